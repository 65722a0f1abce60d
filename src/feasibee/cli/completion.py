"""Shell completion of a scenario's fields and of strategies."""

from __future__ import annotations

from collections.abc import Sequence

import click
from click.shell_completion import CompletionItem


def complete_field(
    context: click.Context, parameter: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Complete the last field of A,B,..."""
    from feasibee.scenario.fields import fields

    return _offered(incomplete, fields())


def complete_change(
    context: click.Context, parameter: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Complete the field of FIELD=VALUE; commas belong to the value."""
    from feasibee.scenario.fields import fields

    return [CompletionItem(f"{field}=") for field in fields() if field.startswith(incomplete)]


def complete_strategy(
    context: click.Context, parameter: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Complete the last strategy of A,B,..."""
    from feasibee.scenario.plugins import registered
    from feasibee.strategies import STRATEGIES

    return _offered(incomplete, [*STRATEGIES, *registered()])


def _offered(incomplete: str, names: Sequence[str]) -> list[CompletionItem]:
    before, comma, last = incomplete.rpartition(",")
    return [CompletionItem(before + comma + name) for name in names if name.startswith(last)]
