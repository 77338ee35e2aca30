#include "base/error.hpp"
#include "measure/compare.hpp"
#include "measure/tasks.hpp"
#include "measure/timing.hpp"
#include "measure/trace_place.hpp"
#include "measure/trace_subject.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace raig {

namespace {

constexpr size_t comparedRays = 1u << 12;  // of each kind, compared with the yardstick's bits
constexpr uint32_t warmUps = 3, repetitions = 10;
constexpr double longRun = 0.3;  // seconds of one: of slow methods, fewer rays are timed
constexpr size_t tile = 64;      // rays of 8 x 8 pixels

double perMillion(uint64_t count, size_t of) {
    return of == 0 ? 0.0 : 1e6 * double(count) / double(of);
}

class TraceTask : public Task {
public:
    explicit TraceTask(const TaskSettings& settings) : settings_(settings) {}

    bool needsScene() const override { return true; }

    void check(const Json& settings) const override {
        checkSettings(settings, "trace",
                      {"offset", "arity", "precision", "max-leaf", "max-tree-depth", "grid-density", "levels"},
                      {"accel", "walk", "build", "bound", "rays", "check", "on"});
        const auto oneOf = [&](const char* name, const char* otherwise, std::initializer_list<const char*> known) {
            const std::string value = textOf(settings, name, otherwise);
            if (std::find(known.begin(), known.end(), value) == known.end())
                throw usageError("the setting \"{}\" takes {}", name, fmt::join(known, ", "));
        };
        oneOf("rays", "primary", {"primary", "shadow", "diffuse", "specular"});
        oneOf("check", "bits", {"bits", "reference"});
        oneOf("on", "device", {"device", "cpu"});
        if (!(std::abs(numberOf(settings, "offset", 0.0)) <= 1e15))
            throw usageError("the setting \"offset\" takes 1e15 at most");
        checkTraceSubject(settings);
    }

    Json run(const ChartScene* scene, const Json& settings) override {
        const double offset = numberOf(settings, "offset", 0.0);
        if (!place_ || place_->offset() != offset) {
            place_.reset();
            place_ = std::make_unique<TracePlace>(*scene, offset);
        }
        const TraceSubject subject = makeTraceSubject(settings, place_->geometry(), place_->primitives(), settings_.device);
        Json measures = subject.facts;
        time(subject, textOf(settings, "rays", "primary"), measures);
        const bool byReference = textOf(settings, "check", "bits") == "reference";
        judge(subject, byReference, byReference ? TracePlace::judgedRays : comparedRays, measures);
        return measures;
    }

    void forgetScene() override { place_.reset(); }

    const Json& measures() const override {
        static const Json all = {{"milliseconds", "ms per 10⁶ rays"},
                                 {"milliseconds_min", "ms per 10⁶ rays, least"},
                                 {"milliseconds_q1", "ms per 10⁶ rays, first quartile"},
                                 {"milliseconds_q3", "ms per 10⁶ rays, third quartile"},
                                 {"mrays_per_s", "10⁶ rays a second"},
                                 {"timed", "rays timed"},
                                 {"counted", "rays counted"},
                                 {"node_fetches", "node fetches a ray"},
                                 {"box_tests", "box tests a ray"},
                                 {"primitive_tests", "triangle tests a ray"},
                                 {"link_reads", "link reads a ray"},
                                 {"tests", "box and triangle tests a ray"},
                                 {"build_seconds", "s to build"},
                                 {"megabytes", "MiB"},
                                 {"bytes_per_triangle", "bytes a triangle"},
                                 {"references_per_triangle", "references a triangle"},
                                 {"nodes", "nodes"},
                                 {"sah", "SAH cost"},
                                 {"faults", "faults per 10⁶ rays"},
                                 {"missed", "missed, per 10⁶ rays"},
                                 {"phantom", "phantom, per 10⁶ rays"},
                                 {"wrong", "wrong, per 10⁶ rays"},
                                 {"aimed_faults", "faults of aimed rays, per 10⁶"},
                                 {"ties", "ties, per 10⁶ rays"},
                                 {"differing", "hits with other bits than bvh's"},
                                 {"checked", "rays judged"}};
        return all;
    }

private:
    /// One of so many tiles of the picture, evenly spread over rows and columns, as shares are odd.
    static constexpr size_t shares[] = {1, 5, 23, 101};
    static std::vector<Ray> part(const std::vector<Ray>& rays, size_t share) {
        std::vector<Ray> some;
        for (size_t begin = 0; begin < rays.size(); begin += share * tile)
            some.insert(some.end(), rays.begin() + static_cast<std::ptrdiff_t>(begin),
                        rays.begin() + static_cast<std::ptrdiff_t>(std::min(begin + tile, rays.size())));
        return some;
    }

