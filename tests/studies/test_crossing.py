"""Searches for the value from which a rate is high enough."""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter

import numpy as np
import pytest
from scipy.special import betaln
from scipy.stats import binom

from feasibee.results.statistics import Interval
from feasibee.simulation.sequential import Finding
from feasibee.studies.size import Edge, Rule, find_edge, finding_at, most_tests

UNKNOWN = Interval(0.5, 0.0, 1.0)


def searched(places, below, enough):
    """Search places of which those before ``below`` are too few, and those from ``enough`` on are enough."""

    def test(place):
        answer = "too few" if place < below else "open" if place < enough else "enough"
        return Finding(place, 0, 1, UNKNOWN, answer)

    return find_edge("", range(places), test)


@pytest.mark.parametrize("places", [*range(1, 34), 100])
def test_both_ends_of_the_answer_are_found_in_few_tests(places):
    step = 1 if places < 34 else 7
    for below in range(0, places + 1, step):
        for enough in range(below, places + 1, step):
            found = searched(places, below, enough)
            assert found.possible == below
            assert found.enough == (enough if enough < places else None)
            assert len(found.tested) <= most_tests(places)


def test_an_easy_first_value_takes_one_test():
    assert len(searched(1000, 0, 0).tested) == 1


def test_a_test_stops_as_soon_as_it_is_sure():
    rule = Rule(0.95, first=100, most=2000)
    assert finding_at(3, lambda trials: 0, rule, 10)[:3] == (3, 0, 20)
    certain = finding_at(0, lambda trials: trials, rule, 1)
    assert certain.answer == "enough"
    assert certain.trials < 300
    far = finding_at(0, lambda trials: round(0.9 * trials), rule, 1)
    assert (far.answer, far.trials) == ("too few", 338)


@pytest.mark.parametrize(("most", "trials"), [(400, 100), (2000, 507)])
def test_a_test_that_seems_hopeless_ends_after_a_quarter_of_its_trials(most, trials):
    close = finding_at(0, lambda trials: round(0.95 * trials), Rule(0.95, first=100, most=most), 1)
    assert (close.answer, close.trials) == ("open", trials)


def is_right(found: Edge, first: int, places: int) -> bool:
    """Whether the first place that reaches the target lies in the interval of an answer."""
    enough = places if found.reached is None else found.reached
    return found.possible <= first <= enough


def test_a_value_is_looked_at_early_and_then_after_half_as_many_trials_more_up_to_the_most():
    assert Rule(0.8, 60, 300).design(9).looks == [20, 45, 60, 90, 135, 203, 300]
    assert Rule(0.8, 20, 10).design(9).looks == [10]


def edges(trials, rule, tests):
    """Return the most successes of so many trials that are too few, and the least that are enough."""

    def answer(successes):
        return rule.design(tests).tested(rule.target, successes, trials).answer

    numbers = range(trials + 1)
    enough = bisect_left(numbers, True, key=lambda each: answer(each) == "enough")
    return bisect_left(numbers, True, key=lambda each: answer(each) != "too few") - 1, enough


@pytest.mark.parametrize("tests", [1, 2, 9, 18, 63])
@pytest.mark.parametrize(("target", "confidence"), [(0.5, 0.9), (0.8, 0.8), (0.95, 0.95)])
def test_each_look_stops_where_the_evidence_is_the_tests_share_of_the_error(target, confidence, tests):
    """The evidence against a rate is a ratio of Beta functions; the bar is that of Bonferroni."""
    for trials in (20, 30, 45, 68, 102, 1000):
        numbers = np.arange(trials + 1)
        evidence = betaln(numbers + 0.5, trials - numbers + 0.5) - betaln(0.5, 0.5)
        evidence -= numbers * np.log(target) + (trials - numbers) * np.log(1 - target)
        refuted = numbers[evidence >= np.log(tests / (1 - confidence))]
        few, enough = refuted[refuted < target * trials], refuted[refuted > target * trials]
        expected = max(few, default=-1), min(enough, default=trials + 1)
        assert edges(trials, Rule(target, confidence=confidence), tests) == expected


def chances(rate, rule, tests):
    """Return the probability of each answer of a test of a value: a sum over all paths of its trials."""
    path, before, found = np.ones(1), 0, Counter()
    looks = []
    finding_at(0, lambda trials: looks.append(trials) or round(rule.target * trials), rule, 10**9)
    for trials in looks:
        few, enough = edges(trials, rule, tests)
        path = np.convolve(path, binom.pmf(np.arange(trials - before + 1), trials - before, rate))
        found.update({"too few": path[: few + 1].sum(), "enough": path[enough:].sum()})
        path[: few + 1] = path[enough:] = 0
        before = trials
    return {**found, "open": path.sum()}


@pytest.mark.parametrize("rates", [[0.8] * 8, [0.7999] * 8, np.linspace(0.77, 0.83, 12)])
def test_an_answer_is_wrong_as_rarely_as_it_says(rates):
    """Exactly, over all answers of all values that a search may test; less probable ones count as wrong."""
    places, first = len(rates), next((at for at, rate in enumerate(rates) if rate >= 0.8), len(rates))
    rule = Rule(0.8, first=60, most=500, confidence=0.8)
    laws = [chances(rate, rule, most_tests(places)) for rate in rates]

    def wrong(known, chance):
        try:
            found = find_edge("", range(places), lambda at: Finding(at, 0, 1, UNKNOWN, known[at]))
        except KeyError as asked:
            (place,) = asked.args
            return sum(
                wrong({**known, place: answer}, chance * share) if chance * share > 1e-7 else chance * share
                for answer, share in laws[place].items()
            )
        return 0.0 if is_right(found, first, places) else chance

    assert 0 < wrong({}, 1.0) < 0.2
