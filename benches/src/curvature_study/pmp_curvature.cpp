// Curvatures of the Polygon Mesh Processing library: see peer.hpp. The methods are `operators` (cotangents and angle
// defects) and `tensor` (edges of two rings).

#include "peer.hpp"

#include <pmp/algorithms/curvature.h>
#include <pmp/surface_mesh.h>

static pmp::SurfaceMesh prepare(const peer::Input& input) {
    pmp::SurfaceMesh mesh;
    for (const auto& p : input.vertices) mesh.add_vertex(pmp::Point(p[0], p[1], p[2]));
    for (const auto& f : input.faces) mesh.add_triangle(pmp::Vertex(f[0]), pmp::Vertex(f[1]), pmp::Vertex(f[2]));
    return mesh;
}

static peer::Curvatures compute(pmp::SurfaceMesh& mesh, const peer::Input& input) {
    const bool is_tensor = input.method == "tensor";
    // Each call computes both curvatures, and returns one.
    peer::Curvatures found(mesh.n_vertices());
    for (const auto& [kind, slot] : {std::pair(pmp::Curvature::Max, 0), std::pair(pmp::Curvature::Min, 1)}) {
        pmp::curvature(mesh, kind, 0, is_tensor, is_tensor);
        const auto values = mesh.get_vertex_property<pmp::Scalar>("v:curv");
        for (auto v : mesh.vertices()) found[v.idx()][slot] = values[v];
    }
    return found;
}

int main(int count, char** words) { return peer::run(count, words, PEER_VERSION, prepare, compute, 2); }
