// SPDX-License-Identifier: Apache-2.0
// Datasets in the data space: imported on all ranks, named on rank 0, and who is told.
#pragma once
#include <atomic>
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
#include "core/scene/dataset_type.h"
#include "core/scene/scene.h"
#include "core/space/publication.h"
#include "multiserver/server/server_rank.h"

namespace gxy {

class Request;

/// A dataset as a tenant sees it.
struct NamedDataset {
  Key key;
  std::string name;
  Scope scope = Scope::Private;
  std::string type, owner;
  bool readOnly = false;
  Generation generation = 0;
  bool ofGraph = false;  ///< it is GRAPH/NODE, and only the graph changes what this name means
};

/// Datasets by the names that a request knows them by, each with the generation that it uses, pinned. What others publish and rename
/// changes nothing for the request.
using PinnedData = std::map<std::string, std::pair<NamedDataset, Pin>>;

/// A dataset that is to be published under a name.
struct DatasetDraft {
  std::string name;
  DatasetType type = DatasetType::Volume;
  Key key{};  ///< of the object that has the name, if that is of the same type; else of a new one
  Generation generation = 1;  ///< that its data will be; 1: the object is new
};

/// What is told about names. Rank 0.
struct DatasetEvent {
  enum class Kind { Added, Updated, Skipped, Dropped, Renamed };
  Kind kind;
  NamedDataset dataset;
  std::string newName;  ///< Renamed
  nlohmann::json
      origin;  ///< Added and Updated of a stream's data: an object with `stream`, `step` and `time`; else null
  bool visibleTo(const std::string& tenant) const {
    return dataset.scope == Scope::Shared || dataset.owner == tenant;
  }
  nlohmann::json json() const;
};

/// Thread safe. All calls are for rank 0 but addWorks(), join() and publish(); those that say so wait for all ranks.
///
/// Data get their names in one way, whoever makes them. A request takes the names on rank 0 (begin). The work that makes the
/// data has a Publication of them on every rank (join), to which it gives the data before they are published (publish).
class Datasets {
 public:
  explicit Datasets(ServerRank& serverRank);
  ~Datasets();
  void addWorks();

  struct Import {
    std::vector<DatasetSpec> specs;
    Scope scope = Scope::Private;
    bool newPartitioning = false;
    std::string like;          ///< the dataset whose partitioning is to be used; empty: see docs/protocol.md
    bool onlyMissing = false;  ///< leaves out names that the tenant sees already
    bool ofGraph = false;      ///< the names are a graph's
  };
  /// Reads files and names what is in them: all or nothing. Waits, also for other imports of the same names, which come one
  /// after the other. The request's tenant owns them; it is told the progress, and its cancelling ends the import.
  /// Returns what of the files is not used, for their user.
  std::vector<std::string> import(Request& request, const Import& what);
  struct Imported {
    std::vector<DatasetDraft> datasets;  ///< what was published
    std::vector<std::string> warnings;   ///< what of the files is not used
  };
  /// The same for a tenant, whoever asks. `begun` gets the number of the exchange; whoever does not want the import any more cancels
  /// that. Throws what `asker.check` throws.
  Imported import(const std::string& tenant, const Asker& asker,
                  const std::function<void(uint64_t exchange)>& begun, const Import& what);

  /// The names under which a request publishes data. Other requests that want one of them wait until this is released.
  class Names {
   public:
    const std::vector<DatasetDraft>& drafts() const { return drafts_; }
    /// Returns what join() needs; it travels in the parameters of a work.
    nlohmann::json items() const;
    /// Throws Error once the tenant has dropped one of the names, which also cancels the exchange.
    void check() const;

