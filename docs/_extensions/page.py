"""The page that simulates, embedded: written by `feasibee.live.page` before any page is read."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from feasibee import Scenario
from feasibee.live.lesson import write_lesson
from feasibee.live.page import write_page

NAME = "swarm.html"
TITLE = "A swarm simulated in this page"


class Page(SphinxDirective):
    """The page in a frame that grows with it and has the theme of the site."""

    def run(self) -> list[nodes.Node]:
        """Return the frame and its script; the page that holds it is at the top of the site."""
        frame = f'<iframe class="swarm" src="_static/{NAME}" title="{TITLE}"></iframe>'
        script = '<script src="_static/swarm.js" defer></script>'
        return [nodes.raw("", f"{frame}\n{script}", format="html")]


def write(app: Sphinx) -> None:
    """Write the page and the lesson into a folder of static files."""
    folder = Path(app.srcdir) / "made" / "page"
    folder.mkdir(parents=True, exist_ok=True)
    write_page(Scenario(tasks={"count": 50}), folder / NAME, seed=1)
    write_lesson(folder / "lesson.html")
    app.config.html_static_path.append(str(folder))


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive, and the writing of the page."""
    app.connect("builder-inited", write)
    app.add_directive("page", Page)
    return {"parallel_read_safe": True}
