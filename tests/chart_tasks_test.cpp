// What charts measure: where something is known of the answer, it is found.
#include "base/error.hpp"
#include "base/random.hpp"
#include "measure/hard_meshes.hpp"
#include "measure/naive_bvh.hpp"
#include "measure/precision.hpp"
#include "measure/tasks.hpp"
#include "measure/trace_place.hpp"
#include "scene/import.hpp"

#include <gtest/gtest.h>

namespace raig {
namespace {

TEST(Precision, OfRaigLetsNoRayThroughNearOrFar) {
    for (const double offset : {0.0, 1e3, 1e7}) {
        const PrecisionFindings found = measurePrecision("raig", offset, 3);
        EXPECT_GT(found.rays, 4000u);
        EXPECT_EQ(found.missed, 0u) << offset;
        EXPECT_GT(found.nanoseconds, 0.0);
    }
}

TEST(Precision, OfTextbooksLetsRaysThrough) {
    for (const char* const method : {"moeller-trumbore", "float-contracted"}) {
        const PrecisionFindings found = measurePrecision(method, 0.0, 3);
        EXPECT_GT(double(found.missed), 0.005 * double(found.rays)) << method;
        EXPECT_LT(double(found.missed), 0.2 * double(found.rays)) << method;
    }
}

std::vector<Ray> raysAtSphere(size_t count, bool atVertices, const std::vector<Triangle>& mesh) {
    Random random(7);
    std::vector<Ray> rays;
    for (size_t i = 0; i < count; ++i) {
        const vec3 origin(3.0 * random.direction());
        const Triangle& t = mesh[random.below(static_cast<uint32_t>(mesh.size()))];
        const vec3 target = atVertices ? t.a : (t.a + t.b + t.c) / 3.0f;
        rays.push_back({origin, 0.0f, target - origin, 1e30f});
    }
    return rays;
}

size_t countOther(const std::vector<Hit>& some, const std::vector<Hit>& others) {
    size_t count = 0;
    for (size_t i = 0; i < some.size(); ++i) count += some[i].primitive != others[i].primitive;
    return count;
}

// A control that fails everywhere would show as little as one that never does.
TEST(TextbookBvh, IsRightWhereNothingIsHardAndFailsAtCorners) {
    const std::vector<Triangle> mesh = hard::sphere(12, 1.0, dvec3(0));
    const hard::naive::Bvh textbook(mesh);
    const Structure structure = structureType("bvh").build(mesh, {});
    const std::unique_ptr<Tracer> tracer = makeCpuTracer(structure);
    for (const bool atVertices : {false, true}) {
        const std::vector<Ray> rays = raysAtSphere(4000, atVertices, mesh);
        std::vector<Hit> textbooks(rays.size()), hits(rays.size());
        textbook.trace(rays, textbooks);
        tracer->trace(rays, hits, Query::closest);
        if (atVertices)
            EXPECT_GT(countOther(textbooks, hits), rays.size() / 100);
        else
            EXPECT_EQ(countOther(textbooks, hits), 0u);
    }
}

TEST(PictureTask, FindsTheClosedFormOfFacingMirrors) {
    const std::unique_ptr<Task> task = makeTask("picture", {});
    ChartScenes scenes({});
    for (const auto& [name, reflectance] : {std::pair("mirrors-50", 0.5), std::pair("mirrors-90", 0.9)}) {
        task->forgetScene();
        const ChartScene& scene = scenes.open(name);
        for (const int depth : {0, 3, 9}) {
            const Json measures =
                task->run(&scene, {{"max-depth", depth}, {"min-contribution", 0}, {"side", 8}, {"repeat", 1}});
            const double theory = std::pow(reflectance, depth + 1.0);
            EXPECT_NEAR(measures["relative_error"].get<double>(), theory, 1e-4 * theory + 2e-6) << name << depth;
            EXPECT_NEAR(measures["discarded_mean"].get<double>(), theory, 1e-4 * theory + 2e-6) << "what is not followed";
            EXPECT_EQ(measures["mean_depth"].get<double>(), depth);
        }
    }
}

// What is cut off is no noise: between mirrors, which draw nothing at random, a reference with samples of its own is cut off
// as well, and differs by rounding only.
TEST(PictureTask, MeasuresNoiseAgainstAReferenceThatGoesAsDeep) {
    const std::unique_ptr<Task> task = makeTask("picture", {});
    ChartScenes scenes({});
    const ChartScene& scene = scenes.open("mirrors-50");
    Json settings = {{"max-depth", 2}, {"min-contribution", 0}, {"spp", 2}, {"side", 8}, {"repeat", 1}};
    EXPECT_GT(task->run(&scene, settings)["rmse"].get<double>(), 0.1) << "what is cut off";
    settings["reference-spp"] = 4;
    constexpr double ulp = 0x1p-23;  // of radiance from 1 to 2
    EXPECT_LE(task->run(&scene, settings)["rmse"].get<double>(), 4 * ulp);
}

// With the reference's numbers the same picture, by every integrator; with others, one that differs by its noise.
TEST(PictureTask, MeasuresEveryIntegratorAgainstItsOwnReference) {
    const std::unique_ptr<Task> task = makeTask("picture", {});
    const ChartScene scene("box", importScene(RAIG_SOURCE_DIR "/assets/cornell_box.gltf"));
    for (const char* integrator : {"whitted", "path", "ao"}) {
        Json settings = {{"integrator", integrator}, {"min-contribution", 1.0 / 512.0}, {"max-depth", 64},
                         {"spp", 1},                 {"side", 16},                      {"repeat", 1}};
        EXPECT_LT(task->run(&scene, settings)["rmse"].get<double>(), 1e-4) << integrator;
        settings["reference-spp"] = 64;
        EXPECT_GT(task->run(&scene, settings)["rmse"].get<double>(), 1e-2) << integrator;
    }
}

/// A floor of two triangles, and a sphere a thousandth as large on it.
Scene stadium() {
    Scene scene;
    scene.materials = {Material{}};
    Mesh mesh;
    const auto add = [&](const Triangle& t) {
        const auto first = static_cast<uint32_t>(mesh.positions.size());
        mesh.positions.insert(mesh.positions.end(), {t.a, t.b, t.c});
        mesh.triangles.push_back({first, first + 1, first + 2});
    };
    add({vec3(-1000, 0, -1000), vec3(1000, 0, -1000), vec3(1000, 0, 1000)});
    add({vec3(-1000, 0, -1000), vec3(1000, 0, 1000), vec3(-1000, 0, 1000)});
    for (const Triangle& t : hard::sphere(16, 1.0, dvec3(0, 1, 0))) add(t);
    mesh.materials.assign(mesh.triangles.size(), 0);
    scene.meshes = {mesh};
    scene.instances = {{0, dmat4(1.0)}};
    completeScene(scene);
    return scene;
}

TEST(TracePlace, LooksAtSmallThingsInALargePlace) {
    const ChartScene scene("stadium", stadium());
    const TracePlace place(scene, 0.0);
    size_t small = 0;
    for (const Hit& hit : place.primary().yardstick) small += hit.primitive != NO_HIT && hit.primitive >= 2;
    EXPECT_GT(small, place.primary().rays.size() / 5);
    EXPECT_EQ(place.aimed().rays.size(), size_t{TracePlace::judgedRays});
}

TEST(Tasks, RefuseWhatTheyDoNotKnow) {
    EXPECT_THROW(makeTask("dance", {}), Error);
    const std::pair<const char*, const char*> cases[] = {
        {"trace", R"({"accel": "embree-fast"})"}, {"trace", R"({"max-tree-depth": 1e9})"},
        {"trace", R"({"precision": 12})"},        {"trace", R"({"offset": 1e300})"},
        {"trace", R"({"rays": "gamma"})"},        {"picture", R"({"spp": 0})"},
        {"picture", R"({"primary": "guess"})"},   {"picture", R"({"integrator": "guess"})"},
        {"picture", R"({"side": 1e9})"},          {"picture", R"({"min-contribution": -1})"},
        {"precision", R"({"method": "guess"})"},  {"spawn", R"({"policy": "hope"})"},
        {"spawn", R"({"size": 1e-300})"},         {"spawn", R"({"size": 1, "place": 1e9})"}};
    for (const auto& [task, settings] : cases)
        EXPECT_THROW(makeTask(task, {})->check(Json::parse(settings)), Error) << task << settings;
}

}  // namespace
}  // namespace raig
