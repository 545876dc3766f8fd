// SPDX-License-Identifier: Apache-2.0
#include "insitu/catalyst/adaptor.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace gxy::catalyst {

namespace {

constexpr size_t kMostMessages = 1000;
constexpr double kNearPlace = 1e-3, kNearSpacing = 1e-6;  // of a cell; simulations compute with 32 bits, too

// What was computed, the same on all ranks though each rounds differently: a multiple of 2^-bits of a cell, about.
double rounded(double value, double spacing, int bits) {
  if (!std::isnormal(spacing)) return value;
  const double unit = std::ldexp(1.0, std::ilogb(spacing) - bits);
  return std::round(value / unit) * unit;
}

std::string text(double number) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.9g", number);
  return digits;
}

// Where a block begins in the grid that begins at `origin`.
Index placeOf(const GridBlock& block, const Position& origin, const Position& spacing) {
  Index place;
  for (size_t a = 0; a < 3; a++) {
    const double cells = (block.origin[a] - origin[a]) / spacing[a];
    place[a] = std::llround(std::clamp(cells, -0x1p40, 0x1p40));
    if (!(std::abs(cells - double(place[a])) <= kNearPlace))
      throw std::runtime_error(block.path + ": its origin " + text(block.origin[a]) + " is " + text(cells) +
                               " cells from " + text(origin[a]) + " on axis " + std::to_string(a) +
                               ", expected a whole number");
  }
  return place;
}

// Components that lie at equal distances are read where they are, others from a copy.
gxy_array described(const Values& values, const Index& extent, const Index& first,
                    std::vector<std::byte>& copy) {
  const auto& all = values.components;
  const auto address = [&](size_t c) { return reinterpret_cast<intptr_t>(all[c].data); };
  const int64_t bytes = int64_t(bytesOf(all[0].type)), components = int64_t(all.size());
  int64_t apart = components > 1 ? address(1) - address(0) : 0;
  bool regular = components == 1 || apart != 0;
  for (size_t c = 1; c < all.size(); c++)
    regular = regular && all[c].stride == all[0].stride && address(c) - address(c - 1) == apart;
  const std::byte* data = all[0].data;
  int64_t stride = all[0].stride;
  if (!regular) {
    copy.resize(size_t(bytes * components * all[0].count));
    std::byte* to = copy.data();
    for (int64_t n = 0; n < all[0].count; n++)
      for (const Array& c : all) to = std::copy_n(c.data + n * c.stride, bytes, to);
    data = copy.data(), stride = bytes * components, apart = bytes;
  }
  const Index strides{stride, stride * extent[0], stride * extent[0] * extent[1]};
  for (size_t a = 0; a < 3 && data; a++) data += first[a] * strides[a];
  return {data, all[0].type, int(components), {strides[0], strides[1], strides[2]}, apart, 0};
}

}  // namespace

void Messages::say(const std::string& text) {
  if (said_.size() >= kMostMessages || !said_.insert(text).second) return;
  std::fputs((prefix_ + text + "\n").c_str(), stderr);
}

void Messages::setRank(int rank, int ranks) {
  prefix_ = ranks == 1 ? "galaxy: " : "galaxy: rank " + std::to_string(rank) + ": ";
}

Adaptor::Adaptor(const Node& params, Messages& messages)
    : messages_(&messages), params_(readParameters(params)), sim_(nullptr, Close{&params_.seconds}) {
  messages.setRank(params_.rank, params_.ranks);
  sim_.reset(gxy_open(params_.name.c_str(), params_.rank, params_.ranks, params_.options.c_str()));
  off_ = gxy_publish(sim_.get(), 0, 0) == GXY_OFF;  // else it is wrong without a mesh, and counts nothing
  gxy_stat counts;
  if (gxy_statistics(sim_.get(), &counts) != GXY_TAKEN) throw std::runtime_error(gxy_message(sim_.get()));
  for (const char* part : {"scripts", "pipelines"})
    if (params.find(std::string("catalyst/") + part))
      warn(std::string("catalyst/") + part +
           ": what is to be done with the data is said to the server, left out");
}

void Adaptor::about(conduit_node_impl* node) const {
  conduit().nodeSetPathChar8Str(node, "catalyst/galaxy/message", gxy_message(sim_.get()));
}

