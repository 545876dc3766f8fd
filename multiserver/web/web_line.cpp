// SPDX-License-Identifier: Apache-2.0
#include "multiserver/web/web_line.h"

#include <boost/asio/post.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/basic_stream.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/websocket/stream.hpp>

#include <array>
#include <optional>

#include "core/comm/error.h"
#include "multiserver/web/answer.h"
#include "multiserver/web/whole_message.h"

namespace gxy {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;

namespace {

constexpr uint32_t kHeaderLimit = 8 << 10;  // bytes of a request

/// Limits nothing, and counts what has been written.
class CountingPolicy {
 public:
  int64_t written() const { return written_; }

 private:
  friend class beast::rate_policy_access;
  static constexpr size_t kAll = std::numeric_limits<size_t>::max();
  size_t available_read_bytes() const noexcept { return kAll; }
  size_t available_write_bytes() const noexcept { return kAll; }
  void transfer_read_bytes(size_t) const noexcept {}
  void transfer_write_bytes(size_t bytes) noexcept { written_ += int64_t(bytes); }
  void on_timer() const noexcept {}

  int64_t written_ = 0;
};

class BrowserLine final : public WebLine, public std::enable_shared_from_this<BrowserLine> {
 public:
  BrowserLine(Socket socket, std::shared_ptr<const Site> site, std::span<const std::byte> first)
      : site_(std::move(site)), stream_(CountingPolicy(), std::move(socket)) {
    received_.commit(
        asio::buffer_copy(received_.prepare(first.size()), asio::buffer(first.data(), first.size())));
  }

  void serve(Changed changed) override {
    changed_ = std::move(changed);
    readRequest();
  }

  void read(std::span<std::byte> into, Done done) override {
    stream_.async_read_some(
        asio::buffer(into.data(), into.size()),
        [self = shared_from_this(), into, done = std::move(done)](auto failed, size_t size) {
          if (failed)
            self->upgraded_ = false;  // nothing more may be sent
          else
            failed = self->checked(into.first(size));
          done(failed, failed ? 0 : size);
        });
  }

  size_t write(std::span<const std::byte> header, std::span<const std::byte> payload, Done done) override {
    const std::array<asio::const_buffer, 2> parts{asio::buffer(header.data(), header.size()),
                                                  asio::buffer(payload.data(), payload.size())};
    writing_ = true;
    stream_.async_write(parts, [self = shared_from_this(), done = std::move(done)](auto failed, size_t size) {
      self->writing_ = false;
      done(failed, size);
    });
    const size_t bytes = header.size() + payload.size();
    return bytes + (bytes < 126 ? 2 : bytes < 65536 ? 4 : 10);  // with the header of WebSocket
  }

  int64_t written() const override { return stream_.next_layer().rate_policy().written(); }
  std::string violation() const override { return violation_; }
  Socket& socket() override { return stream_.next_layer().socket(); }

  void close() override {
    changed_ = nullptr;
    boost::system::error_code ignored;
    if (upgraded_ && !writing_) {  // so that the page is told of an ordinary end
      constexpr std::array<unsigned char, 4> kClose{0x88, 2, 0x03, 0xe8};
      socket().non_blocking(true, ignored);
      socket().send(asio::buffer(kClose), 0, ignored);
    }
    socket().shutdown(Socket::shutdown_both, ignored);
    socket().close(ignored);
  }

 private:
  void tell(State state) {
    if (const Changed changed = changed_) changed(state);
  }

  void readRequest() {
    parser_.emplace();
    parser_->header_limit(kHeaderLimit);
    http::async_read_header(stream_.next_layer(), received_, *parser_,
                            [self = shared_from_this()](auto failed, size_t) { self->takeRequest(failed); });
  }

