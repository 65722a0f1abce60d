"""A folder of chunk files, ``runs``: each holds some runs of one point, and is named by what it holds.

A point is a scenario with a seed. ``KEY.json`` describes it, and ``KEY.FIRST-LAST.DIGEST.npz`` has some of
its runs, with ``.curves`` before the digest if the opinions at each step are kept. A file appears by a
rename, whole or not at all, and one that differs from its digest counts as missing: what wrote it computes it
again. So nothing is locked, any number of processes and machines may write, and to merge folders is to copy
their files into one.
"""

from __future__ import annotations

import json
import re
import zipfile
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from hashlib import blake2b
from importlib.metadata import version
from io import BytesIO
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Final, NamedTuple

import numpy as np

from feasibee.base.codes import MODEL_VERSION
from feasibee.base.errors import FeasibeeError
from feasibee.base.files import atomic_write, make_folder, write_text
from feasibee.base.outcomes import ACCOUNT, CURVES, OUTCOMES, TRACES
from feasibee.base.record import Record
from feasibee.scenario.feasibility import truth
from feasibee.scenario.scenario import Scenario
from feasibee.scenario.tables import hash_of
from feasibee.simulation.plan import DesignPoint, StoppingRule

FORMAT: Final = 11
"""Number of the files' format; raise it whenever they change. Up to 10, it was that of a database."""
VERSIONS: Final = {"format": FORMAT, "model_version": MODEL_VERSION}
TABLE: Final = np.dtype([(each.name, np.dtype(each.dtype).newbyteorder("<")) for each in OUTCOMES])
"""Type of a row per run. One table is read four times as fast as an array per outcome."""
CHUNK: Final = re.compile(r"([0-9a-f]{16})\.(\d{1,19})-(\d{1,19})(\.curves)?\.[0-9a-f]{16}\.npz")
RUNS: Final = "runs"
"""Name of the folder, in that of a study, with the files."""
NAMED: Final = 5
"""Most damaged files that an error names."""
EARLIER: Final = "journal.sqlite"
"""File of an earlier version of feasibee, which ``examples/convert_journal.py`` converts."""
UNREADABLE: Final = (
    *(ArithmeticError, LookupError, TypeError, ValueError, RecursionError, MemoryError, OSError),
    *(EOFError, NotImplementedError, zipfile.BadZipFile),
)
"""Errors that the bytes of a damaged file, or of somebody else's, may raise."""


class StoredPoint(NamedTuple):
    """A point of a folder."""

    id: int
    """Its place, from 1, in the order of the study."""
    key: str
    """What the names of its files begin with."""
    hash: str
    seed: int
    truth: bool
    values: dict[str, Any]
    """What its study varies, by dotted path."""
    scenario: Scenario
    """With the text of the strategy's file as it was, which isn't run without the user's consent."""
    until: dict[str, float] | None
    """Stopping rule that chose the number of runs, if any."""
    source: int | None
    """Number of the text of its strategy's file among all texts; None if the strategy is built in."""

    @property
    def name(self) -> str:
        """Its number and what its study varies."""
        named = ", ".join(f"{path} = {value}" for path, value in self.values.items())
        named = named if len(named) <= 100 else f"{named[:100]}..."
        return f"point {self.id} ({named})" if named else f"point {self.id}"


class Chunk(NamedTuple):
    """Consecutive runs of a point, from ``first`` to before ``last``."""

    first: int
    last: int
    has_curves: bool
    held: str | Record
    """Name of their file, or the runs themselves."""


