// SPDX-License-Identifier: GPL-3.0-or-later
#include "level_annealing.h"

#include "repair.h"

namespace spheroseg {

void uncoarsen(Patchwork& patchwork, const Multilevel& multilevel, int thread_count) {
    const bool opened = multilevel.uncoarsen(patchwork, thread_count);
    if (opened || patchwork.may_be_unsound) {
        repair_unsound(patchwork);
    }
}

} // namespace spheroseg
