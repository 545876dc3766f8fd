// SPDX-License-Identifier: Apache-2.0
#include "multiserver/modules/viewer/cinema.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <filesystem>
#include <map>
#include <mutex>
#include <numeric>
#include <set>
#include <span>

#include "core/comm/error.h"
#include "core/io/file.h"
#include "core/scene/cinema_page.h"
#include "core/scene/cinema_table.h"
#include "core/scene/swept_pictures.h"
#include "multiserver/modules/viewer/batch.h"
#include "multiserver/modules/viewer/documents.h"
#include "multiserver/modules/viewer/members.h"
#include "multiserver/rendering/cost.h"
#include "multiserver/server/datasets.h"

namespace gxy::viewer {

using nlohmann::json;

namespace {

struct CinemaRequest {
  State state;
  Sweep sweep;
  std::string database;  ///< NAME.cdb
  std::string format;
  int concurrent = 4;
  int64_t steps = 1;
  bool depth = false, estimate = false;
  std::vector<std::string> warnings;
};

const json& documentIn(Members& members, const char* key, const char* what) {
  const json* document = members.find(key);
  if (!document || !document->is_object())
    throw Error(std::string("cinema: `") + key + "`: expected " + what);
  return *document;
}

CinemaRequest readCinema(Request& request, std::string_view text) {
  DocumentReader reader(request);
  Members members(reader, text, "cinema");
  CinemaRequest cinema;
  const json& document = documentIn(members, "state", "a state document");
  const json& sweep = documentIn(members, "sweep", "a sweep, an object with `axes`");
  cinema.database = members.text("to", "");
  if (cinema.database.empty()) throw Error("cinema: `to`: expected the name of a database, NAME.cdb");
  if (!cinema.database.ends_with(".cdb")) cinema.database += ".cdb";
  cinema.format = members.oneOf("format", {"png", "exr"});
  cinema.concurrent = int(members.integer("concurrent", 4, 1, 64));
  cinema.steps = members.integer("steps", 1, 1, 1000000);
  cinema.depth = members.flag("depth", false);
  cinema.estimate = members.flag("estimate", false);
  members.expectNoMore();
  StateFile file = reader.state(protocol::dump(document), "state");
  cinema.state = std::move(file.state);
  cinema.sweep = readSweep(protocol::dump(sweep), "sweep");
  cinema.warnings = std::move(file.warnings);
  cinema.warnings.insert(cinema.warnings.end(), cinema.sweep.warnings.begin(), cinema.sweep.warnings.end());
  if (cinema.steps > 1 && !cinema.sweep.hasTime())
    throw Error(
        "cinema: `steps`: expected 1, or an axis \"time\" in the sweep, so that no step replaces another");
  return cinema;
}

/// The time of data in a table: that of the newest of them, or the number of its step if no time is known.
std::string timeCell(const std::vector<Pin>& data) {
  double time = std::nan("");
  int64_t step = 0;
  for (const Pin& pin : data) {
    const auto dataset = pin.get<Dataset>();
    if (!std::isnan(dataset->time)) time = std::isnan(time) ? dataset->time : std::max(time, dataset->time);
    for (const Origin& origin : dataset->origins) step = std::max(step, origin.step);
  }
  return floatCell(std::isfinite(time) ? time : double(step));
}

/// The objects and generations that names mean.
using Versions = std::map<std::string, std::pair<Key, Generation>>;

/// Whether there are newer data of what a state shows, or makes that of. While it lives, they are wanted.
class News {
 public:
  News(Datasets& datasets, const std::string& tenant, const State& state)
      : datasets_(datasets), tenant_(tenant) {
    for (const Vis& vis : state.visualizations.at(0).operators) names_.insert(vis.dataset);
    for (const DatasetSpec& spec : state.datasets)
      for (const FilterInput& input : spec.inputs)
        names_.insert(input.datasets.begin(), input.datasets.end());
    wish_ = datasets.want(tenant, {names_.begin(), names_.end()});
    // The observer may still be running when this has gone.
    subscription_ = datasets.observe([seen = seen_](const DatasetEvent&) {
      const std::lock_guard lock(seen->mutex);
      seen->events++;
      seen->changed.notify_all();
    });
  }

  /// As scenes would show them now. Names of data that are not there are left out.
  Versions newest() const {
    Versions versions;
    for (const std::string& name : names_) {
      if (!datasets_.find(tenant_, name)) continue;
      try {
        const auto held = datasets_.getPinned(tenant_, name);
        versions[name] = {held.first.key, held.second.generation()};
      } catch (const Error&) {  // it was dropped just now
      }
    }
    return versions;
  }

