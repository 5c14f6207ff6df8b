"""Runs of a Python package on raw meshes: PACKAGE. A request is a line with tabs: faces|error VALUE THREADS REPEATS INPUT
OUTPUT.

The package is imported once; each request has a process of its own, which is forked. The answer is the minimum time of the
calls in seconds, the faces of the result, the bytes that the process used beyond the input, and the minimum time that cores
worked for a call; or `failed: ` and the reason. A function gets arrays and returns two functions: one to be timed, and one
that converts its result to arrays, so that conversions do not count.
"""

import importlib
import os
import signal
import sys
import time

import numpy as np

ENOUGH = 10.0
# A process that has used more seconds of a core is stopped.
LIMIT = 30


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


def gpytoolbox(vertices, triangles, kind, value, threads):
    import gpytoolbox

    faces = triangles.astype(np.int32)
    return lambda: gpytoolbox.decimate(vertices, faces, num_faces=int(value)), lambda result: result[:2]


def trueform(vertices, triangles, kind, value, threads):
    import trueform

    faces, share = triangles.astype(np.int32), value / len(triangles)
    return (
        # The boundary stays whole by default, and then the number of faces is out of reach for open meshes.
        lambda: trueform.decimated((faces, vertices), share, preserve_boundary=False, parallel=threads > 1),
        lambda result: (result[1], result[0]),
    )


def zmesh(vertices, triangles, kind, value, threads):
    import zmesh

    mesher = zmesh.Mesher((1, 1, 1))
    # It counts in units of voxels, and cannot represent more than 2^20 of them.
    scale = 1 << 18
    mesh = zmesh.Mesh((vertices * scale).astype(np.float32), triangles, None)
    settings = dict(reduction_factor=len(triangles) / value, max_error=scale, min_error=0)
    return lambda: mesher.simplify(mesh, **settings), lambda mesh: (mesh.vertices / scale, mesh.faces)


def blender(vertices, triangles, kind, value, threads):
    import bpy

    mesh = bpy.data.meshes.new("mesh")
    mesh.from_pydata(vertices.tolist(), [], triangles.tolist())
    thing = bpy.data.objects.new("mesh", mesh)
    bpy.context.scene.collection.objects.link(thing)
    modifier = thing.modifiers.new("decimate", "DECIMATE")
    modifier.ratio = value / len(triangles)
    modifier.use_collapse_triangulate = True

    def work():
        return thing.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()

    def arrays(result):
        result.calc_loop_triangles()
        points = np.empty(3 * len(result.vertices), np.float32)
        corners = np.empty(3 * len(result.loop_triangles), np.int32)
        result.vertices.foreach_get("co", points)
        result.loop_triangles.foreach_get("vertices", corners)
        return points.reshape(-1, 3), corners.reshape(-1, 3)

    return work, arrays


# Functions with the modules that they import.
PACKAGES = {
    "meshlab": (meshlab, ["pymeshlab"]),
    "fast-simplification": (fast_simplification, ["fast_simplification"]),
    "meshlib": (meshlib, ["meshlib.mrmeshnumpy", "meshlib.mrmeshpy"]),
    "open3d": (open3d, ["open3d"]),
    "manifold": (manifold, ["manifold3d"]),
    "pyfqmr": (pyfqmr, ["pyfqmr"]),
    "vtk-quadric": (vtk_quadric, ["vtkmodules.util.numpy_support", "vtkmodules.vtkFiltersCore"]),
    "vtk-pro": (vtk_pro, ["vtkmodules.util.numpy_support", "vtkmodules.vtkFiltersCore"]),
    "libigl": (libigl, ["igl"]),
    "gpytoolbox": (gpytoolbox, ["gpytoolbox"]),
    "trueform": (trueform, ["trueform"]),
    "zmesh": (zmesh, ["zmesh"]),
    "blender": (blender, ["bpy"]),
}


def memory(field):
    with open("/proc/self/status") as status:
        for line in status:
            if line.startswith(field):
                return 1024 * int(line.split()[1])


def timed(repeats, prepare):
    """The least times and the memory of some calls, and the last result with a function that converts it. `prepare`
    returns the call and that function; it is not timed."""
    least, least_cpu, total, peak = float("inf"), float("inf"), 0.0, "-"
    for count in range(repeats):
        try:
            work, convert = prepare()
        except ImportError as error:
            # It is installed, so a library that it links to is missing.
            sys.exit(f"it cannot start: {error}; install that, or leave it out with --tools")
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
    # What the call refers to may own the result.
    return (least, least_cpu, peak), (result, lambda result, _=work: convert(result))


def run(prepare, kind, value, threads, repeats, source, target):
    mesh = read(source)
    cost, (result, arrays) = timed(int(repeats), lambda: prepare(*mesh, kind, float(value), int(threads)))
    vertices, triangles = arrays(result)
    write(target, vertices, triangles)
    least, least_cpu, peak = cost
    return f"{least} {len(triangles)} {peak} {least_cpu}"


def answer(prepare, request):
    try:
        return run(prepare, *request.rstrip("\n").split("\t"))
    except (Exception, SystemExit) as error:
        return "failed: " + " ".join(str(error).split())


def forked(prepare, request):
    """The answer of a copy of this process, which may crash."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        import resource

        resource.setrlimit(resource.RLIMIT_CPU, (LIMIT, LIMIT))
        os.write(writing, answer(prepare, request).encode()[:4000])
        os._exit(0)
    os.close(writing)
    with open(reading, "rb") as pipe:
        text = pipe.read().decode()
    _, status = os.waitpid(child, 0)
    if text:
        return text
    if os.WIFSIGNALED(status) and os.WTERMSIG(status) in (signal.SIGKILL, signal.SIGXCPU):
        return f"failed: it was stopped after {LIMIT} s of a core"
    return f"failed: it crashed with status {status}"


def main():
    prepare, modules = PACKAGES[sys.argv[1]]
    # Libraries print, too.
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    why = None
    for module in modules:
        try:
            importlib.import_module(module)
        except ImportError as error:
            # It is installed, so a library that it links to is missing.
            why = f"failed: it cannot start: {error}; install that, or leave it out with --tools"
    act = forked if hasattr(os, "fork") else answer
    for request in sys.stdin:
        print(why or act(prepare, request), file=answers, flush=True)


if __name__ == "__main__":
    main()
