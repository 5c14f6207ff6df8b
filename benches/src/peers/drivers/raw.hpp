// What every compiled driver does: NAME faces COUNT THREADS REPEATS INPUT OUTPUT.
//
// Reads a raw mesh, calls a library several times, and writes the last result. Prints the least time of the calls in
// seconds, the faces of the result, a dash for the memory, and the least time of the core.
// With --version instead, it prints the version of the library.

#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

namespace raw {

struct Mesh {
    std::vector<std::array<double, 3>> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
};

[[noreturn]] inline void fail(const std::string& reason) {
    std::fprintf(stderr, "%s\n", reason.c_str());
    std::exit(1);
}

template <class T>
void take(std::FILE* file, std::vector<T>& values, std::size_t count) {
    values.resize(count);
    if (std::fread(values.data(), sizeof(T), count, file) != count) fail("the input is too short");
}

inline Mesh read(const char* path) {
    std::FILE* file = std::fopen(path, "rb");
    if (!file) fail("the input cannot be read");
    std::vector<std::uint64_t> counts;
    Mesh mesh;
    take(file, counts, 2);
    take(file, mesh.vertices, counts[0]);
    take(file, mesh.triangles, counts[1]);
    std::fclose(file);
    return mesh;
}

inline void write(const char* path, const Mesh& mesh) {
    std::FILE* file = std::fopen(path, "wb");
    if (!file) fail("the output cannot be written");
    const std::uint64_t counts[] = {mesh.vertices.size(), mesh.triangles.size()};
    std::fwrite(counts, sizeof counts[0], 2, file);
    std::fwrite(mesh.vertices.data(), sizeof mesh.vertices[0], mesh.vertices.size(), file);
    std::fwrite(mesh.triangles.data(), sizeof mesh.triangles[0], mesh.triangles.size(), file);
    std::fclose(file);
}

// `build` makes the mesh of the library, and `arrays` the arrays of one; neither is timed. `simplify` gets a copy of the
// mesh, the name of the tool and the number of faces.
template <class Build, class Simplify, class Arrays>
int run(int count, char** words, const char* version, Build build, Simplify simplify, Arrays arrays) {
    if (count == 2 && std::string(words[1]) == "--version") {
        std::printf("%s\n", version);
        return 0;
    }
    if (count != 8) fail("expected NAME faces COUNT THREADS REPEATS INPUT OUTPUT");
    const std::string name = words[1];
    const auto faces = static_cast<std::size_t>(std::atof(words[3]));
    const int repeats = std::atoi(words[5]);
    const auto original = build(read(words[6]));
    double least = 1e300, least_cpu = 1e300, sum = 0;
    auto mesh = original;
    for (int i = 0; i < repeats && sum < 10; ++i) {
        mesh = original;
        const auto worked = std::clock();
        const auto start = std::chrono::steady_clock::now();
        simplify(mesh, name, faces);
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
        least = std::min(least, seconds.count());
        least_cpu = std::min(least_cpu, double(std::clock() - worked) / CLOCKS_PER_SEC);
        sum += seconds.count();
    }
    const Mesh result = arrays(mesh);
    write(words[7], result);
    std::printf("%.6f %zu - %.6f\n", least, result.triangles.size(), least_cpu);
    return 0;
}

}  // namespace raw
