// SPDX-License-Identifier: GPL-3.0-or-later
#include "face_weights.h"

#include "errors.h"

#include <algorithm>
#include <functional>
#include <limits>

namespace spheroseg {

namespace {

/// Units that the ideal loads of all sub-meshes have together. Zeros add at most one unit per face.
constexpr double kUnits = 1 << 29;

} // namespace

void check_face_weights(const SegmentOptions& options, const TriangleMesh& mesh) {
    const std::vector<double> weights = weights_of(options, mesh);
    const int face_count = mesh.face_count();
    if (weights.size() != static_cast<std::size_t>(face_count)) {
        throw InvalidOptions("One weight per face is expected (" + std::to_string(face_count) +
                             "), but there are " + std::to_string(weights.size()) + ".");
    }
    int bad_count = 0;
    int first_bad = -1;
    bool any_positive = false;
    for (int f = 0; f < face_count; ++f) {
        // Written so that NaN fails as well.
        if (!(weights[f] >= 0.0 && std::isfinite(weights[f]))) {
            first_bad = bad_count++ == 0 ? f : first_bad;
        }
        any_positive = any_positive || weights[f] > 0.0;
    }
    if (bad_count > 0) {
        throw InvalidOptions("Face weights must be finite and 0 or more, but " +
                             std::to_string(bad_count) + " of " + std::to_string(face_count) +
                             (bad_count == 1 ? " is" : " are") + " not; the first is face " +
                             std::to_string(first_bad) + " with " + to_text(weights[first_bad]) +
                             ". Correct the weights, or balance by triangle_count.");
    }
    if (!any_positive) {
        const bool are_areas = options.face_weights.empty();
        throw InvalidOptions(std::string("At least one face ") + (are_areas ? "area" : "weight") +
                             " above 0 is expected, but all " + std::to_string(face_count) +
                             " are 0. Correct the " + (are_areas ? "vertices" : "weights") +
                             ", or balance by triangle_count.");
    }
}

std::vector<double> face_areas(const TriangleMesh& mesh) {
    double largest = 0.0;
    // Vertices that no face uses may have any coordinates.
    for (const Triangle& face : mesh.faces) {
        for (int v : face) {
            const Vec3& p = mesh.positions[v];
            largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
        }
    }
    // 0.5 over a number that is not normal may overflow.
    const double lift = largest < std::numeric_limits<double>::min() ? 0x1p64 : 1.0;
    // Half of each: the difference of two of them must not overflow either.
    const double scale = largest > 0.0 ? 0.5 / (largest * lift) : 0.0;
    std::vector<double> areas(mesh.faces.size());
    for (std::size_t f = 0; f < areas.size(); ++f) {
        const Triangle& face = mesh.faces[f];
        const Vec3 p = mesh.positions[face[0]] * lift * scale;
        const Vec3 q = mesh.positions[face[1]] * lift * scale;
        const Vec3 r = mesh.positions[face[2]] * lift * scale;
        areas[f] = 0.5 * length(cross(q - p, r - p));
    }
    return areas;
}

std::vector<double> weights_of(const SegmentOptions& options, const TriangleMesh& mesh) {
    return options.face_weights.empty() ? face_areas(mesh) : options.face_weights;
}

double ideal_over_heaviest(const std::vector<double>& weights, int submesh_count) {
    std::vector<double> sorted = weights;
    std::sort(sorted.begin(), sorted.end(), std::greater<>());
    const double largest = sorted.front();
    if (largest <= 0.0) {
        return 0.0;
    }
    // Sums from the lightest on: subtracting a heavy weight would leave only its rounding error.
    std::vector<double> rest(sorted.size() + 1, 0.0);
    for (std::size_t i = sorted.size(); i > 0; --i) {
        rest[i - 1] = rest[i] + sorted[i - 1] / largest;
    }
    for (int alone = 0; alone < submesh_count; ++alone) {
        const double load = rest[alone] / (submesh_count - alone);
        if (sorted[alone] / largest <= load) {
            return load;
        }
    }
    return 0.0;
}

std::vector<double> load_shares(const std::vector<double>& weights, int submesh_count) {
    const double heaviest = *std::max_element(weights.begin(), weights.end());
    const double ideal = ideal_over_heaviest(weights, submesh_count);
    std::vector<double> shares;
    shares.reserve(weights.size());
    for (double weight : weights) {
        const double part = weight > 0.0 ? weight / heaviest : 0.0;
        const double whole = part > 0.0 ? 1.0 : 0.0;
        shares.push_back(part < ideal ? part / ideal : whole);
    }
    return shares;
}

std::vector<int> quantized_weights(const std::vector<double>& weights, int submesh_count) {
    const double units_per_submesh = kUnits / submesh_count;
    std::vector<int> quantized;
    quantized.reserve(weights.size());
    for (double share : load_shares(weights, submesh_count)) {
        quantized.push_back(std::max(1, static_cast<int>(std::lround(share * units_per_submesh))));
    }
    return quantized;
}

double weight_imbalance(const std::vector<double>& weights,
                        const std::vector<int>& labels,
                        int submesh_count) {
    const double largest = *std::max_element(weights.begin(), weights.end());
    std::vector<double> loads(submesh_count, 0.0);
    double total = 0.0;
    for (std::size_t f = 0; f < labels.size(); ++f) {
        loads[labels[f]] += weights[f] / largest;
        total += weights[f] / largest;
    }
    // Rounding may leave it a little below 1.
    return std::max(1.0, *std::max_element(loads.begin(), loads.end()) * submesh_count / total);
}

} // namespace spheroseg
