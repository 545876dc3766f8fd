// SPDX-License-Identifier: Apache-2.0
// gxyserver: the multiserver. Every rank makes a ServerRank; rank 0 listens.
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <pwd.h>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <future>
#include <iostream>
#include <mutex>
#include <optional>
#include <thread>

#include "backends/registry/backends.h"
#include "core/comm/error.h"
#include "core/comm/mpi_environment.h"
#include "core/comm/mpi_transport.h"
#include "core/comm/wire.h"
#include "core/image/replace_file.h"
#include "multiserver/protocol/run_files.h"
#include "tools/gxyserver/options.h"
#include "tools/gxyserver/simulation.h"

using namespace gxy;

namespace {

/// Opens once; then all who wait go on.
class Gate {
 public:
  void open() {
    const std::lock_guard lock(mutex_);
    open_ = true;
    changed_.notify_all();
  }
  void wait() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return open_; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool open_ = false;
};

/// Calls `action` once, on a thread of its own, when a signal asks this process to end.
class Signals {
 public:
  explicit Signals(std::function<void()> action) : action_(std::move(action)) {
    set_.async_wait([this](auto failed, int) {
      if (!failed) action_();
    });
    thread_ = std::thread([this] { context_.run(); });
  }
  ~Signals() {
    boost::asio::post(context_, [this] { set_.cancel(); });
    thread_.join();
  }

 private:
  const std::function<void()> action_;
  boost::asio::io_context context_;
  boost::asio::signal_set set_{context_, SIGINT, SIGTERM, SIGUSR2};
  std::thread thread_;
};

std::string userName() {
  const passwd* user = getpwuid(getuid());
  return user ? user->pw_name : "user" + std::to_string(getuid());
}

std::string hostName() {
  char name[256] = {};
  return gethostname(name, sizeof name - 1) == 0 ? name : "HOST";
}

// How the ranks of a simulation reach this machine's rank.
std::string hostOf(const ServeOptions& options) {
  const auto where = boost::asio::ip::make_address(options.server.bind);
  return where.is_unspecified() ? hostName() : where.to_string();
}

/// The tokens of this server's tenants, which are made before it listens, and their files, which exist while
/// it runs. Each tenant has two: its own, and one with which others may only look.
class TokenFiles {
 public:
  TokenFiles(Tenants& tenants, const ServeOptions& options) : options_(options) {
    if (options.noToken) {
      tenants.admitAll();
      return;
    }
    add(tenants, {userName(), true, false}, "");
    for (const std::string& name : options.tenants) add(tenants, {name, false, false}, name);
  }
  void write(uint16_t port) {
    if (tokens_.empty()) return;
    protocol::removeStaleTokens();
    if (options_.tokenFile.empty() || !options_.tenants.empty()) protocol::makeRunDirectory();
    for (const Token& token : tokens_) files_.emplace_back(pathOf(token, port), token.text);
  }
  void remove() { files_.clear(); }
  const std::vector<protocol::TokenFile>& files() const { return files_; }
  bool isViewOnly(size_t file) const { return tokens_[file].viewOnly; }
  /// Empty if no token is asked for.
  std::string administrators() const { return tokens_.empty() ? std::string() : tokens_.front().text; }
  nlohmann::json paths() const {
    nlohmann::json paths = nlohmann::json::array();
    for (const protocol::TokenFile& file : files_) paths.push_back(file.path());
    return paths;
  }

 private:
  struct Token {
    std::string text, tenant;  ///< tenant: empty for the administrator's
    bool viewOnly;
  };
  void add(Tenants& tenants, Tenants::Identity identity, const std::string& tenant) {
    for (const bool viewOnly : {false, true}) {
      tokens_.push_back({newToken(), tenant, viewOnly});
      if (viewOnly) identity = {identity.tenant, false, true};
      tenants.add(tokens_.back().text, identity);
    }
  }
  std::string pathOf(const Token& token, uint16_t port) const {
    if (token.tenant.empty() && !options_.tokenFile.empty())
      return options_.tokenFile + (token.viewOnly ? ".view" : "");
    const std::string view = token.tenant.empty() ? "view" : token.tenant + ".view";
    return protocol::tokenFile(port, token.viewOnly ? view : token.tenant);
  }