class Store:
    """The runs of points, in a folder or in memory.

    Parameters
    ----------
    folder : path, optional
        The folder; by default runs stay in memory.
    write : bool
        Whether runs will be added. Then the folder may be missing or empty, and damaged files are removed.

    Attributes
    ----------
    damaged : list of str
        Names of files that differ from what was written, as far as they were read.

    Raises
    ------
    FeasibeeError
        If there is nothing to read, or a file of another version of the format or of the model.
    """

    def __init__(self, folder: str | Path | None = None, write: bool = False) -> None:
        self.folder = None if folder is None else Path(folder)
        self.damaged: list[str] = []
        self._write = write
        self._about: dict[str, dict[str, Any]] = {}
        self._scenarios: dict[str, Scenario] = {}
        self._chunks: defaultdict[str, list[Chunk]] = defaultdict(list)
        self._checked: set[str] = set()
        self._files = Path()
        if self.folder is not None:
            self._files = make_folder(self.folder / RUNS) if write else self.folder / RUNS
            self._list()

    # --- Reading ---

    @property
    def version(self) -> str:
        """Version of feasibee that wrote the first point."""
        return next((str(each["version"]) for each in self._about.values()), version("feasibee"))

    @property
    def points(self) -> list[StoredPoint]:
        """All points, in the order in which they were added."""
        texts = [text for text in dict.fromkeys(each["source"] for each in self._about.values()) if text]
        return [
            StoredPoint(
                place,
                key,
                about["hash"],
                int(about["seed"]),
                bool(truth(self._scenario(key))),
                about["values"],
                self._scenario(key),
                about["until"],
                texts.index(about["source"]) + 1 if about["source"] else None,
            )
            for place, (key, about) in enumerate(self._about.items(), start=1)
        ]

    @property
    def harm(self) -> str:
        """What is damaged of what was read so far, and what to do."""
        named = ", ".join(self.damaged[:NAMED]) + (", ..." if len(self.damaged) > NAMED else "")
        number = "1 file is" if len(self.damaged) == 1 else f"{len(self.damaged)} files are"
        return (
            f"{self.folder}: {number} damaged and counted as missing: {named}; run the command that wrote "
            "the folder again: it computes what is missing, and nothing else"
        )

    def check(self) -> None:
        """Raise an error if something of what was read so far is damaged."""
        if self.damaged:
            raise FeasibeeError(self.harm)

    def count(self, key: str) -> int:
        """Return the number of a point's runs, by the names of the files."""
        end = max((chunk.last for chunk in self._chunks[key]), default=0)
        return end - sum(last - first for first, last in self.missing(key, 0, end, False))

    def missing(self, key: str, first: int, last: int, curves: bool) -> list[tuple[int, int]]:
        """Return the runs from ``first`` to before ``last`` that aren't there, perhaps with curves."""
        stretches = []
        for chunk in sorted(self._chunks[key], key=lambda each: each.first):
            if chunk.last > first and (chunk.has_curves or not curves):
                if min(chunk.first, last) > first:
                    stretches.append((first, min(chunk.first, last)))
                first = chunk.last
        return [*stretches, (first, last)] if first < last else stretches

    def results(self, key: str) -> SimpleNamespace:
        """Return the outcomes of all runs of a point by name, and the numbers of the runs as ``run``.

        In a world that changes, its ``TRACES`` are among them, of shape (runs, steps + 1).
        """
        numbers, found = self._merged(key, self.records(key))
        traces = TRACES if self._scenario(key).dynamic else ()
        arrays = {each.name: getattr(found, each.name) for each in (*OUTCOMES, *traces)}
        return SimpleNamespace(run=numbers, **arrays)

    def record(self, key: str, first: int, runs: int, curves: bool = False) -> Record:
        """Return consecutive runs of a point, perhaps with curves; raise an error if some aren't there."""
        numbers, found = self._merged(key, self.records(key, first, first + runs, curves), curves)
        low, high = np.searchsorted(numbers, (first, first + runs)).tolist()
        if high - low != runs:
            lost = f"{runs - high + low} of {runs} runs were removed or damaged meanwhile"
            raise FeasibeeError(f"{self.folder}: {lost}; run the same command again")
        return replace(found.part(low, high), first_run=first)

    def records(self, key: str, first: int = 0, last: int = 2**63, curves: bool = False) -> Iterator[Record]:
        """Yield the undamaged chunks of a point with a run from ``first`` to before ``last``."""
        for chunk in list(self._chunks[key]):
            if chunk.first < last and chunk.last > first and (chunk.has_curves or not curves):
                found = chunk.held if isinstance(chunk.held, Record) else self._read(key, chunk)
                if found is not None:
                    yield found

    def _merged(self, key: str, records: Iterator[Record], curves: bool = False) -> tuple[Any, Record]:
        """Return runs in order, and their numbers; raise an error if a run is there twice and differs."""
        shown = (each if curves else each.without_curves() for each in records)
        parts = [self._room(key, 0, 0, curves), *shown]
        parts.sort(key=lambda each: each.first_run)
        twice: list[Record] = []
        for after in parts:
            twice = [each for each in twice if each.first_run + each.runs > after.first_run]
            for before in twice:
                self._agree(key, before, after)
            twice.append(after)
        numbers = np.concatenate([np.arange(each.first_run, each.first_run + each.runs) for each in parts])
        numbers, places = np.unique(numbers, return_index=True)
        return numbers, parts[0].followed_by(*parts[1:]).at(places)

    def _room(self, key: str, first: int, last: int, curves: bool) -> Record:
        """Return a record with room for runs of a point, perhaps with curves."""
        scenario = self._scenario(key)
        length = scenario.run.steps + 1
        return Record.empty(first, last - first, length * curves, length * scenario.dynamic)

    def _agree(self, key: str, one: Record, two: Record) -> None:
        for run, what, here, there in differences(one, two):
            name = next(each.name for each in self.points if each.key == key)
            raise FeasibeeError(
                f"{self.folder}: {name}, run {run}: {what} is {here} in one file and {there} in another, and "
                "only one can be right; sweep into an empty folder to see which, and remove the other"
            )

    def _scenario(self, key: str) -> Scenario:
        if key not in self._scenarios:
            about = self._about[key]
            tables, text = about["scenario"], about["source"]
            self._scenarios[key] = Scenario.from_tables(tables, source=text, trusted=False)
        return self._scenarios[key]

    # --- Writing ---

    def add(self, points: Sequence[DesignPoint], seed: int, until: StoppingRule | None = None) -> list[str]:
        """Add points that are new; return the keys of all of them."""
        return [self._add(point, seed, until) for point in points]

    def _add(self, point: DesignPoint, seed: int, until: StoppingRule | None) -> str:
        scenario, known = point.scenario, self._about
        key = key_of(scenario.hash, seed)
        last = next(reversed(known.values()), {"number": 0})  # points are in the order of their numbers
        before = known.get(key, {"number": last["number"] + 1})
        about = {
            **VERSIONS,
            "version": version("feasibee"),
            "hash": scenario.hash,
            "seed": str(seed),  # 64 bits, which numbers of JSON don't hold everywhere
            "source": scenario.manifest.source or None,
            **before,
            "values": json.loads(json.dumps(dict(point.values))),
            "until": before.get("until") if until is None else vars(until),
        }
        self._scenarios[key] = scenario
        if self.folder is not None and about != before:
            about["scenario"] = scenario.to_dict()
            text = json.dumps({**about, "digest": _digest_of(about)}, default=str)
            write_text(self._files / f"{key}.json", f"{text}\n")
        known[key] = about
        if self.folder is not None and key not in self._checked:
            self._checked.add(key)
            for _ in self.records(key):  # a file that is damaged is removed, and so missing
                pass
        return key

    def put(self, key: str, record: Record) -> None:
        """Add runs of a point."""
        curves = record.feasible_count.shape[1] > 0
        first, last = record.first_run, record.first_run + record.runs
        held: str | Record = record
        if self.folder is not None:
            data = _packed(record)
            held = f"{key}.{first}-{last - 1}{'.curves' * curves}.{_digest(data)}.npz"
            try:
                with atomic_write(self._files / held) as temporary:
                    temporary.write_bytes(data)
            except FeasibeeError as error:
                raise FeasibeeError(
                    f"{error}, and run the same command again: all runs so far are kept"
                ) from None
        self._chunks[key].append(Chunk(first, last, curves, held))

    # --- Files ---

    def _list(self) -> None:
        """Find what is there, by the names of the files; read the description of each point."""
        names = sorted(each.name for each in self._files.iterdir()) if self._files.is_dir() else []
        for name in names:
            if (found := CHUNK.fullmatch(name)) and int(found[2]) <= int(found[3]):
                chunk = Chunk(int(found[2]), int(found[3]) + 1, bool(found[4]), name)
                self._chunks[found[1]].append(chunk)
            elif re.fullmatch(r"[0-9a-f]{16}\.json", name) and (about := self._described(name)):
                self._about[name.removesuffix(".json")] = about
        self._about = dict(sorted(self._about.items(), key=lambda each: (each[1]["number"], each[0])))
        if not self._write and not self._about:
            raise FeasibeeError(f"{self.folder}: {self._lack()}")

    def _lack(self) -> str:
        """Return why a folder has nothing to read, and the remedy."""
        assert self.folder is not None
        if (self.folder / EARLIER).exists():
            return "has results of an earlier version; convert them with examples/convert_journal.py"
        rule = "has no results" if self.folder.is_dir() else "isn't a folder"
        return f"{rule}; name the folder of a sweep or study"

    def _described(self, name: str) -> dict[str, Any] | None:
        """Return the description of a point; None if it is damaged."""
        path = self._files / name
        with suppress(*UNREADABLE):
            about = json.loads(path.read_bytes())
            _check_versions(path, about)
            known = about.pop("digest") == _digest_of(about) and isinstance(about["number"], int)
            found = hash_of(about["scenario"], about["source"] or "")
            if known and about["hash"] == found and f"{key_of(found, int(about['seed']))}.json" == name:
                return dict(about)
        self._drop(name)
        return None

    def _read(self, key: str, chunk: Chunk) -> Record | None:
        """Return the runs of a file with as many steps as the scenario has; None if it is damaged."""
        name = str(chunk.held)
        with suppress(*UNREADABLE):
            data = (self._files / name).read_bytes()
            if _digest(data) == name.split(".")[-2]:
                return _unpacked(data, self._room(key, chunk.first, chunk.last, chunk.has_curves))
        self._chunks[key].remove(chunk)
        self._drop(name)
        return None

    def _drop(self, name: str) -> None:
        self.damaged.append(name)
        if self._write:
            with suppress(OSError):
                (self._files / name).unlink()


