"""List the commands behind each page's numbers, from the files of claims."""

from __future__ import annotations

from collections.abc import Iterator

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from claims.book import ROOT, Page, read_all


class Numbers(SphinxDirective):
    """All commands, with one section per page."""

    def run(self) -> list[nodes.Node]:
        """Return the sections."""
        text = "\n".join(line for page in read_all() if page.commands for line in _lines(page))
        return self.parse_text_to_nodes(text, allow_section_headings=True)


def _lines(page: Page) -> Iterator[str]:
    """Yield the lines of a page's section in Markdown (MyST)."""
    yield from (f"## {page.path.relative_to(ROOT)}", "")
    for name, command in page.commands.items():
        claims = sum(name in page.needs(each) for each in [*page.claims, *page.tables])
        slow = "" if name in page.quick else ", slow"
        places = "one place" if claims == 1 else f"{claims} places"
        yield from (f"`{name}`, used in {places}{slow}:", "", "```sh", command, "```", "")


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("claimed-numbers", Numbers)
    return {"parallel_read_safe": True}
