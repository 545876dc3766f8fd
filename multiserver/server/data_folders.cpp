// SPDX-License-Identifier: Apache-2.0
#include "multiserver/server/data_folders.h"

#include <fcntl.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <map>

#include "core/comm/error.h"
#include "core/io/referenced_files.h"
#include "core/scene/json_text.h"

namespace gxy {

namespace fs = std::filesystem;

namespace {

/// A file descriptor that is closed at the end of its scope.
struct Descriptor {
  int number;
  ~Descriptor() {
    if (number >= 0) ::close(number);
  }
};

}  // namespace

DataFolders::DataFolders(const std::vector<std::string>& folders) {
  for (const std::string& folder : folders.empty() ? std::vector<std::string>{"."} : folders) {
    std::error_code failed;
    const fs::path canonical = fs::canonical(folder, failed);
    if (failed || !fs::is_directory(canonical, failed))
      throw Error(folder + ": it is no folder, expected one that clients may read and write files in");
    folders_.push_back(canonical);
  }
}

bool DataFolders::holds(const fs::path& canonical) const {
  return std::any_of(folders_.begin(), folders_.end(), [&](const fs::path& folder) {
    const auto [end, rest] = std::mismatch(folder.begin(), folder.end(), canonical.begin(), canonical.end());
    (void)rest;
    return end == folder.end();
  });
}

void DataFolders::refuse(const std::string& name, const std::string& reason) const {
  throw Error(inQuotes(name) + ": " + reason + ", expected a file in " + folders_.front().string() +
              (folders_.size() > 1 ? " or another of the server's data folders" : ""));
}

std::string DataFolders::toRead(const std::string& name) const {
  if (name.empty() || name.find('\0') != std::string::npos) refuse(name, "it is no file name");
  const fs::path given(name);
  for (const fs::path& folder : folders_) {
    std::error_code failed;
    const fs::path canonical = fs::canonical(folder / given, failed);  // An absolute name stays as it is.
    if (failed || !holds(canonical)) continue;
    if (!fs::is_regular_file(canonical, failed)) refuse(name, "it is not a regular file");
    return canonical.string();
  }
  refuse(name, "there is no such file that may be read");
}

std::string DataFolders::dataToRead(const std::string& name) const {
  const std::string path = toRead(name);
  for (const std::string& file : filesOpenedFor(path)) {
    std::error_code failed;
    const fs::path canonical = fs::canonical(file, failed);
    if (failed || !holds(canonical) || !fs::is_regular_file(canonical, failed))
      refuse(name, "it refers to " + inQuotes(file) + ", which is no file that may be read");
  }
  return path;
}

ReadScope DataFolders::reading() const {
  return ReadScope([this](const std::string& path, const std::string& place) {
    if (!holds(place)) refuse(path, "it is no file that may be read");
  });
}

std::string DataFolders::textOf(const std::string& name, int64_t limit) const {
  const ReadScope inside = reading();
  return readText(toRead(name), limit);
}

std::vector<DataFolders::Entry> DataFolders::list(const std::string& name, size_t most) const {
  if (name.find('\0') != std::string::npos) refuse(name, "it is no folder's name");
  std::map<std::string, Entry> entries;
  bool found = false;
  for (const fs::path& folder : folders_) {
    std::error_code failed;
    const fs::path canonical = fs::canonical(folder / fs::path(name), failed);
    if (failed || !holds(canonical) || !fs::is_directory(canonical, failed)) continue;
    found = true;
    for (fs::directory_iterator at(canonical, failed), end; !failed && at != end; at.increment(failed)) {
      Entry entry{at->path().filename().string()};
      std::error_code gone;
      const fs::path target = fs::canonical(at->path(), gone);
      if (gone || entry.name.starts_with('.') || !holds(target)) continue;
      entry.isFolder = fs::is_directory(target, gone);
      if (!entry.isFolder && !fs::is_regular_file(target, gone)) continue;
      if (!entry.isFolder) entry.bytes = int64_t(fs::file_size(target, gone));
      entries.try_emplace(entry.name, entry);
      if (entries.size() > most) entries.erase(std::prev(entries.end()));
    }
    if (fs::path(name).is_absolute()) break;
  }
  if (!found) refuse(name, "there is no such folder that may be read");
  std::vector<Entry> sorted;
  for (auto& [key, entry] : entries) sorted.push_back(std::move(entry));
  return sorted;
}

std::string DataFolders::toWrite(const std::string& name) const {
  const fs::path path = folders_.front() / fs::path(name);
  std::error_code failed;
  const fs::path parent = fs::canonical(path.parent_path(), failed);
  if (name.empty() || name.find('\0') != std::string::npos || failed || !holds(parent) ||
      !path.has_filename() || path.filename() == ".." || path.filename() == ".")
    refuse(name, "it cannot be written");
  const fs::path file = parent / path.filename();
  if (fs::exists(fs::symlink_status(file, failed)) && !fs::is_regular_file(fs::symlink_status(file, failed)))
    refuse(name, "it is there and not a regular file");
  return file.string();
}

std::string DataFolders::makeFolder(const std::string& name) const {
  const fs::path path = folders_.front() / fs::path(name);
  std::error_code failed;
  const fs::path parent = fs::canonical(path.parent_path(), failed);
  const fs::path leaf = path.filename();
  if (name.empty() || name.find('\0') != std::string::npos || failed || leaf.empty() || leaf == "." ||
      leaf == "..")
    refuse(name, "it cannot be made");
  const Descriptor in{::open(parent.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC)};
  if (in.number < 0 || !holds(fs::read_symlink("/proc/self/fd/" + std::to_string(in.number), failed)) ||
      failed)
    refuse(name, "it cannot be made");
  if (::mkdirat(in.number, leaf.c_str(), 0777) != 0) {
    const int reason = errno;
    struct stat found {};
    if (reason != EEXIST)
      throw Error(inQuotes(name) + ": no folder can be made there: " + std::strerror(reason));
    if (::fstatat(in.number, leaf.c_str(), &found, AT_SYMLINK_NOFOLLOW) != 0 || !S_ISDIR(found.st_mode))
      refuse(name, "it is there and not a folder");
  }
  return (parent / leaf).string();
}

DataFolders::NewFile::NewFile(const DataFolders& folders, const std::string& path) : path_(path) {
  const fs::path place(path);
  name_ = place.filename();
  folder_ = ::open(place.parent_path().c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
  if (folder_ < 0) fail(errno);
  std::error_code failed;
  // A random name, because other requests may write the same file.
  uint64_t number = 0;
  if (!folders.holds(fs::read_symlink("/proc/self/fd/" + std::to_string(folder_), failed)) || failed ||
      ::getrandom(&number, sizeof number, 0) != sizeof number) {
    ::close(folder_);
    folders.refuse(path, "it cannot be written");
  }
  partial_ = "." + std::to_string(number) + ".partial." + name_;
}

DataFolders::NewFile::~NewFile() {
  if (!finished_) ::unlinkat(folder_, partial_.c_str(), 0);
  ::close(folder_);
}

std::string DataFolders::NewFile::partial() const {
  return "/proc/self/fd/" + std::to_string(folder_) + "/" + partial_;
}

void DataFolders::NewFile::finish() {
  if (::renameat(folder_, partial_.c_str(), folder_, name_.c_str()) != 0) fail(errno);
  finished_ = true;
}

void DataFolders::NewFile::fail(int reason) const {
  throw Error(path_ + ": cannot be written: " + std::strerror(reason));
}

void DataFolders::write(const std::string& path, std::span<const std::byte> bytes) const {
  NewFile made(*this, path);
  const Descriptor file{::openat(made.folder_, made.partial_.c_str(),
                                 O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666)};
  if (file.number < 0) made.fail(errno);
  while (!bytes.empty()) {
    const ssize_t put = ::write(file.number, bytes.data(), std::min(bytes.size(), size_t(1) << 30));
    if (put >= 0)
      bytes = bytes.subspan(size_t(put));
    else if (errno != EINTR)
      made.fail(errno);
  }
  made.finish();
}

}  // namespace gxy
