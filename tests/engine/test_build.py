"""The engine is compiled when it must be, by the compiler that there is; errors say what to do."""

from __future__ import annotations

import importlib.util
import os
import platform
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from feasibee import FeasibeeError
from feasibee.engine import build, compilers, platforms
from feasibee.engine.compilers import COMPILER, Compiler

ROOT = Path(__file__).parents[2]
CC = Compiler(("cc",), "cc (a system) 12.2.0")
ON_WINDOWS = pytest.mark.skipif(os.name == "nt", reason="the programs are shell scripts")


@pytest.fixture(autouse=True)
def no_choice(monkeypatch):
    """Forget the compiler that was found, and what this machine's environment says of it."""
    monkeypatch.delenv(COMPILER, raising=False)
    compilers.compiler.cache_clear()
    yield
    compilers.compiler.cache_clear()


@pytest.fixture
def machine(tmp_path, monkeypatch):
    """A machine with no compiler; return a function that installs one, which runs or fails."""

    def install(name, runs=True):
        if name == "ziglang":
            (tmp_path / "ziglang").mkdir()
            (tmp_path / "ziglang" / "__init__.py").touch()
            (tmp_path / "ziglang" / "__main__.py").write_text(
                f"print('0.17.1')\nraise SystemExit({not runs:d})"
            )
            (tmp_path / "ziglang-0.17.1.dist-info").mkdir()
        else:
            program = tmp_path / "bin" / name
            program.write_text(f"#!/bin/sh\necho '{name} 12.2.0'\nexit {not runs:d}\n")
            program.chmod(0o755)

    (tmp_path / "bin").mkdir()
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))  # for `python -m ziglang`
    monkeypatch.setattr(
        compilers, "find_spec", lambda name: importlib.machinery.PathFinder.find_spec(name, [str(tmp_path)])
    )
    return install


@ON_WINDOWS
@pytest.mark.parametrize(
    ("installed", "wanted", "chosen", "said"),
    [
        ({"ziglang": True}, "", "ziglang 0.17.1", ""),
        ({"ziglang": True, "cc": True}, "", "ziglang 0.17.1", ""),
        ({"ziglang": True, "cc": True}, "cc", "cc 12.2.0", ""),
        ({"ziglang": False, "cc": True}, "", "cc 12.2.0", "ziglang does not run on this machine; "),
        ({"cc": True}, "", "cc 12.2.0", "ziglang is not installed; "),
        ({"cc": False, "clang": True}, "", "clang 12.2.0", "ziglang is not installed; "),
    ],
)
def test_the_compiler_is_ziglang_or_else_the_systems(
    machine, monkeypatch, capsys, installed, wanted, chosen, said
):
    for name, runs in installed.items():
        machine(name, runs)
    monkeypatch.setenv(COMPILER, wanted)
    assert compilers.compiler().name == chosen
    printed = capsys.readouterr().out
    assert said in printed
    assert printed.count("\n") == bool(said)


@ON_WINDOWS
@pytest.mark.parametrize(
    ("installed", "wanted", "said"),
    [
        ({}, "", "ziglang is not installed, and no cc, gcc or clang in PATH runs; run: "),
        ({"ziglang": False, "gcc": False}, "", "ziglang does not run, and no cc, gcc or clang in PATH runs"),
        ({"cc": True}, "zig", f"pip install {compilers.ZIGLANG}, or install gcc or clang"),
        ({"ziglang": True}, "cc", "no cc, gcc or clang in PATH runs"),
        ({"ziglang": True}, "gcc", f"{COMPILER} = 'gcc': must be zig or cc; unset it to use either"),
    ],
)
def test_without_a_compiler_an_error_names_both(machine, monkeypatch, installed, wanted, said):
    for name, runs in installed.items():
        machine(name, runs)
    monkeypatch.setenv(COMPILER, wanted)
    with pytest.raises(FeasibeeError) as error:
        compilers.compiler()
    assert said in str(error.value)


