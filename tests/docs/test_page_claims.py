"""The numbers of README and docs: each from a command (claims/), or given."""

from __future__ import annotations

from pathlib import Path

import pytest

from claims import __main__ as command_line
from claims import book, commands
from claims.book import Claim, Page, Rows
from claims.compare import examine, find_claim, find_table, mended
from claims.cover import uncovered, unused
from claims.template import Template
from claims.values import Record, median, parse_csv, printed, show

PAGES = book.read_all()
NUMBERED = [
    "README.md",
    "examples/README.md",
    "joss/paper.md",
    *(f"docs/{path.name}" for path in (book.ROOT / "docs").glob("*.md")),
]
WITHOUT = {
    "docs/changelog.md",
    "docs/contributing.md",
    "docs/examples.md",
    "docs/findings.md",
}  # they include other files


def page(*claims, path="x.md", command="feasibee", files=(), tables=(), given=(), parts=()):
    rest = [list(claims), list(tables), list(given), list(parts)]
    return Page("x", Path(path), {"a": command}, {}, dict(files), *rest, True)


def claim(text, holds=""):
    return Claim(Template(text), holds)


def put_right(text, page, **outcomes):
    return mended(text, list(examine(text, page, outcomes)))


# --- The pages as they are ---


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_claim_stands_on_its_page_and_every_other_number_is_given(page):
    text = page.path.read_text(encoding="utf-8")
    assert [each.about for each in examine(text, page, {})] == []
    assert list(command_line.unaccounted(text, page)) == []


def test_every_page_has_its_claims():
    assert {page.path.relative_to(book.ROOT).as_posix() for page in PAGES} >= set(NUMBERED) - WITHOUT


def test_every_command_is_for_something():
    for each in PAGES:
        used = set().union(*(each.needs(claim) for claim in [*each.claims, *each.tables]))
        assert used == set(each.commands), each.name


# --- Numbers ---


@pytest.mark.parametrize(
    ("value", "spec", "written"),
    [
        (0.9345, ".3f", "0.935"),
        (-0.025, ".3f", "\N{MINUS SIGN}0.025"),
        (-0.0001, ".2f", "0.00"),
        (32.5, "+.1f", "+32.5"),
        (1154.3, ".3g", "1,154"),
        (2.1, ".3g", "2.10"),
        (42000, "", "42,000"),
        (None, "", "never"),
        ("holds", "s", "holds"),
        ([0.5, None], ".1f", "0.5 | never"),
        (Record(estimate=0.75, low=0.7326, high=0.77), ".2f", "0.75 (0.73 to 0.77)"),
    ],
)
def test_numbers_are_written_as_pages_write_them(value, spec, written):
    assert show(value, spec) == written


def test_a_number_without_a_format_is_an_error():
    with pytest.raises(ValueError, match="no format"):
        show(0.25)


def test_rows_are_found_by_their_values_and_intervals_are_one():
    table = parse_csv(
        "name,tasks,share,share_low,share_high,step\na,10,0.5,0.4,0.6,7\na,20,1,0.9,1,\nb,10,0,0,0.1,3\n"
    )
    assert table(name="a").share.estimate == [0.5, 1]
    assert show(table(name="a", tasks=10).share, ".1f") == "0.5 (0.4 to 0.6)"
    assert table(name="a", tasks=20).step is None
    assert list(table.groups("name")) == ["a", "b"]
    with pytest.raises(LookupError, match="no row"):
        table(name="c")


def test_a_step_that_is_never_reached_is_later_than_any():
    assert median([None, 3, 5]) == 5
    assert median([None, None, 5]) is None


def test_numbers_of_what_was_printed_are_read_from_the_row_of_a_name_in_the_named_table():
    text = """ dmmd-2  1.0

     All together
 over all m  right
 dmmd-2  82.3  81.1 to 83.4  +2.9

     How sure the swarms are
 dmmd-2  0.125
"""
    assert printed(text, "dmmd-2", "All together") == [82.3, 81.1, 83.4, 2.9]
    assert printed(text, "dmmd-2", "How sure the swarms are") == [0.125]
    with pytest.raises(ValueError, match="Together"):
        printed(text, "dmmd-2", "Together")


