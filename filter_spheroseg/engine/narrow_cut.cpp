// SPDX-License-Identifier: GPL-3.0-or-later
#include "narrow_cut.h"

#include "bowtie_finder.h"
#include "branch_decomposition.h"
#include "random.h"
#include "submesh_faces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <unordered_set>
#include <utility>

namespace spheroseg {

namespace {

constexpr int kMostEdges = 12;
constexpr int kLargestSubmesh = 250; // below 256, which Way::size holds
/// Of a region: the lists take up to 7 kB per face.
constexpr std::size_t kMostFaces = 1 << 16;
/// Ways that a list holds, and pairs of ways that are looked at for each of them. Where there are
/// more pairs, one in so many is drawn from all, the others from those in which the parts at the
/// first edge between the two blocks make a complete sub-mesh together, which are few.
constexpr int kMostWays = 1000;
constexpr int kPairsPerWay = 40;
constexpr std::uint64_t kAnyPairOneOf = 4;
/// The parts of two blocks are joined across each set of the edges between these; where there are
/// more than this, across as many sets drawn by chance.
constexpr int kMostEdgesJoinedInAllWays = 5;
/// The sub-meshes with one face more are spread over the region: in a block there may be so many
/// more of them, or fewer, than its share; in the last attempt, which matters on small meshes, any
/// number.
constexpr double kOffShare = 1;
/// The first region has so many sub-meshes, or more; after a failure the next one has twice as
/// many. All faces are cut so many times in vain, then it ends.
constexpr std::size_t kFirstRegion = 8;
constexpr int kTriesOfAll = 2;
/// What a region and its blocks take, in pairs of ways for each face.
constexpr std::int64_t kWorkPerFace = 100;
constexpr std::int64_t kWorkPerReport = 2000;

/// A way to cut a block: into parts, each the part of a sub-mesh that lies in the block. Those with
/// outer edges come first, the rest is complete and not kept.
struct Way {
    /// The ways to cut the two blocks that it is made of, and a bit for each edge between them that
    /// joins the parts at its ends.
    std::array<int, 2> of = {-1, -1};
    std::uint32_t joints = 0;
    /// Complete sub-meshes with one face more than the others.
    int large_count = 0;
    int part_count = 1;
    /// The part at each outer edge, and the faces of each part.
    std::array<std::uint8_t, kMostEdges> part{};
    std::array<std::uint8_t, kMostEdges> size{};
};

/// How the parts of two blocks are joined.
struct Joint {
    /// For each part of the first block, then of the second one, the part of the whole; those from
    /// `open_count` on are complete sub-meshes.
    std::array<int, 2 * kMostEdges> part;
    std::array<int, 2 * kMostEdges> size;
    int open_count = 0;
    int count = 0;
};

class NarrowCut {
public:
    NarrowCut(Patchwork& patchwork,
              std::int64_t& work_left,
              const Deadline* deadline,
              const Progress& progress)
        : patchwork_(patchwork), work_left_(work_left), deadline_(deadline), progress_(progress),
          even_(even_loads(patchwork)), bowtie_finder_(patchwork),
          is_marked_(patchwork.face_count(), 0), faces_of_(patchwork) {}

    bool run() {
        bool balanced = true;
        for (int label = 0; label < patchwork_.submesh_count(); ++label) {
            balanced =
                (even_.deviation(patchwork_.load[label]) == 0 || cut_around(label)) && balanced;
        }
        return balanced;
    }

private:
    bool may_go_on() const {
        return work_left_ > 0 && tries_of_all_ < kTriesOfAll &&
            !(deadline_ && deadline_->expired());
    }

    bool cut_around(int label) {
        for (std::size_t least = kFirstRegion; may_go_on();) {
            const Region region = region_around(label, least);
            count_work(kWorkPerFace * static_cast<std::int64_t>(region.faces.size()));
            if (region.faces.size() > kMostFaces) {
                return false;
            }
            if (cut(region)) {
                faces_of_.update(region);
                return true;
            }
            tries_of_all_ +=
                region.labels.size() < least || region.faces.size() == patchwork_.cells.size();
            least = 2 * std::max(least, region.labels.size());
        }
        return false;
    }

