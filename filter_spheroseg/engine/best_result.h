// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fast_segmentation.h"
#include "multilevel.h"

#include <optional>

namespace spheroseg {

/// The best labelling of a component found so far, with the history of the start that made it:
/// soundness counts before balance, and balance before short boundaries.
class BestResult {
public:
    /// `multilevel` and `task` must outlive this object.
    BestResult(const Multilevel& multilevel, const ComponentTask& task, int thread_count)
        : multilevel_(multilevel), task_(task), thread_count_(thread_count) {}

    /// Keeps the labels of a patchwork on the finest level if they are better than those kept so
    /// far. `sound`: every sub-mesh is connected and free of bowties. Returns whether the labels of
    /// the patchwork are valid.
    bool keep_if_better(const Patchwork& patchwork, bool sound, const History& history);

    /// Are these labels, which must be sound, valid?
    bool would_be_valid(const Patchwork& patchwork) const {
        return cost_of(patchwork, true).is_valid();
    }

    /// Are the labels that are kept valid? False before the first ones.
    bool is_valid() const { return least_cost_ && least_cost_->is_valid(); }
    /// The labels that are kept, and their history; empty before the first ones.
    const std::vector<int>& labels() const { return labels_; }
    const History& history() const { return history_; }
    void set_history(const History& history) { history_ = history; }

private:
    struct Cost {
        bool is_unsound;
        /// Faces above and below the triangle counts that are asked for.
        std::int64_t misplaced;
        /// With weights: by how much the heaviest load is above near_enough, in thousandths of the
        /// mean load, rounded up.
        std::int64_t excess;
        std::int64_t boundary_edges;

        bool is_valid() const { return !is_unsound && misplaced == 0; }
        bool operator<(const Cost& other) const;
    };

    Cost cost_of(const Patchwork& patchwork, bool sound) const;

    const Multilevel& multilevel_;
    const ComponentTask& task_;
    const int thread_count_;
    std::optional<Cost> least_cost_;
    std::vector<int> labels_;
    History history_;
};

} // namespace spheroseg
