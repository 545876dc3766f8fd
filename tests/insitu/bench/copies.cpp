// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstring>
#include <limits>
#include <vector>

#include "core/data/scalar.h"
#include "insitu/client/snapshot.h"
#include "tests/insitu/bench/parts.h"

namespace gxy::bench {

namespace {

/// How the values lie: bytes from one to the next, and from one row to the next in values.
struct Layout {
  const char* name;
  ScalarType type;
  int64_t stride, rowValues;
};

}  // namespace

nlohmann::json copies(const Index3& points, int repeats) {
  const Layout layouts[] = {{"contiguous", ScalarType::Float32, 4, points[0]},
                            {"half rows", ScalarType::Float32, 4, 2 * points[0]},
                            {"float64", ScalarType::Float64, 8, points[0]},
                            {"structures", ScalarType::Float32, 32, points[0]}};
  const Extent block{{0, 0, 0}, points};
  nlohmann::json result = nlohmann::json::object();
  for (const Layout& l : layouts) {
    const size_t bytes = size_t(block.count()) * bytesOf(l.type);
    const int64_t row = l.stride * l.rowValues;
    std::vector<std::byte> array(size_t(row * points[1] * points[2]), std::byte(1)), to(bytes),
        plain(bytes, std::byte(1));
    const gxy_array values{array.data(), int(l.type), 1, {l.stride, row, row * points[1]}, 0, 0};
    double copied = std::numeric_limits<double>::infinity(), memcpied = copied;
    for (int i = 0; i < repeats; i++) {
      const double begin = now();
      std::memcpy(to.data(), plain.data(), bytes);
      const double middle = now();
      insitu::copyPoints(values, block, block, to.data());
      memcpied = std::min(memcpied, middle - begin);
      copied = std::min(copied, now() - middle);
    }
    result[l.name] = {{"bytes", bytes},
                      {"GB/s", 1e-9 * double(bytes) / copied},
                      {"memcpy GB/s", 1e-9 * double(bytes) / memcpied}};
  }
  return result;
}

}  // namespace gxy::bench
