#include "reference/path.hpp"

#include "reference/directions.hpp"
#include "reference/emitters.hpp"
#include "reference/environment.hpp"
#include "reference/sampling.hpp"
#include "reference/scattering.hpp"
#include "reference/shadows.hpp"
#include "scene/integrator.hpp"

#include <algorithm>
#include <numbers>

namespace raig::reference {

namespace {

constexpr double leastSpread = 0.001f;      // of a lobe that is drawn from
constexpr double leastLightSpread = 0.01;   // of what it mirrors of lights without size

/// The share of what is found with one density and might have been with another.
double balanced(double density, double other) {
    return density / (density + other);
}

/// The chances of the ways on.
struct Chances {
    double reflected = 0.0, transmitted = 0.0, scattered = 0.0, rough = 0.0;
};

Chances chancesOf(const dvec3& weight, const Scattering& s) {
    Chances c{largest(weight * s.reflection), largest(weight * s.transmission), largest(weight * s.diffuse),
              largest(weight * s.rough)};
    const double sum = c.reflected + c.transmitted + c.scattered + c.rough;
    if (sum > 0.0) c = {c.reflected / sum, c.transmitted / sum, c.scattered / sum, c.rough / sum};
    return c;
}

/// A chain of rays: where it stands.
class Chain {
public:
    Chain(const World& world, const Ray& ray, const Bounds& bounds, const SampleId& id)
        : world_(world), bounds_(bounds), id_(id), ray_(ray), nest_(id.media) {}

    Radiance follow() {
        while (step()) ++key_;
        return found_;
    }

private:
    /// One ray. False if none goes on.
    bool step() {
        const Hit hit = world_.tree.closest(ray_, leaving_);
        if (hit.primitive == noTriangle) {
            found_.value += weight_ * distantShare() * distantRadiance(world_.scene, ray_.direction);
            return false;
        }
        const double distance = travelled_ + hit.t;
        SurfacePoint p = surfaceAt(world_, ray_, hit, id_.pixelWidth + id_.pixelSpread * distance);
        p.surface.gloss = p.surface.roughness * p.surface.roughness < leastSpread ? 1.0 : 0.0;
        const Passing passing = pass(world_, p, nest_);
        weight_ *= glm::exp(-passing.absorption * (hit.t - ray_.tMin));
        if (!passing.isHidden && passes(p)) return passOn(p, hit, passing);
        travelled_ = distance;

        Scattering s;
        if (passing.isHidden) {
            s.transmission = dvec3(1.0);
            s.transmitted = ray_.direction;
        } else {
            s = scatter(p, ray_.direction, passing);
            found_.value += weight_ * emissionShare(p, hit) * p.surface.emission;
        }
        Chances chances = chancesOf(weight_, s);
        const dvec3 eye = -ray_.direction, weight = weight_;
        const bool goesOn = draw(p, s, passing, chances, hit.primitive);
        if (depth_ + 1 > bounds_.maxDepth) chances = {};
        if (!passing.isHidden) found_.value += weight * directLight(p, s, chances, eye, hit.primitive);
        if (goesOn) found_.depth = ++depth_;
        return goesOn;
    }

    double distantShare() const {
        if (density_ == 0.0 || !world_.scene.environment || !world_.scene.environment->shines()) return 1.0;
        return balanced(density_, environmentDensity(*world_.scene.environment, ray_.direction));
    }

    double emissionShare(const SurfacePoint& p, const Hit& hit) const {
        if (density_ == 0.0 || world_.emitters.triangles.empty() || world_.geometry.isSphere(hit.primitive)) return 1.0;
        const double cosine = std::abs(glm::dot(p.normal, ray_.direction));
        const double ofLight = glowOf(world_, world_.geometry.materials[hit.primitive]) * hit.t * hit.t / cosine;
        return balanced(density_, ofLight);
    }

    /// By its alpha.
    bool passes(const SurfacePoint& p) const {
        if (p.surface.coverage >= 1.0) return false;
        return sample2(id_.pixel, id_.sample, 0x20000000u + key_, bounds_.seed).x >= p.surface.coverage;
    }

    bool passOn(const SurfacePoint& p, const Hit& hit, const Passing& passing) {
        if (passes_ == mostPasses) {
            found_.discarded += largest(weight_);
            return false;
        }
        ++passes_;
        density_ *= 1.0 - p.surface.coverage;
        ray_.tMin = std::nextafter(hit.t, INFINITY);
        leaving_ = hit.primitive;
        nest_ = passing.beyond;
        return largest(weight_) > 0.0;
    }

    /// What the surface sends to `eye` of irradiance from `direction`, its mirrors left out.
    dvec3 towards(const SurfacePoint& p, const Scattering& s, const dvec3& eye, const dvec3& direction, double share,
                  double least) const {
        return s.diffuse / std::numbers::pi +
               share * lobeTowards(s.lobe, p.shadingNormal, p.surface.roughness, eye, direction, least);
    }

