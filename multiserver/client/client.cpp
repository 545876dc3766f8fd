// SPDX-License-Identifier: Apache-2.0
#include "multiserver/client/client.h"

#include <sys/socket.h>

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/use_future.hpp>
#include <boost/asio/write.hpp>

#include <array>
#include <atomic>
#include <cstring>
#include <future>
#include <map>
#include <mutex>
#include <thread>

#include "core/comm/error.h"
#include "multiserver/protocol/json.h"
#include "multiserver/protocol/run_files.h"
#include "multiserver/protocol/wire_message.h"

namespace gxy {

namespace asio = boost::asio;
using asio::ip::tcp;
using protocol::MessageChannel;
using protocol::WireMessage;

namespace {

// A reply that cannot be understood becomes an error reply, so that the waiting caller gets it.
Reply replyOf(std::string_view text) {
  try {
    if (const auto value = protocol::afterWord(text, "ok"))
      return {true, {}, value->empty() ? nlohmann::json() : protocol::parseAnswer(*value, "reply")};
  } catch (const Error& e) {
    return {false, e.what(), {}};
  }
  if (text.starts_with("error: ")) return {false, std::string(text.substr(7)), {}};
  return {false, "reply: expected `ok` or `error: ...`", {}};
}

}  // namespace

class Client::Impl {
 public:
  explicit Impl(Options options) : options_(std::move(options)), socket_(context_) {
    protocol::Hello hello;
    hello.client = options_.name;
    hello.tenant = options_.tenant;
    std::string noToken;  // the reason why there is no token to send
    const std::string where = options_.host + " port " + std::to_string(options_.port);
    try {
      const auto end = std::chrono::steady_clock::now() + options_.patience;
      tcp::resolver resolver(context_);
      const auto found = waitFor(
          resolver.async_resolve(options_.host, std::to_string(options_.port), asio::use_future), end);
      hello.token = tokenFor(found, noToken);
      waitFor(asio::async_connect(socket_, found, asio::use_future), end);
      socket_.set_option(tcp::no_delay(true));
      asio::write(socket_, asio::buffer(protocol::preamble()));
      std::array<std::byte, protocol::kPreambleBytes> theirs;
      waitFor(asio::async_read(socket_, asio::buffer(theirs), asio::use_future), end);
      protocol::checkPreamble(theirs);
      write(protocol::textMessage(MessageChannel::Control, 0, protocol::helloText(hello)));
      const WireMessage answer = next([&](const auto& buffer) {
        return waitFor(socket_.async_read_some(buffer, asio::use_future), end);
      });
      if (const auto reason = protocol::afterWord(answer.text(), "bye"))
        throw Error("server at " + where + ": " + std::string(*reason) +
                    (noToken.empty() ? "" : " (none was sent: " + noToken + ")"));
      welcome_ = protocol::parseWelcome(answer.text());
    } catch (const boost::system::system_error& e) {
      throw Error("cannot connect to " + where + ": " + e.code().message() + "; is a server running there?");
    }
    connected_ = true;
    thread_ = std::thread([this] { run(); });
  }

  ~Impl() {
    ending_ = true;
    ::shutdown(socket_.native_handle(), SHUT_RDWR);
    thread_.join();
  }

  uint32_t send(const std::string& statement, OnReply onReply) {
    uint32_t id;
    {
      const std::lock_guard lock(mutex_);
      if (!connected_) throw Error("the connection has ended: " + reason_);
      do id = nextId_++;
      while (id == 0 || waiting_.count(id));
      waiting_[id] = std::move(onReply);
    }
    try {
      write(protocol::textMessage(MessageChannel::Request, id, statement));
    } catch (const boost::system::system_error&) {
      ::shutdown(socket_.native_handle(), SHUT_RDWR);  // The reading thread then ends all requests.
    }
    return id;
  }

  const Options options_;
  protocol::Welcome welcome_;
  std::atomic<bool> connected_ = false;

 private:
  // The token in the user's run directory is only for servers on this machine, so it is not sent to
  // others unasked. (An ssh tunnel begins on this machine, too.) Without a token, the server may still be
  // one that needs none.
  std::string tokenFor(const tcp::resolver::results_type& found, std::string& whyNone) const {
    if (options_.tokenFile == "-") return {};
    if (!options_.tokenFile.empty()) return protocol::readToken(options_.tokenFile);
    for (const auto& entry : found)
      if (!entry.endpoint().address().is_loopback())
        throw Error("host " + options_.host + " is another machine (" +
                    entry.endpoint().address().to_string() +
                    "), and everything goes there as clear text, the token, too: expected an ssh tunnel, or "
                    "--token-file with a copy of the server's token");
    try {
      return protocol::readServerToken(options_.port);
    } catch (const Error& e) {
      whyNone = e.what();
      return {};
    }
  }

