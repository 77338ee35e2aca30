// What kernel `selftest` is given and where it puts its results: 4 words in and 16 words out a sample.
#ifndef RAIG_SHARED_SELFTEST
#define RAIG_SHARED_SELFTEST

// In: the bits of floats a, b, c, and of d, which is within the range of int.
const uint SELFTEST_OPERANDS = 4u;

// Out: the bits of the results.
const uint SELFTEST_ADD = 0u;            // a + b
const uint SELFTEST_SUB = 1u;            // a - b
const uint SELFTEST_MUL = 2u;            // a * b
const uint SELFTEST_DIV = 3u;            // a / b
const uint SELFTEST_SQRT = 4u;           // sqrt(|a|)
const uint SELFTEST_MUL_ADD = 5u;        // a * b + c
const uint SELFTEST_PRECISE_MUL_ADD = 6u;// the same, marked precise
const uint SELFTEST_FMA = 7u;            // fma(a, b, c)
const uint SELFTEST_MIN = 8u;            // min(a, b)
const uint SELFTEST_MAX = 9u;            // max(a, b)
const uint SELFTEST_FROM_INT = 10u;      // float(int of the bits of a)
const uint SELFTEST_FROM_UINT = 11u;     // float(the bits of a)
const uint SELFTEST_TO_INT = 12u;        // int(d)
const uint SELFTEST_TO_UINT = 13u;       // uint(|d|)
const uint SELFTEST_RESULTS = 16u;       // words a sample; the last two are unused

#endif
