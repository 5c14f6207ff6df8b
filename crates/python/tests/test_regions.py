"""Meshes region by region: the same file from every engine, even if processes die."""

from __future__ import annotations

import hashlib
import os
import signal
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import curvmesh as cm
from curvmesh import regions
from curvmesh.regions import RegionError

from conftest import Run

#: So little memory that several regions and levels are needed.
SETTINGS: dict[str, Any] = {"memory": "30MiB", "ratio": 0.05, "preset": "fast"}


@pytest.fixture(scope="module")
def giant(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("giant") / "giant.ply"
    sphere = cm.shapes.sphere(6)
    p = sphere.vertices
    r = 1 + 0.1 * np.sin(7 * p[:, 0]) * np.cos(5 * p[:, 1]) + 0.01 * np.sin(60 * p[:, 2])
    cm.write(path, sphere.with_vertices(p * r[:, None]))
    return path


@pytest.fixture(params=["local", "dask", "ray"])
def engine(request: pytest.FixtureRequest) -> Any:
    """Each engine that is installed."""
    name = str(request.param)
    if name != "local":
        pytest.importorskip({"dask": "distributed", "ray": "ray"}[name])
    return name


@pytest.fixture
def binary(program: Run) -> str:
    # The fixture `program` skips the test if there is none.
    return os.environ["CURVMESH_PROGRAM"]


@pytest.fixture(scope="module")
def expected(giant: Path) -> str:
    """The output of the program alone."""
    import subprocess

    path = os.environ.get("CURVMESH_PROGRAM")
    if not path:
        pytest.skip("CURVMESH_PROGRAM names no program to compare with")
    output = giant.with_name("expected.ply")
    options = ["--memory", "30MiB", "--ratio", "0.05", "--preset", "fast", "--quiet"]
    subprocess.run([path, "simplify", giant, "-o", output, *options], check=True, capture_output=True)
    return digest(output)


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def test_every_engine_makes_the_same_file(
    engine: Any, giant: Path, binary: str, expected: str, tmp_path: Path
) -> None:
    output, steps = tmp_path / "small.ply", list[str]()
    made = regions.simplify(
        giant,
        output,
        work_dir=tmp_path / "work",
        engine=engine,
        workers=2,
        program=binary,
        callback=steps.append,
        **SETTINGS,
    )
    assert digest(output) == expected
    assert made.cells[0] > 2 and len(made.cells) > 1
    assert made.faces == cm.read(output).face_count
    assert steps[0] == "split" and steps[-1] == "finish" and len(set(steps)) >= 3 + made.cells[0]


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="processes are not killed by signals")
def test_workers_may_die(engine: Any, giant: Path, binary: str, expected: str, tmp_path: Path) -> None:
    """The program and its worker are killed in the middle of a step."""
    killed: list[int] = []

    def kill() -> None:
        for entry in Path("/proc").glob("[0-9]*/cmdline"):
            try:
                words = entry.read_bytes().split(b"\0")
            except OSError:
                continue
            if b"reduce" in words and os.fsencode(tmp_path / "work") in words:
                os.kill(int(entry.parent.name), signal.SIGKILL)
                killed.append(int(entry.parent.name))
                return

    output, steps = tmp_path / "small.ply", list[str]()

    def told(step: str) -> None:
        steps.append(step)
        if step.startswith("reduce") and not killed:
            threading.Timer(0.02, kill).start()

    regions.simplify(
        giant,
        output,
        work_dir=tmp_path / "work",
        engine=engine,
        workers=2,
        program=binary,
        callback=told,
        **SETTINGS,
    )
    # Nothing is lost, and only plans are reported twice.
    assert digest(output) == expected
    once = [step for step in steps if step != "plan"]
    assert len(set(once)) == len(once)


def test_a_result_that_does_not_fit_is_finished_in_parts(
    engine: Any, giant: Path, binary: str, tmp_path: Path
) -> None:
    output, steps = tmp_path / "large.ply", list[str]()
    made = regions.simplify(
        giant,
        output,
        work_dir=tmp_path / "work",
        engine=engine,
        workers=2,
        program=binary,
        callback=steps.append,
        memory="36MiB",
        ratio=0.5,
    )
    assert made.faces == cm.read(output).face_count
    assert sum(step.startswith("finish ") for step in steps) == made.cells[-1] > 1
    import subprocess

    alone = tmp_path / "alone.ply"
    options = ["--memory", "36MiB", "--ratio", "0.5", "--quiet"]
    subprocess.run([binary, "simplify", giant, "-o", alone, *options], check=True, capture_output=True)
    assert digest(output) == digest(alone)


def test_a_run_that_was_broken_off_goes_on(giant: Path, binary: str, expected: str, tmp_path: Path) -> None:
    class Enough(Exception):
        pass

    def stop(step: str) -> None:
        if step.startswith("join"):
            raise Enough

    output, work = tmp_path / "small.ply", tmp_path / "work"
    with pytest.raises(Enough):
        regions.simplify(
            giant, output, work_dir=work, workers=1, program=binary, callback=stop, **SETTINGS
        )
    assert not output.exists()
    regions.simplify(giant, output, work_dir=work, workers=1, program=binary, **SETTINGS)
    assert digest(output) == expected


