// SPDX-License-Identifier: GPL-3.0-or-later
// Pair tests per second of the cohesion loop of `all_pairs`, beside the most additions,
// multiplications and square roots per second that one core reaches. One line of JSON on stdout.
#include "all_pairs_cohesion.h"
#include "random.h"
#include "threads.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <limits>

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define SPHEROSEG_WIDEST_VECTORS __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define SPHEROSEG_WIDEST_VECTORS
#endif

using namespace spheroseg;

namespace {

constexpr int kRepeats = 15;
constexpr int kKernelRepeats = 200;
constexpr int kLanes = 16;
constexpr int kChains = 8;
constexpr int kSteps = 1 << 17;

using Vector = float __attribute__((vector_size(kLanes * sizeof(float))));

volatile float sink;

/// One multiplication and one addition per lane, chain and step, all independent.
SPHEROSEG_WIDEST_VECTORS
void multiply_and_add() {
    Vector products[kChains];
    Vector sums[kChains];
    for (int c = 0; c < kChains; ++c) {
        products[c] = Vector{} + (1.0f + static_cast<float>(c));
        sums[c] = Vector{} + static_cast<float>(c);
    }
    const Vector factor = Vector{} + 0.9999999f;
    const Vector summand = Vector{} + 1e-7f;
    for (int step = 0; step < kSteps; ++step) {
#pragma GCC unroll 8
        for (int c = 0; c < kChains; ++c) {
            products[c] *= factor;
            sums[c] += summand;
        }
    }
    Vector total{};
    for (int c = 0; c < kChains; ++c) {
        total += products[c] + sums[c];
    }
    sink = total[0];
}

/// One square root per lane, chain and step, all independent within a step, of numbers whose roots
/// have no short form (dividers may finish those early).
SPHEROSEG_WIDEST_VECTORS
void take_roots() {
    float values[kLanes * kChains];
    for (int i = 0; i < kLanes * kChains; ++i) {
        values[i] = 2.0f + static_cast<float>(i);
    }
    for (int step = 0; step < kSteps; ++step) {
        for (int i = 0; i < kLanes * kChains; ++i) {
            values[i] = __builtin_sqrtf(values[i] + 3.7f);
        }
    }
    sink = values[kLanes];
}

template <typename Function> double least_seconds(const Function& function) {
    double least = std::numeric_limits<double>::infinity();
    for (int repeat = 0; repeat < kKernelRepeats; ++repeat) {
        const StopWatch watch;
        function();
        least = std::min(least, watch.elapsed_seconds());
    }
    return least;
}

struct Throughput {
    double pairs_per_second = 0.0;
    /// Processor time of all threads; on a busy machine the fairer number for one thread.
    double pairs_per_processor_second = 0.0;
};

/// Faces at random places of the sphere, each a sub-mesh of its own: no pair swaps, so that an
/// iteration is the pair tests alone.
Throughput measure_pair_tests(int face_count, int thread_count) {
    DualGraph graph;
    graph.neighbors.assign(face_count, {-1, -1, -1});
    std::vector<Vec3> centroids(face_count);
    std::vector<int> labels(face_count);
    Random random(0);
    for (int f = 0; f < face_count; ++f) {
        const Vec3 p{random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
        centroids[f] = p * (1.0 / length(p));
        labels[f] = f;
    }
    SwapLimits limits;
    limits.thread_count = thread_count;
    limits.max_iterations = 1;
    const double pairs = 0.5 * face_count * (face_count - 1.0);
    Throughput best;
    for (int repeat = 0; repeat < kRepeats; ++repeat) {
        const std::clock_t begin = std::clock();
        const SwapIterations history =
            cohere_all_pairs(graph, centroids, face_count, 0, limits, labels);
        const double processor_seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
        best.pairs_per_second = std::max(best.pairs_per_second, pairs / history.seconds.front());
        best.pairs_per_processor_second =
            std::max(best.pairs_per_processor_second, pairs / processor_seconds);
    }
    return best;
}

} // namespace

int main(int argc, char** argv) {
    if (argc < 2) {
        std::fprintf(stderr, "usage: pair_throughput FACE_COUNT...\n");
        return 2;
    }
    const double lanes = static_cast<double>(kSteps) * kLanes * kChains;
    std::printf("{\"multiplications_and_additions_per_second\": %.4g, "
                "\"square_roots_per_second\": %.4g, \"cores\": %d, \"runs\": [",
                2.0 * lanes / least_seconds(multiply_and_add),
                lanes / least_seconds(take_roots),
                resolve_thread_count(0));
    for (int i = 1; i < argc; ++i) {
        for (int threads = 1; threads <= resolve_thread_count(0); threads *= 2) {
            const Throughput best = measure_pair_tests(std::atoi(argv[i]), threads);
            std::printf("%s{\"face_count\": %d, \"thread_count\": %d, "
                        "\"pairs_per_second\": %.4g, \"pairs_per_processor_second\": %.4g}",
                        i == 1 && threads == 1 ? "" : ", ",
                        std::atoi(argv[i]),
                        threads,
                        best.pairs_per_second,
                        best.pairs_per_processor_second);
        }
    }
    std::printf("]}\n");
    return 0;
}
