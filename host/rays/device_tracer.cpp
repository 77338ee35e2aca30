#include "base/error.hpp"
#include "device/buffer.hpp"
#include "device/commands.hpp"
#include "device/kernel.hpp"
#include "rays/cpu_walk.hpp"
#include "rays/kernels.hpp"
#include "rays/tracer.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <optional>

namespace raig {

namespace {

constexpr uint32_t workgroupSize = 256;
constexpr uint32_t mostRaysAtOnce = 1u << 20;  // of trace(): 48 MiB of rays and hits

// Loop iterations of a walk in one dispatch. What is not done after the first is taken up again; at most `mostSteps` stays
// below the 65,535 after which Mesa 22.3's llvmpipe silently stops looping.
constexpr uint32_t wholeSteps = 512;  // few walks are longer, and then a few long ones would keep many short ones waiting
constexpr uint32_t pairedSteps = 384;  // of two rays, four nodes a step: no ray of the real scenes tried needs more
constexpr uint32_t firstSteps = 64;
constexpr uint32_t instancedFactor = 16;  // both, through two levels: rounds are counted by their most
constexpr uint32_t mostSteps = 16384;

/// Push constants of shaders/trace.comp.in.
struct Push {
    uint32_t first;
    uint32_t count;
    uint32_t maxSteps;
};

/// A walk of shaders/trace.comp.in that is not finished.
struct Pause {
    uvec4 at;
    uint32_t ray;
    uint32_t top;
    std::array<uint32_t, 2> padding;
};

/// Where shaders/trace.comp.in counts.
struct Counts {
    uint32_t unfinished;
    std::array<uint32_t, 2> nodeFetches;  // low and high halves
    std::array<uint32_t, 2> triangleTests;
    std::array<uint32_t, 2> boxTests;
    std::array<uint32_t, 2> linkReads;
    uint32_t failedHints;
    std::array<uint32_t, 2> padding;
};

uint64_t joined(const std::array<uint32_t, 2>& halves) {
    return halves[0] | uint64_t{halves[1]} << 32;
}

/// What is asked of a batch of rays.
struct Ask {
    Query query = Query::closest;
    bool shadows = false;
    std::span<uint32_t> costs = {};  ///< of each ray; empty: they are not wanted
    const Buffer* hints = nullptr;   ///< of each ray; none: there are none
};

/// How much one kernel should do in a dispatch, so that it takes about as long as it should; in loop iterations, if all rays
/// made as many as they may. Starts with little, as nothing is known of device and structure, and learns from what
/// dispatches took. Most rays end early, so the next may take longer than the last: the most is what a CPU can loop in 2 s.
class DispatchSize {
public:
    /// `paired`: loop iterations are of two rays, and count as two.
    DispatchSize(const DeviceInfo& device, bool paired)
        : DispatchSize(device.type == DeviceType::software, device.prefersTexel, paired) {}

    /// Rays for a dispatch of `steps`; whole workgroups.
    uint32_t rays(uint32_t steps) const {
        return std::max(static_cast<uint32_t>(work_ / steps) / workgroupSize, 1u) * workgroupSize;
    }
    /// Steps for a dispatch of `rays`.
    uint32_t steps(uint32_t rays) const { return static_cast<uint32_t>(std::clamp<double>(work_ / rays, 16, mostSteps)); }

    void learn(double work, double seconds) {
        if (work < 0.5 * work_ && seconds < target_) return;  // a remainder tells little
        work_ = std::clamp(work * std::clamp(target_ / seconds, 0.0625, 8.0), 0x1p12, most_);
    }

private:
    DispatchSize(bool software, bool llvmpipe, bool paired)
        : target_(software ? 0.25 : 0.02), most_((llvmpipe ? 0x1p26 : software ? 0x1p24 : 0x1p31) * (paired ? 3.0 : 1.0)),
          work_(software ? 0x1p18 : 0x1p22) {}

