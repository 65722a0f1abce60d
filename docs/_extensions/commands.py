"""Generate the page of commands from their --help texts."""

from __future__ import annotations

from collections.abc import Iterator

import click
from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from feasibee.cli import main

WIDTH = 84


class CommandHelp(SphinxDirective):
    """All commands, with one section each, in the order of their registration."""

    def run(self) -> list[nodes.Node]:
        """Return the sections."""
        return self.parse_text_to_nodes("\n".join(_lines()), allow_section_headings=True)


def _lines() -> Iterator[str]:
    """Yield the lines of a command's section in Markdown (MyST)."""
    top = click.Context(main, info_name="feasibee", terminal_width=WIDTH, **main.context_settings)
    for name, command in main.commands.items():
        context = click.Context(command, parent=top, info_name=name, terminal_width=WIDTH)
        yield from (f"## feasibee {name}", "", "```text", command.get_help(context), "```", "")


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("command-help", CommandHelp)
    return {"parallel_read_safe": True}
