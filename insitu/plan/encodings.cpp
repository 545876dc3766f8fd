// SPDX-License-Identifier: Apache-2.0
#include "insitu/plan/encodings.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/comm/error.h"
#include "core/comm/wire.h"

namespace gxy::insitu {

const FieldEncoding* encodingIn(const Encodings& encodings, size_t mesh, size_t field) {
  for (const FieldEncoding& e : encodings)
    if (e.mesh == mesh && e.field == field) return &e;
  return nullptr;
}

bool mayBeEncoded(std::span<const Mesh> meshes, const FieldEncoding& e) {
  if (e.mesh >= meshes.size() || meshes[e.mesh].kind != Mesh::Kind::Grid ||
      e.field >= meshes[e.mesh].fields.size())
    return false;
  const Field& field = meshes[e.mesh].fields[e.field];
  int exponent = 0;
  return field.type == ScalarType::Float64 && std::isfinite(e.shift) &&
         (field.components == 1 || e.shift == 0) && std::frexp(e.scale, &exponent) == 0.5 &&
         std::abs(exponent) < 1000;
}

std::vector<Mesh> encoded(std::vector<Mesh> meshes, const Encodings& encodings) {
  for (const FieldEncoding& e : encodings) meshes[e.mesh].fields[e.field].type = ScalarType::Float32;
  return meshes;
}

Bytes written(const Encodings& encodings) { return Writer().write(encodings).take(); }

Encodings readEncodings(std::span<const std::byte> message, std::span<const Mesh> meshes) {
  Reader r(message, "encodings of a stream");
  Encodings encodings = r.readVector<FieldEncoding>();
  r.expectEnd();
  for (const FieldEncoding& e : encodings) {
    const bool once = std::count_if(encodings.begin(), encodings.end(), [&](const FieldEncoding& other) {
                        return other.mesh == e.mesh && other.field == e.field;
                      }) == 1;
    if (!once || !mayBeEncoded(meshes, e))
      r.fail("field " + std::to_string(e.field) + " of mesh " + std::to_string(e.mesh) + " with shift " +
             std::to_string(e.shift) + " and scale " + std::to_string(e.scale) +
             ", expected doubles of grids, each once, and powers of two");
  }
  return encodings;
}

}  // namespace gxy::insitu
