"""Check the links, anchors and files of all built pages, in addition to what Sphinx checks."""

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
"""Pattern of a style sheet that loads a font or another sheet from another site."""

logger = logging.getLogger(__name__)


class _Page(HTMLParser):
    """The anchors of a page, the links on it, and the files that it loads."""

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
    """Warn of dead links, of files loaded from another site, and of public names without a reference."""
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
            logger.warning("%s: loads a file from another site", path.relative_to(root), type="check")
    documented = {name for name, *_ in app.env.domains["py"].get_objects()}
    for name in feasibee.__all__:
        if f"feasibee.{name}" not in documented:
            logger.warning("feasibee.%s: missing in the reference", name, type="check")


def _problem(path: Path, link: str, *, loaded: bool) -> str:
    parts = urlsplit(link)
    if parts.scheme in ("data", "mailto"):
        return ""
    if parts.scheme or parts.netloc:
        return "is loaded from another site" if loaded else ""
    target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
    target = target / "index.html" if target.is_dir() else target
    if not target.is_file():
        return "file not found"
    if parts.fragment and target.suffix == ".html":
        anchors = _read(target).anchors
        if not {parts.fragment, unquote(parts.fragment)} & anchors:
            return "anchor not found"
    return ""


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the check for the end of the build."""
    app.connect("build-finished", check_site)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
