// SPDX-License-Identifier: GPL-3.0-or-later
// Segments a mesh by `all_pairs` for several seeds; one line of JSON per seed on stdout.
#include "raw_mesh.h"
#include "segment.h"

#include <cstdio>
#include <cstdlib>
#include <exception>

using namespace spheroseg;

namespace {

void print_measures(const char* name, const Measures& m) {
    std::printf("\"%s\": {\"boundary_edge_count\": %d, \"bowtie_count\": %d, "
                "\"disconnected_submesh_count\": %d, \"max_triangle_count_difference\": %d}, ",
                name,
                m.boundary_edge_count,
                m.bowtie_count,
                m.disconnected_submesh_count,
                m.max_triangle_count_difference);
}

void print_list(const char* name, const std::vector<double>& values, const char* end) {
    std::printf("\"%s\": [", name);
    for (std::size_t i = 0; i < values.size(); ++i) {
        std::printf("%s%.10g", i == 0 ? "" : ", ", values[i]);
    }
    std::printf("]%s", end);
}

void print_segmentation(const Segmentation& s, std::uint64_t seed, const PreparedMesh& mesh) {
    std::printf("{\"seed\": %llu, \"triangle_count\": %d, ",
                static_cast<unsigned long long>(seed),
                mesh.mesh().face_count());
    print_measures("after_cohesion", s.measures_after_cohesion);
    print_measures("after_refinement", s.measures);
    std::printf("\"cohesion_iterations\": %d, \"refinement_iterations\": %d, "
                "\"cohesion_seconds\": %.6f, \"refinement_seconds\": %.6f, ",
                s.cohesion_iterations,
                s.refinement_iterations,
                s.cohesion_seconds,
                s.refinement_seconds);
    print_list("boundary_edges_by_iteration", s.boundary_edges_by_iteration, ", ");
    print_list("energy_by_iteration", s.energy_by_iteration, "}\n");
    std::fflush(stdout);
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 5) {
        std::fprintf(stderr, "usage: reproduce MESH.raw SUBMESH_COUNT SEED_COUNT THREAD_COUNT\n");
        return 2;
    }
    try {
        PreparedMesh mesh(read_raw_mesh(argv[1]));
        SegmentOptions options;
        options.method = Method::all_pairs;
        options.device = Device::cpu;
        options.submesh_count = std::atoi(argv[2]);
        options.thread_count = std::atoi(argv[4]);
        for (int seed = 0; seed < std::atoi(argv[3]); ++seed) {
            options.seed = seed;
            print_segmentation(segment(mesh, options), options.seed, mesh);
        }
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
    return 0;
}