    /// A part of the rays that takes no longer than longRun, by what a small part of them takes.
    static std::vector<Ray> fewEnough(const TraceSubject& subject, const std::vector<Ray>& rays, Query query) {
        const std::vector<Ray> least = part(rays, shares[3]);
        subject.trace(least, {}, query);  // also makes what a first trace makes
        const double all = subject.trace(least, {}, query) * double(rays.size()) / double(least.size());
        for (const size_t share : shares)
            if (all / double(share) <= longRun) return part(rays, share);
        return least;
    }

    /// A part that is the same however fast anything is: what is counted is, too.
    static std::vector<Ray> counted(const std::vector<Ray>& rays) {
        constexpr size_t enough = 2048;
        size_t share = shares[0];
        for (const size_t larger : shares)
            if (rays.size() / larger >= enough) share = larger;
        return part(rays, share);
    }

    void time(const TraceSubject& subject, const std::string& name, Json& measures) {
        const Query query = name == "shadow" ? Query::any : Query::closest;
        if (place_->rays(name).empty()) return;
        const std::vector<Ray> rays = fewEnough(subject, place_->rays(name), query);
        std::vector<double> milliseconds;
        for (uint32_t i = 0; i < warmUps + repetitions; ++i) {
            const double seconds = subject.trace(rays, {}, query);
            if (i >= warmUps) milliseconds.push_back(seconds * 1e9 / double(rays.size()));
            if (seconds > 2.0 * longRun) i += 3;  // what takes so long is less noise
        }
        const Quartiles q = quartilesOf(milliseconds);
        measures.update({{"milliseconds", q.median},
                         {"milliseconds_min", *std::min_element(milliseconds.begin(), milliseconds.end())},
                         {"milliseconds_q1", q.q1},
                         {"milliseconds_q3", q.q3},
                         {"mrays_per_s", 1e3 / q.median},
                         {"timed", rays.size()}});
        if (!subject.count) return;
        const std::vector<Ray> some = counted(place_->rays(name));
        const WalkCounters counters = subject.count(some, query);
        const auto perRay = [&](uint64_t count) { return double(count) / double(some.size()); };
        measures.update({{"node_fetches", perRay(counters.nodeFetches)},
                         {"box_tests", perRay(counters.boxTests)},
                         {"primitive_tests", perRay(counters.triangleTests)},
                         {"link_reads", perRay(counters.linkReads)},
                         {"tests", perRay(counters.boxTests + counters.triangleTests)},
                         {"counted", some.size()}});
    }

    /// Traces a batch; adds how many hits have other bits than the yardstick's, where they must not.
    static std::vector<Hit> check(const TraceSubject& subject, const TracePlace::Batch& batch, uint64_t& differing) {
        std::vector<Hit> hits(batch.rays.size());
        if (!hits.empty()) subject.trace(batch.rays, hits, Query::closest);
        for (size_t i = 0; i < hits.size(); ++i) differing += std::memcmp(&hits[i], &batch.yardstick[i], sizeof(Hit)) != 0;
        return hits;
    }

    void judge(const TraceSubject& subject, bool byReference, size_t most, Json& measures) {
        const TracePlace::Batch aimed = place_->aimed().first(most), primary = place_->primary().first(most);
        uint64_t differing = 0;
        const std::vector<Hit> aimedHits = check(subject, aimed, differing), hits = check(subject, primary, differing);
        const size_t all = aimed.rays.size() + primary.rays.size();
        measures["checked"] = all;
        if (subject.isExact) measures["differing"] = differing;
        if (!byReference) return;
        const HitComparison ofAimed = compareHits(place_->tree(), aimed.rays, aimedHits),
                            ofPrimary = compareHits(place_->tree(), primary.rays, hits);
        const auto both = [&](HitClass kind) { return perMillion(ofAimed.count(kind) + ofPrimary.count(kind), all); };
        measures.update({{"faults", perMillion(ofAimed.faultCount() + ofPrimary.faultCount(), all)},
                         {"missed", both(HitClass::missed)},
                         {"phantom", both(HitClass::phantom)},
                         {"wrong", both(HitClass::wrong)},
                         {"ties", both(HitClass::tie)},
                         {"aimed_faults", perMillion(ofAimed.faultCount(), aimed.rays.size())}});
    }

    TaskSettings settings_;
    std::unique_ptr<TracePlace> place_;
};

}  // namespace

std::unique_ptr<Task> makeTraceTask(const TaskSettings& settings) {
    return std::make_unique<TraceTask>(settings);
}

}  // namespace raig
