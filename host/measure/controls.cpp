#include "measure/controls.hpp"

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "measure/later_controls.hpp"
#include "measure/naive.hpp"
#include "measure/oracle.hpp"
#include "measure/picture_controls.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <set>

namespace raig {

namespace {

using hard::Oracle;
using hard::Scene;
using hard::naive::Dda;
using hard::naive::Slab;
using hard::naive::Tester;

/// Of what is measured, the mean over the rays.
ControlFindings sum(ControlFindings a, const ControlFindings& b) {
    if (a.measured && b.measured && a.rays + b.rays > 0)
        a.measured = (*a.measured * double(a.rays) + *b.measured * double(b.rays)) / double(a.rays + b.rays);
    a.rays += b.rays;
    a.missed += b.missed;
    a.phantom += b.phantom;
    a.wrong += b.wrong;
    a.hung += b.hung;
    return a;
}

/// Adds up `find(ray, number, findings)` over the rays, numbered from 0.
template <class Find>
ControlFindings over(const std::vector<Ray>& rays, const Find& find) {
    return parallelReduce(
        rays.size(), 64, ControlFindings{},
        [&](size_t begin, size_t end, ControlFindings findings) {
            for (size_t i = begin; i < end; ++i) find(rays[i], i, findings);
            return findings;
        },
        sum);
}

/// What becomes of the rays that hit something, in exact arithmetic, by `fails(ray, hit)`: those it holds for are missed.
template <class Fails>
ControlFindings missesOf(const Scene& scene, const Fails& fails) {
    const Oracle oracle(scene.triangles);
    return over(scene.rays, [&](const Ray& ray, size_t, ControlFindings& findings) {
        const uint32_t hit = oracle.closest(ray).primitive;
        if (hit == NO_HIT) return;
        ++findings.rays;
        findings.missed += fails(ray, hit);
    });
}

/// A control of a case whose rays are drawn first.
template <class Run>
std::function<ControlFindings(const hard::Draw&)> onScenes(uint32_t number, const Run& run) {
    return [number, run](const hard::Draw& draw) { return run(hard::caseOf(number).make(draw)); };
}

/// In the planes of how many of the box's faces the ray lies.
int facesAlong(const Box& box, const Ray& ray) {
    int count = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const float at = ray.origin[axis];
        count += ray.direction[axis] == 0.0f && box.lo[axis] < box.hi[axis] && (at == box.lo[axis] || at == box.hi[axis]);
    }
    return count;
}

/// The box of a triangle that is hit is missed: of those that share the point that is hit, one after the other. Only rays in
/// the planes of so many of its faces count: others that come before the box that was aimed at are not what is asked for.
Control slabControl(uint32_t number, const char* method, double low, double high, Slab slab, int faces = 0,
                    uint32_t draws = 1) {
    return {number,
            method,
            low,
            high,
            onScenes(number,
                     [slab, faces](const std::vector<Scene>& scenes) {
                         const Scene& scene = scenes[0];
                         const Oracle oracle(scene.triangles);
                         return over(scene.rays, [&](const Ray& ray, size_t number, ControlFindings& findings) {
                             const std::vector<uint32_t> hit = oracle.allClosest(ray);
                             if (hit.empty()) return;
                             const Box box = scene.triangles[hit[number % hit.size()]].box();
                             if (facesAlong(box, ray) < faces) return;
                             ++findings.rays;
                             findings.missed += !hard::naive::meets(slab, box, ray);
                         });
                     }),
            draws};
}

/// No triangle is hit where one is.
Control testerControl(uint32_t number, size_t scene, const char* method, double low, double high, Tester tester,
                      uint32_t draws = 1) {
    return {number,
            method,
            low,
            high,
            onScenes(number,
                     [=](const std::vector<Scene>& scenes) {
                         const std::vector<Triangle>& triangles = scenes.at(scene).triangles;
                         return missesOf(scenes[scene], [&](const Ray& ray, uint32_t) {
                             return std::none_of(triangles.begin(), triangles.end(), [&](const Triangle& t) {
                                 const auto at = hard::naive::meets(tester, t, ray);
                                 return at && *at >= ray.tMin && *at <= ray.tMax;
                             });
                         });
                     }),
            draws};
}

/// Case 24: hits that are nowhere near their slivers.
ControlFindings hitsOfSlivers(const std::vector<Scene>& scenes) {
    const std::vector<Triangle>& triangles = scenes[0].triangles;
    const Oracle oracle(triangles);
    return over(scenes[0].rays, [&](const Ray& ray, size_t, ControlFindings& findings) {
        ++findings.rays;
        for (uint32_t i = 0; i < triangles.size(); ++i) {
            const auto t = hard::naive::meets(Tester::moellerTrumbore, triangles[i], ray);
            if (!t || *t < 0.0f || oracle.judge(ray, {*t, 0.0f, 0.0f, i}, false).sound) continue;
            ++findings.phantom;
            return;
        }
    });
}

/// Of the rays that meet the grid: those of which no cell is visited, or, with `anyCell`, those of which some are left out.
Control ddaControl(uint32_t number, size_t scene, const char* method, double low, double high, Dda dda, bool anyCell,
                   uint32_t n = 24, float side = 0.0f) {
    return {number, method, low, high, onScenes(number, [=](const std::vector<Scene>& scenes) {
                Box box;
                for (const Triangle& t : scenes.at(scene).triangles) box.grow(t.box());
                if (side > 0.0f) box.hi = box.lo + vec3(side);
                return over(scenes[scene].rays, [&](const Ray& ray, size_t, ControlFindings& findings) {
                    const auto want = hard::naive::cellsOf(Dda::sound, box, n, ray);
                    if (!want || want->empty()) return;
                    ++findings.rays;
                    const auto got = hard::naive::cellsOf(dda, box, n, ray);
                    if (!got && anyCell) {
                        ++findings.hung;
                        return;
                    }
                    std::set<uint32_t> visited;
                    if (got)
                        for (const auto& visit : *got) visited.insert(visit.cell);
                    const auto isSkipped = [&](const auto& visit) { return !visited.contains(visit.cell); };
                    findings.missed += anyCell ? std::any_of(want->begin(), want->end(), isSkipped) : visited.empty();
                });
            })};
}

/// Case 39: the worst of the scenes, each in a grid of as many cells as its walls lie next to the faces of. What is hit of
/// the triangle that spans all, which comes first, is no wall.
ControlFindings wallsWithoutMargin(const std::vector<Scene>& scenes) {
    const std::array<uint32_t, 4> cells{3, 5, 7, 12};
    ControlFindings worst;
    for (size_t i = 0; i < scenes.size(); ++i) {
        const hard::naive::Grid grid(scenes[i].triangles, cells[i % cells.size()]);
        const Oracle oracle(scenes[i].triangles);
        const ControlFindings findings = over(scenes[i].rays, [&](const Ray& ray, size_t, ControlFindings& found) {
            const uint32_t hit = oracle.closest(ray).primitive;
            if (hit == NO_HIT || hit == 0) return;
            ++found.rays;
            found.missed += grid.closest(ray, /* first= */ false) == NO_HIT;
        });
        if (findings.percent() >= worst.percent()) worst = findings;
    }
    return worst;
}

/// Case 40: the first triangle that is found in a cell, wherever it is hit.
ControlFindings firstInCell(const std::vector<Scene>& scenes) {
    const hard::naive::Grid grid(scenes[0].triangles, 12);
    const Oracle oracle(scenes[0].triangles);
    return over(scenes[0].rays, [&](const Ray& ray, size_t, ControlFindings& findings) {
        const uint32_t hit = oracle.closest(ray).primitive;
        if (hit == NO_HIT) return;
        const uint32_t got = grid.closest(ray, /* first= */ true);
        ++findings.rays;
        findings.missed += got == NO_HIT;
        findings.wrong += got != NO_HIT && got != hit;
    });
}

Control kdTreeControl(uint32_t number) {
    return {number, "kd-tree, planar triangles on one side", 0, 0, onScenes(number, [](const std::vector<Scene>& scenes) {
                return missesOf(scenes[0], [&](const Ray& ray, uint32_t) {
                    return hard::naive::closestByKdTree(scenes[0].triangles, {vec3(0), vec3(4)}, ray) == NO_HIT;
                });
            })};
}

}  // namespace

