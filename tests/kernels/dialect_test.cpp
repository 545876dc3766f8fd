// SPDX-License-Identifier: Apache-2.0
// One text, the same bits: probe.h in C++ against the three ISPC targets, and with denormals kept against flushed.
#include "tests/kernels/dialect_probe.h"

#include <gtest/gtest.h>
#include <xmmintrin.h>

#include <string_view>
#include <vector>

#include "core/kernels/single.h"

#define FN inline
#define R(x) real(x)
#define OUT(T) T&
namespace gxy::single {
#include "tests/kernels/probe.h"
}  // namespace gxy::single
#undef FN
#undef R
#undef OUT

extern "C" {
void probe_sse4(int count, float* out);
void probe_avx2(int count, float* out);
void probe_avx512skx(int count, float* out);
}

namespace gxy {

std::vector<float> probesInCpp() {
  std::vector<float> out(std::size_t(PROBES) * kProbeInputs);
  for (int f = 0; f < PROBES; ++f)
    for (int i = 0; i < kProbeInputs; ++i)
      out[std::size_t(f) * kProbeInputs + std::size_t(i)] = single::probe(f, unsigned(i));
  return out;
}

void expectSameProbes(const std::vector<float>& a, const std::vector<float>& b) {
  for (int f = 0; f < PROBES; ++f) {
    int different = 0, first = -1;
    for (int i = 0; i < kProbeInputs; ++i) {
      float x = a[std::size_t(f) * kProbeInputs + std::size_t(i)],
            y = b[std::size_t(f) * kProbeInputs + std::size_t(i)];
      bool same =
          std::bit_cast<unsigned>(x) == std::bit_cast<unsigned>(y) || (std::isnan(x) && std::isnan(y));
      if (!same && different++ == 0) first = i;
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
  std::vector<float> out(std::size_t(PROBES) * kProbeInputs);
  probe(kProbeInputs, out.data());
  return out;
}

bool runs(const char* isa) {
  __builtin_cpu_init();
  return std::string_view(isa) == "avx2" ? __builtin_cpu_supports("avx2")
                                         : __builtin_cpu_supports("avx512vl");
}

TEST(Dialect, ProbesAreNumbersThatVary) {
  std::vector<float> out = probesInCpp();
  for (int f = 0; f < PROBES; ++f) {
    auto first = out.begin() + std::ptrdiff_t(f) * kProbeInputs;
    std::vector<float> values(first, first + kProbeInputs);
    EXPECT_EQ(std::count_if(values.begin(), values.end(), [](float x) { return std::isnan(x); }), 0) << f;
    std::sort(values.begin(), values.end());
    EXPECT_GT(std::unique(values.begin(), values.end()) - values.begin(), 100) << f;
  }
}

TEST(Dialect, IspcSse4HasTheBitsOfCpp) { expectSameProbes(probesInCpp(), inIspc(probe_sse4)); }
TEST(Dialect, WiderIspcTargetsHaveTheBitsOfCpp) {
  std::vector<float> cpp = probesInCpp();
  if (runs("avx2")) expectSameProbes(cpp, inIspc(probe_avx2));
  if (runs("avx512skx")) expectSameProbes(cpp, inIspc(probe_avx512skx));
}

TEST(Dialect, FlushingDenormalsChangesNoBit) {
  std::vector<float> kept = probesInCpp();
  FlushDenormals flush;
  expectSameProbes(kept, probesInCpp());
  expectSameProbes(kept, inIspc(probe_sse4));
}

}  // namespace
}  // namespace gxy