# --- Sentences ---

TEXT = "Of all\n  swarms 0.41 (0.40\n  to 0.42) are right,\n> half by step 1,204.\n"
BROKEN = claim("Of all swarms {a.share:.2f} are right, half by step {a.step}.")


def test_a_sentence_is_found_however_its_lines_are_broken_and_is_put_right_in_place():
    right = Record(share=Record(estimate=0.5, low=0.45, high=0.55), step=99)
    assert put_right(TEXT, page(BROKEN), a=right) == TEXT.replace("0.41", "0.50").replace(
        "0.40", "0.45"
    ).replace("0.42", "0.55").replace("1,204", "99")
    same = Record(share=Record(estimate=0.41, low=0.4, high=0.42), step=1204)
    assert put_right(TEXT, page(BROKEN), a=same) == TEXT


def test_a_sentence_that_is_not_there_or_twice_is_told():
    assert find_claim("half by 3", BROKEN) == "isn't on the page"
    assert (
        find_claim("by step 3, by step 4", claim("by step {a}")) == "is on the page twice; use a longer text"
    )


def test_a_sentence_whose_words_are_no_longer_true_is_told():
    (finding,) = examine("The most, 3.", page(claim("The most, {a}.", holds="a > 5")), {"a": 3})
    assert not finding.mends
    assert finding.measured == "not true: a > 5"


def test_within_its_tolerance_a_speed_keeps_its_date_and_beyond_it_both_move():
    speed = page(claim("{a.ratio:.1f±20%} times, {a.date:±}"))
    text = "3.4 times, 2026-01-31"
    assert put_right(text, speed, a=Record(ratio=4.0, date="2027-02-01")) == text
    assert put_right(text, speed, a=Record(ratio=5.0, date="2027-02-01")) == "5.0 times, 2027-02-01"


# --- Tables ---

TABLE = "| name | share |\n|---|---|\n| x | 0.10 |\n| y | 0.20 |\n\nThe end.\n"
ROWS = Rows("| name |", "row", "a", Template("| {row.name} | {row.share:.2f} |"))


def test_a_table_gets_all_its_rows():
    rows = [Record(name="y", share=0.2), Record(name="z", share=0.3), Record(name="x", share=0.1)]
    assert put_right(TABLE, page(tables=[ROWS]), a=rows) == TABLE.replace(
        "| x | 0.10 |\n| y | 0.20 |\n", "| y | 0.20 |\n| z | 0.30 |\n| x | 0.10 |\n"
    )


def test_without_its_outcome_a_tables_rows_must_look_like_its_row():
    assert list(examine(TABLE, page(tables=[ROWS]), {})) == []
    (finding,) = examine(TABLE.replace("| y | 0.20 |", "| y |"), page(tables=[ROWS]), {})
    assert finding.stated == "| y |"
    assert find_table("No table.", ROWS) == "no table has this header"


# --- What is covered ---


def loose(text, page):
    return [each[0] for each in uncovered(text, page)]


def test_a_number_that_nobody_claims_is_told():
    assert loose("Right in 0.83 of the 20 runs.", page()) == ["0.83", "20"]
    assert loose("Right in 0.83 of the 20 runs.", page(claim("in {a:.2f} of"), given=["the # runs"])) == []
    assert loose("Right in 0.83 of 0.84.", page(claim("in {a:.2f} of"))) == ["0.84"]


def test_code_links_items_and_names_hold_no_numbers():
    text = "1. `step 3` of [a page](a.md#5), word2vec:\n\n```sh\nmake 7\n```\n"
    assert loose(text, page()) == []


