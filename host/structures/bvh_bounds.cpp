#include "structures/bvh_bounds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace raig::bvh {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double margin = 0x1p-44;  // more than sums of three products of numbers up to 2 are rounded by, in double

float roundedDown(double x) {
    const auto f = static_cast<float>(x);
    return f > x ? std::nextafter(f, -std::numeric_limits<float>::infinity()) : f;
}

float roundedUp(double x) {
    const auto f = static_cast<float>(x);
    return f < x ? std::nextafter(f, std::numeric_limits<float>::infinity()) : f;
}

double diagonal(const std::array<int, 3>& signs, const vec3& p) {
    return signs[0] * double{p.x} + signs[1] * double{p.y} + signs[2] * double{p.z};
}

OrientedBox boxAlong(const std::array<vec3, 3>& axes, std::span<const vec3> points) {
    OrientedBox box{axes, vec3(0.0f), vec3(0.0f)};
    for (int i = 0; i < 3; ++i) {
        double lo = infinity, hi = -infinity;
        for (const vec3& p : points) {
            const double along = glm::dot(dvec3(axes[i]), dvec3(p));
            lo = std::min(lo, along);
            hi = std::max(hi, along);
        }
        box.lo[i] = roundedDown(lo - margin);
        box.hi[i] = roundedUp(hi + margin);
    }
    return box;
}

float halfArea(const OrientedBox& box) {
    const vec3 e = box.hi - box.lo;
    return e.x * e.y + e.y * e.z + e.z * e.x;
}

/// Eigenvectors of a symmetric matrix, by Jacobi's rotations.
std::array<dvec3, 3> eigenvectors(double (&m)[3][3]) {
    double v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int sweep = 0; sweep < 12; ++sweep)
        for (int p = 0; p < 2; ++p)
            for (int q = p + 1; q < 3; ++q) {
                if (m[p][q] == 0.0) continue;
                const double theta = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
                const double t = std::copysign(1.0, theta) / (std::abs(theta) + std::sqrt(theta * theta + 1.0));
                const double c = 1.0 / std::sqrt(t * t + 1.0), s = t * c;
                for (int k = 0; k < 3; ++k) {
                    const double a = m[k][p], b = m[k][q];
                    m[k][p] = c * a - s * b;
                    m[k][q] = s * a + c * b;
                }
                for (int k = 0; k < 3; ++k) {
                    const double a = m[p][k], b = m[q][k];
                    m[p][k] = c * a - s * b;
                    m[q][k] = s * a + c * b;
                }
                for (auto& row : v) {
                    const double a = row[p], b = row[q];
                    row[p] = c * a - s * b;
                    row[q] = s * a + c * b;
                }
            }
    std::array<dvec3, 3> result;
    for (int i = 0; i < 3; ++i) result[i] = dvec3(v[0][i], v[1][i], v[2][i]);
    return result;
}

std::array<vec3, 3> principalAxes(std::span<const vec3> points) {
    dvec3 mean(0.0);
    for (const vec3& p : points) mean += dvec3(p) / static_cast<double>(points.size());
    double covariance[3][3] = {};
    for (const vec3& p : points) {
        const dvec3 d = dvec3(p) - mean;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) covariance[i][j] += d[i] * d[j];
    }
    const std::array<dvec3, 3> found = eigenvectors(covariance);
    return {vec3(found[0]), vec3(found[1]), vec3(found[2])};
}

}  // namespace

Sphere sphereAround(std::span<const vec3> points) {
    const auto farthestFrom = [&](const dvec3& centre) {
        size_t farthest = 0;
        double most = -1.0;
        for (size_t i = 0; i < points.size(); ++i) {
            const dvec3 d = dvec3(points[i]) - centre;
            if (glm::dot(d, d) > most) {
                most = glm::dot(d, d);
                farthest = i;
            }
        }
        return farthest;
    };
    dvec3 centre(points[0]);
    const int steps = static_cast<int>(std::clamp<size_t>((1u << 20) / points.size(), 8, 64));
    for (int i = 1; i <= steps; ++i) centre += (dvec3(points[farthestFrom(centre)]) - centre) / (i + 1.0);
    const vec3 rounded(centre);
    const dvec3 d = dvec3(points[farthestFrom(dvec3(rounded))]) - dvec3(rounded);
    return {rounded, roundedUp(std::sqrt(glm::dot(d, d)) + margin)};
}

OrientedBox orientedBoxAround(std::span<const vec3> points) {
    const OrientedBox straight = boxAlong({vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1)}, points);
    const OrientedBox turned = boxAlong(principalAxes(points), points);
    return halfArea(turned) < halfArea(straight) ? turned : straight;
}

Kdop kdopAround(std::span<const vec3> points) {
    Kdop kdop;
    for (int slab = 0; slab < Kdop::slabs; ++slab) {
        double lo = infinity, hi = -infinity;
        for (const vec3& p : points) {
            const double along = slab < 3 ? double{p[slab]} : diagonal(diagonals[slab - 3], p);
            lo = std::min(lo, along);
            hi = std::max(hi, along);
        }
        kdop.lo[slab] = roundedDown(lo);
        kdop.hi[slab] = roundedUp(hi);
    }
    return kdop;
}

bool contains(const Sphere& sphere, const vec3& point) {
    const dvec3 d = dvec3(point) - dvec3(sphere.centre);
    return std::sqrt(glm::dot(d, d)) <= double{sphere.radius} + margin;
}

bool contains(const OrientedBox& box, const vec3& point) {
    for (int i = 0; i < 3; ++i) {
        const double along = glm::dot(dvec3(box.axes[i]), dvec3(point));
        if (!(along >= box.lo[i] - margin && along <= box.hi[i] + margin)) return false;
    }
    return true;
}

bool contains(const Kdop& kdop, const vec3& point) {
    for (int slab = 0; slab < Kdop::slabs; ++slab) {
        const double along = slab < 3 ? double{point[slab]} : diagonal(diagonals[slab - 3], point);
        if (!(along >= kdop.lo[slab] && along <= kdop.hi[slab])) return false;
    }
    return true;
}

}  // namespace raig::bvh
