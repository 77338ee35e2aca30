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
    uint32_t begin;
};

/// Where shaders/trace.comp.in counts.
struct Counts {
    uint32_t unfinished;
    std::array<uint32_t, 2> nodeFetches;  // low and high halves
    std::array<uint32_t, 2> triangleTests;
    std::array<uint32_t, 3> padding;
};

uint64_t joined(const std::array<uint32_t, 2>& halves) { return halves[0] | uint64_t{halves[1]} << 32; }

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
          header_(device, sizeof(StructureHeader)),
          nodes_(device, std::as_bytes(std::span(structure.nodes))),
          triangles_(device, std::as_bytes(std::span(structure.triangles))),
          counts_(device, sizeof(Counts)),
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
        Kernel& kernel = kernelFor(query, shadows);
        makeStates(count);
        kernel.bind(0, header_);
        kernel.bind(1, rays);
        kernel.bind(2, hits);
        kernel.bind(3, *states_);
        kernel.bind(4, counts_);
        if (kernel.interface().bindings.at(5).used) kernel.bind(5, nodes_);
        kernel.bind(6, triangles_);
        for (uint32_t first = 0; first < count;) {
            const uint32_t some = std::min(size_.rays(), count - first);
            Counts counts = dispatch(kernel, {first, some, maxSteps, /* begin= */ 1}, report);
            while (counts.unfinished > 0) counts = dispatch(kernel, {first, some, maxSteps, /* begin= */ 0}, report);
            first += some;
        }
    }

    Counts dispatch(Kernel& kernel, const Push& push, TraceReport& report) {
        commands_.fill(counts_, 0);
        commands_.dispatch(kernel, {(push.count + workgroupSize - 1) / workgroupSize}, push);
        const RunReport ran = commands_.run();
        if (push.begin != 0) size_.learn(push.count, ran.seconds);
        Counts counts;
        counts_.download(std::as_writable_bytes(std::span(&counts, 1)));
        report.seconds += ran.seconds;
        report.deviceSeconds += ran.deviceSeconds;
        report.counters.nodeFetches += joined(counts.nodeFetches);
        report.counters.triangleTests += joined(counts.triangleTests);
        return counts;
    }

    Kernel& kernelFor(Query query, bool shadows) {
        std::unique_ptr<Kernel>& kernel = kernels_[shadows ? 2 : query == Query::any ? 1 : 0];
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
            };
            kernel = std::make_unique<Kernel>(device_, name_, *spirv, constants);
        }
        return *kernel;
    }

    void makeStates(uint32_t count) {
        const uint64_t bytes = uint64_t{count} * sizeof(uvec2);
        if (!states_ || states_->bytes() < bytes) states_ = std::make_unique<Buffer>(device_, bytes);
    }

    Device& device_;
    std::string name_;
    uint32_t walk_;
    bool counting_;
    Buffer header_;
    BigArray nodes_;
    BigArray triangles_;
    Buffer counts_;
    Commands commands_;
    DispatchSize size_;
    std::unique_ptr<Buffer> states_;
    std::array<std::unique_ptr<Kernel>, 3> kernels_;  // closest, any, shadows
};

}  // namespace

std::unique_ptr<DeviceTracer> makeDeviceTracer(Device& device, const Structure& structure, bool counting) {
    return std::make_unique<VulkanTracer>(device, structure, counting);
}

}  // namespace raig
