"""Two-sided distance and deviation of normals between raw meshes: ORIGINAL SEED.

Results are read from standard input, a path a line. Prints for each mean, root mean square (means of the two directions), maximum, and the mean angle between
the normals at nearest points in degrees.
"""

import sys

import numpy as np
import open3d as o3d

from simplify import read

SAMPLES = 100_000


def corner_normals(vertices, triangles):
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    return np.cross(b - a, c - a)


def samples(vertices, triangles, seed):
    """Points that lie uniformly on the surface, and the normals there."""
    random = np.random.default_rng(seed)
    normals = corner_normals(vertices, triangles)
    areas = np.linalg.norm(normals, axis=1)
    faces = np.searchsorted(np.cumsum(areas), random.random(SAMPLES) * areas.sum())
    faces = np.minimum(faces, len(triangles) - 1)
    r, t = np.sqrt(random.random(SAMPLES)), random.random(SAMPLES)
    weights = np.stack([1 - r, r * (1 - t), r * t], axis=1)
    points = np.einsum("ij,ijk->ik", weights, vertices[triangles[faces]])
    return points, normals[faces] / np.maximum(areas[faces], 1e-300)[:, None]


def scene(vertices, triangles):
    result = o3d.t.geometry.RaycastingScene()
    result.add_triangles(
        o3d.core.Tensor(vertices.astype(np.float32)), o3d.core.Tensor(triangles.astype(np.uint32))
    )
    return result


def one_way(points, normals, surface):
    nearest = surface.compute_closest_points(o3d.core.Tensor(points.astype(np.float32)))
    distances = np.linalg.norm(nearest["points"].numpy() - points, axis=1)
    cosines = np.sum(nearest["primitive_normals"].numpy() * normals, axis=1)
    angles = np.degrees(np.arccos(np.clip(cosines, -1, 1)))
    return distances.mean(), np.sqrt(np.mean(distances**2)), distances.max(), angles.mean()


def main():
    original, seed = read(sys.argv[1]), int(sys.argv[2])
    surface, points = scene(*original), samples(*original, seed)
    for line in sys.stdin:
        try:
            result = read(line.rstrip("\n"))
            there = one_way(*points, scene(*result))
            back = one_way(*samples(*result, seed + 1), surface)
            mean, rms, _, angle = ((x + y) / 2 for x, y in zip(there, back))
            print(mean, rms, max(there[2], back[2]), angle, flush=True)
        except Exception as error:
            print(repr(error), flush=True)


if __name__ == "__main__":
    main()
