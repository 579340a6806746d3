"""Many scenes or designs, on as many processes or machines as there are.

A campaign file names a scene or a design and which of its keys vary::

    from concurrent.futures import ProcessPoolExecutor
    from slipgrid import campaign

    tasks = campaign.plan("widths.toml")
    with ProcessPoolExecutor(8) as pool:
        found = campaign.run(tasks, pool)
    print(found.counts)
    found.frame()

Any ``concurrent.futures.Executor`` or the client of a Dask cluster (``dask.distributed``) may replace the pool. Results are those of
``slipgrid campaign work``, byte for byte, on any number of workers.
"""

from __future__ import annotations

import io
import json
import os
import socket
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, as_completed
from pathlib import Path
from typing import TYPE_CHECKING, Any, Optional, Union

from . import _slipgrid
from ._records import Progress, Record
from .types import DesignRecord, SimulationRecord

if TYPE_CHECKING:
    import pandas as _pandas
    from dask.distributed import Client

__all__ = ["Campaign", "Results", "Task", "plan", "run"]

#: Parts that each process gets, so that all end at about the same time.
_PARTS_EACH = 8
#: Most tasks of a part.
_LARGEST_PART = 64


class Task(Record):
    """A task: ``id``, a hash of everything that the result depends on, and ``values`` of the keys that vary."""

    id: str

    @property
    def values(self) -> Record:  # type: ignore[override]
        """Values of the keys that vary, by key; replaces the method of mappings."""
        return Record(self["values"])


class TaskResult(Record):
    """Result of a task."""

    #: "done", "refused" or "failed".
    outcome: str
    #: Why there is no record; ``None`` where there is one.
    reason: Optional[str]

    @property
    def record(self) -> Union[SimulationRecord, DesignRecord]:
        """The record of a scene or of a design, with the fields of result.json."""
        record = self["record"]
        return SimulationRecord(record) if "results" in record else DesignRecord(record)


class Campaign:
    """Independent tasks, with all files that they read."""

    def __init__(self, campaign: _slipgrid.Campaign) -> None:
        self._campaign = campaign
        self._tasks = campaign.tasks()

    @property
    def name(self) -> str:
        """The name of the campaign."""
        return self._campaign.name

    @property
    def tasks(self) -> list[Task]:
        """The tasks, in the order of the campaign file."""
        return [Task(json.loads(task)) for task in self._tasks]

    def __len__(self) -> int:
        return len(self._tasks)

    def __repr__(self) -> str:
        return f"<Campaign {self.name!r}: {len(self)} tasks>"


class Results:
    """Results of the tasks of a campaign, in their order."""

    def __init__(self, campaign: _slipgrid.Campaign, results: Sequence[str]) -> None:
        self._results = list(results)
        #: The table as CSV, as ``slipgrid campaign merge`` writes it.
        self.csv: str
        #: Numbers of tasks by outcome, in words.
        self.counts: str
        self.csv, self.counts = campaign.table(self._results)

    def __len__(self) -> int:
        return len(self._results)

    def __getitem__(self, place: int) -> TaskResult:
        """Result of one task."""
        return TaskResult(json.loads(self._results[place]))

    def frame(self) -> _pandas.DataFrame:
        """The table."""
        import pandas

        return pandas.read_csv(io.StringIO(self.csv))

    def __repr__(self) -> str:
        return f"<Results of {self.counts}>"


def plan(path: Union[str, Path], progress: Progress | None = None) -> Campaign:
    """Reads a campaign file and all its tasks.

    Parameters
    ----------
    path
        The campaign file.
    progress
        Called with the stage and the share that is done.

    Raises
    ------
    slipgrid.errors.InputError
        If the file or a task is refused.
    """
    return Campaign(_slipgrid.Campaign.plan(Path(path), progress))


def _process() -> str:
    """Identifies this process among those of all machines."""
    return f"{socket.gethostname()} {os.getpid()}"


def _work(shared: tuple[str, dict[str, bytes]], tasks: Sequence[str], threads: int | None, sender: str) -> list[str]:
    """Works on tasks in the process that received them."""
    if _process() != sender:
        _slipgrid.set_threads(threads)
    return _slipgrid.Campaign.of(*shared, tasks).work()


def run(
    tasks: Campaign,
    client: Union[Executor, Client],
    *,
    threads: int | None = 1,
    progress: Progress | None = None,
) -> Results:
    """Works on all tasks and waits for them.

    Parameters
    ----------
    tasks
        The campaign.
    client
        Executor, or client of a Dask cluster.
    threads
        Threads of each process of the client; a thread of this process uses the threads of this process.
    progress
        Called with the stage and the share that is done.

    Raises
    ------
    TypeError
        If the client can run nothing.
    """
    shared, own = tasks._campaign.parts(), tasks._tasks
    cluster: Any = client if hasattr(client, "scatter") else None
    if cluster is None and not isinstance(client, Executor):
        raise TypeError(f"{client!r} runs nothing: expected a concurrent.futures.Executor or a dask.distributed.Client")
    workers = getattr(client, "_max_workers", None) or 1 if cluster is None else len(cluster.scheduler_info()["workers"])
    size = max(1, min(_LARGEST_PART, len(own) // (workers * _PARTS_EACH)))
    parts = [own[first : first + size] for first in range(0, len(own), size)]
    completed: Callable[..., Any]
    if cluster is not None:
        from dask import distributed

        completed = distributed.as_completed
        given = cluster.scatter(shared, broadcast=True, hash=False)
        futures = [cluster.submit(_work, given, part, threads, _process(), pure=False) for part in parts]
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
