/// What the commands that trace have in common: a scene in memory, its structure, and a tracer where --device says.
#pragma once

#include "app/options.hpp"
#include "app/structure_source.hpp"
#include "rays/tracer.hpp"
#include "scene/geometry.hpp"
#include "scene/import.hpp"

#include <memory>

namespace raig {

/// A scene ready to be traced. Not movable: the tracer refers to the structure and the device.
struct Setup {
    Scene scene;
    Geometry geometry;
    Structure structure;
    std::unique_ptr<Device> device;  ///< none on the CPU path
    std::unique_ptr<Tracer> tracer;
    DeviceTracer* deviceTracer = nullptr;  ///< `tracer`, where there is a device
    std::unique_ptr<StructureSource> source;
    std::unique_ptr<MovingScene> moving;  ///< where --frames is given
    double importSeconds = 0.0;
    double buildSeconds = 0.0;  ///< 0 where the structure was read from a file
    double loadSeconds = 0.0;
    double uploadSeconds = 0.0;

    Setup() = default;
    Setup(const Setup&) = delete;
    Setup& operator=(const Setup&) = delete;

    std::string deviceName() const;
    double bytesPerTriangle() const;
};

/// Imports `file`, at the moment of --time-at or of the first of --frames, builds or reads the structure that is asked for,
/// opens the device, and says so line by line.
/// Throws what importing, building and opening throw. `options` must outlive the result.
std::unique_ptr<Setup> prepare(const Options& options, const std::filesystem::path& file);

/// Moves a scene that was prepared for --frames to another frame. The structure is built anew only where a triangle or
/// sphere is elsewhere; what raig added because the file lacks it, a camera, stays. `options` are those of prepare().
void moveTo(Setup& setup, const Options& options, uint32_t frame);

/// The camera that --camera names: an index, or the first whose name is that; the first of all if empty.
/// Throws usageError, which lists those there are.
uint32_t chooseCamera(const Scene& scene, const std::string& wanted);

}  // namespace raig