def key_of(scenario_hash: str, seed: int) -> str:
    """Return what the names of a point's files begin with."""
    return _digest(json.dumps([FORMAT, MODEL_VERSION, scenario_hash, str(seed)]).encode())


def differences(ours: Record, theirs: Record) -> Iterator[tuple[int, str, object, object]]:
    """Yield each run of both records that differs, the first outcome in which it does, and both values."""
    first = max(ours.first_run, theirs.first_run)
    last = min(ours.first_run + ours.runs, theirs.first_run + theirs.runs)
    one, two = (each.part(first - each.first_run, last - each.first_run) for each in (ours, theirs))
    for row in range(last - first):
        for outcome in (*OUTCOMES, *CURVES, *TRACES):
            here, there = getattr(one, outcome.name)[row], getattr(two, outcome.name)[row]
            if outcome in OUTCOMES and here != there:
                yield first + row, outcome.name, here, there
                break
            if outcome not in OUTCOMES and here.shape == there.shape and (here != there).any():
                step = np.flatnonzero(here != there)[0]
                yield first + row, f"{outcome.name} at step {step}", here[step], there[step]
                break


def _check_versions(path: Path, about: Mapping[str, Any]) -> None:
    for name, ours in VERSIONS.items():
        if isinstance(number := about[name], int) and number != ours:
            newer = "install the newer feasibee" if number > ours else "choose another folder"
            what = name.replace("_", " ")
            raise FeasibeeError(f"{path}: has {what} {number}, this feasibee has {ours}; {newer}")


