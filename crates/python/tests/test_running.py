"""Interrupts, threads, progress, memory and the import time."""

from __future__ import annotations

import _thread
import io
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import curvmesh as cm

def scene_of(mesh: cm.Mesh) -> cm.Scene:
    """A scene with one mesh."""
    file = io.BytesIO()
    cm.write(file, mesh, format="glb")
    return cm.read_scene(file.getvalue())


LONG: list[tuple[str, Callable[[cm.Mesh], object]]] = [
    ("simplify", lambda m: cm.simplify(m, ratio=0.01, preset="quality")),
    ("error", lambda m: cm.simplify(m, max_error="0.05%", verify=True)),
    ("lod", lambda m: cm.lod(m, ratios=[0.5, 0.1, 0.01])),
    ("scene", lambda m: cm.simplify_scene(scene_of(m), ratio=0.01, preset="quality")),
    ("scene lod", lambda m: cm.lod_scene(scene_of(m), ratios=[0.5, 0.1, 0.01])),
    ("flip", lambda m: cm.flip(m, cost="f1", look_ahead=3)),
    ("rebuild", lambda m: cm.flip(m, cost="f2", rebuild_effort=5)),
    ("anneal", lambda m: cm.flip(m, cost="f2", anneal_steps=500)),
    ("face", lambda m: cm.curvature(m, estimator="face", radius="3%")),
    ("ball", lambda m: cm.curvature(m, estimator="ball", radius="4%")),
    ("fit", lambda m: cm.curvature(m, estimator="fit", rings=14)),
    ("auto", lambda m: cm.curvature(m, noise="0.1%")),
    ("distance", lambda m: cm.distance(m, cm.shapes.sphere(7), samples=5_000_000)),
    ("exact", lambda m: cm.distance(m, cm.shapes.sphere(7), samples=1000, exact="0.002%")),
    ("patch", lambda m: cm.patch(m, tolerance="0.1%")),
    ("subdivide", lambda m: cm.subdivide(m, steps=2)),
    ("view", lambda m: cm.view(*[m] * 8)),
    ("function", lambda m: cm.simplify(m, ratio=0.1, cost=lambda edges: edges.lengths)),
]


@pytest.fixture(autouse=True)
def interrupts() -> Iterator[None]:
    """Python's own handler, which is missing if a shell has started the tests in the background."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.parametrize("work", [work for _, work in LONG], ids=[name for name, _ in LONG])
def test_an_interrupt_ends_every_long_call(work: Callable[[cm.Mesh], object], large: cm.Mesh) -> None:
    # Built before, so that the work itself is interrupted.
    cm.curvature(large, estimator="vertex")
    sent = [0.0]

    def send() -> None:
        sent[0] = time.perf_counter()
        signal.raise_signal(signal.SIGINT) if os.name == "nt" else os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.25, send)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        work(large)
        # On a fast machine, the work may be done by now; then this call is interrupted.
        time.sleep(5)
    waited = time.perf_counter() - sent[0]
    timer.join()
    # A tenth of a second, plus a margin for a busy machine.
    assert waited < 1.5, waited
    # No work continues in the background but the step that was interrupted, which takes seconds on a busy machine.
    until = time.perf_counter() + 30
    busy = 1.0
    while busy > 0.05 and time.perf_counter() < until:
        before = time.process_time()
        time.sleep(0.1)
        busy = time.process_time() - before
    assert busy <= 0.05, busy


def test_the_best_so_far_is_kept_on_demand(large: cm.Mesh) -> None:
    timer = threading.Timer(0.3, _thread.interrupt_main)
    timer.start()
    # Takes seconds; otherwise nothing is left to interrupt.
    small = cm.simplify(large, faces=100, preset="extreme", keep_partial=True)
    timer.cancel()
    timer.join()
    assert small.stop in ("cancelled", "faces")
    small.mesh.validate()


def test_a_callback_ends_the_run(large: cm.Mesh) -> None:
    states: list[cm.State] = []

    def stop(state: cm.State) -> bool:
        states.append(state)
        return len(states) < 3

    # Quick presets end before the callback is called three times.
    small = cm.simplify(large, faces=100, preset="extreme", callback=stop)
    assert small.stop == "cancelled" and small.mesh.face_count > 100
    assert states[0].phase == "collapse" and states[0].faces is not None
    flipped = cm.flip(large, cost="f1", callback=lambda state: False)
    assert flipped.stop == "cancelled"


def test_progress_is_told_and_exceptions_come_back(large: cm.Mesh) -> None:
    fractions: list[float] = []
    cm.simplify(large, ratio=0.3, preset="fast", progress=fractions.append)
    assert fractions == sorted(fractions) and fractions[-1] == 1.0

    def angry(_: float) -> None:
        raise RuntimeError("no more")

    with pytest.raises(RuntimeError, match="no more"):
        cm.flip(large, cost="f1", look_ahead=2, progress=angry)


def test_a_bar_is_shown(bumpy: cm.Mesh, capsys: pytest.CaptureFixture[str]) -> None:
    cm.simplify(bumpy, faces=500, progress=True)
    assert "simplifying" in capsys.readouterr().err


def test_eight_threads_on_one_mesh(bumpy: cm.Mesh) -> None:
    mesh = bumpy.copy()

    def work(number: int) -> Any:
        small = cm.simplify(mesh, faces=400 + 100 * (number % 4), threads=1 + number % 3)
        k = cm.curvature(mesh, estimator="vertex")
        d = cm.distance(mesh, small.mesh, samples=5_000)
        return small.mesh.faces.tobytes(), k.mean.tobytes(), d.max

    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(work, range(32)))
    for number in range(4, 32):
        assert found[number] == found[number % 4]


def test_other_threads_go_on(large: cm.Mesh) -> None:
    count = [0]
    done = threading.Event()

    def tick() -> None:
        while not done.is_set():
            count[0] += 1
            time.sleep(0.001)

    ticker = threading.Thread(target=tick)
    ticker.start()
    start = time.perf_counter()
    cm.simplify(large, ratio=0.2, preset="fast")
    seconds = time.perf_counter() - start
    done.set()
    ticker.join()
    assert count[0] > 20 * min(seconds, 1)


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="memory is read from /proc")
def test_nothing_leaks_over_a_thousand_calls() -> None:
    """In a separate process: other tests leave threads that release memory at any time."""
    code = """
