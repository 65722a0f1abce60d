"""Compile the engine: ``python -m feasibee.engine.build``; pip, the tests and ``make`` call it, too.

Standard library only, since pip builds the package without the packages that it needs when it runs. The one
exception is cffi, which writes down what engine.h declares.
"""

from __future__ import annotations

import argparse
import ast
import hashlib
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from contextlib import redirect_stdout
from pathlib import Path
from subprocess import PIPE, STDOUT
from typing import Final

from feasibee.base.errors import FeasibeeError
from feasibee.engine.compilers import COMPILER, Compiler, compiler, zig
from feasibee.engine.platforms import BINDING, LIBRARIES, WEBASSEMBLY, Platform, file_of, native, own_tag

PACKAGE: Final = Path(__file__).parent.parent
SOURCES: Final = PACKAGE / "engine" / "c"
AT_ONCE: Final = 2
"""Number of compilers that run at the same time: each may take 300 MB."""
FLAGS: Final = (
    *("-std=c11", "-O3", "-ffp-contract=off", "-fno-math-errno", "-fno-strict-aliasing", "-fno-sanitize=all"),
    *("-fvisibility=hidden", "-fPIC"),
)
"""No contraction and no fast mathematics: each operation rounds as in Python."""
SCALAR: Final = ("-fno-vectorize", "-fno-slp-vectorize")
SMALL: Final = ("-Os", "-DSMALL", *SCALAR, "-mllvm", "-disable-lsr")
SMALLEST: Final = (*SMALL, "-mllvm", "-inline-threshold=0", "-Xclang", "-Oz")
"""In addition for a module that pages load; knowledge would take thrice as long by the second."""
FOR_PAGES: Final = {
    "few": (*SCALAR, "-Os", "-mllvm", "-disable-lsr"),
    "strategies": SMALL,
    "own": (*SMALL, "-w", "-Dfeasibee_rules=feasibee_own_rules"),
}
"""Options of some sources of that module: few.c loses a tenth of its speed, and is 1.5 kB smaller."""
NATIVE: Final = ("crowd", "level")
"""Sources that it leaves out: the general engine plays larger swarms, and any processor can run it."""


MODULES: Final = ("build", "compilers", "generate", "params", "platforms")
"""The modules of this package that decide what is compiled."""
KINDS: Final = {
    "bool": "bool",
    "int": "int64_t",
    "float": "double",
    "np.uint32": "uint32_t",
    "np.uint64": "uint64_t",
}
"""Types of numbers in C, by those of ``params.py``."""


def sources() -> list[Path]:
    """Return the files that the libraries are made from."""
    own = [Path(__file__).with_name(f"{each}.py") for each in MODULES]
    translator = [each for name in ("robot", "strategies") for each in (PACKAGE / name).glob("*.py")]
    return sorted([*SOURCES.glob("*.[ch]"), *own, *translator])


def digest() -> str:
    """Return a hash of all that the libraries are made from, apart from the compiler."""
    made = hashlib.sha256()
    for path in sources():
        data = path.read_bytes()
        made.update(f"{path.relative_to(PACKAGE).as_posix()} {len(data)}\n".encode())
        made.update(data)
    return made.hexdigest()


def declarations() -> str:
    """Return all structs and functions without the lines of the preprocessor, which cffi can't read."""
    headers = [(SOURCES / each).read_text(encoding="utf-8") for each in ("engine.h", "state.h")]
    texts = [params_header(), *headers]
    return "\n".join(line for text in texts for line in text.splitlines() if not line.startswith("#"))


def params_header() -> str:
    """Return ``params.h``: the records of ``params.py`` as structs, from its text, since it imports numpy."""
    text = Path(__file__).with_name("params.py").read_text(encoding="utf-8")
    lines = ["#include <stdbool.h>", "#include <stdint.h>"]
    for record in ast.parse(text).body:
        if isinstance(record, ast.ClassDef) and ast.unparse(record.bases[0]) == "NamedTuple":
            fields = [each for each in record.body if isinstance(each, ast.AnnAssign)]
            kinds = {ast.unparse(each.target): _in_c(ast.unparse(each.annotation)) for each in fields}
            lines += ["", f"{_in_c(record.name)} {{", *(f"    {kinds[each]} {each};" for each in kinds), "};"]
    return "\n".join([*lines, ""])


def _in_c(kind: str) -> str:
    """Return a type of ``params.py`` in C: ``struct robot`` for ``RobotParams``."""
    return KINDS.get(kind) or f"struct {kind.removesuffix('Params').lower() or 'params'}"


def build(target: Platform | None = None, folder: Path = LIBRARIES, *, force: bool = False) -> list[Path]:
    """Compile the libraries of a platform, unless they are there, from these sources and by this compiler.

    Parameters
    ----------
    target : Platform, optional
        The platform; by default this machine's.
    folder : Path
        Where the libraries are.
    force : bool
        Whether to compile them in any case.

    Returns
    -------
    list of Path
        The files that the package needs: a library for each level, the lowest first, and the binding.

    Raises
    ------
    FeasibeeError
        If there is no compiler, or it fails.
    """
    target = target or native()
    stamp = folder / f"{target.tag}.stamp"
    made = digest()
    said, by, files = _read(stamp)
    current = said == made and not force and all(each.exists() for each in files)
    likely = zig()
    if current and likely and by == likely.name:
        return files  # without a trial of the compiler: 50 ms
    try:
        chosen = compiler()
    except FeasibeeError:
        if current:
            return files
        raise
    if not current or by != chosen.name:
        files = _build(target, folder, chosen)
        _write(stamp, "\n".join([made, chosen.name, *(each.name for each in files), ""]))
    return files