Meshes Adaptor::meshesOf(const Node& params) {
  Meshes meshes;
  meshes.lattices = std::move(meshes_.lattices);
  const Warn say = [this](const std::string& text) { warn(text); };
  for (const Node& channel : params.at("catalyst/channels").children()) {
    const std::string type = channel.at("type").text(), name = channel.name();
    if (type == "mesh") {
      for (const Node& domain : domainsOf(channel.at("data")))
        addMeshes(domain, name, name, params_.ghosts, say, meshes);
    } else if (type == "multimesh") {
      for (const Node& mesh : channel.at("data").children())
        for (const Node& domain : domainsOf(mesh))
          addMeshes(domain, name, name + "." + mesh.name(), params_.ghosts, say, meshes);
    } else {
      warn(channel.path() + ": type \"" + type +
           "\" is not taken, expected \"mesh\" or \"multimesh\", left out");
    }
  }
  return meshes;
}

Adaptor::Whole Adaptor::wholeOf(const std::vector<GridBlock>& blocks, const std::vector<Box>& boxes) const {
  const auto part = std::find_if(boxes.begin(), boxes.end(), [](const Box& box) { return !box.empty(); });
  const GridBlock& one = blocks[part == boxes.end() ? 0 : size_t(part - boxes.begin())];
  const WholeGrid& said = params_.wholes.at(params_.wholes.count(one.mesh) ? one.mesh : "");
  const auto missing = [&](const char* what, const char* how) {
    throw std::runtime_error(one.path + ": with several ranks, " + what +
                             " of the whole grid is not known, expected " + how +
                             " in catalyst_initialize, or in the file that GALAXY_CATALYST names");
  };
  Whole whole{{}, one.origin, said.spacing.value_or(one.spacing)};
  for (size_t a = 0; a < 3 && params_.ranks > 1 && !said.spacing; a++)
    whole.spacing[a] = rounded(one.spacing[a], one.spacing[a], 30);
  for (size_t b = 0; b < blocks.size(); b++)
    for (size_t a = 0; a < 3 && !boxes[b].empty(); a++)
      if (!(std::abs(blocks[b].spacing[a] - whole.spacing[a]) <= kNearSpacing * whole.spacing[a]))
        throw std::runtime_error(blocks[b].path + ": spacing " + text(blocks[b].spacing[a]) + " beside " +
                                 text(whole.spacing[a]) + ", expected the same");
  if (params_.ranks > 1) {
    if (!said.size) missing("the size", "catalyst/galaxy/size, its points along x, y and z,");
    if (!said.origin && !one.index)
      missing("the origin",
              "catalyst/galaxy/origin (x, y, z), or elements/origin in the topology instead of it");
    for (size_t a = 0; a < 3 && !said.origin; a++)
      whole.origin[a] =
          rounded(one.origin[a] - double((*one.index)[a]) * whole.spacing[a], whole.spacing[a], 20);
  } else {
    // The blocks of this rank are all there are.
    Index least{INT64_MAX, INT64_MAX, INT64_MAX}, end{INT64_MIN, INT64_MIN, INT64_MIN};
    const Position base = one.origin;
    for (size_t b = 0; b < blocks.size(); b++) {
      if (boxes[b].empty()) continue;
      const Index place = placeOf(blocks[b], base, whole.spacing);
      for (size_t a = 0; a < 3; a++) {
        const int64_t first = place[a] + boxes[b].first[a];
        if (first < least[a])
          least[a] = first,
          whole.origin[a] = blocks[b].origin[a] + double(boxes[b].first[a]) * whole.spacing[a];
        end[a] = std::max(end[a], first + boxes[b].count[a]);
      }
    }
    if (end[0] == INT64_MIN) throw std::runtime_error(one.path + ": the grid has no points");
    for (size_t a = 0; a < 3; a++) whole.points[a] = end[a] - least[a];
  }
  if (said.origin) whole.origin = *said.origin;
  if (said.size) whole.points = *said.size;
  return whole;
}

