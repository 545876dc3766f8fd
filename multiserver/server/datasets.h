// SPDX-License-Identifier: Apache-2.0
// Datasets in the data space: imported on all ranks, named on rank 0, and who is told.
#pragma once
#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/data/dataset.h"
#include "core/data/partitioning.h"
#include "core/scene/scene.h"
#include "multiserver/server/node.h"

namespace gxy {

class Request;

/// What a dataset is shown as.
DatasetType typeOf(const Dataset& dataset);

/// "Volume", "Particles", "PathLines", "Triangles".
const char* nameOf(DatasetType type);

/// A dataset as a tenant sees it.
struct NamedDataset {
  Key key;
  std::string name;
  Scope scope = Scope::Private;
  std::string type, owner;
  bool readOnly = false;
  Generation generation = 0;
};

/// What is told about names. Rank 0.
struct DatasetEvent {
  enum class Kind { Added, Updated, Skipped, Dropped, Renamed };
  Kind kind;
  NamedDataset dataset;
  std::string newName;  ///< Renamed
  bool visibleTo(const std::string& tenant) const {
    return dataset.scope == Scope::Shared || dataset.owner == tenant;
  }
  nlohmann::json json() const;
};

/// Thread safe. All calls but addWorks() and here() are for rank 0; those that say so wait for all ranks.
class Datasets {
 public:
  explicit Datasets(Node& node);
  ~Datasets();
  void addWorks();

  struct Import {
    std::vector<DatasetSpec> specs;
    Scope scope = Scope::Private;
    bool newPartitioning = false;
    std::string like;          ///< the dataset whose partitioning is to be used; empty: see docs/protocol.md
    bool onlyMissing = false;  ///< leaves out names that the tenant sees already
  };
  /// Reads files and names what is in them: all or nothing. Waits, also for other imports of the same names, which come one
  /// after the other. The request's tenant owns them; it is told the progress, and its cancelling ends the import.
  /// Returns what of the files is not used, for their user.
  std::vector<std::string> import(Request& request, const Import& what);

  /// Puts a dataset of `type` in the directory whose parts a work has made on all ranks, each by Objects::add under `key`.
  void add(const std::string& tenant, const std::string& name, Scope scope, Key key, DatasetType type);

  std::vector<NamedDataset> list(const std::string& tenant) const;
  /// Throws Error where the tenant sees none of this name.
  NamedDataset get(const std::string& tenant, const std::string& name) const;
  std::optional<NamedDataset> find(const std::string& tenant, const std::string& name) const;
  /// The same with its current generation held: while the pin lives, every rank has that generation, as its current one or
  /// the one before, unless the dataset is dropped.
  std::pair<NamedDataset, Pin> getPinned(const std::string& tenant, const std::string& name) const;
  /// Several at one moment, in the order of the names: no new generation, drop or change of names comes in between, so what
  /// one import or one step of a simulation has made is seen together or not at all.
  std::vector<std::pair<NamedDataset, Pin>> getPinned(const std::string& tenant,
                                                      std::span<const std::string> names) const;
  /// What all ranks know of it; null when it has been dropped. Waits.
  nlohmann::json info(const NamedDataset& dataset);
  /// The same of what the name means. Throws as get() does.
  std::pair<NamedDataset, nlohmann::json> info(const std::string& tenant, const std::string& name);

  /// These wait for all ranks. With a drop, imports of the tenant under way that are to give it the name end, too; where there are
  /// such, there need be no dataset.
  void drop(const std::string& tenant, const std::string& name);
  void rename(const std::string& tenant, const std::string& name, const std::string& newName);
  void move(const std::string& tenant, const std::string& name, Scope to, bool readOnly);

  /// Waits until the tenant sees this name with this generation or a newer one; without one, with a newer one than now.
  Generation wait(Request& request, const std::string& name, std::optional<Generation> generation,
                  double seconds);

  using Observer = std::function<void(const DatasetEvent&)>;
  /// Until the returned handle goes. Called on the thread that made the change; must be short.
  [[nodiscard]] std::shared_ptr<void> observe(Observer observer);

 private:
  nlohmann::json importHere(const nlohmann::json& parameters);
  /// Rank 0: what an import's data are cut by.
  std::shared_ptr<const Partitioning> partitioningFor(const nlohmann::json& parameters, const Box& data,
                                                      const Grid* grid) const;
  struct Importing;
  std::shared_ptr<void> takeNames(Request& request, const Import& what,
                                  const std::shared_ptr<Importing>& importing);
  /// Ends the imports under way that the tenant has begun and that are to give it this name. False if there are none.
  bool endImportsOf(const std::string& tenant, const std::string& name);
  /// New generations on this rank, all at one moment; `also` as Objects::commit.
  void commitHere(const nlohmann::json& updates, const std::function<void()>& also = {});
  /// A dataset that has no name yet.
  struct Unnamed {
    std::string name;  ///< that it is to get
    Key key;
    DatasetType type;
  };
  /// Throws Error unless the names of all updates still mean what is to be updated.
  void checkUpdates(const std::string& tenant, Scope scope, const nlohmann::json& updates) const;
  /// Names all and commits the updates, or none of either, and then tells. What has failed, or for
  /// what `check` has thrown at the last moment, is on no rank any more.
  void nameAll(
      const std::string& tenant, Scope scope, const std::vector<Unnamed>& added,
      const nlohmann::json& updates, const std::function<void()>& check = [] {});
  /// What a name means there. Throws Error if the tenant may not give it to something else.
  std::optional<NamedDataset> mayName(const std::string& tenant, const std::string& name, Scope scope) const;
  void abandonHere(Key key);
  nlohmann::json infoHere(const nlohmann::json& parameters) const;
  void tell(const DatasetEvent& event);
  void onObject(const ObjectEvent& event);
  Generation generationOf(Key key) const;
  NamedDataset named(const std::string& name, Scope scope, const DirectoryEntry& entry) const;
  void dropObject(Key key);

  Node& node_;
  Observers::Subscription subscription_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::mutex naming_;  ///< held while names change and that is told: one change at a time; before mutex_
  std::map<uint64_t, std::shared_ptr<const Partitioning>> like_;  ///< rank 0: to be used, by exchange
  std::map<std::string, std::shared_ptr<Importing>> importing_;   ///< rank 0: by name with its scope
  std::map<Key, std::pair<std::string, Scope>> names_;            ///< rank 0: of each object
  std::map<std::string, std::vector<Key>> newest_;                ///< rank 0: by owner, newest last
  std::map<uint64_t, std::shared_ptr<Observer>> observers_;
  uint64_t nextObserver_ = 0;
};

/// Throws Error unless the name is 1 to 255 bytes of text without control characters.
void checkDatasetName(const std::string& name);

}  // namespace gxy
