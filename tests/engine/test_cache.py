"""Compiled code is kept where only its owner writes; a damaged file is compiled again, and never runs."""

from __future__ import annotations

import dataclasses
import os
import pickle
import subprocess
import sys
import threading
import types
from concurrent.futures import ThreadPoolExecutor
from importlib.util import find_spec
from pathlib import Path

import pytest
from feasibee.engine.compile import cache_folder, careful, entry, export, on_compile

from feasibee import FeasibeeError
from feasibee.cli.options import keep_matplotlib_in_cache
from feasibee.engine import compile as compile_
from feasibee.engine import compiled as general
from feasibee.files import cache
from feasibee.files.cache import check_cache, own_folder, read_sealed, write_sealed
from feasibee.strategies import STRATEGIES

owned = pytest.mark.skipif(not hasattr(os, "geteuid"), reason="Windows tells access otherwise")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A cache of its own, empty."""
    monkeypatch.setenv("FEASIBEE_CACHE", str(tmp_path / "cache"))
    forget()
    yield tmp_path / "cache"
    forget()


def forget():
    for each in (check_cache, cache_folder, cache._say_damaged):
        each.cache_clear()


def double(number):
    return 2 * number


def compiled(function=double, **options):
    return entry("int64(int64)", **options)(function)


def kept(name="double"):
    (path,) = cache_folder().glob(f"{name}-*.nbc")
    return path


def test_compiled_code_is_kept_and_found_again(folder, monkeypatch):
    assert compiled()(21) == 42
    monkeypatch.setattr(compile_, "write_sealed", None)  # it would be called if it were compiled
    assert compiled()(21) == 42


def test_what_is_compiled_is_told_and_what_is_found_is_not(folder):
    told = []
    token = on_compile.set(told.append)
    try:
        compiled()
        compiled()
        assert told == ["double"]
        entry("float64(float64)")(double)
        assert told == ["double"] * 2
        kept_files = list(cache_folder().glob("double-*.nbc"))
        assert len(kept_files) == 2
        for path in kept_files:
            path.write_bytes(b"")
        compiled()
        assert told == ["double"] * 3
    finally:
        on_compile.reset(token)


def test_what_differs_has_a_file_of_its_own(folder):
    def triple(number):
        return 3 * number

    def times(factor):
        def product(number):
            return factor * number

        return product

    assert [compiled(triple, text=text)(5) for text in ("", "a file", "another")] == [15] * 3
    assert [compiled(times(3))(5), compiled(times(4))(5), compiled(times(3))(5)] == [15, 20, 15]
    assert entry("float64(float64)")(triple)(0.5) == 1.5
    assert len(list(cache_folder().glob("triple-*.nbc"))) == 4
    assert len(list(cache_folder().glob("product-*.nbc"))) == 2


def test_a_function_of_a_user_raises_what_python_would(folder):
    def inverse(number):
        return 1 // number

    with pytest.raises(ZeroDivisionError):
        compiled(inverse, text="a file")(0)
    assert compiled(inverse)(0) == 0


def test_a_function_may_call_itself(folder):
    def factorial(number):
        if number < 2:
            return 1
        return number * factorial(number - 1)

    assert compiled(factorial)(5) == 120


def test_numbas_own_folder_stays_the_users(folder, tmp_path, monkeypatch):
    monkeypatch.setattr(compile_.numba.config, "CACHE_DIR", str(tmp_path / "numba"))
    assert compiled()(1) == 2
    assert not (tmp_path / "numba").exists()
    assert kept().parent == cache_folder()


def test_the_folder_is_named_by_every_module_that_the_engine_imports():
    """A change of any of them compiles the engine again; the text of a strategy names its own files."""
    code = (
        "import sys, feasibee.engine.compiled; print(*(each for each in sys.modules if 'feasibee' in each))"
    )
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    files = {Path(find_spec(each).origin) for each in loaded.stdout.split()}
    faces = {each for each in files if each.name == "__init__.py"}
    strategies = {each for each in files if each.parent.name == "strategies" and each.name != "contract.py"}
    found = set(compile_.sources())
    assert found <= files
    handed_on = {each for each in files if each.parent.name == "files"}  # loaded by its face, not used
    assert files - faces - strategies - found <= handed_on
    assert {"codes.py", "purposes.py", "contract.py", "params.py"} <= {
        each.name for each in compile_.sources()
    }


def test_a_change_of_a_source_has_a_folder_of_its_own(folder, monkeypatch, tmp_path):
    before = cache_folder()
    changed = tmp_path / "feasibee" / "model" / "codes.py"
    changed.parent.mkdir(parents=True)
    changed.write_text("LONGEST = 1\n")
    monkeypatch.setattr(compile_, "PACKAGE", tmp_path / "feasibee")
    monkeypatch.setattr(compile_, "sources", lambda: [changed])
    cache_folder.cache_clear()
    first = cache_folder()
    changed.write_text("LONGEST = 2\n")
    cache_folder.cache_clear()
    assert len({before, first, cache_folder()}) == 3


@owned
def test_the_folder_and_its_files_are_private_whatever_the_umask(folder):
    before = os.umask(0)
    try:
        compiled()
    finally:
        os.umask(before)
    assert {oct(path.stat().st_mode & 0o777) for path in (folder, cache_folder())} == {"0o700"}
    assert oct(kept().stat().st_mode & 0o777) == "0o600"


DAMAGES = {
    "emptied": lambda data: b"",
    "one byte left": lambda data: data[:1],
    "no more than the seal": lambda data: data[: cache.SEAL],
    "halved": lambda data: data[: len(data) // 2],
    "a byte short": lambda data: data[:-1],
    "a byte long": lambda data: data + b"\0",
    "zeros": lambda data: bytes(len(data)),
    "a text": lambda data: b"<html>not found</html>",
    **{
        f"bit {bit}, {place}/8 through": lambda data, place=place, bit=bit: flipped(data, place / 8, bit)
        for place in range(9)
        for bit in (0, 7)
    },
}


def flipped(data, share, bit):
    place = int(share * (len(data) - 1))
    return data[:place] + bytes([data[place] ^ 1 << bit]) + data[place + 1 :]


@pytest.mark.quick(6)
@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_file_is_compiled_again_and_a_line_says_so(folder, capfd, damage):
    compiled()
    whole = kept().read_bytes()
    kept().write_bytes(DAMAGES[damage](whole))
    assert compiled()(21) == 42
    assert read_sealed(kept()) is not None
    assert compiled()(21) == 42
    assert capfd.readouterr().err.splitlines() == [
        f"feasibee: {cache_folder()}: compiled code is damaged; compiling it again, up to 20 s ..."
    ]


def test_many_damaged_files_are_one_line(folder, capfd):
    def add_one(number):
        return number + 1

    def add_two(number):
        return number + 2

    for function in (add_one, add_two):
        compiled(function)
        kept(function.__name__).write_bytes(b"")
    assert (compiled(add_one)(1), compiled(add_two)(1)) == (2, 3)
    assert capfd.readouterr().err.count("\n") == 1


class Poison:
    """Runs a command when it is unpickled."""

    def __init__(self, command):
        self.command = command

    def __reduce__(self):
        return os.system, (self.command,)


def poison(path):
    return pickle.dumps(Poison(f"touch {path}"))


def test_a_poisoned_file_is_dropped_and_never_run(folder, tmp_path):
    pickle.loads(poison(tmp_path / "works"))
    assert (tmp_path / "works").exists()
    compiled()
    seal = kept().read_bytes()[: cache.SEAL]
    for text in (poison(tmp_path / "ran"), seal + poison(tmp_path / "ran")):
        kept().write_bytes(text)
        assert compiled()(21) == 42
    for path in (kept().with_suffix(".nbi"), cache_folder() / "double-0.nbc"):
        path.write_bytes(poison(tmp_path / "ran"))
        assert compiled()(21) == 42
    assert not (tmp_path / "ran").exists()


def poisoned(tmp_path):
    """Put a file in the cache that others may have written: sealed well, but not ours."""
    compiled()
    write_sealed(kept(), poison(tmp_path / "ran"))
    cache_folder.cache_clear()


def placed(which, folder):
    """Return the root, the folder or the file of the cache."""
    return {"root": folder, "folder": cache_folder(), "file": kept()}[which]


@pytest.mark.quick(4)
@owned
@pytest.mark.parametrize("mode", [0o770, 0o707, 0o777, 0o1777, 0o720])
@pytest.mark.parametrize("which", ["root", "folder", "file"])
def test_what_others_can_write_is_refused(folder, tmp_path, which, mode):
    poisoned(tmp_path)
    place = placed(which, folder)
    forget()
    place.chmod(mode)
    line = (
        f"FEASIBEE_CACHE = {place}: can be written by others, and feasibee would run compiled code from it; "
        f"run chmod go-w on it, or name a folder of your own, such as FEASIBEE_CACHE=~/feasibee-cache"
    )
    for look in (compiled, check_cache) if which == "root" else (compiled,):
        with pytest.raises(FeasibeeError) as told:
            look()
        assert str(told.value) == line
    assert not (tmp_path / "ran").exists()


@owned
@pytest.mark.parametrize("which", ["root", "folder", "file"])
def test_what_belongs_to_somebody_else_is_refused(folder, tmp_path, monkeypatch, which):
    poisoned(tmp_path)
    place = placed(which, folder)
    cache_folder.cache_clear()
    if os.geteuid() == 0:
        os.chown(place, 12345, 12345)
        owner = 12345
    else:
        owner = os.geteuid()
        monkeypatch.setattr(os, "geteuid", lambda: owner + 1)
    with pytest.raises(
        FeasibeeError,
        match=rf"belongs to user {owner}, and .* would run compiled code from it; run chown -R root",
    ):
        compiled()
    assert not (tmp_path / "ran").exists()


@owned
def test_what_belongs_to_root_is_used_but_not_if_others_can_write_it(folder, monkeypatch):
    """As in a container's image that root made, and another user runs."""
    compiled()
    cache_folder.cache_clear()
    monkeypatch.setattr(cache, "ROOT", os.geteuid())
    monkeypatch.setattr(os, "geteuid", lambda: 12345)
    assert compiled()(21) == 42
    kept().chmod(0o622)
    with pytest.raises(FeasibeeError, match="can be written by others"):
        compiled()


