"""The page that simulates: markup, style, modules, the compiled engine and a scenario in one HTML file."""

from __future__ import annotations

import json
import re
from importlib.metadata import version
from pathlib import Path
from string import Template
from typing import Any, Final
from urllib.parse import quote

from feasibee.base.files import write_text
from feasibee.live.packet import wasm_of
from feasibee.live.prediction import prediction_of
from feasibee.live.scene import opened_of
from feasibee.scenario.runs import Runs
from feasibee.scenario.scenario import Scenario

MARKUP: Final = Path(__file__).parent
STATIC: Final = MARKUP / "static"
IMPORTED: Final = re.compile(r'(?m)^import \{([^;]+)\} from "\./(\w+)\.js";\n')
EXPORTED: Final = re.compile(r"(?m)^export ((?:async )?(?:const|class|function) ([\w$]+))")


def page_of(scenario: Scenario, seed: int = 0, run: int = 0, name: str = "") -> str:
    """Return the page that begins with a scenario, a seed and a run, as HTML.

    The page changes numbers of robots and tasks, ranges, speed and strategy of the scenario by itself.
    ``name`` says what to call it, such as its file's name. Raise a ScenarioError if a page can't simulate the
    scenario, with all reasons, and a FeasibeeError if seed or run is out of range.
    """
    opened = opened_of(scenario, Runs.single(seed, run))
    return page_with(opened, name, wasm=wasm_of(scenario), prediction=prediction_of(scenario))


def write_page(scenario: Scenario, out: Path, seed: int = 0, run: int = 0, name: str = "") -> None:
    """Write the page of `page_of` to a file; after an error, the previous file is unchanged."""
    write_text(out, page_of(scenario, seed, run, name))


def page_with(opened: dict[str, Any], title: str, **own: Any) -> str:
    """Return the page of an opened scenario; what isn't given is as in a file without server."""
    usual = {"server": False, "wasm": "", **dict.fromkeys(("form", "replays", "field", "prediction"))}
    given = {"name": title, "version": version("feasibee"), "opened": opened}
    return filled("page", "feasibee", "app", usual | given | own)


def filled(name: str, title: str, script: str, given: dict[str, Any]) -> str:
    """Return a page: markup and style of a name, a module and its imports, and what is given to it.

    A placeholder of the markup stands for the element of page.html that has its name as id.
    """
    shell, body = (Template((MARKUP / f"{each}.html").read_text("utf-8")) for each in ("shell", name))
    icon = "data:image/svg+xml," + quote(_text("icon.svg"))
    parts = {each: _part(each) for each in body.get_identifiers() if each != "icon"}
    modules = modules_of(script)
    styles = dict.fromkeys(f"{each}.css" for each in ("base", *modules, name))
    return shell.substitute(
        title=title,
        icon=icon,
        body=body.substitute(parts, icon=icon),
        style="".join(_text(each) for each in styles if (STATIC / each).exists()),
        given=json.dumps(given, separators=(",", ":")).replace("<", "\\u003c"),
        library=_text("uplot.js") if "plot" in modules else "",
        worker=joined("worker"),
        script=joined(script),
    )


def _text(name: str) -> str:
    """Return the text of a file of the page."""
    return (STATIC / name).read_text("utf-8")


def _part(name: str) -> str:
    """Return an element of page.html, by its id: it ends where the indentation is that of its start."""
    text = (MARKUP / "page.html").read_text("utf-8")
    (found,) = re.finditer(rf'(?ms)^( *)<(\w+) id="{name}".*?^\1</\2>', text)
    return found[0]


def modules_of(name: str, seen: tuple[str, ...] = ()) -> tuple[str, ...]:
    """Return the modules that one needs, each after those that it needs itself, and it last."""
    for _, each in IMPORTED.findall(_text(f"{name}.js")):
        if each not in seen:
            seen = modules_of(each, seen)
    return (*seen, name)


def joined(name: str) -> str:
    """Return a module and all that it imports as one text, for what can't import.

    Each module is a function with its own names, as it has as a file; the last one gives nothing away.
    """
    return "\n".join(_scoped(each) if each != name else _bare(each)[0] for each in modules_of(name))


def _bare(name: str) -> tuple[str, list[str]]:
    """Return a module's text with what it imports as constants, and the names that it exports."""
    text = IMPORTED.sub(
        lambda found: f"const {{{found[1].replace(' as ', ': ')}}} = {found[2]}Module;\n", _text(f"{name}.js")
    )
    return EXPORTED.sub(r"\1", text), [each for _, each in EXPORTED.findall(text)]


def _scoped(name: str) -> str:
    text, names = _bare(name)
    return f"const {name}Module = (() => {{\n{text}return {{ {', '.join(names)} }};\n}})();"
