"""One run of a Python package on a raw mesh: PACKAGE faces|error VALUE THREADS REPEATS INPUT OUTPUT.

Prints the minimum time of the calls in seconds, the faces of the result, the bytes that the
process used beyond the input, and the minimum time that cores worked for a call. A function gets arrays and returns two functions: one to be timed,
and one that converts its result to arrays, so that conversions do not count.
"""

import sys
import time

import numpy as np

ENOUGH = 10.0


def read(path):
    data = np.fromfile(path, np.uint8)
    vertices, triangles = (int(n) for n in data[:16].view(np.uint64))
    end = 16 + 24 * vertices
    return (
        data[16:end].view(np.float64).reshape(-1, 3),
        data[end : end + 12 * triangles].view(np.uint32).reshape(-1, 3),
    )


def write(path, vertices, triangles):
    with open(path, "wb") as file:
        file.write(np.array([len(vertices), len(triangles)], np.uint64).tobytes())
        file.write(np.ascontiguousarray(vertices, np.float64).tobytes())
        file.write(np.ascontiguousarray(triangles, np.uint32).tobytes())


def meshlab(vertices, triangles, kind, value, threads):
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, triangles.astype(np.int32)))

    def work():
        # All options: those that are not given keep the values of an earlier call.
        meshes.meshing_decimation_quadric_edge_collapse(
            targetfacenum=int(value), targetperc=0, qualitythr=0.3, preserveboundary=False,
            boundaryweight=1, preservenormal=False, preservetopology=False, optimalplacement=True,
            planarquadric=False, qualityweight=False, autoclean=True, selected=False,
        )
        return meshes.current_mesh()

    return work, lambda mesh: (mesh.vertex_matrix(), mesh.face_matrix())


def fast_simplification(vertices, triangles, kind, value, threads):
    import fast_simplification

    points, faces = vertices.astype(np.float32), triangles.astype(np.int32)
    reduction = 1 - value / len(triangles)
    return lambda: fast_simplification.simplify(points, faces, target_reduction=reduction), tuple


def meshlib(vertices, triangles, kind, value, threads):
    import meshlib.mrmeshnumpy as numpy_bridge
    import meshlib.mrmeshpy as meshlib

    mesh = numpy_bridge.meshFromFacesVerts(triangles.astype(np.int32), vertices)
    settings = meshlib.DecimateSettings()
    settings.packMesh = True
    settings.subdivideParts = 1 if threads == 1 else 8 * threads
    if kind == "faces":
        settings.maxError = 1e30
        settings.maxDeletedFaces = len(triangles) - int(value)
    else:
        settings.maxError = value

    def work():
        meshlib.decimateMesh(mesh, settings)
        return mesh

    arrays = lambda mesh: (
        np.array(numpy_bridge.getNumpyVerts(mesh)),
        np.array(numpy_bridge.getNumpyFaces(mesh.topology)),
    )
    return work, arrays


def open3d(vertices, triangles, kind, value, threads):
    import open3d

    mesh = open3d.geometry.TriangleMesh(
        open3d.utility.Vector3dVector(vertices),
        open3d.utility.Vector3iVector(triangles.astype(np.int32)),
    )
    return (
        lambda: mesh.simplify_quadric_decimation(int(value)),
        lambda mesh: (np.asarray(mesh.vertices), np.asarray(mesh.triangles)),
    )


def manifold(vertices, triangles, kind, value, threads):
    import manifold3d

    mesh = manifold3d.Mesh64(vertices, triangles.astype(np.uint64))
    solid = manifold3d.Manifold(mesh)
    if solid.status() != manifold3d.Error.NoError:
        sys.exit(f"not a closed mesh for it: {solid.status()}")

    def arrays(solid):
        mesh = solid.to_mesh64()
        return np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts)

    def work():
        result = solid.simplify(value)
        result.num_tri()  # It is computed lazily.
        return result

    return work, arrays


def pyfqmr(vertices, triangles, kind, value, threads):
    import pyfqmr

    simplifier = pyfqmr.Simplify()
    simplifier.setMesh(vertices, triangles.astype(np.int32))

    def work():
        simplifier.simplify_mesh(target_count=int(value), aggressiveness=7, preserve_border=False, verbose=False)
        return simplifier.getMesh()

    return work, lambda result: result[:2]


def vtk_mesh(vertices, triangles):
    from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

    points, cells, mesh = vtkPoints(), vtkCellArray(), vtkPolyData()
    points.SetData(numpy_to_vtk(vertices, deep=True))
    cells.SetData(3, numpy_to_vtkIdTypeArray(triangles.astype(np.int64).ravel(), deep=True))
    mesh.SetPoints(points)
    mesh.SetPolys(cells)
    return mesh


def vtk_filter(filter, vertices, triangles, value):
    from vtkmodules.util.numpy_support import vtk_to_numpy

    filter.SetInputData(vtk_mesh(vertices, triangles))
    filter.SetTargetReduction(1 - value / len(triangles))

    def work():
        filter.Modified()
        filter.Update()
        return filter.GetOutput()

    return work, lambda mesh: (
        vtk_to_numpy(mesh.GetPoints().GetData()),
        vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3),
    )


def vtk_quadric(vertices, triangles, kind, value, threads):
    from vtkmodules.vtkFiltersCore import vtkQuadricDecimation

    return vtk_filter(vtkQuadricDecimation(), vertices, triangles, value)


def vtk_pro(vertices, triangles, kind, value, threads):
    from vtkmodules.vtkFiltersCore import vtkDecimatePro

    return vtk_filter(vtkDecimatePro(), vertices, triangles, value)


def libigl(vertices, triangles, kind, value, threads):
    import igl

    points, faces = np.asfortranarray(vertices), np.asfortranarray(triangles, np.int32)
    return lambda: igl.qslim(points, faces, int(value)), lambda result: result[:2]


PACKAGES = {
    "meshlab": meshlab,
    "fast-simplification": fast_simplification,
    "meshlib": meshlib,
    "open3d": open3d,
    "manifold": manifold,
    "pyfqmr": pyfqmr,
    "vtk-quadric": vtk_quadric,
    "vtk-pro": vtk_pro,
    "libigl": libigl,
}


def memory(field):
    with open("/proc/self/status") as status:
        for line in status:
            if line.startswith(field):
                return 1024 * int(line.split()[1])


def main():
    package, kind, value, threads, repeats, source, target = sys.argv[1:]
    mesh = read(source)
    least, least_cpu, total, peak = float("inf"), float("inf"), 0.0, "-"
    for count in range(int(repeats)):
        try:
            work, arrays = PACKAGES[package](*mesh, kind, float(value), int(threads))
        except ImportError as error:
            # It is installed, so a library that it links to is missing.
            sys.exit(f"{package} cannot start: {error}; install that, or leave it out with --tools")
        before = None
        if count == 0:
            try:
                with open("/proc/self/clear_refs", "w") as file:
                    file.write("5")
                before = memory("VmRSS:")
            except OSError:
                pass
        start, worked = time.perf_counter(), time.process_time()
        result = work()
        seconds, cpu = time.perf_counter() - start, time.process_time() - worked
        if before is not None:
            peak = max(memory("VmHWM:") - before, 0)
        least, least_cpu, total = min(least, seconds), min(least_cpu, cpu), total + seconds
        if total > ENOUGH:
            break
    vertices, triangles = arrays(result)
    write(target, vertices, triangles)
    print(least, len(triangles), peak, least_cpu)


if __name__ == "__main__":
    main()
