// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "segment.h"

#include <memory>

namespace spheroseg {

/// Keeps what was prepared for the last mesh, so that another k on the same mesh is cheap.
/// The whole mesh is compared, so that a changed mesh is never mistaken for the old one.
class PreparedMeshCache {
public:
    /// The prepared form of `mesh`. Its parametrization is `sphere_positions` when these are valid
    /// for it, else one of its own: which one never depends on earlier calls.
    /// Throws InvalidInput when a vertex index is out of range, OutOfMemory.
    PreparedMesh&
    prepare(TriangleMesh mesh, std::optional<std::vector<Vec3>> sphere_positions, int thread_count);

    /// True when the last `prepare` took the positions that it was given.
    bool uses_given_positions() const { return uses_given_positions_; }

private:
    std::unique_ptr<PreparedMesh> prepared_;
    /// Is the parametrization of prepared_ one that was given?
    bool uses_given_positions_ = false;
};

} // namespace spheroseg
