// One source for two languages: what lies under shaders/, but for the .comp files, is compiled as GLSL for devices and as
// C++ for the CPU, where it is included inside a namespace or a class that has GLM's names in view.
//
// The common subset: every float literal has its `f` (C++ would compute in double), no swizzles, no implicit conversions, no
// array constructors; a parameter that is written to is INOUT(T), and a
// constant of a file is CONSTANT; no built-in of GLSL whose result the host cannot repeat
// where bits matter (normalize, inversesqrt, fma, min and max on a possible NaN, sin, cos, pow).
#ifndef RAIG_LANGUAGE
#define RAIG_LANGUAGE

#ifdef __cplusplus
#define INOUT(T) T&
#define CONSTANT static constexpr
#define precise
#else
#define INOUT(T) inout T
#define CONSTANT const
#endif

#endif
