/// Reading scene files. One importer a format; every index, range, count, node graph and number is checked after the
/// format's parser, whatever that parser said.
#pragma once

#include "scene/scene.hpp"

#include <filesystem>
#include <memory>
#include <span>

namespace raig {

/// A moment of a scene that moves: `seconds` into one of the file's animations. Without seconds, all is at rest: as its
/// nodes say.
struct Moment {
    std::optional<double> seconds;  ///< finite
    std::string animation;          ///< its name or, if none has that, its index; the first if empty
};

/// Reads a scene by its file name's ending: .gltf .glb .obj .ply .stl (any case), then completes it.
///
/// Ensures: every index in the scene is in range, numbers other than mesh positions are finite, at least one material and
/// one camera; lights and sky are as in the file, or a headlight and a sky where it has no light at all (completeScene).
/// Throws inputError with file and line or JSON pointer if the file cannot be used; limitError if it is too large;
/// usageError if a moment is wanted, and the file has no such animation.
Scene importScene(const std::filesystem::path& path, const Moment& moment = {});

/// A .gltf or .glb file, read once and looked at in several moments (scene/gltf.cpp). Throws as importScene does.
class GltfFile {
public:
    explicit GltfFile(const std::filesystem::path& path);
    ~GltfFile();
    GltfFile(const GltfFile&) = delete;
    GltfFile& operator=(const GltfFile&) = delete;

    Scene at(const Moment& moment) const;
    /// The same, for the last time: images are handed over, not copied.
    Scene lastAt(const Moment& moment);

private:
    void finish(Scene& scene, const Moment& moment) const;
    struct State;
    std::unique_ptr<State> state_;
};

/// A scene file that is looked at in several moments, one after the other.
class MovingScene {
public:
    /// Throws usageError if the file is of a format without animations; else as importScene does.
    explicit MovingScene(const std::filesystem::path& path);

    /// The scene at a moment, completed. A camera that the file lacks is added for the first moment, and stays.
    Scene at(const Moment& moment);

private:
    std::filesystem::path path_;
    GltfFile file_;
    std::optional<Camera> added_;
};

/// The importers, one a format. They throw as importScene does, and leave completing to it.
Scene importGltf(const std::filesystem::path& path, const Moment& moment = {});  ///< .gltf and .glb (scene/gltf.cpp)
Scene importObj(const std::filesystem::path& path);   ///< with its .mtl files (scene/obj.cpp)
Scene importPly(const std::filesystem::path& path);   ///< ASCII and binary of both byte orders (scene/ply.cpp)
Scene importStl(const std::filesystem::path& path);   ///< ASCII and binary (scene/stl.cpp)

/// Adds what a picture needs and the file lacks, each with a remark: a material; a camera in a three-quarter view that
/// frames the usable triangles (PEERS' standard camera); and, if there is neither a light nor an emitting triangle, a
/// headlight (directional, along the first camera, irradiance pi, without shadows) with a sky and some ambient light. A
/// scene with light of its own gets a faint ambient light for what surfaces would send each other; if a sun is among it,
/// that is as bright as goes with the sun, and there are a headlight as faint and a sky. A scene that is lit, and whose
/// faces leave an open side, as a room without a front wall does, is looked into through that, along an axis.
/// Where instances show more than 2^27 vertices and primitives, the view frames the boxes of meshes that stand in more than
/// four places, instead of their triangles; so the cost stays O(vertices, primitives and instances stored).
/// Throws limitError as checkPrimitiveCount does.
void completeScene(Scene& scene);

/// True if a triangle that an instance shows emits light. O(instances and triangles).
bool emitsLight(const Scene& scene);

/// Puts `environment` in the place of all that a completed scene got for want of one: sky, ambient light, headlight.
void lightByEnvironment(Scene& scene, Environment environment);

/// From where the standard view is seen, as a direction from the centre.
constexpr dvec3 threeQuarters{0.5, 0.35, 1.0};

/// The tightest view of `points` (finite ones) from one direction: the eye in the direction of `towardsEye` (not +-Y) from
/// the centre of `framed`, up +Y, 45 degrees, every point of `points` inside `framed` within the middle 95 % of a square
/// frame.
Camera threeQuarterView(const std::vector<vec3>& points, const Box& framed, const dvec3& towardsEye = threeQuarters);

/// Decodes a PNG or JPEG (or what else stb_image reads) into sRGB texels. Throws inputError naming `place`; limitError
/// beyond 16384 x 16384.
Texels decodeImage(std::span<const std::byte> bytes, const std::string& place);

}  // namespace raig