def test_a_table_or_a_section_may_be_given():
    text = "# 1\n\n| field | default |\n|---|---|\n| side | 20 |\n\nMost: 5.\n\n"
    text += "## Rules\n\nAt most 16.\n\n## Ends\n\n7\n"
    assert loose(text, page(parts=["| field |", "## Rules"])) == ["1", "5", "7"]
    assert unused(text, page(given=["9 lives", "Most: 5"], parts=["## Other"])) == ["9 lives", "## Other"]


# --- Commands ---


@pytest.fixture
def kept(tmp_path, monkeypatch):
    monkeypatch.setattr(commands, "KEPT", tmp_path / "kept")
    monkeypatch.setattr(commands, "_sources", lambda scripts: "as it is")


def test_an_outcome_is_kept_until_the_code_changes(kept, monkeypatch):
    ran = []
    monkeypatch.setattr(commands, "_run", lambda *_: ran.append(1) or {"printed": '{"step": 7}', "files": {}})
    assert [commands.outcome(page(), "a").step for _ in range(2)] == [7, 7]
    assert len(ran) == 1
    monkeypatch.setattr(commands, "_sources", lambda scripts: "changed")
    commands.outcome(page(), "a")
    assert len(ran) == 2


def test_what_could_change_an_outcome_is_code_not_docstrings():
    text = '"""Doc."""\ndef f():\n    """Doc."""\n    return 1  # why\n'
    other = '"""Else."""\ndef f():\n    return 1\n'
    assert commands._without_docstrings(text) == commands._without_docstrings(other)
    assert commands._without_docstrings(text) != commands._without_docstrings(other.replace("1", "2"))


def test_a_command_runs_beside_the_files_that_the_page_has(kept, tmp_path):
    (tmp_path / "x.md").write_text("Write\n\n  ```toml\n  [tasks]\n  count = 7\n  ```\n", encoding="utf-8")
    command, files = "feasibee show truth mine.toml --json", {"mine.toml": "[tasks]"}
    there = page(path=tmp_path / "x.md", command=command, files=files)
    assert commands.files_of(there) == {"mine.toml": "[tasks]\ncount = 7\n"}
    assert commands.outcome(there, "a")["feasible"] is True


def test_data_of_an_example_is_no_outcome_of_a_command(kept, tmp_path):
    """Else the file that examples/irsim has would make a Record of each table that `compare` writes."""
    (tmp_path / "x.md").write_text("", encoding="utf-8")
    assert list((commands.ROOT / "examples").rglob("*.json"))
    compare = "feasibee compare --strategies dmmd --tasks 10,20 --runs 2 --seed 1 --set run.steps=10"
    table = commands.outcome(page(path=tmp_path / "x.md", command=compare), "a")
    assert [row.tasks for row in table] == [10, 20]


def test_a_command_that_fails_is_told(kept, tmp_path):
    (tmp_path / "x.md").write_text("", encoding="utf-8")
    wrong = page(path=tmp_path / "x.md", command="feasibee show truth none.toml")
    with pytest.raises(SystemExit, match=r"ended with status 2:\nfeasibee: none\.toml"):
        commands.outcome(wrong, "a")


@pytest.mark.parametrize(("options", "status", "text"), [([], 0, "7 steps"), (["--check"], 1, "6 steps")])
def test_the_command_line_puts_a_page_right_or_only_tells(
    kept, tmp_path, monkeypatch, capsys, options, status, text
):
    (tmp_path / "x.md").write_text("6 steps", encoding="utf-8")
    there = page(claim("{a.step} steps"), path=tmp_path / "x.md")
    monkeypatch.setattr(command_line, "read", lambda name: there)
    monkeypatch.setattr(command_line, "outcome", lambda page, name: Record(step=7))
    assert command_line.main(["x", *options]) == status
    assert (tmp_path / "x.md").read_text(encoding="utf-8") == text
    assert "x.md:1: states 6, measured 7: 6 steps" in capsys.readouterr().out
