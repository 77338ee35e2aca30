#include "rays/adaptive.hpp"

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "rays/frame_kernels.hpp"
#include "rays/frame_tiles.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace raig {

namespace {

/// Over the channels; 0 if that is no finite number.
double meanSquareOf(const vec3& a, const vec3& b) {
    const dvec3 d = dvec3(a) - dvec3(b);
    const double square = (d.x * d.x + d.y * d.y + d.z * d.z) / 3.0;
    return std::isfinite(square) ? square : 0.0;
}

/// All pixels of the part, by their places, in the order in which tiles have them.
std::vector<uint32_t> allPlaces(const shared::FrameParams& params) {
    shared::FrameKernels kernels;
    kernels.frame = params;
    std::vector<uint32_t> places(size_t{params.partWidth} * params.partHeight);
    for (uint32_t i = 0; i < places.size(); ++i)
        places[i] = static_cast<uint32_t>(placeInPart(kernels.pixelOf(i), params));
    return places;
}

/// Keeps the part of values that lie in a row of `width`.
template <class T>
void cut(std::vector<T>& values, uint32_t width, const Crop& part) {
    if (values.empty()) return;
    for (uint32_t y = 0; y < part.height; ++y)
        std::copy_n(&values[size_t{part.y + y} * width + part.x], part.width, &values[size_t{y} * part.width]);
    values.resize(part.pixels());
}

void cut(Picture& picture, const Crop& part) {
    cut(picture.radiance, picture.width, part);
    cut(picture.discarded, picture.width, part);
    cut(picture.samples, picture.width, part);
    cut(picture.levels, picture.width, part);
    cut(picture.costs, picture.width, part);
    picture.width = part.width;
    picture.height = part.height;
}

/// What goes into the time that is left, by how long the last pass took.
class Pace {
public:
    explicit Pace(const FrameOptions& options) : deadline_(options.deadline) {}

    void passBegins() { began_ = Clock::now(); }
    void passEnds(size_t pixels, uint32_t samples) {
        pixels_ = double(pixels);
        perSample_ = secondsOf(Clock::now() - began_) / samples;
    }
    /// Samples of so many pixels, at most `wanted`. A few pixels take longer than their share.
    uint32_t affordable(size_t pixels, uint32_t wanted) const {
        if (!deadline_) return wanted;
        const double perSample = caution * perSample_ * std::max(double(pixels) / pixels_, 0.1);
        const double most = std::max(secondsOf(*deadline_ - Clock::now()), 0.0) / std::max(perSample, 1e-9);
        return most < wanted ? static_cast<uint32_t>(most) : wanted;
    }

private:
    using Clock = std::chrono::steady_clock;
    static double secondsOf(Clock::duration d) { return std::chrono::duration<double>(d).count(); }

    static constexpr double caution = 1.1;
    std::optional<Clock::time_point> deadline_;
    Clock::time_point began_;
    double pixels_ = 1.0;
    double perSample_ = 0.0;  ///< of all those pixels
};

}  // namespace

FrameOptions withMargin(const FrameOptions& options) {
    FrameOptions wide = options;
    if (options.tolerance == 0.0 || !options.crop) return wide;
    uint32_t margin = 0;
    for (uint32_t samples = firstSamples; samples < options.samples; samples *= 2) ++margin;
    const Crop& part = *options.crop;
    wide.crop->x = part.x - std::min(part.x, margin);
    wide.crop->y = part.y - std::min(part.y, margin);
    wide.crop->width = std::min(part.x + part.width + margin, options.width) - wide.crop->x;
    wide.crop->height = std::min(part.y + part.height + margin, options.height) - wide.crop->y;
    return wide;
}

PixelErrors::PixelErrors(uint32_t width, uint32_t height)
    : width_(width), height_(height), means_(size_t{width} * height), changes_(means_.size()), samples_(means_.size(), 1) {}

void PixelErrors::learn(size_t place, const vec3& before, uint32_t from, const vec3& after, uint32_t to) {
    RAIG_CHECK_OP(from, <, to);
    means_[place] = after;
    samples_[place] = to;
    changes_[place] = static_cast<float>(meanSquareOf(before, after) * from / (to - from));
}

