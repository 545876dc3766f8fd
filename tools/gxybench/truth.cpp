// SPDX-License-Identifier: Apache-2.0
#include "tools/gxybench/truth.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "core/comm/error.h"
#include "core/scene/state_file.h"
#include "tools/gxyrender/reference_scene.h"

namespace gxy::bench {
namespace {

// Must be changed with the meaning of the reference or the format of the file.
constexpr const char* kFormat = "gxybench truth 3\n";
constexpr double kPerturbation = 8;  // ulps of float
constexpr int kPerturbations = 24;

/// FNV-1a over eight bytes at a time, with a finaliser.
class Hash {
 public:
  void add(const void* data, size_t bytes) {
    const auto* p = static_cast<const unsigned char*>(data);
    for (; bytes >= 8; p += 8, bytes -= 8) {
      uint64_t word;
      std::memcpy(&word, p, 8);
      step(word);
    }
    for (; bytes > 0; p++, bytes--) step(*p);
  }
  template <class T, class Allocator>
  void add(const std::vector<T, Allocator>& v) {
    step(v.size());
    add(v.data(), v.size() * sizeof(T));
  }
  template <class T>
  void add(const SharedVector<T>& v) {
    step(v.size());
    add(v.data(), v.size() * sizeof(T));
  }
  void add(const std::string& s) {
    step(s.size());
    add(s.data(), s.size());
  }
  std::string text() const {
    char digits[20];
    std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(state_ ^ (state_ >> 29)));
    return digits;
  }

