// Curvatures of CGAL: see peer.hpp. With PEER_CORRECTED, interpolated corrected curvatures (CGAL 5.6 or newer) with the
// methods `ball` of the radius and `star`, the faces at a vertex. With PEER_JETS, fitted jets with the methods
// `DEGREE-RINGS`.

#include "peer.hpp"

#include <CGAL/Polygon_mesh_processing/compute_normal.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/version.h>

#ifdef PEER_CORRECTED
#include <CGAL/Polygon_mesh_processing/interpolated_corrected_curvatures.h>
#else
#include <unordered_set>

#include <CGAL/Monge_via_jet_fitting.h>
#endif

namespace processing = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Simple_cartesian<double>;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Vertex = Mesh::Vertex_index;

static Mesh prepare(const peer::Input& input) {
    Mesh mesh;
    for (const auto& p : input.vertices) mesh.add_vertex({p[0], p[1], p[2]});
    for (const auto& f : input.faces)
        if (mesh.add_face(Vertex(f[0]), Vertex(f[1]), Vertex(f[2])) == Mesh::null_face()) peer::fail("a face is refused");
    return mesh;
}

#ifdef PEER_CORRECTED

static peer::Curvatures compute(Mesh& mesh, const peer::Input& input) {
    using Value = processing::Principal_curvatures_and_directions<Kernel>;
    if (input.method != "ball" && input.method != "star") peer::fail("unknown method");
    // With a negative radius, the default, CGAL takes the faces at the vertex.
    const double radius = input.method == "ball" ? input.radius : -1.0;
    auto values = mesh.add_property_map<Vertex, Value>("v:curvature", Value()).first;
    processing::interpolated_corrected_curvatures(
        mesh, CGAL::parameters::vertex_principal_curvatures_and_directions_map(values).ball_radius(radius));
    peer::Curvatures found;
    for (Vertex v : mesh.vertices()) found.push_back({values[v].max_curvature, values[v].min_curvature});
    return found;
}

#else

// The vertex and the vertices of some rings around it, and further rings while there are too few points.
static std::vector<Kernel::Point_3> rings(const Mesh& mesh, Vertex center, unsigned count, std::size_t least) {
    std::unordered_set<Vertex> seen{center};
    std::vector<Vertex> all{center};
    for (std::size_t start = 0, ring = 0; ring < count || all.size() < least; ++ring) {
        const std::size_t end = all.size();
        for (std::size_t i = start; i < end; ++i)
            for (Vertex next : CGAL::vertices_around_target(mesh.halfedge(all[i]), mesh))
                if (seen.insert(next).second) all.push_back(next);
        if (all.size() == end) break;
        start = end;
    }
    std::vector<Kernel::Point_3> points;
    for (Vertex v : all) points.push_back(mesh.point(v));
    return points;
}

static peer::Curvatures compute(Mesh& mesh, const peer::Input& input) {
    unsigned degree = 0, count = 0;
    if (std::sscanf(input.method.c_str(), "%u-%u", &degree, &count) != 2) peer::fail("unknown method");
    const std::size_t least = (degree + 1) * (degree + 2) / 2;
    auto normals = mesh.add_property_map<Vertex, Kernel::Vector_3>("v:normal", CGAL::NULL_VECTOR).first;
    processing::compute_vertex_normals(mesh, normals);
    peer::Curvatures found;
    for (Vertex v : mesh.vertices()) {
        const auto points = rings(mesh, v, count, least);
        CGAL::Monge_via_jet_fitting<Kernel> fitting;
        auto form = fitting(points.begin(), points.end(), degree, 2);
        form.comply_wrt_given_normal(normals[v]);
        found.push_back({form.principal_curvatures(0), form.principal_curvatures(1)});
    }
    return found;
}

#endif

int main(int count, char** words) { return peer::run(count, words, CGAL_VERSION_STR, prepare, compute); }
