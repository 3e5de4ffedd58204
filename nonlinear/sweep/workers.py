"""Where work is done: in this process, in processes of this machine, or on a Dask cluster.

All three take a function and its arguments and give the results as they come, in any order. The function,
with all that it holds, travels to every worker once, however many arguments there are.
"""

from __future__ import annotations

import functools
import os
import tempfile
from collections.abc import Callable, Generator, Iterable
from itertools import islice
from pathlib import Path
from typing import Any, Protocol, TypeVar

Argument = TypeVar("Argument")
Result = TypeVar("Result")

MOST_LOSSES = 3
"""Times in a row that workers may die without finishing anything before the work is given up."""


WAITING = 2
"""Calls at the scheduler for every thread of a cluster: one that is done and one that is ready to follow."""

PATIENCE_S = 10
"""How long to wait for a scheduler and its first worker."""


class WorkersError(RuntimeError):
    """Workers that cannot be reached or keep dying; the message tells the cause and the remedy."""


class Workers(Protocol):
    """Applies a function to arguments."""

    def __call__(
        self, function: Callable[[Argument], Result], arguments: Iterable[Argument]
    ) -> Generator[Result, None, None]:
        """Results as they come, in any order."""


def in_this_process(
    function: Callable[[Argument], Result], arguments: Iterable[Argument]
) -> Generator[Result, None, None]:
    """One after the other."""
    yield from map(function, arguments)


def on_processes(jobs: int | None = None) -> Workers:
    """Processes of this machine, through joblib; as many as it has cores by default.

    Linear algebra keeps to one thread in each. When a process dies, what it and the others were working on is
    done again. The workers raise `WorkersError` when processes keep dying.
    """
    if jobs == 1:
        return in_this_process
    return functools.partial(_on_processes, -1 if jobs is None else jobs)


def on_dask(address: str | None = None) -> Workers:
    """The workers of a running Dask cluster.

    Parameters
    ----------
    address
        Of its scheduler, such as ``tcp://127.0.0.1:8786``; DASK_SCHEDULER_ADDRESS by default.

    Raises
    ------
    WorkersError
        If there is no address. The workers raise it too, when they are called: if Dask is not installed, no
        scheduler or worker answers, or a call fails.
    """
    found = address or os.environ.get("DASK_SCHEDULER_ADDRESS")
    if not found:
        raise WorkersError("dask: no scheduler's address; give one or set DASK_SCHEDULER_ADDRESS")
    return functools.partial(_on_dask, found)


def usual_workers(jobs: int | None = None) -> Workers:
    """The Dask cluster that DASK_SCHEDULER_ADDRESS names if it is set, otherwise processes.

    The workers raise `WorkersError` as those of `on_dask` and `on_processes` do.

    Parameters
    ----------
    jobs
        Number of processes where there is no cluster; as many as the machine has cores by default.
    """
    return on_dask() if os.environ.get("DASK_SCHEDULER_ADDRESS") else on_processes(jobs)


def _on_processes(
    jobs: int, function: Callable[[Argument], Result], arguments: Iterable[Argument]
) -> Generator[Result, None, None]:
    import cloudpickle
    from joblib.externals.loky.process_executor import BrokenProcessPool

    left = dict(enumerate(arguments))
    losses = 0
    with tempfile.TemporaryDirectory(prefix="chassym-") as folder:
        file = Path(folder) / "function.pickle"
        file.write_bytes(cloudpickle.dumps(function))
        while left:
            try:
                for place, result in _parallel(jobs, file, left):
                    del left[place]
                    losses = 0
                    yield result
            except BrokenProcessPool:
                losses += 1
                if losses == MOST_LOSSES:
                    raise WorkersError(
                        f"processes died {losses} times in a row, as when memory runs out; use fewer"
                    ) from None


def _parallel(
    jobs: int, file: Path, arguments: dict[int, Argument]
) -> Generator[tuple[int, Any], None, None]:
    from joblib import Parallel, delayed, parallel_config

    with parallel_config("loky", n_jobs=jobs, inner_max_num_threads=1):
        calls = (delayed(_call)(str(file), place, argument) for place, argument in arguments.copy().items())
        results = Parallel(return_as="generator_unordered", batch_size=1)(calls)
        try:
            yield from results
        finally:
            results.close()


def _call(file: str, place: int, argument: Argument) -> tuple[int, object]:
    return place, _fetched(file)(argument)


@functools.lru_cache(maxsize=1)
def _fetched(file: str) -> Callable[[Any], object]:
    import cloudpickle

    found: Callable[[Any], object] = cloudpickle.loads(Path(file).read_bytes())
    return found


def _on_dask(
    address: str, function: Callable[[Argument], Result], arguments: Iterable[Argument]
) -> Generator[Result, None, None]:
    """Few calls wait at the scheduler: what a dying worker had not finished goes to another one.

    The function is the result of a task, which the scheduler can have done again; data handed to workers
    would be lost with the last of them that holds it.
    """
    try:
        from distributed import Client, as_completed
    except ImportError:
        raise WorkersError("dask: not installed; install chassym[cluster]") from None
    try:
        client = Client(address, set_as_default=False, timeout=PATIENCE_S)
    except (OSError, ValueError) as error:
        raise WorkersError(
            f"dask: no scheduler at {address!r} ({type(error).__name__}); start one by `dask scheduler`"
        ) from None
    with client:
        _wait_for_workers(client, address)
        held = client.submit(_itself, function, pure=False)
        waiting = iter(arguments)

        def submitted(count: int) -> list[Any]:
            return [client.submit(_apply, held, each, pure=False) for each in islice(waiting, count)]

        going = as_completed(loop=client.loop, with_results=True, raise_errors=False)
        going.update(submitted(WAITING * sum(client.ncores().values())))
        for future, result in going:
            if future.status != "finished":
                raise WorkersError(f"dask: {_cause(future)}; finished work is kept, start again to go on")
            future.release()  # a result that is still wanted would be computed again when its worker dies
            yield result
            going.update(submitted(1))


def _wait_for_workers(client: Any, address: str) -> None:
    try:
        client.wait_for_workers(1, timeout=PATIENCE_S)
    except TimeoutError:
        raise WorkersError(
            f"dask: no worker at {address} within {PATIENCE_S} s; start one by `dask worker {address}`"
        ) from None


def _cause(future: Any) -> str:
    failure = future.exception(timeout=PATIENCE_S) if future.status == "error" else future.status
    return " ".join(str(failure).split())


def _itself(function: Callable[[Argument], Result]) -> Callable[[Argument], Result]:
    return function


def _apply(function: Callable[[Argument], Result], argument: Argument) -> Result:
    return function(argument)