    double roughShare(const SurfacePoint& p) const { return p.surface.transmits ? 0.0 : 1.0 - p.surface.gloss; }

    /// The density of the ray that goes on.
    double densityOf(const SurfacePoint& p, const Chances& chances, const dvec3& eye, const dvec3& direction) const {
        const double a = std::max(p.surface.roughness * p.surface.roughness, leastSpread);
        double density = chances.scattered * std::max(0.0, glm::dot(p.shadingNormal, direction)) / std::numbers::pi;
        if (chances.rough > 0.0) density += chances.rough * mirroredDensity(p.shadingNormal, a, eye, direction);
        return density;
    }

    dvec3 directLight(const SurfacePoint& p, const Scattering& s, const Chances& chances, const dvec3& eye,
                      uint32_t leaving) const {
        dvec3 sum(0.0);
        for (const Arriving& light : lightsSeen(world_, p, id_, key_, bounds_.seed, /* candidates= */ 1)) {
            const double seen = shareSeen(world_, p, light, !light.isDrawn, leaving, id_, key_);
            if (seen == 0.0) continue;
            // A drawn ray would pass what `seen` is of by that chance.
            if (light.isDrawn)
                sum += seen * balanced(light.density, seen * densityOf(p, chances, eye, light.direction)) *
                       light.irradiance * towards(p, s, eye, light.direction, roughShare(p), leastSpread);
            else
                sum += seen * light.irradiance * towards(p, s, eye, light.direction, 1.0, leastLightSpread);
        }
        return sum;
    }

    /// Turns to the ray that goes on. False if none does.
    bool draw(const SurfacePoint& p, const Scattering& s, const Passing& passing, const Chances& c, uint32_t primitive) {
        const dvec3 eye = -ray_.direction, n = p.shadingNormal;
        const dvec2 choice = sample2(id_.pixel, id_.sample, 0x40000000u + key_, bounds_.seed);
        const double through = c.reflected + c.transmitted, before = through + c.scattered;
        leaving_ = primitive;
        if (choice.x >= through && c.scattered + c.rough > 0.0) {
            const dvec2 square = sample2(id_.pixel, id_.sample, 6 + 3 * key_, bounds_.seed);
            const bool isRough = c.rough > 0.0 && choice.x >= before;
            const double a = std::max(p.surface.roughness * p.surface.roughness, leastSpread);
            const dvec3 way = isRough ? mirroredDirection(n, a, eye, square) : cosineDirection(n, square);
            density_ = densityOf(p, c, eye, way);
            if (!canReach(p, way) || glm::dot(n, way) <= 0.0 || density_ == 0.0) return false;
            if (glm::dot(p.normal, way) <= 0.0) leaving_ = noTriangle;  // it starts above the triangle
            const dvec3 value = towards(p, s, eye, way, roughShare(p), leastSpread) * glm::dot(n, way);
            return goOn(p, p.position + p.lift, p.normal, way, weight_ * value / density_, passing.here, choice.y);
        }
        density_ = 0.0;
        if (c.transmitted > 0.0 && choice.x >= c.reflected)
            return goOn(p, p.position, -p.normal, s.transmitted, weight_ * s.transmission / c.transmitted, passing.beyond,
                        choice.y);
        if (c.reflected == 0.0) return false;
        return goOn(p, p.position, p.normal, s.reflected, weight_ * s.reflection / c.reflected, passing.here, choice.y);
    }

    bool goOn(const SurfacePoint& p, const dvec3& from, const dvec3& side, const dvec3& direction, const dvec3& weight,
              const Nest& nest, double chance) {
        const double most = largest(weight), enough = std::min(double{rouletteFactor} * bounds_.minContribution, 1.0);
        if (depth_ + 1 > bounds_.maxDepth) {
            found_.discarded += most;
            return false;
        }
        if (most <= 0.0 || (most < enough && chance >= most / enough)) return false;
        weight_ = most < enough ? weight * (enough / most) : weight;
        nest_ = nest;
        ray_ = Ray{.origin = leave(p, from, side, id_, 4 * (key_ + 1)),
                   .direction = id_.rounding.direction(direction, 4 * (key_ + 1) + 1)};
        return true;
    }

    const World& world_;
    const Bounds& bounds_;
    const SampleId& id_;
    Ray ray_;
    Nest nest_;
    dvec3 weight_{1.0};
    uint32_t depth_ = 0;
    uint32_t key_ = 0;
    uint32_t passes_ = 0;
    uint32_t leaving_ = noTriangle;
    double density_ = 0.0;  ///< with which the ray's direction was drawn; 0: it was not
    double travelled_ = 0.0;
    Radiance found_;
};

}  // namespace

Radiance tracePath(const World& world, const Ray& ray, const Bounds& bounds, const SampleId& id) {
    return Chain(world, ray, bounds, id).follow();
}

}  // namespace raig::reference
