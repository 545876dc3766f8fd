// SPDX-License-Identifier: Apache-2.0
#include <cstring>
#include <filesystem>

#include "core/io/file.h"
#include "core/io/write_geometry.h"
#include "core/io/write_volume.h"
#include "core/scene/state_file.h"
#include "tests/random/random_scene.h"

namespace gxy::test {

namespace {

void save(const WholeVolume& volume, const std::string& path) {
  const bool encoded = volume.shift != 0 || volume.scale != 1;
  const ScalarType type = encoded ? ScalarType::Float64 : volume.stored;
  Samples samples = volume.samples;
  if (encoded) {
    const size_t n = samples.size() / sizeof(float);
    samples.resize(n * sizeof(double));
    for (size_t i = 0; i < n; i++) {
      float stored;
      std::memcpy(&stored, volume.samples.data() + i * sizeof stored, sizeof stored);
      const double value = volume.shift + volume.scale * double(stored);
      std::memcpy(samples.data() + i * sizeof value, &value, sizeof value);
    }
  }
  VolumeWriter(path, volume.grid, {{"data", type, volume.components, {}}}).write(0, 0, samples);
}

}  // namespace

std::string saveScene(const TestScene& scene, const std::string& folder) {
  std::filesystem::create_directories(folder);
  const State state = stateOf(scene);
  for (size_t i = 0; i < scene.data.size(); i++) {
    const std::string path = folder + "/" + state.datasets[i].filename;
    if (const auto* volume = std::get_if<std::shared_ptr<const WholeVolume>>(&scene.data[i])) {
      save(**volume, path);
    } else {
      const auto& geometry = *std::get<std::shared_ptr<const WholeGeometry>>(scene.data[i]);
      writeGeometry(path, geometry.block, geometry.kind);
    }
  }
  const std::string path = folder + "/scene.state.json";
  writeText(path, writeState(state));
  return path;
}

}  // namespace gxy::test
