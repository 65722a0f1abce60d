"""Answer what a referee would ask of the findings: docs/referee.md. Each question is a subcommand.

Margins and samples were committed before the first number was computed; docs/referee.md lists what changed.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable
from functools import cache
from itertools import combinations, product
from statistics import NormalDist
from typing import Any

import numpy as np
from scipy.special import bdtr  # type: ignore[import-untyped]

from claims.measure.equivalence import RATE, difference, mean_difference, overall, tested
from feasibee import Scenario, simulate
from feasibee.errors import ScenarioError
from feasibee.results.measures import decided_right, ended_right
from feasibee.results.statistics import wilson
from feasibee.studies.paper import RatioSummary, check_claims, run_study

SEED = 31
"""No page used this seed before."""
SYMMETRY = RATE
"""Margin of the symmetry, 0.05: that of ARGoS, half of what docs/paper.md reads as symmetrical."""
OPEN = {
    "walk.mean_run": (10, 40),
    "decision.exploration": (10, 50),
    "decision.gain": (10, 50),
    "decision.own_vote": (True, False),
    "decision.inbox": ("latest-per-robot", "every-message"),
    "decision.ties": ("keep", "random-message"),
    "decision.quality_floor": (0, 1),
}
"""Choices that the paper's text leaves open: our default, and another value."""
AGAINST = {"decision.listen": ("always", "dissemination"), "sensing.count_self": (False, True)}
"""Choices of docs/paper.md's table of effects that the paper's text answers as our defaults do."""
ALL = OPEN | AGAINST
DESIGN_RUNS, DESIGN_STEPS = 200, 5000
"""5,000 steps, so that long phases end. The interval of a share is at most 0.14 wide. 400 runs were planned;
the machine was too busy, and the number was halved before any result."""
BAR = 0.75
NAMED = ("census", "sketch", "quiet-census", "turns", "roster", "roster-turns")
"""Strategies with names; map has places instead."""
PARTS: dict[str, dict[str, Any]] = {
    "modulation": {"decision.strategy": "majority"},
    "own vote": {"decision.own_vote": False},
    "latest message only": {"decision.inbox": "every-message"},
    "hearing while exploring": {"decision.listen": "dissemination"},
    "coin": {"decision.start": "first-sight"},
    "not counting itself": {"sensing.count_self": True},
}
"""Parts of the paper's rule, and the change that takes each away."""
SIZES = (5, 10, 20, 50)
HALVES: dict[str, dict[str, Any]] = {
    "whole": {},
    "n not known": {"robots.know_count": False},
    "half of the sightings missed": {"sensing.miss": 0.5},
    "half of the messages lost": {"radio.loss": 0.5},
    "half of the view": {"sensing.view": 180.0},
    "half of the steps": {"run.steps": 500},
}
"""Ways to halve what robots know."""
KNOWING = ("dmmd", "average", "tally", "census", "quiet-census", "turns", "totals")


def main() -> None:
    """Print the answer to a question as JSON."""
    print(json.dumps(QUESTIONS[sys.argv[1]](), indent=2))


def ended(changes: dict[str, Any], runs: int, seed: int = SEED) -> tuple[int, Any]:
    """Return in how many runs the swarm is right at the end, and all outcomes."""
    scenario = Scenario().replace(changes)
    found = simulate(scenario, runs=runs, seed=seed)
    return int(ended_right(found, scenario).sum()), found


def decided(changes: dict[str, Any], runs: int) -> int:
    """Return in how many runs the first decision is right."""
    scenario = Scenario().replace(changes | {"run.stop_at_decision": True})
    return int(decided_right(simulate(scenario, runs=runs, seed=SEED), scenario).sum())


def design() -> dict[str, Any]:
    """Return how often all combinations of the choices are right at ratio 2, and what each explains."""
    tasks = {"tasks.count": 10}
    shares = np.array([chosen(levels, tasks) for levels in product((0, 1), repeat=len(ALL))])
    cube = shares.reshape((2,) * len(ALL))
    inner = cube[..., 0, 0]
    return {
        "all": spread(cube),
        "open": spread(inner),
        "effects": effects(cube, list(ALL)),
        "effects_open": effects(inner, list(OPEN)),
    }


def chosen(levels: tuple[int, ...], changes: dict[str, Any]) -> float:
    """Return the share of right decisions with a level of each choice."""
    values = {name: either[level] for (name, either), level in zip(ALL.items(), levels, strict=False)}
    return decided({"run.steps": DESIGN_STEPS, **changes, **values}, DESIGN_RUNS) / DESIGN_RUNS


