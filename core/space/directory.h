// SPDX-License-Identifier: Apache-2.0
// Names of objects: a private directory for each tenant, and one directory that all tenants share.
#pragma once
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/space/key.h"

namespace gxy {

enum class Scope { Private, Shared };

struct DirectoryEntry {
  Key key;
  std::string type;       ///< "Volume", "Particles", ...; for listings and early error messages
  std::string owner;      ///< the tenant that made the object
  bool readOnly = false;  ///< only the owner may bind the name again or remove it
  bool ofGraph = false;   ///< a graph of the owner made it, and alone gives it its name
  bool operator==(const DirectoryEntry&) const = default;
};

/// Names and their entries. Thread safe. Rank 0's directory decides; other ranks copy its changes.
class Directory {
 public:
  struct Listed {
    std::string name;
    Scope scope;
    DirectoryEntry entry;
    bool operator==(const Listed&) const = default;
  };

  /// Binds a name in the shared directory, or in the private one of the entry's owner. If the name is in
  /// use, its old entry is replaced and returned. Throws Error if the name is empty, or read-only and owned
  /// by another tenant.
  std::optional<DirectoryEntry> bind(const std::string& name, Scope scope, DirectoryEntry entry);

  /// Binds a name in the private directory of the entry's owner if its entry there is `expected`; null: if there is none. Returns
  /// whether it was. Throws Error if the name is empty.
  bool bindIf(const std::string& name, const std::optional<DirectoryEntry>& expected, DirectoryEntry entry);

  /// Returns the entry that a name has for a tenant: that of its private directory, or else of the shared one.
  std::optional<DirectoryEntry> find(const std::string& tenant, const std::string& name) const;
  /// Like this for several names, in their order, as they are at one moment: no name changes in between.
  std::vector<std::optional<Listed>> find(const std::string& tenant,
                                          std::span<const std::string> names) const;
  /// Returns the entry in one of the two directories.
  std::optional<DirectoryEntry> find(const std::string& tenant, const std::string& name, Scope scope) const;
  /// Like the first find(), but throws Error if there is no entry.
  DirectoryEntry get(const std::string& tenant, const std::string& name) const;

  /// Removes a name and returns its entry. Throws Error if there is none, or if it is read-only and owned
  /// by another tenant.
  DirectoryEntry remove(const std::string& tenant, const std::string& name, Scope scope);

  /// Removes a name from a tenant's private directory if its entry there is `expected`. Returns whether it was.
  bool removeIf(const std::string& tenant, const std::string& name, const DirectoryEntry& expected);

  /// Returns all entries that a tenant sees, by name. If a private name hides a shared one, both are listed.
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
