// SPDX-License-Identifier: Apache-2.0
#include "insitu/client/simulation.h"

#include <algorithm>
#include <chrono>

#include "core/comm/error.h"
#include "insitu/client/snapshot.h"

namespace gxy::insitu {

namespace {

std::string sizeText(const Index3& i) {
  return std::to_string(i[0]) + " x " + std::to_string(i[1]) + " x " + std::to_string(i[2]);
}

void checkArray(const std::string& name, const gxy_array& a, const Extent& owned) {
  const auto fail = [&](const std::string& why) { throw Error("gxy_field, \"" + name + "\": " + why); };
  if (a.memory != 0) fail("memory " + std::to_string(a.memory) + ", expected 0, the memory of the host");
  if (a.type < 0 || a.type > GXY_FLOAT64)
    fail("type " + std::to_string(a.type) + ", expected one of gxy_type, 0 to 9");
  if (a.components < 1 || a.components > kMostComponents)
    fail(std::to_string(a.components) + " components, expected 1 to " + std::to_string(kMostComponents));
  if (owned.count() == 0) return;
  if (!a.data) fail("there are no data, expected a pointer to the first owned value");
  for (size_t axis = 0; axis < 3; axis++)
    if (a.stride[axis] == 0 && owned.points[axis] > 1)
      fail("stride[" + std::to_string(axis) + "] is 0, expected the bytes from one point to the next");
}

// The grid of the centres of cells, with a rim. `cells` counts cells; its origin is that of the first point.
Grid centresOf(const Grid& cells) {
  Grid grid = cells;
  grid.rim = true;
  for (int a = 0; a < 3; a++) {
    grid.points[size_t(a)] += 2;
    grid.origin[a] -= grid.spacing[a] / 2;
  }
  return grid;
}

// The points of the stream's grid that a rank owns with some cells: their centres, and the rim beside the outermost ones.
Extent withRim(const Extent& cells, const Index3& all) {
  Extent owned;
  if (cells.count() == 0) return owned;
  for (size_t a = 0; a < 3; a++) {
    const int64_t end = cells.first[a] + cells.points[a];
    owned.first[a] = cells.first[a] == 0 ? 0 : cells.first[a] + 1;
    owned.points[a] = (end == all[a] ? end + 2 : end + 1) - owned.first[a];
  }
  return owned;
}

// A point of time `seconds` later, which may be infinitely many.
Interrupt::Clock::time_point later(Interrupt::Clock::time_point begin,
                                   std::chrono::duration<double> seconds) {
  constexpr std::chrono::hours kForEver(24 * 365 * 100);
  return begin +
         (seconds < kForEver ? std::chrono::duration_cast<Interrupt::Clock::duration>(seconds) : kForEver);
}

}  // namespace

Simulation::Simulation(Options options, Member member)
    : every_(options.every),
      firstTime_(options.firstTime),
      lastTime_(options.lastTime),
      patience_(options.patience),
      connection_(options.on ? std::make_unique<Connection>(std::move(options), std::move(member))
                             : nullptr) {}

void Simulation::checkMesh(const std::string& mesh) const {
  checkName(mesh, "mesh");
  if (!mesh_.empty() && mesh != mesh_)
    throw Error("mesh \"" + mesh + "\" beside \"" + mesh_ + "\": a stream has one grid so far");
}

void Simulation::grid(const std::string& mesh, int block, int of, Grid grid, const Extent& owned) {
  checkMesh(mesh);
  if (described_) throw Error("gxy_grid after the first step: a decomposition cannot change so far");
  if (block < 0) throw Error("gxy_grid: block " + std::to_string(block) + ", expected 0, 1, ...");
  Block described{owned, owned, {}};
  if (of == GXY_OF_CELLS) {
    described.owned = withRim(owned, grid.points);
    for (size_t a = 0; a < 3; a++) described.values.first[a]++;
    grid = centresOf(grid);
  }
  if (!blocks_.empty() && !(grid == grid_))
    throw Error("gxy_grid: a grid of " + sizeText(grid.points) + " points beside one of " +
                sizeText(grid_.points) +
                ", another origin or spacing, or cells beside points: expected the same in all blocks");
  Description one{{mesh, grid, {{"any", ScalarType::Float32, 1}}}, {}};
  if (owned.count() != 0) one.blocks.push_back(described.owned);
  check(one);
  mesh_ = mesh;
  grid_ = grid;
  Block& known = blocks_[block];
  if (known.values == described.values)
    described.fields = std::move(known.fields);  // else they are of other arrays
  known = std::move(described);
}

void Simulation::field(const std::string& mesh, int block, const std::string& name, int of,
                       const gxy_array& values) {
  checkMesh(mesh);
  checkName(name, "field");
  const auto at = blocks_.find(block);
  if (at == blocks_.end())
    throw Error("gxy_field, \"" + name + "\": there is no block " + std::to_string(block) +
                " on this rank, expected gxy_grid() first");
  if ((of == GXY_OF_CELLS) != grid_.rim)
    throw Error("gxy_field, \"" + name + "\": values of " + (grid_.rim ? "points" : "cells") +
                " on a grid that counts " + (grid_.rim ? "cells" : "points") + ", expected the same so far");
  checkArray(name, values, at->second.values);
  auto& known = at->second.fields;
  const auto before = known.find(name);
  if (described_ && (before == known.end() || before->second.type != values.type ||
                     before->second.components != values.components))
    throw Error(
        "gxy_field, \"" + name +
        "\": a new field, type or number of components after the first step, expected those of before");
  known[name] = values;
}

std::vector<Field> Simulation::fields() const {
  std::vector<Field> fields;
  for (const auto& [number, block] : blocks_) {
    std::vector<Field> here;
    for (const auto& [name, values] : block.fields)
      here.push_back({name, ScalarType(values.type), values.components});
    if (number != blocks_.begin()->first && here != fields)
      throw Error("gxy_publish: the fields of block " + std::to_string(number) +
                  " differ from those of another block, expected the same names, types and components");
    fields = std::move(here);
  }
  if (fields.empty())
    throw Error("gxy_publish: there is no field, expected gxy_grid() and gxy_field() first");
  return fields;
}

void Simulation::describe() {
  Description description{{mesh_, grid_, fields()}, {}};
  std::vector<const Block*> present;
  for (const auto& [number, block] : blocks_) {
    if (block.owned.count() == 0) continue;
    description.blocks.push_back(block.owned);
    present.push_back(&block);
  }
  check(description);
  fields_ = description.mesh.fields;
  present_ = std::move(present);
  described_ = true;
  connection_->describe(std::move(description));
}

// Whether a publish is offered at all. It is the same on all ranks, so they count the same publishes.
bool Simulation::passes(double time) const {
  return (statistics_.offered - 1) % every_ == 0 && !(time < firstTime_) && !(time > lastTime_);
}

// What every publish begins with. Throws Error where it is used wrongly.
void Simulation::begin(int64_t step, const char* function) {
  if (last_) throw Error(std::string(function) + " after gxy_publish_last, expected nothing but gxy_close");
  if (!described_)
    describe();
  else if (step <= lastStep_)
    throw Error(std::string(function) + ": step " + std::to_string(step) + " after step " +
                std::to_string(lastStep_) + ", expected steps that ascend");
}

void Simulation::count(int64_t step) {
  lastStep_ = step;
  statistics_.offered++;
}

int Simulation::missed() const { return connection_->connected() ? GXY_NOT_TAKEN : GXY_LOST; }

int Simulation::publish(int64_t step, double time) {
  const auto begun = Clock::now();
  if (!connection_) return GXY_OFF;
  begin(step, "gxy_publish");
  count(step);
  int result = missed();
  if (passes(time)) {
    if (patience_.count() > 0) connection_->await(later(begun, patience_), Connection::Loss::EndsTheWait);
    if (connection_->publish()) {
      take({step, time});
      result = GXY_TAKEN;
    } else {
      result = missed();
    }
  }
  const double seconds = std::chrono::duration<double>(Clock::now() - begun).count();
  statistics_.publish_seconds += seconds;
  statistics_.longest_seconds = std::max(statistics_.longest_seconds, seconds);
  return result;
}

int Simulation::publishLast(int64_t step, double time) {
  if (!connection_) return GXY_OFF;
  begin(step, "gxy_publish_last");
  keepFields();
  count(step);
  last_ = {step, time};
  return connection_->lost() ? GXY_LOST : GXY_TAKEN;
}

void Simulation::take(const Step& step) {
  const auto route = connection_->route();
  if (route) copy(*route);  // A server appoints nothing before there is a plan.
  connection_->filled(step.step, step.time);
  statistics_.taken++;
  statistics_.bytes += route ? int64_t(route->bytes) : 0;
}

// Copies the arrays of the simulation, which may be gone when they are sent. Nothing has changed if there is no memory.
void Simulation::keepFields() {
  std::vector<std::vector<std::byte>> kept;
  std::map<int, Block> blocks = blocks_;
  for (auto& [number, block] : blocks) {
    const Index3& n = block.values.points;
    if (block.values.count() == 0) continue;
    for (auto& [name, array] : block.fields) {
      const auto bytes = int64_t(bytesOf(ScalarType(array.type))) * array.components;
      kept.emplace_back(size_t(bytes * block.values.count()));
      copyPoints(array, block.values, block.values, kept.back().data());
      const gxy_array copy{kept.back().data(), array.type, array.components, {}, 0, 0};
      array = copy;
      array.stride[0] = bytes;
      array.stride[1] = bytes * n[0];
      array.stride[2] = bytes * n[0] * n[1];
    }
  }
  for (auto& [number, block] : blocks) blocks_.at(number).fields.swap(block.fields);
  kept_ = std::move(kept);
}

// Waits until the last step is published, or `until` has come. A step that the server has given up is offered again.
void Simulation::deliverLast(Clock::time_point until) {
  while (connection_->await(until, Connection::Loss::IsWaitedOut)) {
    if (!connection_->publishLast()) continue;  // The server has changed its mind meanwhile.
    const uint64_t before = connection_->published();
    take(*last_);
    connection_->settle(until);
    if (connection_->published() > before) return;
  }
}

void Simulation::copy(const Route& route) {
  std::byte* to = route.slot.get();
  for (const Destination& d : route.destinations)
    for (const Piece& piece : d.pieces) {
      const Block& block = *present_.at(size_t(piece.block));
      for (const Field& field : fields_) {
        copyPoints(block.fields.at(field.name), block.values, piece.points, to);
        to += size_t(piece.points.count()) * field.bytesPerPoint();
      }
    }
}

gxy_stat Simulation::statistics() const {
  gxy_stat s = statistics_;
  if (connection_) s.published = int64_t(connection_->published());
  return s;
}

void Simulation::close(double seconds) {
  if (!connection_) return;
  const auto until = later(Clock::now(), std::chrono::duration<double>(seconds));
  if (last_) deliverLast(until);
  connection_->settle(until);
  connection_->close();
}

}  // namespace gxy::insitu
