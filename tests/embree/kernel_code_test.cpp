// SPDX-License-Identifier: Apache-2.0
// What a kernel does not do it has no code for: a scene with isosurfaces only runs nothing that was compiled with a march
// in it. Methods are known in the object files of the kernels by numbers and names that nothing else needs.
#include <gtest/gtest.h>

#include <cstring>
#include <set>
#include <string>
#include <vector>

#include "core/io/file.h"

namespace gxy {
namespace {

using Names = std::set<std::string>;

/// The kernel files whose code, for every instruction set, has some bytes in it.
Names kernelsWith(const std::string& bytes) {
  std::vector<Names> found;  // by instruction set
  for (const char* isa : {"sse4", "avx2", "avx512skx"}) {
    Names& here = found.emplace_back();
    for (const char* name : {"spawn", "geometry", "fields", "integrate", "integrate_volumes", "shade"}) {
      const std::string object = readText(std::string(KERNELS) + "/" + name + "_" + isa + ".o");
      if (object.find(bytes) != std::string::npos) here.insert(name);
    }
    EXPECT_EQ(here, found[0]) << isa;
  }
  return found[0];
}

template <class T>
Names kernelsWithNumber(T number) {
  std::string bytes(sizeof number, '\0');
  std::memcpy(bytes.data(), &number, sizeof number);
  return kernelsWith(bytes);
}

TEST(KernelCode, MeansOfMapsAreInMarchesOnly) {  // 1/12 in cell_curve.h
  EXPECT_EQ(kernelsWithNumber(1 / 12.f), (Names{"integrate", "integrate_volumes"}));
}

TEST(KernelCode, ExponentialsAreInMarchesAndShadingOnly) {  // splitExp in elementary.h
  EXPECT_EQ(kernelsWithNumber(0.0083688358f), (Names{"integrate", "integrate_volumes", "shade"}));
}

TEST(KernelCode, OcclusionDirectionsAreInShadingOnly) {  // hash1 in light.h
  EXPECT_EQ(kernelsWithNumber(747796405u), (Names{"shade"}));
}

TEST(KernelCode, IsosurfaceWalksAreInFieldsOnly) {  // where one begins, in isosurface.h
  EXPECT_EQ(kernelsWithNumber(0.9999998f), (Names{"fields"}));
}

TEST(KernelCode, TreesAreInGeometryOnly) {  // 1e37 in geometry.ispc
  EXPECT_EQ(kernelsWithNumber(1e37f), (Names{"geometry"}));
}

}  // namespace
}  // namespace gxy