double PixelErrors::meanSquare(size_t place) const {
    const auto x = static_cast<uint32_t>(place % width_), y = static_cast<uint32_t>(place / width_);
    double changes = 0.0, weights = 0.0, contrast = 0.0;
    for (uint32_t ny = y - std::min(y, 1u); ny <= std::min(y + 1, height_ - 1); ++ny)
        for (uint32_t nx = x - std::min(x, 1u); nx <= std::min(x + 1, width_ - 1); ++nx) {
            const size_t neighbour = size_t{ny} * width_ + nx;
            const double weight = (nx == x ? 2.0 : 1.0) * (ny == y ? 2.0 : 1.0);
            if (std::isfinite(changes_[neighbour])) changes += weight * changes_[neighbour];
            weights += weight;
            contrast = std::max(contrast, meanSquareOf(means_[place], means_[neighbour]));
        }
    const double n = samples_[place];
    return changes / weights + contrast / (3.0 * n * n * n);
}

std::vector<uint32_t> PixelErrors::above(double tolerance, std::span<const uint32_t> places) const {
    std::vector<uint8_t> isAbove(places.size());
    parallelFor(places.size(), 4096, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) isAbove[i] = meanSquare(places[i]) > tolerance * tolerance;
    });
    std::vector<uint32_t> result;
    for (size_t i = 0; i < places.size(); ++i)
        if (isAbove[i]) result.push_back(places[i]);
    return result;
}

namespace {

/// Means of the sums, of the part that is wanted. `places`: the pixels that would have got more.
void finish(FramePasses& passes, const FrameOptions& options, std::span<const uint32_t> places, uint32_t samples,
            Picture& picture) {
    Crop part = options.part();
    part.x -= passes.params().left;
    part.y -= passes.params().top;
    picture.statistics.samples = samples;
    if (options.tolerance > 0.0)
        picture.statistics.unsettled = uint64_t(std::ranges::count_if(places, [&](uint32_t place) {
            const uint32_t x = place % picture.width, y = place / picture.width;
            return x - part.x < part.width && y - part.y < part.height;
        }));
    for (size_t i = 0; i < picture.radiance.size(); ++i) {
        const auto count = static_cast<float>(picture.samples.empty() ? samples : picture.samples[i]);
        picture.radiance[i] = picture.radiance[i] / count;
        picture.discarded[i] = picture.discarded[i] / count;
    }
    cut(picture, part);
    passes.finish();
}

}  // namespace

void renderInPasses(FramePasses& passes, const FrameOptions& options, Picture& picture) {
    const bool isAdaptive = options.tolerance > 0.0;
    PixelErrors errors(isAdaptive ? picture.width : 0, isAdaptive ? picture.height : 0);
    std::vector<uint32_t> places = allPlaces(passes.params());
    Pace pace(options);
    std::vector<vec3> before;
    uint32_t samples = 0;
    double work = 0.0;
    const auto begin = [&](uint32_t count) {
        samples = count;
        work = double(places.size()) * samples;
        pace.passBegins();
        passes.begin(samples, std::max(passes.shareDone(), 0.25));
        pace.passEnds(places.size(), samples);
    };
    const auto resume = [&](uint32_t more) {
        before.clear();
        if (isAdaptive)
            for (const uint32_t place : places) before.push_back(picture.radiance[place] / static_cast<float>(samples));
        // Of what is to come only so much is known that each pass goes on with no more pixels.
        const double added = double(places.size()) * more;
        const double share = std::max(passes.shareDone(), (work + added) / (work + 2.0 * added));
        pace.passBegins();
        passes.resume(places, samples, samples + more, share);
        pace.passEnds(places.size(), more);
        work += added;
        samples += more;
    };
    const auto learn = [&](uint32_t more) {
        for (size_t i = 0; i < places.size(); ++i) {
            const vec3 after = picture.radiance[places[i]] / static_cast<float>(samples);
            errors.learn(places[i], before[i], samples - more, after, samples);
            picture.samples[places[i]] = samples;
        }
        if (samples >= firstSamples) places = errors.above(options.tolerance, places);
    };
    begin(options.deadline ? 1 : firstSamples / 2);
    if (samples == 1 && options.samples > 1 && pace.affordable(places.size(), 2) == 2) begin(2);
    if (isAdaptive) picture.samples.assign(places.size(), samples);
    while (samples > 1 && samples < options.samples && !places.empty()) {
        const uint32_t wanted = std::min(samples, options.samples - samples);
        const uint32_t more = pace.affordable(places.size(), wanted);
        if (more == 0) break;
        resume(more);
        if (isAdaptive) learn(more);
        // Cut to the time that is left, it is the last: pixels are not judged after that many samples without a deadline.
        if (isAdaptive && more < wanted) break;
    }
    finish(passes, options, places, samples, picture);
}

}  // namespace raig
