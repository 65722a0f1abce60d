"""What all commands that run studies share: options for workers, and their execution."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from feasibee.cli.interrupts import UNHARMED, leaving
from feasibee.cli.options import folder_type, workers_option
from feasibee.cli.sweep_progress import progress_display
from feasibee.errors import FeasibeeError

if TYPE_CHECKING:
    from feasibee.sweeps.executors import WorkerPool
    from feasibee.sweeps.sweep import Execution

JOURNAL = "a journal of all runs, with which the same command goes on."
KEPT = "the runs in the journal are kept; the same command goes on"


class Workforce(NamedTuple):
    """Workers as a command asks for them."""

    workers: int | None
    processes: bool
    dask: str | None

    def pool(self) -> WorkerPool:
        """Return the workers; connect to the Dask cluster, if one is named."""
        from feasibee.sweeps import executors

        if self.dask is not None:
            if self.processes or self.workers is not None:
                raise FeasibeeError("--dask: brings its own workers; leave out --workers and --processes")
            return executors.dask(self.dask)
        return executors.processes(self.workers) if self.processes else executors.threads(self.workers)


def _address(context: click.Context, parameter: click.Parameter, text: str | None) -> str | None:
    """Check a scheduler's address; with an impossible port, Dask would wait without end."""
    host = r"[\w.-]{1,253}|\[[\w:.%]{1,60}\]"
    found = re.fullmatch(rf"(?:[a-z]{{2,9}}://)?(?:{host}):([0-9]{{1,5}})", text or "", re.ASCII)
    if text is not None and not (found and 0 < int(found[1]) < 2**16):
        raise click.BadParameter("must be the address of a scheduler, such as tcp://10.0.0.1:8786.")
    return text


_processes = click.option(
    "--processes", is_flag=True, help="Use processes instead of threads; a process that dies is replaced."
)
_dask = click.option(
    "--dask", callback=_address, metavar="ADDRESS", help="Use a Dask cluster, such as tcp://10.0.0.1:8786."
)


def workforce_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add --workers, --processes and --dask to a command, which gets them as one `Workforce`."""

    @wraps(command)
    def bundled(
        *arguments: Any, workers: int | None, processes: bool, dask: str | None, **options: Any
    ) -> None:
        command(*arguments, workforce=Workforce(workers, processes, dask), **options)

    return workers_option(_processes(_dask(bundled)))


def folder_option(name: str, what: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Add --out, a folder for some output and the journal, to a command."""
    return click.option(
        "--out",
        type=folder_type,
        default=Path(name),
        show_default=True,
        help=f"Folder for {what}, and {JOURNAL}",
    )


journal_option = click.option(
    "--out",
    type=folder_type,
    help=f"Folder of {JOURNAL} By default in memory.",
)


@contextmanager
def executing(
    what: str, folder: Path | None, workforce: Workforce, log: Path | None = None
) -> Iterator[Execution]:
    """Let a study run within: with its workers, its journal, and a display of its progress.

    Ctrl-C while chunks are computed waits for these; a second one, or one at another moment, ends the process
    at once. So nothing but the journal may be written within.
    """
    from feasibee.sweeps.sweep import Execution

    pool = workforce.pool()
    with leaving(UNHARMED if folder is None else KEPT), progress_display(what, log) as display:
        yield Execution(folder, pool, display)
