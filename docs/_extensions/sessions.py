"""Run the commands and the Python of some pages: compare the outputs, and keep the pictures that they show.

Three kinds of code blocks count on such a page.

- ``console``: each line that begins with ``$ `` is a feasibee command; its output stands below it.
- ``python``: run in order, in one namespace; a ``text`` block right below it has what it prints.
- A block of any language whose first line is ``# NAME.SUFFIX`` is a file that the reader writes.

All run in the folder ``docs/made/PAGE/``, from which the page takes its pictures. The build warns of an
output that differs. ``python docs/_extensions/sessions.py [PAGE ...]`` writes the outputs into the pages.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parent.parent
PAGES = ("index", "first-hour", "from-question-to-decision", "results", "cli")
BLOCK = re.compile(r"^```(?P<language>\w+)\n(?P<code>.*?)^```$", re.MULTILINE | re.DOTALL)
FILE = re.compile(r"# ([\w-]+\.[a-z]+)\n")
DURATION = re.compile(r"\b\d+(\.\d+)? s\b")
"""Differs from run to run, so it is not compared."""


def played(text: str, folder: Path) -> str:
    """Run the blocks of a page in a folder, and return the page with their outputs."""
    names: dict[str, Any] = {"__name__": "__main__"}
    done, end, printed = [], 0, None
    for found in BLOCK.finditer(text):
        between, language, code = text[end : found.start()], found["language"], found["code"]
        if language == "text" and printed is not None and not between.strip():
            code = _unless_alike(code, printed)
        printed = None
        file = FILE.match(code)
        if file:
            (folder / file[1]).write_text(code, encoding="utf-8")
        elif language == "console":
            code = _unless_alike(code, "".join(_answered(line, folder) for line in _commands(code)))
        elif language == "python":
            printed = _executed(code, names, folder)
        done.append(f"{between}```{language}\n{code}```")
        end = found.end()
    return "".join(done) + text[end:]


def _commands(code: str) -> list[str]:
    return [line for line in code.splitlines() if line.startswith("$ ")]


def _answered(line: str, folder: Path) -> str:
    """Return a line of a console and what its command prints."""
    command, _, target = line.removeprefix("$ ").partition(" > ")
    program, *arguments = shlex.split(command)
    if program != "feasibee":
        raise ValueError(f"{line}: a console runs feasibee only")
    finished = subprocess.run(
        [sys.executable, "-m", "feasibee", *arguments],
        cwd=folder,
        env={**os.environ, "COLUMNS": "84", "NO_COLOR": "1", "PYTHONUTF8": "1"},
        capture_output=True,
        encoding="utf-8",
        check=False,
    )
    output = finished.stdout + finished.stderr * (finished.returncode != 0)
    if target:
        (folder / target).write_text(output, encoding="utf-8")
        output = ""
    return "\n".join([line, *(each.rstrip() for each in output.splitlines())]).rstrip() + "\n"


def _executed(code: str, names: dict[str, Any], folder: Path) -> str:
    """Run Python as the reader would in that folder, and return what it prints."""
    with contextlib.chdir(folder), contextlib.redirect_stdout(io.StringIO()) as output:
        exec(code, names)
    return "".join(f"{line.rstrip()}\n" for line in output.getvalue().splitlines())


def _unless_alike(stated: str, printed: str) -> str:
    same = DURATION.sub("", stated) == DURATION.sub("", printed)
    return stated if same else printed


def play(page: str, docs: Path) -> tuple[str, str]:
    """Run the session of a page in an empty folder; return its text before and after."""
    folder = docs / "made" / page
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    text = (docs / f"{page}.md").read_text(encoding="utf-8")
    return text, played(text, folder)


def check_sessions(app: Any) -> None:
    """Warn of each page that prints something else than it says."""
    from sphinx.util import logging

    for page in PAGES:
        stated, right = play(page, Path(app.srcdir))
        if stated != right:
            logging.getLogger(__name__).warning(
                "%s.md: its commands print something else; run python docs/_extensions/sessions.py", page
            )


def setup(app: Any) -> dict[str, bool]:
    """Run the sessions before any page is read."""
    app.connect("builder-inited", check_sessions)
    return {"parallel_read_safe": True}


if __name__ == "__main__":
    for name in sys.argv[1:] or PAGES:
        (DOCS / f"{name}.md").write_text(play(name, DOCS)[1], encoding="utf-8")
