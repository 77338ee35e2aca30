// One source for two languages: what lies under shaders/, but for the .comp files, is compiled as GLSL for devices and as
// C++ for the CPU, where it is included inside a namespace or a class that has GLM's names in view.
//
// The common subset: every float literal has its `f` (C++ would compute in double), no swizzles, no implicit conversions, no
// array constructors; a parameter that is written to is INOUT(T), a constant of a file is CONSTANT,
// and a function of a file under shared/ is a SHARED_FUNCTION; no built-in of GLSL whose result the host cannot repeat where
// bits matter (normalize, inversesqrt, fma, min and max on a possible NaN, sin, cos, pow).
#ifndef RAIG_LANGUAGE
#define RAIG_LANGUAGE

#ifdef __cplusplus
#define INOUT(T) T&
#define CONSTANT static constexpr
#define SHARED_FUNCTION inline
#define precise
#else
#define INOUT(T) inout T
#define CONSTANT const
#define SHARED_FUNCTION
#endif

#endif
