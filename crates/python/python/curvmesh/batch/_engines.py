"""The engines that tasks are handed to: processes of this machine, Dask, Ray.

An engine decides where and when a task runs, and whether it is tried again where its worker has died.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Generator, Iterator, Sequence
from importlib.util import find_spec
from multiprocessing.connection import Connection, wait
from typing import Any, NamedTuple, Union

from .._errors import OptionError
from ._record import Row
from ._task import Task, call


class Lost(NamedTuple):
    """Why a task has no record: its worker died each time, or could not start it."""

    kind: str
    message: str


def _given_up(error: BaseException, is_dead: bool) -> Lost:
    """What an engine says of a task that it has given up."""
    return Lost("WorkerLost" if is_dead else "EngineError", f"{type(error).__name__}: {error}")


#: What became of a task.
Outcome = tuple[Task, Union[Row, Lost]]

#: How many tasks an engine is given before their results are there.
_AHEAD = 1000


def results(
    engine: str, tasks: Sequence[Task], client: Any, workers: int | None, cores: int, retries: int
) -> Generator[Outcome, None, None]:
    """What became of each task, in the order in which they end; nothing is started for none."""
    if not tasks:
        return
    if engine == "dask":
        yield from _dask(tasks, client, workers, cores, retries)
    elif engine == "ray":
        yield from _ray(tasks, client, workers, cores, retries)
    else:
        yield from _local(tasks, workers or max(1, _cpus() // cores), retries)


def check(engine: str, client: Any, workers: int | None) -> None:
    """Whether the engine is there, before anything is looked at.

    Raises
    ------
    OptionError
        There is no such engine, it is not installed, or what is asked of it does not go together.
    """
    packages = {"local": "", "dask": "distributed", "ray": "ray"}
    if engine not in packages:
        raise OptionError(f'there is no engine "{engine}"; there are local, dask and ray')
    package = packages[engine]
    if package and find_spec(package) is None:
        raise OptionError(f'the engine "{engine}" needs {package}', cure=f"pip install {package}")
    if engine == "local" and client is not None:
        raise OptionError("the local engine has no client")
    if client is not None and workers is not None:
        raise OptionError("workers are those of the client: give one of the two")


def _cpus() -> int:
    """The processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class _Worker:
    """A process of this machine that does one task after the other."""

    def __init__(self) -> None:
        # Not forked: the threads of this process would not come along, but their locks would.
        context = multiprocessing.get_context("spawn")
        self.pipe, other = context.Pipe()
        self.process = context.Process(target=_serve, args=(other,), name="curvmesh", daemon=True)
        self.process.start()
        # The end of the process is the end of the pipe.
        other.close()
        self.is_ready = False

    def end(self) -> None:
        self.pipe.close()
        self.process.terminate()
        self.process.join()

    def why(self) -> str:
        """Why it died."""
        self.process.join(5)
        code = self.process.exitcode
        if code is None or code >= 0:
            return f"its process ended with code {code}"
        name = next((known.name for known in signal.Signals if known == -code), str(-code))
        hint = "; where that was for lack of memory, fewer workers help" if name == "SIGKILL" else ""
        return f"its process was ended by {name}{hint}"


def _serve(pipe: Connection) -> None:
    """What a worker does."""
    # Ctrl-C is for the process that waits for results; it ends this one.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    pipe.send(None)
    while True:
        try:
            task = pipe.recv()
        except EOFError:
            return
        pipe.send(call(task))


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os._exit(1)