@pytest.mark.parametrize(
    ("system", "processor", "mac", "wanted", "offered"),
    [
        ("Linux", "x86_64", "", "", True),
        ("Linux", "loongarch64", "", "", False),
        ("Linux", "x86_64", "", "cc", False),
        ("Darwin", "arm64", "14.5", "", True),
        ("Darwin", "arm64", "12.7", "", False),
        ("Windows", "AMD64", "", "", True),
        ("FreeBSD", "amd64", "", "", False),
    ],
)
def test_pip_fetches_ziglang_where_it_has_wheels(monkeypatch, system, processor, mac, wanted, offered):
    monkeypatch.setattr(platform, "system", lambda: system)
    monkeypatch.setattr(platform, "machine", lambda: processor)
    monkeypatch.setattr(platform, "mac_ver", lambda: (mac, ("", "", ""), ""))
    monkeypatch.setenv(COMPILER, wanted)
    assert hook().dependencies() == [compilers.ZIGLANG] * offered


def test_ziglang_is_the_version_that_pages_are_made_with():
    assert f'"{compilers.ZIGLANG}"' in (ROOT / "pyproject.toml").read_text("utf-8")


@pytest.fixture
def compiled(monkeypatch):
    """Let cc be the compiler, and compiling take no time; return the list of what is compiled."""
    done = []

    def compile_library(out, target, level, by):
        out.touch()
        done.append((level, by.name))

    monkeypatch.setattr(build, "compile_library", compile_library)
    monkeypatch.setattr(build, "zig", lambda: None)
    monkeypatch.setattr(build, "compiler", lambda: CC)
    monkeypatch.setattr(Compiler, "known", lambda self, target: list(target.levels))
    return done


LINUX = platforms.PLATFORMS["linux-x86-64"]


def test_what_is_there_is_not_compiled_again(tmp_path, compiled):
    files = build.build(LINUX, tmp_path)
    assert [each.name for each in files] == [
        "feasibee-x86-64-v2.so",
        "feasibee-x86-64-v3.so",
        "feasibee-icelake-server.so",
        platforms.BINDING,
    ]
    assert all(each.exists() for each in files)
    assert len(compiled) == 3
    assert build.build(LINUX, tmp_path) == files
    assert len(compiled) == 3


def test_a_change_is_compiled(tmp_path, compiled, monkeypatch):
    """Of a file, of the compiler, and of what is there."""
    build.build(LINUX, tmp_path)
    monkeypatch.setattr(build, "compiler", lambda: CC._replace(name="cc 13"))
    build.build(LINUX, tmp_path)
    assert len(compiled) == 6
    (tmp_path / "feasibee-x86-64-v3.so").unlink()
    build.build(LINUX, tmp_path)
    assert len(compiled) == 9
    build.build(LINUX, tmp_path, force=True)
    assert len(compiled) == 12
    changed = tmp_path / "few.c"
    monkeypatch.setattr(build, "sources", lambda: [changed])
    monkeypatch.setattr(build, "PACKAGE", tmp_path)
    for text in ("int one;", "int two;"):
        changed.write_text(text)
        build.build(LINUX, tmp_path)
    assert len(compiled) == 18


def test_the_sources_are_all_c_and_what_writes_it():
    names = {path.relative_to(build.PACKAGE).as_posix() for path in build.sources()}
    assert {"engine/c/few.c", "engine/c/engine.h", "engine/generate.py", "engine/build.py"} < names
    assert {"strategies/dmmd.py", "robot/translate.py"} < names


def none():
    raise FeasibeeError("no compiler")


def test_what_is_there_needs_no_compiler(tmp_path, compiled, monkeypatch):
    files = build.build(LINUX, tmp_path)
    monkeypatch.setattr(build, "compiler", none)
    assert build.build(LINUX, tmp_path) == files
    with pytest.raises(FeasibeeError, match="no compiler"):
        build.build(LINUX, tmp_path / "other")


