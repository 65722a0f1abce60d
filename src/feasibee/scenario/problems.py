"""Translate pydantic's errors about a scenario into problems: path, value, rule and remedy."""

from __future__ import annotations

import difflib
import json
from typing import Final

from pydantic_core import ErrorDetails

from feasibee.errors import Problem
from feasibee.scenario.event import Event
from feasibee.scenario.fields import SECTIONS, fields

WORDS: Final = {
    "Input should be": "must be",
    "greater than or equal to": "≥",
    "less than or equal to": "≤",
    "greater than": ">",
    "less than": "<",
    "a valid integer": "a whole number",
    "a valid boolean": "true or false",
    "a valid tuple": "a list",
    "a valid ": "a ",
    "Dictionary should have at least 1 item after validation": "must name a skill",
    "Tuple should have at most": "must be at most",
    "items after validation": "classes",
}
"""Phrases of pydantic's messages, and their replacements."""
REMEDIES: Final = {"faulty": "use {count = 1} for one robot"}
"""What to do about the errors of some types of fields, by the type of the error."""
REMOVED: Final = {
    "sensing.memory": 'leave it out: with observation "unique", each exploration counts anew',
    "response.release": "leave it out: robots are released if the strategy defines gap",
}
"""Fields of earlier versions, and what to do."""
EVENT: Final = "{ step = 500, tasks = 15 }"
"""An event, for remedies."""


def problem_of(details: ErrorDetails) -> Problem:
    """Translate one of pydantic's errors."""
    path = ".".join(str(part) for part in details["loc"])
    kind = details["type"]
    if kind == "extra_forbidden":
        return Problem(path, details["input"], "unknown key", suggestion(path))
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        return Problem(path, details["input"], "must be a table", _table(path))
    if kind == "missing":
        return Problem(path, details["input"], "is missing", f"add {path.rpartition('.')[2]} to this table")
    rule = details["msg"]
    for theirs, ours in WORDS.items():
        rule = rule.replace(theirs, ours)
    return Problem(path, details["input"], rule, REMEDIES.get(kind) or _remedy(path))


def _table(path: str) -> str:
    return f"such as {EVENT}" if path.startswith("events") else f"write [{path}] and its fields below"


def _remedy(path: str) -> str:
    """Return a remedy with the field's default, if it has one that doesn't depend on other fields."""
    section, _, key = path.partition(".")
    if section == "events":
        return f"such as {EVENT}"
    field = SECTIONS[section].model_fields.get(key) if section in SECTIONS else None
    if field is None or field.default is None:
        return "leave it out for the default"
    return f"the paper uses {json.dumps(field.default)}"


def suggestion(path: str) -> str:
    """Return a remedy that names the most similar field or, if none is similar, those of the section."""
    known = fields()
    if path in REMOVED:
        return REMOVED[path]
    if path.startswith("events."):
        return f"the fields of an event are {', '.join(Event.model_fields)}, such as {EVENT}"
    names = known if "." in path else ["preset", *SECTIONS, "events"]
    close = difflib.get_close_matches(path, names, 1, 0.6)
    section = path.split(".", maxsplit=1)[0]
    siblings = [name.split(".")[1] for name in known if name.startswith(f"{section}.")]
    if close:
        return f"did you mean {close[0]}?"
    if "." in path and siblings:
        return f"the fields of [{section}] are {', '.join(siblings)}"
    return f"the sections are {', '.join(SECTIONS)}, and events"
