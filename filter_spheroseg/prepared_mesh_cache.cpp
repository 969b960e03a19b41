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
    if (known && sphere_positions && uses_given_positions_ &&
        same_content(*sphere_positions, prepared_->parametrization().positions)) {
        return *prepared_;
    }
    if (!known || uses_given_positions_) {
        prepared_.reset();
        prepared_ = std::make_unique<PreparedMesh>(std::move(mesh), thread_count);
    }
    uses_given_positions_ =
        sphere_positions && prepared_->set_parametrization(*std::move(sphere_positions));
    return *prepared_;
}

} // namespace spheroseg
