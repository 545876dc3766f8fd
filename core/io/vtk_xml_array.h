// SPDX-License-Identifier: Apache-2.0
// The data of one array of a VTK XML file, read from the file itself in any encoding: VTK's own readers decompress a block again
// for each row of points that they need of it. Used inside core/io only.
#pragma once
#include <memory>

#include "core/data/scalar.h"
#include "core/io/byte_stream.h"
#include "core/io/vtk_xml.h"

namespace gxy {

/// The `bytes` bytes of an array in the blocks that it was compressed in; in the file's byte order, but text in this machine's.
/// Headers of compressed arrays have been checked (VtkXml::checkCompressed). Throws Error if the header of one that is not
/// compressed states another size.
std::shared_ptr<const BlockedBytes> xmlArrayBytes(const VtkXml& xml, vtkXMLDataElement* array,
                                                  ScalarType type, int64_t bytes);

}  // namespace gxy