def test_what_is_wrong_is_told(giant: Path, binary: str, tmp_path: Path) -> None:
    work = tmp_path / "work"
    with pytest.raises(cm.OptionError, match="there is no program"):
        regions.simplify(giant, "out.ply", work_dir=work, program=tmp_path / "gone", **SETTINGS)
    unknown: Any = "slurm"
    with pytest.raises(cm.OptionError, match="no engine"):
        regions.simplify(giant, "out.ply", work_dir=work, engine=unknown, program=binary, **SETTINGS)
    with pytest.raises(RegionError, match="gone.ply") as caught:
        regions.simplify(tmp_path / "gone.ply", "out.ply", work_dir=work, workers=1, program=binary, **SETTINGS)
    assert caught.value.step == "split"
    with pytest.raises(RegionError, match="(?i)ratio"):
        regions.simplify(giant, "out.ply", work_dir=work, workers=1, program=binary, memory="30MiB", ratio=7)


def test_levels_are_the_same_from_every_engine(engine: Any, giant: Path, binary: str, tmp_path: Path) -> None:
    """Levels of detail, some of which fit, by steps that run in parallel."""
    import subprocess

    steps = list[str]()
    made = regions.lod(
        giant,
        tmp_path / "levels",
        work_dir=tmp_path / "work",
        memory="36MiB",
        ratios=[0.02, 0.5],
        faces=[3000],
        preset="fast",
        verify=True,
        engine=engine,
        workers=2,
        program=binary,
        callback=steps.append,
    )
    total = cm.read(giant).face_count
    for level, target in zip(made.levels, (0.5 * total, 3000, 0.02 * total), strict=True):
        assert abs(level.faces - target) <= max(1, target / 100)
        assert level.faces == cm.read(level.output).face_count and level.tiles is None
        assert level.error is not None and 0 < level.error < 1
    once = [step for step in steps if step != "plan"]
    assert len(set(once)) == len(once) and any(step.startswith("finish ") for step in once)
    # The output of a single process.
    alone = tmp_path / "alone"
    one = str(tmp_path / "one")
    split = ["split", str(giant), "-w", one, "--memory", "36MiB", "--preset", "fast", "--verify"]
    split += ["--levels", "0.02,0.5", "--level-faces", "3000"]
    for step in (split, ["finish", one, "-o", str(alone)]):
        subprocess.run([binary, "region", *step, "--quiet"], check=True, capture_output=True)
    for level in made.levels:
        assert digest(Path(level.output)) == digest(alone / Path(level.output).name)


def test_levels_as_tiles(giant: Path, binary: str, tmp_path: Path) -> None:
    made = regions.lod(
        giant,
        tmp_path / "levels",
        work_dir=tmp_path / "work",
        memory="36MiB",
        ratios=[0.5, 0.1],
        tiles=True,
        workers=1,
        program=binary,
    )
    for level in made.levels:
        tiles = sorted(Path(level.output).glob("tile-*.ply"))
        assert len(tiles) == level.tiles
        assert sum(cm.read(tile).face_count for tile in tiles) == level.faces
    assert "levels" in repr(made) and len(made.cells) > 1
    for as_tiles, name in ((False, "giant-1.ply"), (True, "one")):
        folder = tmp_path / ("one" if as_tiles else "file")
        work = tmp_path / f"only-{as_tiles}"
        only = regions.lod(
            giant, folder, work_dir=work, memory="36MiB", faces=[3000], tiles=as_tiles, workers=1, program=binary
        )
        assert [Path(level.output).name for level in only.levels] == [name] and only.levels[0].faces == 3000
    with pytest.raises(cm.OptionError, match="no levels"):
        regions.lod(giant, "out", work_dir=tmp_path / "none", memory="36MiB", program=binary)


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="processes are not killed by signals")
@pytest.mark.parametrize("name", ["SIGKILL", "SIGSEGV", "SIGABRT"])
def test_a_step_that_dies_does_not_kill_its_caller(name: str, tmp_path: Path) -> None:
    program = tmp_path / "deadly"
    program.write_text(f"#!/bin/sh\nkill -{int(getattr(signal, name))} $$\n")
    program.chmod(0o755)
    # In this process, as in a thread of Dask.
    step = regions.Step((str(program),), ("split",), "split", 1)
    assert name in step()["died"]
    with pytest.raises(RegionError, match=f"{name}.*tried 2 times") as caught:
        regions.simplify("in.ply", "out.ply", work_dir=tmp_path / "work", workers=1, retries=1, program=program, **SETTINGS)
    assert caught.value.step == "split"


def test_the_program_of_the_package_is_used_and_tells_its_progress(giant: Path, tmp_path: Path) -> None:
    steps: list[str] = []
    output = tmp_path / "small.ply"
    # A result that fits into memory is fitted by the last step.
    options: dict[str, Any] = {**SETTINGS, "preset": "default"}
    regions.simplify(giant, output, work_dir=tmp_path / "work", workers=2, callback=steps.append, **options)
    told = [step for step in steps if step.startswith("finish: ")]
    assert told and " of " in told[0] and steps[-1] == "finish"
    assert cm.read(output).face_count == pytest.approx(0.05 * cm.read(giant).face_count, rel=0.01)
    assert not (tmp_path / "work" / "progress.txt").exists()
