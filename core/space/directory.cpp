// SPDX-License-Identifier: Apache-2.0
#include "core/space/directory.h"

#include <algorithm>
#include <utility>

#include "core/comm/error.h"

namespace gxy {

void Directory::checkMayChange(const std::string& tenant, const std::string& name,
                               const DirectoryEntry& entry) {
  if (entry.readOnly && entry.owner != tenant) {
    throw Error("name '" + name + "': it is read-only and belongs to " + entry.owner +
                ", expected a name of your own");
  }
}

std::optional<DirectoryEntry> Directory::bind(const std::string& name, Scope scope, DirectoryEntry entry) {
  if (name.empty()) throw Error("name: it is empty, expected one character or more");
  const std::lock_guard lock(mutex_);
  Names& names = scope == Scope::Shared ? shared_ : private_[entry.owner];
  const auto at = names.find(name);
  if (at == names.end()) {
    names.emplace(name, std::move(entry));
    return std::nullopt;
  }
  checkMayChange(entry.owner, name, at->second);
  return std::exchange(at->second, std::move(entry));
}

bool Directory::bindIf(const std::string& name, const std::optional<DirectoryEntry>& expected,
                       DirectoryEntry entry) {
  if (name.empty()) throw Error("name: it is empty, expected one character or more");
  const std::lock_guard lock(mutex_);
  if (findLocked(entry.owner, name, Scope::Private) != expected) return false;
  private_[entry.owner].insert_or_assign(name, std::move(entry));
  return true;
}

std::optional<DirectoryEntry> Directory::find(const std::string& tenant, const std::string& name) const {
  const std::lock_guard lock(mutex_);
  if (auto own = findLocked(tenant, name, Scope::Private)) return own;
  return findLocked(tenant, name, Scope::Shared);
}

std::vector<std::optional<Directory::Listed>> Directory::find(const std::string& tenant,
                                                              std::span<const std::string> names) const {
  const std::lock_guard lock(mutex_);
  std::vector<std::optional<Listed>> found;
  for (const std::string& name : names) {
    auto& at = found.emplace_back();
    for (const Scope scope : {Scope::Private, Scope::Shared})
      if (auto entry = at ? std::nullopt : findLocked(tenant, name, scope))
        at = Listed{name, scope, *std::move(entry)};
  }
  return found;
}

std::optional<DirectoryEntry> Directory::find(const std::string& tenant, const std::string& name,
                                              Scope scope) const {
  const std::lock_guard lock(mutex_);
  return findLocked(tenant, name, scope);
}

std::optional<DirectoryEntry> Directory::findLocked(const std::string& tenant, const std::string& name,
                                                    Scope scope) const {
  const auto own = private_.find(tenant);
  if (scope == Scope::Private && own == private_.end()) return std::nullopt;
  const Names& names = scope == Scope::Shared ? shared_ : own->second;
  const auto at = names.find(name);
  return at == names.end() ? std::nullopt : std::optional(at->second);
}

DirectoryEntry Directory::get(const std::string& tenant, const std::string& name) const {
  if (auto entry = find(tenant, name)) return *std::move(entry);
  throw Error("name '" + name + "': there is none, expected a name in your directory or the shared one");
}

DirectoryEntry Directory::remove(const std::string& tenant, const std::string& name, Scope scope) {
  const std::lock_guard lock(mutex_);
  Names& names = scope == Scope::Shared ? shared_ : private_[tenant];
  const auto at = names.find(name);
  if (at == names.end()) {
    throw Error("name '" + name + "': there is none in " +
                (scope == Scope::Shared ? "the shared directory" : "your directory") +
                ", expected one to remove");
  }
  checkMayChange(tenant, name, at->second);
  DirectoryEntry removed = std::move(at->second);
  names.erase(at);
  return removed;
}

bool Directory::removeIf(const std::string& tenant, const std::string& name, const DirectoryEntry& expected) {
  const std::lock_guard lock(mutex_);
  if (findLocked(tenant, name, Scope::Private) != expected) return false;
  private_[tenant].erase(name);
  return true;
}

std::vector<Directory::Listed> Directory::list(const std::string& tenant) const {
  const std::lock_guard lock(mutex_);
  std::vector<Listed> all;
  if (const auto own = private_.find(tenant); own != private_.end()) {
    for (const auto& [name, entry] : own->second) all.push_back({name, Scope::Private, entry});
  }
  for (const auto& [name, entry] : shared_) all.push_back({name, Scope::Shared, entry});
  std::stable_sort(all.begin(), all.end(), [](const Listed& a, const Listed& b) { return a.name < b.name; });
  return all;
}

}  // namespace gxy
