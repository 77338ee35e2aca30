#include "app/compare_text.hpp"

#include <fmt/format.h>

namespace raig {

namespace {

void printPixelHeader() {
    fmt::print("{:14} {:>8}  {:>9}  {:>9}  {:>9}  {:>6}  {:>7}  {:>7}  {:>7}  {:>7}  {:>5}\n", "pixels", "compared", "max",
               "rmse", "relmse", "psnr", "ssim", "flip", "flip99", "flipmax", "nan");
}

void printPixelRow(const char* name, const PictureDifference& d) {
    fmt::print("{:14} {:>8}  {:.3e}  {:.3e}  {:.3e}  {:6.2f}  {:.5f}  {:.5f}  {:.5f}  {:.5f}  {:>5}\n", name, d.pixels,
               d.max, d.rmse, d.relmse, d.psnr, d.ssim, d.flipMean, d.flipP99, d.flipMax, d.nan);
}

void printRays(const SceneComparison& scene) {
    fmt::print("{:8} {:>8} {:>8}  {:>8} {:>8} {:>6} {:>7} {:>6}  {:>7}  {:>9}  {}\n", "rays", "traced", "hit", "same", "tie",
               "missed", "phantom", "wrong", "offset", "different", "t in ULP: median, 99 %, max");
    for (const RayFamily& family : scene.families) {
        const HitComparison& c = family.hits;
        fmt::print("{:8} {:>8} {:>8}  {:>8} {:>8} {:>6} {:>7} {:>6}  {:>7.3f}  {:>9}  {}, {}, {}\n", family.name, c.rays(),
                   c.met, c.counts[0], c.counts[1], c.counts[2], c.counts[3], c.counts[4], c.offset.max,
                   family.bits ? fmt::format("{}", family.bits->different) : "-", c.tUlp.median, c.tUlp.p99, c.tUlp.max);
    }
}

/// "0: 65000, 1: 432, 3-4: 2": buckets that hold something.
std::string textOf(const UlpHistogram& histogram) {
    std::string text;
    for (size_t i = 0; i < UlpHistogram::buckets; ++i) {
        if (histogram.counts[i] == 0) continue;
        const uint64_t low = UlpHistogram::lowest(i), high = UlpHistogram::highest(i);
        text += text.empty() ? "" : ", ";
        text += low == high ? fmt::format("{}: {}", low, histogram.counts[i])
                            : fmt::format("{}-{}: {}", low, high, histogram.counts[i]);
    }
    return text.empty() ? "none" : text;
}

std::string textOf(const Ray& ray) {
    const vec3 &o = ray.origin, &d = ray.direction;
    return fmt::format("[{:.9g}, {:.9g}, {:.9g}, {:.9g}, {:.9g}, {:.9g}, {:.9g}, {:.9g}]", o.x, o.y, o.z, ray.tMin, d.x, d.y,
                       d.z, ray.tMax);
}

std::string textOf(const Hit& hit) {
    if (hit.primitive == NO_HIT) return "nothing";
    return fmt::format("primitive {} at t {:.9g}, u {:.9g}, v {:.9g}", hit.primitive, hit.t, hit.u, hit.v);
}

std::string textOf(const reference::Hit& hit) {
    if (hit.primitive == reference::noTriangle) return "nothing";
    return fmt::format("primitive {} at t {:.17g}", hit.primitive, hit.t);
}

template <class Difference>
std::string placeOf(const Placed<Difference>& first) {
    return fmt::format("{} ray {} (level {})", first.family, first.difference.ray, first.level);
}

}  // namespace

void printPictures(const PictureDifference& difference) {
    printPixelHeader();
    printPixelRow("all", difference);
}

std::string describe(const Placed<HitComparison::Difference>& first, const std::string& walker) {
    const HitComparison::Difference& d = first.difference;
    return fmt::format("first difference: {}, {}: {} has {}; the reference has {}; the ray is {}", placeOf(first),
                       hitClassNames[static_cast<uint32_t>(d.kind)], walker, textOf(d.device), textOf(d.oracle),
                       textOf(d.floats));
}

std::string describe(const Placed<BitComparison::Difference>& first, const std::string& walker) {
    const BitComparison::Difference& d = first.difference;
    return fmt::format("first bits that differ: {}: {} has {}; the CPU has {}; the ray is {}", placeOf(first), walker,
                       textOf(d.device), textOf(d.cpu), textOf(d.floats));
}

void printScene(const SceneComparison& scene, const std::string& walker) {
    printRays(scene);
    for (const RayFamily& family : scene.families) fmt::print("t in ULP, {}: {}\n", family.name, textOf(family.hits.tUlps));
    if (const auto first = firstDifference(scene.families)) fmt::print("{}\n", describe(*first, walker));
    if (const auto first = firstBitDifference(scene.families)) fmt::print("{}\n", describe(*first, walker));
    printPixelHeader();
    printPixelRow("outside ties", scene.pixels.outsideTies);
    printPixelRow("with ties", scene.pixels.everywhere);
    fmt::print("{} pixels are ties: rounding their rays as floats are moves them by more than {}\n", scene.pixels.ties,
               tieSensitivity);
    fmt::print("discarded weight: {:.3e} on average, {:.3e} at most\n", scene.discardedMean, scene.discardedMax);
    fmt::print("device {:.2f} s, reference {:.2f} s\n", scene.deviceSeconds, scene.referenceSeconds);
}

}  // namespace raig
