// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <exception>

namespace spheroseg {

/// Carries an exception out of a parallel region, which it must not leave by itself: the program
/// would end. Every call that may throw there (all that allocates) goes through `guard`;
/// `rethrow` follows the region, with the first one.
class ParallelFailure {
public:
    template <typename Work> void guard(Work&& work) noexcept {
        try {
            work();
        } catch (...) {
#pragma omp critical(spheroseg_parallel_failure)
            failure_ = failure_ ? failure_ : std::current_exception();
        }
    }

    void rethrow() const {
        if (failure_) {
            std::rethrow_exception(failure_);
        }
    }

private:
    std::exception_ptr failure_;
};

} // namespace spheroseg