  const ServeOptions& options_;
  std::vector<Token> tokens_;  ///< the administrator's first
  std::vector<protocol::TokenFile> files_;
};

/// The paths of rank 0's token files. Other ranks remove the files if rank 0 dies. Thread safe.
class TokensOfRoot {
 public:
  void set(const nlohmann::json& paths) {
    const std::lock_guard lock(mutex_);
    paths_ = paths.get<std::vector<std::string>>();
  }
  void removeStale() {
    const std::lock_guard lock(mutex_);
    for (const std::string& path : paths_) protocol::removeStaleToken(path);
  }

 private:
  std::mutex mutex_;
  std::vector<std::string> paths_;
};

/// Exists while the run is ending, and ends it by force if a rank is missing, because then it would never end.
/// It begins to check after 3 s, so that clients are told first and the launcher has time to end the ranks.
class Ending {
 public:
  Ending(MpiTransport& transport, Presence& presence, std::chrono::milliseconds patience)
      : thread_([=, this, &transport, &presence] { watch(transport, presence, patience); }) {}
  ~Ending() {
    {
      const std::lock_guard lock(mutex_);
      over_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }

 private:
  void watch(MpiTransport& transport, Presence& presence, std::chrono::milliseconds patience) {
    constexpr std::chrono::milliseconds kGrace(3000), kPause(200);
    std::unique_lock lock(mutex_);
    if (changed_.wait_for(lock, kGrace, [this] { return over_; })) return;
    do {
      presence.ask();
      const std::string missing = textOf(presence.missing(patience));
      if (missing.empty()) continue;
      std::cerr << "gxyserver: error: " + missing + ", so the run is ended by force\n";
      return transport.abort();
    } while (!changed_.wait_for(lock, kPause, [this] { return over_; }));
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  bool over_ = false;
  std::thread thread_;
};

// Under MPI, the output is a terminal of the launcher, wherever that writes to. A program that stands between tells
// by --print-ticket that it writes to a person's terminal.
bool isReadByUserOnly(const ServeOptions& options) {
  const bool launched =
      std::getenv("OMPI_COMM_WORLD_RANK") || std::getenv("PMI_RANK") || std::getenv("PMIX_RANK");
  return options.printTicket || (!launched && isatty(STDOUT_FILENO) == 1);
}

// How a browser gets in. A log that others may read gets no ticket.
void announceGui(const ServeOptions& options, const std::string& where, Tickets& tickets,
                 const TokenFiles& tokens) {
  if (!options.server.gui) return;
  std::cout << "gxyserver: in a browser:     ";
  if (tokens.files().empty())
    std::cout << "open http://" << where << "/\n";
  else if (isReadByUserOnly(options))
    std::cout << "open http://" << where
              << "/#ticket=" << tickets.issue(tokens.administrators(), Tickets::kLong) << "\n";
  else
    std::cout << "run: galaxy gui " << where
              << (options.tokenFile.empty() ? "" : " --token-file " + tokens.files().front().path()) << "\n";
}

void announce(const ServeOptions& options, uint16_t port, int ranks, Tickets& tickets,
              const TokenFiles& tokens) {
  using namespace boost::asio::ip;
  const std::string p = std::to_string(port);
  address where = make_address(options.server.bind);
  if (where.is_unspecified())
    where = where.is_v6() ? address(address_v6::loopback()) : address(address_v4::loopback());
  const bool usual = where == address_v4::loopback();  // clients use this address by default
  const std::string host = where.to_string();
  const std::string target = usual ? "localhost" : where.is_v6() ? "[" + host + "]" : host;
  std::string here = "msdata", there = "msdata -P " + p;
  if (!usual) here += " -H " + host;
  if (port != 5001) here += " -P " + p;
  if (tokens.files().empty())
    here += where.is_loopback() ? "" : " --token-file -";
  else if (!where.is_loopback() || !options.tokenFile.empty())
    here += " --token-file " + tokens.files().front().path();
  if (!tokens.files().empty()) there += " --token-file COPY";
  std::cout << "gxyserver: listening on " << options.server.bind << " port " << p << ", " << ranks << " rank"
            << (ranks > 1 ? "s" : "") << "\n"
            << "gxyserver: on this machine:  " << here << "\n"
            << "gxyserver: from elsewhere:   ssh -N -L " << p << ":" << target << ":" << p << " "
            << hostName() << "   then, there: " << there << "\n";
  announceGui(options, target + ":" + p, tickets, tokens);
  for (size_t i = 0; i < tokens.files().size(); i++)
    std::cout << "gxyserver: " << (tokens.isViewOnly(i) ? "view-only token in " : "token in ")
              << tokens.files()[i].path() << "\n";
  if (options.noToken)
    std::cout << "gxyserver: no token is asked for: everybody who can connect may do all\n";
  std::cout << std::flush;
}

void writeDocument(const std::string& file, const std::string& text) {
  replaceFile(file, std::as_bytes(std::span(text)));
}

// Writes the traces of all ranks to a file. A failure is reported and has no other effect.
void writeTrace(ServerRank& serverRank, const std::string& file) {
  try {
    std::vector<std::string> events;
    for (nlohmann::json& rank : serverRank.callAll("server.trace", nlohmann::json::object()))
      events.push_back(rank.get<std::string>());
    writeDocument(file, Trace::document(events));
  } catch (const Error& e) {
    std::cerr << "gxyserver: error: " << e.what() << '\n';
  }
}

// Whether triggers of streams that have ended are at work.
bool someEnd(const nlohmann::json& streams) {
  return std::any_of(streams.begin(), streams.end(),
                     [](const nlohmann::json& stream) { return stream.contains("ending"); });
}

/// A simulation in the same processes, or in the same MPI job.
struct Beside {
  std::string failure;                           ///< why it cannot be there on this rank; empty: it can
  const void* communicator = nullptr;            ///< of the server's ranks; null: MPI_COMM_WORLD
  std::function<void(const Listening&)> tell{};  ///< called once on each rank
  Gate stopped{};                                ///< somebody opens it on rank 0 to end the server
  std::atomic<bool> ended =
      false;  ///< the simulation has; what triggers have begun is finished before the server ends
};

int serve(const ServeOptions& options, Beside& beside) {
  const auto trace = options.traceFile.empty() ? nullptr : std::make_unique<Trace>();
  MpiTransport::Options transportOptions;
  transportOptions.trace = trace.get();
  transportOptions.communicator = beside.communicator;
  transportOptions.threads = options.threads;
  transportOptions.role = hasDevices(options.serverRank.backend);  // ranks with devices share them
  MpiTransport transport(transportOptions);
  const bool root = transport.rank() == 0;
  constexpr uint64_t kStart = 1;  // key of the collectives at start and end
  std::string failure = beside.failure;
  std::unique_ptr<ServerRank> serverRank;
  Gate& stopped = beside.stopped;
  TokensOfRoot tokensOfRoot;
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);  // Exceeding a file size limit is an error of write().
  try {
    const BackendRegistry backends = allBackends({options.device, transport.rankOnNode()});
    ServerRankOptions nodeOptions = options.serverRank;
    nodeOptions.threads = transport.threads();
    nodeOptions.trace = trace.get();
    serverRank = std::make_unique<ServerRank>(transport, std::move(nodeOptions), backends);
    spdlog::info("rank {}: backend {}, {}", transport.rank(), serverRank->backend->name(),
                 serverRank->backend->device());
    serverRank->work.add("gxyserver.stop", [&](const Work::Call&) {
      stopped.open();
      return nlohmann::json();
    });
    serverRank->work.add("gxyserver.tokens", [&](const Work::Call& call) {
      tokensOfRoot.set(call.parameters);
      return nlohmann::json();
    });
  } catch (const std::exception& e) {
    failure = e.what();
  }
  // A rank whose ServerRank could not be made still takes part in the collectives.
  std::unique_ptr<Collective> spare;
  if (!serverRank) spare = std::make_unique<Collective>(transport);
  Collective& collective = serverRank ? serverRank->collective : *spare;
  const auto agreed = [&](uint64_t exchange) {
    try {
      collective.agree(exchange, failure.empty() ? std::nullopt : std::optional(failure));
      return true;
    } catch (const Error& e) {
      if (root) std::cerr << "gxyserver: error: " << e.what() << '\n';
      return false;
    }
  };
  bool good = agreed(kStart);
  // A signal to any other rank is passed on to rank 0, which stops all ranks. Rank 0's Server handles its own
  // signals.
  std::optional<Signals> signals;
  if (good && !root)
    signals.emplace([&] {
      if (serverRank->presence.died(0)) tokensOfRoot.removeStale();
      serverRank->work.send(0, "gxyserver.stop", nlohmann::json::object(), {});
    });
  std::unique_ptr<Server> server;
  std::unique_ptr<TokenFiles> tokens;
  if (good && root) {
    try {
      if (trace) writeDocument(options.traceFile, Trace::document({}));  // fails now if it cannot be written
      tokens = std::make_unique<TokenFiles>(serverRank->tenants, options);
      server = std::make_unique<Server>(*serverRank, options.server, [&] { stopped.open(); });
      tokens->write(server->port());
      serverRank->work.broadcast("gxyserver.tokens", tokens->paths(), [](std::vector<Work::Reply>) {});
      announce(options, server->port(), transport.size(), serverRank->tickets, *tokens);
      if (!options.portFile.empty()) writeDocument(options.portFile, std::to_string(server->port()) + "\n");
    } catch (const std::exception& e) {
      failure = e.what();
    }
  }
  good = good && agreed(kStart);
  if (beside.tell) {
    Listening where;
    if (good) {
      if (root) where = {hostOf(options), server->port(), tokens->administrators()};
      const Bytes told = collective.broadcast(
          kStart, 0, Writer().write(where.host).write(where.port).write(where.token).take());
      Reader reader(told, "address of the server");
      where.host = reader.readString();
      where.port = reader.read<uint16_t>();
      where.token = reader.readString();
    }
    beside.tell(where);
  }
  std::optional<Ending> ending;
  if (good) {
    stopped.wait();
    if (root) {
      while (beside.ended && someEnd(serverRank->streaming.list()))
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
      ending.emplace(transport, serverRank->presence, options.serverRank.rankPatience);
      tokens->remove();  // first, in case there is little time
      server.reset();
      if (trace) writeTrace(*serverRank, options.traceFile);
      serverRank->work.broadcast("gxyserver.stop", nlohmann::json::object(), [](std::vector<Work::Reply>) {});
      std::cout << "gxyserver: stopped\n" << std::flush;
    }
  }
  server.reset();
  signals.reset();
  if (serverRank) serverRank->collective.barrier(kStart);
  return good ? 0 : 1;
}

/// serve() on a thread of its own, beside what the main thread does.
class Serving {
 public:
  Serving(const ServeOptions& options, Beside& beside) {
    beside.tell = [this](const Listening& where) {
      told_ = true;
      listening_.set_value(where);
    };
    thread_ = std::thread([this, &options, &beside] {
      try {
        status_ = serve(options, beside);
      } catch (const std::exception& e) {
        std::cerr << "gxyserver: error: " << e.what() << '\n';
        if (!told_) listening_.set_value({});
      }
    });
  }
  /// Waits until the server listens, or cannot.
  Listening listening() { return listening_.get_future().get(); }
  /// Waits for the server's end, and returns its status.
  int join() {
    thread_.join();
    return status_;
  }

