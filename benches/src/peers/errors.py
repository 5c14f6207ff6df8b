"""Two-sided distance and deviation of normals between raw meshes: ORIGINAL SEED.

Results are read from standard input, a path a line. Prints for each mean, root mean square (means of the two directions), maximum, and the mean angle between
the normals at nearest points in degrees.
"""

import sys

import numpy as np
import open3d as o3d

from simplify import read

SAMPLES = 100_000
# The distances that are computed again at most.
CHECKS = 1_000


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


def exact(point, corners):
    """The distance of a point from triangles, in double precision."""
    nearest = np.inf
    normals = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    is_inside = np.ones(len(normals), bool)
    for start, end in ((0, 1), (1, 2), (2, 0)):
        side, to = corners[end] - corners[start], point - corners[start]
        share = np.sum(to * side, axis=1) / np.maximum(np.sum(side * side, axis=1), 1e-300)
        off = to - np.clip(share, 0, 1)[:, None] * side
        nearest = min(nearest, np.sqrt(np.sum(off * off, axis=1).min()))
        is_inside &= np.sum(np.cross(side, to) * normals, axis=1) >= 0
    lengths = np.maximum(np.linalg.norm(normals, axis=1), 1e-300)
    heights = np.abs(np.sum((point - corners[0]) * normals, axis=1)) / lengths
    return min(nearest, heights[is_inside].min(initial=np.inf))


def largest(points, distances, vertices, triangles):
    """The largest of the distances. They are computed in single precision, and too large by up to 1e-4 at single points
    near needles. Therefore the largest ones are computed again, until no other one can be larger."""
    corners = vertices[triangles].transpose(1, 0, 2)
    order = np.argsort(distances)[::-1]
    found = 0.0
    for index in order[:CHECKS]:
        if distances[index] <= 1.001 * found + 1e-6:
            return found
        found = max(found, exact(points[index], corners))
    return max(found, distances[order[CHECKS]])


def one_way(points, normals, mesh, surface):
    nearest = surface.compute_closest_points(o3d.core.Tensor(points.astype(np.float32)))
    distances = np.linalg.norm(nearest["points"].numpy() - points, axis=1)
    cosines = np.sum(nearest["primitive_normals"].numpy() * normals, axis=1)
    angles = np.degrees(np.arccos(np.clip(cosines, -1, 1)))
    furthest = largest(points, distances, *mesh)
    return distances.mean(), np.sqrt(np.mean(distances**2)), furthest, angles.mean()


def main():
    original, seed = read(sys.argv[1]), int(sys.argv[2])
    surface, points = scene(*original), samples(*original, seed)
    for line in sys.stdin:
        try:
            result = read(line.rstrip("\n"))
            there = one_way(*points, result, scene(*result))
            back = one_way(*samples(*result, seed + 1), original, surface)
            mean, rms, _, angle = ((x + y) / 2 for x, y in zip(there, back))
            print(mean, rms, max(there[2], back[2]), angle, flush=True)
        except Exception as error:
            print(repr(error), flush=True)


if __name__ == "__main__":
    main()
