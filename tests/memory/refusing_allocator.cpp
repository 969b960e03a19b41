// SPDX-License-Identifier: GPL-3.0-or-later
// Replaces the allocator of the program.
#include "refusing_allocator.h"

#include <atomic>
#include <cstdlib>
#include <new>

namespace spheroseg::test {

namespace {

constexpr long long kOff = -1;
constexpr long long kRefused = -2;
std::atomic<long long> countdown{kOff};

} // namespace

void refuse_allocation(long long number) {
    countdown = number;
}

bool stop_refusing() {
    return countdown.exchange(kOff) == kRefused;
}

static void* allocate(std::size_t size) {
    long long left = countdown.load();
    while (left >= 0 && !countdown.compare_exchange_weak(left, left > 0 ? left - 1 : kRefused)) {
    }
    return left == 0 ? nullptr : std::malloc(size > 0 ? size : 1);
}

} // namespace spheroseg::test

void* operator new(std::size_t size) {
    void* const memory = spheroseg::test::allocate(size);
    if (!memory) {
        throw std::bad_alloc();
    }
    return memory;
}
void* operator new[](std::size_t size) {
    return operator new(size);
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
    return spheroseg::test::allocate(size);
}
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept {
    return spheroseg::test::allocate(size);
}
void operator delete(void* memory) noexcept {
    std::free(memory);
}
void operator delete[](void* memory) noexcept {
    std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
    std::free(memory);
}
void operator delete[](void* memory, std::size_t) noexcept {
    std::free(memory);
}
