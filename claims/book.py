"""Read a file of claims: the page, its commands, its sentences and tables, its given numbers."""

from __future__ import annotations

import ast
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from claims.template import Template

ROOT = Path(__file__).parent.parent
PAGES = Path(__file__).parent / "pages"
GIVEN = "given.toml"
"""The file of phrases that are given on every page."""


@dataclass(frozen=True)
class Claim:
    """A sentence of a page with its numbers.

    Parameters
    ----------
    template : Template
        The text of the page, with its numbers as slots.
    holds : str
        Expression that must be true for the words to be right; empty: no condition.
    """

    template: Template
    holds: str = ""

    @property
    def expressions(self) -> list[str]:
        """All expressions of the claim."""
        return [slot.expression for slot in self.template.slots] + [self.holds] * bool(self.holds)


@dataclass(frozen=True)
class Rows:
    """A table of a page with its numbers.

    Parameters
    ----------
    header : str
        Beginning of its first line.
    each, of : str
        Names of the variables of a row, and an expression for the list of their values.
    row : Template
        Template of each row.
    """

    header: str
    each: str
    of: str
    row: Template

    @property
    def expressions(self) -> list[str]:
        """All expressions of the claim."""
        return [self.of, *(slot.expression for slot in self.row.slots)]


@dataclass(frozen=True)
class Page:
    """A page with its commands, claims and given numbers."""

    name: str
    path: Path
    quick: dict[str, str]
    slow: dict[str, str]
    files: dict[str, str]
    claims: list[Claim]
    tables: list[Rows]
    given: list[str]
    given_parts: list[str]
    covered: bool

    @property
    def commands(self) -> dict[str, str]:
        """All commands, by their names in expressions."""
        return self.quick | self.slow

    def needs(self, claim: Claim | Rows) -> set[str]:
        """Return the names of the commands whose outcomes a claim uses."""
        trees = [ast.parse(f"({expression})") for expression in claim.expressions]
        names = {node.id for tree in trees for node in ast.walk(tree) if isinstance(node, ast.Name)}
        return names & set(self.commands)


def read(name: str) -> Page:
    """Read the claims of a page."""
    path = PAGES / f"{name}.toml"
    found = tomllib.loads(path.read_text(encoding="utf-8"))
    page = Page(
        name,
        ROOT / found.pop("page"),
        found.pop("quick", {}),
        found.pop("slow", {}),
        found.pop("files", {}),
        [_claim(each) for each in found.pop("claim", [])],
        [
            Rows(each["header"], each["each"], each["of"], Template(each["row"]))
            for each in found.pop("table", [])
        ],
        found.pop("given", []),
        found.pop("given_parts", []),
        found.pop("covered", True),
    )
    if found:
        raise ValueError(f"{path}: unknown {', '.join(found)}")
    return page


def read_all() -> list[Page]:
    """Read the claims of all pages."""
    return [read(path.stem) for path in sorted(PAGES.glob("*.toml")) if path.name != GIVEN]


def common() -> list[str]:
    """Return the phrases that are given on every page."""
    given: list[str] = tomllib.loads((PAGES / GIVEN).read_text(encoding="utf-8"))["given"]
    return given


def _claim(found: dict[str, Any]) -> Claim:
    return Claim(Template(found["text"]), found.get("holds", ""))
