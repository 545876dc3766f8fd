// SPDX-License-Identifier: Apache-2.0
// One text, the same bits: probe.h in C++ against the three ISPC targets, and with denormals kept against flushed.
#include <gtest/gtest.h>
#include <xmmintrin.h>

#include <string_view>
#include <vector>

#include "gxy/kernels/single.h"

#define FN inline
#define R(x) real(x)
#define OUT(T) T&
namespace gxy::single {
#include "probe.h"
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
namespace {

constexpr int kCount = 50'000;

// Denormal operands and results as 0 while alive (the mode that Embree asks for).
class FlushDenormals {
 public:
  FlushDenormals() : saved_(_mm_getcsr()) { _mm_setcsr(saved_ | 0x8040u); }
  ~FlushDenormals() { _mm_setcsr(saved_); }

 private:
  unsigned saved_;
};

std::vector<float> inCpp() {
  std::vector<float> out(std::size_t(PROBES) * kCount);
  for (int f = 0; f < PROBES; ++f)
    for (int i = 0; i < kCount; ++i)
      out[std::size_t(f) * kCount + std::size_t(i)] = single::probe(f, unsigned(i));
  return out;
}

std::vector<float> inIspc(void (*probe)(int, float*)) {
  std::vector<float> out(std::size_t(PROBES) * kCount);
  probe(kCount, out.data());
  return out;
}

void expectSameBits(const std::vector<float>& a, const std::vector<float>& b) {
  for (int f = 0; f < PROBES; ++f) {
    int different = 0, first = -1;
    for (int i = 0; i < kCount; ++i) {
      float x = a[std::size_t(f) * kCount + std::size_t(i)], y = b[std::size_t(f) * kCount + std::size_t(i)];
      bool same =
          std::bit_cast<unsigned>(x) == std::bit_cast<unsigned>(y) || (std::isnan(x) && std::isnan(y));
      if (!same && different++ == 0) first = i;
    }
    EXPECT_EQ(different, 0) << "probe " << f << ", first at input " << first;
  }
}

bool runs(const char* isa) {
  __builtin_cpu_init();
  return std::string_view(isa) == "avx2" ? __builtin_cpu_supports("avx2")
                                         : __builtin_cpu_supports("avx512vl");
}

TEST(Dialect, ProbesAreNumbersThatVary) {
  std::vector<float> out = inCpp();
  for (int f = 0; f < PROBES; ++f) {
    auto first = out.begin() + std::ptrdiff_t(f) * kCount;
    std::vector<float> values(first, first + kCount);
    EXPECT_EQ(std::count_if(values.begin(), values.end(), [](float x) { return std::isnan(x); }), 0) << f;
    std::sort(values.begin(), values.end());
    EXPECT_GT(std::unique(values.begin(), values.end()) - values.begin(), 100) << f;
  }
}

TEST(Dialect, IspcSse4HasTheBitsOfCpp) { expectSameBits(inCpp(), inIspc(probe_sse4)); }
TEST(Dialect, WiderIspcTargetsHaveTheBitsOfCpp) {
  std::vector<float> cpp = inCpp();
  if (runs("avx2")) expectSameBits(cpp, inIspc(probe_avx2));
  if (runs("avx512skx")) expectSameBits(cpp, inIspc(probe_avx512skx));
}

TEST(Dialect, FlushingDenormalsChangesNoBit) {
  std::vector<float> kept = inCpp();
  FlushDenormals flush;
  expectSameBits(kept, inCpp());
  expectSameBits(kept, inIspc(probe_sse4));
}

}  // namespace
}  // namespace gxy