def test_a_folder_that_cant_be_written_serves_what_it_has(folder, monkeypatch):
    """An error says that something is missing before it is compiled, not after."""

    def fail():
        raise FeasibeeError("can't be written")

    compiled()
    monkeypatch.setattr(compile_, "check_cache", fail)
    monkeypatch.setattr(compile_, "write_sealed", None)
    assert compiled()(21) == 42
    token = on_compile.set(pytest.fail)
    try:
        with pytest.raises(FeasibeeError, match="can't be written"):
            entry("float64(float64)")(double)
    finally:
        on_compile.reset(token)


@owned
def test_code_is_written_to_a_folder_for_all_to_read(folder, tmp_path, monkeypatch):
    compiled()
    before = os.umask(0o077)
    try:
        there = export(tmp_path / "there")
    finally:
        os.umask(before)
    assert [oct(each.stat().st_mode & 0o777) for each in (there.parent, there)] == ["0o755"] * 2
    assert [each.name for each in there.iterdir()] == [kept().name]
    assert oct((there / kept().name).stat().st_mode & 0o777) == "0o644"
    monkeypatch.setenv("FEASIBEE_CACHE", str(tmp_path / "there"))
    forget()
    monkeypatch.setattr(compile_, "write_sealed", None)
    assert compiled()(21) == 42


