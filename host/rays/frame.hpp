/// Pictures: camera rays, and below each the lecture's recursion, turned into steps over many pixels at a time.
///
/// Radiance of a ray is what the surface it meets emits, what it scatters of the light that reaches it (each light, one
/// point of the emitting triangles and one direction of the environment a sample, and ambient light from everywhere), and
/// what arrives along the reflected and the transmitted ray, weighted by K_R and K_T. A ray is followed down to NIVELL_MAX
/// and while its weight in the pixel is at least MIN_CONTRIB. Source: Whitted 1980, "An Improved Illumination Model for
/// Shaded Display"; Hall and Greenberg 1983, "A Testbed for Realistic Image Synthesis" (adaptive recursion).
///
/// Where glass holds other things each ray knows which media it is in (shaders/media.glsl): what it meets parts the one
/// that it runs through from the next, and that one absorbs. Camera rays are in the media that the eye is in, once for a
/// picture (an orthographic camera's eye is the middle of where its rays start).
///
/// The camera's lens, if it has one, is thin: what is at distance z along the axis is blurred to a disk whose diameter, in
/// the plane in focus at distance f, is aperture * |z - f| / z. An orthographic camera's blurs to aperture * |z - f| / f.
///
/// With Integrator::path each ray that meets a surface is followed by one more, in a direction drawn from what the surface
/// does with light: shaders/bounce.glsl. That brings indirect light, in the place of ambient light, which is left out. What
/// glass focuses is found, too; point, spot and directional lights shine through glass straight on, as a drawn ray cannot
/// meet them. A ray of little weight is not discarded but ended by chance, without a bias: below rouletteFactor times
/// MIN_CONTRIB, as often as its weight is short of that. What NIVELL_MAX cuts off is discarded, as ever: that bounds the
/// error of the mean of many pictures, not that of each. Source: Kajiya 1986, "The Rendering Equation"; Veach and Guibas
/// 1995, "Optimally Combining Sampling Techniques for Monte Carlo Rendering".
///
/// With Integrator::ao a pixel is the share of directions, by their cosine, in which a surface meets nothing within a
/// distance; all surfaces count alike, and where there is none it is white. One ray a sample asks. Source: Zhukov, Iones and
/// Kronin 1998, "An Ambient Light Illumination Model".
///
/// Devices and the CPU run the same code, shaders/frame.glsl. The same command gives the same bits, whatever the tile size,
/// the number of threads, or the run.
#pragma once