    double target_;  // seconds
    double most_;
    double work_;
};

struct SizedKernel {
    Kernel kernel;
    DispatchSize size;
    uint32_t raysAGroup;
};

/// The kernels of one kind of query. Walks in one go, or in pieces: the first, and those after it.
enum class Stage : uint32_t { whole, beginning, resuming };
struct Stages {
    std::array<std::optional<SizedKernel>, 3> kernels;
    bool pausing = false;  // a walk was longer than a dispatch
};

class VulkanTracer : public DeviceTracer {
public:
    VulkanTracer(Device& device, const Structure& structure, bool counting)
        : device_(device),
          name_("trace_" + std::string(structure.walkFile()) + (structure.isInstanced() ? "_instanced" : "") +
                (device.loadsTexel() ? "_texel" : "_storage")),
          walk_(structure.header.walk),
          mostSteps_(mostStepsOf(structure)),
          corrupt_(structure),
          counting_(counting),
          instanced_(structure.isInstanced()),
          paired_(device.loadsTexel() && !instanced_),
          spheres_(structure.hasSpheres()),
          wholeSteps_(instanced_ ? wholeSteps * instancedFactor : paired_ ? pairedSteps : wholeSteps),
          firstSteps_(instanced_ ? firstSteps * instancedFactor : firstSteps),
          header_(device, sizeof(StructureHeader)),
          nodes_(device, std::as_bytes(std::span(structure.nodes))),
          triangles_(device, std::as_bytes(std::span(structure.triangles))),
          counts_(device, sizeof(Counts)),
          paused_(device, sizeof(Pause)),
          unfinished_(device, sizeof(Pause)),
          commands_(device) {
        header_.uploadValues(std::span(&structure.header, 1));
    }

    TraceReport trace(std::span<const Ray> rays, std::span<Hit> hits, Query query) override {
        return traceAll(rays, hits, {.query = query});
    }
    TraceReport traceShadows(std::span<const Ray> rays, std::span<Hit> hits) override {
        return traceAll(rays, hits, {.query = Query::any, .shadows = true});
    }
    TraceReport traceCosts(std::span<const Ray> rays, std::span<Hit> hits, Query query, bool shadows,
                           std::span<uint32_t> costs) override {
        RAIG_CHECK_OP(costs.size(), ==, rays.size());
        return traceAll(rays, hits, {.query = query, .shadows = shadows, .costs = costs});
    }

    TraceReport traceBuffers(Buffer& rays, Buffer& hits, uint32_t count, Query query, bool shadows,
                             const Buffer* hints, uint32_t first) override {
        TraceReport report;
        run(rays, hits, first, count, {.query = query, .shadows = shadows, .hints = hints}, report);
        return report;
    }
    TraceReport traceBuffersCosts(Buffer& rays, Buffer& hits, uint32_t count, Query query, bool shadows,
                                  std::span<uint32_t> costs, const Buffer* hints, uint32_t first) override {
        RAIG_CHECK_OP(costs.size(), ==, count);
        TraceReport report;
        run(rays, hits, first, count, {.query = query, .shadows = shadows, .costs = costs, .hints = hints}, report);
        return report;
    }
    const BigArray& nodes() const override { return nodes_; }
    const BigArray& references() const override { return triangles_; }

private:
    TraceReport traceAll(std::span<const Ray> rays, std::span<Hit> hits, const Ask& ask) {
        RAIG_CHECK_OP(rays.size(), ==, hits.size());
        TraceReport report;
        if (rays.empty()) return report;
        const auto start = std::chrono::steady_clock::now();
        const auto most = static_cast<uint32_t>(std::min<size_t>(rays.size(), mostRaysAtOnce));
        Buffer rayBuffer(device_, most * sizeof(Ray));
        Buffer hitBuffer(device_, most * sizeof(Hit));
        for (size_t first = 0; first < rays.size(); first += most) {
            const auto count = static_cast<uint32_t>(std::min<size_t>(most, rays.size() - first));
            rayBuffer.uploadValues(rays.subspan(first, count));
            Ask some = ask;
            if (!ask.costs.empty()) some.costs = ask.costs.subspan(first, count);
            run(rayBuffer, hitBuffer, 0, count, some, report);
            hitBuffer.download(std::as_writable_bytes(hits.subspan(first, count)));
        }
        const double all = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        report.uploadSeconds = all - report.seconds;
        return report;
    }

