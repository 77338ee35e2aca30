#include "reference/sampling.hpp"

#include "base/error.hpp"

namespace raig::reference {

namespace {

uint32_t reverseBits(uint32_t x) {
    uint32_t reversed = 0;
    for (int bit = 0; bit < 32; ++bit) reversed |= ((x >> bit) & 1u) << (31 - bit);
    return reversed;
}

/// Each bit of the result depends on that bit of x, on those below it and on the seed.
uint32_t permuteBits(uint32_t x, uint32_t seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

double toUnit(uint32_t x) {
    return (x >> 8) * 0x1p-24;
}

}  // namespace

uint32_t hash(uint32_t x) {
    const uint32_t state = x * 747796405u + 2891336453u;
    const uint32_t word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
    return (word >> 22) ^ word;
}

uint32_t hash(uint32_t a, uint32_t b) {
    return hash(a ^ hash(b));
}

uint32_t scramble(uint32_t x, uint32_t seed) {
    return reverseBits(permuteBits(reverseBits(x), seed));
}

uint32_t sobol(uint32_t index, uint32_t coordinate) {
    RAIG_CHECK_OP(coordinate, <, 2u);
    if (coordinate == 0) return reverseBits(index);
    uint32_t point = 0;
    for (uint32_t direction = 0x80000000u; index != 0; index >>= 1, direction ^= direction >> 1)
        if (index & 1u) point ^= direction;
    return point;
}

dvec2 sample2(uint32_t pixel, uint32_t sample, uint32_t dimension, uint32_t seed) {
    const uint32_t key = hash(hash(pixel, dimension), seed);
    const uint32_t index = scramble(sample, key);
    return {toUnit(scramble(sobol(index, 0), hash(key, 1))), toUnit(scramble(sobol(index, 1), hash(key, 2)))};
}

}  // namespace raig::reference