def _read(stamp: Path) -> tuple[str, str, list[Path]]:
    """Return the digest and the compiler of what was built, and its files; nothing if nothing was."""
    lines = stamp.read_text(encoding="utf-8").splitlines() if stamp.exists() else []
    made, by, *names = lines or ("", "")
    return made, by, [stamp.with_name(name) for name in names]


def _build(target: Platform, folder: Path, chosen: Compiler) -> list[Path]:
    folder.mkdir(parents=True, exist_ok=True)
    from feasibee.engine.generate import built_in_strategies  # 0.2 s

    _write(folder / "strategies.c", built_in_strategies())
    files = {level: folder / file_of(level, target) for level in chosen.known(target)}
    with ThreadPoolExecutor(AT_ONCE) as pool:
        jobs = [pool.submit(compile_library, file, target, level, chosen) for level, file in files.items()]
        for job in jobs:
            job.result()
    return [*files.values(), *([] if target is WEBASSEMBLY else [_bind(folder)])]


def tag_of(target: Platform, folder: Path) -> str:
    """Return the tag of a wheel with the libraries in a folder.

    Those that a system's compiler made run on such systems only, since they need its C library.
    """
    _, by, _ = _read(folder / f"{target.tag}.stamp")
    return target.tag if by.startswith("ziglang") else own_tag()


def compile_library(out: Path, target: Platform, level: str, by: Compiler, *more: str) -> None:
    """Compile all C, with the strategies that `build` wrote into its folder, into one library.

    For a page, ``own.c`` in that folder may be a user's.

    Parameters
    ----------
    out : Path
        The library.
    target : Platform
        What it is for.
    level : str
        Which instructions it may use.
    by : Compiler
        The compiler.
    *more : str
        Further options, such as those of a sanitizer.

    Raises
    ------
    FeasibeeError
        If the compiler fails.
    """
    own = list(out.parent.glob("own.c"))
    files = [*sorted(SOURCES.glob("*.c")), *out.parent.glob("strategies.c"), *own]
    if target is WEBASSEMBLY:
        files = [each for each in files if each.stem not in NATIVE]
    with tempfile.TemporaryDirectory(dir=out.parent) as name:
        _write(Path(name, "params.h"), params_header())
        compiling = [*by.options(target, level), *FLAGS, *more, "-c", "-I", ".", "-I", str(SOURCES)]
        for each in files:
            small = FOR_PAGES.get(each.stem, SMALLEST) if target is WEBASSEMBLY else ()
            _run(by, level, Path(name), *compiling, *small, str(each), "-o", f"{each.stem}.o")
        # Zig compiles system libraries for each level that it links for: so it links for one of them.
        lowest = by.options(target, next(iter(target.levels)))
        linking = [*(f"{each.stem}.o" for each in files), *by.linking(target, maths=bool(own))]
        _run(by, level, Path(name), *lowest, *more, "-o", out.name, *linking)
        Path(name, out.name).replace(out)  # programs that run the old one keep it


def _run(by: Compiler, level: str, folder: Path, *options: str) -> None:
    done = subprocess.run(
        [*by.command, *options], cwd=folder, stdout=PIPE, stderr=STDOUT, text=True, check=False
    )
    if done.returncode:
        said = next((line for line in done.stdout.splitlines() if "error:" in line), done.stdout[-300:])
        raise FeasibeeError(
            f"{by.name}: can't compile the engine for {level}: {said.strip()}; "
            f"set {COMPILER} to zig or cc to use another compiler, or report it"
        )


def _bind(folder: Path) -> Path:
    """Write what engine.h declares as a module that cffi reads quickly; return its path."""
    try:
        from cffi import FFI
    except ImportError:
        raise FeasibeeError(
            f"cffi: not installed, and the engine's header is read by it; "
            f"run: {sys.executable} -m pip install cffi"
        ) from None
    ffi = FFI()
    ffi.cdef(declarations())
    ffi.set_source("binding", None)
    path = folder / BINDING
    with tempfile.TemporaryDirectory(dir=folder) as name, redirect_stdout(None):  # it says what it does
        written = Path(name) / BINDING
        ffi.emit_python_code(str(written))
        written.replace(path)
    return path


def _write(path: Path, text: str) -> None:
    """Write a file that others may read at the same time."""
    with tempfile.TemporaryDirectory(dir=path.parent) as name:
        written = Path(name, path.name)
        written.write_text(text, encoding="utf-8")
        written.replace(path)


def main() -> None:
    """Compile what the command line says."""
    parser = argparse.ArgumentParser("python -m feasibee.engine.build", description="Compile the engine.")
    parser.add_argument("--force", action="store_true", help="compile what needs no compiling, too")
    parser.add_argument("--wasm", action="store_true", help="compile for WebAssembly, by ziglang")
    given = parser.parse_args()
    try:
        for path in build(WEBASSEMBLY if given.wasm else None, force=given.force):
            print(path)
    except FeasibeeError as error:
        sys.exit(str(error))


if __name__ == "__main__":
    main()
