"""The board of the built-in strategies: docs/benchmark.md."""

from __future__ import annotations

import json

from feasibee.studies.benchmark import board, standings


def main() -> None:
    """Print its rows as JSON."""
    card = board()
    rows = [
        {
            "given": given,
            "place": place,
            "name": each.contender,
            "right": each.right._asdict(),
            "word": "-" if each.word is None else f"{each.word:.2f}",
            "wrong": "-" if each.wrong is None else f"{each.wrong:.2f}",
            "steps": " / ".join("never" if step is None else f"{step}" for step in (each.median, each.p95)),
            "bits": f"{each.bits:,.3g}",
            "memory": f"{each.memory:,}",
            "brier": each.brier,
        }
        for given, group in standings(card).items()
        for place, each in enumerate(group, start=1)
    ]
    print(json.dumps({"rows": rows}))


if __name__ == "__main__":
    main()
