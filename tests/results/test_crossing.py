"""Searches for the value from which a rate is high enough."""

from __future__ import annotations

import numpy as np
import pytest

from feasibee.results.crossing import Crossing, Finding, Rule, find_crossing, finding_at, most_tests
from feasibee.results.statistics import Interval

UNKNOWN = Interval(0.5, 0.0, 1.0)


def searched(places, below, enough):
    """Search places of which those before ``below`` are too few, and those from ``enough`` on are enough."""

    def test(place):
        answer = "too few" if place < below else "open" if place < enough else "enough"
        return Finding(place, 0, 1, UNKNOWN, answer)

    return find_crossing(places, test)


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
    assert finding_at(3, lambda trials: 0, rule, 10)[:3] == (3, 0, 100)
    certain = finding_at(0, lambda trials: trials, rule, 1)
    assert certain.answer == "enough"
    assert certain.trials < 300
    close = finding_at(0, lambda trials: round(0.95 * trials), rule, 1)
    assert (close.answer, close.trials) == ("open", 2000)


def test_fewer_trials_than_the_first_look_are_allowed():
    assert finding_at(0, lambda trials: trials, Rule(0.95, most=3), 1).trials == 3


def swarm_of(rates, seed):
    """Return a test of places with these rates: trials of a place are the same however often it is tested."""

    def search(rule):
        draws = np.random.default_rng(seed).random((len(rates), rule.most))

        def test(place):
            hits = np.cumsum(draws[place] < rates[place])
            return finding_at(place, lambda trials: int(hits[trials - 1]), rule, most_tests(len(rates)))

        return find_crossing(len(rates), test, rule.resolution)

    return search


def is_right(found: Crossing, first: int, places: int) -> bool:
    """Whether the first place that reaches the target lies in the interval of an answer."""
    enough = places if found.enough is None else found.enough
    return found.possible <= first <= enough


def test_an_answer_is_wrong_as_rarely_as_it_says():
    """Of 300 searches at 80 %, 60 may be wrong; Wilson intervals at each look would fail in more than half.

    The rates rise slowly through the target, so that many tests are close.
    """
    rates = 1 / (1 + np.exp(-(np.arange(40) - 15.5) / 6))
    target = 0.8
    first = int(np.argmax(rates >= target))
    rule = Rule(target, first=20, most=1000, confidence=0.8)
    wrong = sum(not is_right(swarm_of(rates, seed)(rule), first, 40) for seed in range(300))
    assert wrong <= 60


def test_the_interval_shrinks_with_trials():
    rates = 1 / (1 + np.exp(-(np.arange(200) - 80.5) / 20))
    widths = []
    for most in (100, 1000, 10_000):
        found = swarm_of(rates, 5)(Rule(0.8, most=most))
        widths.append((200 if found.enough is None else found.enough) - found.possible)
    assert widths == sorted(widths, reverse=True)
    assert widths[-1] < widths[0] / 3


def test_a_coarse_answer_holds_the_fine_one_and_takes_fewer_tests():
    rates = 1 / (1 + np.exp(-(np.arange(200) - 80.5) / 6))
    search, rule = swarm_of(rates, 5), Rule(0.8, most=10_000)
    fine, coarse = search(rule), search(Rule(0.8, most=10_000, resolution=0.2))
    assert coarse.possible <= fine.possible <= fine.enough <= coarse.enough
    assert len(coarse.tested) < len(fine.tested)