   private:
    friend class Datasets;
    std::string operation_, tenant_;
    Scope scope_ = Scope::Private;
    uint64_t exchange_ = 0;
    std::vector<DatasetDraft> drafts_;
    std::atomic<bool> dropped_ = false;
    bool ofGraph_ = false;
    bool givesWay_ = false;              ///< to others that want one of the names
    std::atomic<bool> leaving_ = false;  ///< somebody does
  };
  /// Takes the names of `drafts` for the request's tenant, who will own what has no owner yet, and fills in keys and
  /// generations. Waits for others who have taken one of them. `exchange` names the works that will publish, `operation` (a
  /// verb) what errors call it. With `onlyMissing`, drafts whose names the tenant sees already are left out. Throws Error for
  /// names that are not valid, come twice, or that the tenant may not give to something else.
  [[nodiscard]] std::shared_ptr<const Names> begin(Request& request, uint64_t exchange,
                                                   const std::string& operation, Scope scope,
                                                   std::vector<DatasetDraft> drafts,
                                                   bool onlyMissing = false);
  /// The same for one who publishes again and again: it does not wait, and gives way to requests that do. Throws Error where somebody
  /// else publishes under one of the names now.
  [[nodiscard]] std::shared_ptr<const Names> beginNow(const std::string& tenant, uint64_t exchange,
                                                      const std::string& operation, Scope scope,
                                                      std::vector<DatasetDraft> drafts);
  /// Makes the Publication of these names on a rank, in a work of the exchange. Its items are in the order of the drafts, and what
  /// is staged for them are Datasets.
  Publication join(const nlohmann::json& items, Collectives& ranks);
  /// Collective, in the same work. All items get their data and their names at one moment, and observers are told. If one of the
  /// names means something else by now, or the tenant may not have it any more, all ranks throw Error and nothing has changed.
  void publish(Publication& publication, uint64_t exchange);
  /// Throws Error if the names cannot be published any more, which says more than what the works have thrown then.
  void check(const Names& names) const { newObjects(names); }

  std::vector<NamedDataset> list(const std::string& tenant) const;
  /// Throws Error where the tenant sees none of this name.
  NamedDataset get(const std::string& tenant, const std::string& name) const;
  std::optional<NamedDataset> find(const std::string& tenant, const std::string& name) const;
  /// The same with its current generation held: while the pin lives, every rank has that generation, as its current one or
  /// the one before, unless the dataset is dropped.
  std::pair<NamedDataset, Pin> getPinned(const std::string& tenant, const std::string& name) const;
  /// Does this for several names at one moment, in their order. No new generation, drop or change of names comes in between, so
  /// what was published together is seen together or not at all.
  std::vector<std::pair<NamedDataset, Pin>> getPinned(const std::string& tenant,
                                                      std::span<const std::string> names) const;
  /// Does this for those of `names` that `pinned` has not.
  void pin(const std::string& tenant, const std::vector<std::string>& names, PinnedData& pinned) const;
  /// What all ranks know of it; null when it has been dropped. Waits.
  nlohmann::json info(const NamedDataset& dataset);
  /// The same of what the name means. Throws as get() does.
  std::pair<NamedDataset, nlohmann::json> info(const std::string& tenant, const std::string& name);

  /// Gives what a dataset is now another name, too, which keeps it when the dataset gets newer data. Nothing is copied but what describes
  /// the data; the tenant's memory is counted as if it were. Like import(), it waits, and publishes under the new name. Returns the
  /// generation there, and of a stream's data which step they are (DatasetEvent::origin).
  nlohmann::json copy(Request& request, const std::string& name, const std::string& newName, Scope scope);

  /// These wait for all ranks. A drop also ends imports and filters of the tenant that are under way and are to publish the
  /// name; where there are such, there need be no dataset.
  void drop(const std::string& tenant, const std::string& name);
  /// The same of an object that a graph has imported, which loses the name if it has it.
  void dropOfGraph(const std::string& tenant, const std::string& name, Key key);
  void rename(const std::string& tenant, const std::string& name, const std::string& newName);
  void move(const std::string& tenant, const std::string& name, Scope to, bool readOnly);

  /// Gives a graph's name GRAPH/NODE to an object that the graph has made, in the tenant's directory; observers are told. A name that
  /// the tenant has given to other data stays theirs. The object that had the name before stays, too.
  void nameOfGraph(const std::string& tenant, const std::string& name, Key key, DatasetType type);
  /// The same for a name of the graph's choice, without a `/`. It must be free, or mean `present`. Returns false otherwise, and then nothing
  /// has changed.
  bool publishOfGraph(const std::string& tenant, const std::string& name, Key key, DatasetType type,
                      Key present);
  /// Takes the name away from this object, if it has it.
  void unnameOfGraph(const std::string& tenant, const std::string& name, Key key);

  /// Waits until the tenant sees this name with this generation or a newer one; without one, with a newer one than now.
  Generation wait(Request& request, const std::string& name, std::optional<Generation> generation,
                  double seconds);

