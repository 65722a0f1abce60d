"""Compiled code is kept where only its owner writes; a damaged file is found, and never loaded."""

from __future__ import annotations

import os
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

from feasibee import FeasibeeError
from feasibee.base import cache
from feasibee.base.cache import own_folder, read_library, scratch_folder, write_library
from feasibee.cli.options import keep_matplotlib_in_cache

owned = pytest.mark.skipif(not hasattr(os, "geteuid"), reason="Windows tells access otherwise")
CODE = bytes(range(256)) * 20


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A cache of its own that has a library under the key "own"."""
    monkeypatch.setenv("FEASIBEE_CACHE", str(tmp_path / "cache"))
    cache._say_damaged.cache_clear()
    (tmp_path / "made.so").write_bytes(CODE)
    write_library(own_folder(tmp_path / "cache"), "own", tmp_path / "made.so")
    return tmp_path / "cache"


def library_of(folder):
    (path,) = folder.glob("*.so")
    return path


def test_a_library_is_found_again_under_its_key_only(folder):
    assert read_library(folder, "own").read_bytes() == CODE
    assert read_library(folder, "other") is None


@owned
def test_the_folder_and_its_files_are_private_whatever_the_umask(tmp_path):
    (tmp_path / "made.so").write_bytes(CODE)
    before = os.umask(0)
    try:
        folder = own_folder(tmp_path / "private")
        write_library(folder, "own", tmp_path / "made.so")
    finally:
        os.umask(before)
    assert oct(folder.stat().st_mode & 0o777) == "0o700"
    assert {oct(each.stat().st_mode & 0o777) for each in folder.iterdir()} == {"0o600"}


DAMAGES = {
    "emptied": lambda data: b"",
    "a byte short": lambda data: data[:-1],
    "a text": lambda data: b"<html>not found</html>",
    "a bit in the middle": lambda data: data[:2000] + bytes([data[2000] ^ 1 << 7]) + data[2001:],
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_file_is_never_loaded(folder, capfd, damage):
    place = library_of(folder)
    place.write_bytes(DAMAGES[damage](place.read_bytes()))
    assert read_library(folder, "own") is None
    assert read_library(folder, "own") is None
    said = capfd.readouterr().err.splitlines()
    assert said == [f"feasibee: {folder}: compiled code is damaged; compiling it again ..."]


@owned
@pytest.mark.parametrize("mode", [0o720, 0o1777])
@pytest.mark.parametrize("which", [lambda folder: folder, library_of])
def test_what_others_can_write_is_not_loaded(folder, which, mode):
    place = which(folder)
    place.chmod(mode)
    with pytest.raises(FeasibeeError) as told:
        read_library(own_folder(folder), "own")
    assert str(told.value) == (
        f"FEASIBEE_CACHE = {place}: can be written by others, and feasibee would run compiled code from it; "
        f"run chmod go-w on it, or name a folder of your own, such as FEASIBEE_CACHE=~/feasibee-cache"
    )


@owned
@pytest.mark.parametrize("which", [lambda folder: folder, library_of])
def test_what_belongs_to_somebody_else_is_not_loaded_unless_that_is_root(folder, monkeypatch, which):
    """As in a container's image that root made, and another user runs."""
    place, owner = which(folder), os.geteuid()
    monkeypatch.setattr(os, "geteuid", lambda: owner + 1)
    monkeypatch.setattr(cache, "ROOT", owner)
    assert read_library(own_folder(folder), "own")
    monkeypatch.setattr(cache, "ROOT", owner + 2)
    with pytest.raises(FeasibeeError, match=rf"belongs to user {owner}, .*; run chown -R root"):
        read_library(own_folder(folder), "own")
    place.chmod(0o722)
    monkeypatch.setattr(cache, "ROOT", owner)
    with pytest.raises(FeasibeeError, match="can be written by others"):
        read_library(own_folder(folder), "own")


@owned
def test_a_link_is_as_good_as_what_it_leads_to(tmp_path):
    there, link = tmp_path / "there", tmp_path / "link"
    there.mkdir(0o700)
    link.symlink_to(there)
    assert own_folder(link) == there  # the link may lead elsewhere later
    there.chmod(0o777)
    with pytest.raises(FeasibeeError, match=f"{there}: can be written by others"):
        own_folder(link)
    link.unlink()
    link.symlink_to(tmp_path / "missing")
    assert own_folder(link) == tmp_path / "missing"
    assert oct((tmp_path / "missing").stat().st_mode & 0o777) == "0o700"


def test_a_folder_that_cant_be_is_told(tmp_path):
    """As in a container whose user has no home."""
    (tmp_path / "file").touch()
    for path in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(FeasibeeError, match=r"^FEASIBEE_CACHE = .*: can't be written: .*; name a folder"):
            own_folder(path)
    with pytest.raises(FeasibeeError, match=r"^FEASIBEE_CACHE = .*: can't be written: .*; name a folder"):
        scratch_folder(tmp_path / "file")


@owned
def test_matplotlib_doesnt_make_the_folder_with_rights_for_others(tmp_path, monkeypatch):
    monkeypatch.setenv("FEASIBEE_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("MPLCONFIGDIR", "the user's")
    monkeypatch.delenv("MPLCONFIGDIR")
    before = os.umask(0)
    try:
        keep_matplotlib_in_cache()
    finally:
        os.umask(before)
    assert os.environ["MPLCONFIGDIR"] == str(tmp_path / "cache" / "matplotlib")
    assert oct((tmp_path / "cache").stat().st_mode & 0o777) == "0o700"


def test_readers_and_writers_of_one_file_meet_whole_contents_only(folder, tmp_path):
    stop, place = threading.Event(), library_of(folder)

    def write():
        while not stop.is_set():
            write_library(folder, "own", tmp_path / "made.so")

    with ThreadPoolExecutor(3) as pool:
        for _ in range(3):
            pool.submit(write)
        try:
            assert {read_library(folder, "own") for _ in range(300)} == {place}
        finally:
            stop.set()
    assert [each.name for each in folder.iterdir()] == [place.name]
