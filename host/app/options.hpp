/// What the command line asked for, as plain values, checked: every number is in its range.
#pragma once

#include "app/aov.hpp"
#include "image/tone.hpp"
#include "measure/compare_bounds.hpp"
#include "rays/types.hpp"
#include "scene/import.hpp"
#include "scene/integrator.hpp"
#include "scene/view.hpp"
#include "structures/structure.hpp"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace raig {

/// How camera rays find what they meet.
enum class Primary { ray, raster };

enum class Command { render, trace, compare, bench, chart, stress, info, devices };

enum class Exposure {
    legible,   ///< a png in which hardly anything could be told apart as suits it, all else as it is
    suitable,  ///< as suits the picture
    stops,     ///< as is asked for
};

/// Pictures of an animation, both ends included.
struct FrameRange {
    uint32_t first = 0;
    uint32_t last = 0;
};

/// All options of all commands; each command reads its own and finds the defaults in the rest. Choices that only a part of
/// the program knows (structures, walks, builders, devices, cameras) stay names, checked by that part with a usageError.
struct Options {
    Command command = Command::devices;

    // Common.
    std::string device = "auto";  ///< auto, cpu, an index of `raig devices`, a part of a name; stress: or all
    uint32_t threads = 0;         ///< 0: all cores
    uint32_t seed = 0;
    bool json = false;            ///< one JSON document on standard output
    bool quiet = false;

    // The acceleration structure.
    std::string accel = "bvh";  ///< a line of structures/registry.def, or "auto"
    bool accelGiven = false;    ///< it was asked for
    BuildParams buildParams;    ///< which of them a structure offers, its builder checks
    std::string instances = "auto";  ///< auto, keep or flatten
    std::filesystem::path saveStructure;  ///< where to write the structure; empty: nowhere
    std::filesystem::path loadStructure;  ///< where to read it from; empty: it is built

    // What is read and written. `trace` and `render` have one scene; `compare` a scene, or two pictures.
    std::vector<std::filesystem::path> inputs;
    Moment moment;                 ///< of a scene that moves
    std::filesystem::path output;  ///< render: the picture; compare: the difference picture, empty if none is wanted

    // Pictures: render, and compare of a scene.
    uint32_t width = 512;                  ///< compare: 256 where --size is not given, as the reference takes its time
    uint32_t height = 512;
    bool sizeIsGiven = false;              ///< else as many pixels as these are in the shape that the camera asks for
    std::string camera;                    ///< a name or an index in the file; empty: the first
    ViewChange viewChange;                 ///< of that camera
    std::optional<Crop> crop;              ///< only this part of the picture; it lies in it
    float aperture = 0.0f;                 ///< of the lens, in scene units
    std::optional<float> focus;            ///< distance in scene units; given only with an aperture
    uint32_t maxDepth = 8;                 ///< NIVELL_MAX: levels of reflection and refraction below the primary ray
    double minContribution = 1.0 / 512.0;  ///< MIN_CONTRIB: no ray that contributes less is traced
    uint32_t samples = 0;                  ///< a pixel; 0: the command's own default
    Filter filter = Filter::box;
    Integrator integrator = Integrator::whitted;
    std::optional<float> aoDistance;       ///< how far ambient occlusion looks

    // Light, of the same.
    std::filesystem::path environment;  ///< a picture of what is where nothing is; empty: none
    double environmentScale = 1.0;
    double environmentTurn = 0.0;       ///< radians

    // render.
    std::optional<FrameRange> frames;      ///< a picture of each; nothing: one picture
    double framesPerSecond = 24.0;
    std::optional<double> seconds;         ///< that the picture may take
    double tolerance = 0.0;                ///< of pixels' errors, in linear light; 0: all get as many samples
    Primary primary = Primary::ray;
    Exposure exposure = Exposure::legible;
    double stops = 0.0;                    ///< Exposure::stops
    Tone tone = Tone::none;                ///< none unless `output` is a png
    std::vector<Aov> aovs;                 ///< to be written; each once
    std::optional<Aov> view;               ///< what the picture shows instead of light

    // compare.
    std::vector<Bound> bounds;  ///< of metrics; more than one of the same are all held to
    double pixelsPerDegree = defaultPixelsPerDegree;

    // bench.
    uint32_t side = 1024;       ///< of the square picture whose rays are traced; a multiple of 8
    uint32_t repetitions = 7;   ///< of each measurement
    bool bothQueries = false;   ///< of each set of rays
    std::filesystem::path baseline;  ///< an earlier run's JSON; empty: none
    double slower = 1.25;       ///< than the baseline, by no more than this factor

    // stress.
    std::vector<uint32_t> cases;   ///< by number; none: all
    uint64_t rayCount = 0;         ///< a case; 0: as many as the case has of itself
    std::optional<uint64_t> ray;   ///< only this one
    bool isLong = false;           ///< many more rays and structures
    bool onlyControls = false;
    bool verbose = false;
    std::filesystem::path folder;  ///< for the page and its data; empty: none are written

    // stress and compare.
    std::filesystem::path junit;  ///< XML file to write; empty: none

    // chart. The folder is stress's, too.
    std::vector<std::filesystem::path> sweeps;  ///< files with more of them
    std::vector<std::string> figures;           ///< by name; none: all
    bool fresh = false;                         ///< nothing of an earlier run is taken up

    // trace.
    std::filesystem::path rays;
    std::filesystem::path hits;
    Query query = Query::closest;
    bool counters = false;  ///< count on a device, too, which costs time
};

/// Parses a command line.
///
/// Ensures: numbers are in range; picture files end in .png, .hdr, .exr or .pfm; a folder stands for each file to be
/// written. Nothing if help or the version was asked for, and has been printed on standard output.
/// Throws Error: usage for a wrong command line (its text names the option and what is allowed), badInput for a missing
/// output folder.
std::optional<Options> parseOptions(int argc, const char* const* argv);

}  // namespace raig
