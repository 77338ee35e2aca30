/// What tests of grids have in common: rays aimed at cells, walks stopped and taken up again at will, and a crowded scene.
#pragma once

#include "base/random.hpp"
#include "rays/types.hpp"
#include "structures/structure.hpp"

#include <string>
#include <vector>

namespace raig::test {

/// The grid of `levels` levels and `density` cells a triangle; 0 leaves either to the grid.
Structure gridOver(const std::vector<Triangle>& triangles, uint32_t levels, float density = 0.0f);

/// Expects that the grid finds what brute force does, by bits, and returns how many rays hit something. Tries every triangle
/// for every ray.
size_t expectAsBrute(const Structure& structure, const std::vector<Triangle>& triangles, const std::vector<Ray>& rays,
                     const std::string& what);

/// A corner of a cell of the grid, or of a part that a cell may have, in the scene's unit of length; or a point of such an
/// edge or face.
dvec3 placeOnCell(const Structure& structure, Random& random);

/// Rays along faces and edges of cells, through their corners, and from them; with zeros of both signs. Requires triangles.
std::vector<Ray> raysAtCells(const Structure& structure, const std::vector<Triangle>& triangles, uint64_t seed,
                             size_t count);

/// The closest hits, by the walk that the grid names, which is stopped after every `maxSteps` steps and taken up again with
/// nothing but where it was and the best hit. Reads out of range throw; a ray without end is a failure.
std::vector<Hit> walkInPieces(const Structure& structure, const std::vector<Ray>& rays, uint32_t maxSteps);

/// Walks each ray by the walk that the grid names, as far as a walk may go that ends. Reads out of range throw.
void walkAsFarAsMaybe(const Structure& structure, const std::vector<Ray>& rays);

/// Small things in a large place: a sphere of 6000 triangles of which 10^4 would fit across the scene; around it slivers and
/// triangles of every size, all in one cell.
std::vector<Triangle> stadium(double size, const dvec3& centre);

}  // namespace raig::test
