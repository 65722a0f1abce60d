"""What notebooks show: whole HTML, escaped, with what matters in it."""

from __future__ import annotations

from html.parser import HTMLParser

import numpy as np
import pytest
from declaring import declaring
from pixels import shown_by

from feasibee import Scenario, Swarm
from feasibee.figures.animation import draw_frame
from feasibee.simulation.frames import MOST, SIZE


class Page(HTMLParser):
    """Text and tags of some HTML, which must close what it opens."""

    def __init__(self, text):
        super().__init__()
        self.open, self.tags, self.text, self.strong = [], [], "", []
        self.feed(text)
        self.close()
        assert self.open == []
        self.text = " ".join(self.text.split())

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))
        self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data if "style" not in self.open else ""
        if "strong" in self.open:
            self.strong.append(data)


def page(thing):
    return Page(thing._repr_html_())


def test_a_scenario_shows_each_field_by_section_and_stresses_what_is_not_the_papers():
    scenario = Scenario(tasks={"count": 50}, sensing={"range": 3.0}, arena={"boundary": "walls"})
    shown = page(scenario)
    for name, table in scenario.to_dict().items():
        assert name in shown.text
        assert all(f"{key} = " in shown.text for key in table)
    stressed = {each for each in shown.strong if " = " in each}
    assert stressed == {"count = 50", "range = 3.0", 'boundary = "walls"'}
    assert "4 fields not as in the paper" in shown.text  # the radio's range goes with that of sensing
    assert "infeasible" in shown.strong
    assert scenario.hash[:12] in shown.text
    assert "Number of tasks, m; each needs one robot, and any robot can do it." in shown.text
    paper = page(Scenario())
    assert "as in the paper" in paper.text
    assert paper.strong == ["Scenario", "feasible"]
    assert sum(tag == "details" for tag, _ in shown.tags) == len(scenario.to_dict())


def test_text_of_a_user_is_escaped_and_long_values_cut():
    name = "<script>alert('&')</script>"
    shown = page(
        Scenario(
            robots={"classes": [{"name": name, "count": 5, "skills": ["<i>lift"]}]},
            tasks={"placement": "points", "points": [(1.0, 2.0)] * 500},
        )
    )
    assert name in shown.text
    assert not {"script", "i"} & {tag for tag, _ in shown.tags}
    assert "5 robots, 500 tasks" in shown.text
    assert len(shown.text) < 7000


def test_a_swarm_shows_its_arena_as_in_an_animation(tmp_path):
    swarm = Swarm(declaring(tmp_path, quiet=20.0, tasks={"count": 21}), seed=3)
    swarm.advance(60)
    shown, (feasible, infeasible) = page(swarm), swarm.declared_counts
    assert f"Run 0, step 60: {swarm.feasible_count} feasible, {swarm.infeasible_count} inf" in shown.text
    assert 0 < feasible < 20
    assert f"; declared: {feasible} feasible, {infeasible} infeasible" in shown.text
    assert "undecided (truth: infeasible)" in shown.text
    assert [given["alt"] for tag, given in shown.tags if tag == "img"] == [
        "An arena with 20 robots and 21 tasks"
    ]
    picture = np.asarray(shown_by(swarm), int)
    frame = np.asarray(draw_frame(swarm, size=SIZE), int)
    assert SIZE < len(picture) + 10 < SIZE + 20 < len(frame)  # without the words
    away = np.abs(picture - frame[: len(picture)]).max(axis=2)  # since it has few colours
    assert away.max() < 64
    assert (away > 12).mean() < 0.002


@pytest.mark.parametrize(("robots", "drawn"), [(10_000, True), (MOST + 1, False)])
def test_a_large_swarm_stays_light(robots, drawn):
    swarm = Swarm(Scenario(arena={"side": 600.0}, robots={"count": robots}))
    text = swarm._repr_html_()
    assert len(text) < 200_000
    assert ("<img" in text) == drawn
    assert ("use feasibee run --out" in text) != drawn
