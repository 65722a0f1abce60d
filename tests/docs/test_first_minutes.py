"""The pages that newcomers read first: their commands print what they say, and the search finds them."""

from __future__ import annotations

import importlib.util
import json
import re
import tomllib
from pathlib import Path

import pytest

import feasibee

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
SEARCHED = {"install": "install", "cite": "paper", "pandas": "results", "Windows": "install"}
SEARCHED |= {"obstacle": "not-modelled", "battery": "not-modelled"}
"""What newcomers search for, and a page that must be among the results."""


def load(path):
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


sessions = load(DOCS / "_extensions" / "sessions.py")


def read(page):
    return (DOCS / f"{page}.md").read_text("utf-8")


# --- Sessions: commands and Python with their outputs ---


def test_a_session_puts_outputs_right_and_writes_the_readers_files(tmp_path):
    page = """Text.

```toml
# mine.toml
tasks.count = 2
```

```python
from pathlib import Path

count = len(Path("mine.toml").read_text().splitlines())
print(count, "lines")
```

```text
{lines}
```

```sh
feasibee none
```

```console
$ feasibee show truth mine.toml --json
$ feasibee show truth none.toml
{error}
```

```text
2 robots
```

End.
"""
    played = sessions.played(page.format(lines="3 lines", error="?"), tmp_path)
    assert "```text\n2 lines\n```" in played
    assert '"feasible": true' in played
    assert "feasibee: none.toml: can't be read: No such file or directory" in played
    assert played.startswith("Text.")
    assert played.endswith("```text\n2 robots\n```\n\nEnd.\n")
    assert sessions.played(played, tmp_path) == played


def test_a_session_keeps_the_stated_duration_of_a_command(tmp_path):
    page = "```python\nprint('done in 2.5 s')\n```\n\n```text\ndone in {} s\n```\n"
    assert sessions.played(page.format("7.1"), tmp_path) == page.format("7.1")


def test_a_console_runs_feasibee_only(tmp_path):
    with pytest.raises(ValueError, match="a console runs feasibee only"):
        sessions.played("```console\n$ rm -r .\n```\n", tmp_path)


# --- Ways in ---


def test_each_entry_of_the_navigation_has_a_landing_page_that_links_all_of_its_pages():
    entries = re.findall(r"<sections/(\w+)>", read("index"))
    assert entries[0] == "start"
    assert len(entries) <= 8, "few entries, as xarray's"
    sections = {each: read(f"sections/{each}") for each in entries}
    pages = [page for text in sections.values() for page in re.findall(r"</([\w/-]+)>$", text, re.MULTILINE)]
    assert sorted(pages) == sorted(
        re.findall(r"^\[.*\]\(\.\./([\w/-]+)\.md\)\n: ", "\n".join(sections.values()), re.MULTILINE)
    )
    assert {path.stem for path in DOCS.glob("*.md")} - {"index"} == {
        page for page in pages if "/" not in page
    }
    for reader in ("Researchers", "Engineers", "Students"):
        assert f"**{reader}**" in read("index")


@pytest.mark.parametrize("name", feasibee.__all__)
def test_the_groups_of_the_interface_have_each_name_of_the_package(name):
    groups = read("api/index").partition("| to | names |")[2].partition("\n\n")[0]
    assert f"`~feasibee.{name}`" in groups


@pytest.mark.parametrize(("word", "page"), SEARCHED.items())
def test_a_searched_word_stands_in_a_heading(word, page):
    stem = word.lower().rstrip("ey")
    headings = re.findall(r"^#+ (.*)$", read(page), re.MULTILINE)
    assert any(stem in each.lower() for each in headings)


@pytest.mark.parametrize(("word", "page"), SEARCHED.items())
def test_the_sites_search_finds_a_word(word, page):
    stemmer = pytest.importorskip("sphinx.search.en", reason="Sphinx isn't installed").SearchEnglish({})
    index = DOCS / "_build" / "html" / "searchindex.js"
    if not index.exists():
        pytest.skip("the site isn't built: make docs")
    found = json.loads(index.read_text("utf-8").removeprefix("Search.setIndex(").removesuffix(")"))
    hits = [found[table].get(stemmer.stem(word.lower()), []) for table in ("terms", "titleterms")]
    pages = {found["docnames"][each] for hit in hits for each in (hit if isinstance(hit, list) else [hit])}
    assert page in pages


# --- What the pages say of the package ---


def test_the_extras_on_the_page_are_those_of_the_package():
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["optional-dependencies"]
    (table,) = re.findall(r"\| extra \| for \|\n\|---\|---\|\n((?:\|.*\n)+)", read("install"))
    assert set(re.findall(r"^\| `(\w+)`", table, re.MULTILINE)) == set(extras) - {"live"}


@pytest.mark.parametrize("path", [ROOT / "README.md", *sorted(DOCS.glob("*.md"))], ids=lambda path: path.stem)
def test_no_page_installs_a_package_that_is_not_published(path):
    text = path.read_text("utf-8")
    assert not re.findall(r"pip install [\"']?feasibee", text)
    assert not re.findall(r"pip install (?!--)[^\"\n`]*\[", text), "quote extras: shells expand brackets"


def test_each_message_in_troubleshooting_is_one_of_feasibee():
    """A message on the page is code in a bold symptom; `…` stands for what differs."""
    source = "".join(path.read_text("utf-8") for path in sorted((ROOT / "src").rglob("*.py")))
    source = re.sub(r'"\s*\n\s*f?"', "", source)  # a message of several lines of code
    symptoms = re.findall(r"^\*\*(.*)\*\*.*\n: ", read("troubleshooting"), re.MULTILINE)
    messages = [each for symptom in symptoms for each in re.findall(r"`([^`]* [^`]*)`", symptom)]
    ours = [each for each in messages if not each.startswith(("feasibee: command", "Activate"))]
    assert len(ours) > 10
    parts = [part.strip(" :") for message in ours for part in message.split("…")]
    assert [part for part in parts if part not in source] == []
