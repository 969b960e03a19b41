// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace spheroseg {

/// Notes a Ctrl-C (SIGINT) while it exists. For hosts that handle the signal only when the filter
/// has ended, as Python does: where the process has a handler for it, that handler still gets every
/// signal, at once, and is the installed one again afterwards; one that is installed meanwhile
/// stays. Where a Ctrl-C ends the process or is ignored, as in the MeshLab application, nothing
/// changes and none is noted; nor on systems without POSIX signals.
///
/// One at a time in a process. Nothing throws.
class InterruptWatch {
public:
    InterruptWatch();
    ~InterruptWatch();
    InterruptWatch(const InterruptWatch&) = delete;
    InterruptWatch& operator=(const InterruptWatch&) = delete;

    bool interrupted() const;
};

} // namespace spheroseg
