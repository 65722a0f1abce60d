"""The rules for English that a program can check: length of sentences, and unclear phrases."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent.parent
MOST_WORDS = 25
FORBIDDEN = [
    r"(do|does|did|done) the same",
    r"the own",
    r"beside",
    r"if there (is|are) (one|any|none)",
    r"that there (isn't|aren't)",
    r"refus\w+",
    r"mend(s|ed|ing)?",
    r"settl\w+",
    r"(tell|tells|telling|told)",
    r"liars?",
    r"survives? anything",
    r"any platform",
    r"in a line",
    r"(beat|sink)s?",
]
"""Regular expressions of whole words, case ignored."""
CLUMSY = [
    r"in at least 1\.0+ of",
    r"pass on names could by step",
    r"(say|said|declare) by their own word",
    r"bears? no Byzantine",
    r"places asked for",
    r"each place has a robot",
    r"the output has gone",
    r"what is for good",
    r"never to never",
    r"nothing that was tried",
    r"never mistaken",
]
"""Phrases that walks as new users found hard, for pages and for all that the program says."""

FENCE = re.compile(r"^([ ]*)(`{3,})([^\n]*)\n(.*?)^\1\2[ ]*$\n?", re.MULTILINE | re.DOTALL)
INTERVAL = re.compile(r"\([+\N{MINUS SIGN}\d., %]+(to [+\N{MINUS SIGN}\d., %]+)?\)")
END = re.compile(r"(?<!Fig)(?<!e\.g)(?<!i\.e)[.!?][*_\"')\]]*\s+")


def sentences(text: str) -> Iterator[str]:
    """Yield the sentences of a text in Markdown, without code, quotations and targets of links."""
    text = FENCE.sub(lambda found: _entries(found[4]) if found[3] == "{glossary}" else "\n\n", text)
    text = re.sub(r"<!--.*?-->", "", text, flags=re.DOTALL)
    text = re.sub(r"(\{\w+\}|:\w+:)?(``[^`]+``|`[^`]+`)", "X", text)
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
    text = re.sub(r"^[ ]*>.*$", "", text, flags=re.MULTILINE)
    text = text.replace("|", "\n\n")
    text = re.sub(r"^([ ]*(?:[-*]|\d+\.) |#+ )", r"\n\n", text, flags=re.MULTILINE)
    for block in re.split(r"\n[ ]*\n", text):
        for sentence in END.split(" ".join(block.split()) + " "):
            yield INTERVAL.sub("", sentence).strip()


def _entries(text: str) -> str:
    """Return a glossary with a blank line between each term and its definition."""
    return re.sub(r"^(\S.*)$", r"\1\n", text, flags=re.MULTILINE)


def problems(text: str) -> list[str]:
    """Return the sentences of a text that are too long or have an unclear phrase, each with its problem."""
    found = []
    for sentence in sentences(text):
        words = [word for word in sentence.split() if re.search(r"\w", word)]
        if len(words) > MOST_WORDS:
            found.append(f"{len(words)} words: {sentence}")
        if sentence.count(";") > 1:
            found.append(f"{sentence.count(';')} semicolons: {sentence}")
        for phrase in FORBIDDEN:
            hit = re.search(rf"(?<!\w){phrase}(?!\w)", sentence, re.IGNORECASE)
            if hit:
                found.append(f'"{hit[0]}": {sentence}')
    return found


def pages() -> list[str]:
    """Return the paths of all pages that are written by hand."""
    paths = [
        *(ROOT / "docs").rglob("*.md"),
        *(page for each in (".", "examples", "joss") for page in (ROOT / each).glob("*.md")),
    ]
    written = (path.relative_to(ROOT) for path in paths)
    return sorted(path.as_posix() for path in written if not {"_build", "gallery"} & set(path.parts))


def modules() -> list[str]:
    """Return the paths of all modules of the package, the benchmarks, the claims and the examples."""
    folders = ("src", "benchmarks", "claims", "examples")
    return sorted(
        path.relative_to(ROOT).as_posix() for each in folders for path in (ROOT / each).rglob("*.py")
    )


def summaries(source: str) -> Iterator[str]:
    """Yield the summaries of docstrings, and the descriptions of fields and options, of a module."""
    for node in ast.walk(ast.parse(source)):
        match node:
            case ast.Expr(ast.Constant(str(text))):
                yield text.split("\n\n")[0]
            case ast.keyword("description" | "help", ast.Constant(str(text))):
                yield text


def problems_of(path: str) -> list[str]:
    """Return the problems of a page, or of the summaries in a module."""
    text = (ROOT / path).read_text(encoding="utf-8")
    if path.endswith(".md"):
        return problems(text)
    return [problem for each in summaries(text) for problem in problems(each)]


@pytest.mark.parametrize("page", sorted(pages()))
def test_a_page_has_short_sentences_and_plain_words(page):
    assert problems_of(page) == []


def test_a_modules_summaries_are_short_and_plain():
    found = {path: problems_of(path) for path in modules()}
    assert {path: wrong for path, wrong in found.items() if wrong} == {}


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("Two words " * 12 + "more.", []),
        ("Two words " * 12 + "and more.", ["26 words"]),
        ("- An item that is\n  continued. " + "Two words " * 13, ["26 words"]),
        ("One; two; three.", ["2 semicolons"]),
        ("It stands beside it. Besides, `beside` is code.", ['"beside"']),
        ("See [the page](beside.md).\n\n```sh\nbeside\n```\n\n> beside\n", []),
        ("| a | a cell beside it |\n|---|---|\n", ['"beside"']),
        ("Right in 0.75 (0.73 to 0.77) of the runs, " + "one word " * 9, []),
        ("```{glossary}\nterm\n  Told.\n```\n", ['"Told"']),
    ],
)
def test_the_checker_finds_what_it_should(text, found):
    assert [problem.partition(":")[0] for problem in problems(text)] == found


def test_summaries_are_those_of_docstrings_attributes_and_descriptions():
    source = '"""Module.\n\nMore."""\nX = Field(1, description="Field.")\n"""Attribute."""\n'
    source += 'def f():\n    """Function."""\n    return "text"\n'
    assert sorted(summaries(source)) == ["Attribute.", "Field.", "Function.", "Module."]


@pytest.mark.parametrize("phrase", CLUMSY)
def test_no_page_and_no_text_of_the_program_has_a_phrase_that_new_users_found_hard(phrase):
    texts = {path: (ROOT / path).read_text(encoding="utf-8") for path in [*pages(), *programs()]}
    assert [path for path, text in texts.items() if re.search(phrase, " ".join(text.split()), re.I)] == []


def programs() -> list[str]:
    """Return the paths of what the package is made of: modules of Python and of browsers, and pages."""
    ends = (".py", ".js", ".html")
    found = (path.relative_to(ROOT) for path in (ROOT / "src").rglob("*") if path.suffix in ends)
    return sorted(path.as_posix() for path in found)
