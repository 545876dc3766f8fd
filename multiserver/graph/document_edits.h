// SPDX-License-Identifier: Apache-2.0
// Edits of the JSON of a graph document.
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace gxy {

/// What edits make of a document, and the edits that undo them.
struct EditedDocument {
  nlohmann::json document, inverse;
  std::vector<std::pair<std::string, std::string>> renamedViews{};  ///< from and to, in order
};

/// Applies a list of edits, one after the other. Each is an object with one of
///
/// - `{"set": PATH, "to": VALUE}`: a member of an object, which need not be there, or an element of a list
/// - `{"add": PATH, "to": VALUE, "at": INDEX}`: an element of the list at PATH, which need not be there; at its end without `at`
/// - `{"remove": PATH}`
/// - `{"rename": [SECTION, ELEMENT], "to": NAME}`: a dataset, a named operator, a view or an output, and all that refers to it
///
/// A PATH is a list of keys, of indices and, in lists of objects, of names of elements. Throws Error with the number of the edit and the
/// path where the path leads nowhere or the edit says something else. What the document then means is not looked at.
EditedDocument edited(const nlohmann::json& document, const nlohmann::json& edits);

/// Returns a path as messages call it: `Datasets["seeds"].count`.
std::string pathText(const nlohmann::json& path);

}  // namespace gxy
