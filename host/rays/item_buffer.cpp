#include "rays/item_buffer.hpp"

#include "base/error.hpp"
#include "rays/frame_kernels.hpp"
#include "rays/item_draws.hpp"
#include "rays/kernels.hpp"

#include <algorithm>
#include <optional>

namespace raig {

using namespace shared;

namespace {

constexpr uint32_t mostItems = 1u << 22;  // at once: 32 MiB, and 48 of what they are drawn into
constexpr uint32_t mostWindows = 8;       // that a picture is drawn in, unless it has more pixels than go into these
constexpr uint32_t mostScale = 5;
constexpr uint32_t probesAcross = 16;

std::span<const uint32_t> shaderOf(const Device& device, const char* name) {
    const auto spirv = findKernel(std::string(name) + (device.loadsTexel() ? "_texel" : "_storage"));
    RAIG_CHECK(spirv.has_value());
    return *spirv;
}

}  // namespace

struct ItemBuffer::State {
    State(Device& opened, const Structure& structure, DeviceTracer& tracing)
        : device(opened), tracer(tracing), groups(structure), bounds{structure.header.lo, structure.header.hi},
          unit(structure.header.unit), instanced(structure.isInstanced()), spheres(structure.hasSpheres()),
          list(opened, sizeof(uint32_t) * std::max<uint64_t>(1, structure.instances)) {}

    /// A quarter of how far, along the camera's axis, the nearest of some rays across the part goes.
    double probe(const FrameParams& frame);
    void needRaster(uint32_t width, uint32_t height);
    void draw(const FrameParams& frame, const ItemRect& rect);
    /// Draws all, in pieces that take about as long as they may.
    void drawPieces(const ItemRect& rect, const ItemView& view, std::span<const Draw> draws);

