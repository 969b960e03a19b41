// SPDX-License-Identifier: GPL-3.0-or-later
// The user's patience or the time runs out: at every single moment at which the engine looks.
#include "parallel_failure.h"
#include "segment.h"

#include "test_meshes.h"
#include "thinning.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <thread>
#include <utility>

namespace spheroseg {
namespace {

using namespace test;

struct Trial {
    std::string name;
    TriangleMesh mesh;
    SegmentOptions options;
    /// Calls at which two threads are cancelled, besides the first one of each step, and half as
    /// many for one.
    int stops = 80;
};

SegmentOptions options_of(Method method, Effort effort, int submesh_count) {
    SegmentOptions options;
    options.method = method;
    options.effort = effort;
    options.submesh_count = submesh_count;
    options.thread_count = 2;
    if (effort == Effort::high) {
        options.max_refinement_iterations = 8;
    }
    return options;
}

/// Both methods; every way in which `fast` starts.
std::vector<Trial> trials() {
    return {
        {"fast, coarse trials", displaced_sphere(3), options_of(Method::fast, Effort::draft, 8)},
        {"fast, fine trials", flipped_sphere(2, 200), options_of(Method::fast, Effort::draft, 40)},
        {"fast, no trials", displaced_sphere(4), options_of(Method::fast, Effort::draft, 130)},
        {"fast, single start", displaced_sphere(2), options_of(Method::fast, Effort::high, 60)},
        {"fast, sphere start",
         mesh_for_a_sphere_start(),
         options_of(Method::fast, Effort::high, 50),
         2 * kThinning},
        {"fast, slivers", slivers(60, true), options_of(Method::fast, Effort::draft, 30)},
        {"all_pairs", icosphere(2), options_of(Method::all_pairs, Effort::standard, 20)},
        {"all_pairs, needle",
         long_thin_limb(3, 60),
         options_of(Method::all_pairs, Effort::standard, 7)},
    };
}

/// What a run reports and returns.
struct Watched {
    /// The first call of each step.
    std::map<std::string, int> first_calls;
    int call_count = 0;
    std::vector<int> labels;

    Watched(const Trial& trial, PreparedMesh& prepared) {
        labels = segment(prepared, trial.options, [&](double, const char* step) {
                     first_calls.emplace(step, ++call_count);
                     return true;
                 }).labels;
    }

