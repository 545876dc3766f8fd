// SPDX-License-Identifier: Apache-2.0
// One text, the same bits: the kernels about lines in C++ against the three ISPC targets, and with denormals kept against flushed.
#include <gtest/gtest.h>
#include <xmmintrin.h>

#include <algorithm>
#include <set>
#include <vector>

#include "core/kernels/single.h"
#include "tests/lines/line_dialect_probe.h"

#define FN inline
#define R(x) real(x)
#define UNIFORM
namespace gxy::single {
#include "tests/lines/line_probe.h"
}  // namespace gxy::single
#undef FN
#undef R
#undef UNIFORM

extern "C" {
void line_probe_sse4(int count, float* out);
void line_probe_avx2(int count, float* out);
void line_probe_avx512skx(int count, float* out);
}

namespace gxy::test {

std::vector<float> lineProbesInCpp() {
  std::vector<float> out(size_t(LINE_PROBES) * kLineInputs);
  for (int f = 0; f < LINE_PROBES; f++)
    for (int i = 0; i < kLineInputs; i++)
      out[size_t(f) * kLineInputs + size_t(i)] = single::lineProbe(f, unsigned(i));
  return out;
}

void expectSameLineProbes(const std::vector<float>& a, const std::vector<float>& b) {
  for (int f = 0; f < LINE_PROBES; f++) {
    int different = 0, first = -1;
    for (int i = 0; i < kLineInputs; i++) {
      const size_t at = size_t(f) * kLineInputs + size_t(i);
      if (std::bit_cast<uint32_t>(a[at]) != std::bit_cast<uint32_t>(b[at]) && different++ == 0) first = i;
    }
    EXPECT_EQ(different, 0) << "probe " << f << ", first at input " << first;
  }
}

namespace {

// Denormal operands and results as 0 while alive (the mode that Embree asks for).
class FlushDenormals {
 public:
  FlushDenormals() : saved_(_mm_getcsr()) { _mm_setcsr(saved_ | 0x8040u); }
  ~FlushDenormals() { _mm_setcsr(saved_); }

 private:
  unsigned saved_;
};

std::vector<float> inIspc(void (*probe)(int, float*)) {
  std::vector<float> out(size_t(LINE_PROBES) * kLineInputs);
  probe(kLineInputs, out.data());
  return out;
}

// And in GLSL, since its probes have the same bits.
TEST(Philox, HasItsKnownAnswersInCppAndIspc) {
  const uint32_t known[] = {0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8, 0x408f276d, 0x41c83b0e,
                            0xa20bc7c6, 0x6d5451fd, 0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1};
  std::vector<std::vector<float>> dialects{lineProbesInCpp(), inIspc(line_probe_sse4)};
  if (__builtin_cpu_supports("avx2")) dialects.push_back(inIspc(line_probe_avx2));
  if (__builtin_cpu_supports("avx512vl")) dialects.push_back(inIspc(line_probe_avx512skx));
  for (size_t k = 0; k < dialects.size(); k++)
    for (size_t i = 0; i < std::size(known); i++) {
      const float* halves = &dialects[k][size_t(44) * kLineInputs + 2 * i];
      EXPECT_EQ(halves[0], float(known[i] >> 16)) << "dialect " << k << ", word " << i;
      EXPECT_EQ(halves[1], float(known[i] & 0xffff)) << "dialect " << k << ", word " << i;
    }
}

TEST(LineDialect, ProbesAreNumbersThatVary) {
  const std::vector<float> out = lineProbesInCpp();
  for (int f = 0; f < LINE_PROBES; f++) {
    const auto first = out.begin() + std::ptrdiff_t(f) * kLineInputs;
    EXPECT_EQ(std::count_if(first, first + kLineInputs, [](float x) { return std::isnan(x); }), 0) << f;
    EXPECT_GT(std::set<float>(first, first + kLineInputs).size(), 100u) << f;
  }
}

TEST(LineDialect, IspcHasTheBitsOfCppOnEachInstructionSet) {
  const std::vector<float> cpp = lineProbesInCpp();
  expectSameLineProbes(cpp, inIspc(line_probe_sse4));
  if (__builtin_cpu_supports("avx2")) expectSameLineProbes(cpp, inIspc(line_probe_avx2));
  if (__builtin_cpu_supports("avx512vl")) expectSameLineProbes(cpp, inIspc(line_probe_avx512skx));
}

TEST(LineDialect, FlushingDenormalsChangesNoBit) {
  const std::vector<float> kept = lineProbesInCpp();
  const FlushDenormals flush;
  expectSameLineProbes(kept, lineProbesInCpp());
  expectSameLineProbes(kept, inIspc(line_probe_sse4));
}

}  // namespace
}  // namespace gxy::test
