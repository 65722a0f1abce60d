"""The complete form of a scenario, with all defaults filled in, and its hash."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any

from feasibee.model.codes import MODEL_VERSION
from feasibee.scenario.tables import default_tables


def complete_form(tables: Mapping[str, Any]) -> dict[str, Any]:
    """Return the complete form of a scenario's tables: all fields that have a value.

    Numbers of robots and tasks that follow from classes are left out: a file can't have both.
    """
    complete = {name: _with_values(table) for name, table in tables.items() if name != "events"}
    for name in ("robots", "tasks"):
        if "classes" in complete[name]:
            del complete[name]["count"]
    events = [_with_values(each) for each in tables["events"]]
    return {**complete, "events": events} if events else complete


def _with_values(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return a table without what has no value: None, an empty list, or a table of such."""
    inner = {
        key: _with_values(value) if isinstance(value, Mapping) else value for key, value in table.items()
    }
    return {key: value for key, value in inner.items() if value not in (None, {}, (), [])}


def hash_of(tables: Mapping[str, Any], source: str = "") -> str:
    """Return the hash of a complete form: that of what differs from the defaults, and of the model's version.

    So a new field whose default changes nothing keeps all hashes.

    Parameters
    ----------
    tables : mapping
        The complete form as nested dicts.
    source : str
        Text of the strategy's file, if it is a user's.
    """
    sparse = {name: _sparse(name, table) for name, table in tables.items() if name != "units"}  # no run's
    if source:
        sparse["decision"]["strategy"] = source
    kept = {name: table for name, table in sparse.items() if table}
    text = json.dumps([MODEL_VERSION, kept], sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def _sparse(name: str, table: Any) -> Any:
    """Return what differs from the defaults of a section; events have none."""
    if name not in default_tables():
        return table
    defaults = default_tables()[name]
    return {key: value for key, value in table.items() if value != defaults[key]}
