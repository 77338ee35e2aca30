#include "app/compare_json.hpp"

#include "measure/compare_bounds.hpp"
#include "measure/junit.hpp"

namespace raig {

namespace {

using Json = nlohmann::ordered_json;

Json toJson(const Spread& spread) {
    return {{"median", spread.median}, {"p99", spread.p99}, {"max", spread.max}};
}

Json toJson(const UlpHistogram& histogram) {
    Json buckets = Json::array();
    for (size_t i = 0; i < UlpHistogram::buckets; ++i)
        if (histogram.counts[i] > 0)
            buckets.push_back(
                {{"from", UlpHistogram::lowest(i)}, {"to", UlpHistogram::highest(i)}, {"rays", histogram.counts[i]}});
    return buckets;
}

Json countsOf(const HitComparison& c) {
    Json counts;
    for (size_t i = 0; i < c.counts.size(); ++i) counts[std::string(hitClassNames[i])] = c.counts[i];
    return counts;
}

Json toJson(const vec3& v) {
    return {v.x, v.y, v.z};
}

Json toJson(const Ray& ray) {
    return {{"origin", toJson(ray.origin)}, {"t_min", ray.tMin}, {"direction", toJson(ray.direction)}, {"t_max", ray.tMax}};
}

/// Null where nothing is hit.
Json toJson(const Hit& hit) {
    if (hit.primitive == NO_HIT) return nullptr;
    return {{"primitive", hit.primitive}, {"t", hit.t}, {"u", hit.u}, {"v", hit.v}};
}

Json toJson(const reference::Hit& hit) {
    if (hit.primitive == reference::noTriangle) return nullptr;
    return {{"primitive", hit.primitive}, {"t", hit.t}, {"u", hit.u}, {"v", hit.v}};
}

Json toJson(const std::optional<Placed<HitComparison::Difference>>& first) {
    if (!first) return nullptr;
    const HitComparison::Difference& d = first->difference;
    Json json = {{"family", first->family}, {"level", first->level}, {"ray", d.ray}};
    json["class"] = hitClassNames[static_cast<uint32_t>(d.kind)];
    json.update(toJson(d.floats));
    json["device"] = toJson(d.device);
    json["reference"] = toJson(d.oracle);
    return json;
}

Json toJson(const std::optional<Placed<BitComparison::Difference>>& first) {
    if (!first) return nullptr;
    const BitComparison::Difference& d = first->difference;
    Json json = {{"family", first->family}, {"level", first->level}, {"ray", d.ray}};
    json.update(toJson(d.floats));
    json["device"] = toJson(d.device);
    json["cpu"] = toJson(d.cpu);
    return json;
}

Json familiesOf(const SceneComparison& scene) {
    Json families;
    for (const RayFamily& family : scene.families) {
        const HitComparison& hits = family.hits;
        families[std::string(family.name)] = {
            {"level", family.level},        {"rays", hits.rays()},        {"met", hits.met},
            {"hits", countsOf(hits)},       {"t_ulp", toJson(hits.tUlp)}, {"t_ulp_histogram", toJson(hits.tUlps)},
            {"offset", toJson(hits.offset)}};
    }
    return families;
}

/// Null where the device is the CPU.
Json bitsOf(const SceneComparison& scene) {
    if (!scene.bits) return nullptr;
    return {{"rays", scene.bits->rays},
            {"different", scene.bits->different},
            {"other_ids", scene.bits->otherIds},
            {"t_ulp_max", scene.bits->tUlpMax},
            {"ieee", scene.isIeee},
            {"first", toJson(firstBitDifference(scene.families))}};
}

}  // namespace

Json toJson(const PictureDifference& d) {
    Json json;
    for (const auto& [name, value] : valuesOf(d)) json[std::string(name)] = value;
    json["nan"] = d.nan;
    json["compared"] = d.pixels;
    return json;
}

Json toJson(const SceneComparison& scene) {
    Json pixels = toJson(scene.pixels.outsideTies);
    pixels["ties"] = scene.pixels.ties;
    pixels["blank"] = scene.pixels.blank;
    pixels["with_ties"] = toJson(scene.pixels.everywhere);
    return {{"hits", countsOf(scene.all)},
            {"t_ulp", toJson(scene.all.tUlp)},
            {"t_ulp_histogram", toJson(scene.all.tUlps)},
            {"offset", toJson(scene.all.offset)},
            {"first_difference", toJson(firstDifference(scene.families))},
            {"device_vs_cpu", bitsOf(scene)},
            {"families", familiesOf(scene)},
            {"pixels", pixels},
            {"discarded_weight", {{"mean", scene.discardedMean}, {"max", scene.discardedMax}}},
            {"device_s", scene.deviceSeconds},
            {"reference_s", scene.referenceSeconds}};
}

Json toJson(std::span<const CheckedBound> bounds) {
    Json list = Json::array();
    for (const CheckedBound& one : bounds) {
        Json entry = {{"metric", one.bound.metric->name}, {"value", one.value}};
        entry[one.bound.metric->largerIsBetter ? "at_least" : "at_most"] = one.bound.limit;
        entry["kept"] = one.isKept();
        list.push_back(entry);
    }
    return list;
}

std::string toJUnit(const std::string& subject, std::span<const CheckedBound> bounds,
                    std::span<const std::string> failures) {
    std::vector<JUnitCase> cases;
    for (size_t i = 0; i < bounds.size(); ++i) cases.push_back({"compare." + subject, bounds[i].text(), 0.0, failures[i]});
    return junitXml("raig compare", cases);
}

}  // namespace raig
