"""Engines that run tasks: processes on this machine, Dask, Ray.

An engine decides when and where a job runs, and whether it is retried after its worker has died.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Generator, Iterable, Iterator, Sequence
from contextlib import contextmanager
from importlib.util import find_spec
from multiprocessing.connection import Connection, wait
from typing import Any, NamedTuple, Protocol, TypeVar, Union

from ._errors import OptionError

#: The result of a job: names and JSON values.
Row = dict[str, Any]


class Job(Protocol):
    """A job of an engine: it can be pickled, has a name, and returns a record when called."""

    @property
    def name(self) -> str:
        """The unique name."""

    def __call__(self) -> Row:
        """Runs the job, on any machine."""


def call(job: Job) -> Row:
    """Calls a job; for engines that need a function of a module."""
    return job()


class Lost(NamedTuple):
    """Why a task has no record: its worker died each time, or could not start it."""

    kind: str
    message: str


def _given_up(error: BaseException, is_dead: bool) -> Lost:
    """The reason why an engine gave up a task."""
    return Lost("WorkerLost" if is_dead else "EngineError", f"{type(error).__name__}: {error}")


J = TypeVar("J", bound=Job)

#: Number of jobs that an engine gets before their results are available.
_AHEAD = 1000


#: The outcome of each job, in order of completion.
Outcomes = Generator[tuple[J, Union[Row, Lost]], None, None]


class Engine(Protocol):
    """Runs jobs."""

    def __call__(self, jobs: Sequence[J], /) -> Outcomes[J]:
        """The outcome of each job."""


#: The scheme of fsspec for files that exist in one process only.
_OF_PROCESS = "memory://"


def check_shared(paths: Iterable[str]) -> None:
    """Refuses paths that the processes of an engine do not share.

    Raises
    ------
    OptionError
        A path is in the memory of this process.
    """
    for path in paths:
        if path.startswith(_OF_PROCESS):
            raise OptionError(
                f"{path} is in the memory of this process; tasks run in other processes, which have their own",
                cure="use a folder, or call a Task in this process: curvmesh.batch.Task(source, recipe, output)()",
            )


@contextmanager
def opened(
    engine: str, client: Any, workers: int | None, cores: int, retries: int
) -> Iterator[Engine]:
    """The engine, connected while it is needed."""
    if engine == "dask":
        with _dask_client(client, workers, cores, retries) as connected:
            yield lambda jobs: _dask(jobs, connected, retries)
    elif engine == "ray":
        with _ray_cluster(client, workers, cores):
            yield lambda jobs: _ray(jobs, cores, retries)
    else:
        yield lambda jobs: _local(jobs, workers or max(1, _cpus() // cores), retries)


def check(engine: str, client: Any, workers: int | None) -> None:
    """Checks that the engine is available, before the inputs are read.

    Raises
    ------
    OptionError
        The engine is unknown or not installed, or its options conflict.
    """
    packages = {"local": "", "dask": "distributed", "ray": "ray"}
    if engine not in packages:
        raise OptionError(f'there is no engine "{engine}"; there are local, dask and ray')
    if engine == "local" and client is not None:
        raise OptionError("the local engine has no client")
    if client is not None and workers is not None:
        raise OptionError("workers are those of the client: give one of the two")
    package = packages[engine]
    if package and find_spec(package) is None:
        raise OptionError(f'the engine "{engine}" needs {package}', cure=f"pip install {package}")


def _cpus() -> int:
    """The number of processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def signal_name(number: int) -> str:
    """The name of a signal, and the usual cause of SIGKILL."""
    name = next((known.name for known in signal.Signals if known == number), str(number))
    return f"{name} (often for lack of memory: fewer workers help)" if name == "SIGKILL" else name


class _Worker:
    """A process on this machine that runs one job after the other."""

    def __init__(self) -> None:
        # Not forked: a fork would copy the locks of this process without the threads that hold them.
        context = multiprocessing.get_context("spawn")
        self.pipe, other = context.Pipe()
        self.process = context.Process(target=_serve, args=(other,), name="curvmesh", daemon=True)
        self.process.start()
        # The pipe closes when the process ends.
        other.close()
        self.is_ready = False

    def end(self) -> None:
        self.pipe.close()
        self.process.terminate()
        self.process.join()

    def why(self) -> str:
        """The reason for its end."""
        self.process.join(5)
        code = self.process.exitcode
        if code is None or code >= 0:
            return f"its process ended with code {code}"
        return f"its process was ended by {signal_name(-code)}"


def _serve(pipe: Connection) -> None:
    """The main loop of a worker."""
    # Ctrl-C is for the process that waits for results; it terminates this one.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    pipe.send(None)
    while True:
        try:
            job = pipe.recv()
        except EOFError:
            return
        pipe.send(call(job))


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os._exit(1)


