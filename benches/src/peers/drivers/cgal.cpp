// The edge collapse of CGAL: see raw.hpp.

#include "raw.hpp"

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_filter.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/GarlandHeckbert_policies.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>
#include <CGAL/version.h>

namespace collapse = CGAL::Surface_mesh_simplification;
using Kernel = CGAL::Simple_cartesian<double>;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

// Stops at a number of faces.
struct FewFaces {
    std::size_t count;
    template <class Cost, class Profile>
    bool operator()(const Cost&, const Profile& profile, std::size_t, std::size_t) const {
        return profile.surface_mesh().number_of_faces() <= count;
    }
};

static Mesh build(const raw::Mesh& input) {
    using Vertex = Mesh::Vertex_index;
    Mesh mesh;
    for (const auto& p : input.vertices) mesh.add_vertex({p[0], p[1], p[2]});
    std::size_t refused = 0;
    for (const auto& t : input.triangles)
        refused += mesh.add_face(Vertex(t[0]), Vertex(t[1]), Vertex(t[2])) == Mesh::null_face();
    if (refused) raw::fail(std::to_string(refused) + " faces are refused");
    return mesh;
}

// Quadrics, with the filter of normals that CGAL recommends for them.
template <class Policies>
void by_quadrics(Mesh& mesh, FewFaces stop) {
    const Policies policies(mesh);
    const auto parameters = CGAL::parameters::get_cost(policies.get_cost())
                                .get_placement(policies.get_placement())
                                .filter(collapse::Bounded_normal_change_filter<>());
    collapse::edge_collapse(mesh, stop, parameters);
}

static void simplify(Mesh& mesh, const std::string& name, std::size_t faces) {
    const FewFaces stop{faces};
    if (name == "cgal-lt")
        collapse::edge_collapse(mesh, stop);
    else if (name == "cgal-gh")
        by_quadrics<collapse::GarlandHeckbert_plane_policies<Mesh, Kernel>>(mesh, stop);
    else if (name == "cgal-probabilistic")
        by_quadrics<collapse::GarlandHeckbert_probabilistic_plane_policies<Mesh, Kernel>>(mesh, stop);
    else
        raw::fail("there is no " + name);
}

static raw::Mesh arrays(Mesh& mesh) {
    mesh.collect_garbage();
    raw::Mesh result;
    for (const auto v : mesh.vertices()) {
        const auto& point = mesh.point(v);
        result.vertices.push_back({point.x(), point.y(), point.z()});
    }
    for (const auto face : mesh.faces()) {
        auto& corners = result.triangles.emplace_back();
        std::size_t i = 0;
        for (const auto v : mesh.vertices_around_face(mesh.halfedge(face))) corners[i++] = v;
    }
    return result;
}

int main(int count, char** words) { return raw::run(count, words, CGAL_VERSION_STR, build, simplify, arrays); }
