"""``python -m feasibee``."""

from feasibee.cli import main

main()
