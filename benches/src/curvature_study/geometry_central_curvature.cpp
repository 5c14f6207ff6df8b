// Principal curvatures of geometry-central, from dihedral angles and angle defects: see peer.hpp.

#include "peer.hpp"

#include <geometrycentral/surface/manifold_surface_mesh.h>
#include <geometrycentral/surface/vertex_position_geometry.h>

namespace surface = geometrycentral::surface;

struct Model {
    std::unique_ptr<surface::ManifoldSurfaceMesh> mesh;
    std::unique_ptr<surface::VertexPositionGeometry> geometry;
};

static Model prepare(const peer::Input& input) {
    std::vector<std::vector<std::size_t>> faces;
    for (const auto& f : input.faces) faces.push_back({f[0], f[1], f[2]});
    Model model;
    model.mesh = std::make_unique<surface::ManifoldSurfaceMesh>(faces);
    surface::VertexData<geometrycentral::Vector3> positions(*model.mesh);
    for (std::size_t i = 0; i < input.vertices.size(); ++i) {
        const auto& p = input.vertices[i];
        positions[i] = {p[0], p[1], p[2]};
    }
    model.geometry = std::make_unique<surface::VertexPositionGeometry>(*model.mesh, positions);
    return model;
}

static peer::Curvatures compute(Model& model, const peer::Input&) {
    auto& geometry = *model.geometry;
    geometry.requireVertexMaxPrincipalCurvatures();
    geometry.requireVertexMinPrincipalCurvatures();
    peer::Curvatures found;
    for (auto v : model.mesh->vertices())
        found.push_back({geometry.vertexMaxPrincipalCurvatures[v], geometry.vertexMinPrincipalCurvatures[v]});
    return found;
}

int main(int count, char** words) { return peer::run(count, words, PEER_VERSION, prepare, compute); }
