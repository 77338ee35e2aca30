// Every structure, with every value of every option, on every device, over every soup and family of rays: the bits that
// brute force has on the CPU.
#include "rays/tracer.hpp"
#include "support/devices.hpp"
#include "support/effort.hpp"
#include "support/soups.hpp"
#include "support/variants.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cstring>

namespace raig {
namespace {

using test::Soup;
using test::Variant;

std::string describe(const Hit& h) {
    return fmt::format("triangle {} t {:.9g} u {:.9g} v {:.9g}", static_cast<int32_t>(h.primitive), h.t, h.u, h.v);
}

std::vector<Hit> trace(Tracer& tracer, const std::vector<Ray>& rays, Query query) {
    std::vector<Hit> hits(rays.size());
    tracer.trace(rays, hits, query);
    return hits;
}

/// Triangles, rays, and what these hit by brute force on the CPU.
struct Task {
    Soup soup;
    std::vector<Ray> rays;
    std::vector<Hit> want;
};

Task taskOf(const Soup& soup, std::vector<Ray> rays) {
    const Structure brute = structureType("brute").build(soup.triangles, {});
    std::vector<Hit> want = trace(*makeCpuTracer(brute), rays, Query::closest);
    const auto hits = std::count_if(want.begin(), want.end(), [](const Hit& hit) { return hit.primitive != NO_HIT; });
    EXPECT_TRUE(soup.triangles.size() <= 2 || static_cast<size_t>(hits) > rays.size() / 50)
        << soup.name << ": the rays test nothing";
    return {soup, std::move(rays), std::move(want)};
}

/// Expects the bits of brute force, and any hit exactly where there is a closest one.
void expectAsBruteForce(const Task& task, const Variant& variant, Tracer& tracer) {
    const std::vector<Hit> got = trace(tracer, task.rays, Query::closest), any = trace(tracer, task.rays, Query::any);
    for (size_t i = 0; i < task.rays.size(); ++i) {
        ASSERT_EQ(std::memcmp(&got[i], &task.want[i], sizeof(Hit)), 0)
            << variant << ", " << task.soup.name << " ray " << i << ' ' << test::describe(task.rays[i]) << "\n got "
            << describe(got[i]) << "\nwant " << describe(task.want[i]);
        ASSERT_EQ(any[i].primitive == NO_HIT, got[i].primitive == NO_HIT)
            << variant << ", " << task.soup.name << ' ' << test::describe(task.rays[i]);
    }
}

class EverySoup : public testing::TestWithParam<Soup> {};

// On the CPU: some 100,000 rays a structure, a million in a long run.
TEST_P(EverySoup, IsHitAsByBruteForceWithEveryVariant) {
    const size_t count = test::isLong() ? 60'000 : test::affordable(2400);
    const Task task = taskOf(GetParam(), test::rays(GetParam().triangles, /* seed= */ 7, count));
    for (const Variant& variant : test::allVariants()) {
        const Structure structure = variant.build(task.soup.triangles);
        expectAsBruteForce(task, variant, *makeCpuTracer(structure));
    }
}

std::string soupName(const testing::TestParamInfo<Soup>& soup) {
    std::string name = soup.param.name;
    std::replace(name.begin(), name.end(), ' ', '_');
    return name;
}

INSTANTIATE_TEST_SUITE_P(, EverySoup, testing::ValuesIn(test::soups()), soupName);

/// The soups of about the same size in one place each, four in a row, with the rays of all of them.
Task allInOne(size_t raysEach) {
    Soup all{"all in one", {}};
    std::vector<Ray> rays;
    float place = 0.0f;
    for (const Soup& soup : test::soups()) {
        Box box;
        for (const Triangle& t : soup.triangles)
            if (t.usable()) box.grow(t.box());
        const float size = box.empty() ? 0.0f : glm::length(box.extent());
        if (size < 0.1f || size > 10.0f || glm::length(box.centre()) > 10.0f) continue;
        // Whole numbers: so what lies on fractions of two still does.
        const vec3 offset(8.0f * std::fmod(place, 4.0f), 8.0f * std::floor(place / 4.0f), 16.0f);
        place += 1.0f;
        for (Triangle t : soup.triangles) {
            t.a += offset;
            if (!t.isSphere()) t.b += offset, t.c += offset;
            all.triangles.push_back(t);
        }
        for (Ray ray : test::rays(soup.triangles, /* seed= */ 9, raysEach)) {
            ray.origin += offset;
            rays.push_back(ray);
        }
    }
    EXPECT_GE(place, 10.0f);
    return taskOf(all, std::move(rays));
}

/// A device and a structure, by their names.
class EveryStructure : public testing::TestWithParam<std::tuple<std::string, std::string>> {
protected:
    void SetUp() override {
        const std::optional<DeviceInfo> found = findDevice(std::get<0>(GetParam()));
        if (!found) GTEST_SKIP() << "no Vulkan device named " << std::get<0>(GetParam()) << " here";
        device_ = std::make_unique<Device>(*found);
        for (const Variant& variant : test::allVariants())
            if (variant.structure == std::get<1>(GetParam())) variants_.push_back(variant);
    }
    void TearDown() override {
        device_.reset();
        for (const std::string& message : validationMessages()) ADD_FAILURE() << message;
    }
    void check(const Task& task, const Variant& variant) {
        const Structure structure = variant.build(task.soup.triangles);
        expectAsBruteForce(task, variant, *makeDeviceTracer(*device_, structure));
    }

    std::unique_ptr<Device> device_;
    std::vector<Variant> variants_;
};

// A short run has one scene of all soups for every variant, and for a few also scenes of other sizes, which are not in it. A
// long run has all soups for every variant, and a million rays.
TEST_P(EveryStructure, IsWalkedAsByBruteForce) {
    const Task all = allInOne(test::isLong() ? 2000 : test::affordable(250));
    for (const Variant& variant : variants_) check(all, variant);
    const std::vector<std::string> few = {"far", "tiny", "huge", "stadium"};
    const std::vector<Soup> soups = test::soups();
    const size_t million = 1'000'000 / (2 * soups.size() * variants_.size()) + 1;
    const size_t count = test::isLong() ? million : test::affordable(500);
    for (const Soup& soup : soups) {
        if (!test::isLong() && std::find(few.begin(), few.end(), soup.name) == few.end()) continue;
        const Task task = taskOf(soup, test::rays(soup.triangles, /* seed= */ 9, count));
        for (size_t k = 0; k < variants_.size(); ++k)
            if (test::isLong() || k < few.size()) check(task, variants_[k]);
    }
}

std::vector<std::string> structureNames() {
    std::vector<std::string> names;
    for (const StructureType& type : structureTypes()) names.emplace_back(type.name);
    return names;
}

INSTANTIATE_TEST_SUITE_P(, EveryStructure,
                         testing::Combine(testing::ValuesIn(devicesToTest()), testing::ValuesIn(structureNames())),
                         [](const auto& info) {
                             std::string name = std::get<0>(info.param) + '_' + std::get<1>(info.param);
                             std::replace_if(
                                 name.begin(), name.end(), [](unsigned char c) { return !std::isalnum(c); }, '_');
                             return name;
                         });

}  // namespace
}  // namespace raig