def _local(jobs: Sequence[J], workers: int, retries: int) -> Outcomes[J]:
    waiting = deque((job, 0) for job in jobs)
    idle: list[_Worker] = []
    busy: dict[Any, tuple[_Worker, J, int]] = {}
    has_worked = False
    try:
        while waiting or busy:
            while waiting and len(busy) < workers:
                worker = idle.pop() if idle else _Worker()
                job, tries = waiting.popleft()
                busy[worker.pipe] = (worker, job, tries)
                if worker.is_ready:
                    _send(worker, job)
            for pipe in wait(list(busy)):
                worker, job, tries = busy[pipe]
                try:
                    row = worker.pipe.recv()
                except (EOFError, OSError):
                    why = worker.why()
                    del busy[pipe]
                    worker.end()
                    if tries < retries:
                        # Behind all others, so that a job that kills workers delays no other job.
                        waiting.append((job, tries + 1))
                    elif has_worked:
                        yield job, Lost("WorkerLost", f"tried {tries + 1} times: {why}")
                    else:
                        raise _cannot_start(why) from None
                    continue
                has_worked = True
                if worker.is_ready:
                    del busy[pipe]
                    idle.append(worker)
                    yield job, row
                else:
                    worker.is_ready = True
                    _send(worker, job)
    finally:
        for worker in [*idle, *(worker for worker, _, _ in busy.values())]:
            worker.end()


def _send(worker: _Worker, job: Job) -> None:
    try:
        worker.pipe.send(job)
    except OSError:
        # The worker has died; this is detected when its answer is awaited.
        pass


def _cannot_start(why: str) -> OptionError:
    return OptionError(
        f'no worker can be started: {why}; a script must call this below `if __name__ == "__main__":`, since '
        "its workers import it",
        cure='move the call of a script below `if __name__ == "__main__":`',
    )


@contextmanager
def _dask_client(client: Any, workers: int | None, cores: int, retries: int) -> Iterator[Any]:
    """The given client, or a new one that is closed at the end."""
    import dask
    from distributed import Client, LocalCluster

    if isinstance(client, str):
        with Client(client) as connected:
            yield connected
    elif client is not None:
        yield client
    else:
        count = workers or max(1, _cpus() // cores)
        # One job per worker at a time: a job beside one that kills the worker would be blamed, too.
        alone = {"allowed-failures": retries, "worker-saturation": 1.0}
        with dask.config.set({f"distributed.scheduler.{name}": value for name, value in alone.items()}):
            cluster = LocalCluster(n_workers=count, threads_per_worker=1, dashboard_address=None)
        with cluster, _staffed(cluster, count), Client(cluster) as connected:
            yield connected


@contextmanager
def _staffed(cluster: Any, count: int) -> Iterator[None]:
    """Starts new workers where Dask has given up: it does so if a worker dies while it starts."""
    stopped = threading.Event()

    def staff() -> None:
        while not stopped.wait(5.0):
            if len(cluster.workers) < count:
                cluster.scale(count)

    thread = threading.Thread(target=staff, daemon=True)
    thread.start()
    try:
        yield
    finally:
        stopped.set()
        thread.join()


def _dask(jobs: Sequence[J], client: Any, retries: int) -> Outcomes[J]:
    from distributed import KilledWorker, as_completed

    waiting = deque(jobs)
    of: dict[Any, J] = {}
    done = as_completed()
    # Under one name, so that the scheduler holds back the tasks that exceed the capacity of the workers.
    group = f"curvmesh-{os.urandom(8).hex()}"

    def submit() -> None:
        job = waiting.popleft()
        future = client.submit(call, job, key=(group, job.name), pure=False, retries=retries)
        of[future.key] = job
        done.add(future)

    while waiting and len(of) < _AHEAD:
        submit()
    for future in done:
        job = of.pop(future.key)
        if future.status == "finished":
            yield job, future.result()
        else:
            error = future.exception()
            yield job, _given_up(error, isinstance(error, KilledWorker))
        future.release()
        if waiting:
            submit()


@contextmanager
def _ray_cluster(address: Any, workers: int | None, cores: int) -> Iterator[None]:
    """The cluster that is already connected, or one that is disconnected at the end."""
    import ray

    if ray.is_initialized():
        if address is not None:
            raise OptionError("Ray is connected already: leave out the client")
        if workers is not None:
            raise OptionError("Ray runs already, with workers of its own: leave them out")
        yield
        return
    if address is not None:
        ray.init(address=address, log_to_driver=False)
    else:
        count = workers or max(1, _cpus() // cores)
        ray.init(num_cpus=count * cores, include_dashboard=False, log_to_driver=False)
    try:
        yield
    finally:
        ray.shutdown()


def _ray(jobs: Sequence[J], cores: int, retries: int) -> Outcomes[J]:
    import ray

    remote = ray.remote(num_cpus=cores, max_retries=retries)(call)
    waiting = deque(jobs)
    of: dict[Any, J] = {}
    while waiting or of:
        while waiting and len(of) < _AHEAD:
            job = waiting.popleft()
            of[remote.remote(job)] = job
        ready, _ = ray.wait(list(of), num_returns=1)
        for reference in ready:
            job = of.pop(reference)
            try:
                row = ray.get(reference)
            except ray.exceptions.RayError as error:
                yield job, _given_up(error, not isinstance(error, ray.exceptions.RayTaskError))
            else:
                yield job, row
