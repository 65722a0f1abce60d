"""The strategies: one file each, one row each. A strategy's file imports nothing but ``math``."""

from __future__ import annotations

from types import ModuleType
from typing import Final

from feasibee.strategies import dmmd

STRATEGIES: Final[dict[str, ModuleType]] = {"dmmd": dmmd}