@owned
def test_code_isnt_written_to_a_folder_that_others_can_write(folder, tmp_path):
    compiled()
    (tmp_path / "there").mkdir()
    (tmp_path / "there").chmod(0o777)
    with pytest.raises(
        FeasibeeError, match=r"^--out = .*: can be written by others, .*; run chmod go-w on it, or"
    ):
        export(tmp_path / "there")


def test_code_that_is_gone_isnt_written(folder, tmp_path):
    compiled()
    kept().unlink()
    with pytest.raises(FeasibeeError, match=r"double-.*: the file was deleted or damaged; run"):
        export(tmp_path / "there")


@owned
def test_a_link_is_as_good_as_what_it_leads_to(folder, tmp_path):
    there = tmp_path / "there"
    there.mkdir(0o700)
    folder.symlink_to(there)
    assert own_folder(folder) == there  # the link may lead elsewhere later
    there.chmod(0o777)
    with pytest.raises(FeasibeeError, match=f"{there}: can be written by others"):
        own_folder(folder)
    folder.unlink()
    folder.symlink_to(tmp_path / "missing")
    assert own_folder(folder) == tmp_path / "missing"
    assert oct((tmp_path / "missing").stat().st_mode & 0o777) == "0o700"


def test_a_folder_that_cant_be_is_told(folder, tmp_path):
    """As in a container whose user has no home."""
    folder.touch()
    for path in (folder, folder / "below"):
        with pytest.raises(FeasibeeError, match=r"^FEASIBEE_CACHE = .*: can't be written: .*; name a folder"):
            own_folder(path)
    with pytest.raises(FeasibeeError, match=r"^FEASIBEE_CACHE = .*: can't be written: .*; name a folder"):
        check_cache()