  /// Says that a tenant waits for newer data of these names (none: of all that it sees), until the returned handle goes. Sources of
  /// data that come by themselves make what is wanted (multiserver/insitu).
  [[nodiscard]] std::shared_ptr<void> want(const std::string& tenant, const std::vector<std::string>& names);
  /// Whether somebody who would see this name waits for newer data of it.
  bool wanted(const std::string& tenant, Scope scope, const std::string& name) const;

  using Observer = std::function<void(const DatasetEvent&)>;
  /// Until the returned handle goes. Called on the thread that made the change; must be short.
  [[nodiscard]] std::shared_ptr<void> observe(Observer observer);

 private:
  nlohmann::json importHere(const nlohmann::json& parameters);
  nlohmann::json copyHere(const nlohmann::json& parameters);
  /// Rank 0: chooses the partitioning of an import. `data` is the box of its data; `grid`, if not null, that of its first volume.
  std::shared_ptr<const Partitioning> partitioningFor(const nlohmann::json& parameters, const Box& data,
                                                      const Grid* grid) const;
  /// Collective. The same on every rank.
  std::shared_ptr<const Partitioning> agreedPartitioning(const nlohmann::json& parameters, const Box& data,
                                                         const Grid* grid, Collectives& ranks);
  void fillIn(Names& names) const;
  std::set<std::string> keysOf(const Names& names) const;
  bool areFree(const std::set<std::string>& keys) const;
  void askToLeave(const std::set<std::string>& keys);
  std::shared_ptr<const Names> take(const std::set<std::string>& keys, const std::shared_ptr<Names>& names);
  std::shared_ptr<const Names> takeNames(const Asker& asker, const std::shared_ptr<Names>& names);
  void notifyOnCancel(Request& request);
  Imported importAs(const std::string& tenant, const Asker& asker, uint64_t exchange, const Import& what);
  std::shared_ptr<const Names> begin(const Asker& asker, const std::shared_ptr<Names>& names,
                                     bool onlyMissing);
  std::shared_ptr<const Names> namesOf(uint64_t exchange) const;
  /// Ends what the tenant has begun to publish under this name. False if there is nothing.
  bool endPublishingOf(const std::string& tenant, const std::string& name);
  /// A new object, and the dataset that loses its name to it.
  struct NewObject {
    NamedDataset dataset;
    std::optional<NamedDataset> replaced;
  };
  /// Returns the new objects of a publication as they will be named. Throws Error if the tenant may not have one of the names any more,
  /// or if one that is to get a next generation means another object by now.
  std::vector<NewObject> newObjects(const Names& names) const;
  /// What a name means there. Throws Error if the tenant may not give it to something else.
  std::optional<NamedDataset> mayName(const std::string& tenant, const std::string& name, Scope scope,
                                      bool ofGraph) const;
  nlohmann::json infoHere(const nlohmann::json& parameters) const;
  void tell(const DatasetEvent& event);
  void onObject(const ObjectEvent& event);
  Generation generationOf(Key key) const;
  /// What DatasetEvent::origin says of data, and of the current generation of an object.
  static nlohmann::json originOf(const Dataset& dataset);
  nlohmann::json originOf(Key key) const;
  NamedDataset named(const std::string& name, Scope scope, const DirectoryEntry& entry) const;
  void dropObject(Key key);

  ServerRank& serverRank_;
  Observers::Subscription subscription_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::mutex naming_;  ///< held while names change and that is told: one change at a time; before mutex_
  std::map<uint64_t, std::shared_ptr<const Partitioning>> like_;  ///< rank 0: to be used, by exchange
  std::map<std::string, std::shared_ptr<Names>> taken_;           ///< rank 0: by name with its scope
  std::multiset<std::string> awaited_;  ///< rank 0: names that requests wait for, with their scopes
  std::map<uint64_t, std::shared_ptr<const Names>> publishing_;  ///< rank 0: by exchange
  std::map<Key, std::pair<std::string, Scope>> names_;           ///< rank 0: of each object
  std::map<std::string, std::vector<Key>> newest_;               ///< rank 0: by owner, newest last
  /// How many wait for newer data, by name (empty: of all) and tenant.
  std::map<std::string, std::map<std::string, size_t>> wishes_;
  std::map<uint64_t, std::shared_ptr<Observer>> observers_;
  uint64_t nextObserver_ = 0;
};

/// Throws Error unless the name is 1 to 255 bytes of text without control characters.
void checkDatasetName(const std::string& name);

}  // namespace gxy
