/// How many threads work is shared by: those of raig's own loops, and those of libraries that start their own.
#pragma once

#include <cstddef>
#include <memory>

namespace raig {

/// How many threads parallel loops may use, as the program's --threads says.
size_t threadCount();

/// While it lives, the calling thread, and every thread that is started by it, runs on threadCount() of the processors only:
/// for libraries that start one a processor, whatever they are told. Does nothing where there are no more processors.
class FewerProcessors {
public:
    FewerProcessors();
    ~FewerProcessors();
    FewerProcessors(const FewerProcessors&) = delete;
    FewerProcessors& operator=(const FewerProcessors&) = delete;

private:
    struct Processors;
    std::unique_ptr<Processors> before_;  ///< those that the thread could use, where they are more
};

}  // namespace raig
