// SPDX-License-Identifier: Apache-2.0
#include "multiserver/server/server.h"

#include <spdlog/spdlog.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <csignal>
#include <future>
#include <mutex>
#include <set>
#include <thread>
#include <vector>

#include "core/comm/error.h"
#include "multiserver/web/answer.h"

namespace gxy {

namespace asio = boost::asio;
using asio::ip::tcp;
using nlohmann::json;

namespace {
constexpr size_t kHandshakes = 256;  // limit on sockets without a session; beyond it the oldest is closed
}

class Server::Impl {
 public:
  Impl(ServerRank& serverRank, ServerOptions options, std::function<void()> onStop)
      : serverRank_(serverRank),
        options_(std::move(options)),
        onStop_(std::move(onStop)),
        site_(options_.gui ? std::make_shared<const Site>(
                                 Site{GuiFiles(options_.guiFolder), Hosts(options_.hosts, options_.bind)})
                           : nullptr),
        acceptor_(*context_),
        signals_(*context_),
        timer_(*context_),
        questions_(*context_) {
    listen();
    if (options_.signals) {
      signals_.add(SIGINT);
      signals_.add(SIGTERM);
      signals_.add(SIGUSR2);  // mpirun passes it on and keeps running
      signals_.async_wait([this](auto failed, int) {
        if (!failed) stop();
      });
    }
    serverRank_.clients = [this] { return statistics(); };
    serverRank_.stop = [this] { stop(); };
    accept();
    watchIdleness();
    watchRanks();
    thread_ = std::thread([this] { context_->run(); });
  }

