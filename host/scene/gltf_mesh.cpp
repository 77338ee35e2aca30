#include "scene/gltf_accessor.hpp"
#include "scene/gltf_parts.hpp"

#include <algorithm>
#include <array>

namespace raig::gltf {

namespace {

/// Accessors may be named by any number of primitives, each of which writes them out: a small file could ask for anything.
constexpr size_t mostElements = size_t{1} << 28;

/// Sets of vertices are the same if all of this is: the accessors of position, normal, tangent, both uvs, and colour, and
/// those by which they are bent.
using VertexKey = std::pair<std::array<int, 6>, std::vector<int>>;

vec3 unitOrZero(const vec3& v) {
    const double length = std::sqrt(glm::dot(dvec3(v), dvec3(v)));
    return length > 0.0 && std::isfinite(length) ? vec3(dvec3(v) / length) : vec3(0.0f);
}

float finiteOr(float value, float otherwise) {
    return std::isfinite(value) ? value : otherwise;
}

/// Where rule `mode` puts triangle `i` among the vertices in order: glTF 2.0 specification, section 3.7.2.1.
uvec3 cornersOf(int mode, uint32_t i) {
    if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) return {i, i + 1 + i % 2, i + 2 - i % 2};
    if (mode == TINYGLTF_MODE_TRIANGLE_FAN) return {i + 1, i + 2, 0};
    return {3 * i, 3 * i + 1, 3 * i + 2};
}

/// How many primitives of its kind `count` vertices in order are (points, lines, or triangles).
size_t primitiveCount(int mode, size_t count) {
    switch (mode) {
        case TINYGLTF_MODE_POINTS:
            return count;
        case TINYGLTF_MODE_LINE:
            return count / 2;
        case TINYGLTF_MODE_LINE_LOOP:
            return count < 2 ? 0 : count;
        case TINYGLTF_MODE_LINE_STRIP:
            return count < 2 ? 0 : count - 1;
        case TINYGLTF_MODE_TRIANGLES:
            return count / 3;
        default:
            return count < 3 ? 0 : count - 2;
    }
}

/// Writes out one glTF mesh, primitive after primitive.
class MeshReader {
public:
    MeshReader(const Document& document, const std::vector<UvSource>& uvSources, Scene& scene, Remarks& remarks)
        : document_(document),
          uvSources_(uvSources),
          shapes_(readShapes(document)),
          skins_(document),
          scene_(scene),
          remarks_(remarks) {}

    Mesh read(size_t index, const Bend& bend);

private:
    void addPrimitive(const tinygltf::Primitive& primitive, const std::string& pointer);
    void addShape(const Shape& shape, uint32_t material);
    uint32_t materialOf(const tinygltf::Primitive& primitive) const;
    uint32_t addVertices(const tinygltf::Primitive& primitive, const std::string& pointer);
    void bendVertices(const tinygltf::Primitive& primitive, const std::string& pointer, size_t first);
    void addNormals(int accessor, const std::string& pointer, size_t first);
    void addTangents(int accessor, const std::string& pointer, size_t first);
    void addUvs(int accessor, const std::string& pointer, size_t first, std::vector<vec2>& uvs);
    void addColors(int accessor, const std::string& pointer, size_t first);
    void spend(size_t elements, const std::string& pointer);

