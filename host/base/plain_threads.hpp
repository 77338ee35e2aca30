/// The functions of base/parallel.hpp on threads of their own, for ThreadSanitizer: it cannot look into oneTBB's library,
/// and so takes what one thread hands to another there for a race. Slow, and for that build only.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace raig {

/// Runs `first` on a thread of its own and `second` on this one; one after the other where there are many threads already.
/// Throws what one of them throws, once both have ended.
template <class First, class Second>
void parallelInvoke(const First& first, const Second& second) {
    static std::atomic<int> threads = 0;
    struct Counted {
        const bool isOneTooMany = threads.fetch_add(1) >= 8;
        ~Counted() { --threads; }
    };
    std::exception_ptr failures[2];
    const auto guarded = [&failures](int place, const auto& call) {
        try {
            call();
        } catch (...) {
            failures[place] = std::current_exception();
        }
    };
    if (const Counted counted; counted.isOneTooMany) {
        guarded(0, first);
        guarded(1, second);
    } else {
        std::thread other([&] { guarded(0, first); });
        guarded(1, second);
        other.join();
    }
    for (const std::exception_ptr& failure : failures)
        if (failure) std::rethrow_exception(failure);
}

/// As in base/parallel.hpp.
template <class Body>
void parallelFor(size_t count, size_t grain, const Body& body) {
    std::atomic<size_t> next = 0;
    const auto work = [&] {
        for (size_t begin; (begin = next.fetch_add(grain)) < count;) body(begin, std::min(begin + grain, count));
    };
    if (count > grain)
        parallelInvoke([&] { parallelInvoke(work, work); }, work);
    else
        work();
}

/// As in base/parallel.hpp.
template <class Value, class Over, class Join>
Value parallelReduce(size_t count, size_t grain, const Value& identity, const Over& over, const Join& join) {
    Value sum = identity;
    std::mutex mutex;
    parallelFor(count, grain, [&](size_t begin, size_t end) {
        const Value part = over(begin, end, identity);
        const std::lock_guard lock(mutex);
        sum = join(std::move(sum), part);
    });
    return sum;
}

/// As in base/parallel.hpp; on this thread alone.
template <class Iterator, class Before = std::less<>>
void parallelSort(Iterator begin, Iterator end, const Before& before = {}) {
    std::sort(begin, end, before);
}

}  // namespace raig
