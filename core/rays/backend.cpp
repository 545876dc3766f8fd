// SPDX-License-Identifier: Apache-2.0
#include "gxy/rays/backend.h"

#include "gxy/comm/error.h"

namespace gxy {

TraceCounters& TraceCounters::operator+=(const TraceCounters& o) {
  raysSpawned += o.raysSpawned;
  raysTraced += o.raysTraced;
  raysShaded += o.raysShaded;
  secondariesSpawned += o.secondariesSpawned;
  samples += o.samples;
  macrocells += o.macrocells;
  macrocellsSkipped += o.macrocellsSkipped;
  cells += o.cells;
  isoMacrocellsSkipped += o.isoMacrocellsSkipped;
  nsSpawn += o.nsSpawn;
  nsGeometry += o.nsGeometry;
  nsSurfaces += o.nsSurfaces;
  nsIntegrate += o.nsIntegrate;
  nsShade += o.nsShade;
  nsRoute += o.nsRoute;
  submissions += o.submissions;
  nsDevice += o.nsDevice;
  nsDeviceIdle += o.nsDeviceIdle;
  return *this;
}

std::unique_ptr<Backend> BackendRegistry::make(const std::string& name) const {
  std::string known = "auto";
  for (const Entry& e : entries_) {
    if (name == e.name || (name == "auto" && (!e.fits || e.fits()))) return e.maker();
    known += ", " + e.name;
  }
  throw Error("backend \"" + name + "\" is not in this program; expected one of: " + known);
}

}  // namespace gxy
