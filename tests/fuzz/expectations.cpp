// SPDX-License-Identifier: GPL-3.0-or-later
#include "expectations.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

namespace spheroseg::fuzz {

namespace {

using Real = long double;

bool goes_by_area(const FuzzCase& one) {
    return one.options.balance == Balance::weight && one.options.face_weights.empty();
}

Real area(const Vec3& p, const Vec3& q, const Vec3& r) {
    const Real a[] = {Real{q.x} - p.x, Real{q.y} - p.y, Real{q.z} - p.z};
    const Real b[] = {Real{r.x} - p.x, Real{r.y} - p.y, Real{r.z} - p.z};
    const Real x = a[1] * b[2] - a[2] * b[1];
    const Real y = a[2] * b[0] - a[0] * b[2];
    const Real z = a[0] * b[1] - a[1] * b[0];
    return std::sqrt(x * x + y * y + z * z) / 2;
}

std::string refused_range(const SegmentOptions& options) {
    if (options.triangles_per_submesh < 0) {
        return "triangles_per_submesh must be 0 or more";
    }
    if (options.thread_count < 0) {
        return "thread_count must be 0 or more";
    }
    if (options.max_cohesion_iterations < 0) {
        return "max_cohesion_iterations must be 0 or more";
    }
    if (options.max_refinement_iterations < 0) {
        return "max_refinement_iterations must be 0 or more";
    }
    return options.time_limit_seconds >= 0.0 ? "" : "time_limit_seconds must be 0 or more";
}

std::string refused_size(std::size_t size, int face_count) {
    return size == static_cast<std::size_t>(face_count)
        ? ""
        : "(" + std::to_string(face_count) + "), but there are " + std::to_string(size);
}

std::string refused_weights(const FuzzCase& one) {
    const std::vector<double>& weights = one.options.face_weights;
    const int face_count = one.mesh.face_count();
    if (one.options.balance == Balance::triangle_count) {
        return weights.empty() ? "" : "No face weights are expected";
    }
    if (one.options.method != Method::fast) {
        return "Expected method \"fast\" with balance \"weight\"";
    }
    const std::vector<long double> expected = expected_weights(one);
    if (!weights.empty()) {
        const std::string size = refused_size(weights.size(), face_count);
        if (!size.empty()) {
            return size;
        }
        int bad_count = 0;
        int first = -1;
        for (int f = face_count - 1; f >= 0; --f) {
            if (std::isnan(weights[f]) || std::isinf(weights[f]) || weights[f] < 0.0) {
                ++bad_count;
                first = f;
            }
        }
        if (bad_count > 0) {
            return std::to_string(bad_count) + " of " + std::to_string(face_count) +
                (bad_count == 1 ? " is" : " are") + " not; the first is face " +
                std::to_string(first) + " ";
        }
    }
    return *std::max_element(expected.begin(), expected.end()) > 0
        ? ""
        : "all " + std::to_string(face_count) + " are 0";
}

std::string refused_labels(const FuzzCase& one) {
    const std::vector<int>& labels = one.options.initial_labels;
    if (labels.empty()) {
        return "";
    }
    if (one.options.method != Method::fast) {
        return "Expected method \"fast\" with initial labels";
    }
    const std::string size = refused_size(labels.size(), one.mesh.face_count());
    if (!size.empty()) {
        return size;
    }
    for (std::size_t f = 0; f < labels.size(); ++f) {
        if (labels[f] < 0) {
            return "face " + std::to_string(f) + " has " + std::to_string(labels[f]);
        }
    }
    return "";
}

} // namespace

int expected_submesh_count(const FuzzCase& one) {
    const SegmentOptions& options = one.options;
    const int face_count = one.mesh.face_count();
    if (!options.initial_labels.empty()) {
        const std::vector<int>& labels = options.initial_labels;
        return static_cast<int>(std::set<int>(labels.begin(), labels.end()).size());
    }
    if (options.triangles_per_submesh > 0) {
        return static_cast<int>(
            std::ceil(face_count / static_cast<double>(options.triangles_per_submesh)));
    }
    if (options.submesh_count != 0) {
        return options.submesh_count;
    }
    return face_count < 2000 ? std::max(1, (face_count + 9) / 10) : 200;
}

std::string expected_refusal(const FuzzCase& one) {
    for (const std::string& reason :
         {refused_range(one.options), refused_weights(one), refused_labels(one)}) {
        if (!reason.empty()) {
            return reason;
        }
    }
    const int submesh_count = expected_submesh_count(one);
    return submesh_count >= 1 && submesh_count <= one.mesh.face_count()
        ? ""
        : "submesh_count must lie in [1, " + std::to_string(one.mesh.face_count()) + "]";
}

std::vector<long double> expected_weights(const FuzzCase& one) {
    const TriangleMesh& mesh = one.mesh;
    if (!one.options.face_weights.empty()) {
        return {one.options.face_weights.begin(), one.options.face_weights.end()};
    }
    std::vector<Real> weights(mesh.faces.size(), 1);
    for (std::size_t f = 0; f < weights.size() && goes_by_area(one); ++f) {
        const Triangle& t = mesh.faces[f];
        weights[f] = area(mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]);
    }
    return weights;
}

bool has_vague_weights(const FuzzCase& one) {
    if (!goes_by_area(one)) {
        return false;
    }
    Real largest = 0;
    for (const Triangle& t : one.mesh.faces) {
        for (int v : t) {
            const Vec3& p = one.mesh.positions[v];
            largest = std::max<Real>({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
        }
    }
    const std::vector<Real> areas = expected_weights(one);
    return *std::max_element(areas.begin(), areas.end()) <= 1e-9L * largest * largest;
}

double recount_imbalance(const std::vector<long double>& weights,
                         const std::vector<int>& labels,
                         int submesh_count) {
    std::vector<Real> loads(static_cast<std::size_t>(submesh_count), 0);
    for (std::size_t f = 0; f < labels.size(); ++f) {
        loads[labels[f]] += weights[f];
    }
    const Real total = std::accumulate(loads.begin(), loads.end(), Real{0});
    return static_cast<double>(*std::max_element(loads.begin(), loads.end()) / total *
                               submesh_count);
}

} // namespace spheroseg::fuzz
