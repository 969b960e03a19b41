// SPDX-License-Identifier: GPL-3.0-or-later
// The methods on the cores and on the GPU: whether the labels are equal, and the times per step, as
// a Markdown table. Needs nothing but the engine.
#include "device.h"
#include "mesh_file.h"
#include "segment.h"
#include "threads.h"

#include "../tests/engine/test_solids.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <map>

using namespace spheroseg;

namespace {

constexpr const char* kUsage = R"(usage: spheroseg-bench [OPTIONS] MESH...

MESH is a .ply, .obj or .raw file, or a generated mesh: sphere:N (icosphere of 20 * 4^N triangles,
N from 0 to 9) or bumpy:N (the same with smooth bumps). Without a MESH: sphere:4, bumpy:5.

  --fast             the method fast instead of all_pairs
  --k N              number of sub-meshes (200)
  --per N            triangles per sub-mesh instead
  --seed N           (0)
  --iterations N     most iterations of cohesion and of refinement; 0: until converged (0)
  --repeats N        runs on the GPU, of which the fastest counts (3)
  --cores-up-to N    also on the cores, for comparison, up to so many triangles (30000)
  --require-gpu      fail where no GPU can be used, and where labels differ
)";

struct Settings {
    Method method = Method::all_pairs;
    int k = 200;
    int per = 0;
    int seed = 0;
    int iterations = 0;
    int repeats = 3;
    int cores_up_to = 30000;
    bool require_gpu = false;
    std::vector<std::string> meshes;
};

TriangleMesh make_mesh(const std::string& name) {
    const bool bumpy = name.rfind("bumpy:", 0) == 0;
    if (!bumpy && name.rfind("sphere:", 0) != 0) {
        return MeshFile::read(name);
    }
    const std::string level = name.substr(name.find(':') + 1);
    if (level.size() != 1 || level[0] < '0' || level[0] > '9') {
        throw InvalidInput("Expected a number from 0 to 9 after the colon, found " + name + ".");
    }
    TriangleMesh mesh = test::icosphere(level[0] - '0');
    for (Vec3& p : mesh.positions) {
        p = bumpy ? p * (1.0 + 0.25 * std::sin(7 * p.x) * std::sin(5 * p.y + 2 * p.z)) : p;
    }
    return mesh;
}

Segmentation run(PreparedMesh& mesh, const Settings& settings, Device device) {
    SegmentOptions options;
    options.method = settings.method;
    options.device = device;
    options.submesh_count = std::min(settings.k, mesh.mesh().face_count());
    options.triangles_per_submesh = settings.per;
    options.seed = static_cast<std::uint64_t>(settings.seed);
    options.max_cohesion_iterations = settings.iterations;
    options.max_refinement_iterations = settings.iterations;
    return segment(mesh, options);
}

void print_row(const std::string& name,
               const Segmentation& s,
               const char* device,
               const char* comparison) {
    std::printf("| %s | %d | %d | %s | %.4f | %.4f | %d | %.4f | %d | %d | %d | %s |\n",
                name.c_str(),
                s.measures.triangle_count,
                s.measures.submesh_count,
                device,
                s.total_seconds,
                s.cohesion_seconds,
                s.cohesion_iterations,
                s.refinement_seconds,
                s.refinement_iterations,
                s.measures.boundary_edge_count,
                s.measures.bowtie_count,
                comparison);
    std::fflush(stdout);
}

/// False when the GPU's labels, energies or counts differ from those of the cores.
bool bench(const std::string& name, const Settings& settings, bool has_gpu) {
    PreparedMesh mesh(make_mesh(name));
    if (settings.method == Method::all_pairs) {
        mesh.parametrization();
    }
    const bool on_cores = mesh.mesh().face_count() <= settings.cores_up_to;
    Segmentation cores;
    if (on_cores) {
        cores = run(mesh, settings, Device::cpu);
        print_row(name, cores, "cores", "reference");
    }
    if (!has_gpu) {
        return true;
    }
    Segmentation best;
    bool equal = true;
    for (int i = 0; i < std::max(1, settings.repeats); ++i) {
        const Segmentation gpu = run(mesh, settings, Device::cuda);
        equal = equal &&
            (!on_cores ||
             (gpu.labels == cores.labels && gpu.energy_by_iteration == cores.energy_by_iteration &&
              gpu.boundary_edges_by_iteration == cores.boundary_edges_by_iteration));
        equal = equal && (i == 0 || gpu.labels == best.labels);
        const double seconds = gpu.cohesion_seconds + gpu.refinement_seconds;
        if (i == 0 || seconds < best.cohesion_seconds + best.refinement_seconds) {
            best = gpu;
        }
    }
    print_row(name, best, "GPU", !equal ? "DIFFERENT" : on_cores ? "equal" : "equal in all runs");
    return equal;
}

Settings parse(int argc, char** argv) {
    Settings settings;
    const std::map<std::string, int*> numbers = {{"--k", &settings.k},
                                                 {"--per", &settings.per},
                                                 {"--seed", &settings.seed},
                                                 {"--iterations", &settings.iterations},
                                                 {"--repeats", &settings.repeats},
                                                 {"--cores-up-to", &settings.cores_up_to}};
    for (int i = 1; i < argc; ++i) {
        const std::string argument = argv[i];
        const auto number = numbers.find(argument);
        if (number != numbers.end() && i + 1 < argc) {
            *number->second = std::atoi(argv[++i]);
        } else if (argument == "--fast") {
            settings.method = Method::fast;
        } else if (argument == "--require-gpu") {
            settings.require_gpu = true;
        } else if (argument.rfind("-", 0) == 0) {
            std::fputs(kUsage, argument == "--help" ? stdout : stderr);
            std::exit(argument == "--help" ? 0 : 2);
        } else {
            settings.meshes.push_back(argument);
        }
    }
    if (settings.meshes.empty()) {
        settings.meshes = {"sphere:4", "bumpy:5"};
    }
    return settings;
}

} // namespace

int main(int argc, char** argv) {
    const Settings settings = parse(argc, argv);
    try {
        const cuda::DeviceSearch search = cuda::find_device();
        std::printf("Cores: %d. GPU: %s.\n\n",
                    resolve_thread_count(0),
                    search.device ? search.device->info().name.c_str() : search.reason.c_str());
        if (!search.device && settings.require_gpu) {
            return 1;
        }
        std::printf(
            "| mesh | triangles | k | on | total s | cohesion s | iterations | refinement s | "
            "iterations | boundary edges | bowties | labels |\n"
            "|---|---|---|---|---|---|---|---|---|---|---|---|\n");
        bool equal = true;
        for (const std::string& name : settings.meshes) {
            equal = bench(name, settings, search.device != nullptr) && equal;
        }
        return equal ? 0 : 1;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
