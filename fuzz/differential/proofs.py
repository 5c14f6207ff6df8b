#!/usr/bin/env python3
"""Compares proved distances of curvmesh with distances in exact rational arithmetic.

    python differential/proofs.py ../target/release/curvmesh /tmp/proofs 60 1

Writes small meshes: overlapping and coplanar triangles, fans, needles, meshes far from the origin and tiny ones. Some
meshes are larger than `--memory`. Runs `distance --exact`, `simplify --verify` and `simplify --max-error` on them, and
checks:

- No point of one surface is farther from the other one than the upper bound. The points are corners and random points
  of triangles, as rational numbers.
- The lower bound is at most an exact upper bound: each part of a triangle is no farther from the other surface than
  the farthest corner of the part from one triangle.
- The upper bound is within `--max-error`.

The arguments are the program, a folder for the files, the number of rounds and the first seed. Exit code 1 and the
command lines if a check fails.
"""

import collections
import json
import math
import pathlib
import random
import subprocess
import sys
from fractions import Fraction


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def to_segment(p, a, b):
    """The squared distance of a point from a segment."""
    d, o = sub(b, a), sub(p, a)
    length, along = dot(d, d), dot(o, d)
    if along <= 0 or length == 0:
        return dot(o, o)
    if along >= length:
        o = sub(p, b)
        return dot(o, o)
    return dot(o, o) - Fraction(along * along) / length


def to_triangle(p, triangle):
    """The squared distance of a point from a triangle."""
    a, b, c = triangle
    u, v, o = sub(b, a), sub(c, a), sub(p, a)
    uu, uv, vv, ou, ov = dot(u, u), dot(u, v), dot(v, v), dot(o, u), dot(o, v)
    area = uu * vv - uv * uv
    s, t = vv * ou - uv * ov, uu * ov - uv * ou
    if area > 0 and s >= 0 and t >= 0 and s + t <= area:
        return dot(o, o) - Fraction(s * ou + t * ov) / area
    return min(to_segment(p, a, b), to_segment(p, b, c), to_segment(p, c, a))


def surface(path):
    """The triangles of an OBJ file, with exact coordinates."""
    points, triangles = [], []
    for line in path.read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            points.append(tuple(Fraction(float(word)) for word in words[1:4]))
        elif words[:1] == ["f"]:
            corners = [points[int(word.split("/")[0]) - 1] for word in words[1:]]
            triangles += [(corners[0], *corners[i : i + 2]) for i in range(1, len(corners) - 1)]
    return triangles


def integers(*surfaces):
    """The surfaces in a unit in which all coordinates are integers, and this unit."""
    corners = [x for triangles in surfaces for t in triangles for p in t for x in p]
    unit = Fraction(1, math.lcm(*(x.denominator for x in corners)))
    scaled = [
        [tuple(tuple((x / unit).numerator for x in p) for p in t) for t in triangles]
        for triangles in surfaces
    ]
    return scaled, unit


def points(triangles, count, rng):
    """Corners and other points of some triangles."""
    found = []
    for _ in range(count):
        a, b, c = rng.choice(triangles)
        i = rng.randrange(9)
        j = rng.randrange(9 - i)
        found.append(tuple(Fraction(x * i + y * j + z * (8 - i - j), 8) for x, y, z in zip(a, b, c)))
    return found


def farthest_at_most(triangles, others, depth):
    """A squared distance that no point of the triangles exceeds."""
    most = 0
    for triangle in triangles:
        parts = [triangle]
        for _ in range(depth):
            parts = [part for whole in parts for part in quarters(whole)]
        for part in parts:
            most = max(most, min(max(to_triangle(p, other) for p in part) for other in others))
    return most


def quarters(triangle):
    a, b, c = triangle
    half = lambda p, q: tuple(Fraction(x + y, 2) for x, y in zip(p, q))
    ab, bc, ca = half(a, b), half(b, c), half(c, a)
    return [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]


def soup(rng, kind):
    """Triangles of a kind: points and faces."""
    at = lambda size=1.0: [size * rng.uniform(-1, 1) for _ in range(3)]
    near = lambda p, size: [x + size * rng.uniform(-1, 1) for x in p]
    if kind == "fan":
        count = rng.randrange(5, 24)
        rim = []
        for i in range(count):
            angle, radius = 2 * math.pi * i / count, rng.uniform(0.2, 1)
            rim.append([radius * math.cos(angle), radius * math.sin(angle), 0.1 * rng.random()])
        return [[0, 0, 0.3], *rim], [[0, i + 1, (i + 1) % count + 1] for i in range(count)]
    if kind == "sheet":
        n = rng.randrange(3, 6)
        grid = [[i, j, 0.3 * rng.random()] for i in range(n + 1) for j in range(n + 1)]
        cells = [i * (n + 1) + j for i in range(n) for j in range(n)]
        return grid, [f for k in cells for f in ([k, k + n + 1, k + n + 2], [k, k + n + 2, k + 1])]
    corners = []
    for _ in range(rng.randrange(1, 9)):
        a = at()
        if kind == "needles":
            b = at()
            corners += [a, b, near(b, 10.0 ** -rng.randrange(3, 9))]
        else:
            corners += [a, at(), at()]
    if kind == "coplanar":
        corners = [[x, y, 0.0] for x, y, _ in corners]
    return corners, [[i, i + 1, i + 2] for i in range(0, len(corners), 3)]