def _packed(record: Record) -> bytes:
    table = np.empty(record.runs, TABLE)
    for each in OUTCOMES:
        table[each.name] = getattr(record, each.name)
    by_step = {each.name: getattr(record, each.name) for each in (*CURVES, *TRACES)}
    file = BytesIO()
    np.savez_compressed(file, runs=table, **{name: each for name, each in by_step.items() if each.shape[1]})
    return file.getvalue()


def _unpacked(data: bytes, record: Record) -> Record:
    """Fill a record with what is in a file; raise a ValueError unless the arrays are as large."""
    with np.load(BytesIO(data), allow_pickle=False) as file:
        table = file["runs"]
        if table.dtype != TABLE or table.shape != (record.runs,):
            raise ValueError("other runs than its name says")
        record.decision[:], record.decision_step[:] = table["decision"], table["decision_step"]
        for number, each in enumerate(ACCOUNT):
            record.account[:, number] = table[each.name]
        for each in (*CURVES, *TRACES):
            if (room := getattr(record, each.name)).shape[1]:
                values = file[each.name]
                if values.shape != room.shape or values.dtype.kind != "i":
                    raise ValueError(f"{each.name} of another shape")
                room[:] = values
    return record


def _digest(data: bytes) -> str:
    return blake2b(data, digest_size=8).hexdigest()


def _digest_of(about: Mapping[str, Any]) -> str:
    return _digest(json.dumps(about, sort_keys=True, default=str).encode())