  /// Waits until there are others than these. Throws Error if the request is cancelled.
  void waitBeyond(const Versions& versions, const Request& request) const {
    for (;;) {
      std::unique_lock lock(seen_->mutex);
      const uint64_t events = seen_->events;
      lock.unlock();
      if (newest() != versions) return;
      request.check();
      lock.lock();
      seen_->changed.wait_for(lock, std::chrono::milliseconds(100), [&] { return seen_->events != events; });
    }
  }

 private:
  struct Seen {
    std::mutex mutex;
    std::condition_variable changed;
    uint64_t events = 0;
  };
  Datasets& datasets_;
  const std::string tenant_;
  std::set<std::string> names_;
  const std::shared_ptr<Seen> seen_ = std::make_shared<Seen>();
  std::shared_ptr<void> wish_, subscription_;
};

/// At most what rows of pictures and their cameras take, in the sweep, the batch, the rows and the table.
int64_t bytesOfRows(size_t pictures, const Sweep& sweep) {
  constexpr size_t kBytesOfACell = 4 * 128;  // of 64 bytes or less
  return int64_t(pictures * (sizeof(SweptPicture) + sizeof(BatchPicture) +
                             (sweep.columns().size() + 2) * kBytesOfACell));
}

/// Renders a sweep into one database.
class CinemaWork {
 public:
  CinemaWork(Services& services, Request& request, const CinemaRequest& cinema, const SweptPictures& swept)
      : services_(services),
        request_(request),
        cinema_(cinema),
        swept_(swept),
        folder_(services.serverRank.folders.makeFolder(cinema.database)),
        mutex_(services.tables.of(folder_)),
        tableRoom_(request.session()),
        rows_(swept.pictures.size()),
        made_(swept.pictures.size(), 0) {
    columns_ = swept.columns;
    columns_.push_back("FILE");
    if (cinema.depth) columns_.push_back("FILE_depth");
  }

  /// What the last picture has shown.
  const Versions& shown() const { return shown_; }

  json run() {
    const auto begin = std::chrono::steady_clock::now();
    {
      const std::lock_guard lock(*mutex_);
      const CinemaTable table = tableNow();  // an error of it comes before any picture
      for (size_t p = 0; p < swept_.pictures.size(); p++)
        table.expectFits(swept_.parametersOf(p, floatCell(0)), nameOfTable());
    }
    const BatchRender batch = batchOf();
    json warnings;
    try {
      warnings = std::move(renderBatch(services_, request_, batch)["warnings"]);
    } catch (const std::exception&) {
      replaceTable();  // with what is done
      throw;
    }
    const size_t rows = replaceTable();
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return {{"database", cinema_.database},
            {"pictures", rows_.size()},
            {"rows", rows},
            {"seconds", seconds},
            {"warnings", std::move(warnings)},
            {"text", std::to_string(rows_.size()) + " pictures; " + cinema_.database + " has " +
                         std::to_string(rows) + ", and index.html shows them"}};
  }

 private:
  BatchRender batchOf() {
    BatchRender batch;
    batch.format = cinema_.format;
    batch.concurrent = cinema_.concurrent;
    batch.sceneByScene = true;
    batch.datasets = cinema_.state.datasets;
    for (const SweptScene& s : swept_.scenes)
      batch.scenes.push_back({s.visualization, s.settings, s.annotations});
    order_.resize(swept_.pictures.size());
    std::iota(order_.begin(), order_.end(), size_t(0));
    std::stable_sort(order_.begin(), order_.end(), [this](size_t a, size_t b) {
      return swept_.pictures[a].scene < swept_.pictures[b].scene;
    });
    for (const size_t p : order_)
      batch.pictures.push_back({swept_.pictures[p].scene, swept_.pictures[p].camera, {}});
    batch.filesOf = [this](size_t i, const SceneCache::Pinned& data) { return filesOf(order_[i], data); };
    batch.made = [this](size_t i) { made_[order_[i]] = 1; };
    return batch;
  }

  BatchRender::Files filesOf(size_t picture, const SceneCache::Pinned& data) {
    const DataFolders& folders = services_.serverRank.folders;
    for (const NamedDataset& d : data.scene->data) shown_[d.name] = {d.key, d.generation};
    CinemaTable::Row row = swept_.parametersOf(picture, timeCell(data.pins));
    const std::string name = cinemaFileName(row, swept_.time);
    folders.makeFolder(folder_ + "/" + name.substr(0, name.find('/')));
    row.push_back(name + "." + cinema_.format);
    BatchRender::Files files{folders.toWrite(folder_ + "/" + row.back()), {}};
    if (cinema_.depth) {
      row.push_back(name + "_depth.exr");
      files.depth = folders.toWrite(folder_ + "/" + row.back());
    }
    rows_[picture] = std::move(row);
    return files;
  }

