"""Files are whole or not there."""

from __future__ import annotations

import csv
import errno
import os
import stat
import tracemalloc

import pandas as pd
import pytest

from feasibee import FeasibeeError, Scenario
from feasibee.base.files import (
    TABLE_LIMIT,
    TEXT_LIMIT,
    UnreadableError,
    atomic_write,
    make_folder,
    read_text,
    write_table,
)
from feasibee.simulation import table


def names(folder):
    return sorted(path.name for path in folder.iterdir())


@pytest.fixture
def umask():
    """Give the means to set the umask, and put the old one back."""
    before = os.umask(0o022)
    yield os.umask
    os.umask(before)


@pytest.mark.parametrize("old", [None, "old"])
def test_a_file_appears_whole_with_its_name(tmp_path, old):
    target = tmp_path / "data.csv"
    if old is not None:
        target.write_text(old)
    with atomic_write(target if old is None else str(target)) as temporary:
        temporary.write_text("half")
        assert (target.read_text() if target.exists() else None) == old
        assert (temporary.parent, temporary.suffix) == (tmp_path, ".csv")
        temporary.write_text("whole")
    assert target.read_text() == "whole"
    assert names(tmp_path) == ["data.csv"]


def write_half(target, error):
    with atomic_write(target) as temporary:
        temporary.write_text("half")
        raise error


FULL = OSError(errno.ENOSPC, "No space left on device")


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt, FULL])
@pytest.mark.parametrize("old", [None, "old"])
def test_an_error_or_interruption_leaves_what_was_there(tmp_path, error, old):
    """A full disk is an error of feasibee."""
    target = tmp_path / "data.csv"
    if old is not None:
        target.write_text(old)
    expected = (FeasibeeError, r"data\.csv: .*No space left") if error is FULL else (error, None)
    with pytest.raises(expected[0], match=expected[1]):
        write_half(target, error)
    assert names(tmp_path) == ([] if old is None else ["data.csv"])
    assert old is None or target.read_text() == old


@pytest.mark.parametrize(("mask", "mode"), [(0o027, 0o640), (0, 0o666)])
def test_permissions_follow_the_umask(tmp_path, umask, mask, mode):
    umask(mask)
    with atomic_write(tmp_path / "data.csv") as temporary:
        temporary.write_text("whole")
    assert stat.S_IMODE((tmp_path / "data.csv").stat().st_mode) == mode
    assert umask(0o022) == mask


@pytest.mark.parametrize(
    ("path", "why"),
    [("missing/data.csv", "No such file.*folder"), ("file/data.csv", "Not a dir"), ("data", "isn't a plain")],
)
def test_where_no_file_can_be_is_told_and_all_stays(tmp_path, path, why):
    (tmp_path / "file").write_text("old")
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "inside").write_text("old")
    with pytest.raises(FeasibeeError, match=f"{path}: .*{why}"), atomic_write(tmp_path / path):
        pytest.fail("there is nothing to write to")
    assert (names(tmp_path), names(tmp_path / "data")) == (["data", "file"], ["inside"])


def test_a_folder_is_made_with_those_above_it_and_may_be_there_but_no_file(tmp_path):
    folder = make_folder(tmp_path / "a" / "b")
    (folder / "inside").write_text("old")
    assert make_folder(str(folder)) == folder == tmp_path / "a" / "b"
    for path in (folder / "inside", folder / "inside" / "below"):
        with pytest.raises(FeasibeeError, match=r"inside.*: can't be created: .*; name a folder in one that"):
            make_folder(path)
    assert (folder / "inside").read_text() == "old"


# --- What a user names, read ---


def why(path, **options):
    with pytest.raises(UnreadableError, match="can't be read") as caught:
        read_text(path, "a scenario in TOML", **options)
    assert "\n" not in str(caught.value)
    assert str(caught.value).endswith("; name a scenario in TOML")
    return caught.value.why