PLACES = {
    "here": (1.0, 0.0),
    "offset 1e8": (1.0, 1e8),
    "offset 1e15": (4.0, 1e15),
    "tiny 1e-100": (1e-100, 0.0),
}


def write(path, content, place):
    scale, shift = PLACES[place]
    vertices, faces = content
    lines = ["v " + " ".join(repr(scale * x + shift) for x in p) for p in vertices]
    lines += ["f " + " ".join(str(v + 1) for v in f) for f in faces]
    path.write_text("\n".join(lines) + "\n")


def large(n):
    """A sheet of waves that does not fit into a small memory."""
    grid = [
        [i, j, math.sin(0.07 * i) + math.cos(0.05 * j)] for i in range(n + 1) for j in range(n + 1)
    ]
    cells = [i * (n + 1) + j for i in range(n) for j in range(n)]
    return grid, [f for k in cells for f in ([k, k + n + 1, k + n + 2], [k, k + n + 2, k + 1])]


class Check:
    def __init__(self, program, folder, seed):
        self.program, self.folder, self.rng = program, folder, random.Random(seed)
        self.counts, self.failures = collections.Counter(), []

    def run(self, *words):
        """The JSON that the program prints; `None` if it refuses the mesh."""
        command = [self.program, *map(str, words), "--json", "-q"]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode in (3, 4):
            self.counts["refused"] += 1
            return None
        if done.returncode != 0:
            self.fail(words, f"exit code {done.returncode}: {done.stderr}")
            return None
        return json.loads(done.stdout.splitlines()[-1])

    def fail(self, words, why):
        self.failures.append(" ".join(map(str, words)) + ": " + why)
        print(self.failures[-1], flush=True)

    def bounds(self, words, a, b, lower, upper, samples=12, depth=1):
        """Checks bounds of the distance of two files in both directions."""
        (a, b), unit = integers(surface(a), surface(b))
        if not a or not b:
            return
        # Bounds are lengths, the distances here are squares in units.
        low, high = ((Fraction(bound) / unit) ** 2 for bound in (lower, upper))
        for triangles, others in ((a, b), (b, a)):
            for p in points(triangles, samples, self.rng):
                self.counts["points"] += 1
                if min(to_triangle(p, other) for other in others) > high:
                    self.fail(words, f"a point is farther away than {upper}")
        if depth is not None:
            most = max(farthest_at_most(a, b, depth), farthest_at_most(b, a, depth))
            self.counts["lower bounds"] += 1
            if low > most:
                self.fail(words, f"the distance is less than {lower}")
        if low > high:
            self.fail(words, f"{lower} is more than {upper}")

    def distance(self, kinds, place):
        a, b = self.folder / "a.obj", self.folder / "b.obj"
        for path, kind in zip((a, b), kinds):
            write(path, soup(self.rng, kind), place)
        words = ["distance", a, b, "--exact", self.rng.choice(["10%", "0.1%", "0.001%"]), "--samples", 100]
        if found := self.run(*words):
            self.counts[f"distance, {place}"] += 1
            self.bounds(words, a, b, found["hausdorff"]["lower"], found["hausdorff"]["upper"])

    def simplify(self, kind, place, target):
        a, b = self.folder / "a.obj", self.folder / "c.obj"
        write(a, soup(self.rng, kind), place)
        words = ["simplify", a, "-o", b, "--verify", *target]
        if found := self.run(*words):
            self.counts[f"simplify {target[0]}, {place}"] += 1
            self.proved(words, found, a, b, samples=12, depth=1)

    def simplify_large(self, target):
        a, b = self.folder / "large.obj", self.folder / "d.obj"
        words = ["simplify", a, "-o", b, "--verify", "--memory", "32MiB", *target]
        if found := self.run(*words):
            self.counts[f"simplify {target[0]} --memory"] += 1
            self.proved(words, found, a, b, samples=6, depth=None)

    def proved(self, words, found, a, b, samples, depth):
        error = found["error"]
        lower, upper = error.get("lower", 0.0), error["upper"]
        self.bounds(words, a, b, lower, upper, samples, depth)
        limit = found.get("settings", {}).get("tolerance", {}).get("distance")
        if limit is not None:
            self.counts["limits"] += 1
            if upper > limit:
                self.fail(words, f"{upper} is above the limit {limit}")


def main():
    program, folder, rounds, seed = sys.argv[1], pathlib.Path(sys.argv[2]), *map(int, sys.argv[3:5])
    folder.mkdir(parents=True, exist_ok=True)
    check = Check(program, folder, seed)
    kinds = ["soup", "coplanar", "fan", "needles", "sheet"]
    for i in range(rounds):
        for place in PLACES:
            check.distance(check.rng.choices(kinds, k=2), place)
            # A surface and the same surface with its corners moved a little: they overlap.
            check.distance([kinds[i % len(kinds)]] * 2, place)
            check.simplify(("fan", "sheet")[i % 2], place, ["--ratio", "0.5"])
            check.simplify(("fan", "sheet")[i % 2], place, ["--max-error", "3%"])
    write(folder / "large.obj", large(350), "here")
    check.simplify_large(["--ratio", "0.01"])
    for what, count in sorted(check.counts.items()):
        print(f"{what}: {count}")
    print(f"{len(check.failures)} failures")
    return 1 if check.failures else 0


if __name__ == "__main__":
    sys.exit(main())
