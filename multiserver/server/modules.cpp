// SPDX-License-Identifier: Apache-2.0
#include "multiserver/server/modules.h"

#include <dlfcn.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "core/comm/error.h"
#include "core/scene/json_text.h"

namespace gxy {

const Verb* LoadedModule::find(const std::string& verb) const {
  const auto found =
      std::find_if(verbs_.begin(), verbs_.end(), [&](const Verb& v) { return v.name == verb; });
  return found == verbs_.end() ? nullptr : &*found;
}

/// An open shared library that contains a module.
class Modules::Library {
 public:
  Library(const std::string& name, const std::string& file)
      : handle_(dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL)) {
    if (!handle_) throw Error("module " + name + ": it cannot be loaded: " + dlerror());
    const auto abi = reinterpret_cast<uint32_t (*)()>(dlsym(handle_, "galaxy_module_abi"));
    register_ = reinterpret_cast<void (*)(Registration&)>(dlsym(handle_, "galaxy_module_register"));
    std::string wrong;
    if (!abi || !register_)
      wrong = "the library is no module, expected one that defines GALAXY_MODULE";
    else if (abi() != kModuleAbi)
      wrong = "it was built for interface " + std::to_string(abi()) + ", expected " +
              std::to_string(kModuleAbi) + "; build it anew against this server";
    if (wrong.empty()) return;
    dlclose(handle_);
    throw Error("module " + name + ": " + wrong);
  }
  ~Library() {
    if (!stays_) dlclose(handle_);
  }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;

  void registerIn(Registration& registration) const { register_(registration); }
  /// From now on other code, such as tasks, may refer to its functions, so it is not closed for the life of
  /// the process.
  void stay() { stays_ = true; }

 private:
  void* handle_;
  void (*register_)(Registration&) = nullptr;
  bool stays_ = false;
};

Modules::Modules(ServerRank& serverRank) : serverRank_(serverRank) {}

Modules::~Modules() {
  loaded_.clear();
  for (auto& [name, opened] : opened_) opened.registration.reset();  // Its destructors are in the library.
}

void Modules::addWorks() {
  const auto named = [this](nlohmann::json (Modules::*action)(const std::string&)) {
    return [this, action](const Work::Call& call) {
      return (this->*action)(call.parameters.at("module").get<std::string>());
    };
  };
  serverRank_.work.add("modules.open", named(&Modules::open), Work::Runs::Waiting);
  serverRank_.work.add("modules.commit", named(&Modules::commit), Work::Runs::Waiting);
  serverRank_.work.add("modules.abandon", named(&Modules::abandon), Work::Runs::Waiting);
}

namespace {

bool isModuleName(const std::string& name) {
  return !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  });
}

// Returns the module's file in a folder; empty if the folder does not contain it.
std::string fileIn(const std::string& folder, const std::string& name) {
  namespace fs = std::filesystem;
  std::error_code failed;
  const fs::path inside = fs::canonical(folder, failed);
  const fs::path file = fs::canonical(inside / ("galaxy_" + name + ".so"), failed);
  return failed || file.parent_path() != inside ? std::string() : file.string();
}

}  // namespace

std::string Modules::fileOf(const std::string& name) const {
  if (!isModuleName(name))
    throw Error("module " + inQuotes(name.substr(0, 40)) + ": expected a name of letters, digits and _");
  for (const std::string& folder : serverRank_.options.moduleFolders)
    if (std::string file = fileIn(folder, name); !file.empty()) return file;
  std::string names;
  for (const std::string& other : available()) names += (names.empty() ? "" : ", ") + other;
  throw Error("module " + inQuotes(name) + ": there is none, " +
              (names.empty() ? "nor any other in the server's module folders" : "expected one of: " + names));
}

std::vector<std::string> Modules::available() const {
  std::set<std::string> names;
  for (const std::string& folder : serverRank_.options.moduleFolders) {
    std::error_code failed;
    for (const auto& file : std::filesystem::directory_iterator(folder, failed)) {
      const std::string stem = file.path().stem().string();
      if (file.path().extension() != ".so" || !stem.starts_with("galaxy_")) continue;
      const std::string name = stem.substr(7);
      if (isModuleName(name) && !fileIn(folder, name).empty()) names.insert(name);
    }
  }
  return {names.begin(), names.end()};
}

// Runs on each rank and does everything that can fail.
nlohmann::json Modules::open(const std::string& name) {
  Opened opened;
  opened.library = std::make_unique<Library>(name, fileOf(name));
  opened.registration = std::make_unique<Registration>(serverRank_);
  opened.library->registerIn(*opened.registration);
  std::set<std::string> verbs;
  for (const Verb& verb : opened.registration->verbs_)
    if (!verbs.insert(verb.name).second || !verb.action)
      throw Error("module " + name + ": verb " + verb.name + " is registered twice or without an action");
  std::set<std::string> works;
  for (const auto& work : opened.registration->works_)
    if (!works.insert(work.name).second || serverRank_.work.contains(work.name))
      throw Error("module " + name + ": there is a work " + work.name +
                  " already, expected a name that begins with the module's");
  std::set<std::string> filters;
  for (const auto& filter : opened.registration->filters_)
    if (!filters.insert(filter->schema.name).second || serverRank_.filters.find(filter->schema.name))
      throw Error("module " + name + ": there is a filter " + filter->schema.name +
                  " already, expected another name");
  const std::lock_guard lock(mutex_);
  opened_.insert_or_assign(name, std::move(opened));
  return nullptr;
}

nlohmann::json Modules::commit(const std::string& name) {
  const std::lock_guard lock(mutex_);
  const Registration& registration = *opened_.at(name).registration;
  opened_.at(name).library->stay();
  for (const auto& work : registration.works_) serverRank_.work.add(work.name, work.action, work.runs);
  for (const auto& filter : registration.filters_) serverRank_.filters.add(filter);
  loaded_[name] = std::make_shared<const LoadedModule>(name, registration.verbs_);
  return nullptr;
}

nlohmann::json Modules::abandon(const std::string& name) {
  Opened opened;
  const std::lock_guard lock(mutex_);
  if (const auto found = opened_.find(name); found != opened_.end()) {
    opened = std::move(found->second);
    opened_.erase(found);
  }
  opened.registration.reset();
  return nullptr;
}

// What a module made that could not be loaded has gone with it.
std::shared_ptr<void> Modules::sharedOf(std::type_index type,
                                        const std::function<std::shared_ptr<void>()>& make) {
  std::weak_ptr<void>& known = shared_[type];
  if (auto what = known.lock()) return what;
  auto what = make();
  known = what;
  return what;
}

std::shared_ptr<void> Registration::sharedOf(std::type_index type,
                                             const std::function<std::shared_ptr<void>()>& make) {
  auto what = serverRank_.modules->sharedOf(type, make);
  keep(what);
  return what;
}

std::shared_ptr<const LoadedModule> Modules::load(const std::string& name) {
  const auto known = [&]() -> std::shared_ptr<const LoadedModule> {
    const std::lock_guard lock(mutex_);
    const auto found = loaded_.find(name);
    return found == loaded_.end() ? nullptr : found->second;
  };
  if (auto module = known()) return module;
  const std::lock_guard loading(loading_);
  if (auto module = known()) return module;
  fileOf(name);  // throws for a wrong name before other ranks are asked
  try {
    serverRank_.callAll("modules.open", {{"module", name}});
  } catch (const Error&) {
    serverRank_.callAll("modules.abandon", {{"module", name}});
    throw;
  }
  serverRank_.callAll("modules.commit", {{"module", name}});
  return known();
}

}  // namespace gxy
