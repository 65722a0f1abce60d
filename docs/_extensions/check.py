"""What Sphinx doesn't check: each built page is followed to its links, anchors and files."""

from __future__ import annotations

import re
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

from sphinx.application import Sphinx
from sphinx.util import logging

import feasibee

ELSEWHERE = re.compile(r"""(url\(|@import)\s*["']?(https?:)?//""")
"""How a style sheet loads a font or another sheet from elsewhere."""

logger = logging.getLogger(__name__)


class _Page(HTMLParser):
    """The anchors of a page, what it links to, and what it loads."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.loads: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value for name, value in attrs if value}
        self.anchors |= {given[name] for name in ("id", "name") if name in given}
        if tag == "a" and "href" in given:
            self.links.append(given["href"])
        elif tag == "link" and given.get("rel") not in ("search", "index", "next", "prev", "canonical"):
            self.loads.append(given.get("href", ""))
        if tag in ("img", "script", "iframe", "video", "source", "audio") and "src" in given:
            self.loads.append(given["src"])


@cache
def _read(path: Path) -> _Page:
    return _Page(path.read_text(encoding="utf-8"))


def check_site(app: Sphinx, error: Exception | None) -> None:
    """Warn of every link to nothing, of what is loaded from elsewhere, and of names without a reference."""
    if error is not None or app.builder.format != "html":
        return
    root = Path(app.outdir)
    _read.cache_clear()
    for name in [*app.env.all_docs, "genindex", "search"]:
        path = Path(app.builder.get_outfilename(name))
        page = _read(path)
        for link in [*page.links, *page.loads]:
            wrong = _problem(path, link, loaded=link in page.loads)
            if wrong:
                logger.warning("%s: %s: %s", path.relative_to(root), link, wrong, type="check")
    for path in root.rglob("*.css"):
        if ELSEWHERE.search(path.read_text(encoding="utf-8")):
            logger.warning("%s: loads something from elsewhere", path.relative_to(root), type="check")
    told = {name for name, *_ in app.env.domains["py"].get_objects()}
    for name in feasibee.__all__:
        if f"feasibee.{name}" not in told:
            logger.warning("feasibee.%s: isn't in the reference", name, type="check")


def _problem(path: Path, link: str, *, loaded: bool) -> str:
    parts = urlsplit(link)
    if parts.scheme in ("data", "mailto"):
        return ""
    if parts.scheme or parts.netloc:
        return "is loaded from elsewhere" if loaded else ""
    target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
    target = target / "index.html" if target.is_dir() else target
    if not target.is_file():
        return "there is no such file"
    if parts.fragment and target.suffix == ".html":
        anchors = _read(target).anchors
        if not {parts.fragment, unquote(parts.fragment)} & anchors:
            return "there is no such anchor"
    return ""


def setup(app: Sphinx) -> dict[str, bool]:
    """Check when all is built."""
    app.connect("build-finished", check_site)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
