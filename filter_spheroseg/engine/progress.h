// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "errors.h"

#include <chrono>
#include <functional>
#include <limits>
#include <memory>

namespace spheroseg {

/// Called from the calling thread only, with values that rise from 0 to 1 within one operation, and
/// the name of the running step. False means stop. May be empty.
using Progress = std::function<bool(double, const char*)>;

/// Reports progress and throws Cancelled when the callback answers false.
inline void report_progress(const Progress& progress, double fraction, const char* step) {
    if (progress && !progress(fraction, step)) {
        throw Cancelled("The operation was cancelled; the mesh was not changed.");
    }
}

/// The part [begin, end] of an enclosing operation's progress.
inline Progress sub_progress(const Progress& progress, double begin, double end) {
    if (!progress) {
        return {};
    }
    return [progress, begin, end](double fraction, const char* step) {
        return progress(begin + (end - begin) * fraction, step);
    };
}

/// Never falls back, where an operation may take more tries than were expected.
inline Progress rising_progress(const Progress& progress) {
    if (!progress) {
        return {};
    }
    // Shared by all copies.
    return [progress, most = std::make_shared<double>(0.0)](double fraction, const char* step) {
        *most = fraction > *most ? fraction : *most;
        return progress(*most, step);
    };
}

/// Wall-clock time since it was made.
class StopWatch {
public:
    double elapsed_seconds() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    }

private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// A time limit that runs from when it, or what it is a copy of, is made.
class Deadline {
public:
    /// `limit_seconds` <= 0: no limit.
    explicit Deadline(double limit_seconds = 0.0) : limit_seconds_(limit_seconds) {}

    double elapsed_seconds() const { return watch_.elapsed_seconds(); }
    /// Infinite where there is no limit; below 0 when it has expired.
    double left_seconds() const {
        return limit_seconds_ > 0.0 ? limit_seconds_ - elapsed_seconds()
                                    : std::numeric_limits<double>::infinity();
    }
    bool expired() const { return left_seconds() <= 0.0; }
    /// That of searches where a result is not valid: they may take as long again, and a second.
    Deadline for_searches() const {
        Deadline later = *this;
        later.limit_seconds_ = limit_seconds_ > 0.0 ? 2.0 * limit_seconds_ + 1.0 : 0.0;
        return later;
    }

private:
    StopWatch watch_;
    double limit_seconds_;
};

} // namespace spheroseg