    /// The sub-meshes nearest to one, at least so many and as many as it takes to share their faces
    /// out evenly; where that can not be done, all of the component, or more than kMostFaces.
    Region region_around(int label, std::size_t least) const {
        Region region;
        std::vector<int> queue(1, label);
        std::vector<std::uint8_t> is_met(patchwork_.submesh_count(), 0);
        is_met[label] = 1;
        for (std::size_t head = 0; head < queue.size() && region.faces.size() <= kMostFaces &&
             (region.labels.size() < least || !can_be_even(region));
             ++head) {
            faces_of_.add_to(region, queue[head]);
            for (int f : faces_of_[queue[head]]) {
                for (int neighbor : patchwork_.neighbors(f)) {
                    if (neighbor >= 0 && is_met[patchwork_.label(neighbor)] == 0) {
                        is_met[patchwork_.label(neighbor)] = 1;
                        queue.push_back(patchwork_.label(neighbor));
                    }
                }
            }
        }
        return region;
    }

    bool can_be_even(const Region& region) const {
        const auto faces = static_cast<std::int64_t>(region.faces.size());
        const auto count = static_cast<std::int64_t>(region.labels.size());
        return even_.floor * count <= faces && faces <= even_.ceiling * count;
    }

    /// When it fails all labels are as they were.
    bool cut(const Region& region) {
        if (!can_be_even(region)) {
            return false;
        }
        faces_ = region.faces;
        blocks_ = branch_decomposition(patchwork_, faces_, kMostEdges, random_);
        if (blocks_.empty()) {
            return false;
        }
        most_large_ =
            static_cast<int>(faces_.size()) - even_.floor * static_cast<int>(region.labels.size());
        Way whole_face;
        whole_face.size[0] = 1;
        ways_.assign(faces_.size(), std::vector<Way>(1, whole_face));
        for (std::size_t b = faces_.size(); b < blocks_.size(); ++b) {
            ways_.push_back(list_ways(blocks_[b]));
            if (ways_.back().empty() || !may_go_on()) {
                return false;
            }
        }
        const std::vector<Way>& ways = ways_.back();
        const auto found = std::find_if(ways.begin(), ways.end(), [this](const Way& way) {
            return way.large_count == most_large_;
        });
        if (found == ways.end()) {
            return false;
        }
        label_faces(region, static_cast<int>(found - ways.begin()));
        return true;
    }

    /// Lists ways to cut a block, no two of them alike at its outer edges.
    std::vector<Way> list_ways(const FaceBlock& block) {
        const std::vector<Way>& first = ways_[block.of[0]];
        const std::vector<Way>& second = ways_[block.of[1]];
        const auto pairs = static_cast<std::uint64_t>(first.size() * second.size());
        const std::uint64_t most_pairs = std::min<std::uint64_t>(pairs, kPairsPerWay * kMostWays);
        // All pairs in a random order, or the first ones of it.
        const std::uint64_t start = random_.next() % pairs;
        std::uint64_t stride = 1 + random_.next() % pairs;
        while (std::gcd(stride, pairs) != 1) {
            ++stride;
        }
        const auto edges = static_cast<int>(block.inner.size());
        const bool tries_all = edges <= kMostEdgesJoinedInAllWays;
        const double share = most_large_ * static_cast<double>(block.face_count) /
            static_cast<double>(faces_.size());
        const bool draws_matches = pairs > most_pairs;
        const std::vector<std::vector<int>> by_size = draws_matches
            ? ways_by_size(second, block.inner[0][1])
            : std::vector<std::vector<int>>();
        std::vector<Way> ways;
        std::unordered_set<std::uint64_t> keys;
        Joint joint;
        std::uint64_t i = 0;
        for (; i < most_pairs && ways.size() < kMostWays; ++i) {
            const std::uint64_t pair = (start + i * stride) % pairs;
            Way way;
            way.of = {static_cast<int>(pair / second.size()),
                      static_cast<int>(pair % second.size())};
            const Way& a = first[way.of[0]];
            if (draws_matches && i % kAnyPairOneOf != 0) {
                const std::vector<int>& matches =
                    by_size[completion_of(a.size[a.part[block.inner[0][0]]])];
                if (matches.empty()) {
                    continue;
                }
                way.of[1] = matches[random_.below(static_cast<std::uint32_t>(matches.size()))];
            }
            const Way& b = second[way.of[1]];
            for (std::uint32_t j = 0; j < 1U << std::min(edges, kMostEdgesJoinedInAllWays); ++j) {
                way.joints = tries_all ? j : random_.below(1U << edges);
                if (!join_parts(block, a, b, way.joints, joint)) {
                    continue;
                }
                describe(block, a, b, joint, way);
                if (way.large_count > most_large_ ||
                    (tries_of_all_ < kTriesOfAll - 1 &&
                     std::abs(way.large_count - share) > kOffShare)) {
                    continue;
                }
                const std::uint64_t key = key_of(block, way);
                if (keys.count(key) == 0 && !completes_bowtie(block, way, joint)) {
                    keys.insert(key);
                    ways.push_back(way);
                }
            }
        }
        count_work(static_cast<std::int64_t>(i));
        return ways;
    }

