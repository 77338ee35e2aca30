/// The scenes of charts: those of files, and some made here, where something is known of the answer.
#pragma once

#include "reference/world.hpp"
#include "scene/geometry.hpp"
#include "structures/scene_hash.hpp"

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace raig {

/// A scene, its geometry written out, and the reference's view of it. Not movable, as these refer to each other.
class ChartScene {
public:
    ChartScene(std::string name, Scene scene);
    ChartScene(const ChartScene&) = delete;
    ChartScene& operator=(const ChartScene&) = delete;

    const std::string& name() const { return name_; }
    const Scene& scene() const { return scene_; }
    const Geometry& geometry() const { return geometry_; }
    const std::vector<Primitive>& primitives() const { return primitives_; }
    /// Made when it is first asked for: O(n log n).
    const reference::World& world() const;
    /// True if a mirror or a clear surface is in it: then rays have children.
    bool mirrors() const;
    /// Of two facing mirrors: how much each reflects; what arrives along every ray is 1 / (1 - K). Else nothing.
    std::optional<double> mirrorReflectance;
    /// Names the same scene in a later run: of all that it holds but names and remarks. O(all of them).
    std::string hash() const;

private:
    std::string name_;
    Scene scene_;
    Geometry geometry_;
    std::vector<Primitive> primitives_;
    mutable std::unique_ptr<reference::World> world_;
};

/// Where a sweep's scenes come from: the files of the command line, by name, or what is made here.
class ChartScenes {
public:
    /// Throws inputError if one cannot be opened.
    explicit ChartScenes(const std::vector<std::filesystem::path>& files);

    /// The names that an entry of Sweep::scenes stands for; "mirroring" reads the files to know. Throws usageError, which
    /// lists what there is. What importing throws.
    std::vector<std::string> namesOf(const std::string& entry);
    /// Read or made anew, unless it is the one that was last asked for: one is in memory at a time.
    const ChartScene& open(const std::string& name);

private:
    struct File {
        std::string name;  ///< the file's, without its ending; told apart by a number where two are alike
        std::filesystem::path path;
        std::optional<bool> mirrors;
    };
    std::vector<File> files_;
    std::unique_ptr<ChartScene> last_;
};

}  // namespace raig
