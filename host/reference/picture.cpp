#include "reference/picture.hpp"

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "reference/directions.hpp"
#include "reference/occlusion.hpp"
#include "reference/path.hpp"
#include "reference/sampling.hpp"

#include <algorithm>
#include <mutex>
#include <numbers>

namespace raig::reference {

namespace {

/// Half the width and height of the picture, at distance 1 (perspective) or in world units (orthographic).
dvec2 halfSize(const Camera& camera, double aspect) {
    if (camera.orthographic)
        return aspect > double{camera.xmag} / camera.ymag ? dvec2(camera.ymag * aspect, camera.ymag)
                                                          : dvec2(camera.xmag, camera.xmag / aspect);
    const double halfHeight = std::tan(0.5 * camera.yfov);
    return {halfHeight * aspect, halfHeight};
}

Radiance radianceAlong(const World& world, const PictureOptions& options, const Ray& ray, const SampleId& id) {
    if (options.integrator == Integrator::ao) return openness(world, ray, options.reach, options.bounds, id);
    if (options.integrator == Integrator::path) return tracePath(world, ray, options.bounds, id);
    return traceRay(world, ray, options.bounds, id);
}

/// The share of Gauss's curve, of standard deviation 1, that is below x.
double gaussBelow(double x) {
    return 0.5 * std::erfc(-x / std::numbers::sqrt2);
}

/// The same of the triangle from -1 over 0 to 1.
double tentBelow(double x) {
    const double left = 1.0 - std::abs(x);
    return x < 0.0 ? 0.5 * left * left : 1.0 - 0.5 * left * left;
}

/// Where below(x) == share, for a `below` that grows from less to more than that between -reach and reach: by halving.
template <class Below>
double placeWhere(const Below& below, double share, double reach) {
    double low = -reach, high = reach;
    for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (below(middle) < share ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

/// From the pixel's middle, where the filter's share below is `share`.
double filterPlace(Filter filter, double share) {
    switch (filter) {
        case Filter::box: return share - 0.5;
        case Filter::tent: return placeWhere(tentBelow, share, 1.0);
        case Filter::gauss: return 0.5 * placeWhere(gaussBelow, 0.02425 + (1.0 - 2.0 * 0.02425) * share, 4.0);
    }
    return 0.0;
}

/// A pixel's mean radiance and discarded weight. `variant` counts the roundings; nothing: as it is.
Radiance shadePixel(const World& world, const PictureOptions& options, const Nest& media, uint32_t px, uint32_t py,
                    std::optional<uint32_t> variant) {
    const Camera& camera = world.scene.cameras[options.camera];
    const dvec3 stands = glm::abs(dvec3(camera.eye));
    const double eye = std::max({stands.x, stands.y, stands.z, 0.5 * options.aperture});
    const uint32_t pixel = py * options.width + px;
    const double pixelSize = 2.0 * halfSize(camera, double(options.width) / options.height).y / options.height;
    Radiance mean;
    for (uint32_t sample = 0; sample < options.samples; ++sample) {
        SampleId id{.pixel = pixel, .sample = sample, .media = media};
        (camera.orthographic ? id.pixelWidth : id.pixelSpread) = pixelSize;
        Ray ray = cameraRay(camera, options, px, py, sample);
        if (variant) {
            id.rounding = Rounding(pixel, sample, *variant);
            ray.origin = id.rounding.position(ray.origin, eye, 0);
            ray.direction = id.rounding.direction(ray.direction, 1);
        }
        const Radiance radiance = radianceAlong(world, options, ray, id);
        mean.value += radiance.value;
        mean.discarded += radiance.discarded;
        mean.brightest = std::max(mean.brightest, radiance.brightest);
        mean.depth += radiance.depth;
    }
    mean.value /= options.samples;
    mean.discarded /= options.samples;
    mean.depth /= options.samples;
    return mean;
}

}  // namespace

Ray cameraRay(const Camera& camera, const PictureOptions& options, uint32_t px, uint32_t py, uint32_t sample) {
    const double width = options.width, height = options.height;
    dvec2 place(0.5);
    if (options.samples > 1) {
        const dvec2 square = sample2(py * options.width + px, sample, 0, options.bounds.seed);
        place += dvec2(filterPlace(options.filter, square.x), filterPlace(options.filter, square.y));
    }
    const dvec2 half = halfSize(camera, width / height);
    const double sx = (2.0 * (px + place.x) / width - 1.0) * half.x;
    const double sy = (1.0 - 2.0 * (py + place.y) / height) * half.y;
    const dvec3 eye = camera.eye, forward = camera.forward, aside = sx * dvec3(camera.right) + sy * dvec3(camera.up);
    Ray ray;
    ray.origin = camera.orthographic ? eye + aside : eye;
    const dvec3 towards = camera.orthographic ? forward : forward + aside;
    ray.direction = glm::normalize(towards);
    if (options.aperture > 0.0) {
        const dvec3 sharp = options.focus * towards;  // from where the pinhole's ray starts
        const dvec2 disk = 0.5 * options.aperture * inDisk(sample2(py * options.width + px, sample, 3, options.bounds.seed));
        const dvec3 onLens = disk.x * dvec3(camera.right) + disk.y * dvec3(camera.up);
        ray.origin += onLens;
        if (std::isfinite(options.focus)) ray.direction = glm::normalize(sharp - onLens);
    }
    return ray;
}

Picture render(const World& world, const PictureOptions& options, const std::function<void(double)>& progress) {
    RAIG_CHECK_OP(options.camera, <, world.scene.cameras.size());
    RAIG_CHECK(options.width > 0 && options.height > 0 && options.samples > 0 && options.samples <= 65536);
    const Crop part = options.crop.value_or(Crop{0, 0, options.width, options.height});
    RAIG_CHECK(part.liesIn(options.width, options.height));
    const size_t count = part.pixels();
    const Nest media = mediaAround(world.geometry, world.media, dvec3(world.scene.cameras[options.camera].eye));
    Picture picture{part.width, part.height, std::vector<dvec3>(count), std::vector<double>(count),
                    std::vector<double>(count), std::vector<double>(count), std::vector<double>(count)};
    std::mutex mutex;
    size_t done = 0;
    parallelFor(count, 64, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const auto px = part.x + static_cast<uint32_t>(i % part.width);
            const auto py = part.y + static_cast<uint32_t>(i / part.width);
            const Radiance nominal = shadePixel(world, options, media, px, py, std::nullopt);
            picture.radiance[i] = nominal.value;
            picture.discarded[i] = nominal.discarded;
            picture.brightest[i] = nominal.brightest;
            picture.depth[i] = nominal.depth;
            for (uint32_t variant = 0; variant < options.roundings; ++variant) {
                const dvec3 moved = glm::abs(shadePixel(world, options, media, px, py, variant).value - nominal.value);
                picture.sensitivity[i] = std::max({picture.sensitivity[i], moved.x, moved.y, moved.z});
            }
        }
        if (!progress) return;
        const std::lock_guard lock(mutex);
        done += end - begin;
        progress(static_cast<double>(done) / static_cast<double>(count));
    });
    return picture;
}

}  // namespace raig::reference
