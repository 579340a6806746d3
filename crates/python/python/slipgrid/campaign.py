"""Many scenes or designs, on as many processes or machines as there are.

A campaign file names a scene or a design and which of its keys vary::

    from concurrent.futures import ProcessPoolExecutor
    from slipgrid import campaign

    tasks = campaign.plan("widths.toml")
    with ProcessPoolExecutor(8) as pool:
        found = campaign.run(tasks, pool)
    print(found.counts)
    found.frame()

Instead of the pool any ``concurrent.futures.Executor`` will do, and the client of a Dask cluster (``dask.distributed``). Results are
those of ``slipgrid campaign work``, the same bytes whoever does what.
"""

from __future__ import annotations

import io
import json
import os
import socket
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, as_completed
from pathlib import Path
from typing import TYPE_CHECKING, Any, Union

from . import _slipgrid
from ._records import Record

if TYPE_CHECKING:
    import pandas as _pandas

__all__ = ["Campaign", "Results", "Task", "plan", "run"]

#: Parts that each process gets, so that all end at about the same time.
_PARTS_EACH = 8
#: Most tasks of a part.
_LARGEST_PART = 64


class Task(Record):
    """A task: ``id``, a hash of all that matters to the result, and ``values``, what its keys are."""

    @property
    def values(self) -> Record:  # type: ignore[override]
        """What the keys of the task are, by their names; in place of the method of mappings."""
        return Record(self["values"])


class Campaign:
    """Tasks that stand alone, with all that they read."""

    def __init__(self, campaign: _slipgrid.Campaign) -> None:
        self._campaign = campaign
        self._tasks = campaign.tasks()

    @property
    def name(self) -> str:
        """The name of the campaign."""
        return self._campaign.name

    @property
    def tasks(self) -> list[Task]:
        """The tasks: ``id``, a hash of all that matters to the result, and ``values``, what its keys are."""
        return [Task(json.loads(task)) for task in self._tasks]

    def __len__(self) -> int:
        return len(self._tasks)

    def __repr__(self) -> str:
        return f"<Campaign {self.name!r}: {len(self)} tasks>"


class Results:
    """What came of the tasks of a campaign, in their order."""

    def __init__(self, campaign: _slipgrid.Campaign, results: Sequence[str]) -> None:
        self._results = list(results)
        #: The table as CSV, as ``slipgrid campaign merge`` writes it.
        self.csv: str
        #: How many tasks ended how, in words.
        self.counts: str
        self.csv, self.counts = campaign.table(self._results)

    def __len__(self) -> int:
        return len(self._results)

    def __getitem__(self, place: int) -> Record:
        """What came of one task: its ``outcome`` ("done", "refused" or "failed"), the ``reason``, and the ``record``, whose fields
        are those of result.json."""
        return Record(json.loads(self._results[place]))

    def frame(self) -> _pandas.DataFrame:
        """The table."""
        import pandas

        return pandas.read_csv(io.StringIO(self.csv))

    def __repr__(self) -> str:
        return f"<Results of {self.counts}>"


def plan(path: Union[str, Path], progress: Callable[[str, float], object] | None = None) -> Campaign:
    """The campaign of the file at ``path``. Every task is read as its command would; what is refused raises now."""
    return Campaign(_slipgrid.Campaign.plan(Path(path), progress))


def _process() -> str:
    """What tells this process from others on the same and on other machines."""
    return f"{socket.gethostname()} {os.getpid()}"


def _work(shared: tuple[str, dict[str, bytes]], tasks: Sequence[str], threads: int | None, sender: str) -> list[str]:
    """Does tasks where they were sent."""
    if _process() != sender:
        _slipgrid.set_threads(threads)
    return _slipgrid.Campaign.of(*shared, tasks).work()


def run(
    tasks: Campaign,
    client: Any,
    *,
    threads: int | None = 1,
    progress: Callable[[str, float], object] | None = None,
) -> Results:
    """Does all tasks and waits for them.

    ``client`` is an ``Executor`` or a Dask client. ``threads`` are those of each of its processes, 1 as there are several; a thread
    of this process uses the threads of this process.
    """
    shared, own = tasks._campaign.parts(), tasks._tasks
    is_dask = hasattr(client, "scatter")
    if not is_dask and not isinstance(client, Executor):
        raise TypeError(f"{client!r} runs nothing: expected a concurrent.futures.Executor or a dask.distributed.Client")
    workers = len(client.scheduler_info()["workers"]) if is_dask else getattr(client, "_max_workers", None) or 1
    size = max(1, min(_LARGEST_PART, len(own) // (workers * _PARTS_EACH)))
    parts = [own[first : first + size] for first in range(0, len(own), size)]
    if is_dask:
        from dask import distributed

        completed: Callable[..., Any] = distributed.as_completed
        given = client.scatter(shared, broadcast=True, hash=False)
        futures = [client.submit(_work, given, part, threads, _process(), pure=False) for part in parts]
    else:
        completed = as_completed
        futures = [client.submit(_work, shared, part, threads, _process()) for part in parts]
    try:
        for count, future in enumerate(completed(futures), 1):
            future.result()
            if progress is not None:
                progress("tasks", count / len(parts))
    except BaseException:
        for future in futures:
            future.cancel()
        raise
    return Results(tasks._campaign, [result for future in futures for result in future.result()])