def _local(tasks: Sequence[Task], workers: int, retries: int) -> Iterator[Outcome]:
    waiting = deque((task, 0) for task in tasks)
    idle: list[_Worker] = []
    busy: dict[Any, tuple[_Worker, Task, int]] = {}
    has_worked = False
    try:
        while waiting or busy:
            while waiting and len(busy) < workers:
                worker = idle.pop() if idle else _Worker()
                task, tries = waiting.popleft()
                busy[worker.pipe] = (worker, task, tries)
                if worker.is_ready:
                    _send(worker, task)
            for pipe in wait(list(busy)):
                worker, task, tries = busy[pipe]
                try:
                    row = worker.pipe.recv()
                except (EOFError, OSError):
                    why = worker.why()
                    del busy[pipe]
                    worker.end()
                    if tries < retries:
                        # Behind all others, so that what kills workers holds nobody up.
                        waiting.append((task, tries + 1))
                    elif has_worked:
                        yield task, Lost("WorkerLost", f"tried {tries + 1} times: {why}")
                    else:
                        raise _cannot_start(why) from None
                    continue
                has_worked = True
                if worker.is_ready:
                    del busy[pipe]
                    idle.append(worker)
                    yield task, row
                else:
                    worker.is_ready = True
                    _send(worker, task)
    finally:
        for worker in [*idle, *(worker for worker, _, _ in busy.values())]:
            worker.end()


def _send(worker: _Worker, task: Task) -> None:
    try:
        worker.pipe.send(task)
    except OSError:
        # It has died; that is noticed where its answer is waited for.
        pass


def _cannot_start(why: str) -> OptionError:
    return OptionError(
        f"no worker can be started: {why}",
        cure='scripts that call run() do so below `if __name__ == "__main__":`, as workers import them',
    )


def _dask(
    tasks: Sequence[Task], client: Any, workers: int | None, cores: int, retries: int
) -> Iterator[Outcome]:
    import dask
    from distributed import Client, KilledWorker, LocalCluster, as_completed

    cluster = None
    owned = isinstance(client, str)
    if owned:
        client = Client(client)
    elif client is None:
        owned = True
        count = workers or max(1, _cpus() // cores)
        with dask.config.set({"distributed.scheduler.allowed-failures": retries}):
            cluster = LocalCluster(n_workers=count, threads_per_worker=1, dashboard_address=None)
        client = Client(cluster)
    try:
        waiting = deque(tasks)
        of: dict[Any, Task] = {}
        done = as_completed()

        def submit() -> None:
            task = waiting.popleft()
            key = f"curvmesh-{task.source.name}-{os.urandom(8).hex()}"
            future = client.submit(call, task, key=key, pure=False, retries=retries)
            of[future.key] = task
            done.add(future)

        while waiting and len(of) < _AHEAD:
            submit()
        for future in done:
            task = of.pop(future.key)
            if future.status == "finished":
                yield task, future.result()
            else:
                error = future.exception()
                yield task, _given_up(error, isinstance(error, KilledWorker))
            future.release()
            if waiting:
                submit()
    finally:
        if owned:
            client.close()
        if cluster is not None:
            cluster.close()


def _ray(
    tasks: Sequence[Task], client: Any, workers: int | None, cores: int, retries: int
) -> Iterator[Outcome]:
    import ray

    owned = not ray.is_initialized()
    if not owned and client is not None:
        raise OptionError("Ray is connected already: leave out the client")
    if not owned and workers is not None:
        raise OptionError("Ray runs already, with workers of its own: leave them out")
    if owned:
        if client is not None:
            ray.init(address=client, log_to_driver=False)
        else:
            count = workers or max(1, _cpus() // cores)
            ray.init(num_cpus=count * cores, include_dashboard=False, log_to_driver=False)
    try:
        remote = ray.remote(num_cpus=cores, max_retries=retries)(call)
        waiting = deque(tasks)
        of: dict[Any, Task] = {}
        while waiting or of:
            while waiting and len(of) < _AHEAD:
                task = waiting.popleft()
                of[remote.remote(task)] = task
            ready, _ = ray.wait(list(of), num_returns=1)
            for reference in ready:
                task = of.pop(reference)
                try:
                    row = ray.get(reference)
                except ray.exceptions.RayError as error:
                    yield task, _given_up(error, not isinstance(error, ray.exceptions.RayTaskError))
                else:
                    yield task, row
    finally:
        if owned:
            ray.shutdown()
