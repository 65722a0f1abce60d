"""Run the commands of a page, each in an empty folder, and keep their outputs until a source changes."""

from __future__ import annotations

import ast
import hashlib
import json
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from functools import cache
from pathlib import Path
from typing import Any

from claims.book import ROOT, Page
from claims.values import Record, Table, parse_csv, parse_json
from feasibee.base.files import write_text

KEPT = ROOT / ".claims"
CURVE = "calibration.csv"
"""The points of a comparison's figure; no claim is about them."""


def outcome(page: Page, name: str) -> Any:
    """Return the output of a command: its JSON, or the data that it wrote; kept until the code changes."""
    command, files = page.commands[name], files_of(page)
    kept = KEPT / f"{_key(command, files)}.json"
    if not kept.exists():
        _tell(f"{page.name}: {command}")
        start = time.monotonic()
        written = _run(command, files)
        _tell(f"  {time.monotonic() - start:.1f} s\n")
        KEPT.mkdir(exist_ok=True)
        write_text(kept, json.dumps(written))
    return _parsed(json.loads(kept.read_text(encoding="utf-8")))


def files_of(page: Page) -> dict[str, str]:
    """Return the files that a reader of the page writes: the blocks of code with the given first lines."""
    text = page.path.read_text(encoding="utf-8") if page.files else ""
    return {name: _block(text, line) for name, line in page.files.items()}


def _block(text: str, first: str) -> str:
    """Return the block of code with a given first line."""
    lines = text.splitlines()
    start = next(at for at, line in enumerate(lines) if line.strip() == first and "```" in lines[at - 1])
    indent = len(lines[start]) - len(lines[start].lstrip())
    end = next(at for at in range(start, len(lines)) if lines[at].strip() == "```")
    return "".join(line[indent:] + "\n" for line in lines[start:end])


def _run(command: str, files: dict[str, str]) -> dict[str, Any]:
    """Run a command and return what it printed, and the CSV and JSON files that it wrote."""
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(ROOT / "examples", Path(folder, "examples"))
        for name, text in files.items():
            Path(folder, name).write_text(text, encoding="utf-8")
        before = set(Path(folder).rglob("*.*"))
        environment = {
            **os.environ,
            "PYTHONPATH": os.pathsep.join([str(ROOT / "src"), str(ROOT), os.environ.get("PYTHONPATH", "")]),
        }
        done = subprocess.run(
            _arguments(command), cwd=folder, env=environment, capture_output=True, text=True, check=False
        )
        if done.returncode != 0:
            raise SystemExit(f"{command}\nended with status {done.returncode}:\n{done.stderr}")
        made = sorted(set(Path(folder).rglob("*.*")) - before)
        data = [path for path in made if path.suffix in (".csv", ".json") and path.parent.name != "runs"]
        written = {path.name: path.read_text(encoding="utf-8") for path in data}
    return {"printed": done.stdout, "files": written}


def _arguments(command: str) -> list[str]:
    """Return what runs ``feasibee ...``, or a ``python``, such as that of a folder, and one of our files."""
    program, *rest = shlex.split(command)
    if program == "feasibee":
        data = ["--out", "compare"] if rest[0] == "compare" and not {"--out", "--json"} & {*rest} else []
        return [sys.executable, "-m", "feasibee", *rest, *data]
    return [str(ROOT / program) if "/" in program else sys.executable, str(ROOT / rest[0]), *rest[1:]]


def _parsed(written: dict[str, Any]) -> Any:
    parts = {
        name.partition(".")[0]: parse_csv(text) if name.endswith(".csv") else parse_json(text)
        for name, text in written["files"].items()
        if name != CURVE
    }
    if written["printed"].startswith(("{", "[")):
        return parse_json(written["printed"])
    if not parts:
        raise SystemExit(f"the command wrote neither JSON nor CSV; it printed: {written['printed']}")
    only = next(iter(parts.values()))
    if isinstance(only, Table):
        only.text = written["printed"]
    return only if len(parts) == 1 else Record(parts)


def _key(command: str, files: dict[str, str]) -> str:
    text = json.dumps([command, files, _sources("python" in command.partition(" ")[0])])
    return hashlib.sha256(text.encode()).hexdigest()[:24]


@cache
def _sources(scripts: bool) -> str:
    """Return a hash of all code that could change an outcome, without comments and docstrings."""
    folders = ["src/feasibee", "examples"] + ["claims/measure", "benchmarks", "research"] * scripts
    digest = hashlib.sha256()
    for path in sorted(path for folder in folders for path in (ROOT / folder).rglob("*.*")):
        if path.suffix in (".py", ".toml", ".json", *[".c", ".csv", ".h"] * scripts):
            text = path.read_text(encoding="utf-8")
            digest.update(path.relative_to(ROOT).as_posix().encode() + b"\0")
            digest.update((_without_docstrings(text) if path.suffix == ".py" else text).encode() + b"\0")
    return digest.hexdigest()


def _without_docstrings(text: str) -> str:
    tree = ast.parse(text)
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
            node.body = [each for each in node.body if not _is_text(each)]
    return ast.dump(tree)


def _is_text(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _tell(text: str) -> None:
    print(text, file=sys.stderr, end="", flush=True)
