"""The command line, run as ``python -m feasibee``."""

from feasibee.cli import main

main()