  ~Impl() {
    const std::string reason = farewell();
    asio::post(*context_, [this, reason] {
      boost::system::error_code ignored;
      acceptor_.close(ignored);
      signals_.cancel(ignored);
      retry_ = false;
      timer_.cancel(ignored);
      questions_.cancel(ignored);
      for (const auto& connection : std::set(connections_)) connection->bye(reason);
      const std::lock_guard lock(mutex_);
      ending_ = true;
      changed_.notify_all();
    });
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return count_ == 0 && sessionsEnding_ == 0 && ending_; });
    }
    serverRank_.streaming.end();
    serverRank_.endings.end();
    context_->stop();
    thread_.join();
    context_->restart();
    context_->poll();  // Cancelled operations hold connections, which hold the context.
    serverRank_.clients = [] { return json::array(); };
    serverRank_.stop = [] {};
  }

  uint16_t port() const { return port_; }
  size_t clients() const {
    const std::lock_guard lock(mutex_);
    return count_ + sessionsEnding_;
  }

 private:
  using ConnectionPtr = std::shared_ptr<Connection>;

  void listen() {
    try {
      const tcp::endpoint where(asio::ip::make_address(options_.bind), options_.port);
      acceptor_.open(where.protocol());
      acceptor_.set_option(tcp::acceptor::reuse_address(true));
      acceptor_.bind(where);
      acceptor_.listen(asio::socket_base::max_listen_connections);
      port_ = acceptor_.local_endpoint().port();
    } catch (const boost::system::system_error& e) {
      throw Error("cannot listen on " + options_.bind + " port " + std::to_string(options_.port) + ": " +
                  e.code().message() + "; expected a free port and an address of this machine");
    }
  }

  void accept() {
    acceptor_.async_accept([this](auto failed, tcp::socket socket) {
      if (failed == asio::error::operation_aborted || ending_) return;
      if (failed) {  // for instance, no file descriptors are left
        spdlog::warn("rank 0: a client could not be accepted: {}", failed.message());
        timer_.expires_after(std::chrono::milliseconds(100));
        retry_ = true;
        return timer_.async_wait([this](auto) {
          if (std::exchange(retry_, false)) {
            accept();
            watchIdleness();
          }
        });
      }
      const auto connection = std::make_shared<Connection>(
          std::move(socket), context_, serverRank_, options_.connection, site_,
          [this](const protocol::Hello& hello, const std::shared_ptr<Outbox>& outbox,
                 protocol::Welcome& welcome) { return admit(hello, outbox, welcome); },
          [this](const ConnectionPtr& c) { closed(c); });
      connections_.insert(connection);
      {
        const std::lock_guard lock(mutex_);
        count_ = connections_.size();
      }
      connection->start();
      limitHandshakes();
      accept();
    });
  }

  // A client that says hello soon gets in, however many sockets say nothing.
  void limitHandshakes() {
    std::vector<ConnectionPtr> shaking;
    for (const ConnectionPtr& c : connections_)
      if (!c->session()) shaking.push_back(c);
    if (shaking.size() <= kHandshakes) return;
    (*std::min_element(shaking.begin(), shaking.end(), [](const auto& a, const auto& b) {
      return a->begin() < b->begin();
    }))->close();
  }

  // A ticket stands for a token, once.
  std::string tokenOf(const protocol::Hello& hello) {
    if (hello.ticket.empty() || serverRank_.tenants.admitsAll()) return hello.token;
    if (auto token = serverRank_.tickets.redeem(hello.ticket)) return *std::move(token);
    spdlog::warn("rank 0: client {} came with a ticket that is none", protocol::asLogged(hello.client));
    throw Error("the ticket was used or is too old; `galaxy gui` makes another");
  }

  std::shared_ptr<Session> admit(const protocol::Hello& hello, const std::shared_ptr<Outbox>& outbox,
                                 protocol::Welcome& welcome) {
    const auto sessions =
        size_t(std::count_if(connections_.begin(), connections_.end(),
                             [](const ConnectionPtr& c) { return c->session() != nullptr; }));
    if (sessions >= options_.connection.limits.clients)  // before a ticket is used up
      throw Error(std::to_string(options_.connection.limits.clients) +
                  " clients are connected, no more are allowed");
    const std::string token = tokenOf(hello);
    const auto identity = serverRank_.tenants.identify(token, hello.tenant);
    if (!identity) {
      spdlog::warn("rank 0: client {} came with a wrong token", protocol::asLogged(hello.client));
      throw Error(
          "the token is wrong; a client finds it by itself on the server's machine, or takes --token-file");
    }
    const auto ofTenant =
        size_t(std::count_if(connections_.begin(), connections_.end(), [&](const ConnectionPtr& c) {
          return c->session() && c->session()->tenant() == identity->tenant;
        }));
    if (ofTenant >= options_.tenantClients)
      throw Error("tenant " + identity->tenant + ": " + std::to_string(options_.tenantClients) +
                  " clients are connected, no more are allowed");
    Session::Identity who{++sessions_, hello.client, identity->tenant, identity->administrator,
                          identity->viewOnly};
    welcome = {"gxyserver 0.1",
               who.tenant,
               who.number,
               who.administrator,
               who.viewOnly,
               serverRank_.ranks(),
               options_.connection.limits,
               token == hello.token ? std::string() : token};
    spdlog::info("rank 0: session {} of tenant {}: {}", who.number, who.tenant,
                 protocol::asLogged(who.client));
    return std::make_shared<Session>(serverRank_, outbox, std::move(who), options_.connection.limits);
  }

  void closed(const ConnectionPtr& connection) {
    connections_.erase(connection);
    idleSince_ = std::chrono::steady_clock::now();
    const auto session = connection->session();
    {
      const std::lock_guard lock(mutex_);
      if (session) sessionsEnding_++;
      count_ = connections_.size();
      changed_.notify_all();
    }
    if (!session) return;
    serverRank_.transport.postWaiting([this, session] {
      session->end();
      spdlog::info("rank 0: session {} has ended", session->identity().number);
      const std::lock_guard lock(mutex_);
      sessionsEnding_--;
      changed_.notify_all();
    });
  }

  // Any thread may call this. The sockets' thread collects the data.
  json statistics() {
    const auto list = std::make_shared<std::promise<json>>();
    asio::post(*context_, [this, list] {
      json clients = json::array();
      for (const ConnectionPtr& c : connections_) {
        if (!c->session()) continue;
        const Outbox::Counters o = c->outbox().counters();
        const Session::Identity& who = c->session()->identity();
        clients.push_back({{"session", who.number},
                           {"client", who.client},
                           {"tenant", who.tenant},
                           {"queued bytes", o.queuedBytes},
                           {"most queued bytes", o.mostQueuedBytes},
                           {"sent bytes", o.sentBytes},
                           {"received bytes", c->receivedBytes()},
                           {"tiles sent", o.tilesSent},
                           {"tiles dropped", o.tilesDropped},
                           {"events lost", o.eventsLost},
                           {"requests", c->session()->unanswered()}});
      }
      list->set_value(std::move(clients));
    });
    return list->get_future().get();
  }

  void watchIdleness() {
    if (options_.idleExit.count() == 0) return;
    timer_.expires_after(std::chrono::seconds(1));
    timer_.async_wait([this](auto failed) {
      if (failed || ending_) return;
      const auto now = std::chrono::steady_clock::now();
      if (!connections_.empty() || !serverRank_.streaming.list().empty()) idleSince_ = now;
      if (now >= idleSince_ + options_.idleExit) return stop();
      watchIdleness();
    });
  }

  // Asks the ranks at intervals, and tells clients about those that do not answer. If a rank has died, ends
  // the run, because not every launcher does so.
  void watchRanks() {
    serverRank_.presence.ask();
    const auto patience = serverRank_.options.rankPatience;
    questions_.expires_after(
        std::max<std::chrono::milliseconds>(patience / 4, std::chrono::milliseconds(10)));
    questions_.async_wait([this, patience](auto failed) {
      if (failed || ending_) return;
      const auto missing = serverRank_.presence.missing(patience);
      for (const ConnectionPtr& c : connections_)
        if (c->session()) c->session()->tellMissing(missing);
      if (std::any_of(missing.begin(), missing.end(), [](const auto& m) { return m.died; })) stop();
      watchRanks();
    });
  }

  // Returns the reason why the server ends: quit, a signal, or the death of a rank, after which the launcher
  // ends the other ranks by signals. A rank that has died on another machine is recognised by not answering.
  std::string farewell() const {
    constexpr std::chrono::milliseconds kMoment(400);  // About a second is left before the process is ended.
    serverRank_.presence.ask();
    serverRank_.presence.answered(kMoment);
    const std::string missing = textOf(serverRank_.presence.missing(kMoment));
    return missing.empty() ? "the server stops" : "the server stops: " + missing;
  }

  void stop() {
    if (!stopped_.exchange(true)) onStop_();
  }

  ServerRank& serverRank_;
  const ServerOptions options_;
  const std::function<void()> onStop_;
  const std::shared_ptr<const Site> site_;  ///< null: browsers are disconnected
  std::atomic<bool> stopped_ = false;
  const std::shared_ptr<asio::io_context> context_ = std::make_shared<asio::io_context>(1);
  tcp::acceptor acceptor_;
  asio::signal_set signals_;
  asio::steady_timer timer_, questions_;
  uint16_t port_ = 0;
  std::set<ConnectionPtr> connections_;  ///< used on the sockets' thread only, like the next four
  uint64_t sessions_ = 0;
  std::chrono::steady_clock::time_point idleSince_ = std::chrono::steady_clock::now();
  bool retry_ = false;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  size_t count_ = 0, sessionsEnding_ = 0;
  std::atomic<bool> ending_ = false;
  std::thread thread_;
};

Server::Server(ServerRank& serverRank, ServerOptions options, std::function<void()> onStop)
    : impl_(std::make_unique<Impl>(serverRank, std::move(options), std::move(onStop))) {}
Server::~Server() = default;
uint16_t Server::port() const { return impl_->port(); }
size_t Server::clients() const { return impl_->clients(); }

}  // namespace gxy
