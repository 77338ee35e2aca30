#include "base/error.hpp"
#include "scene/geometry.hpp"
#include "scene/import.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

namespace raig {

namespace {

/// What the standard camera looks at.
struct Subject {
    std::vector<vec3> points;  ///< vertices that triangles name, and points of spheres, in the world, within reach of rays
    Box bounds;                ///< of the usable triangles and spheres
};

/// 26 directions, evenly enough to frame a sphere by.
void addSphere(const Sphere& sphere, Subject& subject) {
    if (!isUsableSphere(sphere.centre, sphere.radius)) return;
    subject.bounds.grow(sphereBox(sphere.centre, sphere.radius));
    for (int x = -1; x <= 1; ++x)
        for (int y = -1; y <= 1; ++y)
            for (int z = -1; z <= 1; ++z)
                if (const dvec3 way(x, y, z); x != 0 || y != 0 || z != 0)
                    subject.points.emplace_back(dvec3(sphere.centre) + double{sphere.radius} * glm::normalize(way));
}

/// The directions of the standard view, and how far from its centre it must be for a point.
struct ThreeQuarters {
    static constexpr double yfov = 0.78539816339744831;  // 45 degrees
    static constexpr double share = 0.95;                // of the frame that the subject may take

    ThreeQuarters(const Box& framed, const dvec3& towardsEye)
        : centre(0.5 * (dvec3(framed.lo) + dvec3(framed.hi))), forward(-glm::normalize(towardsEye)) {}

    double distanceFor(const vec3& point) const {
        const dvec3 p = dvec3(point) - centre;
        const double aside = std::max(std::abs(glm::dot(p, right)), std::abs(glm::dot(p, up)));
        return aside / slope - glm::dot(p, forward);
    }

    dvec3 centre;
    dvec3 forward;
    dvec3 right = glm::normalize(glm::cross(forward, dvec3(0.0, 1.0, 0.0)));
    dvec3 up = glm::cross(right, forward);
    double slope = share * std::tan(yfov / 2.0);
};

/// Of the points inside `framed`, one that asks the standard view to be farthest away; none if there is none.
std::vector<vec3> decidingPoints(const std::vector<vec3>& points, const Box& framed, const dvec3& towardsEye) {
    const ThreeQuarters view(framed, towardsEye);
    std::vector<vec3> deciding;
    for (const vec3& point : points) {
        if (!framed.contains(Box{point, point})) continue;
        if (deciding.empty() || view.distanceFor(point) > view.distanceFor(deciding.front())) deciding = {point};
    }
    return deciding;
}

/// The vertices of an instance's triangles where they stand, points on its spheres, and the bounds of what is usable.
Subject placeInstance(const Scene& scene, const Instance& instance) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    const Placement placement = placementOf(instance.toWorld);
    Subject placed;
    for (const vec3& position : mesh.positions) placed.points.push_back(placePoint(placement, position));
    std::vector<bool> isNamed(placed.points.size(), false);
    for (const uvec3& t : mesh.triangles) {
        isNamed[t.x] = isNamed[t.y] = isNamed[t.z] = true;
        if (!isUsable(placed.points[t.x], placed.points[t.y], placed.points[t.z])) continue;
        for (int corner = 0; corner < 3; ++corner) placed.bounds.grow(placed.points[t[corner]]);
    }
    for (size_t i = 0; i < isNamed.size(); ++i)
        if (!isNamed[i] || !isFinite(placed.points[i])) placed.points[i] = vec3(std::numeric_limits<float>::infinity());
    for (const Sphere& sphere : mesh.spheres) addSphere(placeSphere(instance.toWorld, sphere), placed);
    return placed;
}

/// The box, in its own space, of what rays can meet of a mesh.
Box boxOf(const Mesh& mesh) {
    Box box;
    for (const uvec3& t : mesh.triangles) {
        if (!isUsable(mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z])) continue;
        for (int corner = 0; corner < 3; ++corner) box.grow(mesh.positions[t[corner]]);
    }
    for (const Sphere& sphere : mesh.spheres)
        if (isUsableSphere(sphere.centre, sphere.radius)) box.grow(sphereBox(sphere.centre, sphere.radius));
    return box;
}

/// Where the corners of a mesh's box stand; nothing if they all coincide, for then nothing of it is seen.
Subject placeBox(const Box& box, const Instance& instance) {
    const Placement placement = placementOf(instance.toWorld);
    Subject placed;
    for (unsigned corner = 0; corner < 8 && !box.empty(); ++corner) {
        const glm::bvec3 isHigh(corner & 1, corner & 2, corner & 4);
        const vec3 point = glm::mix(box.lo, box.hi, isHigh);
        placed.points.push_back(placePoint(placement, point));
        if (isInRange(placed.points.back())) placed.bounds.grow(placed.points.back());
    }
    return placed.bounds.lo == placed.bounds.hi ? Subject{} : placed;
}

