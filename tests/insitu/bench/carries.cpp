// SPDX-License-Identifier: Apache-2.0
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <vector>

#include "core/comm/error.h"
#include "tests/insitu/bench/parts.h"

namespace gxy::bench {

namespace {

int64_t checked(int64_t result, const char* what) {
  if (result < 0) throw Error(std::string(what) + ": " + std::strerror(errno));
  return result;
}

struct Slot {
  int file = -1;  // -1: only this process and its children's copies have it
  std::byte* data = nullptr;
};
Slot slotOf(uint64_t bytes, bool shared) {
  Slot slot;
  if (shared) {
    slot.file = int(checked(::memfd_create("slot", 0), "memfd_create"));
    checked(::ftruncate(slot.file, off_t(bytes)), "ftruncate");
  }
  void* at = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, shared ? MAP_SHARED : MAP_PRIVATE | MAP_ANONYMOUS,
                    slot.file, 0);
  if (at == MAP_FAILED) throw Error(std::string("mmap: ") + std::strerror(errno));
  slot.data = static_cast<std::byte*>(at);
  std::memset(slot.data, 1, bytes);  // so that it has its pages
  return slot;
}

// A step is read into the same buffer, piece by piece.
void take(int socket, const Slot& slot, uint64_t bytes, std::vector<std::byte>& buffer) {
  std::byte go{};
  if (slot.file >= 0) checked(::read(socket, &go, 1), "read");
  for (uint64_t at = 0; at < bytes;)
    at += uint64_t(
        slot.file >= 0
            ? checked(
                  ::pread(slot.file, buffer.data(), std::min<uint64_t>(buffer.size(), bytes - at), off_t(at)),
                  "pread")
            : checked(::read(socket, buffer.data(), std::min<uint64_t>(buffer.size(), bytes - at)), "read"));
}

void give(int socket, const Slot& slot, uint64_t bytes) {
  constexpr uint64_t kChunk = 1 << 20;
  const std::byte go{};
  if (slot.file >= 0) checked(::write(socket, &go, 1), "write");
  for (uint64_t at = 0; slot.file < 0 && at < bytes;)
    at += uint64_t(checked(::write(socket, slot.data + at, std::min(kChunk, bytes - at)), "write"));
}

// The processor seconds of both ends for each GB.
double carried(int sender, int receiver, bool shared, uint64_t bytes, int rounds) {
  const Slot slot = slotOf(bytes, shared);
  int back[2];
  checked(::pipe(back), "pipe");
  const auto child = pid_t(checked(::fork(), "fork"));
  if (child == 0) try {
      std::vector<std::byte> buffer(256 << 10);
      const double before = processorSeconds();
      for (int round = 0; round < rounds; round++) {
        take(receiver, slot, bytes, buffer);
        checked(::write(back[1], buffer.data(), 1), "write");
      }
      const double seconds = processorSeconds() - before;
      checked(::write(back[1], &seconds, sizeof seconds), "write");
      ::_exit(0);
    } catch (const std::exception&) {
      ::_exit(1);
    }
  ::close(back[1]);
  const std::vector<std::byte> step(bytes, std::byte(2));
  const double before = processorSeconds();
  for (int round = 0; round < rounds; round++) {
    std::memcpy(slot.data, step.data(), bytes);
    give(sender, slot, bytes);
    std::byte done{};
    if (::read(back[0], &done, 1) != 1) throw Error("the process that receives has failed");
  }
  const double sent = processorSeconds() - before;
  double received = 0;
  if (::read(back[0], &received, sizeof received) != sizeof received)
    throw Error("the process that receives has failed");
  ::waitpid(child, nullptr, 0);
  for (const int file : {back[0], slot.file, sender, receiver})
    if (file >= 0) ::close(file);
  ::munmap(slot.data, bytes);
  return (sent + received) / (1e-9 * double(bytes) * rounds);
}

}  // namespace

nlohmann::json carries(uint64_t bytes, int rounds) {
  const auto onSockets = [&](bool tcp, bool shared) {
    int ends[2];
    if (tcp)
      connectedPair(ends);
    else
      checked(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends), "socketpair");
    return carried(ends[0], ends[1], shared, bytes, rounds);
  };
  return {{"TCP CPU s/GB", onSockets(true, false)},
          {"Unix socket CPU s/GB", onSockets(false, false)},
          {"shared slot CPU s/GB", onSockets(false, true)}};
}

}  // namespace gxy::bench