    const Document& document_;
    const std::vector<UvSource>& uvSources_;
    std::vector<Shape> shapes_;
    Skins skins_;
    Scene& scene_;
    Remarks& remarks_;
    size_t written_ = 0;
    Mesh mesh_;
    Bend bend_;
    std::vector<bool> mirrored_;  ///< one a vertex, up to the last that a skin has bent
    std::vector<uint32_t> sphereMaterials_;
    std::map<VertexKey, uint32_t> firstVertex_;
};

int findAttribute(const tinygltf::Primitive& primitive, const std::string& name) {
    const auto found = primitive.attributes.find(name);
    return found == primitive.attributes.end() ? -1 : found->second;
}

void MeshReader::spend(size_t elements, const std::string& pointer) {
    written_ += elements;
    if (written_ > mostElements)
        throw limitError("{}#{}: the meshes hold more than {} vertices and indices in all", document_.file, pointer,
                         mostElements);
}

Mesh MeshReader::read(size_t index, const Bend& bend) {
    const tinygltf::Mesh& source = document_.model.meshes[index];
    mesh_ = Mesh{};
    bend_ = bend;
    mirrored_.clear();
    mesh_.name = source.name;
    sphereMaterials_.clear();
    firstVertex_.clear();
    for (size_t p = 0; p < source.primitives.size(); ++p)
        addPrimitive(source.primitives[p], fmt::format("/meshes/{}/primitives/{}", index, p));
    mesh_.materials.insert(mesh_.materials.end(), sphereMaterials_.begin(), sphereMaterials_.end());
    return std::move(mesh_);
}

/// Of a primitive that names none, the default one, which comes after the document's.
uint32_t MeshReader::materialOf(const tinygltf::Primitive& primitive) const {
    return static_cast<uint32_t>(primitive.material >= 0 ? primitive.material
                                                         : static_cast<int>(document_.model.materials.size()));
}

void MeshReader::addShape(const Shape& shape, uint32_t material) {
    if (!shape.isSphere()) {
        ++scene_.otherPrimitives;
        remarks_.add(fmt::format("a shape that is no sphere is left out: {}", shape.type));
        return;
    }
    mesh_.spheres.push_back({vec3(0.0f), shape.radius});
    sphereMaterials_.push_back(material);
    if (material >= document_.model.materials.size()) return;
    const Material& surface = scene_.materials[material];
    if (surface.baseColorTexture || surface.roughnessTexture || surface.normalTexture || surface.emissionTexture)
        remarks_.add("a sphere's texture is left out: spheres have no texture coordinates");
    if (glm::any(glm::greaterThan(surface.emission, vec3(0.0f))))
        remarks_.add("a sphere glows, but lights nothing: only triangles are lights");
}

void MeshReader::addPrimitive(const tinygltf::Primitive& primitive, const std::string& pointer) {
    if (const Shape* shape = shapeOf(document_, shapes_, primitive, pointer)) {
        if (primitive.attributes.empty()) {
            if (bend_.skin >= 0) throw errorAt(document_, pointer, "is a shape in a mesh that a node shows with a skin");
            return addShape(*shape, materialOf(primitive));
        }
        remarks_.add("a primitive with both vertices and a shape has its vertices used");
    }
    if (findAttribute(primitive, "POSITION") < 0) {
        remarks_.add("a primitive without positions is left out");
        return;
    }
    const size_t vertexCount = document_.model.accessors[findAttribute(primitive, "POSITION")].count;
    std::vector<uint32_t> indices;
    const bool isIndexed = primitive.indices >= 0;
    size_t count = vertexCount;
    if (isIndexed) {
        const std::string place = pointer + "/indices";
        checkType(document_, primitive.indices,
                  {.components = 1,
                   .bytes = false,
                   .unsignedBytes = true,
                   .shorts = false,
                   .unsignedShorts = true,
                   .unsignedInts = true,
                   .floats = false,
                   .needsNormalized = false},
                  place);
        count = document_.model.accessors[primitive.indices].count;
        spend(count, place);
        indices = readIndices(document_, primitive.indices);
        for (size_t i = 0; i < indices.size(); ++i)
            if (indices[i] >= vertexCount)
                throw errorAt(document_, place, "index {} names vertex {} of {}", i, indices[i], vertexCount);
    }
    const size_t primitives = primitiveCount(primitive.mode, count);
    if (primitive.mode < TINYGLTF_MODE_TRIANGLES) {
        scene_.otherPrimitives += primitives;
        remarks_.add("points and lines are left out: no ray hits them");
        return;
    }
    if (primitive.mode == TINYGLTF_MODE_TRIANGLES && count % 3 != 0)
        remarks_.add("a primitive's last, incomplete triangle is left out");
    if (primitives == 0) return;
    const uint32_t first = addVertices(primitive, pointer);
    mesh_.triangles.reserve(mesh_.triangles.size() + primitives);
    for (size_t i = 0; i < primitives; ++i) {
        const uvec3 at = cornersOf(primitive.mode, static_cast<uint32_t>(i));
        uvec3 corners = (isIndexed ? uvec3(indices[at.x], indices[at.y], indices[at.z]) : at) + first;
        // As an instance that mirrors does, so that fronts stay fronts.
        if (!mirrored_.empty() && mirrored_[corners.x] && mirrored_[corners.y] && mirrored_[corners.z])
            std::swap(corners.y, corners.z);
        mesh_.triangles.push_back(corners);
    }
    mesh_.materials.resize(mesh_.triangles.size(), materialOf(primitive));
}

/// The index of the primitive's first vertex in the mesh.
uint32_t MeshReader::addVertices(const tinygltf::Primitive& primitive, const std::string& pointer) {
    const UvSource plain;
    const UvSource& uvSource = primitive.material >= 0 ? uvSources_[primitive.material] : plain;
    const int position = findAttribute(primitive, "POSITION");
    const int normal = findAttribute(primitive, "NORMAL");
    const int tangent = uvSource.hasNormals ? findAttribute(primitive, "TANGENT") : -1;
    std::array<int, 2> uv = {findAttribute(primitive, "TEXCOORD_0"), -1};
    for (size_t i = 0; i < uvSource.sets.size(); ++i) {
        uv[i] = findAttribute(primitive, fmt::format("TEXCOORD_{}", uvSource.sets[i]));
        if (uv[i] < 0) remarks_.add("a textured primitive has no texture coordinates: its texture's first texel is used");
    }
    const int color = findAttribute(primitive, "COLOR_0");
    const VertexKey key{{position, normal, tangent, uv[0], uv[1], color}, bendAccessors(primitive, bend_)};
    const auto [known, isNew] = firstVertex_.try_emplace(key, static_cast<uint32_t>(mesh_.positions.size()));
    if (!isNew) return known->second;

    const bool isQuantized = std::ranges::count(document_.model.extensionsUsed, "KHR_mesh_quantization") > 0;
    checkType(document_, position,
              {.components = 3,
               .bytes = isQuantized,
               .unsignedBytes = isQuantized,
               .shorts = isQuantized,
               .unsignedShorts = isQuantized,
               .unsignedInts = false,
               .floats = true,
               .needsNormalized = false},
              pointer + "/attributes/POSITION");
    spend(document_.model.accessors[position].count, pointer);
    const std::vector<vec3> positions = readVec3(document_, position);
    const size_t first = mesh_.positions.size();
    mesh_.positions.insert(mesh_.positions.end(), positions.begin(), positions.end());
    // What one primitive has and another lacks is filled in, so that each array stays empty or whole.
    if (normal >= 0 || !mesh_.normals.empty()) addNormals(normal, pointer, first);
    if (tangent >= 0 || !mesh_.tangents.empty()) addTangents(tangent, pointer, first);
    if (uv[0] >= 0 || !mesh_.uvs.empty()) addUvs(uv[0], pointer, first, mesh_.uvs);
    if (uv[1] >= 0 || !mesh_.moreUvs.empty()) addUvs(uv[1], pointer, first, mesh_.moreUvs);
    if (color >= 0 || !mesh_.colors.empty()) addColors(color, pointer, first);
    if (!bend_.isNone()) bendVertices(primitive, pointer, first);
    return known->second;
}

void MeshReader::bendVertices(const tinygltf::Primitive& primitive, const std::string& pointer, size_t first) {
    spend(bendCost(primitive, bend_, mesh_.positions.size() - first), pointer);
    const bool hasNormals = findAttribute(primitive, "NORMAL") >= 0;
    const std::span<vec3> normals = hasNormals ? std::span(mesh_.normals).subspan(first) : std::span<vec3>();
    const std::vector<bool> mirrored =
        bend(document_, primitive, pointer, bend_, skins_, std::span(mesh_.positions).subspan(first), normals, remarks_);
    mirrored_.insert(mirrored_.end(), mirrored.begin(), mirrored.end());
}

void MeshReader::addNormals(int accessor, const std::string& pointer, size_t first) {
    mesh_.normals.resize(mesh_.positions.size(), vec3(0.0f));
    if (accessor < 0) return;
    checkType(document_, accessor,
              {.components = 3,
               .bytes = true,
               .unsignedBytes = false,
               .shorts = true,
               .unsignedShorts = false,
               .unsignedInts = false,
               .floats = true,
               .needsNormalized = true},
              pointer + "/attributes/NORMAL");
    const std::vector<vec3> normals = readVec3(document_, accessor);
    std::transform(normals.begin(), normals.end(), mesh_.normals.begin() + first, unitOrZero);
}

void MeshReader::addTangents(int accessor, const std::string& pointer, size_t first) {
    mesh_.tangents.resize(mesh_.positions.size(), vec4(0.0f));
    if (accessor < 0) return;
    checkType(document_, accessor,
              {.components = 4,
               .bytes = true,
               .unsignedBytes = false,
               .shorts = true,
               .unsignedShorts = false,
               .unsignedInts = false,
               .floats = true,
               .needsNormalized = true},
              pointer + "/attributes/TANGENT");
    const std::vector<vec4> tangents = readVec4(document_, accessor);
    for (size_t i = 0; i < tangents.size(); ++i)
        if (const vec3 along = unitOrZero(vec3(tangents[i])); along != vec3(0.0f))
            mesh_.tangents[first + i] = vec4(along, tangents[i].w < 0.0f ? -1.0f : 1.0f);
}

void MeshReader::addUvs(int accessor, const std::string& pointer, size_t first, std::vector<vec2>& uvs) {
    uvs.resize(mesh_.positions.size(), vec2(0.0f));
    if (accessor < 0) return;
    checkType(document_, accessor,
              {.components = 2,
               .bytes = true,
               .unsignedBytes = true,
               .shorts = true,
               .unsignedShorts = true,
               .unsignedInts = false,
               .floats = true,
               .needsNormalized = false},
              pointer + "/attributes/TEXCOORD");
    const std::vector<vec2> read = readVec2(document_, accessor);
    for (size_t i = 0; i < read.size(); ++i) uvs[first + i] = isUsableUv(read[i]) ? read[i] : vec2(0.0f);
}

void MeshReader::addColors(int accessor, const std::string& pointer, size_t first) {
    mesh_.colors.resize(mesh_.positions.size(), vec3(1.0f));
    if (!mesh_.alphas.empty()) mesh_.alphas.resize(mesh_.positions.size(), 1.0f);
    if (accessor < 0) return;
    const bool hasAlpha = document_.model.accessors[accessor].type == TINYGLTF_TYPE_VEC4;
    checkType(document_, accessor,
              {.components = hasAlpha ? 4 : 3,
               .bytes = false,
               .unsignedBytes = true,
               .shorts = false,
               .unsignedShorts = true,
               .unsignedInts = false,
               .floats = true,
               .needsNormalized = true},
              pointer + "/attributes/COLOR_0");
    if (hasAlpha || !mesh_.alphas.empty()) mesh_.alphas.resize(mesh_.positions.size(), 1.0f);
    if (hasAlpha) {
        const std::vector<vec4> all = readVec4(document_, accessor);
        for (size_t i = 0; i < all.size(); ++i) mesh_.alphas[first + i] = std::clamp(finiteOr(all[i].w, 1.0f), 0.0f, 1.0f);
    }
    const std::vector<vec3> colors = readVec3(document_, accessor);
    for (size_t i = 0; i < colors.size(); ++i)
        for (int k = 0; k < 3; ++k) mesh_.colors[first + i][k] = std::max(0.0f, finiteOr(colors[i][k], 1.0f));
}

/// The ways in which a mesh is bent, in the order in which they are met.
class Bends {
public:
    size_t add(Bend bend) {
        const auto [entry, isNew] = known_.try_emplace({bend.skin, bend.weights}, bends.size());
        if (isNew) bends.push_back(std::move(bend));
        return entry->second;
    }
    std::vector<Bend> bends;

private:
    std::map<std::pair<int, std::vector<double>>, size_t> known_;
};

}  // namespace