import gc, os, curvmesh as cm
ball = cm.shapes.sphere(3)

def work():
    mesh = cm.Mesh(ball.vertices, ball.faces)
    mesh.vertex_data["x"] = mesh.vertices[:, 0]
    small = cm.simplify(mesh, faces=300, preset="fast", callback=lambda state: None)
    cm.curvature(small.mesh, estimator="vertex").directions.sum()
    cm.flip(small.mesh, cost=cm.FaceCost(lambda t: t[:, 0, 0], 1), max_flips=3)
    cm.distance(mesh, small.mesh, samples=100)
    try:
        cm.Mesh(ball.vertices, ball.faces + 9999)
    except cm.OutOfRangeError:
        pass

def resident(calls):
    for _ in range(calls):
        work()
    gc.collect()
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGESIZE")

before = resident(300)
print(resident(1000) - before)
"""
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    # A thousand times the smallest array of these meshes would be 7 MB.
    assert int(found.stdout) < 2e6, found.stdout


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="memory is read from /proc")
def test_arrays_are_copied_once() -> None:
    """The memory of a mesh from arrays is the size of its content: positions, corners and ends, without a
    second copy."""
    code = """
import resource, numpy as np, curvmesh as cm
ball = cm.shapes.sphere(8)
v, f = ball.vertices.copy(), ball.faces.copy()
del ball
held = lambda: int(open('/proc/self/status').read().split('VmHWM:')[1].split()[0]) * 1024
open('/proc/self/clear_refs', 'w').write('5')
before = held()
mesh = cm.Mesh(v, f)
grown = held() - before
print(grown / (v.nbytes + f.nbytes + 4 * len(f)))
"""
    try:
        found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    except subprocess.CalledProcessError as error:
        if "clear_refs" in error.stderr:
            pytest.skip("the peak of memory cannot be reset here")
        raise
    assert float(found.stdout) < 1.4, found.stdout


def test_import_is_quick_and_imports_little() -> None:
    code = """
import sys, time
start = time.perf_counter()
import curvmesh
print(time.perf_counter() - start)
print(*[name for name in ("numpy", "trimesh", "open3d", "pyvista", "meshio", "tqdm") if name in sys.modules])
"""
    runs = [
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        for _ in range(5)
    ]
    assert not runs[0].stdout.splitlines()[1:] or runs[0].stdout.splitlines()[1] == ""
    seconds = min(float(run.stdout.split()[0]) for run in runs)
    assert seconds < 0.03, seconds


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
def test_a_forked_process_works(bumpy: cm.Mesh) -> None:
    expected = cm.simplify(bumpy, faces=500).mesh.faces.sum()
    child = os.fork()
    if child == 0:
        right = cm.simplify(bumpy, faces=500).mesh.faces.sum() == expected
        os._exit(0 if right else 1)
    _, status = os.waitpid(child, 0)
    assert status == 0


def test_all_that_is_exported_is_documented() -> None:
    for name in cm.__all__:
        assert name == "__version__" or getattr(cm, name).__doc__, name
    assert np.all([name in dir(cm) for name in cm.__all__])
