// SPDX-License-Identifier: Apache-2.0
#include "truth.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "gxy/comm/error.h"
#include "gxy/scene/state_file.h"
#include "gxyrender/reference_scene.h"

namespace gxy::bench {
namespace {

constexpr const char* kFormat =
    "gxybench truth 1\n";  // changes with what the reference means or the file holds
constexpr double kMiss = 1e30;
constexpr double kPerturbation = 8;  // ulps of float
constexpr int kPerturbations = 6;

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
  template <class T>
  void add(const std::vector<T>& v) {
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
  for (const auto& [p, block] : volume.blocks) {
    hash.add(&block.extent, sizeof block.extent);
    hash.add(block.samples);
  }
}

void addGeometry(Hash& hash, const Geometry& geometry) {
  for (const auto& [p, block] : geometry.blocks) {
    hash.add(block.points), hash.add(block.normals), hash.add(block.values);
    hash.add(block.triangles), hash.add(block.segments), hash.add(block.neighbours);
  }
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
    if (data.geometry) addGeometry(hash, *data.geometry);
  }
  return hash.text();
}

template <class Stream, class Do>
void forEachPart(Stream& truth, Do what) {
  what(truth.rgb), what(truth.low), what(truth.high);
  what(truth.depth), what(truth.nearest), what(truth.farthest);
}

/// Written beside its place and moved there, so that an interrupted run leaves no half of a file.
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

/// False where there is none, or none that is whole.
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
  const Camera& camera = state.cameras.at(0);
  const bool surfaces = hasSurfaces(scene.visualization);
  const int pictures = surfaces ? 1 + kPerturbations : 1;
  reference::ReferenceOptions how;
  if (scene.visualization.lighting.aoCount > 0)
    how.aoHook = occlusionDirections(scene.visualization.lighting.aoCount, camera.dimensions.x, 0);
  int done = 0;
  how.progress = [&](double f) { progress((done + f) / pictures); };
  const auto one = [&] {
    reference::ReferencePicture picture = reference::renderReference(scene, camera, how);
    reference::applyBackground(picture, state.settings.background);
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
  for (const OperatorData& data : loaded.data.at(0))
    if (data.volume)
      return std::min(
          {data.volume->grid.spacing.x, data.volume->grid.spacing.y, data.volume->grid.spacing.z});
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

namespace {

/// One picture against the truth, pixel by pixel.
class Comparison {
 public:
  Comparison(const Truth& truth, const Picture& picture, double tolerance)
      : truth_(truth), picture_(picture), tolerance_(tolerance) {}

  double difference(size_t p) const {
    double worst = 0;
    for (size_t c = 0; c < 3; c++) {
      const double d = std::abs(double(picture_.rgba[4 * p + c]) - truth_.rgb[3 * p + c]);
      worst = std::isnan(d) ? INFINITY : std::max(worst, d);
    }
    return worst;
  }

  bool isFlip(size_t p) const {
    if (truth_.low.empty()) return false;
    bool changes = false, among = true;
    for (size_t c = 0; c < 3; c++) {
      const double low = truth_.low[3 * p + c], high = truth_.high[3 * p + c], x = picture_.rgba[4 * p + c];
      changes = changes || high - low > 0.5 * tolerance_;
      among = among && x >= low - tolerance_ && x <= high + tolerance_;
    }
    return changes && among;
  }

  bool isDepthFlip(size_t p) const {
    const double slack = 0.5 * truth_.cell, t = picture_.depth[p];
    return truth_.farthest[p] - truth_.nearest[p] > slack && t >= truth_.nearest[p] - slack &&
           t <= truth_.farthest[p] + slack;
  }

 private:
  const Truth& truth_;
  const Picture& picture_;
  double tolerance_;
};

/// Of the hits that are where they should be, in cells.
struct Distances {
  double squares = 0;
  int64_t count = 0;
};

/// What the hit of pixel p is; true where the difference is a flip.
bool compareHit(const Truth& truth, const Picture& picture, const Comparison& comparison, size_t p, Row& row,
                Distances& distances) {
  const bool mine = picture.depth[p] < kMiss, theirs = truth.depth[p] < kMiss;
  if (!mine && !theirs) return false;
  row.hits += theirs;
  const double dt = mine && theirs ? std::abs(picture.depth[p] - truth.depth[p]) / truth.cell : INFINITY;
  if (dt <= 0.5) {
    distances.squares += dt * dt;
    distances.count++;
    row.dtMax = std::max(row.dtMax, dt);
    return false;
  }
  if (comparison.isDepthFlip(p)) return true;
  (!mine ? row.missed : !theirs ? row.extra : row.wrongSheet)++;
  return false;
}

}  // namespace

void compareWith(const Truth& truth, const Picture& picture, bool isosurfacesAlone, Row& row) {
  if (picture.width != truth.width || picture.height != truth.height)
    throw Error("the picture is " + std::to_string(picture.width) + " x " + std::to_string(picture.height) +
                " pixels, its reference " + std::to_string(truth.width) + " x " +
                std::to_string(truth.height));
  const Comparison comparison(truth, picture, row.tolerance);
  const size_t pixels = truth.depth.size();
  double squares = 0;
  Distances distances;
  row.flips = 0;
  row.hits = isosurfacesAlone ? 0 : -1;
  row.missed = row.extra = row.wrongSheet = 0;
  row.dtMax = 0;
  std::vector<double> worst;
  for (size_t p = 0; p < pixels; p++) {
    const bool depthFlip = isosurfacesAlone && compareHit(truth, picture, comparison, p, row, distances);
    const double d = comparison.difference(p);
    if (depthFlip || (d > row.tolerance && comparison.isFlip(p))) {
      row.flips++;
      continue;
    }
    worst.push_back(d);
    for (size_t c = 0; c < 3; c++) {
      const double e = double(picture.rgba[4 * p + c]) - truth.rgb[3 * p + c];
      squares += e * e;
    }
  }
  const double counted = double(std::max<size_t>(worst.size(), 1));
  row.rmsError = std::sqrt(squares / (3 * counted));
  std::sort(worst.begin(), worst.end());
  row.maxError = worst.empty() ? 0 : worst.back();
  row.p999Error = worst.empty() ? 0 : worst[size_t(std::ceil(0.999 * counted)) - 1];
  row.dtRms = std::sqrt(distances.squares / double(std::max<int64_t>(distances.count, 1)));
}

}  // namespace gxy::bench