def spread(cube: np.ndarray) -> dict[str, Any]:
    """Return the distribution of the shares over designs, and where that of the defaults stands in it."""
    ours = float(cube.flat[0])
    quartiles = [float(each) for each in np.quantile(cube, (0, 0.25, 0.5, 0.75, 1))]
    return {
        "designs": cube.size,
        "ours": wilson(round(ours * DESIGN_RUNS), DESIGN_RUNS)._asdict(),
        "quartiles": quartiles,
        "below_ours": float((cube < ours).mean()),
        "above_bar": float((cube > BAR).mean()),
    }


def effects(cube: np.ndarray, names: list[str]) -> list[dict[str, Any]]:
    """Return first-order and total shares of the variance by choice, without the binomial noise.

    The designs are a full factorial, so the variance divides exactly: a contrast per set of choices. The
    noise of a design adds the same amount to each of the 2^k - 1 squared contrasts.
    """
    noise = float((cube * (1 - cube)).mean()) / (DESIGN_RUNS - 1) / cube.size
    contrasts = cube
    for axis in range(cube.ndim):
        one, other = np.take(contrasts, 0, axis), np.take(contrasts, 1, axis)
        contrasts = np.stack(((one + other) / 2, (other - one) / 2), axis)
    squares = contrasts**2 - noise
    whole = float(squares.sum() - squares.flat[0])
    found = []
    for axis, name in enumerate(names):
        alone = tuple(int(at == axis) for at in range(cube.ndim))
        first, total = float(squares[alone]), float(np.take(squares, 1, axis).sum())
        change = {"change": 2 * float(contrasts[alone])}
        found.append({"choice": name, **change, "first": first / whole, "total": total / whole})
    return found


def claims() -> dict[str, Any]:
    """Return for how many designs of the open choices the paper's claims on Fig. 3 hold."""
    tasks = (8, 20, 50)
    found = {
        m: np.array(
            [chosen((*levels, 0, 0), {"tasks.count": m}) for levels in product((0, 1), repeat=len(OPEN))]
        )
        for m in tasks
    }
    feasible, near, infeasible = (found[m] for m in tasks)
    error = np.minimum(feasible, infeasible)
    return {
        "designs": error.size,
        "feasible": int((feasible > BAR).sum()),
        "infeasible": int((infeasible > BAR).sum()),
        "both": int((error > BAR).sum()),
        "worst_at_one": int((near < error).sum()),
        "divided": int((np.minimum(near, 1 - near) > 0.25).sum()),
        "lean": [float(each) for each in np.quantile(feasible - infeasible, (0, 0.5, 1))],
    }


@cache
def study(runs: int, seed: int) -> list[RatioSummary]:
    """Return the paper's ratios, simulated."""
    return run_study(runs, seed)


def multiplicity() -> dict[str, Any]:
    """Return p-values of the six verdicts of docs/paper.md, and Holm's, with 2,000 and 100 runs.

    In addition, the p-value of the last verdict by the method that was used first: a normal error.
    """
    band = check_claims(study(2000, 1), 1)[-1]
    error = (band.high - band.low) / 2 / NormalDist().inv_cdf(0.975)
    found = {f"runs{runs}": holm(p_values(study(runs, 1))) for runs in (2000, 100)}
    return {**found, "normal_error": NormalDist(0, error).cdf(band.estimate)}


def p_values(points: list[RatioSummary]) -> list[tuple[str, float]]:
    """Return the p-value of each claim: one-sided; the largest, where all parts must hold."""
    checked = check_claims(points, 1)
    normal = NormalDist()

    def below(rates: list[tuple[int, int]], bar: float) -> float:
        return max(1 - float(bdtr(right - 1, runs, bar)) for right, runs in rates)

    far = [[p for p in points if p.ratio > 2], [p for p in points if p.ratio < 0.5]]
    right = [
        [(int((p.decision == side).sum()), p.runs) for p in part]
        for side, part in zip((1, 0), far, strict=True)
    ]
    one = next(p for p in points if p.tasks == p.robots)
    sides = [(int((one.decision == side).sum()), one.runs) for side in (0, 1)]
    errors = [(each.high - each.low) / 2 / normal.inv_cdf(0.975) for each in checked]
    lean = checked[2]
    outside = max(1 - normal.cdf((0.1 - abs(lean.estimate)) / errors[2]), 0.0)
    rank = checked[4]
    falls = normal.cdf(
        math.atanh(rank.estimate)
        / ((math.atanh(rank.high) - math.atanh(rank.low)) / 2 / normal.inv_cdf(0.975))
    )
    narrower = wider_band(points)
    found = [below(right[0], BAR), below(right[1], BAR), outside, below(sides, 0.25), falls, narrower]
    return [(each.claim, p) for each, p in zip(checked, found, strict=True)]