    Device& device;
    DeviceTracer& tracer;
    DrawnGroups groups;
    Box bounds;
    float unit;
    bool instanced;
    bool spheres;
    Buffer list;
    std::unique_ptr<Raster> raster;
    uint32_t rasterWidth = 0, rasterHeight = 0;
    std::optional<Buffer> items;
    ItemWindow window{0, 0, 1, 0};
    double nearest = 0.0;
    double seconds = 0.0;
    uint64_t triangles = 0;
    double atOnce = 0x1p16;  ///< triangles a submission; learnt
};

double ItemBuffer::State::probe(const FrameParams& frame) {
    FrameKernels kernels;
    kernels.frame = frame;
    std::vector<Ray> rays;
    for (uint64_t i = 0; i < probesAcross * probesAcross; ++i) {
        const uint64_t x = (2 * (i % probesAcross) + 1) * frame.partWidth / (2 * probesAcross);
        const uint64_t y = (2 * (i / probesAcross) + 1) * frame.partHeight / (2 * probesAcross);
        rays.push_back(kernels.cameraRay(static_cast<uint32_t>((frame.top + y) * frame.width + frame.left + x), 0));
    }
    // With hints that say nothing, as the kernel that takes hints is at hand.
    Buffer raysThere(device, rays.size() * sizeof(Ray)), hitsThere(device, rays.size() * sizeof(Hit));
    Buffer hints(device, rays.size() * sizeof(uvec2) * HINTS_A_RAY);
    raysThere.uploadValues(std::span<const Ray>(rays));
    hints.fill(NO_HINT);
    const auto count = static_cast<uint32_t>(rays.size());
    seconds += tracer.traceBuffers(raysThere, hitsThere, count, Query::closest, false, &hints).seconds;
    const std::vector<Hit> hits = hitsThere.downloadValues<Hit>();
    double least = std::numeric_limits<double>::infinity();
    for (size_t i = 0; i < hits.size(); ++i)
        if (hits[i].primitive != NO_HIT)
            least = std::min(least, double{hits[i].t} * glm::dot(dvec3(rays[i].direction), dvec3(frame.forward)));
    return 0.25 * least * unit;
}

void ItemBuffer::State::needRaster(uint32_t width, uint32_t height) {
    if (raster && rasterWidth >= width && rasterHeight >= height) return;
    rasterWidth = std::max(rasterWidth, width);
    rasterHeight = std::max(rasterHeight, height);
    const BigArray &nodes = tracer.nodes(), &references = tracer.references();
    const Constants constants = {{/* INSTANCED */ 0, instanced},
                                 {/* HAS_SPHERES */ 1, spheres},
                                 {/* NODE_CHUNKS */ 2, nodes.chunkCount()},
                                 {/* NODE_SHIFT */ 3, nodes.chunkShift()},
                                 {/* TRIANGLE_CHUNKS */ 4, references.chunkCount()},
                                 {/* TRIANGLE_SHIFT */ 5, references.chunkShift()}};
    raster.reset();
    raster = std::make_unique<Raster>(device, "items", shaderOf(device, "item_corner"), shaderOf(device, "item_word"),
                                      constants, rasterWidth, rasterHeight);
    raster->bind(0, nodes);
    raster->bind(1, references);
    raster->bind(2, list);
}

void ItemBuffer::State::drawPieces(const ItemRect& rect, const ItemView& view, std::span<const Draw> draws) {
    const double target = device.info().type == DeviceType::software ? 0.25 : 0.02;
    const std::span<const std::byte> push = std::as_bytes(std::span(&view, 1));
    bool clears = true;
    for (size_t next = 0; next < draws.size() || clears;) {
        double together = 0.0;
        size_t end = next;
        for (; end < draws.size() && together < atOnce; ++end)
            together += double(draws[end].triangles) * draws[end].instances;
        const double took = raster->draw(rect.width, rect.height, clears, push, draws.subspan(next, end - next));
        seconds += took;
        triangles += static_cast<uint64_t>(together);
        if (together >= 0.5 * atOnce || took > target)
            atOnce = std::clamp(together * std::clamp(target / std::max(took, 1e-6), 0.125, 4.0), 0x1p10, 0x1p26);
        next = end;
        clears = false;
    }
}

void ItemBuffer::State::draw(const FrameParams& frame, const ItemRect& rect) {
    const ItemProjection projection(frame, bounds, unit, rect, window.scale, nearest);
    const uint64_t enough = std::max<uint64_t>(1u << 22, 16 * uint64_t{rect.width} * rect.height);
    const ItemDraws found = groups.seenBy(projection, enough);
    if (!found.instances.empty()) list.uploadValues(std::span<const uint32_t>(found.instances));
    drawPieces(rect, projection.view(groups.instancesAt()), piecesOf(found.draws, 1u << 16));
    const uint32_t row = frame.partWidth * window.scale;
    const uint64_t at = uint64_t{rect.y - window.firstRow * window.scale} * row + rect.x;
    seconds += raster->copy(rect.width, rect.height, *items, sizeof(ItemWindow) + 8 * at, row);
}

ItemBuffer::ItemBuffer(Device& device, const Structure& structure, DeviceTracer& tracer)
    : state_(std::make_unique<State>(device, structure, tracer)) {}

ItemBuffer::~ItemBuffer() = default;

void ItemBuffer::begin(const FrameParams& frame) {
    const uint64_t pixels = uint64_t{frame.partWidth} * frame.partHeight;
    const uint64_t wanted = frame.samples > 1 ? 8 * uint64_t{frame.samples} : 1;
    const auto fits = [&](uint64_t items) { return items <= wanted && pixels * items <= uint64_t{mostWindows} * mostItems; };
    uint32_t scale = 1;
    while (scale < mostScale && fits((scale + 1) * (scale + 1))) ++scale;
    state_->window = {0, 0, scale, 0};
    state_->seconds = 0.0;
    state_->triangles = 0;
    state_->nearest = state_->probe(frame);
}

void ItemBuffer::show(const FrameParams& frame, uint32_t first, uint32_t end) {
    State& state = *state_;
    ItemWindow& window = state.window;
    RAIG_CHECK(first < end && end <= frame.partHeight);
    if (window.firstRow <= first && end <= window.firstRow + window.rows) return;
    const uint32_t scale = window.scale, across = frame.partWidth * scale;
    const uint32_t rows = std::max(end - first, mostItems / across / scale);
    window.firstRow = first;
    window.rows = std::min(rows, frame.partHeight - first);
    const uint64_t bytes = sizeof(ItemWindow) + 8 * uint64_t{across} * window.rows * scale;
    if (!state.items || state.items->bytes() < bytes) {
        state.items.reset();
        state.items.emplace(state.device, bytes);
    }
    const uint32_t side = Raster::largestSide(state.device), height = window.rows * scale;
    state.needRaster(std::min(across, side), std::min(height, side));
    for (uint32_t y = 0; y < height; y += side)
        for (uint32_t x = 0; x < across; x += side)
            state.draw(frame, {x, window.firstRow * scale + y, std::min(side, across - x), std::min(side, height - y)});
    state.items->uploadValues(std::span<const ItemWindow>(&window, 1));
}

const Buffer& ItemBuffer::items() const {
    RAIG_CHECK(state_->items.has_value());
    return *state_->items;
}

uint32_t ItemBuffer::scale() const { return state_->window.scale; }
double ItemBuffer::seconds() const { return state_->seconds; }
uint64_t ItemBuffer::triangles() const { return state_->triangles; }

}  // namespace raig
