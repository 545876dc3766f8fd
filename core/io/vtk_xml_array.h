// SPDX-License-Identifier: Apache-2.0
// Reads the data of one array of a VTK XML file in any encoding, directly from the file. VTK's own readers
// decode on one thread, and would decompress a block again for each row of points that they need from it. Used inside core/io only.
#pragma once
#include <cstddef>
#include <memory>
#include <span>

#include "core/data/scalar.h"
#include "core/io/byte_stream.h"
#include "core/io/vtk_xml.h"

namespace gxy {

/// Returns the `bytes` bytes of an array in the blocks of its compression. They are in the file's byte order; those
/// of text are in this machine's. The caller has checked the headers of compressed arrays
/// (VtkXml::checkCompressed()). Throws Error if the header of an array that is not compressed states another size.
std::shared_ptr<const BlockedBytes> xmlArrayBytes(const VtkXml& xml, vtkXMLDataElement* array,
                                                  ScalarType type, int64_t bytes);

/// Fills `out` with the first values of an array, in this machine's byte order, on all cores. Returns false if the array has
/// fewer. Throws Error for an array that cannot be decoded.
bool readXmlArray(const VtkXml& xml, vtkXMLDataElement* array, ScalarType type, std::span<std::byte> out);

}  // namespace gxy
