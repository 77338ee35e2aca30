#include "measure/picture_controls.hpp"

#include "measure/corruption.hpp"
#include "measure/hard_meshes.hpp"
#include "measure/stress_pictures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace raig {

namespace {

/// By how much the first picture of the case's scene `index` is darker than what it shows, where bounds are those given and
/// nobody tells what they cut off: in percent of `whole`.
ControlFindings darkness(const hard::PictureCase& pictureCase, size_t index, const FrameOptions& options, double whole,
                         const hard::Draw& draw) {
    hard::PictureScene scene = pictureCase.make(draw).at(index);
    scene.options = {options};
    const Picture picture = pictureSubjectOf({"bvh", {}}, nullptr).render(scene).at(0);
    double sum = 0.0;
    for (const vec3& pixel : picture.radiance) sum += 1.0 - double{pixel.x} / whole;
    return {.rays = picture.radiance.size(), .measured = 100.0 * sum / double(picture.radiance.size())};
}

/// Case 52: mirrors of reflectance `k`, the case's scene `index`, which glow with a radiance of 0.25.
Control depthControl(const char* method, double rate, size_t index, double k, uint32_t depth) {
    const auto run = [=](const hard::Draw& draw) {
        FrameOptions options;
        options.width = options.height = 16;
        options.samples = 1;
        options.maxDepth = depth;
        options.minContribution = 0.0f;
        return darkness(hard::recursionCases().at(0), index, options, 0.25 / (1.0 - k), draw);
    };
    return {52, method, rate, rate, run, 1, false, "% of the light"};
}

/// Case 53: panes that divide light in two, eight times.
ControlFindings withoutBound(const hard::Draw& draw) {
    FrameOptions options;
    options.width = options.height = 16;
    options.samples = 1;
    options.maxDepth = 8;
    options.minContribution = 1.0f / 255.0f;
    return darkness(hard::recursionCases().at(1), 2, options, 1.0, draw);
}

/// Case 54: of rays in glass that meet its surface from within at more than the critical angle, those that Snell's law, put
/// down without asking whether there is a way out, sends nowhere.
ControlFindings bentWithoutAsking(const hard::Draw& draw) {
    Random random = draw.random(110);
    const float eta = 1.5f;
    ControlFindings findings;
    for (int i = 0; i < 4000; ++i) {
        const dvec3 d = random.direction();
        const auto cosine = static_cast<float>(std::abs(d.z));
        const float k = 1.0f - eta * eta * (1.0f - cosine * cosine);
        if (double{eta} * eta * (1.0 - d.z * d.z) <= 1.0) continue;
        ++findings.rays;
        findings.phantom += std::isnan(eta * cosine - std::sqrt(k));
    }
    return findings;
}

/// Case 61: mix(a, infinity, 0) as it is defined: a (1 - t) + b t. That of `a` is asked for, and is no number.
ControlFindings mixedByDefinition(const hard::Draw& draw) {
    Random random = draw.random(111);
    const volatile float infinity = std::numeric_limits<float>::infinity(), share = 0.0f;
    ControlFindings findings;
    for (int i = 0; i < 1000; ++i) {
        const auto a = static_cast<float>(random.unit());
        ++findings.rays;
        findings.wrong += !(a * (1.0f - share) + infinity * share == a);
    }
    return findings;
}

/// Case 62: the links of a hierarchy, led around, followed by who trusts them: from one node that is missed to the next.
ControlFindings withoutEnd(const hard::Draw&) {
    Structure structure = structureType("bvh").build(hard::sphere(12, 1.0, dvec3(0), 0.1), {.walk = "skip"});
    const uint32_t nodes = structure.header.nodeCount;
    leadAround(structure);
    ControlFindings findings;
    for (uint32_t start = 0; start < nodes; ++start) {
        if (structure.nodes[2 * size_t{start}].w >= 0x80000000u) continue;  // a leaf
        uint32_t at = start, steps = 0;
        while (at < nodes && steps < 4 * nodes) {
            const uint32_t link = structure.nodes[2 * size_t{at}].w;
            at = link >= 0x80000000u ? at + 1 : link;
            ++steps;
        }
        ++findings.rays;
        findings.hung += at < nodes;
    }
    return findings;
}

}  // namespace

std::vector<Control> pictureControls() {
    return {
        depthControl("NIVELL_MAX 8 and no bound told, K 0.9", 39.0, 1, 0.9, 8),
        depthControl("NIVELL_MAX 15 and no bound told, K 0.9", 19.0, 1, 0.9, 15),
        depthControl("NIVELL_MAX 8 and no bound told, K 0.5", 0.2, 0, 0.5, 8),
        {53, "MIN_CONTRIB 1/255 and no bound told", 100.0, 100.0, withoutBound, 1, false, "% of the light"},
        {54, "Snell's law where nothing can leave", 0, 0, bentWithoutAsking},
        {61, "mix(a, infinity, 0) as it is defined", 100.0, 100.0, mixedByDefinition},
        {62, "links followed without counting", 0, 0, withoutEnd},
    };
}

}  // namespace raig
