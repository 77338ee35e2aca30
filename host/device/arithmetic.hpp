/// What a device's float arithmetic does, measured: nothing is assumed from its name.
#pragma once

#include "device/device.hpp"

#include <span>

namespace raig {

/// Findings over `samples` operand triples, hard ones among them. Exact: the bits that IEEE 754 asks for, rounding to
/// nearest even, on normal numbers, zeros and infinities; how denormals fare is said apart.
struct Arithmetic {
    uint64_t samples = 0;
    bool addExact = false;
    bool subExact = false;
    bool mulExact = false;
    bool divExact = false;
    bool sqrtExact = false;
    bool intToFloatExact = false;
    bool uintToFloatExact = false;   ///< on SwiftShader it is not, from 2^31 on: it rounds twice
    bool floatToIntExact = false;    ///< truncates, to int and to uint
    std::string denormals;           ///< "kept", "flushed" (to a zero, of operands, results or both), or "mixed"
    std::string contraction;         ///< a * b + c: "none", "fused", or "mixed"
    std::string preciseContraction;  ///< the same where the kernel says `precise`
    std::string fma;                 ///< "fused", "unfused" (a product and a sum), or "other"
    std::string minMaxNan;           ///< of min and max with one NaN: "number", "nan", "first", "second", or "mixed"
    bool divisionByZero = false;     ///< 1/+0 = +inf and 1/-0 = -inf

    /// + - * / sqrt exact, and `precise` keeps a product and a sum apart: hits equal the CPU's, bit for bit.
    bool ieee() const;

    bool operator==(const Arithmetic&) const = default;
};

/// Measures `device` with kernel `selftest` (shaders/selftest.comp, storage form). About 5 ms and the kernel's compilation.
Arithmetic measureArithmetic(Device& device, std::span<const uint32_t> spirv);

/// The same measurement of the CPU's floats: libraries can leave the processor in a mode that flushes denormals.
Arithmetic measureHostArithmetic();

}  // namespace raig