    /// For each size the ways in which the part at an outer edge has it.
    std::vector<std::vector<int>> ways_by_size(const std::vector<Way>& ways, int edge) const {
        std::vector<std::vector<int>> by_size(even_.ceiling + 1);
        for (int i = 0; i < static_cast<int>(ways.size()); ++i) {
            by_size[ways[i].size[ways[i].part[edge]]].push_back(i);
        }
        return by_size;
    }

    /// The size of a part that makes a complete sub-mesh with one of `size` faces; that of another
    /// complete one where this is complete already. Where there are two such sizes, any of them.
    int completion_of(int size) {
        const int complete =
            even_.floor + static_cast<int>(random_.below(even_.ceiling - even_.floor + 1));
        return size < complete ? complete - size : complete;
    }

    void count_work(std::int64_t pairs) {
        work_left_ -= pairs;
        unreported_work_ += pairs;
        if (unreported_work_ >= kWorkPerReport) {
            unreported_work_ = 0;
            report_progress(progress_, 0.0, "Balancing");
        }
    }

    /// The part at an outer edge of the first or second block, in the order of Joint::part.
    static int part_at(int side, int edge, const Way& a, const Way& b) {
        return side == 0 ? a.part[edge] : a.part_count + b.part[edge];
    }

    /// False when a part gets too large, or has no outer edge and is too small.
    bool join_parts(const FaceBlock& block,
                    const Way& a,
                    const Way& b,
                    std::uint32_t joints,
                    Joint& joint) const {
        std::array<int, 2 * kMostEdges> root;
        std::array<int, 2 * kMostEdges> size;
        std::array<int, 2 * kMostEdges> name;
        const int count = a.part_count + b.part_count;
        for (int i = 0; i < count; ++i) {
            root[i] = i;
            size[i] = i < a.part_count ? a.size[i] : b.size[i - a.part_count];
            name[i] = -1;
        }
        const auto root_of = [&](int i) {
            while (root[i] != i) {
                i = root[i];
            }
            return i;
        };
        for (std::size_t e = 0; e < block.inner.size(); ++e) {
            if ((joints >> e & 1) != 0) {
                const int x = root_of(part_at(0, block.inner[e][0], a, b));
                const int y = root_of(part_at(1, block.inner[e][1], a, b));
                if (x != y) {
                    root[y] = x;
                    size[x] += size[y];
                    if (size[x] > even_.ceiling) {
                        return false;
                    }
                }
            }
        }
        joint.count = 0;
        const auto name_of = [&](int i) {
            const int r = root_of(i);
            if (name[r] < 0) {
                joint.size[joint.count] = size[r];
                name[r] = joint.count++;
            }
            return name[r];
        };
        for (const auto& [side, edge] : block.origin) {
            name_of(part_at(side, edge, a, b));
        }
        joint.open_count = joint.count;
        for (int i = 0; i < count; ++i) {
            joint.part[i] = name_of(i);
            if (joint.part[i] >= joint.open_count && size[root_of(i)] < even_.floor) {
                return false;
            }
        }
        return true;
    }

    /// What a way is like at the outer edges of its block, and how many large sub-meshes it has.
    void describe(
        const FaceBlock& block, const Way& a, const Way& b, const Joint& joint, Way& way) const {
        way.large_count = a.large_count + b.large_count;
        for (int i = joint.open_count; i < joint.count; ++i) {
            way.large_count += joint.size[i] > even_.floor;
        }
        way.part_count = joint.open_count;
        for (int i = 0; i < way.part_count; ++i) {
            way.size[i] = static_cast<std::uint8_t>(joint.size[i]);
        }
        for (std::size_t e = 0; e < block.origin.size(); ++e) {
            const auto [side, edge] = block.origin[e];
            way.part[e] = static_cast<std::uint8_t>(joint.part[part_at(side, edge, a, b)]);
        }
    }

    /// Equal for ways that are alike at the outer edges, and hardly ever for others.
    static std::uint64_t key_of(const FaceBlock& block, const Way& way) {
        std::uint64_t key = Random(static_cast<std::uint64_t>(way.large_count)).next();
        const auto add = [&key](std::uint8_t value) { key = Random(key + value).next(); };
        std::for_each(way.part.begin(), way.part.begin() + block.outer.size(), add);
        std::for_each(way.size.begin(), way.size.begin() + way.part_count, add);
        return key;
    }

