// What the shared libraries show of themselves.
#pragma once

/// Marks the namespace of a public header: `namespace CONSIMD_EXPORT consimd {`. What is declared in that block a
/// shared library exports, types with their type information, so that an exception or a type is the same on both sides;
/// everything else is compiled with hidden visibility. Where libraries have no such attribute, on Windows, it says
/// nothing, and the libraries are static ones.
#if defined(_WIN32)
#define CONSIMD_EXPORT
#else
#define CONSIMD_EXPORT [[gnu::visibility("default")]]
#endif
