/// The sampling numbers of a picture: scrambled Sobol points, a pair for every pixel, sample and purpose.
///
/// All is 32-bit integer arithmetic, so that whoever follows the same definition gets the same numbers, whatever else
/// differs. This is the definition's second implementation, written apart from the one that pictures are made with.
///
/// Source: Laine and Karras 2011, "Stratified Sampling for Stochastic Transparency" (the permutation); Burley 2020,
/// "Practical Hash-based Owen Scrambling", with Vegdahl's constants; O'Neill 2014, "PCG" (the hash).
#pragma once

#include "base/vectors.hpp"

#include <cstdint>

namespace raig::reference {

/// A well-mixed permutation of the 32-bit integers.
uint32_t hash(uint32_t x);

/// Mixes two integers into one: hash(a ^ hash(b)).
uint32_t hash(uint32_t a, uint32_t b);

/// Nested uniform (Owen) scrambling: a permutation under which each bit is flipped or not by a function of `seed` and of the
/// bits above it. So aligned blocks of 2^k integers go to aligned blocks of 2^k integers.
uint32_t scramble(uint32_t x, uint32_t seed);

/// Coordinate 0 or 1 of point `index` of the Sobol sequence, as a fraction of 2^32.
uint32_t sobol(uint32_t index, uint32_t coordinate);

/// A point of [0, 1)^2, its coordinates whole multiples of 2^-24.
///
/// Requires  pixel = y * width + x of the whole picture; sample < 65536; `dimension` tells what the point is for.
/// Ensures   samples k 2^m ... (k + 1) 2^m - 1 of one pixel and dimension are stratified: each of the 2^m boxes of any
///           subdivision of the square into 2^a by 2^(m - a) boxes holds exactly one of them.
dvec2 sample2(uint32_t pixel, uint32_t sample, uint32_t dimension, uint32_t seed);

}  // namespace raig::reference
