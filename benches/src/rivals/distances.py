"""The Hausdorff distance of two raw meshes by another package: METHOD VALUE REPEATS FIRST SECOND.

The value is a tolerance, or the number of points in each direction. Prints the seconds of the calls, the seconds of the
core, the bytes used beyond the input (the least of the repeats), a lower and an upper bound; a dash if there is none.
"""

import sys

import numpy as np

from simplify import read, timed

SEED = 1


def cascading(first, second, tolerance):
    import cascading_upper_bounds as package

    a, b = ((np.ascontiguousarray(v), np.ascontiguousarray(f, np.int32)) for v, f in (first, second))

    def run():
        # One call for each direction. The tolerance is a length: the diagonal is one.
        found = [package.pompeiu_hausdorff(*x, *y, tolerance) for x, y in ((a, b), (b, a))]
        return max(f[0] for f in found), max(f[1] for f in found)

    return run, lambda bounds: bounds


def meshlab(first, second, samples):
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    for vertices, triangles in (first, second):
        meshes.add_mesh(pymeshlab.Mesh(vertices, triangles.astype(np.int32)))

    def run():
        found = [
            meshes.get_hausdorff_distance(
                sampledmesh=x, targetmesh=1 - x, savesample=False, samplevert=True, sampleedge=False,
                samplefauxedge=False, sampleface=True, samplenum=int(samples), maxdist=pymeshlab.PercentageValue(100),
            )
            for x in (0, 1)
        ]
        return max(f["max"] for f in found), None

    return run, lambda bounds: bounds


def open3d(first, second, samples):
    import errors

    errors.SAMPLES = int(samples)

    def run():
        surfaces = [errors.scene(*mesh) for mesh in (first, second)]
        points = [errors.samples(*mesh, SEED + i) for i, mesh in enumerate((first, second))]
        return max(errors.one_way(*points[i], surfaces[1 - i])[2] for i in (0, 1)), None

    return run, lambda bounds: bounds


def libigl(first, second, _):
    import igl

    a, b = ((v, f.astype(np.int64)) for v, f in (first, second))
    return lambda: (igl.hausdorff(*a, *b), None), lambda bounds: bounds


METHODS = {"cascading": cascading, "meshlab": meshlab, "open3d": open3d, "libigl": libigl}


def main():
    method, value, repeats, first, second = sys.argv[1:]
    meshes = read(first), read(second)
    value = 0.0 if value == "-" else float(value)
    cost, (bounds, _) = timed(int(repeats), lambda: METHODS[method](*meshes, value))
    print(*cost, *("-" if bound is None else bound for bound in bounds))


if __name__ == "__main__":
    main()
