// Corrected normal currents of DGtal with interpolated normals, in balls of the radius: see peer.hpp.

#include "peer.hpp"

#include <DGtal/base/Common.h>
#include <DGtal/geometry/meshes/CorrectedNormalCurrentComputer.h>
#include <DGtal/math/linalg/SimpleMatrix.h>
#include <DGtal/shapes/SurfaceMesh.h>
#include <DGtal/kernel/SpaceND.h>

using Space = DGtal::SpaceND<3, DGtal::int32_t>;
using Point = Space::RealPoint;
using Vector = Space::RealVector;
using Mesh = DGtal::SurfaceMesh<Point, Vector>;
using Computer = DGtal::CorrectedNormalCurrentComputer<Point, Vector>;

static Mesh prepare(const peer::Input& input) {
    std::vector<Point> points;
    std::vector<std::vector<Mesh::Vertex>> faces;
    for (const auto& p : input.vertices) points.emplace_back(p[0], p[1], p[2]);
    for (const auto& f : input.faces) faces.push_back({f[0], f[1], f[2]});
    return Mesh(points.begin(), points.end(), faces.begin(), faces.end());
}

static peer::Curvatures compute(Mesh& mesh, const peer::Input& input) {
    mesh.computeFaceNormalsFromPositions();
    mesh.computeVertexNormalsFromFaceNormals();
    const Computer computer(mesh);
    const auto area = computer.computeMu0();
    const auto tensor = computer.computeMuXY();
    peer::Curvatures found;
    for (Mesh::Vertex v = 0; v < mesh.nbVertices(); ++v) {
        if (mesh.incidentFaces(v).empty()) peer::fail("a vertex has no face");
        const auto face = mesh.incidentFaces(v)[0];
        const auto [k1, k2, d1, d2] = Computer::principalCurvatures(
            area.measure(mesh.position(v), input.radius, face), tensor.measure(mesh.position(v), input.radius, face),
            mesh.vertexNormal(v));
        found.push_back({k2, k1});
    }
    return found;
}

int main(int count, char** words) { return peer::run(count, words, DGtal_VERSION, prepare, compute); }