Adaptor::Grid Adaptor::placed(const std::vector<GridBlock>& blocks) {
  Grid grid;
  std::vector<Box> boxes;
  bool points = params_.association == "vertex";
  for (const GridBlock& block : blocks) {
    boxes.push_back(ownedOf(block));
    for (const Values& values : block.fields)
      points = points || (params_.association.empty() && !values.ofElements);
  }
  grid.of = points ? GXY_OF_POINTS : GXY_OF_CELLS;
  const Whole whole = wholeOf(blocks, boxes);
  if (points && std::count(whole.points.begin(), whole.points.end(), 1) > 0) {
    warn(blocks[0].path +
         ": fields of points in one layer, expected two layers or fields of elements, left out");
    grid.leftOut = true;
    return grid;
  }
  grid.size = whole.points;
  for (size_t a = 0; a < 3 && !points; a++) grid.size[a] = cells(whole.points, a);
  grid.origin = whole.origin;
  grid.spacing = whole.spacing;
  for (size_t b = 0; b < blocks.size(); b++) {
    Box& box = boxes[b];
    if (box.ofPoints && !points && !box.empty())
      throw std::runtime_error(blocks[b].ghosts->path +
                               ": ghosts of points do not say which cells are ghosts");
    const Index place = box.empty() ? Index() : placeOf(blocks[b], whole.origin, whole.spacing);
    Index first{}, count = box.count;
    for (size_t a = 0; a < 3; a++) {
      first[a] = place[a] + box.first[a];
      if (box.empty())
        first[a] = count[a] = 0;
      else if (!points)
        count[a] = cells(box.count, a);
      else if (!box.ofPoints && params_.shared && first[a] + count[a] != grid.size[a])
        count[a]--;  // The next block has the last points, too.
    }
    grid.blocks.push_back({blocks[b].points, blocks[b].origin, blocks[b].spacing, box, first, count});
  }
  return grid;
}

// `before`: how many blocks the library may know.
void Adaptor::tell(const std::string& mesh, const Grid& grid, size_t before) {
  const Placed none{};
  for (size_t b = 0; b < std::max(before, grid.blocks.size()); b++) {
    const Placed& block = b < grid.blocks.size() ? grid.blocks[b] : none;
    if (gxy_grid(sim_.get(), mesh.c_str(), int(b), grid.of, grid.size.data(), block.first.data(),
                 block.count.data(), grid.origin.data(), grid.spacing.data()) != GXY_TAKEN)
      throw std::runtime_error("grid \"" + mesh + "\", block " + std::to_string(b) + ": " +
                               gxy_message(sim_.get()));
  }
}

void Adaptor::grid(const std::string& mesh, const std::vector<GridBlock>& blocks) {
  if (published_ && !grids_.count(mesh))
    return warn(blocks[0].path + ": a new grid after the first step, left out");
  if (std::all_of(blocks.begin(), blocks.end(), [](const GridBlock& block) { return block.fields.empty(); }))
    return warn(blocks[0].path + ": a grid without fields, left out");
  Grid& grid = grids_[mesh];
  if (grid.leftOut) return;
  const size_t before = grid.blocks.size();
  const bool isAsBefore =
      published_ && std::equal(blocks.begin(), blocks.end(), grid.blocks.begin(), grid.blocks.end(),
                               [](const GridBlock& now, const Placed& then) {
                                 return now.points == then.points && now.origin == then.origin &&
                                        now.spacing == then.spacing;
                               });
  if (!isAsBefore) {
    // If the new blocks are wrong, those of the next step are new again.
    if (published_) grid.blocks.assign(std::max(before, blocks.size()), Placed());
    Grid now = placed(blocks);
    if (published_ && now.leftOut) throw std::runtime_error(blocks[0].path + ": expected a grid as before");
    if (!now.leftOut) tell(mesh, now, std::max(before, grid.blocks.size()));
    grid = std::move(now);
    if (grid.leftOut) return;
    std::erase_if(told_, [&](const auto& one) { return std::get<0>(one.first) == mesh; });
  } else {
    tell(mesh, grid, before);  // where ranks wait, whenever another rank may have other blocks
  }
  const bool ofCells = grid.of == GXY_OF_CELLS;
  for (size_t b = 0; b < blocks.size(); b++) {
    Index extent = blocks[b].points;
    for (size_t a = 0; a < 3 && ofCells; a++) extent[a] = cells(blocks[b].points, a);
    for (const Values& values : blocks[b].fields) {
      if (values.ofElements == ofCells)
        field(values, {mesh, int(b), values.name}, grid.of, extent, grid.blocks[b].box.first);
      else
        warn(values.path +
             ": a grid has fields of its points or of its cells so far, left out "
             "(catalyst/galaxy/association)");
    }
  }
}

