// SPDX-License-Identifier: GPL-3.0-or-later
#include "prepared_mesh_cache.h"

#include <cstring>

namespace spheroseg {

namespace {

/// Bitwise, so that NaN equals itself.
template <typename T> bool same_content(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() &&
        (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

bool same_mesh(const TriangleMesh& a, const TriangleMesh& b) {
    return same_content(a.faces, b.faces) && same_content(a.positions, b.positions);
}

} // namespace

PreparedMesh& PreparedMeshCache::prepare(TriangleMesh mesh,
                                         std::optional<std::vector<Vec3>> sphere_positions,
                                         int thread_count) {
    const bool known = prepared_ && same_mesh(prepared_->mesh(), mesh);
    if (known && sphere_positions && given_positions_ &&
        same_content(*sphere_positions, *given_positions_)) {
        return *prepared_;
    }
    if (!known || given_positions_) {
        prepared_.reset();
        given_positions_.reset();
        prepared_ = std::make_unique<PreparedMesh>(std::move(mesh), thread_count);
    }
    if (sphere_positions && prepared_->report().is_closed_genus_zero() &&
        prepared_->set_parametrization(*sphere_positions)) {
        given_positions_ = std::move(sphere_positions);
    }
    return *prepared_;
}

} // namespace spheroseg
