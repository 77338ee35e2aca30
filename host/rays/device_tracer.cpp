#include "base/error.hpp"
#include "device/buffer.hpp"
#include "device/commands.hpp"
#include "device/kernel.hpp"
#include "rays/kernels.hpp"
#include "rays/tracer.hpp"

#include <algorithm>
#include <array>
#include <chrono>

namespace raig {

namespace {

constexpr uint32_t workgroupSize = 256;
constexpr uint32_t mostRaysAtOnce = 1u << 20;  // of trace(): 48 MiB of rays and hits

// Loop iterations of a walk in one dispatch: bounds its time, and stays below the 65,535 after which Mesa 22.3's llvmpipe
// silently stops looping.
constexpr uint32_t maxSteps = 16384;

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
    std::array<uint32_t, 3> padding;
};

/// Where shaders/trace.comp.in counts.
struct Counts {
    uint32_t unfinished;
    std::array<uint32_t, 2> nodeFetches;  // low and high halves
    std::array<uint32_t, 2> triangleTests;
    std::array<uint32_t, 3> padding;
};

uint64_t joined(const std::array<uint32_t, 2>& halves) {
    return halves[0] | uint64_t{halves[1]} << 32;
}

/// How many rays to dispatch at once, so that a dispatch takes about as long as it should.
class DispatchSize {
public:
    explicit DispatchSize(const DeviceInfo& info) : target_(info.type == DeviceType::software ? 0.5 : 0.02) {}

    uint32_t rays() const { return rays_; }
    void learn(uint32_t rays, double seconds) {
        if (rays < rays_ / 2 || seconds <= 0.0) return;  // a remainder tells little
        const double wanted = std::clamp(rays * target_ / seconds, rays_ * 0.25, rays_ * 4.0);
        rays_ = static_cast<uint32_t>(std::clamp(wanted, 4096.0, 4.0 * mostRaysAtOnce));
    }

private:
    double target_;  // seconds
    uint32_t rays_ = 1u << 16;
};

class VulkanTracer : public DeviceTracer {
public:
    VulkanTracer(Device& device, const Structure& structure, bool counting)
        : device_(device),
          name_("trace_" + structure.name + (device.loadsTexel() ? "_texel" : "_storage")),
          walk_(structure.header.walk),
          counting_(counting),
          paired_(device.loadsTexel()),
          header_(device, sizeof(StructureHeader)),
          nodes_(device, std::as_bytes(std::span(structure.nodes))),
          triangles_(device, std::as_bytes(std::span(structure.triangles))),
          counts_(device, sizeof(Counts)),
          paused_(device, sizeof(Pause)),
          unfinished_(device, sizeof(Pause)),
          commands_(device),
          size_(device.info()) {
        header_.uploadValues(std::span(&structure.header, 1));
    }

    TraceReport trace(std::span<const Ray> rays, std::span<Hit> hits, Query query) override {
        return traceAll(rays, hits, query, false);
    }
    TraceReport traceShadows(std::span<const Ray> rays, std::span<Hit> hits) override {
        return traceAll(rays, hits, Query::any, true);
    }

    double traceBuffers(Buffer& rays, Buffer& hits, uint32_t count, Query query, bool shadows) override {
        TraceReport report;
        run(rays, hits, count, query, shadows, report);
        return report.seconds;
    }

private:
    TraceReport traceAll(std::span<const Ray> rays, std::span<Hit> hits, Query query, bool shadows) {
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
            run(rayBuffer, hitBuffer, count, query, shadows, report);
            hitBuffer.download(std::as_writable_bytes(hits.subspan(first, count)));
        }
        const double all = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        report.uploadSeconds = all - report.seconds;
        return report;
    }

    void run(Buffer& rays, Buffer& hits, uint32_t count, Query query, bool shadows, TraceReport& report) {
        for (uint32_t first = 0; first < count;) {
            const uint32_t some = std::min(size_.rays(), count - first);
            if (!pausing_) {
                Kernel& whole = kernelFor(query, shadows, Stage::whole);
                bind(whole, rays, hits);
                // Saving state costs every ray; so it is done only once a structure has shown that it needs it.
                pausing_ = dispatch(whole, {first, some, maxSteps}, paired_ ? 2 * workgroupSize : workgroupSize, report) > 0;
            }
            if (pausing_) traceInPieces(rays, hits, {first, some, maxSteps}, query, shadows, report);
            first += some;
        }
    }

