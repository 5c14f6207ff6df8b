"""Makes a corpus: meshes of all kinds, sound ones and broken ones, the same for the same seed.

``python corpus.py FOLDER --generated 2000 --corrupted 500 --models MODELS``
"""

from __future__ import annotations

import argparse
import os
import shutil
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

import curvmesh as cm

#: The defects of generated meshes.
DEFECTS = ("none", "none", "none", "open", "reversed", "doubled", "fin", "pinch", "loose", "flat", "far", "nan")

#: Parts of some of the names.
ODD = ("", "", "", " with spaces", " <b>&amp;", " 'quoted\"", " Ünï", " 100%", " #1?")


def surface(rng: np.random.Generator) -> tuple[Any, Any]:
    """A closed surface of some shape and size."""
    kind = rng.integers(4)
    if kind == 0:
        mesh = cm.shapes.sphere(int(rng.integers(1, 5)))
    elif kind == 1:
        mesh = cm.shapes.torus(int(rng.integers(5, 40)), int(rng.integers(4, 20)))
    elif kind == 2:
        mesh = cm.shapes.octahedron()
    else:
        one, other = cm.shapes.sphere(2), cm.shapes.torus(12, 6)
        faces = np.vstack([one.faces, other.faces + one.vertex_count])
        mesh = cm.Mesh(np.vstack([one.vertices + 5, other.vertices]), faces)
    vertices = mesh.vertices * rng.uniform(0.3, 2, 3) * 10.0 ** rng.integers(-3, 4)
    size = np.ptp(vertices, axis=0).max()
    vertices = vertices + rng.normal(0, rng.choice([0, 0.002, 0.02]) * size, vertices.shape)
    return vertices, mesh.faces.copy()


def spoiled(vertices: Any, faces: Any, defect: str, rng: np.random.Generator) -> tuple[Any, Any]:
    """The surface with a defect."""
    if defect == "open":
        faces = faces[rng.random(len(faces)) > 0.1]
    elif defect == "reversed":
        some = rng.random(len(faces)) < 0.3
        faces[some] = faces[some][:, ::-1]
    elif defect == "doubled":
        faces = np.vstack([faces, faces[: max(1, len(faces) // 5)]])
    elif defect == "fin":
        vertices = np.vstack([vertices, vertices.mean(axis=0)])
        faces = np.vstack([faces, [[faces[0, 0], faces[0, 1], len(vertices) - 1]]])
    elif defect == "pinch":
        faces = np.where(faces == faces.max(), 0, faces)
    elif defect == "loose":
        vertices = np.vstack([vertices, rng.normal(size=(5, 3))])
    elif defect == "flat":
        vertices = vertices * [1, 1, 0]
    elif defect == "far":
        vertices = vertices + 1e7 * np.ptp(vertices)
    elif defect == "nan":
        vertices = vertices.copy()
        vertices[rng.integers(len(vertices))] = np.nan
    return vertices, faces


def generate(folder: Path, count: int, seed: int) -> None:
    """Writes generated meshes."""
    rng = np.random.default_rng(seed)
    for number in range(count):
        vertices, faces = surface(rng)
        defect = str(rng.choice(DEFECTS))
        vertices, faces = spoiled(vertices, faces, defect, rng)
        name = f"made {number:05}{rng.choice(ODD)} {defect}"
        if defect == "nan":
            # Our writers cannot write this, so it is written by hand.
            lines = ["OFF", f"{len(vertices)} {len(faces)} 0"]
            lines += [" ".join(map(repr, map(float, vertex))) for vertex in vertices]
            lines += [f"3 {a} {b} {c}" for a, b, c in faces]
            (folder / f"{name}.off").write_text("\n".join(lines))
            continue
        path = folder / f"{name}.{rng.choice(['ply', 'obj', 'stl', 'off', 'glb'])}"
        cm.write(path, cm.Mesh(vertices, faces, check=False))


def corrupted(data: bytes, rng: np.random.Generator) -> bytes:
    """The content of a file with an error in it."""
    content = bytearray(data)
    place = int(rng.integers(len(content)))
    kind = rng.integers(6)
    if kind == 0:
        return bytes(content[:place])
    if kind == 1:
        for at in rng.integers(0, len(content), 1 + len(content) // 500):
            content[at] ^= 1 << int(rng.integers(8))
    elif kind == 2:
        content[place:place] = rng.integers(0, 256, 40, dtype=np.uint8).tobytes()
    elif kind == 3:
        del content[place : place + 1 + int(rng.integers(200))]
    elif kind == 4:
        content[place:place] = content[place : place + 300]
    else:
        digits = [at for at in range(min(len(content), 4000)) if 48 <= content[at] < 58]
        for at in rng.choice(digits, 3) if digits else []:
            content[at] = 57
    return bytes(content)


def corrupt(folder: Path, files: list[Path], count: int, seed: int) -> None:
    """Writes corrupted copies of files."""
    rng = np.random.default_rng(seed)
    for number in range(count):
        source = files[int(rng.integers(len(files)))]
        path = folder / f"bad {number:05}{source.suffix}"
        path.write_bytes(corrupted(source.read_bytes(), rng))


def make(folder: Path, generated: int, spoilt: int, models: Path | None = None, seed: int = 1) -> None:
    """Makes the corpus."""
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        seeds = Path(scratch)
        generate(seeds, 40, seed + 1)
        files = sorted(path for path in seeds.iterdir() if path.suffix != ".glb" or path.stat().st_size)
        if models is not None:
            known = {f".{extension}" for extension in ("obj", "ply", "stl", "off", "gltf", "glb")}
            real = sorted(path for path in models.rglob("*") if path.suffix.lower() in known)
            for path in real:
                target = folder / path.relative_to(models)
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(path, target)
            files += [path for path in real if path.stat().st_size < 2_000_000]
        corrupt(folder, files, spoilt, seed + 2)
    generate(folder, generated, seed)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--generated", type=int, default=2000)
    parser.add_argument("--corrupted", type=int, default=500)
    parser.add_argument("--models", type=Path, default=os.environ.get("CURVMESH_MODELS"))
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    make(given.folder, given.generated, given.corrupted, given.models, given.seed)


if __name__ == "__main__":
    main()
