// SPDX-License-Identifier: Apache-2.0
// The C interface: arguments are checked, and exceptions become results.
#include "insitu/api/galaxy_insitu.h"

#include <algorithm>
#include <exception>
#include <memory>
#include <string>

#include "core/comm/error.h"
#include "insitu/client/here.h"
#include "insitu/client/simulation.h"

using namespace gxy;
using namespace gxy::insitu;

struct gxy_sim {
  std::unique_ptr<Simulation> simulation;  ///< null: gxy_open() was used wrongly
  std::string message;
  std::string shown;      ///< what gxy_message() has returned
  bool embedded = false;  ///< it was opened with a server in this process
};

namespace {

// Runs what a function does. Nothing is thrown out of the library.
template <class Action>
int guarded(gxy_sim* sim, Action action) {
  if (!sim) return GXY_WRONG;
  try {
    if (!sim->simulation) return GXY_WRONG;  // The message of gxy_open() stays.
    sim->message.clear();
    return action(*sim->simulation);
  } catch (const std::exception& e) {
    try {
      sim->message = e.what();
    } catch (const std::exception&) {
      // There is no memory for the message.
    }
    return GXY_WRONG;
  }
}

const char* given(const char* text, const char* what) {
  if (!text) throw Error(std::string(what) + " is NULL, expected a text");
  return text;
}

void checkOf(int of, const char* function) {
  if (of != GXY_OF_POINTS && of != GXY_OF_CELLS)
    throw Error(std::string(function) + ": of " + std::to_string(of) + ", expected one of gxy_of");
}

std::unique_ptr<Simulation> opened(const char* name, int rank, int ranks, const char* options) {
  checkName(given(name, "gxy_open: the name"), "stream");
  if (ranks < 1 || ranks > kMostRanks || rank < 0 || rank >= ranks)
    throw Error("gxy_open: rank " + std::to_string(rank) + " of " + std::to_string(ranks) +
                ", expected a rank from 0 up, of 1 to " + std::to_string(kMostRanks) + " ranks");
  Options read = readOptions(options);
  if (read.on && rank == 0) readTriggers(read);
  return std::make_unique<Simulation>(std::move(read), Member{name, rank, ranks});
}

}  // namespace

int gxy_version(void) { return GXY_INSITU_VERSION; }

gxy_sim* gxy_open(const char* name, int rank, int ranks, const char* options) {
  static gxy_sim noMemory;
  try {
    auto sim = std::make_unique<gxy_sim>();
    try {
      sim->simulation = opened(name, rank, ranks, options);
    } catch (const std::exception& e) {
      sim->message = e.what();
    }
    return sim.release();
  } catch (const std::exception&) {
    return &noMemory;
  }
}

void gxy_set_here(const char* address, const char* token) {
  try {
    Here server;
    const std::string where = address ? address : "";
    const size_t colon = where.rfind(':');
    if (colon != std::string::npos) {
      server.host = where.substr(0, colon);
      server.port = uint16_t(std::stoi(where.substr(colon + 1)));
      server.token = token ? token : "";
    } else {
      server.problem = "\"to\": \"here\": the server of this MPI job could not be started";
    }
    setHere(std::move(server));
  } catch (const std::exception&) {
    // no memory, or no address: there is no server
  }
}

int gxy_prepare_here(const char* options, const char* mpi) {
  try {
    if (!saysHere(options)) return 0;
    if (here().port == 0) loadEmbedded(mpi ? mpi : "");
    return 1;
  } catch (const std::exception& e) {
    try {
      setHere({{}, 0, {}, e.what()});
    } catch (const std::exception&) {
      // There is no memory for the message.
    }
    return -1;
  }
}

namespace {

gxy_sim* openedHere(const char* name, int rank, int ranks, const char* options, Communicator comm) {
  bool started = false;
  try {
    if (comm.given())
      started = startEmbedded(comm, givenOptions(options));
    else if (here().problem.empty() && here().port == 0)
      setHere({{}, 0, {}, "\"to\": \"here\": another rank cannot start a server in its process"});
  } catch (const std::exception&) {
    // no memory
  }
  gxy_sim* sim = gxy_open(name, rank, ranks, options);
  sim->embedded = started;
  return sim;
}

}  // namespace

gxy_sim* gxy_open_here(const char* name, int rank, int ranks, const char* options, const void* comm) {
  return openedHere(name, rank, ranks, options, {comm, nullptr});
}

gxy_sim* gxy_open_here_fortran(const char* name, int rank, int ranks, const char* options, const int* comm) {
  return openedHere(name, rank, ranks, options, {nullptr, comm});
}

