// SPDX-License-Identifier: GPL-3.0-or-later
// In place of the GPU in builds without CUDA.
#include "device.h"

namespace spheroseg::cuda {

DeviceSearch find_device() {
    return {nullptr, "this build has no CUDA (configure with -DSPHEROSEG_CUDA=ON)"};
}

bool built_with_cuda() {
    return false;
}

} // namespace spheroseg::cuda
