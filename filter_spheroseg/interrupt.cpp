// SPDX-License-Identifier: GPL-3.0-or-later
#include "interrupt.h"

#if defined(__unix__) || defined(__APPLE__)

#include <atomic>
#include <signal.h>

namespace spheroseg {

namespace {

// Global, as a handler is given nothing else.
std::atomic<bool> noted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a handler must not wait for a lock");
struct sigaction host_action;

void note_and_hand_on(int signal_number, siginfo_t* info, void* context) {
    noted = true;
    if (host_action.sa_flags & SA_SIGINFO) {
        host_action.sa_sigaction(signal_number, info, context);
    } else {
        host_action.sa_handler(signal_number);
    }
}

bool is_ours(const struct sigaction& action) {
    return (action.sa_flags & SA_SIGINFO) && action.sa_sigaction == note_and_hand_on;
}

bool is_handler(const struct sigaction& action) {
    return (action.sa_flags & SA_SIGINFO) ||
        (action.sa_handler != SIG_DFL && action.sa_handler != SIG_IGN);
}

} // namespace

InterruptWatch::InterruptWatch() {
    noted = false;
    struct sigaction installed;
    // Ours may be there: put back by somebody whose own handler had taken its place for a while. It
    // must not call itself.
    if (sigaction(SIGINT, nullptr, &installed) != 0 || is_ours(installed) ||
        !is_handler(installed)) {
        return;
    }
    host_action = installed;
    struct sigaction ours = installed;
    ours.sa_flags |= SA_SIGINFO;
    ours.sa_sigaction = note_and_hand_on;
    sigaction(SIGINT, &ours, nullptr);
}

InterruptWatch::~InterruptWatch() {
    struct sigaction installed;
    if (sigaction(SIGINT, nullptr, &installed) == 0 && is_ours(installed)) {
        sigaction(SIGINT, &host_action, nullptr);
    }
}

bool InterruptWatch::interrupted() const {
    return noted;
}

} // namespace spheroseg

#else

namespace spheroseg {

InterruptWatch::InterruptWatch() = default;
InterruptWatch::~InterruptWatch() = default;

bool InterruptWatch::interrupted() const {
    return false;
}

} // namespace spheroseg

#endif
