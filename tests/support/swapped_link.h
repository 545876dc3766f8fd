// SPDX-License-Identifier: Apache-2.0
// An attacker who replaces files between the check of their path and their opening.
#pragma once
#include <atomic>
#include <filesystem>
#include <string>
#include <thread>

namespace gxy::test {

/// While it lives, a thread repeatedly replaces a file by a symbolic link to `target` and back. One of the
/// two is always there. In the end the file is back.
class SwappedLink {
 public:
  SwappedLink(std::filesystem::path file, std::filesystem::path target)
      : file_(std::move(file)), target_(std::move(target)) {
    std::filesystem::create_hard_link(file_, kept_);
    thread_ = std::thread([this] {
      while (!ended_) {
        std::filesystem::create_symlink(target_, next_);
        std::filesystem::rename(next_, file_);
        std::filesystem::create_hard_link(kept_, next_);
        std::filesystem::rename(next_, file_);
      }
    });
  }
  ~SwappedLink() {
    ended_ = true;
    thread_.join();
    std::filesystem::remove(kept_);
  }
  SwappedLink(const SwappedLink&) = delete;
  SwappedLink& operator=(const SwappedLink&) = delete;

 private:
  const std::filesystem::path file_, target_;
  const std::filesystem::path kept_ = file_.string() + ".kept", next_ = file_.string() + ".next";
  std::atomic<bool> ended_ = false;
  std::thread thread_;
};

}  // namespace gxy::test
