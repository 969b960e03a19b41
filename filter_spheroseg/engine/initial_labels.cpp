// SPDX-License-Identifier: GPL-3.0-or-later
#include "initial_labels.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <utility>

namespace spheroseg {

namespace {

/// Faces of each label in one component.
std::map<int, int> label_counts(const Component& component, const std::vector<int>& labels) {
    std::map<int, int> counts;
    for (int f = 0; f < component.face_count(); ++f) {
        ++counts[labels[component.mesh_face(f)]];
    }
    return counts;
}

/// The labels that each component keeps, the ones with the most faces first.
std::vector<std::vector<int>> kept_labels(const std::vector<Component>& components,
                                          const std::vector<int>& submesh_counts,
                                          int submesh_count,
                                          const std::vector<int>& labels) {
    std::vector<std::pair<int, int>> home(submesh_count, {0, -1}); // most faces, component
    for (std::size_t i = 0; i < components.size(); ++i) {
        for (const auto& [label, count] : label_counts(components[i], labels)) {
            if (count > home[label].first) {
                home[label] = {count, static_cast<int>(i)};
            }
        }
    }
    std::vector<std::vector<int>> kept(components.size());
    for (int l = 0; l < submesh_count; ++l) {
        kept[home[l].second].push_back(l);
    }
    for (std::size_t i = 0; i < kept.size(); ++i) {
        std::stable_sort(kept[i].begin(), kept[i].end(), [&](int a, int b) {
            return home[a].first > home[b].first;
        });
        if (static_cast<int>(kept[i].size()) > submesh_counts[i]) {
            kept[i].resize(submesh_counts[i]);
        }
    }
    return kept;
}

} // namespace

std::vector<ComponentLabels> share_labels(const std::vector<Component>& components,
                                          const std::vector<int>& submesh_counts,
                                          const std::vector<int>& labels) {
    int submesh_count = 0;
    for (int count : submesh_counts) {
        submesh_count += count;
    }
    std::vector<std::vector<int>> kept =
        kept_labels(components, submesh_counts, submesh_count, labels);
    std::vector<std::uint8_t> is_kept(submesh_count, 0);
    for (std::vector<int>& names : kept) {
        std::sort(names.begin(), names.end());
        for (int name : names) {
            is_kept[name] = 1;
        }
    }
    std::vector<int> free_names;
    for (int l = 0; l < submesh_count; ++l) {
        if (!is_kept[l]) {
            free_names.push_back(l);
        }
    }
    std::vector<int> number_of(submesh_count, -1);
    std::size_t next_free = 0;
    std::vector<ComponentLabels> shared(components.size());
    for (std::size_t i = 0; i < components.size(); ++i) {
        ComponentLabels& part = shared[i];
        part.names = std::move(kept[i]);
        for (std::size_t number = 0; number < part.names.size(); ++number) {
            number_of[part.names[number]] = static_cast<int>(number);
        }
        for (int f = 0; f < components[i].face_count(); ++f) {
            part.labels.push_back(number_of[labels[components[i].mesh_face(f)]]);
        }
        for (int name : part.names) {
            number_of[name] = -1;
        }
        while (static_cast<int>(part.names.size()) < submesh_counts[i]) {
            part.names.push_back(free_names[next_free++]);
        }
    }
    return shared;
}

} // namespace spheroseg
