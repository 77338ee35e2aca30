#include "structures/scene_hash.hpp"

#include "base/error.hpp"

#include <xxhash.h>

#include <memory>
#include <type_traits>

namespace raig {

namespace {

class Hasher {
public:
    Hasher() : state_(XXH3_createState()) { RAIG_CHECK(state_ && XXH3_128bits_reset(state_.get()) == XXH_OK); }

    /// Requires that nothing in a T be padding.
    template <class T>
    void add(std::span<const T> values) {
        static_assert(std::is_trivially_copyable_v<T>);
        RAIG_CHECK(XXH3_128bits_update(state_.get(), values.data(), values.size_bytes()) == XXH_OK);
    }
    /// Numbers, each taken as 64 bits.
    template <class... Numbers>
    void addNumbers(Numbers... numbers) {
        const uint64_t all[] = {static_cast<uint64_t>(numbers)...};
        add(std::span<const uint64_t>(all));
    }
    SceneHash result() const {
        const XXH128_hash_t hash = XXH3_128bits_digest(state_.get());
        return {hash.low64, hash.high64};
    }

private:
    struct Free {
        void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
    };
    std::unique_ptr<XXH3_state_t, Free> state_;
};

}  // namespace

SceneHash hashOf(std::span<const std::byte> bytes) {
    Hasher hasher;
    hasher.add(bytes);
    return hasher.result();
}

SceneHash hashOf(std::span<const Primitive> primitives) {
    const XXH128_hash_t hash = XXH3_128bits(primitives.data(), primitives.size_bytes());
    return {hash.low64, hash.high64};
}

SceneHash hashOf(const PlacedScene& scene) {
    static_assert(sizeof(vec3) == 12 && sizeof(uvec3) == 12 && sizeof(shared::Placement) == 48,
                  "nothing in them is padding");
    static_assert(sizeof(PlacedPrimitive) == sizeof(Primitive) + 4, "nothing in it is padding");
    Hasher hasher;
    hasher.addNumbers(scene.leastTriangles, scene.positions.size(), scene.meshes.size(), scene.instances.size(),
                      scene.others.size());
    hasher.add(scene.positions);
    for (const StoredMesh& mesh : scene.meshes) {
        hasher.addNumbers(mesh.triangles.size(), mesh.firstVertex, mesh.vertices, mesh.keeps);
        hasher.add(mesh.triangles);
    }
    for (const PlacedMesh& placed : scene.instances) {
        hasher.addNumbers(placed.mesh, placed.firstId, placed.mirrored);
        hasher.add(std::span<const shared::Placement>(&placed.placement, 1));
    }
    hasher.add(std::span<const PlacedPrimitive>(scene.others));
    return hasher.result();
}

uint64_t primitiveCount(const PlacedScene& scene) {
    uint64_t count = scene.others.size();
    for (const PlacedMesh& placed : scene.instances) count += scene.meshes[placed.mesh].triangles.size();
    return count;
}

}  // namespace raig
