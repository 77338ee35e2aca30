#include "base/threads.hpp"

#include <tbb/global_control.h>

#include <sched.h>

#include <algorithm>

namespace raig {

size_t threadCount() {
    return tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
}

struct FewerProcessors::Processors {
    cpu_set_t set;
};

FewerProcessors::FewerProcessors() {
    Processors now;
    if (::sched_getaffinity(0, sizeof(now.set), &now.set) != 0) return;  // more processors than a set holds
    size_t wanted = threadCount();
    if (static_cast<size_t>(CPU_COUNT(&now.set)) <= wanted) return;
    Processors fewer;
    CPU_ZERO(&fewer.set);
    // From where it runs now: programs side by side should not all take the same.
    const int first = std::max(::sched_getcpu(), 0);
    for (int i = 0; i < CPU_SETSIZE && wanted > 0; ++i) {
        const int processor = (first + i) % CPU_SETSIZE;
        if (!CPU_ISSET(processor, &now.set)) continue;
        CPU_SET(processor, &fewer.set);
        --wanted;
    }
    if (::sched_setaffinity(0, sizeof(fewer.set), &fewer.set) == 0) before_ = std::make_unique<Processors>(now);
}

FewerProcessors::~FewerProcessors() {
    if (before_) ::sched_setaffinity(0, sizeof(before_->set), &before_->set);
}

}  // namespace raig
