// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyrender/statistics.h"

#include <sys/resource.h>

#include <chrono>
#include <ctime>

#include "core/image/replace_file.h"

namespace gxy {

double wallSeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double cpuSeconds() {
  rusage u{};
  getrusage(RUSAGE_SELF, &u);
  return double(u.ru_utime.tv_sec + u.ru_stime.tv_sec) +
         1e-6 * double(u.ru_utime.tv_usec + u.ru_stime.tv_usec);
}

double threadCpuSeconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

namespace {

nlohmann::json skipped(const Renderer::Counters& c, const LeftBefore& before) {
  const TraceCounters& k = c.trace;
  auto kernels = nlohmann::json::array();
  for (size_t i = 0; i < kKernels; i++)
    if (k.kernelRuns[i] == 0) kernels.push_back(kKernelNames[i]);
  return {{"arrays", before.data.arrays},
          {"components", before.data.components},
          {"pieces", before.data.pieces},
          {"sample bytes", before.data.bytes},
          {"partitions", c.partitionsSkipped},
          {"tiles", c.tilesSkipped},
          {"pixels", c.pixelsSkipped},
          {"macrocells", k.macrocellsSkipped},
          {"segments", k.segmentsSkipped},
          {"isosurface cells", before.isoCells},
          {"isosurface macrocells", k.isoMacrocellsSkipped},
          {"secondaries", k.secondariesSkipped},
          {"rays ended early", k.raysEndedEarly},
          {"messages", c.messagesSkipped},
          {"kernels", kernels}};
}

}  // namespace

nlohmann::json statisticsOf(const Renderer::Counters& c, const Transport::Counters& t, const Phases& p,
                            const LeftBefore& before, const Ledger& ledger, int64_t residentBefore) {
  const TraceCounters& k = c.trace;
  const ProcessBytes process = processBytes();
  const auto byPurpose = [](const std::vector<Ledger::Line>& lines) {
    auto bytes = nlohmann::json::object();
    for (const Ledger::Line& line : lines) bytes[line.purpose] = line.bytes;
    return bytes;
  };
  return {{"rays",
           {{"spawned", k.raysSpawned},
            {"secondaries", k.secondariesSpawned},
            {"traced", k.raysTraced},
            {"shaded", k.raysShaded},
            {"forwarded", c.raysForwarded},
            {"retired", k.raysRetired},
            {"most in flight", c.mostRaysInFlight}}},
          {"volumes",
           {{"samples", k.samples},
            {"macrocells", k.macrocells},
            {"isosurface cells", k.cells},
            {"mesh cells", k.meshCells},
            {"mesh walks", k.meshWalks}}},
          {"skipped", skipped(c, before)},
          {"messages",
           {{"ray messages", c.rayMessages},
            {"ray bytes", c.rayBytes},
            {"contribution messages", c.contributionMessages},
            {"contribution bytes", c.contributionBytes},
            {"all bytes", t.bytesSent},
            {"packets", t.packetsSent},
            {"most bytes waiting", t.mostBytesWaiting},
            {"all messages", t.messagesSent},
            {"completion waves", c.completionWaves}}},
          {"thread seconds",
           {{"spawn", 1e-9 * double(k.nsSpawn)},
            {"geometry", 1e-9 * double(k.nsGeometry)},
            {"slices and isosurfaces", 1e-9 * double(k.nsSurfaces)},
            {"integrate", 1e-9 * double(k.nsIntegrate)},
            {"shade and route", 1e-9 * double(k.nsShade)}}},
          {"device",
           {{"submissions", k.submissions},
            {"rays read", k.raysRead},
            {"busy seconds", 1e-9 * double(k.nsDevice)},
            {"idle seconds between", 1e-9 * double(k.nsDeviceIdle)},
            {"asked seconds", 1e-9 * double(k.nsDeviceAsked)}}},
          {"seconds",
           {{"load", p.load},
            {"compile", p.compile},
            {"compile each", p.compileEach},
            {"render", p.render},
            {"total", p.total},
            {"cpu render", p.cpuRender},
            {"cpu pictures", p.cpuPictures}}},
          {"memory",
           {{"ledger", byPurpose(ledger.snapshot())},
            {"ledger peaks", byPurpose(ledger.peaks())},
            {"ledger total", ledger.total()},
            {"ledger peak", ledger.peak()},
            {"process before data", residentBefore},
            {"process", process.resident},
            {"process peak", process.peakResident}}}};
}

nlohmann::json trafficOf(const std::map<Channel, MpiTransport::Traffic>& byChannel, int partners) {
  auto kinds = nlohmann::json::object();
  for (const auto& [channel, t] : byChannel)
    kinds[std::string(nameOf(channel))] = {{"messages sent", t.messagesSent},
                                           {"bytes sent", t.bytesSent},
                                           {"messages received", t.messagesReceived},
                                           {"bytes received", t.bytesReceived}};
  return {{"kinds", kinds}, {"partners", partners}};
}

void writeStatistics(const std::string& path, const nlohmann::json& run,
                     const std::vector<nlohmann::json>& ranks) {
  const std::string text = nlohmann::json{{"run", run}, {"ranks", ranks}}.dump(2) + '\n';
  replaceFile(path, std::as_bytes(std::span(text)));
}

}  // namespace gxy
