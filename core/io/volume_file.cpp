// SPDX-License-Identifier: Apache-2.0
#include "gxy/io/volume_file.h"

#include <algorithm>
#include <cstring>

#include "gxy/comm/error.h"
#include "gxy/io/file.h"
#include "gxy/io/legacy_vtk.h"
#include "gxy/io/volume_formats.h"

namespace gxy {

namespace {

/// Some of the components of samples. They lie between the others, so those are read, too, but not kept.
class SomeComponents final : public SampleSource {
 public:
  SomeComponents(const VolumeFile& file, std::vector<int> components)
      : source_(file.source),
        bytesPerPoint_(file.bytesPerPoint()),
        bytesPerSample_(bytesOf(file.array.type)),
        components_(std::move(components)) {}

  uint64_t piecesNotRead() const override { return source_->piecesNotRead(); }
  bool readsPartsAlone() const override { return source_->readsPartsAlone(); }

  void read(const Extent& extent, std::span<std::byte> out) const override {
    Extent slab = extent;
    const int64_t end = extent.first[2] + extent.points[2];
    const int64_t each = extent.points[0] * extent.points[1] * int64_t(bytesPerPoint_);
    const int64_t depth = std::max<int64_t>(1, kSlabBytes / each);
    std::vector<std::byte> all;
    for (; slab.first[2] < end; slab.first[2] += depth) {
      slab.points[2] = std::min(depth, end - slab.first[2]);
      all.resize(size_t(slab.count()) * bytesPerPoint_);
      source_->read(slab, all);
      for (size_t at = 0; at < all.size(); at += bytesPerPoint_)
        for (const int c : components_) {
          std::memcpy(out.data(), all.data() + at + size_t(c) * bytesPerSample_, bytesPerSample_);
          out = out.subspan(bytesPerSample_);
        }
    }
  }

 private:
  static constexpr int64_t kSlabBytes = 16 << 20;  ///< that are read at once
  std::shared_ptr<const SampleSource> source_;
  size_t bytesPerPoint_, bytesPerSample_;
  std::vector<int> components_;
};

}  // namespace

bool isVolumeFile(const std::string& path) {
  const std::string extension = extensionOf(path);
  if (extension == ".vtk") {
    const File file = File::open(path);
    std::string head(size_t(std::min(file.size(), int64_t(1024))), '\0');
    file.readAt(0, std::as_writable_bytes(std::span(head)));
    return legacyDatasetType(head) == "STRUCTURED_POINTS";
  }
  return extension == ".vti" || extension == ".pvti" || extension == ".vol" || extension == ".json";
}

VolumeFile openVolume(const std::string& path, const std::string& array) {
  const std::string extension = extensionOf(path);
  if (extension == ".vol" || extension == ".json") return openRawVolume(path);
  if (extension == ".vti") return openVti(path, array);
  if (extension == ".pvti") return openPvti(path, array);
  if (extension == ".vtk") return openLegacyVolume(path, array);
  throw Error(path + ": not a volume file: expected .vti, .pvti, .vtk, .vol or .json");
}

VolumeFile withComponents(VolumeFile file, std::vector<int> components) {
  for (const int c : components)
    if (c < 0 || c >= file.array.components)
      throw Error(file.path + ": component " + std::to_string(c) + " was asked for, it has " +
                  std::to_string(file.array.components) + " (counted from 0)");
  const int kept = int(components.size());
  if (kept == file.array.components) return file;
  file.source = std::make_shared<SomeComponents>(file, std::move(components));
  file.array.components = kept;
  return file;
}

void readVolume(const VolumeFile& file, const Extent& extent, std::span<std::byte> out) {
  for (int a = 0; a < 3; ++a) {
    const size_t i = size_t(a);
    if (extent.first[i] < 0 || extent.points[i] < 0 ||
        extent.first[i] > file.grid.points[i] - extent.points[i])
      throw Error(file.path + ": the points asked for lie outside the grid");
  }
  if (out.size() != size_t(extent.count()) * file.bytesPerPoint())
    throw Error(file.path + ": the buffer's size is not that of the points asked for");
  if (extent.count() > 0) file.source->read(extent, out);
}

const ArrayInfo& chooseArray(const std::vector<ArrayInfo>& arrays, const std::string& name,
                             const std::string& active, const std::string& path) {
  if (arrays.empty()) throw Error(path + ": no point data with a numeric array (cell data are not used)");
  const auto named = [&](const std::string& wanted) {
    return std::find_if(arrays.begin(), arrays.end(), [&](const ArrayInfo& a) { return a.name == wanted; });
  };
  if (!name.empty()) {
    const auto found = named(name);
    if (found != arrays.end()) return *found;
    std::string list;
    for (const ArrayInfo& a : arrays) list += (list.empty() ? "'" : ", '") + a.name + "'";
    throw Error(path + ": no point array '" + name + "'; the file has " + list);
  }
  const auto found = active.empty() ? arrays.end() : named(active);
  return found != arrays.end() ? *found : arrays.front();
}

Extent intersection(const Extent& a, const Extent& b) {
  Extent both;
  for (size_t i = 0; i < 3; ++i) {
    both.first[i] = std::max(a.first[i], b.first[i]);
    const int64_t end = std::min(a.first[i] + a.points[i], b.first[i] + b.points[i]);
    both.points[i] = end - both.first[i];
    if (both.points[i] <= 0) return {};
  }
  return both;
}

void copyExtent(std::span<const std::byte> source, const Extent& from, std::span<std::byte> target,
                const Extent& to, size_t bytesPerPoint) {
  const Extent both = intersection(from, to);
  const auto offset = [&](const Extent& e, int64_t j, int64_t k) {
    const int64_t row = (k - e.first[2]) * e.points[1] + (j - e.first[1]);
    return size_t(row * e.points[0] + both.first[0] - e.first[0]) * bytesPerPoint;
  };
  for (int64_t k = both.first[2]; k < both.first[2] + both.points[2]; ++k)
    for (int64_t j = both.first[1]; j < both.first[1] + both.points[1]; ++j)
      std::memcpy(target.data() + offset(to, j, k), source.data() + offset(from, j, k),
                  size_t(both.points[0]) * bytesPerPoint);
}

}  // namespace gxy
