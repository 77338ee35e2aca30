/// A scene on a device, held against the reference and against the same walk on the CPU: rays in families, and pixels.
#pragma once

#include "measure/compare.hpp"
#include "rays/tracer.hpp"

namespace raig {

/// A device's hits beside those that the same walk finds on the CPU.
struct BitComparison {
    struct Difference {
        uint64_t ray;  ///< its number
        Ray floats;
        Hit device;
        Hit cpu;
    };
    uint64_t rays = 0;
    uint64_t different = 0;  ///< another id, or other bits of t, u or v
    uint64_t otherIds = 0;   ///< of those: another id, or a hit on one side only
    uint64_t tUlpMax = 0;    ///< of the rest: how far t is off
    std::optional<Difference> first;
};

/// Compares hits bit by bit. `denormalsAreZero`: on a device that flushes denormals, one is as good as
/// another or a zero.
/// Requires spans of equal length.
BitComparison compareBits(std::span<const Ray> rays, std::span<const Hit> device, std::span<const Hit> cpu,
                          bool denormalsAreZero);

/// Rays of one kind.
struct RayFamily {
    std::string_view name;
    uint32_t level;  ///< how often its rays have been reflected: 0 from the eye
    HitComparison hits;
    std::optional<BitComparison> bits;  ///< none where the device is the CPU
};

/// Traces and compares, by rising level: `camera`, the rays given; `aimed`, as many from `eye` (aimedRays); and `bounce`,
/// which goes on from where the camera's hit. `cpu`: the device's structure on the CPU, null where the device is that.
std::vector<RayFamily> compareFamilies(const reference::Tree& tree, std::span<const Ray> camera, const vec3& eye,
                                       Tracer& device, Tracer* cpu, bool denormalsAreZero);

/// A ray that stands out, and where it comes from.
template <class Difference>
struct Placed {
    std::string_view family;
    uint32_t level;
    Difference difference;
};

/// The first ray of the lowest level that is missed, phantom or wrong; if none is, the first tie.
std::optional<Placed<HitComparison::Difference>> firstDifference(std::span<const RayFamily> families);

/// The first ray of the lowest level where device and CPU differ.
std::optional<Placed<BitComparison::Difference>> firstBitDifference(std::span<const RayFamily> families);

/// All that is said of a scene.
struct SceneComparison {
    std::vector<RayFamily> families;
    HitComparison all;                  ///< see sumOf
    std::optional<BitComparison> bits;  ///< of all families, but for `first`
    bool isIeee = false;                ///< the device's arithmetic is measured to be: then no bit may differ
    PictureComparison pixels;
    double discardedMean = 0.0;
    double discardedMax = 0.0;
    double deviceSeconds = 0.0;
    double referenceSeconds = 0.0;
};

/// Adds up the counts. Distances are those of the family where they are largest; single rays are left out.
HitComparison sumOf(std::span<const RayFamily> families);
std::optional<BitComparison> sumOfBits(std::span<const RayFamily> families);

}  // namespace raig
