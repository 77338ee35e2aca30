// Hard case 62: links that lead around, forged in a structure that was sound when it was built. Tracers must say so and not
// hang, on the CPU and on devices, whatever is asked.
#include "measure/corruption.hpp"
#include "rays/cpu_walk.hpp"
#include "rays/tracer.hpp"
#include "support/devices.hpp"
#include "support/soups.hpp"
#include "support/variants.hpp"

#include <gtest/gtest.h>

namespace raig {
namespace {

using test::Variant;

class Corrupt : public testing::Test {
protected:
    const std::vector<Triangle> triangles = test::sphere(12, 1.0, dvec3(0), 0.1);
    const std::vector<Ray> rays = test::rays(triangles, /* seed= */ 4, /* count= */ 300);
    std::vector<Hit> hits = std::vector<Hit>(300);
};

TEST_F(Corrupt, LinksAreNoticedOnTheCpu) {
    size_t forged = 0;
    for (const Variant& variant : test::walkVariants()) {
        Structure structure = variant.build(triangles);
        if (!leadAround(structure)) continue;
        ++forged;
        const auto tracer = makeCpuTracer(structure);
        EXPECT_NE(structureType(variant.structure).findFault(structure, triangles), std::nullopt) << variant;
        EXPECT_THROW(tracer->trace(rays, hits, Query::closest), CorruptStructure) << variant;
        // Whatever is hit first may end the walk before it goes around: but it ends.
        const std::vector<Ray> misses(rays.size(), {vec3(3, 0.1f, 0.2f), 0.0f, vec3(-1, 0, 0), 1e-3f});
        try {
            tracer->trace(misses, hits, Query::any);
        } catch (const CorruptStructure& error) {
            EXPECT_NE(std::string(error.what()).find(variant.structure + " structure is corrupt"), std::string::npos);
        }
    }
    EXPECT_GE(forged, 10u);
}

class CorruptOnDevices : public OnEveryDevice {};

TEST_P(CorruptOnDevices, LinksAreNoticed) {
    Device device(info);
    const std::vector<Triangle> triangles = test::sphere(12, 1.0, dvec3(0), 0.1);
    const std::vector<Ray> rays = test::rays(triangles, /* seed= */ 4, /* count= */ 100);
    std::vector<Hit> hits(rays.size());
    for (const StructureType& type : structureTypes()) {
        Structure structure = type.build(triangles, {});
        if (!leadAround(structure)) continue;
        EXPECT_THROW(makeDeviceTracer(device, structure)->trace(rays, hits, Query::closest), CorruptStructure) << type.name;
    }
}

INSTANTIATE_TEST_SUITE_P(, CorruptOnDevices, testing::ValuesIn(devicesToTest()), testName);

}  // namespace
}  // namespace raig
