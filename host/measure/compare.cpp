#include "measure/compare.hpp"

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "reference/sphere.hpp"

#include <algorithm>
#include <bit>

namespace raig {

namespace {

using reference::noTriangle;

struct Corners {
    vec3 a, b, c;
};

Corners cornersOf(const Geometry& geometry, uint32_t triangle) {
    const uvec3 t = geometry.triangles[triangle];
    return {geometry.positions[t.x], geometry.positions[t.y], geometry.positions[t.z]};
}

double largest(const dvec3& v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

bool canBeHit(const Geometry& geometry, uint32_t id) {
    if (geometry.isSphere(id)) return isUsableSphere(geometry.sphere(id).centre, geometry.sphere(id).radius);
    const Corners k = cornersOf(geometry, id);
    return isUsable(k.a, k.b, k.c);
}

/// False for an answer that no ray can have.
bool isAnswer(const Geometry& geometry, const Ray& ray, const Hit& hit) {
    if (hit.primitive == NO_HIT) return true;
    if (hit.primitive >= geometry.triangles.size() || !(hit.t >= ray.tMin && hit.t <= ray.tMax)) return false;
    return canBeHit(geometry, hit.primitive);
}

reference::Approach approachTo(const Geometry& geometry, const reference::Ray& ray, uint32_t id) {
    if (geometry.isSphere(id)) return reference::approachSphere(ray, geometry.sphere(id).centre, geometry.sphere(id).radius);
    const Corners k = cornersOf(geometry, id);
    return reference::approach(ray, k.a, k.b, k.c);
}

double distanceTo(const Geometry& geometry, const dvec3& point, uint32_t id) {
    if (geometry.isSphere(id))
        return reference::distanceToSphere(point, geometry.sphere(id).centre, geometry.sphere(id).radius);
    const Corners k = cornersOf(geometry, id);
    return reference::distanceToTriangle(point, k.a, k.b, k.c);
}

/// How far the tolerance of a triangle moves a hit of it along the ray, edge-on farther than face-on; of a sphere, the
/// tolerance.
double reachOf(const Geometry& geometry, const Ray& ray, uint32_t id) {
    const double tolerance = positionTolerance(geometry, ray, id);
    if (geometry.isSphere(id)) return tolerance;
    const Corners k = cornersOf(geometry, id);
    const dvec3 normal = glm::cross(dvec3(k.b) - dvec3(k.a), dvec3(k.c) - dvec3(k.a)), d(ray.direction);
    const double slope = std::abs(glm::dot(normal, d)) / (glm::length(normal) * glm::length(d));
    return slope > 0.0 ? tolerance / slope : tolerance;
}

/// True if the ray passes within the tolerance of the device's triangle, not behind what the oracle sees: where that may
/// lie, its own tolerance considered.
bool passesBy(const Geometry& geometry, const Ray& floats, const reference::Hit& oracle, uint32_t triangle) {
    const reference::Ray ray = widen(floats);
    const double tolerance = positionTolerance(geometry, floats, triangle);
    const reference::Approach nearest = approachTo(geometry, ray, triangle);
    if (nearest.distance > tolerance) return false;
    if (oracle.primitive == noTriangle) return true;
    const double reach = std::max(tolerance, reachOf(geometry, floats, oracle.primitive));
    if ((nearest.t - oracle.t) * glm::length(ray.direction) <= reach) return true;
    const auto at = [&](double t) { return ray.origin + t * ray.direction; };
    return distanceTo(geometry, at(oracle.t), triangle) <= tolerance ||
           distanceTo(geometry, at(nearest.t), oracle.primitive) <= positionTolerance(geometry, floats, oracle.primitive);
}

/// True if the point that the device names lies on the triangle, within the tolerance.
bool isOn(const Geometry& geometry, const Ray& ray, const Hit& device, uint32_t triangle) {
    const dvec3 point = dvec3(ray.origin) + double{device.t} * dvec3(ray.direction);
    return distanceTo(geometry, point, triangle) <= positionTolerance(geometry, ray, triangle);
}

/// True if it lies on the device's triangle and on the oracle's: at a shared vertex a triangle seen edge-on is met exactly
/// only farther on.
bool meetsBoth(const Geometry& geometry, const Ray& ray, const reference::Hit& oracle, const Hit& device) {
    return isOn(geometry, ray, device, device.primitive) && isOn(geometry, ray, device, oracle.primitive);
}

/// True if another triangle has the edge from p to q, corner for corner. O(triangles).
bool isShared(const Geometry& geometry, uint32_t triangle, const vec3& p, const vec3& q) {
    for (uint32_t id = 0; id < geometry.triangleCount(); ++id) {
        if (id == triangle || geometry.isSphere(id)) continue;
        const Geometry::Corners k = geometry.corners(geometry.place(id));
        const auto has = [&](const vec3& corner) { return corner == k.a || corner == k.b || corner == k.c; };
        if (has(p) && has(q)) return true;
    }
    return false;
}

/// True if the ray passes within the tolerance of an edge of the triangle that no other has.
bool passesOpenEdge(const Geometry& geometry, const Ray& ray, uint32_t triangle) {
    if (geometry.isSphere(triangle)) return false;
    const Geometry::Corners k = geometry.corners(geometry.place(triangle));
    const double tolerance = positionTolerance(geometry, ray, triangle);
    for (const auto& [p, q] : {std::pair(k.a, k.b), std::pair(k.b, k.c), std::pair(k.c, k.a)})
        if (reference::approach(widen(ray), p, q, q).distance <= tolerance && !isShared(geometry, triangle, p, q))
            return true;
    return false;
}

/// True if a ray moved sideways by no more than `tolerance` sees the device's triangle (none: nothing), or what the ray
/// itself meets within the tolerances where that is: around a vertex, each triangle of the fan is seen from a wedge only,
/// which may be thinner than what lies between the directions that are tried, 16 at 4 distances.
bool nearbyRaySees(const reference::Tree& tree, const Ray& floats, const Hit& device, double tolerance) {
    const uint32_t triangle = device.primitive;
    const reference::Ray ray = widen(floats);
    const bool isThere = triangle != noTriangle && isOn(tree.geometry(), floats, device, triangle);
    const dvec3 d = glm::normalize(ray.direction);
    const dvec3 aside = std::abs(d.x) < 0.5 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
    const dvec3 right = glm::normalize(glm::cross(d, aside)), up = glm::cross(right, d);
    for (double distance = tolerance; distance > 0.1 * tolerance; distance /= 2.0)
        for (int i = 0; i < 16; ++i) {
            const double angle = 0.39269908169872415 * i;
            reference::Ray moved = ray;
            moved.origin += distance * (std::cos(angle) * right + std::sin(angle) * up);
            const reference::Hit seen = tree.closest(moved);
            if (seen.primitive == triangle) return true;
            if (isThere && seen.primitive != noTriangle && passesBy(tree.geometry(), floats, seen, triangle)) return true;
        }
    return false;
}

/// How far the point that a hit's t stands for is from its triangle, in units of the tolerance there.
double offsetOf(const Geometry& geometry, const Ray& ray, const Hit& hit) {
    const dvec3 point = dvec3(ray.origin) + double{hit.t} * dvec3(ray.direction);
    return distanceTo(geometry, point, hit.primitive) / positionTolerance(geometry, ray, hit.primitive);
}

/// A float's place in the order of all floats.
int64_t rankOf(float x) {
    const int64_t bits = std::bit_cast<int32_t>(x);
    return bits >= 0 ? bits : int64_t{std::numeric_limits<int32_t>::min()} - bits;
}

}  // namespace

reference::Ray widen(const Ray& ray) {
    return {ray.origin, ray.direction, ray.tMin, ray.tMax};
}

uint64_t ulpsApart(float a, float b) {
    return static_cast<uint64_t>(std::abs(rankOf(a) - rankOf(b)));
}

double positionTolerance(const Ray& ray, const vec3& a, const vec3& b, const vec3& c) {
    const dvec3 o = ray.origin;
    return 8.0 *
           reference::floatUlp(std::max({largest(o), largest(dvec3(a) - o), largest(dvec3(b) - o), largest(dvec3(c) - o)}));
}

double positionTolerance(const Geometry& geometry, const Ray& ray, uint32_t id) {
    if (!geometry.isSphere(id)) {
        const Corners k = cornersOf(geometry, id);
        return positionTolerance(ray, k.a, k.b, k.c);
    }
    const Sphere& sphere = geometry.sphere(id);
    const dvec3 o = ray.origin;
    return 8.0 * reference::floatUlp(std::max(largest(o), largest(dvec3(sphere.centre) - o) + sphere.radius));
}

HitClass classifyHit(const reference::Tree& tree, const Ray& ray, const reference::Hit& oracle, const Hit& device) {
    const Geometry& geometry = tree.geometry();
    if (!isAnswer(geometry, ray, device)) return HitClass::wrong;
    if (device.primitive == oracle.primitive) return HitClass::same;
    const HitClass fault = device.primitive == NO_HIT       ? HitClass::missed
                           : oracle.primitive == noTriangle ? HitClass::phantom
                                                            : HitClass::wrong;
    const reference::Ray wide = widen(ray);
    if (!reference::isUsable(wide)) return fault;
    if (device.primitive != NO_HIT && passesBy(geometry, ray, oracle, device.primitive)) return HitClass::tie;
    // What lies in front of the oracle's hit can only be a tie by its own edges, looked at above.
    if (oracle.primitive == noTriangle || (device.primitive != NO_HIT && device.t <= oracle.t)) return fault;
    if (device.primitive != NO_HIT && meetsBoth(geometry, ray, oracle, device)) return HitClass::tie;
    const double tolerance = positionTolerance(geometry, ray, oracle.primitive);
    if (nearbyRaySees(tree, ray, device, tolerance)) return HitClass::tie;
    if (!passesOpenEdge(geometry, ray, oracle.primitive)) return fault;
    // Those on both sides of a crack may be met.
    reference::Hit without = tree.closest(wide, oracle.primitive);
    if (without.primitive != noTriangle && passesOpenEdge(geometry, ray, without.primitive))
        without = tree.closest(wide, oracle.primitive, without.primitive);
    if (device.primitive == NO_HIT) return without.primitive == noTriangle ? HitClass::tie : fault;
    const bool isRight = isOn(geometry, ray, device, device.primitive) && without.primitive != noTriangle &&
                         passesBy(geometry, ray, without, device.primitive);
    return isRight ? HitClass::tie : fault;
}

Spread spreadOf(std::vector<double> values) {
    if (values.empty()) return {};
    std::sort(values.begin(), values.end());
    const auto rank = [&](double share) {
        return values[static_cast<size_t>(std::ceil(share * static_cast<double>(values.size()))) - 1];
    };
    return {rank(0.5), rank(0.99), values.back()};
}

size_t UlpHistogram::bucketOf(uint64_t ulps) {
    return ulps == 0 ? 0 : static_cast<size_t>(std::bit_width(ulps - 1)) + 1;
}

uint64_t UlpHistogram::lowest(size_t bucket) {
    return bucket < 2 ? bucket : (uint64_t{1} << (bucket - 2)) + 1;
}

uint64_t UlpHistogram::highest(size_t bucket) {
    return bucket == 0 ? 0 : uint64_t{1} << (bucket - 1);
}

void UlpHistogram::operator+=(const UlpHistogram& other) {
    for (size_t i = 0; i < buckets; ++i) counts[i] += other.counts[i];
}

uint64_t HitComparison::rays() const {
    return counts[0] + counts[1] + counts[2] + counts[3] + counts[4];
}

uint64_t HitComparison::faultCount() const {
    return count(HitClass::missed) + count(HitClass::phantom) + count(HitClass::wrong);
}

HitComparison compareHits(const reference::Tree& tree, std::span<const Ray> rays, std::span<const Hit> hits) {
    RAIG_CHECK_OP(rays.size(), ==, hits.size());
    std::vector<reference::Hit> oracle(rays.size());
    std::vector<HitClass> kinds(rays.size());
    parallelFor(rays.size(), 256, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            oracle[i] = tree.closest(widen(rays[i]));
            kinds[i] = classifyHit(tree, rays[i], oracle[i], hits[i]);
        }
    });
    HitComparison result;
    std::vector<double> ulps, offsets;
    for (size_t i = 0; i < rays.size(); ++i) {
        ++result.counts[static_cast<uint32_t>(kinds[i])];
        result.met += oracle[i].primitive != noTriangle;
        if (kinds[i] == HitClass::same && hits[i].primitive != NO_HIT) {
            const uint64_t apart = ulpsApart(static_cast<float>(oracle[i].t), hits[i].t);
            ++result.tUlps.counts[UlpHistogram::bucketOf(apart)];
            ulps.push_back(static_cast<double>(apart));
            offsets.push_back(offsetOf(tree.geometry(), rays[i], hits[i]));
        }
        if (kinds[i] == HitClass::same) continue;
        const HitComparison::Difference difference{i, rays[i], kinds[i], oracle[i], hits[i]};
        if (kinds[i] != HitClass::tie && result.faults.size() < 16) result.faults.push_back(difference);
        if (kinds[i] == HitClass::tie && !result.firstTie) result.firstTie = difference;
    }
    result.tUlp = spreadOf(std::move(ulps));
    result.offset = spreadOf(std::move(offsets));
    return result;
}

Image roundedImage(const reference::Picture& picture) {
    Image image(picture.width, picture.height);
    for (size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = vec3(picture.radiance[i]);
    return image;
}

PictureComparison compareToReference(const Image& picture, const reference::Picture& expected, double sensitivity,
                                     double pixelsPerDegree) {
    const Image rounded = roundedImage(expected);
    std::vector<uint8_t> ties(expected.sensitivity.size());
    // Written so that a NaN is no tie.
    for (size_t i = 0; i < ties.size(); ++i) ties[i] = expected.sensitivity[i] > sensitivity;
    PictureComparison result;
    result.outsideTies = comparePictures(picture, rounded, ties, pixelsPerDegree);
    result.everywhere = comparePictures(picture, rounded, {}, pixelsPerDegree);
    result.ties = static_cast<uint64_t>(std::count(ties.begin(), ties.end(), 1));
    for (const dvec3& colour : expected.radiance) result.blank &= colour == expected.radiance[0];
    return result;
}

}  // namespace raig
