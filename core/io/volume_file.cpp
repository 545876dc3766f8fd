// SPDX-License-Identifier: Apache-2.0
#include "core/io/volume_file.h"

#include <algorithm>

#include "core/comm/error.h"
#include "core/io/file.h"
#include "core/io/legacy_vtk.h"
#include "core/io/volume_formats.h"

namespace gxy {

namespace {

/// Some components of samples. All components are read, because they are interleaved; the others are not kept.
class SomeComponents final : public SampleSource {
 public:
  SomeComponents(const VolumeFile& file, std::vector<int> components)
      : source_(file.source),
        bytesPerPoint_(file.bytesPerPoint()),
        bytesPerSample_(bytesOf(file.array.type)),
        components_(std::move(components)) {}

  uint64_t piecesNotRead() const override { return source_->piecesNotRead(); }

  void read(std::span<const Extent> wanted, const TakeSamples& take) const override {
    std::vector<std::byte> whole, some;
    source_->read(wanted, [&](const SamplesRead& all) {
      whole.resize(size_t(all.points.count()) * bytesPerPoint_);
      copyExtent(all.samples, all.layout, whole, all.points, bytesPerPoint_);
      some.clear();
      for (size_t at = 0; at < whole.size(); at += bytesPerPoint_)
        for (const int c : components_) {
          const auto sample = whole.begin() + std::ptrdiff_t(at + size_t(c) * bytesPerSample_);
          some.insert(some.end(), sample, sample + std::ptrdiff_t(bytesPerSample_));
        }
      take({all.wanted, all.points, all.points, some});
    });
  }

 private:
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
  return extension == ".vti" || extension == ".pvti" || extension == ".vol" || extension == ".json" ||
         isImageFile(path);
}

std::string readableFormats() {
  return "volumes as .vti .pvti .vtk .vol .json .mha .mhd .nrrd .nhdr .nii .nii.gz .npy, geometry as .vtu "
         ".pvtu .vtp .pvtp .vts .pvts .vtr .pvtr .vtk .ply .stl .obj .off .csv .xyz .part, unstructured, "
         "curvilinear and rectilinear volumes as .vtu .pvtu .vts .pvts .vtr .pvtr .vtk .part";
}

VolumeFile openVolume(const std::string& path, const std::string& array) {
  return openVolume(path, array, {});
}

VolumeFile openVolume(const std::string& path, const std::string& array, const RawOptions& options) {
  const std::string extension = extensionOf(path);
  if (options.dimensions || options.type) {
    if (!options.dimensions || !options.type)
      throw Error(path + ": expected both the dimensions and the type of raw samples");
    return openRaw(path, options);
  }
  if ((options.spacing || options.origin) && !isImageFile(path))
    throw Error(
        path +
        ": spacing and origin may be given for .mha .mhd .nrrd .nhdr .nii .nii.gz .npy and raw samples");
  if (extension == ".vol" || extension == ".json") return openRawVolume(path);
  if (extension == ".vti") return openVti(path, array);
  if (extension == ".pvti") return openPvti(path, array);
  if (extension == ".vtk") return openLegacyVolume(path, array);
  if (isImageFile(path)) return openImageFile(path, options);
  throw Error(path + ": this kind of file cannot be read as a volume: expected " + readableFormats());
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

void readVolume(const VolumeFile& file, std::span<const ReadTarget> targets,
                const std::function<void(int64_t)>& advance) {
  std::vector<Extent> wanted;
  for (const auto& [extent, out] : targets) {
    for (size_t a = 0; a < 3; ++a)
      if (extent.first[a] < 0 || extent.points[a] < 0 ||
          extent.first[a] > file.grid.points[a] - extent.points[a])
        throw Error(file.path + ": the points asked for lie outside the grid");
    if (out.size() != size_t(extent.count()) * file.bytesPerPoint())
      throw Error(file.path + ": the buffer's size is not that of the points asked for");
    wanted.push_back(extent);
  }
  file.source->read(wanted, [&](const SamplesRead& some) {
    const auto& [extent, out] = targets[some.wanted];
    copyBox(some.points, some.samples, some.layout, out, extent, file.bytesPerPoint());
    advance(some.points.count());
  });
}

void readVolume(const VolumeFile& file, const Extent& extent, std::span<std::byte> out) {
  const ReadTarget target{extent, out};
  readVolume(file, std::span(&target, 1), [](int64_t) {});
}

const ArrayInfo& chooseArray(const std::vector<ArrayInfo>& arrays, const std::string& name,
                             const std::string& active, const std::string& path) {
  if (arrays.empty()) throw Error(path + ": there is no numeric array of points or cells");
  const auto named = [&](const std::string& wanted) {
    return std::find_if(arrays.begin(), arrays.end(), [&](const ArrayInfo& a) { return a.name == wanted; });
  };
  if (!name.empty()) {
    const auto found = named(name);
    if (found != arrays.end()) return *found;
    std::string list;
    for (const ArrayInfo& a : arrays) list += (list.empty() ? "'" : ", '") + a.name + "'";
    throw Error(path + ": no array '" + name + "'; the file has " + list);
  }
  const auto found = active.empty() ? arrays.end() : named(active);
  return found != arrays.end() ? *found : arrays.front();
}

void copyExtent(std::span<const std::byte> source, const Extent& from, std::span<std::byte> target,
                const Extent& to, size_t bytesPerPoint) {
  copyBox(intersection(from, to), source, from, target, to, bytesPerPoint);
}

}  // namespace gxy
