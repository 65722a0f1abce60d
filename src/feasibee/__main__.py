"""The command line as a program: ``feasibee``, or ``python -m feasibee``."""

from feasibee.cli import interrupts


def main() -> None:
    """Handle Ctrl-C, then import the commands and run one."""
    interrupts.begin()
    from feasibee.cli.commands import main as commands

    commands()


if __name__ == "__main__":
    main()