 private:
  void step(uint64_t word) {
    state_ = (state_ ^ word) * 0x100000001b3u;
    state_ ^= state_ >> 32;
  }
  uint64_t state_ = 0xcbf29ce484222325u;
};

void addVolume(Hash& hash, const Volume& volume) {
  hash.add(&volume.grid.origin, sizeof volume.grid.origin),
      hash.add(&volume.grid.spacing, sizeof volume.grid.spacing);
  hash.add(&volume.stored, sizeof volume.stored), hash.add(&volume.components, sizeof volume.components);
  hash.add(&volume.shift, sizeof volume.shift), hash.add(&volume.scale, sizeof volume.scale);
  for (const auto& [p, block] : volume.blocks) {
    hash.add(&block.extent, sizeof block.extent);
    hash.add(block.samples);
  }
}

void addMesh(Hash& hash, const Mesh& mesh) {
  hash.add(&mesh.components, sizeof mesh.components);
  hash.add(&mesh.shift, sizeof mesh.shift), hash.add(&mesh.scale, sizeof mesh.scale);
  for (const auto& [p, block] : mesh.blocks) {
    hash.add(block.points), hash.add(block.values);
    for (const auto& cells : block.cells.points) hash.add(cells);
    if (mesh.ofCells) hash.add(block.cellValues);
  }
}

void addGeometry(Hash& hash, const OwnedGeometry& geometry) {
  const GeometryBlock& block = geometry.block;
  hash.add(&geometry.kind, sizeof geometry.kind);
  hash.add(block.points), hash.add(block.normals), hash.add(block.values);
  hash.add(block.triangles), hash.add(block.segments), hash.add(block.neighbours);
  if (!block.colors.empty()) hash.add(block.colors);
  for (const PointField& field : block.fields) hash.add(field.values);
}

std::string contentOf(State state, const LoadedState& loaded) {
  for (DatasetSpec& d : state.datasets) d.filename = "data";
  state.settings.tolerance = RenderSettings().tolerance;
  state.settings.step = 0;
  Hash hash;
  hash.add(std::string(kFormat));
  hash.add(writeState(state));
  for (const OperatorData& data : loaded.data.at(0)) {
    if (data.volume) addVolume(hash, *data.volume);
    if (data.mesh) addMesh(hash, *data.mesh);
    if (data.owned) addGeometry(hash, *data.owned);
  }
  return hash.text();
}

template <class Stream, class Do>
void forEachPart(Stream& truth, Do what) {
  what(truth.rgb), what(truth.low), what(truth.high);
  what(truth.depth), what(truth.nearest), what(truth.farthest);
}

/// Writes the file beside its place and moves it there, so that an interrupted run leaves no partial file.
void store(const Truth& truth, const std::string& path) {
  const std::string partial = path + "." + std::to_string(::getpid());
  {
    std::ofstream out(partial, std::ios::binary);
    out << kFormat << truth.width << ' ' << truth.height << ' ';
    forEachPart(truth, [&](const auto& v) { out << v.size() << ' '; });
    out << '\n';
    forEachPart(truth, [&](const auto& v) {
      out.write(reinterpret_cast<const char*>(v.data()), std::streamsize(v.size() * sizeof(v[0])));
    });
    if (!out.flush()) throw Error(partial + ": cannot be written");
  }
  std::filesystem::rename(partial, path);
}

/// Reads a truth. Returns false if there is no file or it is not complete.
bool load(const std::string& path, size_t pixels, Truth& truth) {
  std::ifstream in(path, std::ios::binary);
  std::string format;
  if (!std::getline(in, format) || format + '\n' != kFormat) return false;
  std::vector<size_t> sizes(6);
  in >> truth.width >> truth.height;
  for (size_t& n : sizes) in >> n;
  in.ignore(2);
  if (!in || *std::max_element(sizes.begin(), sizes.end()) > 3 * pixels) return false;
  auto size = sizes.begin();
  forEachPart(truth, [&](auto& v) {
    v.resize(*size++);
    in.read(reinterpret_cast<char*>(v.data()), std::streamsize(v.size() * sizeof(v[0])));
  });
  return bool(in) && truth.rgb.size() == 3 * pixels;
}

bool hasSurfaces(const Visualization& visualization) {
  return std::any_of(visualization.operators.begin(), visualization.operators.end(), [](const Vis& v) {
    return v.type != VisType::Volume || !v.isovalues.empty() || !v.slices.empty() || !v.clipPlanes.empty();
  });
}

void widen(Truth& truth, const reference::ReferencePicture& picture) {
  for (size_t p = 0; p < picture.depth.size(); p++) {
    for (size_t c = 0; c < 3; c++) {
      const auto x = float(picture.rgba[4 * p + c]);
      truth.low[3 * p + c] = std::min(truth.low[3 * p + c], x);
      truth.high[3 * p + c] = std::max(truth.high[3 * p + c], x);
    }
    truth.nearest[p] = std::min(truth.nearest[p], picture.depth[p]);
    truth.farthest[p] = std::max(truth.farthest[p], picture.depth[p]);
  }
}

Truth render(const State& state, const LoadedState& loaded, const Progress& progress) {
  const reference::ReferenceScene scene = referenceScene(state, loaded, 0);
  const Camera camera = loaded.camera(picturesOf(state).at(0));
  const bool surfaces = hasSurfaces(scene.visualization);
  const int pictures = surfaces ? 1 + kPerturbations : 1;
  reference::ReferenceOptions how;
  if (scene.visualization.lighting.aoCount > 0)
    how.aoHook = occlusionDirections(scene.visualization.lighting.aoCount, camera.dimensions.x, 0);
  int done = 0;
  how.progress = [&](double f) { progress((done + f) / pictures); };
  const auto one = [&] {
    reference::ReferencePicture picture = reference::renderReference(scene, camera, how);
    reference::applyBackground(picture, state.settings);
    done++;
    return picture;
  };

  Truth truth;
  const reference::ReferencePicture exact = one();
  truth.width = exact.width, truth.height = exact.height;
  for (size_t p = 0; p < exact.depth.size(); p++)
    for (size_t c = 0; c < 3; c++) truth.rgb.push_back(float(exact.rgba[4 * p + c]));
  truth.depth = exact.depth;
  if (surfaces) {
    truth.low = truth.high = truth.rgb;
    truth.nearest = truth.farthest = truth.depth;
    how.perturbation = kPerturbation;
    for (how.seed = 0; how.seed < uint64_t(kPerturbations); how.seed++) widen(truth, one());
  }
  return truth;
}

double smallestCell(const LoadedState& loaded) {
  for (const OperatorData& data : loaded.data.at(0)) {
    if (data.volume)
      return std::min(
          {data.volume->grid.spacing.x, data.volume->grid.spacing.y, data.volume->grid.spacing.z});
    if (data.mesh) return typicalLength(*data.mesh);
  }
  return 0;
}

}  // namespace

Truth truthOf(const State& state, const std::string& directory, const std::string& cache,
              const Progress& progress) {
  SingleRank alone;
  Ledger ledger;
  RenderOptions whole;
  whole.partitions = {1, 1, 1};
  const LoadedState loaded = loadData(state, directory, whole, alone, ledger);
  const std::filesystem::path folder = std::filesystem::path(cache) / "references";
  const std::string path = (folder / contentOf(state, loaded)).string();
  const glm::ivec2 size = state.cameras.at(0).dimensions;
  Truth truth;
  if (!load(path, size_t(size.x) * size_t(size.y), truth)) {
    truth = render(state, loaded, progress);
    std::filesystem::create_directories(folder);
    store(truth, path);
  }
  truth.cell = smallestCell(loaded);
  return truth;
}

}  // namespace gxy::bench