    /// Has one of the sub-meshes that the joint completes a bowtie?
    bool completes_bowtie(const FaceBlock& block, const Way& way, const Joint& joint) {
        bool found = false;
        for (int i = joint.open_count; i < joint.count && !found; ++i) {
            const std::vector<int> faces = faces_of_part(block, way, joint, i);
            for (int f : faces) {
                is_marked_[f] = 1;
            }
            const auto is_outside = [this](int face) { return face < 0 || is_marked_[face] == 0; };
            found = bowtie_finder_.has_bowtie(faces, 0, faces.size(), [&](int face, int corner) {
                return is_outside(patchwork_.neighbor(face, corner)) +
                    is_outside(patchwork_.neighbor(face, previous_corner(corner)));
            });
            for (int f : faces) {
                is_marked_[f] = 0;
            }
        }
        return found;
    }

    /// The faces of a part of a block; `way` need not be in its list yet.
    std::vector<int>
    faces_of_part(const FaceBlock& block, const Way& way, const Joint& joint, int part) const {
        struct Step {
            int block;
            int way;
            int part;
        };
        std::vector<Step> steps;
        const auto add_origins =
            [&](const FaceBlock& whole, const Way& its, const Joint& of, int wanted) {
                int at = 0;
                for (const int side : {0, 1}) {
                    const int count = ways_[whole.of[side]][its.of[side]].part_count;
                    for (int i = 0; i < count; ++i) {
                        if (of.part[at++] == wanted) {
                            steps.push_back({whole.of[side], its.of[side], i});
                        }
                    }
                }
            };
        add_origins(block, way, joint, part);
        std::vector<int> faces;
        while (!steps.empty()) {
            const Step step = steps.back();
            steps.pop_back();
            const FaceBlock& inner = blocks_[step.block];
            if (inner.is_face()) {
                faces.push_back(faces_[step.block]);
            } else {
                Joint of;
                const Way& its = ways_[step.block][step.way];
                join_ways(inner, its, of);
                add_origins(inner, its, of, step.part);
            }
        }
        return faces;
    }

    void join_ways(const FaceBlock& block, const Way& way, Joint& joint) const {
        join_parts(
            block, ways_[block.of[0]][way.of[0]], ways_[block.of[1]][way.of[1]], way.joints, joint);
    }

    /// Labels the faces of the region as one of the ways to cut the last block, which is all of it.
    void label_faces(const Region& region, int way) {
        for (int label : region.labels) {
            patchwork_.load[label] = 0;
        }
        std::size_t used = 0;
        struct Step {
            int block;
            int way;
            std::vector<int> labels; // of its parts
        };
        std::vector<Step> steps = {{static_cast<int>(blocks_.size()) - 1, way, {}}};
        while (!steps.empty()) {
            Step step = std::move(steps.back());
            steps.pop_back();
            const FaceBlock& block = blocks_[step.block];
            if (block.is_face()) {
                patchwork_.set_label(faces_[step.block], step.labels[0]);
                ++patchwork_.load[step.labels[0]];
                continue;
            }
            const Way& its = ways_[step.block][step.way];
            Joint joint;
            join_ways(block, its, joint);
            for (int i = joint.open_count; i < joint.count; ++i) {
                step.labels.push_back(region.labels[used++]);
            }
            int at = 0;
            for (const int side : {0, 1}) {
                Step next = {block.of[side], its.of[side], {}};
                const int count = ways_[next.block][next.way].part_count;
                for (int i = 0; i < count; ++i) {
                    next.labels.push_back(step.labels[joint.part[at++]]);
                }
                steps.push_back(std::move(next));
            }
        }
    }

    Patchwork& patchwork_;
    std::int64_t& work_left_;
    const Deadline* const deadline_;
    const Progress& progress_;
    const LoadRange even_;
    BowtieFinder bowtie_finder_;
    std::vector<std::uint8_t> is_marked_;
    SubmeshFaces faces_of_;
    /// The faces of the region, its blocks, and the ways to cut each of these, as listed so far.
    std::vector<int> faces_;
    std::vector<FaceBlock> blocks_;
    std::vector<std::vector<Way>> ways_;
    /// Sub-meshes of the region with one face more than the others.
    int most_large_ = 0;
    int tries_of_all_ = 0;
    std::int64_t unreported_work_ = 0;
    Random random_{0x6e6172726f77ULL};
};

} // namespace

bool cut_narrow_regions(Patchwork& patchwork,
                        std::int64_t& work_left,
                        const Deadline* deadline,
                        const Progress& progress) {
    return even_loads(patchwork).ceiling <= kLargestSubmesh &&
        NarrowCut(patchwork, work_left, deadline, progress).run();
}

} // namespace spheroseg
