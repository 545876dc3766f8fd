// SPDX-License-Identifier: Apache-2.0
// EXPORT, in ISPC, begins a function that C++ calls. A plain `export` compiles each function a second time, for calls from ISPC,
// which nobody makes here; that doubles the time that the compiler takes, and more.
#if ISPC_MAJOR_VERSION > 1 || (ISPC_MAJOR_VERSION == 1 && ISPC_MINOR_VERSION >= 26)
#define EXPORT export __attribute__((external_only))
#else
#define EXPORT export
#endif
