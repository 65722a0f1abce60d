"""Generate the page of commands from their --help texts."""

from __future__ import annotations

from collections.abc import Iterator

import click
from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from feasibee.cli.commands import GROUPS, main

WIDTH = 84


class CommandHelp(SphinxDirective):
    """All commands, with one section each, by their groups."""

    def run(self) -> list[nodes.Node]:
        """Return the sections."""
        return self.parse_text_to_nodes("\n".join(_lines()), allow_section_headings=True)


def _lines() -> Iterator[str]:
    """Yield the lines of a command's section in Markdown (MyST)."""
    top = click.Context(main, info_name="feasibee", terminal_width=WIDTH, **main.context_settings)
    for title, commands in GROUPS.items():
        yield from (f"## {title}", "")
        for command in commands:
            yield from _section(top, command)


def _section(parent: click.Context, command: click.Command) -> Iterator[str]:
    """Yield the section of a command, and those of the commands of a group."""
    context = click.Context(command, parent=parent, info_name=command.name, terminal_width=WIDTH)
    yield from (f"### {context.command_path}", "", "```text", command.get_help(context), "```", "")
    if isinstance(command, click.Group):
        for each in command.commands.values():
            yield from _section(context, each)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("command-help", CommandHelp)
    return {"parallel_read_safe": True}