/// Places instances; where all of them show too much to go through, those of meshes that stand in many places by their
/// boxes.
class Placer {
public:
    explicit Placer(const Scene& scene) : scene_(scene), counts_(scene.meshes.size(), 0), boxes_(scene.meshes.size()) {
        uint64_t work = 0;
        for (const Instance& instance : scene.instances) {
            const Mesh& mesh = scene.meshes[instance.mesh];
            work += mesh.positions.size() + mesh.triangles.size() + 26 * mesh.spheres.size();
            ++counts_[instance.mesh];
        }
        isLarge_ = work > mostWork;
        for (size_t i = 0; i < boxes_.size(); ++i)
            if (byBox(i)) boxes_[i] = boxOf(scene.meshes[i]);
    }
    Subject place(const Instance& instance) const {
        return byBox(instance.mesh) ? placeBox(boxes_[instance.mesh], instance) : placeInstance(scene_, instance);
    }

private:
    static constexpr uint64_t mostWork = uint64_t{1} << 27;
    bool byBox(size_t mesh) const { return isLarge_ && counts_[mesh] > 4; }

    const Scene& scene_;
    std::vector<uint32_t> counts_;  ///< of each mesh's instances
    std::vector<Box> boxes_;        ///< of meshes that are placed by them
    bool isLarge_ = false;
};

/// Twice over the instances, so that of each only the points which the view depends on stay in memory.
Subject findSubject(const Scene& scene, const dvec3& towardsEye) {
    const Placer placer(scene);
    Subject subject;
    for (const Instance& instance : scene.instances) subject.bounds.grow(placer.place(instance).bounds);
    if (subject.bounds.empty()) return subject;
    for (const Instance& instance : scene.instances) {
        const std::vector<vec3> deciding = decidingPoints(placer.place(instance).points, subject.bounds, towardsEye);
        subject.points.insert(subject.points.end(), deciding.begin(), deciding.end());
    }
    return subject;
}

/// The sum of the areas of all front faces, as a vector: 0 for closed surfaces, else what faces the openings.
dvec3 sumOfFaces(const Scene& scene, double& area) {
    dvec3 sum(0.0);
    for (const Instance& instance : scene.instances) {
        const Mesh& mesh = scene.meshes[instance.mesh];
        const Placement placement = placementOf(instance.toWorld);
        const double side = glm::determinant(glm::mat<3, 3, double>(instance.toWorld)) < 0.0 ? -1.0 : 1.0;
        for (const uvec3& t : mesh.triangles) {
            const vec3 a = placePoint(placement, mesh.positions[t.x]), b = placePoint(placement, mesh.positions[t.y]),
                       c = placePoint(placement, mesh.positions[t.z]);
            if (!isUsable(a, b, c)) continue;
            const dvec3 face = glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a));
            sum += side * face;
            area += glm::length(face);
        }
    }
    return sum;
}

/// The horizontal axis from which a room that is lit from within, without a front wall, is looked into; nothing for what
/// is closed, or open at the top only.
std::optional<dvec3> findOpening(const Scene& scene) {
    uint64_t work = 0;
    for (const Instance& instance : scene.instances) work += scene.meshes[instance.mesh].triangles.size();
    if (work > uint64_t{1} << 24) return std::nullopt;
    double area = 0.0;
    const dvec3 faces = sumOfFaces(scene, area);
    const bool isAlongX = std::abs(faces.x) > std::abs(faces.z);
    const double most = isAlongX ? faces.x : faces.z;
    if (!(std::abs(most) > 0.05 * area)) return std::nullopt;
    const double sign = most > 0.0 ? 1.0 : -1.0;
    return isAlongX ? dvec3(sign, 0.0, 0.0) : dvec3(0.0, 0.0, sign);
}

void addCamera(Scene& scene) {
    const bool isLit = !scene.lights.empty() || emitsLight(scene);
    const std::optional<dvec3> opening = isLit ? findOpening(scene) : std::nullopt;
    const dvec3 towardsEye = opening.value_or(threeQuarters);
    Subject subject = findSubject(scene, towardsEye);
    const bool isEmpty = subject.bounds.empty();
    if (isEmpty) {
        // Nothing to look at: look at a unit box around the origin.
        subject.bounds = {vec3(-0.5f), vec3(0.5f)};
        subject.points.clear();
        for (unsigned corner = 0; corner < 8; ++corner)
            subject.points.emplace_back(corner & 1 ? 0.5f : -0.5f, corner & 2 ? 0.5f : -0.5f, corner & 4 ? 0.5f : -0.5f);
    }
    scene.cameras.push_back(threeQuarterView(subject.points, subject.bounds, towardsEye));
    scene.remarks.emplace_back(isEmpty   ? "no camera and nothing to see: a three-quarter view of a unit box is used"
                               : opening ? "no camera: a view into the scene through its open side is used"
                                         : "no camera: a three-quarter view of the whole scene is used");
}

/// What surfaces send each other is not traced; where the file says nothing of it, a faint light from everywhere stands in,
/// so that places no light reaches directly can be told from nothing.
constexpr float faintAmbient = 0.03f;

const char* const noLight =
    "no light: a headlight along the camera, a sky and some ambient light are used (by path without the ambient light)";
const char* const noEnvironment = "no environment: ";  // how the remark begins

