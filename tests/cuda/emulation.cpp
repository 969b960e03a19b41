// SPDX-License-Identifier: GPL-3.0-or-later
#include "emulation.h"

#include "random.h"

#include <cstdint>
#include <exception>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <setjmp.h>
#include <stdexcept>
#include <string>
#include <ucontext.h>
#include <vector>

#if defined(__SANITIZE_ADDRESS__)
#define SPHEROSEG_ADDRESS_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define SPHEROSEG_ADDRESS_SANITIZER 1
#endif
#endif
#if defined(SPHEROSEG_ADDRESS_SANITIZER)
#include <sanitizer/common_interface_defs.h>
#endif

namespace spheroseg::emulation {

Index thread_index;
Index block_index;
Index block_size;
Index grid_size;

namespace {

constexpr std::size_t kStackBytes = std::size_t{64} << 10;

/// Where a stack stands. Jumps save no signal mask, which makes them several times faster than
/// contexts; the sanitizer knows contexts only.
struct Place {
    ucontext_t context{};
    jmp_buf jump{};
    bool jumps = false;
};

/// A stack as the address sanitizer wants to know it.
struct Stack {
    const void* bottom = nullptr;
    std::size_t bytes = 0;
    void* fake = nullptr;
};

/// From the running stack to another one; returns when that one, or a third, switches back.
void switch_stacks(Place& from, Stack& from_stack, Place& to, const Stack& to_stack) {
#if defined(SPHEROSEG_ADDRESS_SANITIZER)
    __sanitizer_start_switch_fiber(&from_stack.fake, to_stack.bottom, to_stack.bytes);
    swapcontext(&from.context, &to.context);
    __sanitizer_finish_switch_fiber(from_stack.fake, nullptr, nullptr);
#else
    (void)from_stack;
    (void)to_stack;
    from.jumps = true;
    if (_setjmp(from.jump) == 0) {
        if (to.jumps) {
            _longjmp(to.jump, 1);
        }
        setcontext(&to.context);
    }
#endif
}

struct Fibre {
    Place place;
    std::unique_ptr<char[]> memory;
    Stack stack;
    bool finished = false;
};

/// The threads of one block after the other; kept for the next launch with as many threads.
class BlockRunner {
public:
    explicit BlockRunner(unsigned int threads);

    void run_block(const std::function<void()>& kernel, std::size_t shared_bytes, Random& random);
    void* shared() { return shared_.get(); }
    /// Called by the running fibre: lets the others come to the barrier too.
    bool wait(bool value);

private:
    static void enter();

    std::vector<Fibre> fibres_;
    std::vector<int> order_;
    const std::function<void()>* kernel_ = nullptr;
    std::unique_ptr<char[]> shared_;
    Place scheduler_;
    Stack scheduler_stack_;
    int running_ = 0;
    bool next_or_ = false;
    bool last_or_ = false;
    std::exception_ptr error_;
};

BlockRunner* runner = nullptr;

BlockRunner::BlockRunner(unsigned int threads) : fibres_(threads), order_(threads) {
    std::iota(order_.begin(), order_.end(), 0);
    for (Fibre& fibre : fibres_) {
        fibre.memory = std::make_unique<char[]>(kStackBytes);
        fibre.stack = {fibre.memory.get(), kStackBytes, nullptr};
        ucontext_t& context = fibre.place.context;
        getcontext(&context);
        context.uc_stack.ss_sp = fibre.memory.get();
        context.uc_stack.ss_size = kStackBytes;
        makecontext(&context, &BlockRunner::enter, 0);
    }
}

void BlockRunner::enter() {
#if defined(SPHEROSEG_ADDRESS_SANITIZER)
    __sanitizer_finish_switch_fiber(
        nullptr, &runner->scheduler_stack_.bottom, &runner->scheduler_stack_.bytes);
#endif
    Fibre& fibre = runner->fibres_[runner->running_];
    for (;;) {
        try {
            (*runner->kernel_)();
        } catch (...) {
            runner->error_ = std::current_exception();
        }
        fibre.finished = true;
        switch_stacks(fibre.place, fibre.stack, runner->scheduler_, runner->scheduler_stack_);
    }
}

bool BlockRunner::wait(bool value) {
    next_or_ = next_or_ || value;
    Fibre& fibre = fibres_[running_];
    switch_stacks(fibre.place, fibre.stack, scheduler_, scheduler_stack_);
    thread_index = {static_cast<unsigned int>(running_), 0, 0};
    return last_or_;
}

void BlockRunner::run_block(const std::function<void()>& kernel,
                            std::size_t shared_bytes,
                            Random& random) {
    kernel_ = &kernel;
    shared_ = std::make_unique<char[]>(std::max<std::size_t>(1, shared_bytes));
    std::memset(shared_.get(), 0xff, shared_bytes); // floats that are no numbers
    for (int i = static_cast<int>(order_.size()) - 1; i > 0; --i) {
        std::swap(order_[i], order_[random.below(i + 1)]);
    }
    for (Fibre& fibre : fibres_) {
        fibre.finished = false;
    }
    for (std::size_t finished = 0; finished < fibres_.size();) {
        next_or_ = false;
        finished = 0;
        for (int index : order_) {
            running_ = index;
            thread_index = {static_cast<unsigned int>(index), 0, 0};
            switch_stacks(scheduler_, scheduler_stack_, fibres_[index].place, fibres_[index].stack);
            finished += fibres_[index].finished ? 1 : 0;
        }
        if (error_) {
            std::rethrow_exception(error_);
        }
        if (finished != 0 && finished != fibres_.size()) {
            throw std::logic_error("Expected all threads of a block at its barrier, found " +
                                   std::to_string(finished) + " of " +
                                   std::to_string(fibres_.size()) + " finished.");
        }
        last_or_ = next_or_;
        std::reverse(order_.begin(), order_.end());
    }
}

} // namespace

void run(const Launch& launch, const std::function<void()>& kernel) {
    static std::map<unsigned int, std::unique_ptr<BlockRunner>> runners;
    Random random(launch.order_seed);
    const unsigned int blocks = launch.grid.x * launch.grid.y;
    std::vector<unsigned int> order(blocks);
    std::iota(order.begin(), order.end(), 0U);
    for (unsigned int i = blocks; i > 1; --i) {
        std::swap(order[i - 1], order[random.below(i)]);
    }
    std::unique_ptr<BlockRunner>& kept = runners[launch.threads];
    // Fibres of a launch that failed stand in the middle of a kernel: they are not used again.
    std::unique_ptr<BlockRunner> used =
        kept ? std::move(kept) : std::make_unique<BlockRunner>(launch.threads);
    runner = used.get();
    block_size = {launch.threads, 1, 1};
    grid_size = launch.grid;
    for (unsigned int block : order) {
        block_index = {block % launch.grid.x, block / launch.grid.x, 0};
        used->run_block(kernel, launch.shared_bytes, random);
    }
    kept = std::move(used);
}

float rough_root(float value) {
    if (value < std::numeric_limits<float>::min()) {
        return 0.0f;
    }
    const float root = std::sqrt(value);
    std::uint32_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    switch (bits % 3) {
    case 0:
        return root * (1.0f + 0x1.0p-22f);
    case 1:
        return root * (1.0f - 0x1.0p-22f);
    default:
        return root;
    }
}

void* shared_memory() {
    return runner->shared();
}

void barrier() {
    runner->wait(false);
}

bool barrier_or(bool value) {
    return runner->wait(value);
}

} // namespace spheroseg::emulation
