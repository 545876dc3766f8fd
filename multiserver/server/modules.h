// SPDX-License-Identifier: Apache-2.0
// Loads modules, which are shared libraries in the server's module folders, on all ranks by their bare names.
#pragma once
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <typeindex>
#include <vector>

#include "multiserver/server/module.h"

namespace gxy {

/// A module that is loaded on all ranks. It is immutable and never unloaded.
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
  explicit Modules(ServerRank& serverRank);
  ~Modules();
  void addWorks();  ///< called once, when the server rank has its Work

  /// Returns the module with this name, after loading it on all ranks if it is not loaded yet. Only for rank
  /// 0; waits for all ranks and for other loads. Throws Error if any rank cannot load it; then nothing has
  /// changed on any rank.
  std::shared_ptr<const LoadedModule> load(const std::string& name);

  /// Returns the names of modules in the folders, in alphabetical order.
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
  friend class Registration;
  std::shared_ptr<void> sharedOf(std::type_index type, const std::function<std::shared_ptr<void>()>& make);

  ServerRank& serverRank_;
  std::mutex loading_;  ///< rank 0: held during a load
  mutable std::mutex mutex_;
  std::map<std::string, Opened> opened_;  ///< libraries, both before and after commit()
  std::map<std::string, std::shared_ptr<const LoadedModule>> loaded_;
  std::map<std::type_index, std::weak_ptr<void>> shared_;  ///< which modules keep; used while one is loaded
};

}  // namespace gxy
