// SPDX-License-Identifier: Apache-2.0
#include "insitu/embed/embed.h"

#include <dlfcn.h>
#include <mpi.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <unistd.h>

#include <boost/asio/ip/address.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "backends/registry/backends.h"
#include "core/comm/error.h"
#include "core/comm/mpi_transport.h"
#include "core/comm/wire.h"
#include "core/image/replace_file.h"
#include "multiserver/protocol/run_files.h"
#include "multiserver/server/server.h"

namespace {

using namespace gxy;
using nlohmann::json;

constexpr uint64_t kStart = 1;  // key of the collectives at start and end

// The folder of modules beside this library, built or installed.
std::string ownModules() {
  Dl_info info{};
  if (dladdr(reinterpret_cast<const void*>(&ownModules), &info) == 0 || !info.dli_fname) return {};
  std::error_code failed;
  const auto folder = std::filesystem::absolute(info.dli_fname, failed).parent_path() / "galaxy";
  return std::filesystem::is_directory(folder, failed) ? folder.string() : std::string();
}

/// The member "here" of the options.
struct Settings {
  uint16_t port = 5001;
  std::string bind = "127.0.0.1", portFile, data, backend = "auto";
  int threads = 1;
  int niceness = 5;
};

Settings readSettings(const std::string& options) {
  Settings s;
  const json all = json::parse(options, nullptr, false);
  const json given = all.is_object() ? all.value("here", json::object()) : json::object();
  if (!given.is_object()) throw Error("option \"here\": expected an object");
  const auto integer = [&](const char* key, int64_t fallback, int64_t least, int64_t most) {
    const json value = given.value(key, json(fallback));
    if (!value.is_number_integer() || value.get<int64_t>() < least || value.get<int64_t>() > most)
      throw Error(std::string("option \"here\", \"") + key + "\": expected an integer from " +
                  std::to_string(least) + " to " + std::to_string(most));
    return value.get<int64_t>();
  };
  const auto text = [&](const char* key, const std::string& fallback) {
    const json value = given.value(key, json(fallback));
    if (!value.is_string()) throw Error(std::string("option \"here\", \"") + key + "\": expected a text");
    return value.get<std::string>();
  };
  for (const auto& [key, value] : given.items())
    if (key != "bind" && key != "port" && key != "port-file" && key != "data" && key != "backend" &&
        key != "threads" && key != "niceness")
      throw Error("option \"here\": there is no \"" + key +
                  "\", expected bind, port, port-file, data, backend, threads or niceness");
  s.port = uint16_t(integer("port", s.port, 0, 65535));
  s.threads = int(integer("threads", s.threads, 1, 4096));
  s.niceness = int(integer("niceness", s.niceness, 0, 19));
  s.bind = text("bind", s.bind);
  boost::system::error_code wrong;
  boost::asio::ip::make_address(s.bind, wrong);
  if (wrong)
    throw Error("option \"here\", \"bind\": found \"" + s.bind + "\", expected an address as 0.0.0.0");
  s.portFile = text("port-file", "");
  s.data = text("data", "");
  s.backend = text("backend", s.backend);
  return s;
}

// Whether the ranks are on several machines; the same on all of them.
bool isOnSeveralMachines(MPI_Comm comm) {
  MPI_Comm beside;
  int here = 0, all = 0;
  MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &beside);
  MPI_Comm_size(beside, &here);
  MPI_Comm_size(comm, &all);
  MPI_Comm_free(&beside);
  return here < all;
}

std::string hostOf(const std::string& bind) {
  const auto address = boost::asio::ip::make_address(bind);
  char name[256] = {};
  if (!address.is_unspecified()) return address.to_string();
  return gethostname(name, sizeof name - 1) == 0 ? name : "localhost";
}