def test_text_comes_with_newlines_and_without_a_mark_of_its_order(tmp_path):
    (tmp_path / "a.toml").write_bytes(b"\xef\xbb\xbfone\r\ntwo\rthree\n")
    assert read_text(tmp_path / "a.toml", "a file") == "one\ntwo\nthree\n"


def test_a_device_or_pipe_is_never_opened_which_would_wait(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to("pipe")
    for path in ("/dev/zero", "/dev/null", tmp_path / "pipe", tmp_path / "link"):
        assert why(path) == "it isn't a plain file"


def test_a_file_has_as_many_bytes_as_allowed_and_no_more(tmp_path):
    """A sparse file of a terabyte takes no memory."""
    path = tmp_path / "large.toml"
    path.write_bytes(b" " * TEXT_LIMIT)
    assert len(read_text(path, "a file")) == TEXT_LIMIT
    path.write_bytes(b" " * (TEXT_LIMIT + 1))
    assert len(read_text(path, "a file", TABLE_LIMIT)) == TEXT_LIMIT + 1
    os.truncate(path, 2**40)
    tracemalloc.start()
    assert why(path) == "it is larger than 1 MiB"
    assert tracemalloc.get_traced_memory()[1] < 8 * TEXT_LIMIT
    tracemalloc.stop()
    with pytest.raises(FeasibeeError, match=r"1 MiB; name one that names a CSV file for its points"):
        Scenario.read(path)
    with pytest.raises(FeasibeeError, match=r"No such file or directory; name a scenario in TOML$"):
        Scenario.read(tmp_path / "none.toml")


@pytest.mark.parametrize(
    ("data", "rule"),
    [(b"\xff", "it isn't UTF-8 text"), (b"a\0b", "it contains a NUL character, so it isn't text")],
)
def test_what_isnt_text_is_refused(tmp_path, data, rule):
    (tmp_path / "data").write_bytes(data)
    assert why(tmp_path / "data") == rule


@pytest.mark.parametrize("name", ["a\0b", "\ud800", "x" * 5000, "loop", ".", "file/below", "none"])
def test_a_name_that_no_file_can_have_is_refused(tmp_path, name):
    (tmp_path / "loop").symlink_to("loop")
    (tmp_path / "file").touch()
    assert why(tmp_path / name)


@pytest.mark.parametrize("name", ["=1+1.py", "+1.py", "-a", "@sum(a1)", "\ta", "\n=1", "\uff1d1+1"])
def test_a_spreadsheet_computes_no_name_in_a_csv(tmp_path, name):
    write_table(tmp_path / "data.csv", [{name: name, "left": -1.5, "right": "-1.5"}])
    with (tmp_path / "data.csv").open(newline="", encoding="utf-8") as file:
        assert list(csv.reader(file)) == [[f"'{name}", "left", "right"], [f"'{name}", "-1.5", "-1.5"]]


@pytest.mark.parametrize(
    ("name", "written"),
    [("dmmd", "dmmd"), ("", '""'), (" =1", " =1"), ("caf\udce9.py", r"caf\udce9.py"), ("a\r=1", r"a\r=1")],
)
def test_any_other_name_stands_in_a_csv_as_it_is_or_with_an_escape(tmp_path, name, written):
    write_table(tmp_path / "data.csv", [{"name": name}])
    assert (tmp_path / "data.csv").read_text() == f"name\n{written}\n"


def test_a_spreadsheet_computes_no_name_in_the_export_of_a_sweep(tmp_path, monkeypatch):
    runs = pd.DataFrame({"decision.strategy": ["=1+1.py", "dmmd"], "seed": [1, 2]})
    monkeypatch.setattr(table, "to_dataframe", lambda journal: runs)
    assert table.export(None, tmp_path / "runs.csv") == 2
    assert (tmp_path / "runs.csv").read_text() == "decision.strategy,seed\n'=1+1.py,1\ndmmd,2\n"
