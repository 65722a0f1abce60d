"""What strangers meet at the door: version, changelog, citation, records of decisions, workflows."""

from __future__ import annotations

import datetime
import importlib.metadata
import json
import re
import shutil
import subprocess
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
VERSION = PROJECT["version"]
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
RECORDS = sorted((ROOT / "docs" / "decisions").glob("[0-9]*.md"))
SECTIONS = ["Context", "Choice", "Measured consequence", "Sources"]
CHANGES = ["Added", "Changed", "Deprecated", "Removed", "Fixed", "Security", "Results changed"]
PARTS = [
    "Summary",
    "Statement of need",
    "State of the field",
    "Software design",
    "Research impact statement",
    "AI usage disclosure",
    "Acknowledgements",
    "References",
]


def read(name):
    return (ROOT / name).read_text("utf-8")


def test_the_version_is_the_same_everywhere():
    assert importlib.metadata.version("feasibee") == VERSION
    assert re.findall(r"^version: (.*)$", read("CITATION.cff"), re.MULTILINE) == [VERSION]
    assert re.findall(r"version = \{(.*)\}", read("docs/paper.md")) == [VERSION]


def test_the_changelog_has_this_version_and_each_release_a_date():
    first, *released = re.findall(r"^## (.*)$", read("CHANGELOG.md"), re.MULTILINE)
    assert first == "Unreleased"
    dates = [datetime.date.fromisoformat(each.partition(" - ")[2]) for each in released]
    assert dates == sorted(dates, reverse=True)
    if released:
        assert VERSION in [each.partition(" - ")[0] for each in released]
    else:
        assert f"To become {VERSION}, the first release." in read("CHANGELOG.md")


def test_the_changelog_has_known_headings_and_says_what_results_changed():
    for text in re.split(r"^## ", read("CHANGELOG.md"), flags=re.MULTILINE)[1:]:
        headings = re.findall(r"^### (.*)$", text, re.MULTILINE)
        assert headings == [each for each in CHANGES if each in headings]
        assert "Results changed" in headings


def test_badges_say_what_the_project_says():
    """No badge needs a public host of this repository, as those of CI, coverage and downloads would."""
    badges = re.findall(r"https://img\.shields\.io/badge/([^)]*)", read("README.md"))
    license_, python = PROJECT["license"].replace("-", "--"), PROJECT["requires-python"].removeprefix(">=")
    assert badges == [f"license-{license_}-blue", f"python-{python}_or_later-blue"]
    assert read("README.md").count("https://img.shields.io/") == len(badges)


def test_the_citation_names_the_program_and_the_paper():
    """The fields that the format requires, and that reference managers show."""
    text = read("CITATION.cff")
    top = re.findall(r"^([a-z-]+):", text, re.MULTILINE)
    assert {"cff-version", "message", "title", "authors", "version", "license", "references"} <= set(top)
    assert len(top) == len(set(top))
    _, paper = text.split("\nreferences:\n")
    assert re.findall(r"family-names: (.*)", paper) == ["Fuady", "Tarapore", "Ehsan", "Soorati"]
    for part in ("type: article", "year: 2024", "arXiv:2405.07799"):
        assert part in paper


def test_the_archives_record_is_the_citations():
    record, text = json.loads(read(".zenodo.json")), read("CITATION.cff")
    assert f"\ntitle: {record['title']}\n" in text
    assert f'\nabstract: "{record["description"]}"\n' in text
    assert [f"  - {each}" for each in record["keywords"]] == re.findall(r"(?m)^  - [a-z -]+$", text)
    assert [each["name"] for each in record["creators"]] == re.findall(r'(?m)^  - name: "(.*)"$', text)
    assert record["license"] == "Apache-2.0" == re.findall(r"^license: (.*)$", text, re.MULTILINE)[0]
    assert record["related_identifiers"][0]["identifier"] in text


