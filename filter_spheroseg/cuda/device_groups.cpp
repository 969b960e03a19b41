// SPDX-License-Identifier: GPL-3.0-or-later
#include "device_groups.h"

#include <algorithm>
#include <numeric>

namespace spheroseg::cuda {

namespace {

/// The most partners of all labels together: no more faces than the mesh has begin their lists.
std::size_t most_partners(int face_count, int submesh_count) {
    return partner_capacity(0) * static_cast<std::size_t>(submesh_count) +
        (partner_capacity(1) - partner_capacity(0)) * static_cast<std::size_t>(face_count);
}

std::vector<float> quantiles() {
    return {exponential_quantiles().begin(), exponential_quantiles().end()};
}

std::vector<int> cell_counts_of(const Patchwork& patchwork) {
    std::vector<int> counts(patchwork.submesh_count(), 0);
    for (const Cell& cell : patchwork.cells) {
        ++counts[cell.label];
    }
    return counts;
}

/// Lists of partners of all labels, each with room to grow.
class DevicePartners {
public:
    DevicePartners(Device& device, int face_count, int submesh_count)
        : faces_(device, most_partners(face_count, submesh_count)),
          begin_(device, static_cast<std::size_t>(submesh_count) + 1),
          counts_(device, submesh_count) {}

    /// Begins them with the boundary faces of all groups.
    void begin(const Patchwork& patchwork, Grouping& grouping) {
        host_counts_.assign(patchwork.submesh_count(), 0);
        for (int g = 0; g < grouping.group_count(); ++g) {
            for (int face : grouping.faces(g)) {
                ++host_counts_[patchwork.cells[face].label];
            }
        }
        host_begin_.assign(1, 0);
        for (int count : host_counts_) {
            host_begin_.push_back(host_begin_.back() +
                                  static_cast<long long>(partner_capacity(count)));
        }
        host_faces_.resize(host_begin_.back());
        std::vector<long long> next(host_begin_.begin(), host_begin_.end() - 1);
        for (int g = 0; g < grouping.group_count(); ++g) {
            for (int face : grouping.faces(g)) {
                host_faces_[next[patchwork.cells[face].label]++] = face;
            }
        }
        faces_.upload(host_faces_);
        begin_.upload(host_begin_);
        counts_.upload(host_counts_);
    }

    void show(AnnealArrays& arrays) const {
        arrays.partners = faces_.data();
        arrays.partner_begin = begin_.data();
        arrays.partner_counts = counts_.data();
    }

private:
    DeviceArray<int> faces_;
    DeviceArray<long long> begin_;
    DeviceArray<int> counts_;
    std::vector<int> host_faces_;
    std::vector<long long> host_begin_;
    std::vector<int> host_counts_;
};

class GroupsOnDevice : public spheroseg::DeviceGroups {
public:
    /// Sets `was_used` when a phase runs.
    GroupsOnDevice(
        Device& device, bool& was_used, const Patchwork& patchwork, bool with_partners, int threads)
        : device_(device), was_used_(was_used), threads_(threads),
          host_cell_counts_(cell_counts_of(patchwork)), host_labels_(cell_labels(patchwork)),
          host_loads_(patchwork.load.size()), cells_(device, patchwork.cells),
          labels_(device, host_labels_), listed_(device, patchwork.cells.size()),
          faces_(device, patchwork.cells.size()), loads_(device, patchwork.load.size()),
          cell_counts_(device, host_cell_counts_), group_of_label_(device, patchwork.load.size()),
          order_(device, patchwork.load.size()), face_begin_(device, patchwork.load.size()),
          face_counts_(device, patchwork.load.size()), quantiles_(device, quantiles()),
          change_(device, 1) {
        face_counts_.clear(); // Downloaded whole; there are fewer groups than sub-meshes.
        if (with_partners) {
            partners_ = std::make_unique<DevicePartners>(
                device, patchwork.face_count(), patchwork.submesh_count());
        }
    }

    std::int64_t run(const Phase& phase,
                     const FreeLoads& loads,
                     Patchwork& patchwork,
                     Grouping& grouping,
                     BoundaryFaces& boundary) override {
        return run_phase(phase, loads, patchwork, grouping, boundary);
    }

    std::int64_t run(const Phase& phase,
                     const BoundedLoads& loads,
                     Patchwork& patchwork,
                     Grouping& grouping,
                     BoundaryFaces& boundary) override {
        partners_->begin(patchwork, grouping);
        return run_phase(phase, loads, patchwork, grouping, boundary);
    }

private:
    template <typename Loads>
    std::int64_t run_phase(const Phase& phase,
                           const Loads& loads,
                           Patchwork& patchwork,
                           Grouping& grouping,
                           BoundaryFaces& boundary) {
        was_used_ = true;
        send(patchwork, grouping, boundary);
        change_.clear();
        AnnealArrays arrays{cells_.data(),
                            labels_.data(),
                            listed_.data(),
                            loads_.data(),
                            cell_counts_.data(),
                            group_of_label_.data(),
                            quantiles_.data(),
                            order_.data(),
                            faces_.data(),
                            face_begin_.data(),
                            face_counts_.data(),
                            nullptr,
                            nullptr,
                            nullptr,
                            change_.data(),
                            grouping.group_count(),
                            patchwork.may_close_rings};
        if (partners_) {
            partners_->show(arrays);
        }
        device_.anneal_groups(arrays, phase, loads);
        receive(patchwork, grouping, boundary);
        std::vector<unsigned long long> change;
        change_.download(change);
        return static_cast<std::int64_t>(change.front());
    }

