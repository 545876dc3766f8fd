// SPDX-License-Identifier: Apache-2.0
#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <memory>
#include <thread>
#include <vector>

#include "core/comm/error.h"
#include "insitu/api/galaxy_insitu.h"
#include "tests/insitu/bench/parts.h"

namespace gxy::bench {

namespace {

// Bytes that all TCP sockets of this process have sent and received.
uint64_t bytesOnTheWire() {
  uint64_t bytes = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    tcp_info info{};
    socklen_t size = sizeof info;
    const int descriptor = std::stoi(entry.path().filename());
    if (::getsockopt(descriptor, IPPROTO_TCP, TCP_INFO, &info, &size) == 0)
      bytes += info.tcpi_bytes_sent + info.tcpi_bytes_received;
  }
  return bytes;
}

// Waits of the calling thread, and of all threads.
struct Waits {
  long mine = 0, all = 0;
};
Waits waits() {
  rusage thread{}, process{};
  getrusage(RUSAGE_THREAD, &thread);
  getrusage(RUSAGE_SELF, &process);
  return {thread.ru_nvcsw, process.ru_nvcsw};
}

// Linux sends a signal for each system call of a thread while `guard` says so. The handler lets the others pass.
volatile char guard = SYSCALL_DISPATCH_FILTER_ALLOW;
volatile sig_atomic_t systemCalls = 0;
void onSystemCall(int, siginfo_t*, void*) {
  guard = SYSCALL_DISPATCH_FILTER_ALLOW;
  systemCalls = systemCalls + 1;
}

// How many of `calls` calls make a system call; null where the system cannot tell.
template <class Call>
nlohmann::json withSystemCalls(int calls, Call call) {
  struct sigaction action {};
  action.sa_sigaction = onSystemCall;
  action.sa_flags = SA_SIGINFO;
  ::sigaction(SIGSYS, &action, nullptr);
  if (::prctl(PR_SET_SYSCALL_USER_DISPATCH, PR_SYS_DISPATCH_ON, 0, 0, &guard) != 0) return nullptr;
  guard = SYSCALL_DISPATCH_FILTER_BLOCK;
  ::getppid();  // to see that it is counted
  guard = SYSCALL_DISPATCH_FILTER_ALLOW;
  if (systemCalls != 1) return nullptr;
  systemCalls = 0;
  for (int i = 0; i < calls; i++) {
    guard = SYSCALL_DISPATCH_FILTER_BLOCK;
    call();
    guard = SYSCALL_DISPATCH_FILTER_ALLOW;
  }
  ::prctl(PR_SET_SYSCALL_USER_DISPATCH, PR_SYS_DISPATCH_OFF, 0, 0, 0);
  return int(systemCalls);
}

}  // namespace

nlohmann::json publishes(const To& to, int calls) {
  const std::unique_ptr<gxy_sim, void (*)(gxy_sim*)> sim(
      gxy_open("silent", 0, 1, to.options().dump().c_str()), [](gxy_sim* s) { gxy_close(s, 0); });
  const int64_t n[3] = {16, 16, 16}, first[3] = {0, 0, 0};
  const double origin[3] = {0, 0, 0}, spacing[3] = {1, 1, 1};
  const std::vector<float> values(16 * 16 * 16);
  gxy_grid(sim.get(), "grid", 0, GXY_OF_POINTS, n, first, n, origin, spacing);
  gxy_field(sim.get(), "grid", 0, "f", GXY_OF_POINTS, {values.data(), GXY_FLOAT32, 1, {4, 64, 1024}, 0, 0});
  int64_t step = 0;
  const auto call = [&] { return gxy_publish(sim.get(), ++step, 0); };
  const int expected = to.address.empty() ? GXY_OFF : GXY_NOT_TAKEN;
  if (!to.address.empty()) {
    gxy_stat statistics{};
    for (const double begin = now(); statistics.published == 0; gxy_statistics(sim.get(), &statistics)) {
      if (call() < 0 || now() > begin + 30)
        throw Error("no step is taken: " + std::string(gxy_message(sim.get())));
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(500));  // until nothing is under way any more
  }
  std::vector<double> seconds(size_t(calls) + 1), clock(seconds.size());
  int others = 0;
  for (int i = 0; i < 1000; i++) others += call() != expected;
  const uint64_t sent = bytesOnTheWire();
  const Waits before = waits();
  for (double& s : seconds) {
    const double begin = now();
    others += call() != expected;
    s = now() - begin;
  }
  const Waits after = waits();
  const nlohmann::json making = withSystemCalls(calls, call);
  const uint64_t more = bytesOnTheWire() - sent;
  for (double& c : clock) {
    const double begin = now();
    c = now() - begin;
  }
  std::sort(seconds.begin(), seconds.end());
  std::sort(clock.begin(), clock.end());
  const auto quantile = [&](double q) { return 1e6 * seconds[size_t(q * calls)]; };
  return {{"calls", calls},
          {"median us", quantile(0.5)},
          {"99.9 % us", quantile(0.999)},
          {"longest us", quantile(1)},
          {"clock us", 1e6 * clock[size_t(calls) / 2]},
          {"other results", others},
          {"bytes on the wire", more},
          {"waits", after.mine - before.mine},
          {"waits of all threads", after.all - before.all},
          {"calls with system calls", making}};
}

}  // namespace gxy::bench
