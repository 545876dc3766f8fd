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

}  // namespace

Simulation::Simulation(Options options, Member member)
    : connection_(options.on ? std::make_unique<Connection>(std::move(options), std::move(member))
                             : nullptr) {}

void Simulation::checkMesh(const std::string& mesh) const {
  checkName(mesh, "mesh");
  if (!mesh_.empty() && mesh != mesh_)
    throw Error("mesh \"" + mesh + "\" beside \"" + mesh_ + "\": a stream has one grid so far");
}

void Simulation::grid(const std::string& mesh, int block, const Grid& grid, const Extent& owned) {
  checkMesh(mesh);
  if (described_) throw Error("gxy_grid after the first step: a decomposition cannot change so far");
  if (block < 0) throw Error("gxy_grid: block " + std::to_string(block) + ", expected 0, 1, ...");
  if (!blocks_.empty() && !(grid == grid_))
    throw Error("gxy_grid: a grid of " + sizeText(grid.points) + " points beside one of " +
                sizeText(grid_.points) + ", or another origin or spacing: expected the same in all blocks");
  Description one{{mesh, grid, {{"any", ScalarType::Float32, 1}}}, {}};
  if (owned.count() != 0) one.blocks.push_back(owned);
  check(one);
  mesh_ = mesh;
  grid_ = grid;
  blocks_[block].owned = owned;
}

void Simulation::field(const std::string& mesh, int block, const std::string& name, const gxy_array& values) {
  checkMesh(mesh);
  checkName(name, "field");
  const auto at = blocks_.find(block);
  if (at == blocks_.end())
    throw Error("gxy_field, \"" + name + "\": there is no block " + std::to_string(block) +
                " on this rank, expected gxy_grid() first");
  checkArray(name, values, at->second.owned);
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
  fields_ = fields();
  Description description{{mesh_, grid_, fields_}, {}};
  for (auto& [number, block] : blocks_) {
    if (block.owned.count() == 0) continue;
    block.index = int(description.blocks.size());
    description.blocks.push_back(block.owned);
    present_.push_back(&block);
  }
  check(description);
  connection_->describe(std::move(description));
  described_ = true;
}

int Simulation::publish(int64_t step, double time) {
  const auto begin = std::chrono::steady_clock::now();
  if (!connection_) return GXY_OFF;
  if (!described_)
    describe();
  else if (step <= lastStep_)
    throw Error("gxy_publish: step " + std::to_string(step) + " after step " + std::to_string(lastStep_) +
                ", expected steps that ascend");
  lastStep_ = step;
  statistics_.offered++;
  int result = connection_->connected() ? GXY_NOT_TAKEN : GXY_LOST;
  if (connection_->publish()) {
    const auto route = connection_->route();
    copy(*route);
    connection_->filled(step, time);
    statistics_.taken++;
    statistics_.bytes += int64_t(route->bytes);
    result = GXY_TAKEN;
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  statistics_.publish_seconds += seconds;
  statistics_.longest_seconds = std::max(statistics_.longest_seconds, seconds);
  return result;
}

void Simulation::copy(const Route& route) {
  std::byte* to = route.slot.get();
  for (const Destination& d : route.destinations)
    for (const Piece& piece : d.pieces) {
      const Block& block = *present_.at(size_t(piece.block));
      for (const Field& field : fields_) {
        copyPoints(block.fields.at(field.name), block.owned.first, piece.points, to);
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
  if (connection_) connection_->close(seconds);
}

}  // namespace gxy::insitu
