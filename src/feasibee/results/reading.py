"""Read a NetCDF file in a process of its own, with limits of time and memory.

HDF5 loops forever in some damaged files. No signal handler of Python runs meanwhile, so only another process
can end it. This module imports no xarray: the process starts with each file that is opened.
"""

from __future__ import annotations

import faulthandler
import math
import os
import pickle
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any

LIMIT_S = 10
"""Largest time to read the structure of a file, in seconds; the values have as much, and more by size."""
LEAST_RATE = 20e6
"""Least number of bytes of values that are read per second."""
MOST_GIB = 20
"""Largest size of results that are opened, in GiB: two curves of the largest size, and the rest."""
MOST_PACKED = 1100
"""Largest size of values per byte of their file: zlib packs at most 1,032 bytes into one."""
SPARE = 2 << 30
"""Memory that HDF5 may use in addition to the values, in bytes."""


@contextmanager
def reading(path: str | Path) -> Iterator[Iterator[Any]]:
    """Start to read a file in another process, which ends with the block.

    Yields
    ------
    iterator
        The attributes of the file, then the name of each variable with its dimensions, values and attributes.
        It raises a ValueError if the file can't be read.
    """
    # Isolated, with the paths of this process: another module of the same name could lie in the folder.
    code = f"import sys; sys.path[:] = {sys.path!r}; from feasibee.results import reading; reading.main()"
    with subprocess.Popen(
        [sys.executable, "-I", "-c", code, os.path.abspath(path), str(LIMIT_S)],  # noqa: PTH100 - no address
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,  # HDF5 prints its own tracebacks
    ) as process:
        try:
            assert process.stdout is not None
            yield _parts(process.stdout)
        finally:
            process.kill()


def _parts(stream: IO[bytes]) -> Iterator[Any]:
    """Yield what the other process sends until it sends None."""
    while True:
        try:
            part = pickle.load(stream)
        except (EOFError, pickle.UnpicklingError):
            raise ValueError(f"HDF5 crashed, or was stopped after {LIMIT_S} s or more") from None
        if part is None:
            return
        if isinstance(part, str):
            raise ValueError(part)
        yield part


def main() -> None:
    """Send the parts of a file within a limit in seconds, or one line on why it can't be read."""
    stream = sys.stdout.buffer
    try:
        for part in _read(sys.argv[1], float(sys.argv[2])):
            pickle.dump(part, stream, protocol=5)
        pickle.dump(None, stream)
    except Exception as error:  # the HDF5 library raises many kinds of errors for a damaged file
        pickle.dump(str(error).partition("\n")[0] or type(error).__name__, stream)
    stream.flush()
    os._exit(0)  # HDF5 may crash or loop where it closes a damaged file


def _read(path: str, limit_s: float) -> Iterator[Any]:
    import h5netcdf

    _limit(limit_s)
    file = h5netcdf.File(path, "r", phony_dims="sort", decode_vlen_strings=True)
    yield dict(file.attrs)
    variables = {name: file.variables[name] for name in file.variables}
    _check_size(size := sum(map(_size, variables.values())), path)
    _limit(limit_s, size)
    for name, each in variables.items():
        yield name, (each.dimensions, each[...], dict(each.attrs))


def _size(variable: Any) -> int:
    return int(variable.dtype.itemsize * math.prod(variable.shape))


def _check_size(size: int, path: str) -> None:
    """Raise an error if the values are too large: a small file can declare huge ones."""
    if size > MOST_GIB << 30:
        raise ValueError(f"it has {size / 2**30:.0f} GiB, above the limit of {MOST_GIB} GiB")
    if size > MOST_PACKED * (packed := Path(path).stat().st_size):
        raise ValueError(f"it declares {size:,} bytes of values, but has {packed:,} bytes")


def _limit(limit_s: float, size: int = 0) -> None:
    """Let this process end itself unless it reads so many bytes of values in time, and with little else."""
    # A thread of C, which ends the process whatever HDF5 does, on each platform, and if its parent died.
    faulthandler.dump_traceback_later(limit_s + size / LEAST_RATE, exit=True)
    with suppress(ImportError, OSError, ValueError):  # where there is no such limit, only the time is limited
        import resource

        used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        most = resource.getrlimit(resource.RLIMIT_AS)[1]
        resource.setrlimit(resource.RLIMIT_AS, (used + size + SPARE, most))
