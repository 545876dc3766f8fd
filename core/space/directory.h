// SPDX-License-Identifier: Apache-2.0
// Names of objects: a private directory for each tenant, and one that all share.
#pragma once
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/space/key.h"

namespace gxy {

enum class Scope { Private, Shared };

struct DirectoryEntry {
  Key key;
  std::string type;       ///< "Volume", "Particles", ...: for listing, and for errors before data are touched
  std::string owner;      ///< the tenant that made it
  bool readOnly = false;  ///< only the owner may bind the name anew or remove it
  bool operator==(const DirectoryEntry&) const = default;
};

/// Thread safe. Rank 0's copy decides; the others hold what it tells them.
class Directory {
 public:
  struct Listed {
    std::string name;
    Scope scope;
    DirectoryEntry entry;
    bool operator==(const Listed&) const = default;
  };

  /// Binds a name in the tenant's own or the shared directory; the tenant is the entry's owner. A name in use
  /// is bound anew, and what it named before is returned. Throws Error for an empty name, or one that is
  /// another's and read-only.
  std::optional<DirectoryEntry> bind(const std::string& name, Scope scope, DirectoryEntry entry);

  /// What a name means to a tenant: its own directory first, then the shared one.
  std::optional<DirectoryEntry> find(const std::string& tenant, const std::string& name) const;
  /// What it means in one of the two.
  std::optional<DirectoryEntry> find(const std::string& tenant, const std::string& name, Scope scope) const;
  /// The first of these; throws Error if there is none.
  DirectoryEntry get(const std::string& tenant, const std::string& name) const;

  /// Removes a name, and returns what it named. Throws Error if there is none, or if it is another's and
  /// read-only.
  DirectoryEntry remove(const std::string& tenant, const std::string& name, Scope scope);

  /// All that a tenant sees, by name; where a private name hides a shared one, both.
  std::vector<Listed> list(const std::string& tenant) const;

 private:
  using Names = std::map<std::string, DirectoryEntry>;
  std::optional<DirectoryEntry> findLocked(const std::string& tenant, const std::string& name,
                                           Scope scope) const;
  static void checkMayChange(const std::string& tenant, const std::string& name, const DirectoryEntry& entry);

  mutable std::mutex mutex_;
  Names shared_;
  std::map<std::string, Names> private_;  ///< by tenant
};

}  // namespace gxy