def wider_band(points: list[RatioSummary]) -> float:
    """Return in which share of resamples the quartile band at ratio 10 is not narrower than at ratio 2.

    A first version used a normal error, as for the other claims. But the band's distribution at ratio 2 is
    skewed: about a quarter of the swarms is wrong there, so the lower quartile is at 0 or 100 % by chance.
    """
    random, resamples = np.random.default_rng(SEED), 1000
    large, small = (next(p.thinned for p in points if p.tasks == tasks) for tasks in (2, 10))

    def band(runs: np.ndarray) -> float:
        low, high = np.quantile(runs[random.integers(len(runs), size=len(runs))], (0.25, 0.75), axis=0)
        return float((high - low).mean())

    wider = sum(band(large) >= band(small) for _ in range(resamples))
    return (1 + wider) / (1 + resamples)


def holm(found: list[tuple[str, float]]) -> dict[str, Any]:
    """Return p-values with Holm's correction (1979), and how many hold at 2.5 %."""
    ordered, last, corrected = sorted(range(len(found)), key=lambda at: found[at][1]), 0.0, {}
    for rank, at in enumerate(ordered):
        last = corrected[at] = min(1.0, max(last, (len(found) - rank) * found[at][1]))
    rows = [{"claim": name, "p": p, "holm": corrected[at]} for at, (name, p) in enumerate(found)]
    return {
        "rows": rows,
        "hold": sum(each < 0.025 for each in corrected.values()),
        "largest": max(corrected.values()),
    }