/// The sky where the file has none, so that mirrors and glass have something to show. It goes with a sun whose irradiance is
/// pi.
constexpr Sky daySky = {.zenith = {0.28f, 0.44f, 0.72f}, .horizon = {0.85f, 0.88f, 0.92f}, .ground = {0.19f, 0.16f, 0.13f}};

/// The irradiance of all suns: a directional light comes from outdoors.
double sunlight(const Scene& scene) {
    double sum = 0.0;
    for (const Light& light : scene.lights)
        if (light.type == Light::Type::directional)
            sum += glm::dot(dvec3(light.intensity), dvec3(0.2126, 0.7152, 0.0722));
    return std::min(sum, 1e30);
}

/// A directional light of that irradiance along the camera. It casts no shadows, or a room's own walls would keep it out.
Light headlightOf(const Scene& scene, double irradiance) {
    Light headlight;
    headlight.type = Light::Type::directional;
    headlight.direction = scene.cameras.front().forward;
    headlight.intensity = vec3(static_cast<float>(irradiance));
    headlight.castsShadows = false;
    return headlight;
}

/// What surfaces and the sky would add to the file's own light. Where no sun gets to, a headlight as faint as the ambient
/// light shows shapes.
void addEnvironment(Scene& scene) {
    scene.ambient = vec3(faintAmbient);
    const double sun = sunlight(scene);
    if (!(sun > 0.0)) {
        scene.remarks.push_back(
            fmt::format("{}a faint ambient light ({}) is used (not by path)", noEnvironment, faintAmbient));
        return;
    }
    const auto scale = static_cast<float>(sun / std::numbers::pi);
    scene.sky = {scale * daySky.zenith, scale * daySky.horizon, scale * daySky.ground};
    scene.ambient *= scale;
    scene.lights.push_back(headlightOf(scene, std::numbers::pi * scene.ambient.x));
    scene.remarks.push_back(fmt::format(
        "{}a sky that goes with the sun, a faint ambient light ({:.3g}, not by path) and a headlight as faint are used",
        noEnvironment, scene.ambient.x));
}

/// A directional light whose irradiance of pi makes a white diffuse surface that faces it exactly 1 bright, and a sky.
void addLight(Scene& scene) {
    scene.lights.push_back(headlightOf(scene, std::numbers::pi));
    scene.sky = daySky;
    scene.ambient = vec3(0.12f);
    scene.remarks.emplace_back(noLight);
}

}  // namespace

bool emitsLight(const Scene& scene) {
    std::vector<bool> emitting;
    for (const Material& material : scene.materials)
        emitting.push_back(glm::any(glm::greaterThan(material.emission, vec3(0.0f))));
    std::vector<bool> isDone(scene.meshes.size(), false);
    return std::ranges::any_of(scene.instances, [&](const Instance& instance) {
        if (isDone[instance.mesh]) return false;
        isDone[instance.mesh] = true;
        const Mesh& mesh = scene.meshes[instance.mesh];
        // Spheres glow, but light nothing.
        const auto ofTriangles = std::span(mesh.materials).first(mesh.triangles.size());
        return std::ranges::any_of(ofTriangles, [&](uint32_t index) { return emitting[index]; });
    });
}

void completeScene(Scene& scene) {
    checkPrimitiveCount(scene);
    if (scene.materials.empty()) {
        scene.materials.push_back({});
        scene.remarks.emplace_back("no material: a diffuse grey is used");
    }
    if (scene.cameras.empty()) addCamera(scene);
    if (scene.lights.empty() && !emitsLight(scene)) {
        addLight(scene);
    } else {
        addEnvironment(scene);
    }
}

void lightByEnvironment(Scene& scene, Environment environment) {
    std::erase_if(scene.lights, [](const Light& light) { return !light.castsShadows; });
    std::erase(scene.remarks, noLight);
    std::erase_if(scene.remarks, [](const std::string& remark) { return remark.starts_with(noEnvironment); });
    scene.sky = {};
    scene.ambient = vec3(0.0f);
    scene.environment = std::move(environment);
}

Camera threeQuarterView(const std::vector<vec3>& points, const Box& framed, const dvec3& towardsEye) {
    RAIG_CHECK(!framed.empty() && isFinite(framed.lo) && isFinite(framed.hi));
    const ThreeQuarters view(framed, towardsEye);
    double distance = -std::numeric_limits<double>::infinity();
    for (const vec3& point : points)
        if (framed.contains(Box{point, point})) distance = std::max(distance, view.distanceFor(point));
    // A single point, or one seen edge-on, asks for no distance at all.
    if (!(distance > 0.0)) distance = std::max(glm::length(dvec3(framed.extent())), 1e-3);

    Camera camera;
    camera.name = towardsEye == threeQuarters ? "three-quarter view" : "view along an axis";
    camera.eye = vec3(view.centre - distance * view.forward);
    camera.forward = vec3(view.forward);
    camera.right = vec3(view.right);
    camera.up = vec3(view.up);
    camera.yfov = static_cast<float>(ThreeQuarters::yfov);
    camera.target = vec3(view.centre);
    return camera;
}

}  // namespace raig