    void run(Buffer& rays, Buffer& hits, uint32_t begin, uint32_t count, const Ask& ask, TraceReport& report) {
        RAIG_CHECK(ask.hints == nullptr || (ask.query == Query::closest && !ask.shadows));
        RAIG_CHECK(ask.query == Query::any || !ask.shadows);
        const uint32_t end = begin + count;
        if (!ask.costs.empty()) makeCosts(end);
        Buffer& counts = ask.costs.empty() ? counts_ : *costs_;
        Stages& stages = stagesOf(ask);
        for (uint32_t first = begin; first < end;) {
            if (!stages.pausing) {
                SizedKernel& whole = kernelFor(ask, Stage::whole);
                const uint32_t some = std::min(whole.size.rays(wholeSteps_), end - first);
                bind(whole.kernel, rays, hits, counts, ask);
                // Saving state costs every ray; so it is done only once a structure has shown that it needs it.
                const WalkCounters before = report.counters;
                const uint64_t failedBefore = report.failedHints;
                stages.pausing = dispatch(whole, {first, some, wholeSteps_}, counts, report) > 0;
                if (stages.pausing) {
                    report.counters = before;
                    report.failedHints = failedBefore;
                } else {
                    first += some;
                }
            } else {
                SizedKernel& beginning = kernelFor(ask, Stage::beginning);
                SizedKernel& resuming = kernelFor(ask, Stage::resuming);
                const uint32_t some = std::min(beginning.size.rays(firstSteps_), end - first);
                traceInPieces(beginning, resuming, rays, hits, {first, some, firstSteps_}, counts, ask, report);
                first += some;
            }
        }
        if (!ask.costs.empty())
            costs_->download(std::as_writable_bytes(ask.costs), sizeof(Counts) + uint64_t{begin} * sizeof(uint32_t));
    }

    void traceInPieces(SizedKernel& beginning, SizedKernel& resuming, Buffer& rays, Buffer& hits, const Push& push,
                       Buffer& counts, const Ask& ask, TraceReport& report) {
        makePauses(push.count);
        bind(beginning.kernel, rays, hits, counts, ask);
        uint32_t unfinished = dispatch(beginning, push, counts, report);
        for (uint64_t steps = push.maxSteps; unfinished > 0;) {
            if (steps > mostSteps_) throw corrupt_;
            std::swap(paused_, unfinished_);
            bind(resuming.kernel, rays, hits, counts, ask);
            const uint32_t more = resuming.size.steps(unfinished);
            unfinished = dispatch(resuming, {0, unfinished, more}, counts, report);
            steps += more;
        }
    }

    void bind(Kernel& kernel, Buffer& rays, Buffer& hits, Buffer& counts, const Ask& ask) {
        kernel.bind(0, header_);
        kernel.bind(1, rays);
        kernel.bind(2, hits);
        kernel.bind(3, paused_);
        kernel.bind(4, counts);
        kernel.bind(5, nodes_);
        kernel.bind(6, triangles_);
        kernel.bind(7, unfinished_);
        kernel.bind(8, ask.hints ? *ask.hints : paused_);  // where there are none, the kernel has no use for it
    }

