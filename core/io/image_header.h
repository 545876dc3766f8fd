// SPDX-License-Identifier: Apache-2.0
// Reads headers of images that consist of a header and raw samples, after the formats' public descriptions:
//
//   .mha .mhd       MetaImage (itk.org, Documentation/MetaIO)
//   .nrrd .nhdr     NRRD (teem.sourceforge.net/nrrd/format.html)
//   .nii .nii.gz    NIfTI-1 (nifti.nimh.nih.gov/nifti-1)
//   .npy            NumPy (numpy.org, numpy.lib.format)
//
// Used inside core/io only.
#pragma once
#include <string>
#include <string_view>

#include "core/io/byte_stream.h"
#include "core/io/image_volume.h"

namespace gxy {

/// The description of an image, and the place and form of its samples.
struct ImageHeader {
  ImageData image;  ///< without arrays
  ScalarType type = ScalarType::UInt8;
  int components = 1;
  bool swapBytes = false;
  bool text = false;                            ///< numbers as text, not bytes
  Compression compression = Compression::None;  ///< None or Zlib
  std::string dataFile;                         ///< as written; empty: the file itself
  /// Position of the samples. If a whole file is compressed, it counts decompressed bytes. kAtEnd: the
  /// samples are the last bytes.
  int64_t offset = 0;
  bool exact = false;               ///< the file must end with the samples; checked if they are not encoded
  double slope = 1, intercept = 0;  ///< value = intercept + slope * sample

  static constexpr int64_t kAtEnd = -1;
};

/// Every header is within this many bytes from a file's beginning.
inline constexpr int64_t kHeaderBytes = 1 << 20;

/// `bytes` are the first kHeaderBytes of a file, or all of them if there are fewer; those of a .nii.gz
/// are decompressed. These functions throw Error, which begins with `where`, for a header that is
/// malformed or not supported.
ImageHeader parseMetaImage(std::string_view bytes, const std::string& where);
ImageHeader parseNrrd(std::string_view bytes, const std::string& where);
ImageHeader parseNifti(std::string_view bytes, const std::string& where);
ImageHeader parseNpy(std::string_view bytes, const std::string& where);

/// Reads the header of a file in the format of its extension; returns nothing for other extensions.
std::optional<ImageHeader> imageHeaderOf(const std::string& path);

}  // namespace gxy
