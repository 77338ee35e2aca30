// `raig trace`: a batch of rays from one NumPy file to hits in another.
#include "app/commands.hpp"
#include "app/counters_json.hpp"
#include "app/setup.hpp"
#include "base/error.hpp"
#include "base/log.hpp"
#include "rays/npy.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>
#include <cstring>

namespace raig {

namespace {

std::vector<Ray> readRays(const std::filesystem::path& path) {
    const NpyFloats floats = readNpyFloats(path, sizeof(Ray) / sizeof(float));
    std::vector<Ray> rays(floats.rows);
    if (!rays.empty()) std::memcpy(rays.data(), floats.values.data(), floats.values.size() * sizeof(float));
    return rays;
}

/// Hits as users know them: triangles by instance and number within its mesh.
std::vector<NpyHit> placed(const std::vector<Hit>& hits, const Geometry& geometry) {
    std::vector<NpyHit> result;
    result.reserve(hits.size());
    for (const Hit& hit : hits) {
        NpyHit out{hit.t, hit.u, hit.v, NO_HIT, NO_HIT};
        if (hit.primitive != NO_HIT) {
            const Geometry::Place place = geometry.place(hit.primitive);
            out.primitive = place.primitive;
            out.instance = place.instance;
        }
        result.push_back(out);
    }
    return result;
}

}  // namespace

int trace(const Options& options) {
    const std::vector<Ray> rays = readRays(options.rays);
    const std::unique_ptr<Setup> setup = prepare(options, options.inputs.front());
    std::vector<Hit> hits(rays.size());
    const TraceReport report = setup->tracer->trace(rays, hits, options.query);
    writeNpyHits(options.hits, placed(hits, setup->geometry));

    const auto hitCount = std::count_if(hits.begin(), hits.end(), [](const Hit& h) { return h.primitive != NO_HIT; });
    const double megaRays = static_cast<double>(rays.size()) * 1e-6 / std::max(report.seconds, 1e-9);
    log::note("rays: {} traced in {:.3f} s ({:.2f} Mrays/s), {} hit", rays.size(), report.seconds, megaRays, hitCount);
    if (!options.json) return static_cast<int>(ExitCode::done);

    nlohmann::ordered_json json = {{"rays", rays.size()},
                                   {"hits", hitCount},
                                   {"device", setup->deviceName()},
                                   {"structure", setup->structure.name},
                                   {"walk", setup->structure.walk},
                                   {"instances", setup->structure.instances},
                                   {"structure_bytes", setup->structure.statistics.bytes},
                                   {"build_s", setup->buildSeconds},
                                   {"load_s", setup->loadSeconds},
                                   {"upload_s", setup->uploadSeconds + report.uploadSeconds},
                                   {"trace_s", report.seconds},
                                   {"device_s", report.deviceSeconds},
                                   {"mrays_per_s", megaRays},
                                   {"counters", nullptr}};
    if (options.counters || !setup->device) json["counters"] = toJson(report.counters);
    std::printf("%s\n", json.dump(2).c_str());
    return static_cast<int>(ExitCode::done);
}

}  // namespace raig
