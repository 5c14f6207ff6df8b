"""Batch processing: recipes, records, and the engines themselves with workers that die."""

from __future__ import annotations

import html.parser
import inspect
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import curvmesh as cm
from curvmesh import _engines
from curvmesh.batch import InputError, Recipe, RecipeError, Report, Source, Task, gather, run
from curvmesh.batch import _run as running
from curvmesh.batch._steps import STEPS

from corpus import make

#: All steps.
ALL = [
    {"do": "read", "external": "folder"},
    "repair",
    {"do": "flip", "cost": "f2", "max_flips": 200},
    {"do": "simplify", "ratio": 0.5, "preset": "fast"},
    {"do": "lod", "ratios": [0.5, 0.25], "preset": "fast"},
    "curvature",
    {"do": "distance", "to": "repaired", "samples": 1000},
    {"do": "render", "values": "mean_curvature", "size": [64, 48]},
    {"do": "write", "extension": "ply", "precision": "double"},
]

#: A few tenths of a second for each of the scans.
WORK = [
    "repair",
    {"do": "simplify", "ratio": 0.2, "preset": "fast"},
    {"do": "distance", "samples": 100_000},
]

SCANS = 8


@pytest.fixture(scope="module")
def scans(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Meshes that take a while, and two that cannot be processed."""
    folder = tmp_path_factory.mktemp("models") / "scans"
    folder.mkdir()
    sphere = cm.shapes.sphere(5)
    for number in range(SCANS):
        p = sphere.vertices
        r = 1 + 0.1 * np.sin((3 + number) * p[:, 0]) * np.cos(4 * p[:, 1])
        cm.write(folder / f"scan{number}.ply", sphere.with_vertices(p * r[:, None]))
    (folder / "broken.ply").write_text("ply\nformat ascii 1.0\nelement vertex 3\n")
    (folder / "nothing.off").write_text("OFF\n0 0 0\n")
    return folder


@pytest.fixture(scope="module")
def reference(scans: Path, tmp_path_factory: pytest.TempPathFactory) -> Report:
    """The results of an undisturbed sequential run."""
    return run(scans, WORK, tmp_path_factory.mktemp("reference") / "out", workers=1)


def records(output: Path) -> dict[str, bytes]:
    return {path.parent.name: path.read_bytes() for path in output.glob("*/record.json")}


def all_is_there(report: Report, output: Path, reference: Report) -> None:
    """Nothing is lost, nothing is duplicated, and all results equal the reference."""
    names = [row["name"] for row in report.rows]
    assert names == [row["name"] for row in reference.rows] and len(set(names)) == SCANS + 2
    assert report.hash == reference.hash
    lines = (output / "manifest.jsonl").read_text().splitlines()
    assert [json.loads(line)["name"] for line in lines] == names
    for row in report.done:
        for file in row["outputs"]:
            assert (output / row["name"] / file["file"]).stat().st_size == file["bytes"]
    assert not list(output.rglob("*.part-*"))


def test_a_row_for_every_input(scans: Path, reference: Report) -> None:
    assert [row["failure"]["kind"] for row in reference.failed] == ["ReadError", "ReadError"]
    assert reference.failed[0]["failure"]["do"] == "read" and reference.failed[0]["failure"]["line"]
    row = reference.done[0]
    assert [step["do"] for step in row["steps"]] == ["read", "repair", "simplify", "distance", "write"]
    small = cm.simplify(cm.repair(cm.read(row["input"])).mesh, ratio=0.2, preset="fast")
    assert row["steps"][2]["faces"] == small.mesh.face_count
    found = cm.distance(cm.read(row["input"]), small.mesh, samples=100_000)
    assert (row["steps"][3]["mean"], row["steps"][3]["max"]) == (found.mean, found.max)
    output = Path(reference.manifest).parent / row["name"]
    assert sorted(path.name for path in output.iterdir()) == ["mesh.ply", "record.json", "thumbnail.png"]
    assert cm.read(output / "mesh.ply").face_count == small.mesh.face_count


def test_finished_work_is_not_done_again(scans: Path, tmp_path: Path, reference: Report) -> None:
    output = tmp_path / "out"
    some = [scans / "scan0.ply", scans / "scan1.ply", scans / "broken.ply"]
    first = run(some, WORK, output, workers=1)
    before = records(output)
    told: list[Any] = []
    second = run(some, WORK, output, callback=told.append)
    assert (second.skipped, second.hash, told) == (3, first.hash, [])
    assert records(output) == before
    # A touched file is read once, and found to be unchanged.
    os.utime(some[0])
    third = run(some, WORK, output, workers=1, callback=told.append)
    assert (third.skipped, len(told), third.hash) == (2, 1, first.hash)
    assert told[0]["started"] == first.rows[1]["started"]
    assert run(some, WORK, output).skipped == 3
    # A lost result, another recipe and an explicit request cause work.
    (output / "scan0.ply" / "mesh.ply").unlink()
    assert run(some, WORK, output, workers=1).skipped == 2
    assert run(some, WORK, output, workers=1, retry_failed=True).skipped == 2
    other = run(some, ["repair", {"do": "write", "name": "mended"}], output, workers=1)
    assert other.skipped == 0 and other.hash != first.hash
    left = sorted(path.name for path in (output / "scan0.ply").iterdir())
    assert left == ["mended.ply", "record.json", "thumbnail.png"]


def test_shards_are_parts_of_the_whole(scans: Path, tmp_path: Path) -> None:
    steps = ["repair", "write"]
    whole = run(scans, steps, tmp_path / "whole", workers=1, thumbnail=0)
    parts = [run(scans, steps, tmp_path / "parts", shard=f"{k}/3", workers=1, thumbnail=0) for k in (1, 2, 3)]
    assert sum(len(part.rows) for part in parts) == len(whole.rows)
    assert (tmp_path / "parts" / "manifest-2-of-3.jsonl").exists()
    assert gather(tmp_path / "parts").hash == whole.hash


# -- recipes


@pytest.mark.parametrize(
    "steps, step, says",
    [
        ([], None, "there are no steps"),
        ({"do": "repair"}, None, '"steps"'),
        ([{"ratio": 1}], 0, "must be like"),
        (["simplfy"], 0, 'did you mean "simplify"'),
        (["repair", {"do": "simplify"}], 1, "say when to stop"),
        ([{"do": "simplify", "ratio": "0.1"}], 0, "must be a number"),
        ([{"do": "simplify", "ratio": float("nan")}], 0, "must be a number"),
        ([{"do": "simplify", "ratio": 1.5}], 0, "ratio"),
        ([{"do": "simplify", "faces": True}], 0, "whole number"),
        ([{"do": "simplify", "ratio": 0.5, "preset": "nice"}], 0, "nice"),
        ([{"do": "simplify", "ratio": 0.5, "progress": True}], 0, "no option"),
        ([{"do": "read", "format": "docx"}], 0, "docx"),
        ([{"do": "read", "external": "all"}], 0, "external"),
        ([{"do": "flip", "cost": "f9"}], 0, "f9"),
        ([{"do": "flip", "look_ahead": 9}], 0, "look_ahead"),
        ([{"do": "curvature", "estimator": "guess"}], 0, "guess"),
        ([{"do": "curvature", "quantities": ["mass"]}], 0, "quantities"),
        ([{"do": "distance", "exact": "1 furlong"}], 0, "expected a length"),
        ([{"do": "distance", "to": "moon"}], 0, '"input" or "repaired"'),
        ([{"do": "render", "size": [0, 10]}], 0, "pixels"),
        ([{"do": "render", "colormap": "pinkish"}], 0, "pinkish"),
        ([{"do": "write", "extension": "docx"}], 0, "extension"),
        ([{"do": "write", "name": "../../etc/passwd"}], 0, "plain name"),
        ([{"do": "write", "name": "record"}], 0, "plain name"),
        ([{"do": "write", "encoding": "morse"}], 0, "morse"),
        (["repair", "read"], 1, "comes first"),
        (["write", "write"], 1, "name"),
        (["render", {"do": "render", "direction": "top"}], 1, "name"),
        ([{"do": "lod"}], 0, "which levels"),
    ],
)
def test_recipes_are_checked_before_anything_runs(
    steps: Any, step: int | None, says: str, scans: Path, tmp_path: Path
) -> None:
    with pytest.raises(RecipeError) as caught:
        run(scans, steps, tmp_path / "out")
    assert says in str(caught.value) and caught.value.step == step
    assert not (tmp_path / "out").exists()


def test_a_recipe_is_the_same_as_data_and_as_file(tmp_path: Path) -> None:
    path = tmp_path / "recipe.json"
    path.write_text(json.dumps({"steps": ALL}))
    assert Recipe(ALL) == Recipe(path) == Recipe(str(path)) == Recipe({"steps": ALL})
    one, other = {"do": "simplify", "ratio": 1, "seed": None}, {"ratio": 1.0, "do": "simplify"}
    assert Recipe([one]).hash == Recipe([other]).hash
    path.write_text("{")
    with pytest.raises(RecipeError, match="no JSON"):
        Recipe(path)
    with pytest.raises(RecipeError, match="gone.json"):
        Recipe(tmp_path / "gone.json")


def test_options_are_those_of_the_functions() -> None:
    """A step takes all data options of its function."""
    no_data = {
        *("mesh", "first", "second", "source", "path", "progress", "callback", "keep_partial", "threads"),
        *("constraint", "cost_modifier", "record", "overwrite_companions", "format"),
    }
    own = {"name", "extension", "quantities", "to"}
    for name, step in STEPS.items():
        parameters = set(inspect.signature(getattr(cm, name)).parameters)
        unsaid = no_data | ({"cost"} if name == "simplify" else set())
        assert parameters - unsaid - {"format"} == set(step.options) - own - {"format"}, name


# -- inputs


def test_inputs_are_paths_patterns_folders_and_urls(scans: Path, tmp_path: Path) -> None:
    pytest.importorskip("fsspec")
    steps = [{"do": "write", "extension": "off"}]

    def names(inputs: Any, **options: Any) -> list[str]:
        output = tmp_path / f"out{len(list(tmp_path.iterdir()))}"
        return [row["name"] for row in run(inputs, steps, output, workers=1, thumbnail=0, **options).rows]

    assert names(str(scans / "scan[12].ply")) == ["scan1.ply", "scan2.ply"]
    deep = str(scans.parent / "*" / "scan3.ply")
    assert names(deep) == ["scans/scan3.ply"]
    assert names([scans / "scan1.ply", str(scans / "scan1.ply")]) == ["scan1.ply"]
    assert names(f"file://{scans}/scan*.ply", shard=(1, 5)) == ["scan0.ply", "scan5.ply"]
    assert names(scans / "gone.ply") == ["gone.ply"]
    with pytest.raises(InputError, match="no mesh files"):
        names(tmp_path / "*.ply")
    with pytest.raises(InputError, match="there are no inputs"):
        names([])
    (tmp_path / "scan1.ply").write_bytes((scans / "scan1.ply").read_bytes())
    with pytest.raises(InputError, match="same place"):
        names([scans / "scan1.ply", tmp_path / "scan1.ply"])
    for bad in ("0/3", "4/3", "3", "1/2/3"):
        with pytest.raises(cm.OptionError, match="which part of how many"):
            names(scans, shard=bad)


def test_results_go_where_fsspec_can_write(scans: Path) -> None:
    fsspec = pytest.importorskip("fsspec")
    fs = fsspec.filesystem("memory")
    for name in ("scan1.ply", "broken.ply"):
        fs.pipe_file(f"/in/{name}", (scans / name).read_bytes())
    recipe = Recipe(["repair", {"do": "render", "size": [32, 32]}])
    task = Task(Source("scan1.ply", "memory://in/scan1.ply"), recipe, "memory://out")
    row = task()
    assert row["failure"] is None, row["failure"]
    assert json.loads(fs.cat_file("/out/scan1.ply/record.json"))["outputs"] == row["outputs"]
    assert [file["file"] for file in row["outputs"]] == ["picture.png", "mesh.ply"]
    assert cm.read(fs.cat_file("/out/scan1.ply/mesh.ply")).face_count == row["steps"][0]["faces"]
    # A repeated call does no work; nor does a call after another worker has finished.
    assert task() == row
    bad = Task(Source("broken.ply", "memory://in/broken.ply"), recipe, "memory://out")()
    assert bad["failure"]["kind"] == "ReadError" and bad["failure"]["lasting"]
    report = gather("memory://out")
    assert len(report.rows) == 2 and "broken.ply" in fs.cat_file("/out/summary.html").decode()
    here = Task(Source("scan1.ply", str(scans / "scan1.ply")), recipe, "memory://here")()
    assert here["outputs"] == row["outputs"] and here["input_hash"] == row["input_hash"]


def test_what_is_asked_of_run_is_checked(scans: Path, tmp_path: Path) -> None:
    for options, says in (
        ({"engine": "slurm"}, "no engine"),
        ({"client": "tcp://x"}, "no client"),
        ({"workers": 0}, "at least 1"),
        ({"engine": "dask", "client": "tcp://x", "workers": 2}, "one of the two"),
        ({"cores": 0}, "at least 1"),
        ({"retries": -1}, "not negative"),
    ):
        with pytest.raises(cm.OptionError, match=says):
            run(scans, WORK, tmp_path / "out", **options)
    (tmp_path / "file").write_text("")
    with pytest.raises(cm.WriteError):
        run(scans / "scan1.ply", ["repair"], tmp_path / "file", workers=1)


# -- engines


class Deadly(Task):
    """A task that kills its worker for some inputs."""

    def __call__(self) -> Any:
        if self.source.name == "scan5.ply":
            os.kill(os.getpid(), signal.SIGKILL)
        return super().__call__()


class Killer:
    """Kills a worker during its next task, and records which results were complete at that time."""

    def __init__(self, output: Path) -> None:
        self.output = output
        self.told: list[str] = []
        self.killed = 0
        self.before: dict[str, bytes] = {}
        self.timer: threading.Timer | None = None

    def __call__(self, row: dict[str, Any]) -> None:
        self.told.append(row["name"])
        # The two that fail at once start no task.
        if self.timer is None and row["failure"] is None:
            self.timer = threading.Timer(0.05, self.kill, [int(row["worker"].rpartition(":")[2])])
            self.timer.start()

    def kill(self, process: int) -> None:
        self.before = records(self.output)
        os.kill(process, signal.SIGKILL)
        self.killed = process

    def check(self, report: Report, reference: Report) -> None:
        all_is_there(report, self.output, reference)
        assert self.killed and self.before
        # Each is reported once, and results that were complete before are not computed again.
        assert sorted(self.told) == [row["name"] for row in report.rows]
        after = records(self.output)
        assert {name: after[name] for name in self.before} == self.before
        late = [row["worker"] for name, row in zip(self.told, report.rows) if name not in self.before]
        assert not any(worker.endswith(f":{self.killed}") for worker in late[2:])


@pytest.fixture
def dask_client() -> Iterator[Any]:
    distributed = pytest.importorskip("distributed")
    cluster = distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, memory_limit="1GB", dashboard_address=None
    )
    with cluster, distributed.Client(cluster) as client:
        yield client


@pytest.fixture(scope="module")
def ray_runs() -> Iterator[None]:
    ray = pytest.importorskip("ray")
    with pytest.MonkeyPatch.context() as patch:
        # Workers import this file.
        patch.setenv("PYTHONPATH", str(Path(__file__).parent))
        ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False, object_store_memory=100 << 20)
        yield
        ray.shutdown()


needs_signals = pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="processes are not killed by signals")


@needs_signals
def test_local_workers_may_die(scans: Path, tmp_path: Path, reference: Report) -> None:
    killer = Killer(tmp_path / "out")
    report = run(scans, WORK, tmp_path / "out", workers=2, callback=killer)
    killer.check(report, reference)


@needs_signals
def test_dask_workers_may_die(scans: Path, tmp_path: Path, reference: Report, dask_client: Any) -> None:
    killer = Killer(tmp_path / "out")
    report = run(scans, WORK, tmp_path / "out", engine="dask", client=dask_client, callback=killer)
    killer.check(report, reference)


@needs_signals
def test_ray_workers_may_die(scans: Path, tmp_path: Path, reference: Report, ray_runs: None) -> None:
    killer = Killer(tmp_path / "out")
    report = run(scans, WORK, tmp_path / "out", engine="ray", callback=killer)
    killer.check(report, reference)


def one_is_lost(run_it: Callable[[], Report], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(running, "Task", Deadly)
    report = run_it()
    (failed,) = report.failed
    assert (failed["name"], failed["failure"]["kind"]) == ("scan5.ply", "WorkerLost")
    assert not failed["failure"]["lasting"] and len(report.done) == 3
    monkeypatch.undo()
    # The record does not say that the input would kill a worker again.
    again = run_it()
    assert (again.skipped, again.failed) == (3, [])


@needs_signals
def test_what_kills_each_worker_is_given_up(
    scans: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    some = str(scans / "scan[3456].ply")
    one_is_lost(lambda: run(some, ["repair"], tmp_path / "out", workers=2, retries=1), monkeypatch)


def test_workers_that_dask_gives_up_are_replaced() -> None:
    """Dask closes a worker that dies while it starts, and starts no other one."""
    distributed = pytest.importorskip("distributed")
    with _engines.opened("dask", None, 2, 1, 1):
        client = distributed.default_client()
        cluster = client.cluster
        for name, worker in list(cluster.workers.items()):
            del cluster.workers[name]
            cluster.sync(worker.close)
        client.wait_for_workers(2, timeout=60)


@needs_signals
def test_what_kills_each_worker_of_dask_is_given_up(
    scans: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("distributed")
    some = str(scans / "scan[3456].ply")
    one_is_lost(
        lambda: run(some, ["repair"], tmp_path / "out", engine="dask", workers=1, retries=1), monkeypatch
    )


@needs_signals
def test_what_kills_each_worker_of_ray_is_given_up(
    scans: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ray_runs: None
) -> None:
    some = str(scans / "scan[3456].ply")
    one_is_lost(lambda: run(some, ["repair"], tmp_path / "out", engine="ray", retries=1), monkeypatch)


@needs_signals
@pytest.mark.parametrize("finished", [0, 2, 5])
def test_a_run_that_was_killed_goes_on(
    scans: Path, tmp_path: Path, reference: Report, finished: int
) -> None:
    recipe, output = tmp_path / "recipe.json", tmp_path / "out"
    recipe.write_text(json.dumps(WORK))
    command = [sys.executable, "-m", "curvmesh.batch", recipe, scans, "-o", output, "--workers", "2"]
    process = subprocess.Popen([*map(str, command)], stdout=subprocess.DEVNULL)
    until = time.monotonic() + 60
    while len(records(output)) < finished and process.poll() is None and time.monotonic() < until:
        time.sleep(0.005)
    # In the middle of the next tasks.
    time.sleep(0.01 * finished)
    process.kill()
    process.wait()
    # Its workers notice, and end.
    time.sleep(0.5)
    before = records(output)
    assert len(before) >= finished
    report = run(scans, WORK, output, workers=2)
    all_is_there(report, output, reference)
    assert report.skipped == len(before)
    after = records(output)
    assert {name: after[name] for name in before} == before


@needs_signals
def test_whatever_ends_a_run_ends_its_workers(scans: Path, tmp_path: Path) -> None:
    seen: list[int] = []

    def stop(row: dict[str, Any]) -> None:
        seen.append(int(row["worker"].rpartition(":")[2]))
        if len(set(seen)) == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as caught:
        run(scans, WORK, tmp_path / "out", workers=2, callback=stop)
    # Although the exception is kept, and with it the state of the run.
    assert caught.value is not None
    for process in set(seen):
        with pytest.raises(ProcessLookupError):
            os.kill(process, 0)
    assert records(tmp_path / "out").keys() >= {"broken.ply"}


def test_the_number_of_cores_does_not_matter(scans: Path, tmp_path: Path, reference: Report) -> None:
    some = [scans / f"scan{number}.ply" for number in range(3)]
    one, two = (run(some, WORK, tmp_path / f"out{n}", workers=1, cores=n) for n in (1, 2))
    assert one.hash == two.hash
    every = [run(some[0], ALL, tmp_path / f"all{n}", workers=1, cores=n).done[0] for n in (1, 2)]
    assert every[0]["outputs"] == every[1]["outputs"] and len(every[0]["outputs"]) == 4
    by_name = {row["name"]: row["outputs"] for row in reference.rows}
    assert all(row["outputs"] == by_name[row["name"]] for row in one.rows)


# -- the command line and reports


def test_the_command_line(scans: Path, tmp_path: Path, reference: Report) -> None:
    recipe, output = tmp_path / "recipe.json", tmp_path / "out"

    def call(*arguments: Any) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "curvmesh.batch", *map(str, arguments)]
        return subprocess.run(command, capture_output=True, text=True)

    recipe.write_text(json.dumps(["repair", {"do": "simplfy"}]))
    wrong = call(recipe, scans, "-o", output)
    assert wrong.returncode == 2 and 'did you mean "simplify"' in wrong.stderr
    recipe.write_text(json.dumps(["repair"]))
    parts = [call(recipe, scans, "-o", output, "--shard", f"{k}/2", "--workers", 1) for k in (1, 2)]
    assert sorted(part.returncode for part in parts) == [4, 4] or 4 in [p.returncode for p in parts]
    assert "broken.ply: ReadError" in "".join(part.stdout for part in parts)
    assert call("-o", output, "--gather", "--quiet").returncode == 4
    names = [json.loads(line)["name"] for line in (output / "manifest.jsonl").open()]
    assert names == [row["name"] for row in reference.rows]


def test_scripts_without_a_guard_are_told(tmp_path: Path) -> None:
    cm.write(tmp_path / "a.ply", cm.shapes.sphere(1))
    script = tmp_path / "script.py"
    script.write_text("import curvmesh as cm\ncm.batch.run('a.ply', ['repair'], 'out')\n")
    found = subprocess.run([sys.executable, script], cwd=tmp_path, capture_output=True, text=True)
    assert found.returncode and "no worker can be started" in found.stderr and 'if __name__ == "__main__":' in found.stderr


class Page(html.parser.HTMLParser):
    """The content of a page."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.sources: list[str] = []
        self.words = ""
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.sources += [value or "" for name, value in attrs if name in ("src", "href")]

    def handle_data(self, data: str) -> None:
        self.words += data


def test_a_corpus_of_all_kinds(tmp_path: Path) -> None:
    """Every input has a row, failures have a kind, and a second run has nothing to do."""
    make(tmp_path / "in", generated=30, spoilt=30)
    count = len(list((tmp_path / "in").iterdir()))
    report = run(tmp_path / "in", ALL, tmp_path / "out", workers=2)
    assert len(report.rows) == count == 60
    for row in report.failed:
        kind = getattr(cm, row["failure"]["kind"], None)
        assert kind is not None and issubclass(kind, cm.CurvmeshError), row["failure"]
        assert kind is not cm.InternalError and row["failure"]["message"]
    assert len(report.done) >= 20
    for row in report.done:
        assert [file["file"] for file in row["outputs"]][-1] == "mesh.ply"
        assert len(row["steps"]) == len(ALL)
    again = run(tmp_path / "in", ALL, tmp_path / "out")
    assert (again.skipped, again.hash) == (count, report.hash)

    shown = Page(tmp_path / "out" / "summary.html")
    assert {"img", "svg", "table"} <= set(shown.tags) and "b" in shown.tags
    assert shown.tags.count("b") == 4, "names are text, not markup"
    assert all(source.startswith("data:image/png") for source in shown.sources)
    assert all(row["name"] in shown.words for row in report.failed)


def test_the_manifest_as_parquet(scans: Path, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    report = run(scans, ["repair"], tmp_path / "out", workers=2, thumbnail=0, parquet=True)
    rows = parquet.read_table(tmp_path / "out" / "manifest.parquet").to_pylist()
    assert [row["name"] for row in rows] == [row["name"] for row in report.rows]
    kinds = [row["failure"] and row["failure"]["kind"] for row in report.rows]
    assert [row["failure_kind"] for row in rows] == kinds
    assert json.loads(rows[2]["steps"]) == report.rows[2]["steps"]


def test_unknown_values_stay_unknown_in_files(tmp_path: Path) -> None:
    ball = cm.shapes.sphere(2)
    mesh = cm.Mesh(np.vstack([[[5, 5, 5]], ball.vertices]), ball.faces + 1)
    cm.write(tmp_path / "a.ply", mesh)
    report = run(tmp_path / "a.ply", ["curvature"], tmp_path / "out", workers=1, thumbnail=0)
    assert report.failed == []
    back = cm.read(tmp_path / "out" / "a.ply" / "mesh.ply")
    for name in ("mean_curvature", "gaussian_curvature"):
        values = back.vertex_data[name]
        assert np.isnan(values[0]) and not np.isnan(values[1:]).any()


@pytest.mark.parametrize("engine", ["local", "dask", "ray"])
def test_memory_of_one_process_is_no_place_for_many(engine: Any, scans: Path) -> None:
    pytest.importorskip({"local": "fsspec", "dask": "distributed", "ray": "ray"}[engine])
    fsspec = pytest.importorskip("fsspec")
    fsspec.filesystem("memory").pipe_file("/only/here.ply", (scans / "scan1.ply").read_bytes())
    for inputs, output in ((scans, "memory://out2"), ("memory://only", str(scans.parent / "out2"))):
        with pytest.raises(cm.OptionError, match="in the memory of this process") as caught:
            run(inputs, ["repair"], output, engine=engine)
        assert "Task" in caught.value.cure


def test_columns_of_parquet_keep_their_types(scans: Path, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    good, bad = (
        parquet.read_schema(
            Path(
                run(scans / name, ["repair"], tmp_path / name, workers=1, parquet=True, thumbnail=0).manifest
            ).with_suffix(".parquet")
        )
        for name in ("scan1.ply", "broken.ply")
    )
    assert good == bad
    assert str(good.field("failure_message").type) == "string" and str(good.field("input_bytes").type) == "int64"
