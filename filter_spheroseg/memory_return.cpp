// SPDX-License-Identifier: GPL-3.0-or-later
#include "memory_return.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace spheroseg {

void MemoryReturn::count(std::size_t faces) {
    constexpr std::size_t kFacesBetween = 1'000'000;
    faces_ += faces;
    if (faces_ >= kFacesBetween) {
        faces_ = 0;
#ifdef __GLIBC__
        malloc_trim(0);
#endif
    }
}

} // namespace spheroseg
