"""Edge flips by another package: METHOD VALUE REPEATS INPUT OUTPUT, with raw meshes; the value is not used.

Prints the seconds of the calls, the seconds of the core, and the bytes used beyond the input: the least of the repeats.
With one argument, a raw mesh, it prints F1, F2, F3, the smallest angle and the mean smallest angle of the faces
instead, for each further path on standard input.
"""

import sys

import numpy as np

from simplify import read, timed, write


def meshlab(vertices, triangles, work):
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, triangles.astype(np.int32)))

    def run():
        work(meshes)
        return meshes.current_mesh()

    return run, lambda mesh: (mesh.vertex_matrix(), mesh.face_matrix())


# All options: those that are not given keep the values of an earlier call.
def meshlab_curvature(vertices, triangles, criterion):
    return meshlab(
        vertices,
        triangles,
        lambda meshes: meshes.meshing_edge_flip_by_curvature_optimization(
            selection=False, pthreshold=1, curvtype=criterion
        ),
    )


def meshlab_planar(vertices, triangles, criterion):
    # By default only faces that are flat within one degree flip; 180 degrees lets all of them flip. Iterations would
    # move vertices.
    return meshlab(
        vertices,
        triangles,
        lambda meshes: meshes.meshing_edge_flip_by_planar_optimization(
            selection=False, pthreshold=180, planartype=criterion, iterations=0
        ),
    )


def meshlib_delaunay(vertices, triangles, _):
    import meshlib.mrmeshnumpy as bridge
    import meshlib.mrmeshpy as meshlib

    mesh = bridge.meshFromFacesVerts(triangles.astype(np.int32), vertices)

    def run():
        meshlib.makeDeloneEdgeFlips(mesh, meshlib.DeloneSettings(), 100)
        return mesh

    arrays = lambda mesh: (np.array(bridge.getNumpyVerts(mesh)), np.array(bridge.getNumpyFaces(mesh.topology)))
    return run, arrays


def libigl_delaunay(vertices, triangles, _):
    import igl

    faces = triangles.astype(np.int64)
    corners = vertices[faces]
    lengths = np.linalg.norm(corners[:, [2, 0, 1]] - corners[:, [1, 2, 0]], axis=2)
    # Its edges are curves on the surface; as straight edges they are a mesh again, if not always a manifold.
    return lambda: igl.intrinsic_delaunay_triangulation(lengths, faces), lambda found: (vertices, found[1])


METHODS = {
    "meshlab-curvature": meshlab_curvature,
    "meshlab-planar": meshlab_planar,
    "meshlib-delaunay": meshlib_delaunay,
    "libigl-delaunay": libigl_delaunay,
}


def quality(vertices, triangles):
    """F1, F2, F3 of DHKL01 (Voronoi areas; vertices of the boundary do not count) and angles of faces in degrees."""
    count = len(vertices)
    corners = vertices[triangles]
    edges = [corners[:, (i + 1) % 3] - corners[:, i] for i in range(3)]
    normals = np.cross(edges[0], -edges[2])
    areas = 0.5 * np.linalg.norm(normals, axis=1)
    normals = normals / np.maximum(2 * areas, 1e-300)[:, None]
    squares = [(edge**2).sum(1) for edge in edges]
    angles = [np.arctan2(2 * areas, -(edges[i] * edges[(i + 2) % 3]).sum(1)) for i in range(3)]
    area, defect = np.zeros(count), np.full(count, 2 * np.pi)
    obtuse = [angle > np.pi / 2 for angle in angles]
    with np.errstate(all="ignore"):
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            share = (squares[i] / np.tan(angles[k]) + squares[k] / np.tan(angles[j])) / 8
            rest = areas - np.tan(angles[j]) * squares[i] / 8 - np.tan(angles[k]) * squares[k] / 8
            share = np.where(obtuse[i], rest, share)
            share = np.where(obtuse[j], squares[i] * np.tan(angles[i]) / 8, share)
            share = np.where(obtuse[k], squares[k] * np.tan(angles[i]) / 8, share)
            np.add.at(area, triangles[:, i], share)
            np.add.at(defect, triangles[:, i], -angles[i])
    ends = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).astype(np.int64)
    faces = np.tile(np.arange(len(triangles)), 3)
    keys = ends.min(1) * count + ends.max(1)
    order = np.argsort(keys, kind="stable")
    first = np.flatnonzero(np.r_[True, np.diff(keys[order]) != 0])
    uses = np.diff(np.r_[first, len(keys)])
    one, other = order[first[uses == 2]], order[first[uses == 2] + 1]
    a, b = normals[faces[one]], normals[faces[other]]
    bends = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(1))
    lengths = np.linalg.norm(vertices[ends[one, 0]] - vertices[ends[one, 1]], axis=1)
    mean = np.zeros(count)
    for end in (0, 1):
        np.add.at(mean, ends[one, end], lengths * bends / 4)
    inside = area > 0
    inside[ends[order[first[uses == 1]]].ravel()] = False
    mean, defect, area = mean[inside], defect[inside], area[inside]
    roots = np.sqrt(np.maximum(mean**2 - area * defect, 0))
    f3 = np.where(defect >= 0, 2 * mean, 2 * roots).sum()
    smallest = np.degrees(np.minimum.reduce(angles))
    return (mean**2 / area).sum(), mean.sum(), f3, smallest.min(), smallest.mean()


def main():
    if len(sys.argv) == 2:
        for path in (s.rstrip("\n") for t in (sys.argv[1:], sys.stdin) for s in t):
            print(*quality(*read(path)), flush=True)
        return
    method, _, repeats, source, target = sys.argv[1:]
    name, _, criterion = method.partition(" ")
    mesh = read(source)
    cost, (result, arrays) = timed(int(repeats), lambda: METHODS[name](*mesh, criterion))
    write(target, *arrays(result))
    print(*cost)


if __name__ == "__main__":
    main()