  void takeRequest(boost::system::error_code failed) {
    if (failed == http::error::header_limit || failed == http::error::buffer_overflow)
      return send(refusal(431, "Expected at most 8 KiB of header."));
    if (failed == http::error::body_limit) return send(refusal(413, "Expected no body."));
    if (failed && failed.category() == http::make_error_code(http::error::bad_method).category() &&
        failed != http::error::end_of_stream && failed != http::error::partial_message)
      return send(refusal(400, "Expected a request of HTTP/1.1."));
    if (failed) return tell(State::Ended);
    if (parser_->chunked() || parser_->content_length().value_or(0) > 0)
      return send(refusal(413, "Expected no body."));
    Answer answer = answerTo(*site_, parser_->get());
    if (answer.upgrade && received_.size() > 0)
      answer = refusal(400, "Expected nothing after the request to upgrade before its answer.");
    if (answer.upgrade) return upgrade();
    send(std::move(answer));
  }

  void send(Answer answer) {
    tell(State::Answers);
    answer_ = std::move(answer);
    const std::string_view body = answer_.body();
    const std::array<asio::const_buffer, 2> parts{asio::buffer(answer_.head),
                                                  asio::buffer(body.data(), body.size())};
    asio::async_write(stream_.next_layer(), parts, [self = shared_from_this()](auto failed, size_t) {
      if (failed) return self->tell(State::Ended);
      self->tell(State::Waits);
      if (!self->answer_.close) return self->readRequest();
      boost::system::error_code ignored;
      self->socket().shutdown(Socket::shutdown_send, ignored);
      self->drain();
    });
  }

  // Closing while bytes of the client are unread would reset the connection, and with it the answer.
  void drain() {
    socket().async_read_some(asio::buffer(scratch_), [self = shared_from_this()](auto failed, size_t) {
      if (failed) return self->tell(State::Ended);
      self->drain();
    });
  }

  void upgrade() {
    stream_.binary(true);
    stream_.auto_fragment(false);
    stream_.read_message_max(0);  // none: the limits of the protocol hold
    stream_.control_callback([this](websocket::frame_type kind, beast::string_view) {
      if (kind != websocket::frame_type::close) return;
      // Beast would wait until the client has closed the connection, too.
      asio::post(stream_.get_executor(), [self = shared_from_this()] { self->tell(State::Ended); });
    });
    stream_.set_option(websocket::stream_base::decorator([](websocket::response_type& response) {
      response.set(http::field::server, "Galaxy");
      response.set(http::field::sec_websocket_protocol, kSubprotocol);
    }));
    stream_.async_accept(parser_->get(), [self = shared_from_this()](auto failed) {
      if (failed) return self->tell(State::Ended);
      self->parser_.reset();
      self->received_.shrink_to_fit();
      self->upgraded_ = true;
      self->tell(State::Upgraded);
    });
  }

  // Returns an error if what has been read breaks the rules.
  boost::system::error_code checked(std::span<const std::byte> piece) {
    try {
      if (stream_.got_text()) throw Error("WebSocket message of text, expected binary ones");
      whole_.take(piece, stream_.is_message_done());
      return {};
    } catch (const Error& e) {
      violation_ = e.what();
      return asio::error::invalid_argument;
    }
  }

  const std::shared_ptr<const Site> site_;
  websocket::stream<beast::basic_stream<asio::ip::tcp, asio::any_io_executor, CountingPolicy>, false> stream_;
  Changed changed_;
  beast::flat_buffer received_{2 * kHeaderLimit};
  std::optional<http::request_parser<http::empty_body>> parser_;
  Answer answer_;  ///< being sent
  std::array<std::byte, 1024> scratch_;
  WholeMessage whole_;
  std::string violation_;
  bool upgraded_ = false, writing_ = false;
};

}  // namespace

std::shared_ptr<WebLine> makeWebLine(Line::Socket socket, std::shared_ptr<const Site> site,
                                     std::span<const std::byte> first) {
  return std::make_shared<BrowserLine>(std::move(socket), std::move(site), first);
}

}  // namespace gxy