/// The server of this process, one rank of it. Made and destroyed on all ranks together.
class Embedded {
 public:
  /// Throws the same Error on all ranks, or one of this rank only before the ranks have met.
  Embedded(const void* communicator, const Settings& settings)
      : transport_(transportOptions(communicator, settings)) {
    std::string failure;
    try {
      const BackendRegistry backends = allBackends({{}, transport_.rankOnNode()});
      ServerRankOptions options;
      options.backend = settings.backend;
      options.insituBind = settings.bind;
      options.threads = transport_.threads();
      if (!settings.data.empty()) options.dataFolders = {settings.data};
      if (std::string own = ownModules(); !own.empty()) options.moduleFolders = {std::move(own)};
      rank_ = std::make_unique<ServerRank>(transport_, std::move(options), backends);
    } catch (const std::exception& e) {
      failure = e.what();
    }
    std::unique_ptr<Collective> spare;
    if (!rank_) spare = std::make_unique<Collective>(transport_);
    Collective& collective = rank_ ? rank_->collective : *spare;
    const auto agreed = [&] {
      collective.agree(kStart, failure.empty() ? std::nullopt : std::optional(failure));
    };
    agreed();
    std::string token;
    uint16_t port = 0;
    if (transport_.rank() == 0) {
      try {
        token = newToken();
        rank_->tenants.add(token, {"user", true});
        ServerOptions options;
        options.port = settings.port;
        options.bind = settings.bind;
        options.signals = false;
        server_ = std::make_unique<Server>(*rank_, options, [] {});
        port = server_->port();
        protocol::removeStaleTokens();
        protocol::makeRunDirectory();
        tokenFile_.emplace(protocol::tokenFile(port), token);
        if (!settings.portFile.empty()) {
          const std::string text = std::to_string(port) + "\n";
          replaceFile(settings.portFile, std::as_bytes(std::span(text)));
        }
      } catch (const std::exception& e) {
        failure = e.what();
      }
    }
    try {
      agreed();
    } catch (const Error&) {
      server_.reset();
      throw;
    }
    const std::string host = transport_.rank() == 0 ? hostOf(settings.bind) : std::string();
    const Bytes told = collective.broadcast(kStart, 0, Writer().write(port).write(token).write(host).take());
    Reader reader(told, "address of the server");
    port_ = reader.read<uint16_t>();
    token_ = reader.readString();
    host_ = reader.readString();
  }
  ~Embedded() {
    // What triggers have begun for streams that have ended is finished.
    const auto isEnding = [](const json& stream) { return stream.contains("ending"); };
    const auto someEnd = [&] {
      const json streams = rank_->streaming.list();
      return std::any_of(streams.begin(), streams.end(), isEnding);
    };
    while (rank_->rank() == 0 && someEnd()) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    tokenFile_.reset();
    server_.reset();
    rank_->collective.barrier(kStart);
  }
  Embedded(const Embedded&) = delete;
  Embedded& operator=(const Embedded&) = delete;

  const std::string& host() const { return host_; }
  uint16_t port() const { return port_; }
  const std::string& token() const { return token_; }

 private:
  static MpiTransport::Options transportOptions(const void* communicator, const Settings& settings) {
    MpiTransport::Options options;
    options.communicator = communicator;
    options.threads = settings.threads;
    return options;
  }

  MpiTransport transport_;
  std::unique_ptr<ServerRank> rank_;
  std::unique_ptr<Server> server_;
  std::optional<protocol::TokenFile> tokenFile_;
  uint16_t port_ = 0;
  std::string host_, token_;
};

Embedded* embedded = nullptr;  // A process that exits without stop() must not wait for the others.

template <size_t Size>
void put(char (&to)[Size], const std::string& text) {
  std::snprintf(to, Size, "%s", text.c_str());
}

// On a thread that lasts for this call only: the threads that it makes are as nice as it is.
int start(const void* communicator, const char* options, galaxy_embed_address* address) {
  std::string failure;
  try {
    int level = 0;
    MPI_Query_thread(&level);
    if (level < MPI_THREAD_MULTIPLE)
      throw Error("MPI runs with thread level " + std::to_string(level) +
                  ", expected MPI_THREAD_MULTIPLE of MPI_Init_thread; or use a server beside");
    const Settings settings = readSettings(options);
    const bool isLocal = boost::asio::ip::make_address(settings.bind).is_loopback();
    if (isOnSeveralMachines(*static_cast<const MPI_Comm*>(communicator)) && isLocal)
      throw Error(
          "the ranks are on several machines, expected the option \"here\" with \"bind\": an address on "
          "which others reach "
          "this one, or 0.0.0.0");
    std::thread([&] {
      try {
        setpriority(PRIO_PROCESS, 0, settings.niceness);  // of this thread
        if (!spdlog::get("galaxy")) {
          spdlog::set_default_logger(spdlog::stderr_color_mt("galaxy"));
          spdlog::set_level(spdlog::level::warn);
        }
        embedded = new Embedded(communicator, settings);
      } catch (const std::exception& e) {
        failure = e.what();
      }
    }).join();
  } catch (const std::exception& e) {
    failure = e.what();
  }
  if (!embedded) {
    put(address->error, failure);
    return 1;
  }
  put(address->host, embedded->host());
  address->port = embedded->port();
  put(address->token, embedded->token());
  return 0;
}

int startFortran(int communicator, const char* options, galaxy_embed_address* address) {
  const MPI_Comm comm = MPI_Comm_f2c(communicator);
  return start(&comm, options, address);
}

void stop() { delete std::exchange(embedded, nullptr); }

#define TEXT_OF(x) #x
#define VALUE_OF(x) TEXT_OF(x)
#ifdef OMPI_MAJOR_VERSION
constexpr const char* kMpi = "Open MPI v" VALUE_OF(OMPI_MAJOR_VERSION) ".";
#else
constexpr const char* kMpi = "MPI";
#endif

}  // namespace

extern "C" __attribute__((visibility("default")))
const galaxy_embed galaxy_embed_impl{GALAXY_EMBED_VERSION, kMpi, start, startFortran, stop};
