"""The page of a field: its steps come from the log of its world, while it is written and later."""

from __future__ import annotations

from pathlib import Path
from threading import Lock
from typing import Any
from urllib.parse import parse_qsl

from pydantic import BaseModel, ConfigDict, Field

from feasibee.base.files import named
from feasibee.field.recording import Recording, columns_of, state_of
from feasibee.live.page import page_with
from feasibee.live.scene import scene_of, settings_of
from feasibee.live.serve import Routes


class Since(BaseModel):
    """Request of a page for steps from one on."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    start: int = Field(alias="from", ge=0, lt=2**31)


def routes_of_field(folder: Path) -> Routes:
    """Return the answers to pages of the field that writes its logs in a folder.

    Raise a FeasibeeError if there is no log of a field, or a damaged one.
    """
    field, lock = Recording(folder), Lock()

    def newest() -> Recording:
        nonlocal field
        if not field.grow():
            field = Recording(folder)
        return field

    def page(_: bytes) -> str:
        with lock:
            now = newest()
        scenario, which = now.scenario, now.which
        opened = scene_of(scenario, which, [scenario]) | settings_of(scenario)
        about = {"address": named(folder), "hz": now.hz, "which": now.mark}
        return page_with(opened, f"field in {named(folder)}", server=True, field=about)

    def steps(query: bytes) -> dict[str, Any]:
        since = Since.model_validate(dict(parse_qsl(query.decode(), keep_blank_values=True)))
        with lock:
            now = newest()
            return {"which": now.mark, "steps": columns_of(now, since.start), "state": state_of(now)}

    return {("GET", "/"): page, ("GET", "/field"): steps}
