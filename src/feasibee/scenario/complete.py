"""The complete form of a scenario, with all defaults filled in, and its hash."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any


def complete_form(tables: Mapping[str, Any]) -> dict[str, Any]:
    """Return the complete form of a scenario's tables: without what has no value, or follows from the rest.

    Tables that change nothing are left out, so that scenarios without them keep their hashes.
    """
    complete = {name: _with_values(table) for name, table in tables.items() if name != "events"}
    for name in ("robots", "tasks"):
        table = complete[name]
        del table["count" if table["classes"] else "classes"]
        if not table["points"]:
            del table["points"]
    if tables["robots"]["contact"] == "stand":
        del complete["robots"]["contact"]
    if not complete["units"]:
        del complete["units"]
    if tables["response"]["patience"] is None:  # nobody responds
        del complete["response"]
    events = [_with_values(each) for each in tables["events"]]
    return {**complete, "events": events} if events else complete


def _with_values(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return a table without what has no value: None, or a table of such."""
    inner = {
        key: _with_values(value) if isinstance(value, Mapping) else value for key, value in table.items()
    }
    return {key: value for key, value in inner.items() if value not in (None, {})}


def hash_of(tables: Mapping[str, Any], source: str = "") -> str:
    """Return the hash of a complete form as nested dicts; ``source`` is the text of its strategy's file."""
    tables = {name: table for name, table in tables.items() if name != "units"}  # they change no run
    if source:
        tables = {**tables, "decision": {**tables["decision"], "strategy": source}}
    text = json.dumps(tables, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()
