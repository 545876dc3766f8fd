// SPDX-License-Identifier: Apache-2.0
// Shared by the tests of the scene: the message of the Error that a call throws, and scratch files.
#pragma once
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "core/comm/error.h"
#include "tests/support/temporary_folder.h"

namespace gxy {

/// The message of the Error that `call` throws; any other outcome fails the test.
template <class Call>
std::string errorOf(Call call) {
  try {
    call();
  } catch (const Error& e) {
    return e.what();
  }
  ADD_FAILURE() << "expected gxy::Error";
  return "";
}

/// A directory that lives as long as this object.
class ScratchDirectory : public gxy::test::TemporaryFolder {
 public:
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(path() / name) << text;
    return path() / name;
  }
};

}  // namespace gxy