bool Control::failsAsItShould(const ControlFindings& findings) const {
    const double rate = findings.rate();
    if (!hasRate()) return rate > 0.0;
    return rate >= low / 2.0 && rate <= (findings.measured ? 2.0 * high : std::min(2.0 * high, 100.0));
}

std::vector<Control> allControls() {
    std::vector<Control> controls = {
        slabControl(1, "slabs by min and max", 50.0, 50.0, Slab::glsl, 1),
        slabControl(1, "slabs by min and max, other order", 66.7, 66.7, Slab::otherOrder, 1),
        slabControl(1, "slabs by minNum and maxNum", 100.0, 100.0, Slab::numbers, 1),
        slabControl(2, "slabs by min and max", 75.0, 75.0, Slab::glsl, 2),
        slabControl(2, "slabs by min and max, other order", 75.0, 75.0, Slab::otherOrder, 2),
        slabControl(2, "slabs by minNum and maxNum", 100.0, 100.0, Slab::numbers, 2),
        slabControl(3, "slabs, near and far by d >= 0", 50.0, 50.0, Slab::signOfValue),
        slabControl(4, "slabs, near and far by d >= 0", 100.0, 100.0, Slab::signOfValue),
        slabControl(5, "slabs by min and max", 12.3, 12.3, Slab::glsl),
        slabControl(5, "slabs by fma(b, 1/d, -o/d)", 19.8, 19.8, Slab::fused, 0, /* draws= */ 4),
        slabControl(6, "slabs by min and max", 6.6, 8.0, Slab::glsl),
        slabControl(6, "slabs by fma(b, 1/d, -o/d)", 53.0, 54.0, Slab::fused),
        slabControl(7, "slabs, |d| clamped to 1e-5", 100.0, 100.0, Slab::clamped5),
        slabControl(8, "slabs, |d| clamped to 1e-5", 89.0, 89.0, Slab::clamped5),
        slabControl(8, "slabs, |d| clamped to 1e-12", 96.0, 96.0, Slab::clamped12),
        slabControl(9, "slabs, enter < leave", 100.0, 100.0, Slab::strict),
        slabControl(10, "slabs by min and max", 15.0, 19.5, Slab::glsl),  // measured
        slabControl(11, "slabs, 1/0 = FLT_MAX", 95.8, 100.0, Slab::largest),
        slabControl(12, "slabs by min and max", 6.0, 9.1, Slab::glsl),  // measured
        testerControl(13, 0, "Moeller-Trumbore", 9.46, 9.46, Tester::moellerTrumbore),
        testerControl(14, 0, "Moeller-Trumbore", 11.42, 11.42, Tester::moellerTrumbore),
        testerControl(15, 0, "Moeller-Trumbore with fma, at vertices", 23.8, 23.8, Tester::moellerTrumboreFused),
        testerControl(15, 1, "Moeller-Trumbore with fma, at edges", 17.5, 17.5, Tester::moellerTrumboreFused),
        testerControl(16, 1, "Moeller-Trumbore", 0, 0, Tester::moellerTrumbore),
        testerControl(16, 1, "watertight, but with fma", 0, 0, Tester::watertightFused, /* draws= */ 6),
        testerControl(17, 1, "watertight, but with fma", 0, 0, Tester::watertightFused, /* draws= */ 4),
        testerControl(18, 0, "Moeller-Trumbore, |det| < 1e-7 left out", 100.0, 100.0, Tester::moellerTrumboreCull),
        testerControl(19, 0, "Moeller-Trumbore", 100.0, 100.0, Tester::moellerTrumbore),
        testerControl(20, 0, "edges by sign(u) != sign(det - u)", 100.0, 100.0, Tester::sameSigns),
        {24, "Moeller-Trumbore", 0, 0, onScenes(24, hitsOfSlivers)},
        ddaControl(32, 0, "DDA, entry not clamped", 33.0, 34.0, Dda::unclamped, false),
        ddaControl(32, 1, "DDA, entry not clamped, from the farthest faces", 100.0, 100.0, Dda::unclamped, false),
        ddaControl(33, 0, "DDA, step = d >= 0 ? 1 : -1", 48.0, 48.0, Dda::noZeros, true),
        ddaControl(34, 0, "DDA, step = d >= 0 ? 1 : -1", 74.0, 88.0, Dda::noZeros, true),
        ddaControl(37, 0, "DDA from the entry point, 1e3 away", 3.3, 3.3, Dda::reorigin, true),
        ddaControl(37, 1, "DDA from the entry point, 1e4 away", 43.9, 43.9, Dda::reorigin, true),
        ddaControl(37, 2, "DDA from the entry point, 1e5 away", 91.8, 91.8, Dda::reorigin, true),
        ddaControl(38, 0, "DDA in single precision, cells of 1/64", 25.0, 25.0, Dda::single, true, 32, 0.5f),
        {39, "grid without a margin", 13.3, 13.3, onScenes(39, wallsWithoutMargin), /* draws= */ 8, /* worst= */ true},
        {40, "grid, first triangle found in a cell", 0, 0, onScenes(40, firstInCell)},
        kdTreeControl(47),
        kdTreeControl(48),
        kdTreeControl(49),
    };
    for (const auto& more : {laterControls(), pictureControls()}) controls.insert(controls.end(), more.begin(), more.end());
    return controls;
}

ControlResult runControl(const Control& control, uint32_t seed) {
    ControlFindings all;
    for (uint32_t draw = 0; draw < control.draws; ++draw) {
        const ControlFindings findings = control.run({.seed = seed + (draw << 24)});
        if (draw == 0)
            all = findings;
        else if (!control.worst)
            all = sum(all, findings);
        else if (findings.rate() > all.rate())
            all = findings;
    }
    return {control, all, control.failsAsItShould(all)};
}

}  // namespace raig