def symmetry() -> dict[str, Any]:
    """Return whether decisions at mirrored ratios are equivalent, with a seed that no page used before."""
    points = study(2000, SEED)
    pairs = list(zip(points, points[::-1], strict=True))[: len(points) // 2]
    found = [
        difference((int((few.decision == 1).sum()), few.runs), (int((many.decision == 0).sum()), many.runs))
        for few, many in pairs
    ]
    tests = [tested(each, SYMMETRY) for each in found]
    rows = [
        {"tasks": few.tasks, "mirrored": many.tasks, **test}
        for (few, many), test in zip(pairs, tests, strict=True)
    ]
    mean = tested(mean_difference(found), SYMMETRY)
    verdicts = [test["verdict"] for test in tests]
    counts = {name: verdicts.count(name) for name in ("equivalent", "different", "not shown")}
    least = min(rows, key=lambda row: row["estimate"])
    return {"rows": rows, "mean": mean, "counts": counts, "overall": overall(verdicts), "least": least}


def wrong_names() -> list[dict[str, Any]]:
    """Return how often strategies with names are right at the end if robots name tasks wrongly."""
    return [
        {
            "strategy": strategy,
            "tasks": tasks,
            "rate": f"{rate:.4f}".rstrip("0").rstrip("."),
            **wilson(
                ended({**named(strategy), "tasks.count": tasks, "sensing.misname": rate}, 400)[0], 400
            )._asdict(),
        }
        for strategy in NAMED
        for tasks in (20, 18, 21)
        for rate in (0.0, 1e-4, 1e-3, 1e-2)
    ]


def named(strategy: str) -> dict[str, Any]:
    """Return a strategy whose robots know n."""
    return {"decision.strategy": strategy, "robots.know_count": True}


def ablations() -> dict[str, Any]:
    """Return how often swarms are right at ratio 2 without one or two parts of the paper's rule.

    The difference of a pair from the sum of its two effects is taken on the scale of log odds.
    """
    runs, base = 2000, {"tasks.count": 10}
    counts: dict[tuple[str, ...], int] = {(): decided(base, runs)}
    for size in (1, 2):
        for names in combinations(PARTS, size):
            counts[names] = decided(
                {**base, **{k: v for name in names for k, v in PARTS[name].items()}}, runs
            )
    rows = [
        {"without": " and ".join(names), **wilson(right, runs)._asdict()} for names, right in counts.items()
    ]
    pairs = [interaction(names, counts, runs) for names in counts if len(names) == 2]
    clear = [each for each in pairs if each["low"] > 0 or each["high"] < 0]
    return {"rows": rows, "pairs": pairs, "clear": len(clear)}


def interaction(names: tuple[str, ...], counts: dict[Any, int], runs: int) -> dict[str, Any]:
    """Return by how much two effects together differ from their sum, in log odds, with a 95 % interval.

    The interval is Bonferroni's for the 15 pairs.
    """
    parts = [counts[names], counts[()], counts[names[:1]], counts[names[1:]]]
    log_odds = [math.log((right + 0.5) / (runs - right + 0.5)) for right in parts]
    variance = sum(1 / (right + 0.5) + 1 / (runs - right + 0.5) for right in parts)
    estimate = log_odds[0] + log_odds[1] - log_odds[2] - log_odds[3]
    half = NormalDist().inv_cdf(1 - 0.025 / math.comb(len(PARTS), 2)) * math.sqrt(variance)
    pair = {"one": names[0], "other": names[1], "measured": counts[names] / runs}
    added = log_odds[2] + log_odds[3] - log_odds[1]
    return {
        **pair,
        "added": 1 / (1 + math.exp(-added)),
        "estimate": estimate,
        "low": estimate - half,
        "high": estimate + half,
    }


def sizes() -> list[dict[str, Any]]:
    """Return the headlines of docs/findings.md for other numbers of robots, in the same area per robot."""
    return [headlines(n, 200) for n in SIZES]


def headlines(n: int, runs: int) -> dict[str, Any]:
    """Return each headline's share for n robots."""
    base = {"robots.count": n, "arena.side": round(20 * math.sqrt(n / 20), 1)}
    quiet = {"decision.strategy": "quiet-census", "robots.know_count": True}
    many, equal, twice = ({"tasks.count": m} for m in (n + 1, n, n // 2))
    lies = {"faults.byzantine": {"count": 1}, "faults.byzantine_says": "colluding"}
    liar = {**quiet, **equal, **lies, "decision.parameters": {"tolerates": 1.0}}

    def right(*changes: dict[str, Any]) -> dict[str, float]:
        return wilson(
            ended({k: v for each in (base, *changes) for k, v in each.items()}, runs)[0], runs
        )._asdict()

    def wrongly(*changes: dict[str, Any]) -> dict[str, float]:
        found = ended({k: v for each in (base, *changes) for k, v in each.items()}, runs)[1]
        return wilson(int((found.declared_feasible.values > 0).sum()), runs)._asdict()

    acting = {**quiet, **many, "run.steps": 400}
    census = {"decision.strategy": "census"}
    return {
        "robots": n,
        "coin": right(twice),
        "first_sight": right(twice, {"decision.start": "first-sight"}),
        "dmmd": right(equal),
        "census": right(equal, census),
        "still": wrongly(acting),
        "acting": wrongly(acting, {"acting.start": 0}),
        "liar_census": right(equal, census, lies),
        "liar_tolerates": right(liar),
        "liars_tolerates": right(liar, {"faults.byzantine": {"count": 2}}),
    }


def knowledge() -> list[dict[str, Any]]:
    """Return how often strategies are right with less knowledge, with 19 and 22 tasks.

    With 16 and 25, as planned first, all but two were right in all runs, whatever they knew.
    """
    return [
        {"strategy": strategy, "less": name, **halved(strategy, changes)}
        for strategy in KNOWING
        for name, changes in HALVES.items()
    ]


def halved(strategy: str, changes: dict[str, Any]) -> dict[str, Any]:
    """Return the share of right swarms over 19 and 22 tasks, or what the strategy can't do without."""
    runs, right = 400, 0
    for tasks in (19, 22):
        try:
            right += ended({**named(strategy), "tasks.count": tasks, **changes}, runs)[0]
        except ScenarioError as error:
            return {"rejected": str(error).splitlines()[0]}
    return wilson(right, 2 * runs)._asdict()


QUESTIONS: dict[str, Callable[[], Any]] = {
    "design": design,
    "claims": claims,
    "multiplicity": multiplicity,
    "symmetry": symmetry,
    "names": wrong_names,
    "ablations": ablations,
    "sizes": sizes,
    "knowledge": knowledge,
}

if __name__ == "__main__":
    main()
