// `raig render`: a picture of a scene.
#include "app/animation_options.hpp"
#include "app/aov_layers.hpp"
#include "app/aov_options.hpp"
#include "app/commands.hpp"
#include "app/integrator_options.hpp"
#include "app/progress.hpp"
#include "app/sampling_options.hpp"
#include "app/setup.hpp"
#include "app/tone_options.hpp"
#include "app/view_options.hpp"
#include "base/error.hpp"
#include "base/files.hpp"
#include "base/log.hpp"
#include "image/image.hpp"
#include "rays/economy.hpp"
#include "rays/frame.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>

namespace raig {

namespace {

using Clock = std::chrono::steady_clock;

struct Discarded {
    double mean = 0.0;
    double worst = 0.0;
    size_t worstPixel = 0;
};

Discarded measureDiscarded(const Picture& picture) {
    Discarded result;
    for (size_t i = 0; i < picture.discarded.size(); ++i) {
        result.mean += picture.discarded[i] / double(picture.discarded.size());
        if (picture.discarded[i] > result.worst) result = {result.mean, picture.discarded[i], i};
    }
    return result;
}

double raysTraced(const FrameStatistics& statistics) { return double(statistics.closestRays + statistics.shadowRays); }

bool isWanted(const Options& options, Aov aov) {
    return options.view == aov || std::ranges::find(options.aovs, aov) != options.aovs.end();
}

/// What light shows is left out where another view is wanted and nothing else is known from it.
bool needsPicture(const Options& options) {
    return !options.view || std::ranges::any_of(aovTypes(), [&](const AovType& type) {
        return type.isOfPicture && isWanted(options, type.aov);
    });
}

FrameOptions frameOptionsOf(const Options& options, Clock::time_point start, Setup& setup) {
    FrameOptions frame = frameOptions(options, setup.scene, usualSamples);
    setIntegrator(options, setup, frame);
    if (needsPicture(options)) setSampling(options, setup.scene, start, frame);
    frame.keepsLevels = isWanted(options, Aov::level);
    frame.countsCosts = isWanted(options, Aov::cost);
    return frame;
}

Picture makePicture(const Setup& setup, FrameOptions frame, Primary primary) {
    if (primary == Primary::raster) frame.itemsOf = &setup.structure;
    Progress progress("render");
    return setup.device ? renderPicture(*setup.device, setup.scene, setup.geometry, *setup.deviceTracer, frame,
                                        progress.callback())
                        : renderPicture(setup.scene, setup.geometry, *setup.tracer, frame, progress.callback());
}

bool needsHits(const Options& options) {
    return std::ranges::any_of(aovTypes(), [&](const AovType& type) {
        return !type.isOfPicture && isWanted(options, type.aov);
    });
}

PrimaryHits makeHits(const Setup& setup, const FrameOptions& frame) {
    return setup.device ? findPrimaryHits(*setup.device, setup.scene, setup.geometry, *setup.deviceTracer, frame)
                        : findPrimaryHits(setup.scene, setup.geometry, *setup.tracer, frame);
}

Image imageOf(Picture& picture) {
    Image image;
    image.width = picture.width;
    image.height = picture.height;
    image.pixels = std::move(picture.radiance);
    return image;
}

/// Writes the picture, and AOVs as its layers or beside it. Returns how many of its pixels are not finite.
uint64_t writeAll(const Options& options, const Image& image, const AovSources& sources, const Notes& notes) {
    std::vector<Layer> layers;
    for (const Aov aov : options.aovs) layers.push_back(layerOf(aov, sources));
    const std::vector<std::filesystem::path> files = aovFiles(options);
    for (size_t i = 0; i < files.size(); ++i)
        writeFileAtomically(files[i],
                            encodeLayers(image.width, image.height, {}, std::span(layers).subspan(i, 1), notes));
    if (layers.empty() || !files.empty()) return writePicture(options.output, image, notes);
    writeFileAtomically(options.output, encodeLayers(image.width, image.height, image.pixels, layers, notes));
    return countNonFinite(image);
}

/// What is done to light to show it; nothing where another view is shown.
struct Shown {
    double stops = 0.0;
    Tone tone = Tone::none;
};

Notes notesOf(const Options& options, const FrameOptions& frame, const Setup& setup, const Picture& picture,
              const Shown& shown) {
    Notes notes = {{"Software", "raig"},
                   {"Scene", options.inputs.front().filename().string()},
                   {"Recursion", fmt::format("NIVELL_MAX {}, MIN_CONTRIB {}", frame.maxDepth, options.minContribution)},
                   {"Integrator", integratorText(frame)},
                   {"Samples", samplingText(frame, picture)},
                   {"Structure", setup.structure.name}};
    if (frame.filter != Filter::box) notes.emplace_back("Filter", nameOf(frame.filter));
    if (options.view) notes.emplace_back("Shows", typeOf(*options.view).name);
    if (options.moment.seconds) notes.emplace_back("Time", fmt::format("{} s", *options.moment.seconds));
    if (frame.aperture > 0.0f)
        notes.emplace_back("Lens", fmt::format("aperture {}, in focus at {}", frame.aperture, frame.focus));
    if (const std::optional<Crop>& c = frame.crop)
        notes.emplace_back("Part", fmt::format("{} x {} pixels from ({}, {}) on of {} x {}", c->width, c->height, c->x, c->y,
                                               frame.width, frame.height));
    if (shown.stops != 0.0 || shown.tone != Tone::none)
        notes.emplace_back("Light", fmt::format("times 2^{:.9g}, curve {}", shown.stops, nameOf(shown.tone)));
    return notes;
}

void describe(const Picture& picture, const FrameOptions& frame, const Discarded& discarded) {
    const Crop part = frame.part();
    const FrameStatistics& s = picture.statistics;
    if (frame.integrator != Integrator::whitted) log::note("integrator: {}", integratorText(frame));
    log::note(
        "picture: {} x {} in {:.3f} s ({:.3f} s of it to set up): {:.2f} Mrays, {:.2f} Mrays/s while tracing, depth {}",
        picture.width, picture.height, s.seconds, s.setupSeconds, raysTraced(s) * 1e-6,
        raysTraced(s) * 1e-6 / std::max(s.traceSeconds, 1e-9), s.deepest);
    if (frame.deadline && frame.tolerance == 0.0)
        log::note("samples: {} a pixel went into the time; --spp {} gives the same picture", frame.samples, frame.samples);
    if (frame.tolerance > 0.0)
        log::note("samples: {}; {} pixels may be farther off", samplingText(frame, picture), s.unsettled);
    if (s.hintedRays > 0)
        log::note("item buffer: {} triangles drawn in {:.3f} s; {} of {} camera rays met something else ({:.2f} %)",
                  s.drawnTriangles, s.drawSeconds, s.fallbacks, s.hintedRays,
                  100.0 * double(s.fallbacks) / double(s.hintedRays));
    log::note("discarded weight: {:.2e} on average, {:.2e} at worst, in pixel ({}, {})", discarded.mean, discarded.worst,
              part.x + discarded.worstPixel % part.width, part.y + discarded.worstPixel / part.width);
    if (s.openMaterials > 0)
        log::note("remark: {} materials of glass that other things lie in or about are not closed, or beyond the first 255: "
                  "each is taken to part what is around it from what it holds, whatever lies in it",
                  s.openMaterials);
    if (s.forgottenMedia > 0)
        log::warn("rays were in more than 4 things of glass at once, {} times: the outermost was forgotten",
                  s.forgottenMedia);
}

nlohmann::ordered_json toJson(const Setup& setup, const FrameOptions& frame, const Picture& picture,
                              const Discarded& discarded) {
    const FrameStatistics& s = picture.statistics;
    const StructureStatistics& built = setup.structure.statistics;
    const Crop part = frame.part();
    return {{"device", setup.deviceName()},
            {"triangles", setup.geometry.triangleCount()},
            {"spheres", setup.geometry.spheres.size()},
            {"instances", setup.scene.instances.size()},
            {"dropped",
             {{"non_finite", setup.geometry.dropped.nonFinite},
              {"zero_area", setup.geometry.dropped.zeroArea},
              {"other", setup.geometry.dropped.other}}},
            {"structure",
             {{"name", setup.structure.name},
              {"walk", setup.structure.walk},
              {"nodes", built.nodes},
              {"depth", built.depth},
              {"references", built.references},
              {"instances", setup.structure.instances},
              {"bytes", built.bytes},
              {"bytes_per_triangle", setup.bytesPerTriangle()}}},
            {"width", frame.width},
            {"height", frame.height},
            {"crop", {{"x", part.x}, {"y", part.y}, {"width", part.width}, {"height", part.height}}},
            {"integrator", integratorNames[static_cast<size_t>(frame.integrator)]},
            {"samples", frame.samples},
            {"filter", nameOf(frame.filter)},
            {"max_depth", frame.maxDepth},
            {"min_contribution", frame.minContribution},
            {"seed", frame.seed},
            {"import_s", setup.importSeconds},
            {"build_s", setup.buildSeconds},
            {"load_s", setup.loadSeconds},
            {"upload_s", setup.uploadSeconds},
            {"render_s", s.seconds},
            {"trace_s", s.traceSeconds},
            {"closest_rays", s.closestRays},
            {"shadow_rays", s.shadowRays},
            {"spared_shadow_rays", s.spared},
            {"mrays_per_s", raysTraced(s) * 1e-6 / std::max(s.traceSeconds, 1e-9)},
            {"deepest", s.deepest},
            {"forgotten_media", s.forgottenMedia},
            {"tiles", s.tiles},
            {"discarded_weight", {{"mean", discarded.mean}, {"max", discarded.worst}}},
            {"remarks", setup.scene.remarks}};
}

nlohmann::ordered_json primaryOf(const Options& options, const FrameStatistics& s) {
    if (options.primary == Primary::ray) return {{"by", "ray"}};
    return {{"by", "raster"},       {"rays", s.hintedRays},          {"fallbacks", s.fallbacks},
            {"draw_s", s.drawSeconds}, {"triangles", s.drawnTriangles}};
}

/// What was not modelled, and not traced.
void describeSavings(const Setup& setup, Integrator integrator, const Picture& picture) {
    for (const std::string& line : describe(measureEconomy(setup.scene, setup.geometry, integrator)))
        log::note("economy: {}", line);
    const FrameStatistics& s = picture.statistics;
    if (s.spared > 0)
        log::note("economy: {} shadow rays of {} were not traced, as nothing was met, or they could have added nothing",
                  s.spared, s.spared + s.shadowRays);
}

void addAovs(const Options& options, const AovView& view, nlohmann::ordered_json& document) {
    document["aovs"] = nlohmann::json::array();
    for (const Aov aov : options.aovs) document["aovs"].push_back(typeOf(aov).name);
    if (!options.view) return;
    document["view"] = {{"name", typeOf(*options.view).name}};
    if (view.range) document["view"].update({{"min", view.range->first}, {"max", view.range->second}});
}

/// Renders the scene that was prepared, as `options` say, writes the picture and tells of it. What --json prints of it.
/// The exposure of `options`, and how far ambient occlusion looks, become what was taken, whoever chose it.
/// `start`: when the picture's time began.
nlohmann::ordered_json renderOne(Options& options, Clock::time_point start, Setup& setup) {
    FrameOptions frame = frameOptionsOf(options, start, setup);
    Picture picture;
    PrimaryHits hits;
    if (needsPicture(options)) picture = makePicture(setup, frame, options.primary);
    if (needsPicture(options)) frame.samples = picture.statistics.samples;  // fewer where time was short
    if (needsHits(options)) hits = makeHits(setup, frame);
    const Crop part = frame.part();
    const AovSources sources{part.width, part.height, frame.samples, picture, hits};
    AovView view = options.view ? viewOf(*options.view, sources) : AovView{imageOf(picture), std::nullopt};
    const uint64_t nonFiniteLight = countNonFinite(view.image);
    Shown shown;
    if (!options.view) shown = {showLight(options, view.image), options.tone};
    const uint64_t nonFinite =
        std::max(nonFiniteLight, writeAll(options, view.image, sources, notesOf(options, frame, setup, picture, shown)));
    if (nonFinite > 0) log::warn("{}: {} pixels are not finite", options.output.string(), nonFinite);

    const Discarded discarded = measureDiscarded(picture);
    if (needsPicture(options)) describe(picture, frame, discarded);
    if (options.seconds && picture.statistics.seconds > 1.5 * *options.seconds)
        log::warn("--time {}: the picture took {:.1f} s; it has {} samples a pixel, and one at least", *options.seconds,
                  picture.statistics.seconds, frame.samples);
    if (options.verbose && needsPicture(options)) describeSavings(setup, frame.integrator, picture);
    if (view.range)
        log::note("view: {} from {:.6g} to {:.6g}", typeOf(*options.view).name, view.range->first, view.range->second);
    if (frame.integrator == Integrator::ao) options.aoDistance = frame.reach;
    const bool isBlack = options.exposure == Exposure::suitable && shown.stops == 0.0;  // as far as can be told
    if (!options.view && !isBlack) {
        options.exposure = Exposure::stops;
        options.stops = shown.stops;
    }
    if (!options.json) return {};
    nlohmann::ordered_json document = toJson(setup, frame, picture, discarded);
    addSampling(frame, picture, document);
    if (frame.integrator == Integrator::ao) document["ao_distance"] = frame.reach;  // null: no end
    document["output"] = options.output.string();
    document["time"] = options.moment.seconds ? nlohmann::json(*options.moment.seconds) : nlohmann::json(nullptr);
    document["exposure"] = shown.stops;
    document["tonemap"] = nameOf(shown.tone);
    document["primary"] = primaryOf(options, picture.statistics);
    addAovs(options, view, document);
    document["non_finite_pixels"] = nonFinite;
    return document;
}

/// A picture of each frame. The exposure, and how far ambient occlusion looks, that are found for the first hold for all, or
/// they would flicker.
nlohmann::ordered_json renderFrames(const Options& options, Clock::time_point start, Setup& setup) {
    Options each = options;
    nlohmann::ordered_json documents = nlohmann::ordered_json::array();
    const auto [first, last] = *options.frames;
    for (uint32_t frame = first; frame <= last; ++frame) {
        if (frame > first) start = Clock::now();
        if (frame > first) moveTo(setup, options, frame);
        each.output = fileOf(options.output, frame);
        each.moment.seconds = secondsOf(options, frame);
        documents.push_back(renderOne(each, start, setup));
        log::note("frame {} ({} of {}): at {:.4g} s, {}", frame, frame - first + 1, last - first + 1, *each.moment.seconds,
                  each.output.string());
    }
    return {{"frames", documents}};
}

}  // namespace

int render(const Options& options) {
    const Clock::time_point start = Clock::now();
    const std::unique_ptr<Setup> setup = prepare(options, options.inputs.front());
    Options one = options;
    const nlohmann::ordered_json document =
        options.frames ? renderFrames(options, start, *setup) : renderOne(one, start, *setup);
    if (options.json) std::puts(document.dump(2, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
    return static_cast<int>(ExitCode::done);
}

}  // namespace raig