  std::string nameOfTable() const { return cinema_.database + "/data.csv"; }

  /// The table as it is now, by one request at a time. Others may have added to it. The room for it is kept, so that what has been rendered
  /// can be put into it.
  CinemaTable tableNow() {
    const std::string csv = folder_ + "/data.csv";
    if (!std::filesystem::exists(csv)) return continuedTable({}, columns_, nameOfTable());
    constexpr uintmax_t kLongest = uintmax_t(256) << 20;
    std::error_code failed;
    const uintmax_t size = std::filesystem::file_size(csv, failed);
    const auto limit = failed ? 0 : int64_t(std::min(size, kLongest));
    tableRoom_.atLeast(limit);
    const std::string text = services_.serverRank.folders.textOf(csv, limit);
    tableRoom_.atLeast(limit + memoryOfTable(text));
    return continuedTable(text, columns_, nameOfTable());
  }

  /// Adds what has been made to the table. Returns the number of its rows.
  size_t replaceTable() {
    const DataFolders& folders = services_.serverRank.folders;
    const std::lock_guard lock(*mutex_);
    CinemaTable table = tableNow();
    bool more = false;
    for (size_t p = 0; p < rows_.size(); p++)
      if (made_[p]) {
        table.put(rows_[p]);
        more = true;
      }
    if (!more) return table.rows().size();
    const auto replace = [&](const char* name, const std::string& text) {
      folders.write(folders.toWrite(folder_ + "/" + name), std::as_bytes(std::span(text)));
    };
    replace("data.csv", table.text());
    replace("index.html", cinemaPage(table, std::filesystem::path(cinema_.database).filename().string()));
    return table.rows().size();
  }

  Services& services_;
  Request& request_;
  const CinemaRequest& cinema_;
  const SweptPictures& swept_;
  const std::string folder_;
  const std::shared_ptr<std::mutex> mutex_;  ///< of the table
  KeptRoom tableRoom_;
  CinemaTable::Row columns_;
  Versions shown_;
  std::vector<size_t> order_;           ///< of pictures, those of a scene together
  std::vector<CinemaTable::Row> rows_;  ///< by picture, once its data are known
  std::vector<char> made_;              ///< by picture; each is written once, before the batch ends
};

}  // namespace

json cinema(Services& services, Request& request, std::string_view document) {
  CinemaRequest cinema = readCinema(request, document);
  const size_t pictures = countOfPictures(cinema.sweep, cinema.state);
  if (cinema.estimate) {
    const size_t scenes = countOfScenes(cinema.sweep);
    return {{"pictures", pictures},
            {"scenes", scenes},
            {"columns", cinema.sweep.columns()},
            {"warnings", cinema.warnings},
            {"text", std::to_string(pictures) + " pictures, of " + std::to_string(scenes) + " scenes"}};
  }
  KeptRoom room(request.session());
  room.add(bytesOf(cinema.state) + bytesOfRows(pictures, cinema.sweep));
  room.take();
  // A reader for each text: what one has read counts until it goes.
  const auto read = [&](const std::string& text) {
    StateFile file = DocumentReader(request).state(text, "state");
    if (file.state.datasets != cinema.state.datasets)
      throw Error("the sweep varies keys of `Datasets`, expected none, as a server makes these once");
    for (const Visualization& visualization : file.state.visualizations) checkCost(visualization);
    room.add(
        2 *
        bytesOf(file.state));  // for the sweep and the batch; `check` takes it, whose errors are no state's
    return file;
  };
  const SweptPictures swept = sweptPictures(cinema.sweep, cinema.state, read, [&] {
    request.check();
    room.take();
  });
  room.take();
  const News news(*services.serverRank.datasets, request.session().tenant(), cinema.state);
  json result;
  Versions shown, last;  // by the last pass; `shown` with what its data are made of
  for (int64_t steps = 0; steps < cinema.steps;) {
    if (steps > 0) news.waitBeyond(shown, request);
    shown = news.newest();
    CinemaWork work(services, request, cinema, swept);
    result = work.run();
    for (const auto& version : work.shown()) shown[version.first] = version.second;
    for (const json& w : result["warnings"]) cinema.warnings.push_back(w);
    steps += work.shown() != last;  // data may come in while they are looked at
    last = work.shown();
  }
  result["warnings"] = cinema.warnings;
  if (!cinema.warnings.empty())
    result["text"] = result["text"].get<std::string>() + "\n" + linesOf(cinema.warnings);
  return result;
}

}  // namespace gxy::viewer
