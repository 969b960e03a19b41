// SPDX-License-Identifier: GPL-3.0-or-later
#include "fuzz_case.h"

#include "fuzz_mesh.h"
#include "fuzz_start.h"

#include <cmath>

namespace spheroseg::fuzz {

namespace {

/// Which kind of mesh; zero means a small one.
constexpr std::size_t kMeshByte = 14;
/// Here begin weights and initial labels; zeros mean neither.
constexpr std::size_t kStartBytes = 15;

void read_limits(ByteReader& bytes, FuzzCase& result) {
    const int kind = bytes.below(16);
    const int amount = bytes.byte();
    switch (kind) {
    case 0:
        result.options.max_cohesion_iterations = amount % 8;
        break;
    case 1:
        result.options.max_refinement_iterations = amount % 32;
        break;
    case 2:
        result.options.time_limit_seconds = 1e-6 * amount * amount;
        break;
    case 3:
    case 4:
        result.cancel_at_call = 1 + amount % 64;
        break;
    default:
        break;
    }
}

/// One option out of its range, in one case of 32.
void spoil_option(ByteReader& bytes, SegmentOptions& options) {
    switch (bytes.byte()) {
    case 1:
        options.submesh_count = -bytes.byte();
        break;
    case 2:
        options.triangles_per_submesh = -1;
        break;
    case 3:
        options.thread_count = -2;
        break;
    case 4:
        options.max_cohesion_iterations = -3;
        break;
    case 5:
        options.max_refinement_iterations = -1;
        break;
    case 6:
        options.time_limit_seconds = -1.0;
        break;
    case 7:
        options.time_limit_seconds = std::nan("");
        break;
    case 8:
        options.device = Device::cuda;
        break;
    default:
        break;
    }
}

void read_submesh_count(ByteReader& bytes, int face_count, SegmentOptions& options) {
    const int kind = bytes.below(8);
    const int amount = bytes.word();
    if (kind == 0) {
        options.triangles_per_submesh = 1 + amount % 100;
    } else if (kind == 1) {
        options.submesh_count = amount % 1000;
    } else if (kind < 5) {
        options.submesh_count = 1 + amount % 12;
    } else {
        options.submesh_count = 1 + amount % (face_count + 1);
    }
}

/// So few sub-meshes that a large mesh is coarsened; seldom more, but often with effort `high`,
/// which then goes on from a single start.
void read_few_submeshes(ByteReader& bytes, int face_count, SegmentOptions& options) {
    const int kind = options.effort == Effort::high ? 8 + bytes.below(8) : bytes.below(16);
    const int amount = bytes.word();
    if (kind == 0) {
        options.triangles_per_submesh = 60 + amount % 1000;
    } else if (kind < 8) {
        options.submesh_count = 1 + amount % (1 + face_count / 80);
    } else if (kind < (options.effort == Effort::high ? 11 : 15)) {
        options.submesh_count = 2 + amount % 5;
    } else {
        options.submesh_count = 50 + amount % 100;
    }
}

/// What would take too long on a large mesh gets few iterations.
void bound_effort(int amount, int face_count, SegmentOptions& options) {
    if (options.method == Method::all_pairs && face_count > kMaxFaces / 2) {
        options.max_cohesion_iterations = 1 + amount % 2;
        options.max_refinement_iterations = 1 + amount % 2;
    } else if (options.effort == Effort::high && options.max_refinement_iterations == 0) {
        options.max_refinement_iterations = 1 + amount % 32;
    }
}

} // namespace

FuzzCase read_case(const std::uint8_t* data, std::size_t size) {
    FuzzCase result;
    ByteReader bytes(data, size < kOptionBytes ? size : kOptionBytes);
    bytes.skip_to(kMeshByte);
    const int mesh_kind = bytes.byte();
    const bool large = mesh_kind % 2 == 1;
    result.check_levels = mesh_kind / 2 % 4 == 1;
    ByteReader mesh_bytes(data, size);
    mesh_bytes.skip_to(kOptionBytes);
    result.mesh = read_mesh(mesh_bytes, large);

    bytes.skip_to(0);
    SegmentOptions& options = result.options;
    options.method = bytes.below(8) == 0 ? Method::all_pairs : Method::fast;
    const int effort = bytes.byte();
    options.effort = effort % 16 == 0 ? Effort::standard : Effort::draft;
    if (large ? effort >= 248 : effort == 255 && result.mesh.face_count() < 60) {
        options.effort = Effort::high;
    }
    if (large) {
        read_few_submeshes(bytes, result.mesh.face_count(), options);
    } else {
        read_submesh_count(bytes, result.mesh.face_count(), options);
    }
    options.seed = static_cast<std::uint64_t>(bytes.byte());
    options.thread_count = 1 + bytes.below(3);
    read_limits(bytes, result);
    result.parametrize = bytes.below(4) == 0;
    result.measure_any_labels = bytes.below(4) == 0;
    result.label_seed = bytes.byte();
    spoil_option(bytes, options);
    bytes.skip_to(kStartBytes);
    read_weights(bytes, result.mesh.face_count(), options);
    read_labels(bytes, result.mesh, options);
    result.start_again = bytes.below(4) == 1;
    if (large) {
        bound_effort(effort, result.mesh.face_count(), options);
    }
    return result;
}

} // namespace spheroseg::fuzz