std::vector<uint32_t> addMeshes(const Document& document, const std::vector<UvSource>& uvSources,
                                const std::vector<PlacedNode>& placed, Scene& scene, Remarks& remarks) {
    const std::vector<tinygltf::Mesh>& meshes = document.model.meshes;
    std::vector<Bends> waysOf(meshes.size());
    std::vector<size_t> bendOfPlaced(placed.size(), 0);
    for (size_t i = 0; i < placed.size(); ++i)
        if (const tinygltf::Node& node = document.model.nodes[placed[i].node]; node.mesh >= 0)
            bendOfPlaced[i] = waysOf[node.mesh].add(bendOf(document, node));
    MeshReader reader(document, uvSources, scene, remarks);
    bool needsDefault = false;
    for (size_t i = 0; i < meshes.size(); ++i) {
        const std::vector<Bend>& bends = waysOf[i].bends;
        scene.meshes.push_back(reader.read(i, bends.empty() ? Bend{} : bends[0]));
        for (const tinygltf::Primitive& primitive : meshes[i].primitives) needsDefault |= primitive.material < 0;
    }
    std::vector<size_t> firstOther;
    for (size_t i = 0; i < meshes.size(); ++i) {
        firstOther.push_back(scene.meshes.size());
        for (size_t k = 1; k < waysOf[i].bends.size(); ++k) scene.meshes.push_back(reader.read(i, waysOf[i].bends[k]));
    }
    std::vector<uint32_t> shown(placed.size(), 0);
    for (size_t i = 0; i < placed.size(); ++i)
        if (const int mesh = document.model.nodes[placed[i].node].mesh; mesh >= 0)
            shown[i] = static_cast<uint32_t>(bendOfPlaced[i] ? firstOther[mesh] + bendOfPlaced[i] - 1 : size_t(mesh));
    if (!needsDefault && !scene.materials.empty()) return shown;
    // The specification's defaults: a rough white metal.
    Material material;
    material.name = "default";
    material.baseColor = vec3(1.0f);
    material.metallic = 1.0f;
    scene.materials.push_back(std::move(material));
    return shown;
}

}  // namespace raig::gltf
