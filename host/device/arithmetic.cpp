#include "device/arithmetic.hpp"

#include "base/error.hpp"
#include "base/vectors.hpp"
#include "device/commands.hpp"

#include <bit>
#include <cmath>
#include <limits>
#include <random>

namespace raig {

namespace {

namespace shared {
using uint = uint32_t;
#include "shared/selftest.glsl"
}  // namespace shared
using namespace shared;

constexpr uint32_t signBit = 0x80000000u;
constexpr uint32_t smallestNormal = 0x00800000u;
constexpr uint32_t infinity = 0x7f800000u;

bool isDenormal(uint32_t bits) {
    return (bits & ~signBit) != 0 && (bits & ~signBit) < smallestNormal;
}
bool isNan(uint32_t bits) {
    return (bits & ~signBit) > infinity;
}
bool sameFloat(uint32_t x, uint32_t y) {
    return x == y || (isNan(x) && isNan(y));
}
uint32_t flushed(uint32_t bits) {
    return isDenormal(bits) ? bits & signBit : bits;
}

/// Denormals are taken apart and put together by integers: the processor may be in a mode that flushes them.
double widened(uint32_t bits) {
    if (!isDenormal(bits)) return std::bit_cast<float>(bits);
    const double magnitude = std::ldexp(static_cast<double>(bits & ~signBit), -149);
    return (bits & signBit) != 0 ? -magnitude : magnitude;
}

uint32_t rounded(double value) {
    if (std::abs(value) >= 0x1p-126 || value == 0.0 || std::isnan(value))
        return std::bit_cast<uint32_t>(static_cast<float>(value));
    return static_cast<uint32_t>(std::nearbyint(std::ldexp(std::abs(value), 149))) | (std::signbit(value) ? signBit : 0u);
}

/// Operands a, b, c, d of one sample, as bits.
using Operands = std::array<uint32_t, SELFTEST_OPERANDS>;
using Results = std::array<uint32_t, SELFTEST_RESULTS>;

/// The correctly rounded result. One operation on floats, done in double and rounded again, is correctly rounded
/// [Figueroa 1995, "When is Double Rounding Innocuous?"].
uint32_t expected(uint32_t slot, uint32_t aBits, uint32_t bBits) {
    const double a = widened(aBits), b = widened(bBits);
    switch (slot) {
        case SELFTEST_ADD:
            return rounded(a + b);
        case SELFTEST_SUB:
            return rounded(a - b);
        case SELFTEST_MUL:
            return rounded(a * b);
        case SELFTEST_DIV:
            return rounded(a / b);
        case SELFTEST_SQRT:
            return rounded(std::sqrt(std::abs(a)));
    }
    RAIG_CHECK(!"a slot of one operation");
    return 0;
}

/// Every pair of the values where float arithmetic has its corners, then random ones.
std::vector<Operands> makeOperands() {
    std::vector<uint32_t> hard = {0x00000001u, 0x007fffffu, 0x00400000u, 0x00800001u,
                                  0x7f7fffffu, 0x7fc00000u, infinity,    0u};
    for (const float value : {1.0f, 1.0f / 3.0f, 0.1f, 3.0f, 5.0f, 7.0f, 1.5f, 16777215.0f, 16777216.0f, 1e-20f, 1e20f,
                              1e-38f, 0x1p-126f, 0x1.fffffep-1f, 0x1.000002p0f, 0x1.fffffep0f, 0x1p64f, 0x1p-64f})
        hard.push_back(std::bit_cast<uint32_t>(value));
    for (size_t i = hard.size(); i-- > 0;) hard.push_back(hard[i] ^ signBit);

    std::mt19937 random(1);  // its sequence is the same everywhere
    const auto anyBits = [&] { return static_cast<uint32_t>(random()); };
    // Of like size, so that sums cancel and a fused multiply-add shows.
    const auto nearOne = [&] { return (anyBits() & 0x80ffffffu) | 0x3f000000u; };
    const auto integer = [&] {
        return std::bit_cast<uint32_t>(static_cast<float>(static_cast<int32_t>(anyBits())) * 0.99f);
    };
    std::vector<Operands> operands;
    for (const uint32_t a : hard)
        for (const uint32_t b : hard) operands.push_back({a, b, nearOne(), integer()});
    for (int i = 0; i < 8192; ++i) operands.push_back({anyBits(), anyBits(), anyBits(), integer()});
    for (int i = 0; i < 8192; ++i) {
        const uint32_t a = nearOne(), b = nearOne();
        const uint32_t product = rounded(widened(a) * widened(b)) ^ signBit;
        operands.push_back({a, b, i % 2 == 0 ? product : nearOne(), integer()});
    }
    return operands;
}

std::string summarise(bool first, bool second, const char* onlyFirst, const char* onlySecond, const char* both) {
    return first && second ? both : second ? onlySecond : onlyFirst;
}

/// Judges + - * / sqrt: whether exact, and what becomes of denormals.
void judgeOperations(std::span<const Operands> operands, std::span<const Results> results, Arithmetic& found) {
    std::array<bool, 5> exact{true, true, true, true, true};
    bool kept = false, flushes = false, other = false;
    for (size_t i = 0; i < operands.size(); ++i) {
        const auto [a, b, c, d] = operands[i];
        for (uint32_t slot = SELFTEST_ADD; slot <= SELFTEST_SQRT; ++slot) {
            const uint32_t want = expected(slot, a, b), got = results[i][slot];
            // A result that rounds up to the smallest normal number may have been flushed before that.
            const bool denormal = isDenormal(a) || (slot != SELFTEST_SQRT && isDenormal(b)) || isDenormal(want) ||
                                  (want & ~signBit) == smallestNormal;
            if (!denormal) {
                exact[slot] = exact[slot] && sameFloat(got, want);
                continue;
            }
            const uint32_t coarse = expected(slot, flushed(a), flushed(b));
            const bool isKept = sameFloat(got, want);
            const bool isFlushed = sameFloat(got, flushed(want)) || sameFloat(got, coarse) ||
                                   sameFloat(got, flushed(coarse)) ||
                                   ((want & ~signBit) == smallestNormal && (got & ~signBit) == 0);
            if (isKept && isFlushed) continue;  // says nothing
            (isKept ? kept : isFlushed ? flushes : other) = true;
        }
    }
    found.addExact = exact[SELFTEST_ADD];
    found.subExact = exact[SELFTEST_SUB];
    found.mulExact = exact[SELFTEST_MUL];
    found.divExact = exact[SELFTEST_DIV];
    found.sqrtExact = exact[SELFTEST_SQRT];
    found.denormals = other ? "mixed" : summarise(kept, flushes, "kept", "flushed", "mixed");
}

/// Judges a * b + c in its three forms, on samples where one rounding and two differ.
void judgeContraction(std::span<const Operands> operands, std::span<const Results> results, Arithmetic& found) {
    const auto isPlain = [](float value) { return std::isnormal(value) && std::abs(value) > 1e-30f; };
    const auto judge = [&](uint32_t slot, const char* once, const char* twice, const char* neither) {
        bool fused = false, unfused = false, other = false;
        for (size_t i = 0; i < operands.size(); ++i) {
            const auto [a, b, c, d] = operands[i];
            const float x = std::bit_cast<float>(a), y = std::bit_cast<float>(b), z = std::bit_cast<float>(c);
            const float product = std::bit_cast<float>(rounded(widened(a) * widened(b)));
            if (!isPlain(x) || !isPlain(y) || !isPlain(z) || !isPlain(product)) continue;
            const float one = std::fma(x, y, z), two = product + z;
            if (one == two || !isPlain(one) || !(two == 0.0f || isPlain(two))) continue;
            const float got = std::bit_cast<float>(results[i][slot]);
            (got == one ? fused : got == two ? unfused : other) = true;
        }
        return other ? std::string(neither) : summarise(unfused, fused, twice, once, neither);
    };
    found.contraction = judge(SELFTEST_MUL_ADD, "fused", "none", "mixed");
    found.preciseContraction = judge(SELFTEST_PRECISE_MUL_ADD, "fused", "none", "mixed");
    found.fma = judge(SELFTEST_FMA, "fused", "unfused", "other");
}

/// Judges min and max where one operand is NaN.
std::string judgeNan(std::span<const Operands> operands, std::span<const Results> results) {
    bool number = true, nan = true, first = true, second = true;
    for (size_t i = 0; i < operands.size(); ++i) {
        const auto [a, b, c, d] = operands[i];
        if (isNan(a) == isNan(b) || isDenormal(a) || isDenormal(b)) continue;
        for (const uint32_t slot : {SELFTEST_MIN, SELFTEST_MAX}) {
            const uint32_t got = results[i][slot];
            number = number && sameFloat(got, isNan(a) ? b : a);
            nan = nan && isNan(got);
            first = first && sameFloat(got, a);
            second = second && sameFloat(got, b);
        }
    }
    return number ? "number" : nan ? "nan" : first ? "first" : second ? "second" : "mixed";
}

void judgeConversions(std::span<const Operands> operands, std::span<const Results> results, Arithmetic& found) {
    found.intToFloatExact = found.uintToFloatExact = found.floatToIntExact = found.divisionByZero = true;
    const auto check = [](bool& soFar, bool now) { soFar = soFar && now; };
    for (size_t i = 0; i < operands.size(); ++i) {
        const auto [a, b, c, d] = operands[i];
        const Results& result = results[i];
        const float whole = std::bit_cast<float>(d);
        check(found.intToFloatExact, result[SELFTEST_FROM_INT] == rounded(static_cast<double>(static_cast<int32_t>(a))));
        check(found.uintToFloatExact, result[SELFTEST_FROM_UINT] == rounded(static_cast<double>(a)));
        check(found.floatToIntExact, result[SELFTEST_TO_INT] == static_cast<uint32_t>(static_cast<int32_t>(whole)) &&
                                         result[SELFTEST_TO_UINT] == static_cast<uint32_t>(std::abs(whole)));
        if (a == std::bit_cast<uint32_t>(1.0f) && (b & ~signBit) == 0)
            check(found.divisionByZero, result[SELFTEST_DIV] == (infinity | (b & signBit)));
    }
}

Arithmetic judge(std::span<const Operands> operands, std::span<const Results> results) {
    Arithmetic found;
    found.samples = operands.size();
    judgeOperations(operands, results, found);
    judgeContraction(operands, results, found);
    judgeConversions(operands, results, found);
    found.minMaxNan = judgeNan(operands, results);
    return found;
}

}  // namespace

bool Arithmetic::ieee() const {
    return addExact && subExact && mulExact && divExact && sqrtExact && preciseContraction == "none";
}

Arithmetic measureArithmetic(Device& device, std::span<const uint32_t> spirv) {
    const std::vector<Operands> operands = makeOperands();
    const auto count = static_cast<uint32_t>(operands.size());
    Buffer in(device, operands.size() * sizeof(Operands));
    Buffer out(device, operands.size() * sizeof(Results));
    in.upload(std::as_bytes(std::span(operands)));
    Kernel kernel(device, "selftest", spirv);
    kernel.bind(0, in);
    kernel.bind(1, out);
    const struct { uint32_t count; } push{count};
    Commands commands(device);
    const uint32_t size = kernel.interface().workgroupSize[0];
    commands.dispatch(kernel, {(count + size - 1) / size}, push);
    commands.run();
    return judge(operands, out.downloadValues<Results>());
}

Arithmetic measureHostArithmetic() {
    const std::vector<Operands> operands = makeOperands();
    std::vector<Results> results(operands.size());
    for (size_t i = 0; i < operands.size(); ++i) {
        const auto [aBits, bBits, cBits, dBits] = operands[i];
        const float a = std::bit_cast<float>(aBits), b = std::bit_cast<float>(bBits), c = std::bit_cast<float>(cBits);
        const float d = std::bit_cast<float>(dBits);
        Results& result = results[i];
        const auto put = [&](uint32_t slot, float value) { result[slot] = std::bit_cast<uint32_t>(value); };
        put(SELFTEST_ADD, a + b);
        put(SELFTEST_SUB, a - b);
        put(SELFTEST_MUL, a * b);
        put(SELFTEST_DIV, a / b);
        put(SELFTEST_SQRT, std::sqrt(std::abs(a)));
        put(SELFTEST_MUL_ADD, a * b + c);
        put(SELFTEST_PRECISE_MUL_ADD, a * b + c);
        put(SELFTEST_FMA, std::fma(a, b, c));
        put(SELFTEST_MIN, b < a ? b : a);  // as glm::min, and GLSL's definition
        put(SELFTEST_MAX, a < b ? b : a);
        put(SELFTEST_FROM_INT, static_cast<float>(static_cast<int32_t>(aBits)));
        put(SELFTEST_FROM_UINT, static_cast<float>(aBits));
        result[SELFTEST_TO_INT] = static_cast<uint32_t>(static_cast<int32_t>(d));
        result[SELFTEST_TO_UINT] = static_cast<uint32_t>(std::abs(d));
    }
    return judge(operands, results);
}

}  // namespace raig
