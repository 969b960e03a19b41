// SPDX-License-Identifier: GPL-3.0-or-later
#include "waiting_threads.h"

// Clang has an OpenMP library of its own, whose threads sleep after a fifth of a second.
#if defined(__linux__) && defined(__GNUC__) && !defined(__clang__)

#include <atomic>
#include <cstdlib>
#include <mutex>
#include <pthread.h>
#include <signal.h>
#include <unistd.h>

namespace spheroseg {

namespace {

const bool kPolicyIsGiven = std::getenv("OMP_WAIT_POLICY") || std::getenv("GOMP_SPINCOUNT");

/// Stays for as long as the process: no signal can wake it, so it does not return to code of a
/// plugin that may have been unloaded.
void* idle_with_a_team(void*) {
    std::atomic<int> members{0};
#pragma omp parallel num_threads(2)
    ++members; // as an empty team would not be made
    while (true) {
        pause();
    }
}

void start_idle_team() {
    sigset_t all;
    sigset_t before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    pthread_t thread;
    if (pthread_create(&thread, nullptr, idle_with_a_team, nullptr) == 0) {
        pthread_detach(thread);
    }
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

} // namespace

void keep_waiting_threads_calm() {
    static std::once_flag once;
    if (!kPolicyIsGiven) {
        std::call_once(once, start_idle_team);
    }
}

} // namespace spheroseg

#else

namespace spheroseg {

void keep_waiting_threads_calm() {}

} // namespace spheroseg

#endif
