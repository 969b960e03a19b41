// SPDX-License-Identifier: GPL-3.0-or-later
#include "fuzz_start.h"

#include "random.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace spheroseg::fuzz {

namespace {

/// Weights that are accepted.
double good_weight(int kind, int face, Random& random) {
    switch (kind) {
    case 0:
        return 0.25;
    case 1:
        return 1.0 + random.below(10);
    case 2:
        return std::pow(10.0, 600.0 * random.uniform() - 300.0);
    case 3:
        return random.below(8) == 0 ? 1.0 : 0.0;
    case 4:
        return random.below(2);
    case 5:
        return 1e308;
    case 6:
        return 5e-324 * (1.0 + random.below(3));
    case 7:
        // One face outweighs all others.
        return face == 0 ? 1e6 : 1.0 + 1e-3 * random.below(1000);
    case 8:
        return std::exp(4.0 * random.uniform());
    default:
        return face % 16 == 0 ? 20.0 : 1.0;
    }
}

/// Spoils weights, of one or two faces where it is about values.
void spoil_weights(int kind, Random& random, SegmentOptions& options) {
    std::vector<double>& weights = options.face_weights;
    const double bad[] = {std::numeric_limits<double>::quiet_NaN(),
                          std::numeric_limits<double>::infinity(),
                          -std::numeric_limits<double>::infinity(),
                          -1e-300};
    switch (kind) {
    case 0:
        weights.push_back(1.0);
        break;
    case 1:
        weights.resize(weights.size() - 1);
        break;
    case 2:
        std::fill(weights.begin(), weights.end(), random.below(2) == 0 ? 0.0 : -0.0);
        break;
    case 3:
        options.balance = Balance::triangle_count;
        break;
    default:
        for (std::uint32_t i = 0; i <= random.below(2); ++i) {
            weights[random.below(static_cast<std::uint32_t>(weights.size()))] =
                bad[random.below(4)];
        }
        break;
    }
}

/// Each face gets the label of the seed that is nearest in steps across edges; 0 where no seed is.
std::vector<int> blobs(const TriangleMesh& mesh, int label_count, Random& random) {
    std::map<std::pair<int, int>, std::vector<int>> faces_on;
    for (int f = 0; f < mesh.face_count(); ++f) {
        for (int c = 0; c < 3; ++c) {
            const Triangle& t = mesh.faces[f];
            faces_on[std::minmax(t[c], t[(c + 1) % 3])].push_back(f);
        }
    }
    std::vector<int> labels(mesh.faces.size(), -1);
    std::vector<int> queue;
    for (int l = 0; l < label_count; ++l) {
        const auto seed =
            static_cast<int>(random.below(static_cast<std::uint32_t>(mesh.face_count())));
        if (labels[seed] < 0) {
            labels[seed] = l;
            queue.push_back(seed);
        }
    }
    for (std::size_t head = 0; head < queue.size(); ++head) {
        const Triangle t = mesh.faces[queue[head]];
        for (int c = 0; c < 3; ++c) {
            for (int g : faces_on[std::minmax(t[c], t[(c + 1) % 3])]) {
                if (labels[g] < 0) {
                    labels[g] = labels[queue[head]];
                    queue.push_back(g);
                }
            }
        }
    }
    std::replace(labels.begin(), labels.end(), -1, 0);
    return labels;
}

int good_label(int kind, int face, int face_count, int label_count, Random& random) {
    switch (kind) {
    case 0:
        return static_cast<int>(random.below(static_cast<std::uint32_t>(label_count)));
    case 1:
        return face % label_count;
    case 2:
        return face * label_count / face_count;
    case 3:
        // All but one have a single face.
        return std::min(face, label_count - 1);
    case 4:
        return 7;
    case 5:
        return face;
    case 6:
        // Two ends of the list in one label.
        return std::min(face, face_count - 1 - face) * label_count / face_count;
    default:
        return std::numeric_limits<int>::max() - 3 * (face % label_count);
    }
}

void spoil_labels(int kind, Random& random, std::vector<int>& labels) {
    if (kind == 0) {
        labels.push_back(0);
    } else if (kind == 1) {
        labels.resize(labels.size() - 1);
    } else {
        for (std::uint32_t i = 0; i <= random.below(2); ++i) {
            labels[random.below(static_cast<std::uint32_t>(labels.size()))] =
                random.below(2) == 0 ? -1 : std::numeric_limits<int>::min();
        }
    }
}

} // namespace

void read_weights(ByteReader& bytes, int face_count, SegmentOptions& options) {
    const int kind = bytes.below(32);
    Random random(static_cast<std::uint64_t>(bytes.byte()));
    if (kind < 11 || face_count == 0) {
        return;
    }
    options.balance = Balance::weight;
    if (kind < 14) {
        return; // by area
    }
    for (int f = 0; f < face_count; ++f) {
        options.face_weights.push_back(good_weight(kind < 24 ? kind - 14 : 1, f, random));
    }
    if (kind >= 27) {
        spoil_weights(kind - 27, random, options);
    }
}

void read_labels(ByteReader& bytes, const TriangleMesh& mesh, SegmentOptions& options) {
    const int kind = bytes.below(32);
    Random random(static_cast<std::uint64_t>(bytes.byte()), 1);
    const int face_count = mesh.face_count();
    if (kind < 11 || face_count == 0) {
        return;
    }
    const int label_count = std::clamp(requested_submesh_count(options, face_count), 1, face_count);
    if (kind >= 19 && kind < 28) {
        options.initial_labels = blobs(mesh, label_count, random);
        return;
    }
    for (int f = 0; f < face_count; ++f) {
        options.initial_labels.push_back(
            good_label(kind < 19 ? kind - 11 : 0, f, face_count, label_count, random));
    }
    if (kind >= 28) {
        spoil_labels(kind - 28, random, options.initial_labels);
    }
}

} // namespace spheroseg::fuzz
