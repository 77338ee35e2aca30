#include "measure/hard_scenes.hpp"

#include "measure/hard_meshes.hpp"

#include <cmath>

namespace raig::hard {

Material glass(float ior) {
    Material m;
    m.baseColor = vec3(1.0f);
    m.roughness = 0.0f;
    m.transmission = 1.0f;
    m.ior = ior;
    m.thin = false;
    return m;
}

Material mirror(float reflectance) {
    Material m;
    m.baseColor = vec3(reflectance);
    m.metallic = 1.0f;
    m.roughness = 0.0f;
    return m;
}

Material glowing(float radiance) {
    Material m;
    m.baseColor = vec3(0.0f);
    m.emission = vec3(radiance);
    return m;
}

Mesh& addMesh(raig::Scene& scene, std::vector<vec3> positions, std::vector<uvec3> triangles, const Material& material) {
    Mesh mesh;
    mesh.positions = std::move(positions);
    mesh.triangles = std::move(triangles);
    mesh.materials.assign(mesh.triangles.size(), static_cast<uint32_t>(scene.materials.size()));
    scene.materials.push_back(material);
    scene.instances.push_back({static_cast<uint32_t>(scene.meshes.size()), dmat4(1.0)});
    return scene.meshes.emplace_back(std::move(mesh));
}

void addQuad(raig::Scene& scene, const vec3& corner, const vec3& u, const vec3& v, const Material& material) {
    addMesh(scene, {corner, corner + u, corner + u + v, corner + v}, {{0, 1, 2}, {0, 2, 3}}, material);
}

void addBox(raig::Scene& scene, const vec3& lo, const vec3& hi, const Material& material) {
    std::vector<vec3> corners;
    for (int i = 0; i < 8; ++i)
        corners.emplace_back((i & 1) != 0 ? hi.x : lo.x, (i & 2) != 0 ? hi.y : lo.y, (i & 4) != 0 ? hi.z : lo.z);
    addMesh(scene, corners,
            {{0, 2, 3},
             {0, 3, 1},
             {4, 5, 7},
             {4, 7, 6},
             {0, 1, 5},
             {0, 5, 4},
             {2, 6, 7},
             {2, 7, 3},
             {0, 4, 6},
             {0, 6, 2},
             {1, 3, 7},
             {1, 7, 5}},
            material);
}

void addBall(raig::Scene& scene, const vec3& centre, float radius, uint32_t rings, const Material& material) {
    std::vector<vec3> positions;
    std::vector<uvec3> triangles;
    for (const Primitive& t : sphere(rings, radius, dvec3(centre))) {
        const auto first = static_cast<uint32_t>(positions.size());
        const bool isOutwards = glm::dot(glm::cross(t.b - t.a, t.c - t.a), t.a + t.b + t.c - 3.0f * centre) > 0.0f;
        positions.insert(positions.end(), {t.a, isOutwards ? t.b : t.c, isOutwards ? t.c : t.b});
        triangles.emplace_back(first, first + 1, first + 2);
    }
    addMesh(scene, std::move(positions), std::move(triangles), material);
}

void addSphere(raig::Scene& scene, const vec3& centre, float radius, const Material& material) {
    Mesh& mesh = addMesh(scene, {}, {}, material);
    mesh.spheres = {{centre, radius}};
    mesh.materials = {static_cast<uint32_t>(scene.materials.size() - 1)};
}

raig::Scene whiteSky() {
    raig::Scene scene;
    scene.sky = {.zenith = vec3(1.0f), .horizon = vec3(1.0f), .ground = vec3(1.0f)};
    scene.ambient = vec3(1.0f);
    return scene;
}

Camera cameraAt(const vec3& eye, const vec3& forward, float yfov) {
    const vec3 up = std::abs(forward.y) < 0.9f * glm::length(forward) ? vec3(0, 1, 0) : vec3(0, 0, 1);
    Camera camera;
    camera.eye = eye;
    camera.forward = glm::normalize(forward);
    camera.right = glm::normalize(glm::cross(camera.forward, up));
    camera.up = glm::cross(camera.right, camera.forward);
    camera.yfov = yfov;
    return camera;
}

std::function<Ray(const FrameOptions&, size_t)> pixelRays(const raig::Scene& scene) {
    struct Kept {
        uvec2 size{0};
        std::vector<Ray> rays;
    };
    return [scene, kept = std::make_shared<Kept>()](const FrameOptions& options, size_t pixel) {
        const uvec2 size(options.width, options.height);
        if (kept->size != size) kept->rays = cameraRays(scene, options);
        kept->size = size;
        return kept->rays.at(pixel);
    };
}

FrameOptions pictureOf(uint32_t width, uint32_t height, uint32_t maxDepth, float minContribution) {
    FrameOptions options;
    options.width = width;
    options.height = height;
    options.samples = 1;
    options.maxDepth = maxDepth;
    options.minContribution = minContribution;
    return options;
}

}  // namespace raig::hard