 private:
  std::promise<Listening> listening_;
  bool told_ = false;  ///< used by the thread only
  int status_ = 1;
  std::thread thread_;
};

// The server goes on after the simulation's end, until somebody stops it; and the simulation after the server's.
int serveWithSimulation(const ServeOptions& options) {
  Beside beside;
  std::optional<LoadedSimulation> simulation;
  try {
    simulation.emplace(options.simulation, options.serverRank.moduleFolders);
  } catch (const Error& e) {
    beside.failure = e.what();
  }
  Serving serving(options, beside);
  const Listening where = serving.listening();
  const int status = where.port > 0 ? simulation->run(where, options.simulationArguments) : 0;
  return std::max(serving.join(), status);
}

int serveWorld(const ServeOptions& options) {
  SharedWorld world;
  Beside beside;
  beside.communicator = world.communicator();
  Serving serving(options, beside);
  world.tell(serving.listening());
  world.awaitEnd();
  beside.ended = true;
  beside.stopped.open();
  return serving.join();
}

}  // namespace

int main(int argc, char** argv) {
  ServeOptions options;
  try {
    const char* rank = std::getenv("OMPI_COMM_WORLD_RANK");  // MPI is not initialised yet
    if (!rank) rank = std::getenv("PMI_RANK");
    if (const auto code = parseOptions(argc, argv, !rank || std::string(rank) == "0", options)) return *code;
    MpiEnvironment mpi(options.world || !options.simulation.empty());
    spdlog::set_default_logger(spdlog::stderr_color_mt("gxyserver"));
    spdlog::set_level(spdlog::level::from_str(options.logLevel));
    if (options.world) return serveWorld(options);
    if (!options.simulation.empty()) return serveWithSimulation(options);
    Beside nobody;
    return serve(options, nobody);
  } catch (const std::exception& e) {
    std::cerr << "gxyserver: error: " << e.what() << '\n';
    return 1;
  }
}