    /// Labels and counts of faces are there already.
    void send(const Patchwork& patchwork, Grouping& grouping, BoundaryFaces& boundary) {
        const int group_count = grouping.group_count();
        const std::vector<int>& group_of_label = grouping.group_of_label();
        host_begin_.assign(group_count + 1, 0);
        for (int l = 0; l < patchwork.submesh_count(); ++l) {
            host_begin_[group_of_label[l] + 1] += host_cell_counts_[l];
            host_loads_[l] = grouping.load(l);
        }
        std::partial_sum(host_begin_.begin(), host_begin_.end(), host_begin_.begin());
        host_begin_.pop_back();
        host_counts_.clear();
        host_faces_.resize(patchwork.cells.size());
        for (int g = 0; g < group_count; ++g) {
            const std::vector<int>& faces = grouping.faces(g);
            host_counts_.push_back(static_cast<int>(faces.size()));
            std::copy(faces.begin(), faces.end(), host_faces_.begin() + host_begin_[g]);
        }
        listed_.upload(boundary.listed());
        faces_.upload(host_faces_);
        loads_.upload(host_loads_);
        group_of_label_.upload(group_of_label);
        order_.upload(grouping.largest_first());
        face_begin_.upload(host_begin_);
        face_counts_.upload(host_counts_);
    }

    void receive(Patchwork& patchwork, Grouping& grouping, BoundaryFaces& boundary) {
        labels_.download(host_labels_);
        listed_.download(boundary.listed());
        faces_.download(host_faces_);
        loads_.download(host_loads_);
        cell_counts_.download(host_cell_counts_);
        face_counts_.download(host_counts_);
        const int face_count = patchwork.face_count();
#pragma omp parallel for schedule(static) num_threads(threads_)
        for (int f = 0; f < face_count; ++f) {
            patchwork.set_own_label(f, host_labels_[f]);
        }
        patchwork.tell_neighbors(threads_);
        for (int l = 0; l < patchwork.submesh_count(); ++l) {
            grouping.load(l) = host_loads_[l];
        }
        for (int g = 0; g < grouping.group_count(); ++g) {
            const auto begin = host_faces_.begin() + host_begin_[g];
            grouping.faces(g).assign(begin, begin + host_counts_[g]);
        }
    }

    Device& device_;
    bool& was_used_;
    const int threads_;
    std::vector<int> host_cell_counts_;
    std::vector<int> host_labels_;
    std::vector<int> host_faces_;
    std::vector<int> host_loads_;
    std::vector<int> host_begin_;
    std::vector<int> host_counts_;
    DeviceArray<Cell> cells_;
    DeviceArray<int> labels_;
    DeviceArray<unsigned char> listed_;
    DeviceArray<int> faces_;
    DeviceArray<int> loads_;
    DeviceArray<int> cell_counts_;
    DeviceArray<int> group_of_label_;
    DeviceArray<int> order_;
    DeviceArray<int> face_begin_;
    DeviceArray<int> face_counts_;
    DeviceArray<float> quantiles_;
    DeviceArray<unsigned long long> change_;
    std::unique_ptr<DevicePartners> partners_;
};

} // namespace

std::size_t annealing_bytes(int face_count, int submesh_count, bool with_partners) {
    const auto faces = static_cast<std::size_t>(face_count);
    const auto labels = static_cast<std::size_t>(submesh_count);
    const std::size_t partners = with_partners
        ? sizeof(int) * (most_partners(face_count, submesh_count) + labels) +
            sizeof(long long) * (labels + 1)
        : 0;
    return faces * (sizeof(Cell) + 2 * sizeof(int) + 1) + labels * 6 * sizeof(int) +
        kQuantileCount * sizeof(float) + sizeof(unsigned long long) + partners;
}

std::unique_ptr<spheroseg::DeviceGroups>
DeviceAnnealing::begin_groups(const Patchwork& patchwork, bool with_partners, int thread_count) {
    require_memory(
        *device_,
        annealing_bytes(patchwork.face_count(), patchwork.submesh_count(), with_partners),
        "refinement");
    return std::make_unique<GroupsOnDevice>(
        *device_, was_used_, patchwork, with_partners, thread_count);
}

} // namespace spheroseg::cuda
