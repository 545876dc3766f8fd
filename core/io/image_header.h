// SPDX-License-Identifier: Apache-2.0
// Formats of images that are a header and raw samples, each read after its public description:
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

/// What a header says of the image and of where its samples are.
struct ImageHeader {
  ImageData image;  ///< without arrays
  ScalarType type = ScalarType::UInt8;
  int components = 1;
  bool swapBytes = false;
  bool text = false;                            ///< numbers as text, not bytes
  Compression compression = Compression::None;  ///< None or Zlib
  std::string dataFile;                         ///< as written; empty: the file itself
  int64_t offset =
      0;  ///< of the samples, in what is compressed after decompression; kAtEnd: they are the last bytes
  bool exact = false;               ///< the file ends with the samples, where they are not encoded
  double slope = 1, intercept = 0;  ///< value = intercept + slope * sample

  static constexpr int64_t kAtEnd = -1;
};

/// Bytes from a file's beginning that hold every header.
inline constexpr int64_t kHeaderBytes = 1 << 20;

/// These take the first kHeaderBytes of a file, or all of it (of a .nii.gz decompressed), and throw Error, which begins with
/// `where`, for what is malformed or not supported.
ImageHeader parseMetaImage(std::string_view bytes, const std::string& where);
ImageHeader parseNrrd(std::string_view bytes, const std::string& where);
ImageHeader parseNifti(std::string_view bytes, const std::string& where);
ImageHeader parseNpy(std::string_view bytes, const std::string& where);

/// The header of a file by its ending; nothing for other endings.
std::optional<ImageHeader> imageHeaderOf(const std::string& path);

}  // namespace gxy