  // Waits for an operation that has been started. Throws if it is not complete at time `end`; the socket must
  // not be used afterwards.
  template <class T>
  T waitFor(std::future<T> result, std::chrono::steady_clock::time_point end) {
    context_.restart();
    context_.run_until(end);
    if (result.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
      throw boost::system::system_error(asio::error::timed_out);
    return result.get();
  }

  void write(const WireMessage& message) {
    const auto header = protocol::headerOf(message);
    const std::array<asio::const_buffer, 2> parts{asio::buffer(header), asio::buffer(message.payload)};
    const std::lock_guard lock(writing_);
    asio::write(socket_, parts);
  }

  WireMessage next(const auto& readSome) {
    for (;;) {
      if (!unread_.empty())
        if (auto message = reader_.take(unread_)) return *std::move(message);
      const size_t size = readSome(asio::buffer(buffer_));
      unread_ = std::span<const std::byte>(buffer_).first(size);
    }
  }

  void run() {
    std::string reason = "closed";
    try {
      for (;;) {
        const WireMessage message = next([this](const auto& buffer) { return socket_.read_some(buffer); });
        if (message.channel != MessageChannel::Control) {
          take(message);
        } else if (const auto number = protocol::afterWord(message.text(), "ping")) {
          write(protocol::textMessage(MessageChannel::Control, 0, "pong " + std::string(*number)));
        } else if (const auto why = protocol::afterWord(message.text(), "bye")) {
          reason = *why;
          break;
        }
      }
    } catch (const boost::system::system_error& e) {
      reason = e.code() == asio::error::eof ? "the server has ended without a word" : e.code().message();
    } catch (const std::exception& e) {
      reason = e.what();
    }
    std::map<uint32_t, OnReply> waiting;
    {
      const std::lock_guard lock(mutex_);
      connected_ = false;
      reason_ = reason;
      waiting.swap(waiting_);
    }
    const Reply ended{false, "the connection has ended: " + reason, {}};
    for (const auto& [id, onReply] : waiting) onReply(ended);
    if (options_.onEnd && !ending_) options_.onEnd(reason);
  }

  void take(const WireMessage& message) {
    if (message.channel == MessageChannel::Reply) {
      OnReply onReply;
      {
        const std::lock_guard lock(mutex_);
        const auto found = waiting_.find(message.id);
        if (found == waiting_.end())
          throw Error("reply to request " + std::to_string(message.id) + ", which is not out");
        onReply = std::move(found->second);
        waiting_.erase(found);
      }
      onReply(replyOf(message.text()));
    } else if (message.channel == MessageChannel::Event) {
      if (options_.onEvent) options_.onEvent(protocol::parseAnswer(message.text(), "event"));
    } else if (message.channel == MessageChannel::Pixels) {
      const protocol::PixelHeader header = protocol::pixelHeader(message.payload);
      if (options_.onPixels) options_.onPixels(header, protocol::pixelData(message.payload));
    } else {
      takeFile(message);
    }
  }

  void takeFile(const WireMessage& message) {
    uint32_t size = 0;
    const std::span<const std::byte> payload(message.payload);
    if (payload.size() >= sizeof size) std::memcpy(&size, payload.data(), sizeof size);
    if (payload.size() < sizeof size || size > payload.size() - sizeof size)
      throw Error("file record of " + std::to_string(payload.size()) + " bytes: its header does not fit");
    const auto header = message.text().substr(sizeof size, size);
    if (options_.onFile)
      options_.onFile(message.id, protocol::parseAnswer(header, "file record"),
                      payload.subspan(sizeof size + size));
  }

  asio::io_context context_;
  tcp::socket socket_;
  protocol::MessageReader reader_{protocol::MessageReader::fromServer()};
  std::array<std::byte, 64 << 10> buffer_;
  std::span<const std::byte> unread_;
  std::mutex writing_;
  std::mutex mutex_;
  std::map<uint32_t, OnReply> waiting_;
  uint32_t nextId_ = 1;
  std::string reason_;
  std::atomic<bool> ending_ = false;
  std::thread thread_;
};

Client::Client(Options options) : impl_(std::make_unique<Impl>(std::move(options))) {}
Client::~Client() = default;

const protocol::Welcome& Client::welcome() const { return impl_->welcome_; }
bool Client::connected() const { return impl_->connected_; }

uint32_t Client::send(const std::string& statement, OnReply onReply) {
  return impl_->send(statement, std::move(onReply));
}

Reply Client::request(const std::string& statement) {
  const auto promise = std::make_shared<std::promise<Reply>>();
  send(statement, [promise](const Reply& reply) { promise->set_value(reply); });
  return promise->get_future().get();
}

nlohmann::json Client::expect(const std::string& statement) {
  Reply reply = request(statement);
  if (!reply.ok) throw Error(reply.error);
  return std::move(reply.value);
}

}  // namespace gxy
