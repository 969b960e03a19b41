// SPDX-License-Identifier: GPL-3.0-or-later
// Spherical parametrization of raw meshes: a row of a Markdown table for each. Usage:
//   map_quality THREADS RAW_MESH...
#include "dual_graph.h"
#include "parametrization.h"
#include "progress.h"
#include "raw_mesh.h"

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>

int main(int argc, char** argv) {
    using namespace spheroseg;
    const int threads = argc > 1 ? std::atoi(argv[1]) : 0;
    try {
        for (int i = 2; i < argc; ++i) {
            const TriangleMesh mesh = read_raw_mesh(argv[i]);
            const DualGraph graph = build_dual_graph(mesh, threads);
            const StopWatch watch;
            const CollapseHierarchy hierarchy = build_hierarchy(mesh, graph, threads);
            const double hierarchy_seconds = watch.elapsed_seconds();
            const Parametrization map = parametrize(mesh, hierarchy, threads);
            const double seconds = watch.elapsed_seconds();
            const ParametrizationQuality quality = measure_parametrization(mesh, map.positions);
            std::printf("| %s | %d | %d | %.2f | %.3g | %.3g | %.3f | %.3f |\n",
                        std::filesystem::path(argv[i]).stem().c_str(),
                        mesh.face_count(),
                        quality.flipped_triangle_count,
                        quality.anisotropy_mean,
                        quality.area_distortion_mean,
                        quality.area_distortion_max,
                        hierarchy_seconds,
                        seconds);
        }
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
    return 0;
}
