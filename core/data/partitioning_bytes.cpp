// SPDX-License-Identifier: Apache-2.0
#include "core/data/partitioning_bytes.h"

#include <utility>

#include "core/comm/wire.h"

namespace gxy {

Bytes written(const Partitioning& p) {
  std::vector<int32_t> owners;
  for (int i = 0; i < p.partitions(); i++) owners.push_back(p.owner(i));
  Writer w;
  for (int a = 0; a < 3; a++) w.write(p.faces(a));
  return w.write(p.cellPartition()).write(owners).take();
}

Partitioning readPartitioning(std::span<const std::byte> message) {
  Reader r(message, "partitioning");
  std::array<std::vector<double>, 3> faces;
  for (auto& f : faces) f = r.readVector<double>();
  auto cells = r.readVector<int32_t>(), owners = r.readVector<int32_t>();
  return {std::move(faces), std::move(cells), std::move(owners)};
}

}  // namespace gxy
