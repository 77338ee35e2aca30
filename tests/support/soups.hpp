/// Triangles and spheres to build over and rays to send at them: the ordinary and the hostile.
#pragma once

#include "measure/hard_meshes.hpp"
#include "measure/oracle.hpp"
#include "rays/types.hpp"
#include "structures/structure.hpp"

#include <ostream>
#include <string>
#include <vector>

namespace raig::test {

struct Soup {
    std::string name;
    std::vector<Primitive> triangles;
};

/// Its name, for tests that have it as their parameter.
inline std::ostream& operator<<(std::ostream& out, const Soup& soup) {
    return out << soup.name;
}

/// Ordinary soup, slivers, a flat wall, duplicates, overlaps, one triangle, none, all unusable, some unusable, far from the
/// origin, tiny, huge, uneven ("teapot in a stadium"), a closed sphere, an axis-aligned room, tilted walls, pages of a book;
/// then those of sphere_soups.hpp.
std::vector<Soup> soups();

/// The triangles of the one of soups() that has this name. Throws where none does.
std::vector<Triangle> soupNamed(const std::string& name);

using hard::sphere;

/// Rays of every family, in turn: random, axis-aligned with +0 and -0, from inside, at vertices, at points of edges, along
/// the faces of bounding boxes, at corners of boxes, nearly parallel to an axis, in the planes of triangles and nearly so or
/// past silhouettes of spheres, not normalised, short intervals.
std::vector<Ray> rays(const std::vector<Triangle>& triangles, uint64_t seed, size_t count);

using hard::describe;

}  // namespace raig::test