    /// Returns how many walks are not finished. `counted` begins with a Counts.
    uint32_t dispatch(SizedKernel& sized, const Push& push, Buffer& counted, TraceReport& report) {
        commands_.fill(counted, 0, 0, sizeof(Counts));
        commands_.dispatch(sized.kernel, {(push.count + sized.raysAGroup - 1) / sized.raysAGroup}, push);
        const RunReport ran = commands_.run();
        sized.size.learn(double(push.count) * push.maxSteps, ran.seconds);
        Counts counts;
        counted.download(std::as_writable_bytes(std::span(&counts, 1)));
        report.seconds += ran.seconds;
        report.deviceSeconds += ran.deviceSeconds;
        report.counters +=
            {joined(counts.nodeFetches), joined(counts.triangleTests), joined(counts.boxTests), joined(counts.linkReads)};
        report.failedHints += counts.failedHints;
        return counts.unfinished;
    }

    SizedKernel& kernelFor(const Ask& ask, Stage stage) {
        std::optional<SizedKernel>& sized = stagesOf(ask).kernels[static_cast<uint32_t>(stage)];
        if (!sized) {
            const auto spirv = findKernel(name_);
            RAIG_CHECK(spirv.has_value());
            const bool costs = !ask.costs.empty();
            const bool paired = stage == Stage::whole && paired_ && !costs;
            const Constants constants = {
                {0, workgroupSize},
                {1, /* ANY_HIT */ ask.query == Query::any},
                {2, /* SKIP_SEE_THROUGH */ ask.shadows},
                {3, walk_},
                {4, /* COUNTING */ counting_ || costs},
                {5, nodes_.chunkCount()},
                {6, nodes_.chunkShift()},
                {7, triangles_.chunkCount()},
                {8, triangles_.chunkShift()},
                {9, /* PAUSING */ stage != Stage::whole},
                {10, /* RESUMING */ stage == Stage::resuming},
                {11, /* PAIRED */ paired},
                {12, /* HAS_SPHERES */ spheres_},
                {13, costs},
                {14, /* HINTED */ ask.hints != nullptr},
            };
            sized.emplace(Kernel(device_, name_, *spirv, constants), DispatchSize(device_.info(), paired),
                          paired ? 2 * workgroupSize : workgroupSize);
        }
        return *sized;
    }

    Stages& stagesOf(const Ask& ask) {
        const uint32_t kind = ask.hints ? 3 : ask.shadows ? 2 : ask.query == Query::any ? 1 : 0;
        return stages_[(ask.costs.empty() ? 0 : 4) + kind];
    }

    void makeCosts(uint32_t count) {
        const uint64_t bytes = sizeof(Counts) + uint64_t{count} * sizeof(uint32_t);
        if (!costs_ || costs_->bytes() < bytes) costs_.emplace(device_, bytes);
    }

    void makePauses(uint32_t count) {
        const uint64_t bytes = uint64_t{count} * sizeof(Pause);
        if (unfinished_.bytes() >= bytes) return;
        paused_ = Buffer(device_, bytes);
        unfinished_ = Buffer(device_, bytes);
    }

    Device& device_;
    std::string name_;
    uint32_t walk_;
    uint64_t mostSteps_;         // of a walk; one that makes more goes around
    CorruptStructure corrupt_;
    bool counting_;
    bool instanced_;
    bool paired_;  // two rays an invocation: llvmpipe computes one while it waits for the other
    bool spheres_;
    uint32_t wholeSteps_;
    uint32_t firstSteps_;
    Buffer header_;
    BigArray nodes_;
    BigArray triangles_;
    Buffer counts_;
    std::optional<Buffer> costs_;  // a Counts, and one word a ray; where they were asked for
    Buffer paused_;
    Buffer unfinished_;
    Commands commands_;
    std::array<Stages, 8> stages_;  // closest, any, shadows, closest with hints; the same with costs
};

}  // namespace

std::unique_ptr<DeviceTracer> makeDeviceTracer(Device& device, const Structure& structure, bool counting) {
    return std::make_unique<VulkanTracer>(device, structure, counting);
}

}  // namespace raig