#include "rays/tracer.hpp"
#include "scene/geometry.hpp"
#include "scene/integrator.hpp"
#include "scene/view.hpp"

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace raig {

struct FrameOptions {
    uint32_t width = 512;
    uint32_t height = 512;
    uint32_t samples = 4;                     ///< a pixel, or with a tolerance at most; 1 goes through its centre
    /// By when the picture is to be there: it gets as many samples as go into that time, up to `samples`, but at least one.
    /// What that gives is the picture of FrameStatistics::samples without a deadline, to the last bit.
    std::optional<std::chrono::steady_clock::time_point> deadline{};
    double tolerance = 0.0;                   ///< > 0: pixels get samples until their error is less (rays/adaptive.hpp)
    Filter filter = Filter::box;              ///< by which samples make up a pixel
    uint32_t maxDepth = 8;                    ///< NIVELL_MAX: reflections and refractions below the camera ray
    float minContribution = 1.0f / 512.0f;    ///< MIN_CONTRIB
    Integrator integrator = Integrator::whitted;
    float reach = INFINITY;                   ///< of ambient occlusion: what is farther away hides nothing; > 0
    uint32_t seed = 0;
    uint32_t camera = 0;                      ///< index into Scene::cameras
    uint32_t tilePixels = 0;                  ///< pixels at work at once; 0: by memory and measured time
    bool keepsLevels = false;                 ///< Picture::levels is wanted
    bool countsCosts = false;                 ///< Picture::costs is wanted: rays are traced by slower kernels, that count
    std::optional<Crop> crop{};               ///< only this part of the picture, whose pixels have the bits of the whole's

    float aperture = 0.0f;                    ///< diameter of the lens, in scene units; 0: a pinhole, all is sharp
    float focus = INFINITY;                   ///< distance along the camera's axis at which the picture is sharp; > 0

    /// Devices with DeviceOptions::graphics: an item buffer is drawn of this structure, which is the tracer's, and camera
    /// rays are told what it shows (rays/item_buffer.hpp). None: they are not. The picture has the same bits.
    const Structure* itemsOf = nullptr;

    /// What is rendered.
    Crop part() const { return crop.value_or(Crop{0, 0, width, height}); }
};

struct FrameStatistics {
    uint64_t closestRays = 0;   ///< camera, reflected and transmitted rays
    uint64_t shadowRays = 0;    ///< those that ask for light, or for what is open
    uint64_t spared = 0;        ///< shadow rays that were not traced: the others of one a light for each closest ray
    uint32_t deepest = 0;       ///< reflections and refractions of the deepest ray
    uint64_t forgottenMedia = 0;  ///< how often rays entered more things within each other than they remember
    uint32_t openMaterials = 0;   ///< of glass that may hold or lie in other things, but is not closed: Media
    uint32_t samples = 0;       ///< a pixel, or with a tolerance at most
    uint64_t unsettled = 0;     ///< pixels whose error is above the tolerance, where there is one
    uint32_t tiles = 0;
    double seconds = 0.0;       ///< wall time, from the scene in memory to the picture in memory
    double traceSeconds = 0.0;  ///< of which in finding hits
    double firstSeconds = 0.0;  ///< of which those of each pixel's first ray; with hints, looking them up, too
    double setupSeconds = 0.0;  ///< of which in data and kernels

    uint64_t hintedRays = 0;    ///< camera rays that an item buffer gave a hint to: that nothing is there is one, too
    uint64_t fallbacks = 0;     ///< of which met something else
    uint64_t drawnTriangles = 0;
    double drawSeconds = 0.0;   ///< wall time of drawing item buffers
};

/// What was rendered: of a part of a picture, that part.
struct Picture {
    uint32_t width = 0;
    uint32_t height = 0;
    std::vector<vec3> radiance;    ///< linear RGB, row by row from the top
    std::vector<float> discarded;  ///< of each pixel, the weight of the rays that were not followed: times the scene's
                                   ///< greatest radiance, it bounds what NIVELL_MAX and MIN_CONTRIB left out
    std::vector<uint32_t> samples; ///< of each pixel, where they are not all alike
    std::vector<uint32_t> levels;  ///< of each pixel, reflections and refractions of its deepest ray; where asked for
    std::vector<uint32_t> costs;   ///< of each pixel, nodes fetched and primitives tested by all its rays; where asked for
    FrameStatistics statistics;
};

/// Told from time to time, from the calling thread: the share of the work done, in [0, 1], and the rays traced so far.
using FrameProgress = std::function<void(double fractionDone, double raysDone)>;

/// Renders on the CPU, over all cores.
///
/// Requires  geometry == flatten(scene), or gatherInstances(scene), which gives the same picture; `tracer` of its triangles,
///           one level or two, with those that let light through marked so (markSeeThrough in rays/lights.hpp);
///           options.camera < scene.cameras.size(); sizes and samples > 0, samples <= 65536; a crop lies in the picture;
///           0 <= aperture <= 10^6 focus.
/// Ensures   no pixel's radiance is NaN or infinite unless the scene's numbers overflow.
/// Cost      samples * pixels * (1 + lights) rays for diffuse scenes; memory: what is rendered and tiles of some 64 MB.
///           Throws limitError if more than 2^31 pixels are to be rendered, or the whole picture has more than 2^32, or a
///           pixel's rays do not fit the memory of a tile.
Picture renderPicture(const Scene& scene, const Geometry& geometry, Tracer& tracer, const FrameOptions& options,
                      const FrameProgress& progress = {});

/// Renders on a Vulkan device. Keep it for several pictures of one scene: its data and kernels stay on the device.
///
/// No dispatch is longer than the device stands (50 ms on hardware, 2 s on software devices), as tiles are sized by measured
/// time.
class DeviceFrame {
public:
    /// Requirements of scene, geometry and tracer as for renderPicture; `tracer` traces on `device`, and both outlive this,
    /// as do `scene` and `geometry`. Throws limitError if the scene does not fit.
    DeviceFrame(Device& device, const Scene& scene, const Geometry& geometry, DeviceTracer& tracer);
    ~DeviceFrame();
    DeviceFrame(const DeviceFrame&) = delete;
    DeviceFrame& operator=(const DeviceFrame&) = delete;

    Picture render(const FrameOptions& options, const FrameProgress& progress = {});

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// One picture by a DeviceFrame of its own.
Picture renderPicture(Device& device, const Scene& scene, const Geometry& geometry, DeviceTracer& tracer,
                      const FrameOptions& options, const FrameProgress& progress = {});

/// The camera rays of sample `sampleIndex` of every pixel that is rendered, row by row, as renderPicture traces them.
std::vector<Ray> cameraRays(const Scene& scene, const FrameOptions& options, uint32_t sampleIndex = 0);

/// How far ambient occlusion looks where nothing else is said: as far as a quarter of a square picture's height is at the
/// median distance of what the camera of `options` sees, by 1024 rays; without end where that is nothing.
float suitableReach(const Scene& scene, Tracer& tracer, FrameOptions options);

}  // namespace raig
