"""Resolve names and empty docstrings that autodoc doesn't handle."""

from __future__ import annotations

from typing import Any

from sphinx.application import Sphinx

import feasibee


def resolve_public(app: Sphinx, env: Any, node: Any, shown: Any) -> Any:
    """Resolve a public name in a docstring of another module."""
    name = node.get("reftarget")
    if node.get("refdomain") != "py" or name not in feasibee.__all__:
        return None
    domain = env.domains["py"]
    return domain.resolve_xref(env, node["refdoc"], app.builder, "obj", f"feasibee.{name}", node, shown)


def drop_alias(app: Sphinx, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    """Remove Python's default docstring of a field of a named tuple."""
    if any(line.startswith("Alias for field number") for line in lines):
        lines.clear()


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect the functions to Sphinx's events."""
    app.connect("missing-reference", resolve_public)
    app.connect("autodoc-process-docstring", drop_alias)
    return {"parallel_read_safe": True}
