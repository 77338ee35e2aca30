#include "base/error.hpp"
#include "base/parallel.hpp"
#include "rays/cpu_walk.hpp"

#include <chrono>
#include <mutex>

namespace raig {

namespace cpu_walks {
#define RAIG_WALK(name)                                                                                        \
    void name(const Structure& structure, WalkOptions options, std::span<const Ray> rays, std::span<Hit> hits, \
              WalkCounters& counters);                                                                         \
    uint64_t name##MostSteps(const Structure& structure);
#include "walks.def"
#undef RAIG_WALK
}  // namespace cpu_walks

CpuWalk cpuWalk(std::string_view walkFile) {
#define RAIG_WALK(name) \
    if (walkFile == #name) return cpu_walks::name;
#include "walks.def"
#undef RAIG_WALK
    RAIG_CHECK(false && "a file of shaders/structures/");
    return nullptr;
}

uint64_t mostStepsOf(const Structure& structure) {
    const std::string_view walkFile = structure.walkFile();
#define RAIG_WALK(name) \
    if (walkFile == #name) return cpu_walks::name##MostSteps(structure);
#include "walks.def"
#undef RAIG_WALK
    RAIG_CHECK(false && "a file of shaders/structures/");
    return 0;
}

CorruptStructure::CorruptStructure(const Structure& structure)
    : std::logic_error(fmt::format("the {} structure is corrupt: a walk through it does not end within {} steps",
                                   structure.name, mostStepsOf(structure))) {}

namespace {

class CpuTracer : public Tracer {
public:
    explicit CpuTracer(const Structure& structure) : structure_(structure), walk_(cpuWalk(structure.walkFile())) {}

    TraceReport trace(std::span<const Ray> rays, std::span<Hit> hits, Query query) override {
        return run(rays, hits, {.anyHit = query == Query::any, .skipSeeThrough = false});
    }
    TraceReport traceShadows(std::span<const Ray> rays, std::span<Hit> hits) override {
        return run(rays, hits, {.anyHit = true, .skipSeeThrough = true});
    }
    /// One by one: walks count for all of the rays that they are given.
    TraceReport traceCosts(std::span<const Ray> rays, std::span<Hit> hits, Query query, bool shadows,
                           std::span<uint32_t> costs) override {
        RAIG_CHECK(hits.size() == rays.size() && costs.size() == rays.size() && (!shadows || query == Query::any));
        const WalkOptions options{.anyHit = query == Query::any, .skipSeeThrough = shadows};
        return runBlocks(rays.size(), [&](size_t begin, size_t end, WalkCounters& counters) {
            for (size_t i = begin; i < end; ++i) {
                WalkCounters one;
                walk_(structure_, options, rays.subspan(i, 1), hits.subspan(i, 1), one);
                costs[i] = static_cast<uint32_t>(one.nodeFetches + one.triangleTests);
                counters += one;
            }
        });
    }

private:
    TraceReport run(std::span<const Ray> rays, std::span<Hit> hits, WalkOptions options) {
        RAIG_CHECK_OP(rays.size(), ==, hits.size());
        return runBlocks(rays.size(), [&](size_t begin, size_t end, WalkCounters& counters) {
            walk_(structure_, options, rays.subspan(begin, end - begin), hits.subspan(begin, end - begin), counters);
        });
    }

    /// `body(begin, end, counters)` over blocks of `count` rays, timed, its counters summed.
    template <class Body>
    static TraceReport runBlocks(size_t count, const Body& body) {
        const auto start = std::chrono::steady_clock::now();
        TraceReport report;
        std::mutex mutex;
        parallelFor(count, 256, [&](size_t begin, size_t end) {
            WalkCounters counters;
            body(begin, end, counters);
            const std::lock_guard lock(mutex);
            report.counters += counters;
        });
        report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        return report;
    }

    const Structure& structure_;
    CpuWalk walk_;
};

}  // namespace

std::unique_ptr<Tracer> makeCpuTracer(const Structure& structure) {
    return std::make_unique<CpuTracer>(structure);
}

}  // namespace raig
