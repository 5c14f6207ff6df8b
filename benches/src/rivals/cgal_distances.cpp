// The Hausdorff distance of two raw meshes by CGAL: bounded|sampled VALUE REPEATS FIRST SECOND.
//
// The value is a tolerance, or the number of points in each direction. Prints the least seconds of the calls, the least
// seconds of the core, a dash for the memory, a lower and an upper bound; a dash if there is none.

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

// Before the distance, which uses the midpoints of 3D without including them.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <CGAL/Polygon_mesh_processing/distance.h>
#include <CGAL/Random.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>

namespace processing = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Simple_cartesian<double>;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

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
    for (std::size_t i = 0; i < corners.size(); i += 3) {
        using Vertex = Mesh::Vertex_index;
        if (mesh.add_face(Vertex(corners[i]), Vertex(corners[i + 1]), Vertex(corners[i + 2])) == Mesh::null_face()) {
            std::fprintf(stderr, "a face is refused\n");
            std::exit(1);
        }
    }
    return mesh;
}

int main(int count, char** words) {
    if (count != 6) return 2;
    const std::string method = words[1];
    const double value = std::atof(words[2]);
    const int repeats = std::atoi(words[3]);
    const Mesh first = read(words[4]), second = read(words[5]);
    double least = 1e300, least_cpu = 1e300, sum = 0, found = 0;
    for (int i = 0; i < repeats && sum < 10; ++i) {
        CGAL::get_default_random() = CGAL::Random(1);
        const auto worked = std::clock();
        const auto start = std::chrono::steady_clock::now();
        if (method == "bounded") {
            found = processing::bounded_error_symmetric_Hausdorff_distance<CGAL::Sequential_tag>(first, second, value);
        } else {
            const auto points = [value](const Mesh& mesh) {
                return CGAL::parameters::number_of_points_on_faces(std::size_t(value))
                    .number_of_points_on_edges(0)
                    .do_sample_edges(false);
            };
            found = processing::approximate_symmetric_Hausdorff_distance<CGAL::Sequential_tag>(
                first, second, points(first), points(second));
        }
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
        least = std::min(least, seconds.count());
        least_cpu = std::min(least_cpu, double(std::clock() - worked) / CLOCKS_PER_SEC);
        sum += seconds.count();
    }
    // The estimate is at most the tolerance away from the distance.
    if (method == "bounded")
        std::printf("%.6f %.6f - %.17g %.17g\n", least, least_cpu, std::max(found - value, 0.0), found + value);
    else
        std::printf("%.6f %.6f - %.17g -\n", least, least_cpu, found);
}