    void traceInPieces(Buffer& rays, Buffer& hits, const Push& push, Query query, bool shadows, TraceReport& report) {
        makePauses(push.count);
        Kernel& beginning = kernelFor(query, shadows, Stage::beginning);
        Kernel& resuming = kernelFor(query, shadows, Stage::resuming);
        bind(beginning, rays, hits);
        uint32_t unfinished = dispatch(beginning, push, workgroupSize, report);
        while (unfinished > 0) {
            std::swap(paused_, unfinished_);
            bind(resuming, rays, hits);
            unfinished = dispatch(resuming, {0, unfinished, maxSteps}, workgroupSize, report);
        }
    }

    void bind(Kernel& kernel, Buffer& rays, Buffer& hits) {
        kernel.bind(0, header_);
        kernel.bind(1, rays);
        kernel.bind(2, hits);
        kernel.bind(3, paused_);
        kernel.bind(4, counts_);
        kernel.bind(5, nodes_);
        kernel.bind(6, triangles_);
        kernel.bind(7, unfinished_);
    }

    /// Returns how many walks are not finished.
    uint32_t dispatch(Kernel& kernel, const Push& push, uint32_t raysAGroup, TraceReport& report) {
        commands_.fill(counts_, 0);
        commands_.dispatch(kernel, {(push.count + raysAGroup - 1) / raysAGroup}, push);
        const RunReport ran = commands_.run();
        size_.learn(push.count, ran.seconds);
        Counts counts;
        counts_.download(std::as_writable_bytes(std::span(&counts, 1)));
        report.seconds += ran.seconds;
        report.deviceSeconds += ran.deviceSeconds;
        report.counters.nodeFetches += joined(counts.nodeFetches);
        report.counters.triangleTests += joined(counts.triangleTests);
        return counts.unfinished;
    }

    /// Walks in one go, or in pieces: the first, and those after it.
    enum class Stage : uint32_t { whole, beginning, resuming };

    Kernel& kernelFor(Query query, bool shadows, Stage stage) {
        std::unique_ptr<Kernel>& kernel = kernels_[shadows ? 2 : query == Query::any ? 1 : 0][static_cast<uint32_t>(stage)];
        if (!kernel) {
            const auto spirv = findKernel(name_);
            RAIG_CHECK(spirv.has_value());
            const Constants constants = {
                {0, workgroupSize},
                {1, /* ANY_HIT */ query == Query::any || shadows},
                {2, /* SKIP_SEE_THROUGH */ shadows},
                {3, walk_},
                {4, counting_},
                {5, nodes_.chunkCount()},
                {6, nodes_.chunkShift()},
                {7, triangles_.chunkCount()},
                {8, triangles_.chunkShift()},
                {9, /* PAUSING */ stage != Stage::whole},
                {10, /* RESUMING */ stage == Stage::resuming},
                {11, /* PAIRED */ stage == Stage::whole && paired_},
            };
            kernel = std::make_unique<Kernel>(device_, name_, *spirv, constants);
        }
        return *kernel;
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
    bool counting_;
    bool paired_;  // two rays an invocation: llvmpipe computes one while it waits for the other
    Buffer header_;
    BigArray nodes_;
    BigArray triangles_;
    Buffer counts_;
    Buffer paused_;
    Buffer unfinished_;
    Commands commands_;
    DispatchSize size_;
    bool pausing_ = false;                                           // a walk was longer than a dispatch
    std::array<std::array<std::unique_ptr<Kernel>, 3>, 3> kernels_;  // closest, any, shadows; each in all stages
};

}  // namespace

std::unique_ptr<DeviceTracer> makeDeviceTracer(Device& device, const Structure& structure, bool counting) {
    return std::make_unique<VulkanTracer>(device, structure, counting);
}

}  // namespace raig
