// SPDX-License-Identifier: Apache-2.0
#include "core/io/file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "core/comm/error.h"

namespace gxy {
namespace {

[[noreturn]] void fail(const std::string& path, const std::string& what) {
  throw Error(path + ": " + what + ": " + std::strerror(errno));
}

constexpr size_t kReadAtOnce = size_t(8) << 20;

thread_local ReadRules ownRules;
ReadRules& ownRulesOfThread() { return ownRules; }
std::atomic<RulesOfThread> rulesOfThread = ownRulesOfThread;

ReadRules& rules() { return rulesOfThread.load(std::memory_order_acquire)(); }

}  // namespace

RulesOfThread readRules() { return rulesOfThread; }
void shareReadRules(RulesOfThread ofProgram) { rulesOfThread = ofProgram; }

ReadScope::ReadScope(Check check) : check_(std::move(check)), outer_(std::exchange(rules().scope, this)) {}

ReadScope::~ReadScope() { rules().scope = outer_; }

ReadWatch::ReadWatch(std::function<void()> check)
    : check_(std::move(check)), outer_(std::exchange(rules().watch, this)) {}

ReadWatch::~ReadWatch() { rules().watch = outer_; }

void ReadWatch::check() {
  if (const ReadWatch* const watch = rules().watch) watch->check_();
}

File File::open(const std::string& path) {
  // O_NONBLOCK: if the file is a pipe, do not wait for a writer. It has no effect on regular files.
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) fail(path, "cannot open the file");
  File file(path, descriptor);
  if (const ReadScope* const scope = rules().scope) {
    std::error_code failed;
    const std::filesystem::path place = std::filesystem::read_symlink(file.opened(), failed);
    if (failed) throw Error(path + ": cannot find out where the file lies: " + failed.message());
    scope->check_(path, place.string());
  }
  struct stat status {};
  if (::fstat(descriptor, &status) != 0) fail(path, "cannot examine the file");
  if (!S_ISREG(status.st_mode)) throw Error(path + ": not a regular file");
  return file;
}

File File::create(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor < 0) fail(path, "cannot create the file");
  return File(path, descriptor);
}

File::File(File&& other) noexcept
    : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

File::~File() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

std::string File::opened() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

int64_t File::size() const {
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0) fail(path_, "cannot examine the file");
  return status.st_size;
}

void File::readAt(int64_t offset, std::span<std::byte> out) const {
  while (!out.empty()) {
    ReadWatch::check();
    const ssize_t got = ::pread(descriptor_, out.data(), std::min(out.size(), kReadAtOnce), offset);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail(path_, "cannot read at byte " + std::to_string(offset));
    if (got == 0)
      throw Error(path_ + ": the file ends at byte " + std::to_string(offset) + ", " +
                  std::to_string(out.size()) + " bytes too early");
    out = out.subspan(size_t(got));
    offset += got;
  }
}

void File::writeAt(int64_t offset, std::span<const std::byte> data) const {
  while (!data.empty()) {
    const ssize_t put = ::pwrite(descriptor_, data.data(), std::min(data.size(), size_t(1) << 30), offset);
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) fail(path_, "cannot write at byte " + std::to_string(offset));
    data = data.subspan(size_t(put));
    offset += put;
  }
}

std::string readText(const std::string& path, int64_t limit) {
  const File file = File::open(path);
  const int64_t size = file.size();
  if (size > limit)
    throw Error(path + ": " + std::to_string(size) + " bytes; a file of this kind has at most " +
                std::to_string(limit));
  std::string text(size_t(size), '\0');
  file.readAt(0, std::as_writable_bytes(std::span(text)));
  return text;
}

void writeText(const std::string& path, const std::string& text) {
  File::create(path).writeAt(0, std::as_bytes(std::span(text)));
}

std::string extensionOf(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return char(std::tolower(c)); });
  return extension;
}

std::string beside(const std::string& document, const std::string& name) {
  return (std::filesystem::path(document).parent_path() / name).string();
}

}  // namespace gxy
