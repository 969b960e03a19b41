// SPDX-License-Identifier: GPL-3.0-or-later
// What must hold for every mesh and all options, as a libFuzzer target.
#include "exact_cuts.h"
#include "expectations.h"
#include "fuzz_case.h"
#include "fuzz_levels.h"
#include "fuzz_report.h"
#include "fuzz_sphere.h"
#include "random.h"
#include "recount.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace spheroseg::fuzz {
namespace {

void require(bool holds, const char* what, const FuzzCase& one) {
    if (!holds) {
        report_failure(what, one);
    }
}

void check_measures(const Measures& measures, const Recount& recount, const FuzzCase& one) {
    require(measures.submesh_triangles == recount.triangle_counts, "triangle counts", one);
    require(measures.max_triangle_count_difference == recount.max_triangle_count_difference,
            "max_triangle_count_difference",
            one);
    require(
        measures.boundary_edge_count == recount.boundary_edge_count, "boundary_edge_count", one);
    require(measures.disconnected_submesh_count == recount.disconnected_submesh_count,
            "disconnected_submesh_count",
            one);
    require(measures.bowtie_count == recount.bowtie_count, "bowtie_count", one);
    require(measures.disk_count == recount.disk_count, "disk_count", one);
}

/// Labels complete and in range; what the measures say is so.
Recount check_labels(const Segmentation& result, const Surface& surface, const FuzzCase& one) {
    const int submesh_count = result.measures.submesh_count;
    require(submesh_count == expected_submesh_count(one), "submesh_count", one);
    require(result.labels.size() == one.mesh.faces.size(), "one label per face", one);
    for (int label : result.labels) {
        require(label >= 0 && label < submesh_count, "labels in range", one);
    }
    const Recount recount = surface.recount(result.labels, submesh_count);
    check_measures(result.measures, recount, one);
    if (!has_vague_weights(one)) {
        const double imbalance =
            recount_imbalance(expected_weights(one), result.labels, submesh_count);
        require(std::abs(result.weight_imbalance - imbalance) <= 1e-6 * imbalance,
                "weight_imbalance",
                one);
    }
    return recount;
}

void check_guarantees(const Segmentation& result,
                      const Recount& recount,
                      const Surface& surface,
                      const FuzzCase& one) {
    const auto submesh_count = static_cast<int>(recount.triangle_counts.size());
    const bool by_weight = one.options.balance == Balance::weight;
    const int difference =
        by_weight ? one.mesh.face_count() : surface.least_count_difference(submesh_count);
    require(result.component_count == static_cast<int>(surface.component_sizes().size()),
            "component_count",
            one);
    require(by_weight || result.best_max_triangle_count_difference == difference,
            "best_max_triangle_count_difference",
            one);
    const bool is_valid = recount.is_whole() && recount.max_triangle_count_difference <= difference;
    require(result.is_valid() == is_valid, "is_valid", one);
    require(result.may_be_balanced || !is_valid, "may_be_balanced, which it is", one);
    if (one.options.method == Method::all_pairs) {
        require(recount.max_triangle_count_difference <= difference, "balance of all_pairs", one);
        count(Outcome::segmented);
    } else if (is_valid) {
        count(Outcome::segmented);
    } else {
        switch (can_be_cut(surface, submesh_count, difference)) {
        case Answer::no:
            count(Outcome::impossible);
            break;
        case Answer::yes:
            require(result.may_be_balanced, "may_be_balanced, as it can be cut", one);
            count(Outcome::missed);
            note_missed("possible", one, recount, difference);
            break;
        case Answer::unknown:
            count(Outcome::not_reached);
            note_missed("perhaps possible", one, recount, difference);
            break;
        }
    }
}

/// Progress rises within [0, 1], and stops the run when the case says so.
Progress watched_progress(const FuzzCase& one, int& calls) {
    return [&one, &calls, last = 0.0](double fraction, const char* step) mutable {
        require(fraction >= last && fraction <= 1.0 && step && *step, "progress", one);
        last = fraction;
        return ++calls != one.cancel_at_call;
    };
}

bool must_be_accepted(const Surface& surface, const FuzzCase& one) {
    return one.options.method == Method::fast ? surface.is_clean() : surface.is_sphere();
}

void check_same_labels(PreparedMesh& used, const FuzzCase& one, const Segmentation& result) {
    if (one.options.time_limit_seconds > 0.0) {
        return;
    }
    SegmentOptions options = one.options;
    options.thread_count = 1 + (options.thread_count + one.label_seed / 2 % 2) % 3;
    if (one.label_seed % 2 == 0) {
        require(segment(used, options).labels == result.labels, "same labels, used mesh", one);
    } else {
        PreparedMesh fresh(one.mesh, options.thread_count);
        require(segment(fresh, options).labels == result.labels, "same labels, new mesh", one);
    }
}

/// Labels that are valid already do not get worse, and come back as they were where nothing better
/// is found.
void check_against_input(const Segmentation& result, const Surface& surface, const FuzzCase& one) {
    const int submesh_count = result.measures.submesh_count;
    const std::vector<int>& given = one.options.initial_labels;
    std::vector<int> numbers(given);
    std::sort(numbers.begin(), numbers.end());
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
    std::vector<int> labels;
    for (int label : given) {
        labels.push_back(static_cast<int>(std::lower_bound(numbers.begin(), numbers.end(), label) -
                                          numbers.begin()));
    }
    const Recount before = surface.recount(labels, submesh_count);
    if (!before.is_whole()) {
        return;
    }
    const int edges_more = result.measures.boundary_edge_count - before.boundary_edge_count;
    if (one.options.balance == Balance::weight) {
        const double imbalance = recount_imbalance(expected_weights(one), labels, submesh_count);
        const double tolerance = 1e-9 * imbalance;
        if (!has_vague_weights(one)) {
            require(result.weight_imbalance <= imbalance + 0.001 + tolerance,
                    "no worse balance than the initial labels",
                    one);
            require(result.weight_imbalance < imbalance + tolerance || edges_more <= 0,
                    "no longer boundary than the initial labels at the same balance",
                    one);
        }
    } else if (before.max_triangle_count_difference <=
               surface.least_count_difference(submesh_count)) {
        require(result.is_valid(), "valid labels stay valid", one);
        require(edges_more <= 0, "no longer boundary than the initial labels", one);
        require(edges_more < 0 || result.labels == labels, "labels come back as they were", one);
    }
}

void run_segmentation(PreparedMesh& prepared, const Surface& surface, const FuzzCase& one);

/// From the labels that came out; in half of the cases some faces get the label of another.
void start_again(PreparedMesh& prepared,
                 const Surface& surface,
                 const FuzzCase& one,
                 const std::vector<int>& labels) {
    FuzzCase next = one;
    next.start_again = false;
    next.cancel_at_call = 0;
    next.options.initial_labels = labels;
    Random random(static_cast<std::uint64_t>(one.label_seed));
    const auto face_count = static_cast<std::uint32_t>(labels.size());
    for (std::uint32_t i = random.below(2) * (1 + random.below(4)); i > 0; --i) {
        next.options.initial_labels[random.below(face_count)] = labels[random.below(face_count)];
    }
    if (expected_submesh_count(next) >= static_cast<int>(surface.component_sizes().size())) {
        run_segmentation(prepared, surface, next);
    }
}

void run_segmentation(PreparedMesh& prepared, const Surface& surface, const FuzzCase& one) {
    int calls = 0;
    Segmentation result;
    try {
        result = segment(prepared, one.options, watched_progress(one, calls));
    } catch (const Cancelled&) {
        require(calls == one.cancel_at_call, "cancelled without being asked", one);
        count(Outcome::cancelled);
        result = segment(prepared, one.options);
    }
    require(expected_refusal(one).empty() || has_vague_weights(one), "bad options pass", one);
    const Recount recount = check_labels(result, surface, one);
    if (one.options.time_limit_seconds > 0.0 && result.time_limit_hit &&
        !(recount.is_whole() &&
          (one.options.balance == Balance::weight || recount.max_triangle_count_difference <= 1))) {
        count(Outcome::out_of_time);
    } else {
        check_guarantees(result, recount, surface, one);
    }
    check_same_labels(prepared, one, result);
    if (!one.options.initial_labels.empty()) {
        check_against_input(result, surface, one);
    }
    if (one.start_again && one.options.method == Method::fast) {
        start_again(prepared, surface, one, result.labels);
    }
}

/// Labels drawn at random, some of them out of range.
void run_measures(const PreparedMesh& prepared, const Surface& surface, const FuzzCase& one) {
    Random random(static_cast<std::uint64_t>(one.label_seed));
    const int submesh_count = 1 + static_cast<int>(random.below(8));
    std::vector<int> labels;
    for (int f = 0; f < one.mesh.face_count(); ++f) {
        labels.push_back(static_cast<int>(random.below(submesh_count)));
    }
    if (one.label_seed % 16 == 0 && !labels.empty()) {
        labels.back() = one.label_seed % 32 == 0 ? submesh_count : -1;
    }
    const Measures measures =
        measure(prepared.mesh(), prepared.dual_graph(), labels, submesh_count, 1);
    if (surface.is_clean()) {
        check_measures(measures, surface.recount(labels, submesh_count), one);
    }
}

void run_case(const FuzzCase& one) {
    PreparedMesh prepared(one.mesh, one.options.thread_count);
    const Surface surface(one.mesh);
    if (one.parametrize && prepared.report().is_closed_genus_zero()) {
        const char* fault = find_bad_sphere(prepared, one.label_seed, one.options.thread_count);
        require(!fault, fault, one);
    }
    if (one.measure_any_labels) {
        run_measures(prepared, surface, one);
    }
    if (one.check_levels && surface.is_clean()) {
        const char* fault = find_bad_level(prepared, one.label_seed, one.options.thread_count);
        require(!fault, fault, one);
    }
    try {
        run_segmentation(prepared, surface, one);
    } catch (const InvalidInput&) {
        require(!must_be_accepted(surface, one) ||
                    expected_submesh_count(one) <
                        static_cast<int>(surface.component_sizes().size()),
                "a good mesh is refused",
                one);
        throw;
    } catch (const InvalidOptions& error) {
        const std::string expected = expected_refusal(one);
        require((!expected.empty() || has_vague_weights(one)) &&
                    std::string(error.what()).find(expected) != std::string::npos,
                "options are refused for a reason",
                one);
        throw;
    }
}

} // namespace
} // namespace spheroseg::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
    using namespace spheroseg;
    using namespace spheroseg::fuzz;
    const FuzzCase one = read_case(bytes, size);
    const auto refuse = [&](const std::exception& error) {
        require(std::string(error.what()).size() > 20, "a message that helps", one);
        count(Outcome::refused);
    };
    try {
        run_case(one);
    } catch (const InvalidInput& error) {
        refuse(error);
    } catch (const InvalidOptions& error) {
        refuse(error);
    } catch (const DeviceError& error) {
        refuse(error);
    }
    return 0;
}
