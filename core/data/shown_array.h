// SPDX-License-Identifier: Apache-2.0
// Which of the fields of geometry an operator shows.
#pragma once
#include <memory>
#include <optional>
#include <string>

#include "core/data/owned_geometry.h"

namespace gxy {

/// A field of geometry that is to be shown, or a component of it.
struct ShownArray {
  std::string name;              ///< empty: the geometry's values or colours
  std::optional<int> component;  ///< none: the magnitude of several components
};

/// Whether the values or colours of the geometry are what is to be shown: nothing else is named.
bool showsOwnValues(const OwnedGeometry& geometry, const ShownArray& shown);

/// Returns the range of what is to be shown. Throws Error that names `dataset`, and lists what there is, if the geometry has
/// no such array or component. The same on every rank.
Range rangeOfShown(const OwnedGeometry& geometry, const ShownArray& shown, const std::string& dataset);

/// Bytes that geometryToShow() takes on this rank.
int64_t bytesToShow(const OwnedGeometry& geometry, const ShownArray& shown);

/// Returns geometry whose values are what is to be shown, and without further fields, for rendering. It is the same object if nothing
/// needs to be changed. Where values give radii, those shown do. Throws Error as rangeOfShown() does.
std::shared_ptr<const OwnedGeometry> geometryToShow(std::shared_ptr<const OwnedGeometry> geometry,
                                                    const ShownArray& shown, const std::string& dataset);

}  // namespace gxy
