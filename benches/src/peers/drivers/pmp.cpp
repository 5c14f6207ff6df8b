// The decimation of the Polygon Mesh Processing library: see raw.hpp.

#include "raw.hpp"

#include <cmath>
#include <exception>

#include <pmp/algorithms/decimation.h>
#include <pmp/surface_mesh.h>

static pmp::SurfaceMesh build(const raw::Mesh& input) {
    pmp::SurfaceMesh mesh;
    for (const auto& p : input.vertices) mesh.add_vertex(pmp::Point(p[0], p[1], p[2]));
    try {
        for (const auto& t : input.triangles) mesh.add_triangle(pmp::Vertex(t[0]), pmp::Vertex(t[1]), pmp::Vertex(t[2]));
    } catch (const std::exception& error) {
        raw::fail(error.what());
    }
    return mesh;
}

// The library stops at a number of vertices. The number for so many faces depends on the collapses at the boundary,
// which take one face instead of two; it is corrected until the faces are as many as asked for, within 0.5 %.
static void simplify(pmp::SurfaceMesh& mesh, const std::string&, std::size_t faces) {
    const pmp::SurfaceMesh original = mesh;
    double vertices = double(mesh.n_vertices()) - (double(mesh.n_faces()) - double(faces)) / 2;
    for (int attempt = 0; attempt < 5; ++attempt) {
        mesh = original;
        pmp::decimate(mesh, static_cast<unsigned>(std::max(4.0, std::round(vertices))));
        const double excess = double(mesh.n_faces()) - double(faces);
        if (std::abs(excess) <= std::max(2.0, 0.005 * faces)) return;
        vertices -= excess / 2;
    }
}

static raw::Mesh arrays(pmp::SurfaceMesh& mesh) {
    mesh.garbage_collection();
    raw::Mesh result;
    for (const auto v : mesh.vertices()) {
        const auto& point = mesh.position(v);
        result.vertices.push_back({point[0], point[1], point[2]});
    }
    for (const auto face : mesh.faces()) {
        auto& corners = result.triangles.emplace_back();
        std::size_t i = 0;
        for (const auto v : mesh.vertices(face)) corners[i++] = v.idx();
    }
    return result;
}

int main(int count, char** words) { return raw::run(count, words, PEER_VERSION, build, simplify, arrays); }
