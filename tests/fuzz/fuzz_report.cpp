// SPDX-License-Identifier: GPL-3.0-or-later
#include "fuzz_report.h"

#include <array>
#include <cstdio>
#include <cstdlib>

namespace spheroseg::fuzz {

namespace {

constexpr const char* kOutcomeNames[] = {
    "segmented", "impossible", "missed", "not_reached", "out_of_time", "refused", "cancelled"};

class Statistics {
public:
    static Statistics& get() {
        static Statistics statistics;
        return statistics;
    }
    ~Statistics() {
        const char* path = std::getenv("SPHEROSEG_FUZZ_STATISTICS");
        std::FILE* file = path ? std::fopen(path, "a") : nullptr;
        if (file) {
            for (std::size_t i = 0; i < counts.size(); ++i) {
                std::fprintf(file, "%s %lld ", kOutcomeNames[i], counts[i]);
            }
            std::fprintf(file, "\n");
            std::fclose(file);
        }
    }
    std::array<long long, static_cast<std::size_t>(Outcome::outcome_count)> counts{};
};

void print_case(std::FILE* file, const FuzzCase& one) {
    const SegmentOptions& options = one.options;
    std::fprintf(file,
                 "method %d effort %d submesh_count %d triangles_per_submesh %d seed %llu "
                 "thread_count %d iterations %d %d time_limit %g cancel_at_call %d balance %d\n",
                 static_cast<int>(options.method),
                 static_cast<int>(options.effort),
                 options.submesh_count,
                 options.triangles_per_submesh,
                 static_cast<unsigned long long>(options.seed),
                 options.thread_count,
                 options.max_cohesion_iterations,
                 options.max_refinement_iterations,
                 options.time_limit_seconds,
                 one.cancel_at_call,
                 static_cast<int>(options.balance));
    std::fprintf(file, "weights {");
    for (double weight : options.face_weights) {
        std::fprintf(file, "%.17g, ", weight);
    }
    std::fprintf(file, "} initial labels {");
    for (int label : options.initial_labels) {
        std::fprintf(file, "%d, ", label);
    }
    std::fprintf(file, "}\n");
    std::fprintf(file, "%d vertices, faces {", one.mesh.vertex_count());
    for (const Triangle& t : one.mesh.faces) {
        std::fprintf(file, "{%d, %d, %d}, ", t[0], t[1], t[2]);
    }
    std::fprintf(file, "}\n");
}

} // namespace

void count(Outcome outcome) {
    ++Statistics::get().counts[static_cast<std::size_t>(outcome)];
}

int counted(Outcome outcome) {
    return static_cast<int>(Statistics::get().counts[static_cast<std::size_t>(outcome)]);
}

void note_missed(const char* how,
                 const FuzzCase& one,
                 const Recount& recount,
                 int least_difference) {
    const char* path = std::getenv("SPHEROSEG_FUZZ_MISSED");
    std::FILE* file = path ? std::fopen(path, "a") : nullptr;
    if (file) {
        std::fprintf(file,
                     "%s: %d faces, MTCD %d (best %d), bowties %d, disconnected %d, empty %d\n",
                     how,
                     one.mesh.face_count(),
                     recount.max_triangle_count_difference,
                     least_difference,
                     recount.bowtie_count,
                     recount.disconnected_submesh_count,
                     recount.empty_submesh_count);
        print_case(file, one);
        std::fclose(file);
    }
}

void report_failure(const char* what, const FuzzCase& one) {
    std::fprintf(stderr, "\nDoes not hold: %s\n", what);
    print_case(stderr, one);
    std::abort();
}

} // namespace spheroseg::fuzz
