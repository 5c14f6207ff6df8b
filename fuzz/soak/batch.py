#!/usr/bin/env python3
"""Kills workers of `curvmesh.batch` at random, and checks that the results are as without.

    python soak/batch.py /tmp/soak 1200 local dask ray

Runs a recipe on small meshes, again and again for this number of seconds, on each engine in turn, while another thread
kills a random worker with SIGKILL every few seconds. A run may give up an input whose worker died too often; the next
run of the same folder has to finish it. At the end of each round, all outputs exist and have the same bytes as after a
run without kills, and no other files are left. The arguments are a new folder, the seconds and the engines.
"""

import hashlib
import os
import pathlib
import random
import signal
import sys
import threading
import time

import curvmesh
from curvmesh import batch

STEPS = ["repair", {"do": "simplify", "ratio": 0.2, "preset": "quality"}, "curvature"]
INPUTS = 12
#: The mean number of seconds between two kills.
PAUSE = 2.0
#: More runs than this for one round count as a failure.
MOST_RUNS = 20


def is_below(pid):
    """Whether a process was started by this one, directly or not."""
    while pid > 1:
        if pid == os.getpid():
            return True
        try:
            pid = int(pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[1])
        except OSError:
            return False
    return False


class Killer(threading.Thread):
    """Kills workers until it is stopped. Only workers that have ended a task: Dask gives up a worker that dies while it
    starts.
    """

    def __init__(self, seed):
        super().__init__(daemon=True)
        self.random, self.done, self.killed = random.Random(seed), threading.Event(), 0
        self.workers = set()

    def see(self, row):
        """Remembers the worker of a task that has ended. The rows of tasks that were given up have none."""
        if pid := row["worker"].rpartition(":")[2]:
            self.workers.add(int(pid))

    def run(self):
        while not self.done.wait(self.random.uniform(0.0, 2.0 * PAUSE)):
            if self.workers:
                worker = self.random.choice(sorted(self.workers))
                self.workers.discard(worker)
                if is_below(worker):
                    os.kill(worker, signal.SIGKILL)
                    self.killed += 1


def contents(folder):
    """The hash of each file below a folder that depends on inputs and recipe alone."""
    times = {"record.json", "manifest.jsonl", "summary.html"}
    files = [path for path in folder.rglob("*") if path.is_file()]
    digest = lambda path: None if path.name in times else hashlib.sha256(path.read_bytes()).hexdigest()
    return {str(path.relative_to(folder)): digest(path) for path in sorted(files)}


def main():
    folder, seconds, engines = pathlib.Path(sys.argv[1]), float(sys.argv[2]), sys.argv[3:] or ["local"]
    inputs = folder / "inputs"
    inputs.mkdir(parents=True)
    for i in range(INPUTS):
        curvmesh.shapes.torus(30 + i, 20).save(inputs / f"torus{i}.ply")
    reference = batch.run(inputs, STEPS, folder / "reference")
    expected = contents(folder / "reference")
    print(f"{len(expected)} files without kills", flush=True)
    end, failures = time.monotonic() + seconds, 0
    rounds = {engine: [0, 0, 0] for engine in engines}
    number = 0
    while time.monotonic() < end:
        engine = engines[number % len(engines)]
        output = folder / f"{engine}{number}"
        killer = Killer(number)
        killer.start()
        runs = 0
        while True:
            runs += 1
            report = batch.run(inputs, STEPS, output, engine=engine, workers=2, callback=killer.see)
            killer.workers.clear()
            if not report.failed or runs == MOST_RUNS:
                break
        killer.done.set()
        killer.join()
        found = contents(output)
        is_same = report.hash == reference.hash and found == expected
        rounds[engine] = [a + b for a, b in zip(rounds[engine], (1, runs, killer.killed))]
        print(f"{engine}: {runs} runs, {killer.killed} kills, {'same' if is_same else 'DIFFERENT'}", flush=True)
        if not is_same:
            failures += 1
            wrong = {name for name in {*found, *expected} if found.get(name, 0) != expected.get(name, 0)}
            print(f"  {sorted(wrong)}, failed: {report.failed}", flush=True)
        number += 1
    for engine, (count, runs, kills) in rounds.items():
        print(f"{engine}: {count} rounds, {runs} runs, {kills} kills")
    print(f"{failures} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
