/// What a tracer and a renderer answered, held against the reference: every ray and every pixel put into a class.
#pragma once

#include "image/metrics.hpp"
#include "rays/types.hpp"
#include "reference/picture.hpp"

#include <array>
#include <optional>
#include <string_view>

namespace raig {

/// How an answer stands to the reference's.
enum class HitClass : uint32_t {
    same,     ///< the same triangle, or nothing on both sides
    tie,      ///< another answer, that a ray moved by the accuracy of float positions gets from the reference too
    missed,   ///< nothing, where there is a triangle
    phantom,  ///< a triangle, where there is nothing
    wrong,    ///< another triangle, or no answer at all: a triangle that does not exist, a t that is NaN or outside the ray
};
inline constexpr std::array<std::string_view, 5> hitClassNames{"same", "tie", "missed", "phantom", "wrong"};

/// A ray of floats as the reference takes it: the same numbers.
reference::Ray widen(const Ray& ray);

/// How many floats lie between a and b, plus one: 0 if equal (-0 and +0 are), 1 for neighbours. Requires finite numbers.
uint64_t ulpsApart(float a, float b);

/// The accuracy that float positions can have around a ray and a triangle: 8 units in the last place of the largest
/// coordinate among the ray's origin and the corners seen from it.
double positionTolerance(const Ray& ray, const vec3& a, const vec3& b, const vec3& c);

/// The same for primitive `id`; of a sphere, its farthest coordinate seen from the origin counts.
double positionTolerance(const Geometry& geometry, const Ray& ray, uint32_t id);

/// Classes a device's answer. With d = positionTolerance of the triangle in question, it is a tie where
///   - the device names a triangle that the ray passes within its d of, no farther along the ray than the oracle's hit may
///     be with its triangle moved by its d along its normal, or where the oracle's triangle is within its d too (a shared
///     edge, duplicates); or
///   - one of 64 rays moved sideways by up to the d of the oracle's primitive gets the device's answer from the reference,
///     be it nothing or a triangle farther away (a silhouette), or another triangle there that makes that a tie by the first
///     rule. A hole in a closed surface is no tie: no ray nearby sees through it; or
///   - the ray passes within d of an edge of the oracle's triangle that no other triangle has, corner for corner, and the
///     answer would be right, or a tie by the first rule, without that triangle, and without another one like it behind:
///     surfaces that only lie side by side have cracks, wherever rounding puts them.
/// `same` says nothing of t: compareHits measures that.
///
/// Requires  oracle == tree.closest(widen(ray)). `device` may be anything.
/// Cost      O(1) for same; else up to 64 closest hits, and O(triangles) where all else fails.
HitClass classifyHit(const reference::Tree& tree, const Ray& ray, const reference::Hit& oracle, const Hit& device);

/// Median, 99th percentile (nearest rank) and maximum; all 0 of no values.
struct Spread {
    double median = 0.0;
    double p99 = 0.0;
    double max = 0.0;
};
Spread spreadOf(std::vector<double> values);

/// How many values are how many ULP off: 0, 1, 2, 3 to 4, 5 to 8, and so on, each twice as wide as the one before.
struct UlpHistogram {
    static constexpr size_t buckets = 34;  ///< the last one ends at 2^32: no two floats are farther apart

    static size_t bucketOf(uint64_t ulps);
    static uint64_t lowest(size_t bucket);
    static uint64_t highest(size_t bucket);
    void operator+=(const UlpHistogram& other);

    std::array<uint64_t, buckets> counts{};
};

struct HitComparison {
    std::array<uint64_t, 5> counts{};  ///< by HitClass
    uint64_t met = 0;                  ///< rays that hit something by the reference: of no such ray, the rest says little

    /// Where the triangle is the same: how far t is from the oracle's, rounded to float, in ULP. This grows without bound at
    /// grazing incidence and for t near 0, where t is ill-conditioned; `offset` does not.
    Spread tUlp;
    UlpHistogram tUlps;

    /// Where the triangle is the same: how far origin + t * direction is from it, in units of positionTolerance. Above 1, t
    /// is wrong, though the triangle is right.
    Spread offset;

    /// A ray whose answer is not the reference's.
    struct Difference {
        uint64_t ray;  ///< its number
        Ray floats;
        HitClass kind;
        reference::Hit oracle;
        Hit device;
    };
    std::vector<Difference> faults;      ///< neither same nor tie, in order; at most 16 are kept
    std::optional<Difference> firstTie;

    uint64_t count(HitClass kind) const { return counts[static_cast<uint32_t>(kind)]; }
    uint64_t rays() const;
    /// Missed, phantom and wrong together: what a correct tracer has none of.
    uint64_t faultCount() const;
};

/// Finds the closest hits of `rays` by the reference and classes hits[i], a device's answer to rays[i].
/// Requires spans of equal length. Cost: one closest hit a ray, in double precision, over all cores.
HitComparison compareHits(const reference::Tree& tree, std::span<const Ray> rays, std::span<const Hit> hits);

struct PictureComparison {
    PictureDifference outsideTies;  ///< over the pixels that rounding cannot change
    PictureDifference everywhere;
    uint64_t ties = 0;  ///< pixels left out of outsideTies
    /// Every pixel of the reference has the same colour: a picture that agrees with it proves nothing.
    bool blank = true;
};

/// A pixel whose value in double precision moves by more than this, in any channel, when its rays are rounded as floats are,
/// says nothing about a float renderer (see reference/rounding.hpp).
inline constexpr double tieSensitivity = 1e-3;

/// Compares a picture with the reference's of the same size (else throws inputError).
PictureComparison compareToReference(const Image& picture, const reference::Picture& expected,
                                     double sensitivity = tieSensitivity,
                                     double pixelsPerDegree = defaultPixelsPerDegree);

/// The reference's radiance, rounded to floats.
Image roundedImage(const reference::Picture& picture);

}  // namespace raig
