// What every compiled peer of the study of curvature does: PROGRAM FOLDER METHOD RADIUS.
//
// Reads the raw arrays vertices.raw (double) and faces.raw (uint32) of the folder, writes both principal curvatures of
// every vertex to out.raw (double, two per vertex), and prints the seconds of processor time of the computation and the
// bytes that it used beyond the input (a dash if the system does not report them).
// With --version instead, it prints the version of the library.

#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <string>
#include <vector>

namespace peer {

struct Input {
    std::vector<std::array<double, 3>> vertices;
    std::vector<std::array<std::uint32_t, 3>> faces;
    std::string method;
    double radius;
};

using Curvatures = std::vector<std::array<double, 2>>;

template <class T>
std::vector<T> read_all(const std::string& path) {
    std::FILE* file = std::fopen(path.c_str(), "rb");
    if (!file) std::exit(2);
    std::vector<T> values;
    T value;
    while (std::fread(&value, sizeof(T), 1, file) == 1) values.push_back(value);
    std::fclose(file);
    return values;
}

// The number of bytes in a line of the status of this process; -1 if the system does not report it.
inline long long memory(const std::string& field) {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
        if (line.compare(0, field.size(), field) == 0) return 1024 * std::atoll(line.c_str() + field.size());
    return -1;
}

[[noreturn]] inline void fail(const char* reason) {
    std::fprintf(stderr, "%s\n", reason);
    std::exit(1);
}

// `prepare` makes the mesh of the library, and is not timed. `compute` returns the curvatures. `calls` is how often it
// calls the library for what one call computes.
template <class Prepare, class Compute>
int run(int count, char** words, const char* version, Prepare prepare, Compute compute, int calls = 1) {
    if (count == 2 && std::string(words[1]) == "--version") {
        std::printf("%s\n", version);
        return 0;
    }
    if (count != 4) fail("expected FOLDER METHOD RADIUS");
    const std::string folder = std::string(words[1]) + "/";
    Input input;
    input.vertices = read_all<std::array<double, 3>>(folder + "vertices.raw");
    input.faces = read_all<std::array<std::uint32_t, 3>>(folder + "faces.raw");
    input.method = words[2];
    input.radius = std::atof(words[3]);
    auto mesh = prepare(input);
    // Resets the peak.
    std::ofstream("/proc/self/clear_refs") << 5;
    const long long before = memory("VmRSS:");
    const std::clock_t start = std::clock();
    const Curvatures found = compute(mesh, input);
    const double seconds = double(std::clock() - start) / CLOCKS_PER_SEC / calls;
    const std::string used = before < 0 ? "-" : std::to_string(std::max(memory("VmHWM:") - before, 0LL));
    std::FILE* file = std::fopen((folder + "out.raw").c_str(), "wb");
    if (!file || std::fwrite(found.data(), sizeof(found[0]), found.size(), file) != found.size()) return 2;
    std::fclose(file);
    std::printf("%.9f %s\n", seconds, used.c_str());
    return 0;
}

}  // namespace peer
