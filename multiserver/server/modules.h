// SPDX-License-Identifier: Apache-2.0
// Modules: shared libraries in the server's module folders, loaded on all ranks by bare name.
#pragma once
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "multiserver/server/module.h"

namespace gxy {

/// A module that is there on all ranks. Immutable, never unloaded.
class LoadedModule {
 public:
  LoadedModule(std::string name, std::vector<Verb> verbs)
      : name_(std::move(name)), verbs_(std::move(verbs)) {}
  const std::string& name() const { return name_; }
  const std::vector<Verb>& verbs() const { return verbs_; }
  const Verb* find(const std::string& verb) const;

 private:
  std::string name_;
  std::vector<Verb> verbs_;
};

class Modules {
 public:
  explicit Modules(Node& node);
  ~Modules();
  void addWorks();  ///< once, when the node has its Work

  /// Rank 0: the module of this name, loaded on all ranks if it is not. Throws Error if any rank cannot load it, and then
  /// nothing has changed on any. One load at a time; waits.
  std::shared_ptr<const LoadedModule> load(const std::string& name);

  /// Names of what load() may find in the folders, in alphabetical order.
  std::vector<std::string> available() const;

 private:
  class Library;
  struct Opened {
    std::unique_ptr<Library> library;
    std::unique_ptr<Registration> registration;
  };

  std::string fileOf(const std::string& name) const;
  nlohmann::json open(const std::string& name);
  nlohmann::json commit(const std::string& name);
  nlohmann::json abandon(const std::string& name);

  Node& node_;
  std::mutex loading_;  ///< rank 0: held during a load
  mutable std::mutex mutex_;
  std::map<std::string, Opened> opened_;  ///< libraries, before and after their commit
  std::map<std::string, std::shared_ptr<const LoadedModule>> loaded_;
};

}  // namespace gxy
