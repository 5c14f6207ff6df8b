// One run of CGAL's edge collapse on a raw mesh:
// lindstrom-turk|garland-heckbert faces COUNT THREADS REPEATS INPUT OUTPUT.
// Prints the least time of the calls in seconds, the faces of the result, a dash for the memory, and the least time of
// the core.

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_filter.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/GarlandHeckbert_policies.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

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

template <class T>
std::vector<T> take(std::FILE* file, std::size_t count) {
    std::vector<T> values(count);
    if (std::fread(values.data(), sizeof(T), count, file) != count) std::exit(2);
    return values;
}

static Mesh read(const char* path) {
    std::FILE* file = std::fopen(path, "rb");
    if (!file) std::exit(2);
    const auto counts = take<std::uint64_t>(file, 2);
    const auto coordinates = take<double>(file, 3 * counts[0]);
    const auto corners = take<std::uint32_t>(file, 3 * counts[1]);
    std::fclose(file);
    Mesh mesh;
    for (std::size_t i = 0; i < coordinates.size(); i += 3)
        mesh.add_vertex({coordinates[i], coordinates[i + 1], coordinates[i + 2]});
    std::size_t refused = 0;
    for (std::size_t i = 0; i < corners.size(); i += 3) {
        using Vertex = Mesh::Vertex_index;
        const auto face = mesh.add_face(Vertex(corners[i]), Vertex(corners[i + 1]), Vertex(corners[i + 2]));
        refused += face == Mesh::null_face();
    }
    if (refused) {
        std::fprintf(stderr, "%zu faces are refused\n", refused);
        std::exit(1);
    }
    return mesh;
}

static void write(const char* path, const Mesh& mesh) {
    std::FILE* file = std::fopen(path, "wb");
    if (!file) std::exit(2);
    const std::uint64_t counts[] = {mesh.number_of_vertices(), mesh.number_of_faces()};
    std::fwrite(counts, sizeof(std::uint64_t), 2, file);
    for (const auto vertex : mesh.vertices()) {
        const auto& point = mesh.point(vertex);
        const double coordinates[] = {point.x(), point.y(), point.z()};
        std::fwrite(coordinates, sizeof(double), 3, file);
    }
    for (const auto face : mesh.faces())
        for (const auto vertex : mesh.vertices_around_face(mesh.halfedge(face))) {
            const std::uint32_t corner = vertex;
            std::fwrite(&corner, sizeof corner, 1, file);
        }
    std::fclose(file);
}

int main(int, char** arguments) {
    const std::string kind = arguments[1];
    const FewFaces stop{static_cast<std::size_t>(std::atof(arguments[3]))};
    const int repeats = std::atoi(arguments[5]);
    const Mesh original = read(arguments[6]);
    double least = 1e300, least_cpu = 1e300, sum = 0;
    Mesh mesh;
    for (int i = 0; i < repeats && sum < 10; ++i) {
        mesh = original;
        const auto worked = std::clock();
        const auto start = std::chrono::steady_clock::now();
        if (kind == "lindstrom-turk") {
            collapse::edge_collapse(mesh, stop);
        } else {
            collapse::GarlandHeckbert_policies<Mesh, Kernel> policies(mesh);
            const auto parameters = CGAL::parameters::get_cost(policies.get_cost())
                                        .get_placement(policies.get_placement())
                                        .filter(collapse::Bounded_normal_change_filter<>());
            collapse::edge_collapse(mesh, stop, parameters);
        }
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
        least = std::min(least, seconds.count());
        least_cpu = std::min(least_cpu, double(std::clock() - worked) / CLOCKS_PER_SEC);
        sum += seconds.count();
    }
    mesh.collect_garbage();
    write(arguments[7], mesh);
    std::printf("%.6f %zu - %.6f\n", least, static_cast<std::size_t>(mesh.number_of_faces()), least_cpu);
}
