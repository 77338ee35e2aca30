#include "measure/hard_meshes.hpp"

#include <cmath>
#include <numbers>

namespace raig::hard {

std::vector<Triangle> CutBox::triangles() const {
    std::vector<Triangle> result;
    for (int axis = 0; axis < 3; ++axis) {
        const std::vector<float>&p = cuts[(axis + 1) % 3], &q = cuts[(axis + 2) % 3];
        for (const float side : {cuts[axis].front(), cuts[axis].back()})
            for (size_t i = 0; i + 1 < p.size(); ++i)
                for (size_t j = 0; j + 1 < q.size(); ++j) {
                    const auto at = [&](size_t k, size_t l) {
                        vec3 corner;
                        corner[axis] = side;
                        corner[(axis + 1) % 3] = p[k];
                        corner[(axis + 2) % 3] = q[l];
                        return corner;
                    };
                    result.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
                    result.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
                }
    }
    return result;
}

Box CutBox::box() const {
    return {vec3(cuts[0].front(), cuts[1].front(), cuts[2].front()), vec3(cuts[0].back(), cuts[1].back(), cuts[2].back())};
}

CutBox randomCutBox(Random& random, const dvec3& centre, double size, int inner) {
    CutBox result;
    for (int axis = 0; axis < 3; ++axis) {
        const double half = 0.5 * size * random.within(0.6, 1.0);
        std::vector<float>& cuts = result.cuts[axis];
        cuts.push_back(static_cast<float>(centre[axis] - half));
        for (int i = 0; i < inner; ++i)
            cuts.push_back(static_cast<float>(centre[axis] + half * ((i + random.within(0.2, 0.8)) / inner - 0.5)));
        cuts.push_back(static_cast<float>(centre[axis] + half));
    }
    return result;
}

std::vector<Triangle> squares(int axis, float place, int side) {
    std::vector<Triangle> result;
    for (int i = 0; i < side; ++i)
        for (int j = 0; j < side; ++j) {
            const auto at = [&](int k, int l) {
                vec3 corner;
                corner[axis] = place;
                corner[(axis + 1) % 3] = static_cast<float>(k);
                corner[(axis + 2) % 3] = static_cast<float>(l);
                return corner;
            };
            result.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            result.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    return result;
}

float anyZero(Random& random) {
    return random.below(2) == 0 ? 0.0f : -0.0f;
}

std::vector<Triangle> sphere(uint32_t rings, double radius, dvec3 centre, double bumps) {
    const uint32_t columns = 2 * rings;
    std::vector<std::vector<vec3>> points(rings + 1, std::vector<vec3>(columns));
    for (uint32_t i = 0; i <= rings; ++i)
        for (uint32_t j = 0; j < columns; ++j) {
            const double theta = std::numbers::pi * i / rings, phi = 2.0 * std::numbers::pi * j / columns;
            const bool pole = i == 0 || i == rings;
            const double r = radius * (1.0 + (pole ? 0.0 : bumps * std::sin(5 * theta) * std::sin(7 * phi)));
            const double s = pole ? 0.0 : std::sin(theta);
            points[i][j] = vec3(centre + r * dvec3(s * std::cos(phi), std::cos(theta), s * std::sin(phi)));
        }
    std::vector<Triangle> triangles;
    for (uint32_t i = 0; i < rings; ++i)
        for (uint32_t j = 0; j < columns; ++j) {
            const uint32_t next = (j + 1) % columns;
            if (i > 0) triangles.push_back({points[i][j], points[i][next], points[i + 1][j]});
            if (i + 1 < rings) triangles.push_back({points[i][next], points[i + 1][next], points[i + 1][j]});
        }
    return triangles;
}

Mesh meshOf(const std::vector<Triangle>& triangles) {
    Mesh mesh;
    for (const Triangle& t : triangles) {
        const auto first = static_cast<uint32_t>(mesh.positions.size());
        mesh.positions.insert(mesh.positions.end(), {t.a, t.b, t.c});
        mesh.triangles.emplace_back(first, first + 1, first + 2);
        mesh.materials.push_back(0);
    }
    return mesh;
}

}  // namespace raig::hard
