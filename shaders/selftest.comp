// What this device's arithmetic does with operands it cannot foresee: judged by host/device/arithmetic.cpp.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared/selftest.glsl"

layout(local_size_x = 64) in;
layout(set = 0, binding = 0, std430) readonly buffer Operands { uvec4 operands[]; };
layout(set = 0, binding = 1, std430) writeonly buffer Results { uint results[]; };
layout(push_constant) uniform Push { uint count; };

void put(uint slot, float value) { results[gl_GlobalInvocationID.x * SELFTEST_RESULTS + slot] = floatBitsToUint(value); }

void main() {
    uint sample_ = gl_GlobalInvocationID.x;
    if (sample_ >= count) return;
    uvec4 bits = operands[sample_];
    float a = uintBitsToFloat(bits.x);
    float b = uintBitsToFloat(bits.y);
    float c = uintBitsToFloat(bits.z);
    float d = uintBitsToFloat(bits.w);

    put(SELFTEST_ADD, a + b);
    put(SELFTEST_SUB, a - b);
    put(SELFTEST_MUL, a * b);
    put(SELFTEST_DIV, a / b);
    put(SELFTEST_SQRT, sqrt(abs(a)));
    put(SELFTEST_MUL_ADD, a * b + c);
    precise float apart = a * b + c;
    put(SELFTEST_PRECISE_MUL_ADD, apart);
    put(SELFTEST_FMA, fma(a, b, c));
    put(SELFTEST_MIN, min(a, b));
    put(SELFTEST_MAX, max(a, b));
    put(SELFTEST_FROM_INT, float(int(bits.x)));
    put(SELFTEST_FROM_UINT, float(bits.x));
    results[sample_ * SELFTEST_RESULTS + SELFTEST_TO_INT] = uint(int(d));
    results[sample_ * SELFTEST_RESULTS + SELFTEST_TO_UINT] = uint(abs(d));
}
