// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyrender/run.h"

#include "core/comm/error.h"
#include "core/comm/error_text.h"

namespace gxy {

std::string textOfRoot(Collective& collective, bool root, const std::function<std::string()>& make) {
  std::string said;
  if (root) {
    try {
      said = " " + make();
    } catch (const std::exception& e) {
      said = "!" + textOf(e);
    }
  }
  const auto* begin = reinterpret_cast<const std::byte*>(said.data());
  const Bytes heard = collective.broadcast(kRunKey, 0, Bytes(begin, begin + said.size()));
  const std::string text(reinterpret_cast<const char*>(heard.data()), heard.size());
  if (text.at(0) == '!') throw Error(text.substr(1));
  return text.substr(1);
}

}  // namespace gxy
