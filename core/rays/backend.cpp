// SPDX-License-Identifier: Apache-2.0
#include "core/rays/backend.h"

#include <spdlog/spdlog.h>

#include <exception>
#include <numeric>
#include <utility>

#include "core/comm/error.h"
#include "core/rays/substitutes.h"

namespace gxy {

std::vector<LeavingRays> LeavingRays::split(int most) const {
  std::vector<LeavingRays> parts;
  for (RayList& part : rays.split(most)) parts.push_back({partition, primary, std::move(part)});
  return parts;
}

void LeavingRays::write(Bytes& out) const {
  std::vector<int> all(size_t(rays.size()));
  std::iota(all.begin(), all.end(), 0);
  rays.write(all, primary, out);
}

TraceCounters& TraceCounters::operator+=(const TraceCounters& o) {
  raysSpawned += o.raysSpawned;
  raysTraced += o.raysTraced;
  raysShaded += o.raysShaded;
  raysRetired += o.raysRetired;
  secondariesSpawned += o.secondariesSpawned;
  secondariesSkipped += o.secondariesSkipped;
  raysEndedEarly += o.raysEndedEarly;
  samples += o.samples;
  macrocells += o.macrocells;
  macrocellsSkipped += o.macrocellsSkipped;
  segmentsSkipped += o.segmentsSkipped;
  cells += o.cells;
  isoMacrocellsSkipped += o.isoMacrocellsSkipped;
  meshCells += o.meshCells;
  meshWalks += o.meshWalks;
  nsSpawn += o.nsSpawn;
  nsGeometry += o.nsGeometry;
  nsSurfaces += o.nsSurfaces;
  nsIntegrate += o.nsIntegrate;
  nsShade += o.nsShade;
  nsRoute += o.nsRoute;
  submissions += o.submissions;
  nsDevice += o.nsDevice;
  nsDeviceIdle += o.nsDeviceIdle;
  nsDeviceAsked += o.nsDeviceAsked;
  nodes += o.nodes;
  primitives += o.primitives;
  raysRead += o.raysRead;
  for (size_t k = 0; k < kKernels; k++) kernelRuns[k] += o.kernelRuns[k];
  return *this;
}

void DeviceScene::spawnRays(const DeviceFrame&, RayList, Done) const {
  throw Error("this device cannot begin rays of a sampling");
}

std::unique_ptr<Backend> BackendRegistry::make(const std::string& name, Ledger* ledger) const {
  std::string known = "auto";
  std::exception_ptr first;
  std::vector<std::string> failures;
  for (size_t i = 0; i < entries_.size(); i++) {
    const Entry& e = entries_[i];
    known += ", " + e.name;
    if (name == e.name) return e.maker(ledger);
    if (name != "auto" || (e.fits && !e.fits())) continue;
    try {
      std::unique_ptr<Backend> made = e.maker(ledger);
      for (const std::string& failure : failures) spdlog::warn("{}; {} is taken", failure, e.name);
      return withSubstitutes(std::move(made), {entries_.begin() + std::ptrdiff_t(i) + 1, entries_.end()},
                             ledger);
    } catch (const std::exception& error) {
      if (!first) first = std::current_exception();
      failures.push_back("backend " + e.name + " cannot be used: " + error.what());
    }
  }
  if (first) std::rethrow_exception(first);
  throw Error("backend \"" + name + "\" is not in this program; expected one of: " + known);
}

}  // namespace gxy