int gxy_grid(gxy_sim* sim, const char* mesh, int block, int of, const int64_t size[3], const int64_t first[3],
             const int64_t count[3], const double origin[3], const double spacing[3]) {
  return guarded(sim, [&](Simulation& s) {
    checkOf(of, "gxy_grid");
    if (!size || !first || !count || !origin || !spacing)
      throw Error("gxy_grid: an argument is NULL, expected arrays of three numbers");
    Grid grid;
    Extent owned;
    for (int a = 0; a < 3; a++) {
      if (size[a] < 1 || size[a] > kMostPoints || first[a] < 0 || first[a] > size[a] || count[a] < 0)
        throw Error("gxy_grid: size " + std::to_string(size[a]) + ", first " + std::to_string(first[a]) +
                    ", count " + std::to_string(count[a]) + " on axis " + std::to_string(a) +
                    ", expected a block inside the grid, of at most 2^31 by axis");
      grid.points[size_t(a)] = size[a];
      grid.origin[a] = origin[a];
      grid.spacing[a] = spacing[a];
      owned.first[size_t(a)] = first[a];
      owned.points[size_t(a)] = count[a];
    }
    if (std::any_of(count, count + 3, [](int64_t n) { return n == 0; })) owned = {};
    s.grid(given(mesh, "gxy_grid: mesh"), block, of, grid, owned);
    return GXY_TAKEN;
  });
}

int gxy_points(gxy_sim* sim, const char* mesh, int64_t count, gxy_array positions, gxy_array ids,
               const double box[6]) {
  return guarded(sim, [&](Simulation& s) {
    if (count < 0) throw Error("gxy_points: count " + std::to_string(count) + ", expected 0 or more");
    Box domain;
    for (int a = 0; box && a < 3; a++) {
      domain.lo[a] = box[a];
      domain.hi[a] = box[a + 3];
    }
    if (box && domain.empty())
      throw Error("gxy_points: the box is empty, expected the least x, y, z and then the largest");
    s.meshes("gxy_points").points(given(mesh, "gxy_points: mesh"), uint64_t(count), positions, ids, domain);
    return GXY_TAKEN;
  });
}

int gxy_cells(gxy_sim* sim, const char* mesh, int64_t points, gxy_array positions, int64_t cells,
              gxy_array types, gxy_array offsets, gxy_array connectivity) {
  return guarded(sim, [&](Simulation& s) {
    if (points < 0 || cells < 0)
      throw Error("gxy_cells: " + std::to_string(points) + " points and " + std::to_string(cells) +
                  " cells, expected 0 or more");
    CellArrays arrays;
    arrays.count = uint64_t(cells);
    arrays.types = types;
    arrays.offsets = offsets;
    arrays.connectivity = connectivity;
    s.meshes("gxy_cells").cells(given(mesh, "gxy_cells: mesh"), uint64_t(points), positions, arrays);
    return GXY_TAKEN;
  });
}

int gxy_field(gxy_sim* sim, const char* mesh, int block, const char* field, int of, gxy_array values) {
  return guarded(sim, [&](Simulation& s) {
    checkOf(of, "gxy_field");
    s.meshes("gxy_field")
        .field(given(mesh, "gxy_field: mesh"), block, given(field, "gxy_field: field"), of, values);
    return GXY_TAKEN;
  });
}

int gxy_skip(gxy_sim* sim, int64_t step, double time) {
  return guarded(sim, [&](Simulation& s) { return s.skip(step, time); });
}

int gxy_wanted(gxy_sim* sim, int64_t step, double time) {
  return guarded(sim, [&](Simulation& s) { return s.wanted(step, time); });
}

int gxy_wanted_settle(gxy_sim* sim, int64_t step, int any) {
  return guarded(sim, [&](Simulation& s) {
    s.settle(step, any != 0);
    return GXY_TAKEN;
  });
}

int gxy_steered(gxy_sim* sim, const char* parameter, double* value) {
  return guarded(sim, [&](Simulation& s) {
    if (!value) throw Error("gxy_steered: value is NULL, expected a double");
    return s.steered(given(parameter, "gxy_steered: parameter"), *value) ? 1 : 0;
  });
}

int gxy_publish(gxy_sim* sim, int64_t step, double time) {
  return guarded(sim, [&](Simulation& s) { return s.publish(step, time); });
}

int gxy_publish_last(gxy_sim* sim, int64_t step, double time) {
  return guarded(sim, [&](Simulation& s) { return s.publishLast(step, time); });
}

int gxy_statistics(gxy_sim* sim, gxy_stat* statistics) {
  return guarded(sim, [&](Simulation& s) {
    if (!statistics) throw Error("gxy_statistics: statistics is NULL, expected a gxy_stat");
    *statistics = s.statistics();
    return GXY_TAKEN;
  });
}

const char* gxy_message(gxy_sim* sim) {
  if (!sim) return "gxy_sim is NULL, expected what gxy_open returned";
  try {
    sim->shown = sim->message;
    if (sim->shown.empty() && sim->simulation) sim->shown = sim->simulation->problem();
    return sim->shown.c_str();
  } catch (const std::exception&) {
    return "there is no memory for a message";
  }
}

void gxy_close(gxy_sim* sim, double seconds) {
  if (!sim) return;
  guarded(sim, [&](Simulation& s) {
    s.close(seconds > 0 ? std::min(seconds, 1e6) : 0);
    return GXY_TAKEN;
  });
  if (sim->embedded) leaveEmbedded();
  if (sim->simulation || !sim->message.empty()) delete sim;
}
