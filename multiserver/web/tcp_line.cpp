// SPDX-License-Identifier: Apache-2.0
#include "multiserver/web/tcp_line.h"

#include <boost/asio/write.hpp>

#include <array>

namespace gxy {

namespace {

class TcpLine final : public Line, public std::enable_shared_from_this<TcpLine> {
 public:
  explicit TcpLine(Socket socket) : socket_(std::move(socket)) {}

  void read(std::span<std::byte> into, Done done) override {
    socket_.async_read_some(boost::asio::buffer(into.data(), into.size()),
                            [self = shared_from_this(), done = std::move(done)](auto failed, size_t size) {
                              done(failed, size);
                            });
  }

  size_t write(std::span<const std::byte> header, std::span<const std::byte> payload, Done done) override {
    const std::array<boost::asio::const_buffer, 2> parts{boost::asio::buffer(header.data(), header.size()),
                                                         boost::asio::buffer(payload.data(), payload.size())};
    const auto counted = [this, before = written_](auto failed, size_t size) {
      written_ = before + int64_t(size);
      return boost::asio::transfer_all()(failed, size);
    };
    boost::asio::async_write(socket_, parts, counted,
                             [self = shared_from_this(), done = std::move(done)](auto failed, size_t size) {
                               done(failed, size);
                             });
    return header.size() + payload.size();
  }

  int64_t written() const override { return written_; }

  void close() override {
    boost::system::error_code ignored;
    socket_.shutdown(Socket::shutdown_both, ignored);
    socket_.close(ignored);
  }

  Socket& socket() override { return socket_; }

 private:
  Socket socket_;
  int64_t written_ = 0;
};

}  // namespace

std::shared_ptr<Line> makeTcpLine(Line::Socket socket) {
  return std::make_shared<TcpLine>(std::move(socket));
}

}  // namespace gxy
