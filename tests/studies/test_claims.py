"""The paper's claims hold, fail or can't be told, on studies made to measure."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from statistics import NormalDist

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from feasibee import wilson
from feasibee.studies.paper import BASELINE, CANNOT_TELL, FAILS, HOLDS, RatioSummary, check_claims

ROBOTS = 20
TASKS = (2, 4, 8, 10, 20, 40, 50, 100, 200)
"""Ratios 10, 5, 2.5, 2, 1 and their mirror images."""

CLAIMS = ("feasible", "infeasible", "symmetrical", "diverging", "earlier", "narrower")
"""Our names for the claims, in their order."""


def reliable(ratio):
    """Return the share of runs that decide feasible where every claim holds."""
    return 0.5 if ratio == 1 else 0.95 if ratio > 1 else 0.05


def earlier(ratio, runs):
    return 100 - 5 * ratio + np.arange(runs) % 30


def narrower(ratio, runs):
    """Return curves whose quartile band is the narrower the larger the ratio."""
    return np.linspace(50 - 40 / ratio, 50 + 40 / ratio, runs)


def study(shares=reliable, steps=earlier, spread=narrower, undecided=0.0, runs=400, tasks=TASKS):
    points = []
    for number in tasks:
        ratio = ROBOTS / number
        decision = np.full(runs, -1, np.int8)
        left = round(undecided * runs)
        feasible = round(shares(ratio) * (runs - left))
        decision[left:] = [1] * feasible + [0] * (runs - left - feasible)
        curves = np.repeat(np.asarray(spread(ratio, runs), np.float32)[:, None], 5, axis=1)
        points.append(
            RatioSummary(
                panel=BASELINE,
                robots=ROBOTS,
                tasks=number,
                feasible=number <= ROBOTS,
                first_run=number * 1000,
                decision=decision,
                decision_step=np.asarray(steps(ratio, runs), np.int32),
                quartiles=np.quantile(curves, (0.25, 0.5, 0.75), axis=0),
                thinned=curves,
            )
        )
    return points


def check(seed=1, **changes):
    claims = check_claims(study(**changes), seed)
    assert len(claims) == len(CLAIMS)
    return dict(zip(CLAIMS, claims, strict=True))


def with_share(at, share):
    """Return the reliable shares, but for one ratio."""
    return lambda ratio: share if ratio == at else reliable(ratio)


# --- As a whole ---


def test_the_claims_are_the_papers_in_their_order_and_hold_where_they_are_made_to_hold():
    words = ("decide feasible", "decide infeasible", "symmetrical", "diverge", "earlier", "range is smaller")
    for claim, expected in zip(check().values(), words, strict=True):
        assert expected in claim.claim
        assert claim.verdict == HOLDS
        assert "section III" in claim.source
        assert claim.statistic
        assert claim.bar


def test_only_the_claim_whose_interval_is_resampled_says_so():
    assert [name for name, claim in check().items() if "1000 resamples" in claim.statistic] == ["narrower"]


def test_the_order_of_the_points_does_not_matter():
    assert check_claims(study()[::-1], 1) == check_claims(study(), 1)


@given(
    st.lists(st.floats(0, 1), min_size=len(TASKS), max_size=len(TASKS)),
    st.floats(0, 0.9),
    st.integers(4, 60),
    st.integers(0, 2**64 - 1),
)
def test_intervals_hold_their_estimate_and_verdicts_follow_from_them(shares, undecided, runs, seed):
    by_ratio = dict(zip((ROBOTS / number for number in TASKS), shares, strict=True))
    bars = {"feasible": 0.75, "infeasible": 0.75, "diverging": 0.25, "earlier": 0.0, "narrower": 0.0}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("feasibee.studies.paper.RESAMPLES", 20)
        claims = check(seed, shares=by_ratio.get, undecided=undecided, runs=runs)
    json.dumps([asdict(claim) for claim in claims.values()], allow_nan=False)
    for name, claim in claims.items():
        assert claim.low <= claim.high
        if name != "narrower":  # a resampled interval needn't
            assert claim.low <= claim.estimate <= claim.high
        if name == "symmetrical":
            inside, outside = -0.1 < claim.low <= claim.high < 0.1, claim.high < -0.1 or claim.low > 0.1
        elif name in {"feasible", "infeasible", "diverging"}:
            assert "above" in claim.bar
            inside, outside = claim.low > bars[name], claim.high <= bars[name]
        else:
            assert "below" in claim.bar
            inside, outside = claim.high < bars[name], claim.low >= bars[name]
        assert claim.verdict == (HOLDS if inside else FAILS if outside else CANNOT_TELL)


def leaning(above, below):
    """Return shares that are right above and below ratio one."""
    return lambda ratio: above if ratio > 1 else 1 - below


FIVE = (2, 10, 20, 40, 200)
CASES = [
    *[
        (name, {"shares": with_share(ratio, share if ratio > 1 else 1 - share)}, share, verdict)
        for name, ratio in (("feasible", 5.0), ("infeasible", 0.2))
        for share, verdict in ((0.9, HOLDS), (0.76, CANNOT_TELL), (0.74, CANNOT_TELL), (0.6, FAILS))
    ],
    # An undecided run is not a right one.
    *[(name, {"undecided": 0.4}, 0.95 * 0.6, FAILS) for name in ("feasible", "infeasible")],
    *[
        ("symmetrical", {"shares": leaning(above, below), "runs": runs}, above - below, verdict)
        for above, below, runs, verdict in (
            (0.9, 0.7, 400, FAILS),
            (0.7, 0.9, 400, FAILS),
            (0.9, 0.85, 400, HOLDS),
            (0.9, 0.8, 400, CANNOT_TELL),
            (0.9, 0.9, 10, CANNOT_TELL),
        )
    ],
    *[
        ("diverging", {"shares": with_share(1.0, share)}, min(share, 1 - share), verdict)
        for share, verdict in (
            (0.5, HOLDS),
            (0.35, HOLDS),
            (0.65, HOLDS),
            (0.27, CANNOT_TELL),
            (0.05, FAILS),
            (0.95, FAILS),
        )
    ],
    ("earlier", {"steps": lambda ratio, runs: np.arange(runs) % 50}, 0, CANNOT_TELL),
    ("earlier", {"tasks": FIVE, "steps": lambda ratio, runs: np.full(runs, 100 - 5 * ratio)}, -1, HOLDS),
    ("earlier", {"tasks": FIVE, "steps": lambda ratio, runs: np.full(runs, 100 + 5 * ratio)}, 1, FAILS),
]


@pytest.mark.parametrize(("name", "changes", "estimate", "verdict"), CASES)
def test_a_claim_has_its_estimate_its_interval_and_its_verdict(monkeypatch, name, changes, estimate, verdict):
    """Of several ratios the worst decides, and a claim is open if its bar is within the interval."""
    monkeypatch.setattr("feasibee.studies.paper.RESAMPLES", 20)  # none of these claims resamples
    claim = check(**changes)[name]
    assert claim.estimate == pytest.approx(estimate, abs=1e-9)
    assert -1 <= claim.low <= claim.high <= 1
    assert claim.verdict == verdict
    if name == "diverging":
        assert (claim.low, claim.high) == wilson(round(estimate * 400), 400)[1:]


# --- More than 75 % right beyond ratio 2 ---


def test_the_interval_of_several_ratios_shares_the_error_among_them():
    for name, ratio, share in (("feasible", 5.0, 0.8), ("infeasible", 0.2, 0.2)):
        claim = check(shares=with_share(ratio, share))[name]
        assert "3 ratios" in claim.statistic  # 10, 5, 2.5, and their mirror images
        assert f"at {ratio:g})" in claim.statistic
        assert (claim.estimate, claim.low, claim.high) == wilson(320, 400, 1 - 0.05 / 3)


# --- Symmetrical ---


def test_mirrored_data_are_symmetrical():
    shares = {10.0: 0.99, 5.0: 0.9, 2.5: 0.8, 2.0: 0.6, 1.0: 0.3}
    claim = check(shares=lambda ratio: shares.get(ratio, 1 - shares.get(round(1 / ratio, 9), 0)))[
        "symmetrical"
    ]
    assert claim.estimate == pytest.approx(0, abs=1e-12)
    assert -claim.low == pytest.approx(claim.high)
    assert claim.verdict == HOLDS
    assert "4 pairs" in claim.statistic


def test_the_interval_of_the_symmetry_is_that_of_a_mean_of_differences():
    """4 pairs, each a difference of two shares, of variance p (1 - p) / n each."""
    claim = check(shares=lambda ratio: 0.8 if ratio > 1 else 0.3)["symmetrical"]
    half = 1.959964 * math.sqrt(4 * (0.8 * 0.2 + 0.7 * 0.3) / 400) / 4
    assert claim.high - claim.estimate == pytest.approx(half, rel=0.02)
    assert claim.estimate - claim.low == pytest.approx(half, rel=0.02)


# --- Earlier with a larger ratio ---


def test_only_ratios_from_2_up_are_in_the_claim():
    claim = check(
        steps=lambda ratio, runs: earlier(ratio, runs) if ratio >= 2 else 200 + ratio * np.ones(runs)
    )
    assert claim["earlier"] == check()["earlier"]


def test_an_undecided_run_is_later_than_any():
    def steps(ratio, runs):
        return np.where(np.arange(runs) < runs / 2, 900, -1 if ratio < 10 else 900)

    claim = check(steps=steps)["earlier"]
    assert claim.estimate < -0.3
    assert claim.verdict == HOLDS


def test_the_rank_correlation_by_hand():
    """Ratio ranks 1.5 1.5 3.5 3.5, step ranks 2.5 4 1 2.5: r = -3 / sqrt(4 * 4.5)."""
    claim = check(tasks=FIVE, runs=2, steps=lambda ratio, _: [1, 3] if ratio == 10 else [3, 5])["earlier"]
    assert claim.estimate == pytest.approx(-1 / math.sqrt(2))
    half = NormalDist().inv_cdf(0.975) * math.sqrt((1 + 0.5 / 2) / (4 - 3))
    ends = (math.tanh(math.atanh(claim.estimate) + side * half) for side in (-1, 1))
    assert (claim.low, claim.high) == pytest.approx(tuple(ends))


def test_a_swarm_that_never_decides_cannot_tell():
    claim = check(undecided=1.0, steps=lambda ratio, runs: np.full(runs, -1))["earlier"]
    assert claim.verdict == CANNOT_TELL
    assert math.isfinite(claim.estimate)


# --- A narrower band with a larger ratio ---


def test_the_width_of_the_band_is_the_mean_difference_of_the_quartiles():
    """Even spreads of 8 and 40 percentage points: the quartiles lie half of that apart."""
    claim = check()["narrower"]
    assert claim.estimate == pytest.approx(4 - 20, rel=1e-4)
    assert claim.low < -16 < claim.high < 0


def test_the_interval_of_the_width_is_that_of_resampled_runs():
    """The quartile of n uniform values has a standard error of sqrt(3 / 16 n) of the range."""
    runs = 400
    claim = check(runs=runs, spread=lambda ratio, n: np.linspace(0, 100, n))["narrower"]
    # Var(q75 - q25) = (2 * 3/16 - 2 * 1/16) / n, twice for two ratios.
    error = 100 * math.sqrt(2 * (2 * 3 / 16 - 2 / 16) / runs)
    width = 2 * NormalDist().inv_cdf(0.975) * error
    assert claim.high - claim.low == pytest.approx(width, rel=0.15)


def test_resampling_is_a_matter_of_the_seed():
    one, again, other = check(seed=1), check(seed=1), check(seed=2**64 - 1)
    assert one == again
    assert one["narrower"] != other["narrower"]
    assert one["narrower"].low == pytest.approx(other["narrower"].low, rel=0.05)
    assert one["earlier"] == other["earlier"]