def test_an_error_of_the_compiler_is_said(tmp_path, monkeypatch):
    """With the first error, and the level; the sources that are right are left out, for they take 10 s."""
    monkeypatch.setattr(build, "SOURCES", tmp_path / "none")
    (tmp_path / "strategies.c").write_text("int broken(")
    found = compilers.zig() or compilers.system_compiler()
    target = platforms.native()
    level = next(iter(target.levels))
    with pytest.raises(
        FeasibeeError, match=rf"can't compile the engine for {level}: .*strategies\.c.*error: "
    ):
        build.compile_library(tmp_path / "out.so", target, level, found)
    assert [path.name for path in tmp_path.iterdir()] == ["strategies.c"]


@pytest.mark.parametrize("name", ["gcc", "clang"])
def test_c_is_compiled_without_a_warning(name, tmp_path):
    if shutil.which(name) is None:
        pytest.skip(f"no {name}")
    (tmp_path / "params.h").write_text(build.params_header())
    folders = (f"-I{build.SOURCES}", f"-I{tmp_path}")
    options = ("-std=c11", "-fsyntax-only", "-Wall", "-Wextra", "-Werror", *folders)
    for path in build.SOURCES.glob("*.c"):
        done = subprocess.run([name, *options, str(path)], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr


def hook():
    """Return hatchling's hook of this project."""
    pytest.importorskip("hatchling")
    spec = importlib.util.spec_from_file_location("hatch_build", ROOT / "hatch_build.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    made = module.Engine(str(ROOT), {}, None, None, "", "wheel")
    made.module = module
    return made


@pytest.mark.parametrize(
    ("by", "tag"), [("ziglang 0.17.1", "manylinux_2_17_x86_64"), ("cc 12", platforms.own_tag())]
)
def test_a_wheel_has_the_libraries_and_the_name_of_its_platform(tmp_path, monkeypatch, by, tag):
    """What a system's compiler made needs the C library of such a system."""
    made = hook()
    files = [tmp_path / "feasibee-x86-64-v2.so", tmp_path / platforms.BINDING]
    (tmp_path / f"{LINUX.tag}.stamp").write_text(f"digest\n{by}\n")
    monkeypatch.setattr(made.module, "build", lambda target, folder: files)
    monkeypatch.setattr(made.module, "native", lambda: LINUX)
    monkeypatch.setattr(made.module, "LIBRARIES", tmp_path)
    data = {"force_include": {}}
    made.initialize("standard", data)
    assert data == {
        "pure_python": False,
        "tag": f"py3-none-{tag}",
        "force_include": {str(each): f"feasibee/engine/lib/{each.name}" for each in files},
    }
    data = {"force_include": {}}
    made.initialize("editable", data)
    assert data == {"force_include": {}}


def test_a_wheel_of_another_platform_is_compiled_for_it(monkeypatch):
    made = hook()
    monkeypatch.setenv(made.module.PLATFORM, "macos-arm64")
    given = []
    monkeypatch.setattr(made.module, "build", lambda *arguments: given.append(arguments) or [])
    monkeypatch.setattr(made.module, "tag_of", lambda target, folder: target.tag)
    monkeypatch.setattr(made.module, "zig", lambda: True)
    data = {"force_include": {}}
    made.initialize("standard", data)
    wanted = platforms.PLATFORMS["macos-arm64"], platforms.WEBASSEMBLY
    assert given == [(each, ROOT / "build" / "macos-arm64") for each in wanted]
    assert data["tag"] == "py3-none-macosx_11_0_arm64"
    monkeypatch.setenv(made.module.PLATFORM, "amiga")
    with pytest.raises(FeasibeeError, match="FEASIBEE_PLATFORM = amiga: must be one of linux-x86-64, "):
        made.initialize("standard", data)


def test_the_command_says_what_it_compiled(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["build"])
    monkeypatch.setattr(build, "build", lambda target, force: [Path("a.so")])
    build.main()
    assert capsys.readouterr().out == "a.so\n"
    monkeypatch.setattr(build, "build", lambda target, force: none())
    with pytest.raises(SystemExit, match="no compiler"):
        build.main()