def test_the_paper_has_the_sections_length_and_references_that_joss_asks_for():
    """Its requirements of May 2026, at commit 5c61e22 of openjournals/joss, docs/paper.md."""
    _, _, body = read("joss/paper.md").split("---\n", 2)
    assert re.findall(r"^# (.*)$", body, re.MULTILINE) == PARTS
    assert 750 <= len(body.split()) <= 1750
    entries = re.findall(r"^@\w+\{(\w+),", read("joss/paper.bib"), re.MULTILINE)
    assert sorted(entries) == sorted(set(re.findall(r"@(\w+)[\];]", body)))


def test_the_paper_and_the_docs_compare_simulators_in_the_same_table():
    pages = ("joss/paper.md", "docs/not-modelled.md")
    ours, theirs = (re.search(r"(?m)^\| \| feasibee .*(?:\n\|.*)+", read(page))[0] for page in pages)
    rows = [[line for line in table.splitlines() if not line.startswith("|-")] for table in (ours, theirs)]
    assert rows[0] == rows[1]
    assert len(rows[0]) > 10
    assert {line.count("|") for line in rows[0]} == {10}


@pytest.mark.parametrize("path", RECORDS, ids=lambda path: path.stem)
def test_a_decision_has_a_date_a_status_and_all_sections_on_a_page(path):
    text = path.read_text("utf-8")
    assert re.findall(r"^## (.*)$", text, re.MULTILINE) == SECTIONS
    (date,) = re.findall(r"^- Date: (.*)$", text, re.MULTILINE)
    assert datetime.date.fromisoformat(date)
    (status,) = re.findall(r"^- Status: (.*)$", text, re.MULTILINE)
    assert re.fullmatch(r"accepted|replaced by \[.*\]\(\d\d-[a-z0-9-]+\.md\)", status)
    assert len(text.splitlines()) <= 60
    listed = re.findall(r"^(\d\d-[a-z0-9-]+)$", read("docs/decisions/index.md"), re.MULTILINE)
    assert listed.index(path.stem) + 1 == int(path.name[:2])
    assert len(listed) == len(RECORDS)


def test_every_target_that_contributors_are_told_of_exists():
    targets = set(re.findall(r"^([a-z-]+):", read("Makefile"), re.MULTILINE))
    for name in ("CONTRIBUTING.md", "README.md"):
        told = set(re.findall(r"\bmake ([a-z-]+)", re.sub(r"without\s+make", "", read(name))))
        assert told <= targets, name


def test_make_paper_computes_the_numbers_of_its_page():
    (command,) = re.findall(r"^feasibee paper .*$", read("docs/paper.md"), re.MULTILINE)
    assert "--seed" in command
    assert f"{command} --out paper" in read("Makefile")
    assert "`make paper`" in read("README.md")


def test_workflows_run_what_is_supported_and_pin_their_actions():
    ci = read(".github/workflows/ci.yml")
    for each in ("3.11", "3.12", "3.13", "3.14", "ubuntu-latest", "macos-latest", "windows-latest"):
        assert each in ci
    for path in WORKFLOWS:
        text = path.read_text("utf-8")
        uses = re.findall(r"uses: (\S+)", text)
        assert uses
        assert all(re.fullmatch(r"[\w./-]+@(v\d+|release/v\d+)", each) for each in uses), path.name
        assert re.search(r"^permissions:", text, re.MULTILINE), f"{path.name}: its token may do anything"


@pytest.mark.skipif(shutil.which("actionlint") is None, reason="actionlint isn't installed")
@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.name)
def test_actionlint_finds_nothing(path):
    done = subprocess.run(["actionlint", path], capture_output=True, text=True, check=False)
    assert (done.stdout + done.stderr, done.returncode) == ("", 0)


def test_no_page_has_the_marks_of_a_merge():
    pages = [*ROOT.glob("*.md"), *ROOT.glob("docs/*.md"), *RECORDS]
    assert [page.name for page in pages if re.search(r"(?m)^(<{7}|>{7}) ", page.read_text("utf-8"))] == []