    /// About `number` calls, from the first one on.
    std::set<int> some_calls(int number) const {
        std::set<int> calls;
        for (int call = 1; call <= call_count; call += 1 + call_count / number) {
            calls.insert(call);
        }
        return calls;
    }
};

/// Cancels a run at each of these calls; returns the part of them that heard of it.
double
cancel_at_calls(const Trial& trial, const std::set<int>& stops, const std::vector<int>& labels) {
    int runs = 0;
    int reached = 0;
    for (int stop : stops) {
        PreparedMesh prepared(trial.mesh, 2);
        int left = stop;
        bool cancelled = false;
        try {
            segment(prepared, trial.options, [&](double, const char*) { return --left > 0; });
        } catch (const Cancelled&) {
            cancelled = true;
        }
        EXPECT_EQ(cancelled, left <= 0);
        EXPECT_GE(left, 0) << "called again after it said stop";
        reached += cancelled;
        if (runs++ % 5 == 0) {
            EXPECT_EQ(segment(prepared, trial.options).labels, labels) << stop;
        }
    }
    return static_cast<double>(reached) / runs;
}

TEST(Cancel, AtAnyCallOfEveryStepLeavesTheMeshUsable) {
    std::set<std::string> steps;
    for (Trial trial : trials()) {
        SCOPED_TRACE(trial.name);
        PreparedMesh fresh(trial.mesh, 1);
        const Watched run(trial, fresh);
        std::set<int> stops = run.some_calls(trial.stops / kThinning);
        for (const auto& [step, call] : run.first_calls) {
            steps.insert(step);
            stops.insert(call);
        }
        const bool maps =
            trial.name == "fast, sphere start" || trial.options.method == Method::all_pairs;
        EXPECT_EQ(run.first_calls.count("Mapping to the sphere"), maps ? 1u : 0u);
        // How many calls there are depends on which thread does what, where they share tasks.
        EXPECT_GT(cancel_at_calls(trial, stops, run.labels), 0.0);
        trial.options.thread_count = 1;
        PreparedMesh another(trial.mesh, 1);
        const Watched alone(trial, another);
        EXPECT_EQ(alone.labels, run.labels);
        EXPECT_EQ(cancel_at_calls(trial, alone.some_calls(trial.stops / 2 / kThinning), run.labels),
                  1.0);
    }
    for (const char* step : {"Simplifying the mesh",
                             "Mapping to the sphere",
                             "Cohesion",
                             "Trials",
                             "Relaxation",
                             "Refinement",
                             "Exchanges"}) {
        EXPECT_EQ(steps.count(step), 1u) << step << " was never reached";
    }
}

TEST(Cancel, OfTheSphericalMapAtEveryCallLeavesTheMeshUsable) {
    const TriangleMesh mesh = displaced_sphere(3);
    const auto cancelled_after = [&](PreparedMesh& prepared, int calls) {
        try {
            prepared.parametrization(2, [&](double, const char*) { return --calls > 0; });
        } catch (const Cancelled&) {
            return true;
        }
        return false;
    };
    int calls = 1;
    for (;; calls += kThinning) {
        PreparedMesh prepared(mesh, 2);
        if (!cancelled_after(prepared, calls)) {
            break;
        }
        EXPECT_TRUE(is_valid_parametrization(mesh, prepared.parametrization(2).positions));
    }
    EXPECT_GT(calls, 20);
}

TEST(Cancel, WorksWhileABalanceIsSearchedForThatDoesNotExist) {
    const TriangleMesh tree = random_tree(1500, 1);
    const SegmentOptions options = options_of(Method::fast, Effort::draft, 60);
    PreparedMesh prepared(tree, 2);
    double last = 0.0;
    int searches = 0;
    const Segmentation result = segment(prepared, options, [&](double fraction, const char* step) {
        EXPECT_GE(fraction, last) << step;
        last = fraction;
        searches += step == std::string("Balancing");
        return true;
    });
    EXPECT_GT(result.measures.max_triangle_count_difference, 1);
    EXPECT_GT(searches, 20);
    EXPECT_THROW(
        segment(prepared,
                options,
                [&](double, const char* step) { return step != std::string("Balancing"); }),
        Cancelled);
}

TEST(TimeLimit, OfNearlyNothingLeavesAValidResult) {
    // Sub-meshes that were not annealed can often not be balanced here.
    const TriangleMesh mesh = flipped_sphere(5, 40000);
    const int face_count = mesh.face_count();
    for (int k : {2, 20, 200, face_count / 8, face_count / 3}) {
        for (bool by_weight : {false, true}) {
            PreparedMesh prepared(mesh, 2);
            SegmentOptions options;
            options.submesh_count = k;
            options.balance = by_weight ? Balance::weight : Balance::triangle_count;
            options.time_limit_seconds = 1e-9;
            const Segmentation result = segment(prepared, options);
            EXPECT_TRUE(result.time_limit_hit);
            EXPECT_TRUE(result.measures.is_valid(by_weight ? face_count : 1)) << k;
        }
    }
}

// However long everything before it takes.
TEST(TimeLimit, LeavesTimeToSearchForABalance) {
    PreparedMesh prepared(stacked(1000, 1), 2);
    SegmentOptions options;
    options.submesh_count = 250;
    options.time_limit_seconds = 1e-9;
    bool dawdled = false;
    const Segmentation result = segment(prepared, options, [&](double, const char*) {
        if (!std::exchange(dawdled, true)) {
            std::this_thread::sleep_for(std::chrono::milliseconds(1100));
        }
        return true;
    });
    EXPECT_TRUE(result.time_limit_hit);
    EXPECT_TRUE(result.measures.is_valid());
}

TEST(TimeLimit, ThatIsHitAtOnceGivesTheLabelsOfDraft) {
    const TriangleMesh mesh = limbed_figure(4);
    for (int k : {7, 60, 640}) {
        SegmentOptions options;
        options.submesh_count = k;
        options.effort = Effort::draft;
        PreparedMesh prepared(mesh, 2);
        const std::vector<int> labels = segment(prepared, options).labels;
        for (Effort effort : {Effort::draft, Effort::standard, Effort::high}) {
            options.effort = effort;
            options.time_limit_seconds = 1e-9;
            EXPECT_EQ(segment(prepared, options).labels, labels) << k;
        }
    }
}

TEST(TimeLimit, ThatIsHitAtAnyCallLeavesABalancedResultAndIsReported) {
    constexpr double kLimit = 0.03;
    for (Trial trial : trials()) {
        SCOPED_TRACE(trial.name);
        PreparedMesh prepared(trial.mesh, 2);
        const std::vector<int> unlimited = segment(prepared, trial.options).labels;
        const int calls = Watched(trial, prepared).call_count;
        trial.options.time_limit_seconds = kLimit;
        for (int late = 1; late < calls; late += 1 + calls / 40) {
            int left = late;
            const auto dawdle = [&](double fraction, const char*) {
                if (fraction < 1.0 && --left == 0) {
                    std::this_thread::sleep_for(std::chrono::duration<double>(kLimit));
                }
                return true;
            };
            const Segmentation result = segment(prepared, trial.options, dawdle);
            const bool fast = trial.options.method == Method::fast;
            EXPECT_LE(result.measures.max_triangle_count_difference, 1) << late;
            // The last calls may not come (their number depends on which thread does what), and the
            // very last one says that all is done.
            const bool is_hit = result.time_limit_hit || left > 0;
            EXPECT_TRUE(!fast || (result.measures.is_valid() && is_hit)) << late;
            if (!result.time_limit_hit) {
                EXPECT_EQ(result.labels, unlimited) << "cut short without a word at " << late;
            }
        }
    }
}

TEST(TimeLimit, ThatCutsHighShortLeavesNoLongerBoundariesThanStandard) {
    PreparedMesh prepared(displaced_sphere(4), 2);
    SegmentOptions options;
    options.submesh_count = 60;
    const int standard = segment(prepared, options).measures.boundary_edge_count;
    options.effort = Effort::high;
    options.time_limit_seconds = 1.0;
    bool dawdled = false;
    // What `high` holds in reserve is made within the first fifth.
    const auto dawdle = [&](double fraction, const char*) {
        if (fraction > 0.2 && !dawdled) {
            dawdled = true;
            std::this_thread::sleep_for(std::chrono::seconds(1));
        }
        return true;
    };
    const Segmentation high = segment(prepared, options, dawdle);
    EXPECT_TRUE(high.measures.is_valid());
    EXPECT_TRUE(high.time_limit_hit);
    EXPECT_LE(high.measures.boundary_edge_count, standard);
}

TEST(ParallelFailure, TakesAnExceptionOutOfAParallelRegion) {
    ParallelFailure failure;
    int done = 0;
#pragma omp parallel for num_threads(2) reduction(+ : done)
    for (int i = 0; i < 100; ++i) {
        failure.guard([&] {
            if (i % 10 == 3) {
                throw InvalidInput("thrown by a thread");
            }
            ++done;
        });
    }
    EXPECT_EQ(done, 90);
    EXPECT_THROW(failure.rethrow(), InvalidInput);
    EXPECT_NO_THROW(ParallelFailure().rethrow());
}

} // namespace
} // namespace spheroseg
