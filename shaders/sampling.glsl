// Sampling numbers: the same 32-bit integers on every device, for every pixel, sample and dimension, in any order.

// Scrambles 32 bits into others, one to one [O'Neill 2014, "PCG: A Family of Simple Fast Space-Efficient Statistically Good
// Algorithms for Random Number Generation": the output permutation RXS-M-XS; Jarzynski and Olano 2020].
uint hash(uint x) {
    uint s = x * 747796405u + 2891336453u;
    uint word = ((s >> ((s >> 28u) + 4u)) ^ s) * 277803737u;
    return (word >> 22u) ^ word;
}

uint hash2(uint a, uint b) { return hash(a ^ hash(b)); }

// A hash in which each bit depends on lower bits only [Laine and Karras 2011, "Stratified Sampling for Stochastic
// Transparency", with Vegdahl's constants].
uint permuteBits(uint x, uint seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16u) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

// Owen scrambling: each bit is flipped or not by what the bits above it are [Burley 2020, "Practical Hash-based Owen
// Scrambling"].
uint scramble(uint x, uint seed) { return bitfieldReverse(permuteBits(bitfieldReverse(x), seed)); }

// The second dimension of Sobol's sequence: the generator matrix is Pascal's triangle modulo 2, whose product with i is five
// shifted differences, upside down [Ahmed 2024, "An Implementation Algorithm of 2D Sobol Sequence Fast, Elegant, and
// Compact"].
uint sobol1(uint i) {
    uint x = bitfieldReverse(i);
    x ^= (x & 0x0000ffffu) << 16u;
    x ^= (x & 0x00ff00ffu) << 8u;
    x ^= (x & 0x0f0f0f0fu) << 4u;
    x ^= (x & 0x33333333u) << 2u;
    x ^= (x & 0x55555555u) << 1u;
    return x;
}

// Two 32-bit numbers for sample `sampleIndex` of `pixel` in `dimension`. Over the first 2^k samples of a pixel they are
// stratified in every elementary interval of area 2^-k.
uvec2 sampleBits(uint pixel, uint sampleIndex, uint dimension, uint seed) {
    uint key = hash2(hash2(pixel, dimension), seed);
    uint i = scramble(sampleIndex, key);
    return uvec2(scramble(bitfieldReverse(i), hash2(key, 1u)), scramble(sobol1(i), hash2(key, 2u)));
}

// The same as numbers in [0, 1), multiples of 2^-24.
vec2 sampleSquare(uint pixel, uint sampleIndex, uint dimension, uint seed) {
    uvec2 bits = sampleBits(pixel, sampleIndex, dimension, seed);
    return vec2(float(bits.x >> 8u) * (1.0f / 16777216.0f), float(bits.y >> 8u) * (1.0f / 16777216.0f));
}
