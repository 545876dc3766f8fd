// SPDX-License-Identifier: Apache-2.0
#include <arpa/inet.h>
#include <linux/tcp.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <limits>
#include <vector>

#include "core/comm/error.h"
#include "tests/insitu/bench/parts.h"

namespace gxy::bench {

namespace {

constexpr size_t kChunk = 1 << 20;

int checked(int result, const char* what) {
  if (result < 0) throw Error(std::string(what) + ": " + std::strerror(errno));
  return result;
}

sockaddr_in loopback(uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(port);
  return address;
}

struct Listener {
  int socket = -1;
  uint16_t port = 0;
};
Listener listening() {
  Listener l{checked(::socket(AF_INET, SOCK_STREAM, 0), "socket"), 0};
  sockaddr_in address = loopback(0);
  socklen_t size = sizeof address;
  checked(::bind(l.socket, reinterpret_cast<sockaddr*>(&address), size), "bind");
  checked(::listen(l.socket, 64), "listen");
  checked(::getsockname(l.socket, reinterpret_cast<sockaddr*>(&address), &size), "getsockname");
  l.port = ntohs(address.sin_port);
  return l;
}

// What a process says of its work.
struct Work {
  double begin = 0, end = 0, processor = 0;
};

template <class Action>
Work timed(Action action) {
  Work work{now(), 0, processorSeconds()};
  action();
  work.end = now();
  work.processor = processorSeconds() - work.processor;
  return work;
}

Work send(const std::vector<Listener>& to, uint64_t bytes, int rounds) {
  std::vector<int> sockets;
  for (const Listener& l : to) {
    sockets.push_back(checked(::socket(AF_INET, SOCK_STREAM, 0), "socket"));
    const sockaddr_in address = loopback(l.port);
    checked(::connect(sockets.back(), reinterpret_cast<const sockaddr*>(&address), sizeof address),
            "connect");
    const int yes = 1;
    ::setsockopt(sockets.back(), IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
  }
  const std::vector<std::byte> data(bytes, std::byte(1));
  return timed([&] {
    for (int round = 0; round < rounds; round++)
      for (size_t at = 0, chunk = 0; at < data.size(); chunk++) {
        const size_t end = std::min(data.size(), at + kChunk);
        while (at < end)
          at += size_t(checked(
              int(::send(sockets[chunk % sockets.size()], &data[at], end - at, MSG_NOSIGNAL)), "send"));
      }
  });  // The sockets close with the process.
}

Work receive(const Listener& at, int senders) {
  std::vector<pollfd> sockets;
  for (int i = 0; i < senders; i++)
    sockets.push_back({checked(::accept(at.socket, nullptr, nullptr), "accept"), POLLIN, 0});
  std::vector<std::byte> buffer(kChunk);
  return timed([&] {
    for (int open = senders; open > 0;) {
      checked(::poll(sockets.data(), sockets.size(), -1), "poll");
      for (pollfd& s : sockets) {
        if (s.revents == 0) continue;
        if (checked(int(::recv(s.fd, buffer.data(), buffer.size(), 0)), "recv") > 0) continue;
        ::close(s.fd);
        s.fd = -1;  // which poll() leaves out
        s.revents = 0;
        open--;
      }
    }
  });
}

// Runs a function in a process of its own. Returns where it says what its work was.
int started(const std::function<Work()>& work) {
  int ends[2];
  checked(::pipe(ends), "pipe");
  const pid_t child = checked(::fork(), "fork");
  if (child != 0) {
    ::close(ends[1]);
    return ends[0];
  }
  try {
    const Work done = work();
    ::_exit(::write(ends[1], &done, sizeof done) == sizeof done ? 0 : 1);
  } catch (const std::exception&) {
    ::_exit(1);
  }
}

Work workOf(int pipe) {
  Work work;
  const auto n = ::read(pipe, &work, sizeof work);
  ::close(pipe);
  if (n != sizeof work) throw Error("a process that sends or receives has failed");
  return work;
}

}  // namespace

void connectedPair(int ends[2]) {
  const Listener l = listening();
  ends[0] = checked(::socket(AF_INET, SOCK_STREAM, 0), "socket");
  const sockaddr_in address = loopback(l.port);
  checked(::connect(ends[0], reinterpret_cast<const sockaddr*>(&address), sizeof address), "connect");
  ends[1] = checked(::accept(l.socket, nullptr, nullptr), "accept");
  ::close(l.socket);
}

nlohmann::json rawTcp(int senders, int receivers, uint64_t bytes, int rounds) {
  std::vector<Listener> to;
  std::vector<int> receiving, sending;
  for (int i = 0; i < receivers; i++) to.push_back(listening());
  for (const Listener& l : to) receiving.push_back(started([&] { return receive(l, senders); }));
  for (int i = 0; i < senders; i++) sending.push_back(started([&] { return send(to, bytes, rounds); }));
  double begin = std::numeric_limits<double>::infinity(), end = 0, sent = 0, received = 0;
  for (const int pipe : sending) {
    const Work work = workOf(pipe);
    begin = std::min(begin, work.begin);
    sent += work.processor;
  }
  for (const int pipe : receiving) {
    const Work work = workOf(pipe);
    end = std::max(end, work.end);
    received += work.processor;
  }
  while (::wait(nullptr) > 0) {
  }
  const double gigabytes = 1e-9 * double(bytes) * senders * rounds;
  return {{"MB/s", 1e3 * gigabytes / (end - begin)},
          {"sender CPU s/GB", sent / gigabytes},
          {"receiver CPU s/GB", received / gigabytes}};
}

}  // namespace gxy::bench