@owned
def test_matplotlib_doesnt_make_the_folder_with_rights_for_others(folder, monkeypatch):
    monkeypatch.setenv("MPLCONFIGDIR", "the user's")
    monkeypatch.delenv("MPLCONFIGDIR")
    before = os.umask(0)
    try:
        keep_matplotlib_in_cache()
    finally:
        os.umask(before)
    assert os.environ["MPLCONFIGDIR"] == str(folder / "matplotlib")
    assert oct(folder.stat().st_mode & 0o777) == "0o700"


def test_readers_and_writers_of_one_file_meet_whole_contents_only(folder):
    path = own_folder(folder) / "double-0.nbc"
    contents = [bytes([number]) * 200_000 for number in range(4)]
    write_sealed(path, contents[0])
    stop = threading.Event()

    def write(content):
        while not stop.is_set():
            write_sealed(path, content)

    with ThreadPoolExecutor(4) as pool:
        for content in contents:
            pool.submit(write, content)
        try:
            assert {read_sealed(path) for _ in range(300)} <= set(contents)
        finally:
            stop.set()
    assert [each.name for each in folder.iterdir()] == [path.name]


PROGRAM = """
import sys, types
from feasibee.engine.compile import entry
module = sys.modules["{name}"] = types.ModuleType("{name}")
exec("def double(number):\\n    return 2 * number", module.__dict__)
print(entry("int64(int64)", text="a text")(module.double)(21))
"""


def begin(name="here"):
    """Start a process that compiles a function of a module, or finds it compiled."""
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    return subprocess.Popen([sys.executable, "-c", PROGRAM.format(name=name)], **options)


@pytest.mark.slow
def test_the_same_text_in_another_module_is_compiled_for_it(folder):
    """Code that is loaded looks up the module that it was compiled in; the first one is missing here."""
    assert begin("here").communicate() == ("42\n", "")
    assert begin("there").communicate() == ("42\n", "")


@pytest.mark.slow
def test_processes_that_compile_at_once_or_find_damage_at_once_all_end_right(folder):
    def run_all():
        return [each.communicate() for each in [begin() for _ in range(3)]]

    assert run_all() == [("42\n", "")] * 3
    kept().write_bytes(kept().read_bytes()[:500])
    answers = run_all()
    assert [out for out, _ in answers] == ["42\n"] * 3
    assert "compiled code is damaged" in "".join(err for _, err in answers)
    assert run_all() == [("42\n", "")] * 3


@pytest.mark.slow
def test_the_engine_survives_damage_to_each_of_its_files(folder):
    def run():
        command = [
            sys.executable,
            "-m",
            "feasibee",
            "run",
            "--runs",
            "20",
            "--json",
            "--set",
            "radio.loss=0.1",
        ]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        return done.stdout, done.stderr

    expected, said = run()
    assert "compiling the general engine" in said
    assert run() == (expected, "")
    (inner,) = folder.iterdir()
    files = sorted(inner.glob("*.nbc"))
    assert {path.name.split("-")[0] for path in files} >= {
        "play",
        "start_general",
        "advance_general_few_1",
        "say",
    }
    for path in files:
        data = path.read_bytes()
        path.write_bytes(flipped(data, 0.5, 3))
    answer, said = run()
    assert answer == expected
    damaged, compiling = said.splitlines()
    assert "compiled code is damaged" in damaged
    assert "compiling the general engine" in compiling
    assert run() == (expected, "")


PRINTING = """
def shown(number):
    print(number)
    return number

def double(number):
    return 2 * shown(number)
"""


def test_a_function_that_is_called_may_print(folder, capfd):
    """It needs what numba calls its environment, which isn't set for a function that is only linked in."""
    module = sys.modules["printing"] = types.ModuleType("printing")
    exec(PRINTING, module.__dict__)
    module.shown = careful(module.shown)
    assert compiled(module.double, text="a text")(21) == 42
    assert compiled(module.double, text="a text")(21) == 42
    assert capfd.readouterr().out == "21\n21\n"


def test_code_that_a_process_has_loaded_is_not_kept_as_that_of_a_file_changed_since(tmp_path):
    """Otherwise an update during a run would leave the old code on disk, under the new text."""
    file = tmp_path / "own.py"
    file.write_text("def quality(robots, tasks):\n    return robots / (robots + tasks)\n")

    def text(body):
        names = {}
        exec(compile(f"def quality(robots, tasks):\n    return {body}\n", file, "exec"), names)
        functions = {"functions": frozenset({"quality"}), "quality": names["quality"]}
        return general._text_of(dataclasses.replace(STRATEGIES["dmmd"], **functions))

    assert text("robots / (robots + tasks)") == text("robots / (robots + tasks)")
    assert text("robots / (robots + tasks)") != text("tasks / (robots + tasks)")
