#include "measure/chart_scene.hpp"

#include "base/error.hpp"
#include "base/input_file.hpp"
#include "measure/hard_meshes.hpp"
#include "rays/primitives.hpp"
#include "scene/import.hpp"

#include <algorithm>
#include <numbers>

namespace raig {

namespace {

/// Two squares that face each other, glow with radiance 1 and mirror the share K of what arrives; an orthographic camera
/// between them looks straight at one. Every ray goes to and fro for ever: 1 + K + K^2 + ... arrives [the catalogue's
/// case 52].
Scene facingMirrors(double reflectance) {
    Scene scene;
    Material mirror;
    mirror.name = "mirror";
    mirror.baseColor = vec3(static_cast<float>(reflectance));
    mirror.metallic = 1.0f;
    mirror.roughness = 0.0f;
    mirror.emission = vec3(1.0f);
    scene.materials = {mirror};
    Mesh mesh;
    for (const float z : {-1.0f, 1.0f}) {
        const auto first = static_cast<uint32_t>(mesh.positions.size());
        for (const auto& [x, y] : {std::pair(-4.0f, -4.0f), {4.0f, -4.0f}, {4.0f, 4.0f}, {-4.0f, 4.0f}})
            mesh.positions.emplace_back(x, y, z);
        mesh.triangles.push_back({first, first + 1, first + 2});
        mesh.triangles.push_back({first, first + 2, first + 3});
    }
    mesh.materials.assign(mesh.triangles.size(), 0);
    scene.meshes = {mesh};
    scene.instances = {{0, dmat4(1.0)}};
    Camera camera;
    camera.eye = vec3(0.25f, 0.125f, 0.0f);  // off the diagonals, where the triangles meet
    camera.orthographic = true;
    camera.xmag = camera.ymag = 1.0f;
    scene.cameras = {camera};
    return scene;
}

/// A closed fan of triangles fifty thousand times longer than wide: a rod whose corners lie on two circles.
Scene slivers() {
    constexpr uint32_t sides = 5'000;
    Scene scene;
    scene.materials = {Material{}};
    Mesh mesh;
    const auto place = [](uint32_t i, float end) {
        const double angle = 2.0 * std::numbers::pi * i / sides;
        return vec3(static_cast<float>(std::cos(angle)), 30.0f * end, static_cast<float>(std::sin(angle)));
    };
    for (const float end : {-1.0f, 1.0f}) {
        for (uint32_t i = 0; i < sides; ++i) mesh.positions.push_back(place(i, end));
        mesh.positions.emplace_back(0.0f, 30.0f * end, 0.0f);
    }
    const uint32_t top = sides + 1;
    for (uint32_t i = 0; i < sides; ++i) {
        const uint32_t next = (i + 1) % sides;
        mesh.triangles.push_back({i, next, top + next});
        mesh.triangles.push_back({i, top + next, top + i});
        mesh.triangles.push_back({sides, next, i});
        mesh.triangles.push_back({top + sides, top + i, top + next});
    }
    mesh.materials.assign(mesh.triangles.size(), 0);
    scene.meshes = {mesh};
    scene.instances = {{0, dmat4(1.0)}};
    completeScene(scene);
    return scene;
}

/// A closed, bumpy sphere a million from the origin, where floats are 1/16 apart [the catalogue's case 17].
Scene farSphere() {
    Scene scene;
    scene.materials = {Material{}};
    scene.meshes = {hard::meshOf(hard::sphere(24, 20.0, dvec3(1e6), 0.2))};
    scene.instances = {{0, dmat4(1.0)}};
    completeScene(scene);
    return scene;
}

struct Made {
    const char* name;
    Scene (*make)(double reflectance);
    double reflectance;  ///< of two facing mirrors; else 0
};
constexpr Made made[] = {{"slivers", [](double) { return slivers(); }, 0.0},
                         {"far-sphere", [](double) { return farSphere(); }, 0.0},
                         {"mirrors-50", facingMirrors, 0.5},
                         {"mirrors-90", facingMirrors, 0.9},
                         {"mirrors-98", facingMirrors, 0.98}};

const Made* findMade(const std::string& name) {
    const auto* found = std::find_if(std::begin(made), std::end(made), [&](const Made& one) { return one.name == name; });
    return found == std::end(made) ? nullptr : found;
}

std::unique_ptr<ChartScene> make(const Made& one) {
    auto scene = std::make_unique<ChartScene>(one.name, one.make(one.reflectance));
    if (one.reflectance > 0.0) scene->mirrorReflectance = one.reflectance;
    return scene;
}

}  // namespace

ChartScene::ChartScene(std::string name, Scene scene)
    : name_(std::move(name)), scene_(std::move(scene)), geometry_(flatten(scene_)), primitives_(primitivesOf(geometry_)) {}

const reference::World& ChartScene::world() const {
    if (!world_) world_ = std::make_unique<reference::World>(scene_, geometry_);
    return *world_;
}

bool ChartScene::mirrors() const {
    std::vector<uint8_t> matters(scene_.materials.size());
    for (size_t i = 0; i < matters.size(); ++i) {
        const Surface surface = surfaceOf(scene_.materials[i]);
        // What merely shines mirrors little but at grazing incidence, and still does.
        matters[i] = surface.gloss > 0.0f || surface.transmission != vec3(0.0f);
    }
    return std::any_of(geometry_.materials.begin(), geometry_.materials.end(),
                       [&](uint32_t material) { return matters[material] != 0; });
}

namespace {

/// All numbers of a scene that pictures depend on, beside its primitives, as text: fmt writes floats so that they can be
/// read back. Arrays follow as they are.
class Looks {
public:
    template <class... Numbers>
    void add(const Numbers&... numbers) {
        ((bytes_ += fmt::format("{} ", numbers)), ...);
    }
    void add(const vec3& v) { add(v.x, v.y, v.z); }
    template <class T>
    void addAll(const std::vector<T>& values) {
        add(values.size());
        bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    }
    void add(const Material& m) {
        for (const vec3& v : {m.baseColor, m.emission, m.attenuationColor}) add(v);
        add(m.alpha, m.alphaVaries, m.alphaCutoff, m.metallic, m.roughness, m.transmission, m.ior, m.thin,
            m.attenuationDistance, m.normalScale, m.occlusionStrength);
        for (const auto* texture :
             {&m.baseColorTexture, &m.roughnessTexture, &m.normalTexture, &m.emissionTexture, &m.occlusionTexture})
            add(*texture);
    }
    void add(const std::optional<Texture>& t) {
        add(t.has_value());
        if (!t) return;
        add(t->image, static_cast<uint32_t>(t->wrapU), static_cast<uint32_t>(t->wrapV), t->set);
        add(t->u);
        add(t->v);
    }
    void add(const Light& l) {
        for (const vec3& v : {l.position, l.direction, l.intensity}) add(v);
        add(static_cast<uint32_t>(l.type), l.innerConeAngle, l.outerConeAngle, l.castsShadows, l.range);
    }
    void add(const Camera& c) {
        for (const vec3& v : {c.eye, c.forward, c.right, c.up}) add(v);
        add(c.orthographic, c.yfov, c.xmag, c.ymag, c.aspect);
    }
    std::span<const std::byte> bytes() const { return std::as_bytes(std::span(bytes_)); }

private:
    std::string bytes_;
};

}  // namespace

std::string ChartScene::hash() const {
    Looks looks;
    for (const Material& m : scene_.materials) looks.add(m);
    for (const Light& l : scene_.lights) looks.add(l);
    for (const Camera& c : scene_.cameras) looks.add(c);
    for (const vec3& v : {scene_.sky.zenith, scene_.sky.horizon, scene_.sky.ground, scene_.ambient}) looks.add(v);
    for (const Texels& image : scene_.images) {
        looks.add(image.width, image.height);
        looks.addAll(image.rgba);
    }
    looks.addAll(geometry_.normals);
    looks.addAll(geometry_.tangents);
    looks.addAll(geometry_.uvs);
    looks.addAll(geometry_.moreUvs);
    looks.addAll(geometry_.colors);
    looks.addAll(geometry_.alphas);
    looks.addAll(geometry_.triangles);
    looks.addAll(geometry_.materials);
    const SceneHash shape = hashOf(primitives_), rest = hashOf(looks.bytes());
    return fmt::format("{:016x}{:016x}{:016x}{:016x}", shape[0], shape[1], rest[0], rest[1]);
}

ChartScenes::ChartScenes(const std::vector<std::filesystem::path>& files) {
    for (const std::filesystem::path& path : files) {
        [[maybe_unused]] const InputFile opens{path};  // that one is missing should be told before the others are measured
        const std::string stem = path.stem().string();
        std::string name = stem;
        const auto taken = [&] {
            return findMade(name) != nullptr ||
                   std::any_of(files_.begin(), files_.end(), [&](const File& file) { return file.name == name; });
        };
        for (int number = 2; taken(); ++number) name = fmt::format("{}-{}", stem, number);
        files_.push_back({name, path, {}});
    }
}

std::vector<std::string> ChartScenes::namesOf(const std::string& entry) {
    std::vector<std::string> names;
    if (entry == "given" || entry == "first" || entry == "mirroring") {
        for (File& file : files_) {
            if (entry == "mirroring" && !file.mirrors) file.mirrors = open(file.name).mirrors();
            if (entry != "mirroring" || *file.mirrors) names.push_back(file.name);
            if (entry == "first") break;
        }
        return names;
    }
    if (findMade(entry) != nullptr) return {entry};
    for (const Made& one : made) names.emplace_back(one.name);
    throw usageError("there is no scene \"{}\"; there are given, first, mirroring, {}", entry, fmt::join(names, ", "));
}

const ChartScene& ChartScenes::open(const std::string& name) {
    if (last_ && last_->name() == name) return *last_;
    last_.reset();
    if (const Made* one = findMade(name)) {
        last_ = make(*one);
        return *last_;
    }
    const auto file = std::find_if(files_.begin(), files_.end(), [&](const File& one) { return one.name == name; });
    RAIG_CHECK(file != files_.end());
    last_ = std::make_unique<ChartScene>(name, importScene(file->path));
    return *last_;
}

}  // namespace raig
