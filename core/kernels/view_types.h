// SPDX-License-Identifier: Apache-2.0
// What the structures that the host fills in are made of. The host fills them in namespace gxy::single (ISPC reads the same bytes) or
// gxy::twin. In GLSL, and in C++ that writes for GLSL (GXY_LAYOUT: the structures alone), the members that are pointers elsewhere are
// places in a buffer.

#if defined(GXY_GLSL) || defined(GXY_LAYOUT)
#define PTR(T) uint
#define RAW uint
#elif defined(ISPC)
#define PTR(T) const uniform T* uniform
#define RAW const void* uniform
#define BYTE unsigned int8
#else
#define PTR(T) const T*
#define RAW const void*
#define BYTE std::uint8_t
#endif