void Adaptor::points(const Points& points) {
  const Key key{points.mesh, 0, ""};
  const int64_t count = points.positions.components[0].count;
  const Index row{count, 1, 1};
  gxy_array ids{};
  for (const Values& values : points.fields)
    if (values.name == params_.ids && !points.cells)
      ids = described(values, row, {}, copies_[{points.mesh, 0, params_.ids}]);
  const gxy_array positions = described(points.positions, row, {}, copies_[key]);
  const double* box = params_.box ? params_.box->data() : nullptr;
  int result = GXY_TAKEN;
  if (points.cells) {
    const Cells& cells = *points.cells;
    const auto rowOf = [](const Array& a) { return gxy_array{a.data, a.type, 1, {a.stride, 0, 0}, 0, 0}; };
    const bool areAlike = cells.type != 0;
    const gxy_array ofAll{&cells.type, GXY_UINT8, 1, {0, 0, 0}, 0, 0};
    result = gxy_cells(sim_.get(), points.mesh.c_str(), count, positions, cells.count,
                       areAlike ? ofAll : rowOf(cells.types), areAlike ? gxy_array{} : rowOf(cells.offsets),
                       rowOf(cells.connectivity));
  } else {
    result = gxy_points(sim_.get(), points.mesh.c_str(), count, positions, ids, box);
  }
  if (!told(key, points.path, result)) return;
  for (const Values& values : points.fields) {
    const bool ofCells = points.cells && values.ofElements;
    if (values.name != params_.ids || points.cells)
      field(values, {points.mesh, 0, values.name}, ofCells ? GXY_OF_CELLS : GXY_OF_POINTS,
            ofCells ? Index{points.cells->count, 1, 1} : row, {});
  }
}

void Adaptor::field(const Values& values, const Key& key, int of, const Index& extent, const Index& first) {
  const auto& [mesh, block, own] = key;
  const std::string& owner = own == kGhosts ? mesh : owners_.try_emplace(own, mesh).first->second;
  const std::string name = owner == mesh ? own : mesh + "." + own;
  const gxy_array array = described(values, extent, first, copies_[key]);
  told(key, values.path, gxy_field(sim_.get(), mesh.c_str(), block, name.c_str(), of, array));
}

// What is not taken is left out. What was taken before is then missing, since it may not be there any more.
bool Adaptor::told(const Key& key, const std::string& path, int result) {
  if (result == GXY_TAKEN) return told_[key] = true;
  warn(path + ": " + gxy_message(sim_.get()) + ", left out");
  return false;
}

void Adaptor::execute(const Node& params) {
  if (off_) return;
  step_++;  // at least, where the node does not say it
  try {
    const Node state = params.at("catalyst/state");
    step_ = state.at(state.find("timestep") ? "timestep" : "cycle").integer();
    time_ = state.at("time").number();
    describe(params);
    publish(params.integerOr("catalyst/galaxy/last", 0) != 0);
  } catch (...) {
    gxy_skip(sim_.get(), step_, time_);  // the other ranks may publish it
    throw;
  }
}

void Adaptor::describe(const Node& params) {
  for (auto& [key, now] : told_) now = false;
  meshes_ = meshesOf(params);
  forgetUnused(meshes_.lattices);
  std::map<std::string, std::vector<GridBlock>> grids;
  for (const GridBlock& block : meshes_.grids) grids[block.mesh].push_back(block);
  for (const auto& [mesh, blocks] : grids) grid(mesh, blocks);
  for (const Points& all : meshes_.points) points(all);
  for (const auto& [key, now] : told_) {
    const auto& [mesh, block, name] = key;
    if (!now)
      throw std::runtime_error(
          (name.empty() ? "the points" : "field \"" + name + "\" of block " + std::to_string(block)) +
          " of mesh \"" + mesh + "\": missing, expected what the first step had");
  }
}

void Adaptor::publish(bool last) {
  if (told_.empty()) warn("catalyst/channels: there is nothing that Galaxy takes");
  const auto offer = told_.empty() ? gxy_skip : last ? gxy_publish_last : gxy_publish;
  const int result = offer(sim_.get(), step_, time_);
  if (result == GXY_WRONG) throw std::runtime_error(gxy_message(sim_.get()));
  published_ = !told_.empty();
  off_ = result == GXY_OFF;
  if (result == GXY_LOST && *gxy_message(sim_.get())) warn(gxy_message(sim_.get()));
}

}  // namespace gxy::catalyst
