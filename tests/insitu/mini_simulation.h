// SPDX-License-Identifier: Apache-2.0
// A simulation of several ranks on one thread, whose values are a function of point, step and field.
#pragma once
#include <atomic>
#include <cmath>
#include <cstring>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "core/data/scalar.h"
#include "core/data/volume.h"
#include "insitu/api/galaxy_insitu.h"
#include "insitu/plan/blocks.h"

namespace gxy::test {

/// How the arrays of a simulation lie in memory.
enum class Layout { Together, Ghosts, Structure, Backwards, Fortran };
inline constexpr Layout kLayouts[] = {Layout::Together, Layout::Ghosts, Layout::Structure, Layout::Backwards,
                                      Layout::Fortran};

struct MiniField {
  std::string name;
  ScalarType type = ScalarType::Float32;
  int components = 1;
};

/// The value of a component of a field at a point.
inline double valueAt(const Grid& grid, const Index3& p, int64_t step, size_t field, int component) {
  const double x = double(p[0]) / double(grid.points[0]), y = double(p[1]) / double(grid.points[1]),
               z = double(p[2]) / double(grid.points[2]);
  return 40 * std::sin(3 * x + 0.3 * double(step) + component) * std::cos(2 * y - double(field)) +
         30 * z * z + 45;
}

/// The array of one field of one block.
class MiniArray {
 public:
  MiniArray(const MiniField& field, const Extent& block, Layout layout) : field_(field), block_(block) {
    const auto size = int64_t(bytesOf(field.type));
    const int64_t ghosts = layout == Layout::Ghosts ? 2 : 0, extra = layout == Layout::Structure ? 3 : 0;
    Index3 all;
    for (size_t a = 0; a < 3; a++) all[a] = block.points[a] + 2 * ghosts;
    int64_t next = size * (field.components + extra);
    component_ = size;
    if (layout == Layout::Fortran && field.components > 1) {  // one array for each component
      next = size;
      component_ = size * all[0] * all[1] * all[2];
    }
    int64_t first = 0;
    for (size_t i = 0; i < 3; i++) {
      const size_t axis = layout == Layout::Fortran ? 2 - i : i;
      stride_[axis] = next;
      first += ghosts * next;
      if (layout == Layout::Backwards) {
        first += next * (all[axis] - 1);
        stride_[axis] = -next;
      }
      next *= all[axis];
    }
    first_ = first;
    bytes_.assign(size_t(next + component_ * field.components), std::byte(0x5a));
  }

  void fill(const Grid& grid, int64_t step, size_t field) {
    for (int64_t k = 0; k < block_.points[2]; k++)
      for (int64_t j = 0; j < block_.points[1]; j++)
        for (int64_t i = 0; i < block_.points[0]; i++)
          for (int c = 0; c < field_.components; c++) {
            const Index3 p{block_.first[0] + i, block_.first[1] + j, block_.first[2] + k};
            std::byte* at =
                bytes_.data() + first_ + i * stride_[0] + j * stride_[1] + k * stride_[2] + c * component_;
            withType(field_.type, [&](auto value) {
              value = decltype(value)(valueAt(grid, p, step, field, c));
              std::memcpy(at, &value, sizeof value);
            });
          }
  }
  gxy_array array() const {
    return {bytes_.data() + first_,
            int(field_.type),
            field_.components,
            {stride_[0], stride_[1], stride_[2]},
            component_,
            0};
  }

 private:
  MiniField field_;
  Extent block_;
  int64_t stride_[3] = {}, component_ = 0, first_ = 0;
  std::vector<std::byte> bytes_;
};

class MiniSimulation {
 public:
  /// `of` is GXY_OF_POINTS or GXY_OF_CELLS: of what `grid.points` and `blocks` are, and the fields. `only`: this rank is one, and the
  /// others are elsewhere; -1: all are here.
  MiniSimulation(std::string name, const Grid& grid, std::vector<insitu::Block> blocks, int ranks,
                 std::vector<MiniField> fields, Layout layout, const std::string& options,
                 int of = GXY_OF_POINTS, int only = -1)
      : grid_(grid), fields_(std::move(fields)), layout_(layout), of_(of) {
    for (int r = 0; r < ranks; r++)
      sims_.emplace_back(only < 0 || r == only ? gxy_open(name.c_str(), r, ranks, options.c_str()) : nullptr,
                         [](gxy_sim* s) { gxy_close(s, 0); });
    blocks_.resize(size_t(ranks));
    decompose(grid, blocks);
  }

  /// The ranks have other blocks from now on, and perhaps another grid. `some`: only these ranks have, and tell it; none: all of them.
  void decompose(const Grid& grid, const std::vector<insitu::Block>& blocks, const std::set<int>& some = {}) {
    grid_ = grid;
    const auto tells = [&](int r) { return rank(r) && (some.empty() || some.count(r) > 0); };
    std::erase_if(arrays_, [&](const Array& a) { return tells(a.rank); });
    std::vector<int> now(sims_.size());
    for (const insitu::Block& b : blocks) {
      if (!tells(b.rank)) continue;
      now[size_t(b.rank)]++;
      tell(b, b.extent.points);
      for (size_t f = 0; f < fields_.size(); f++) {
        arrays_.push_back({b.rank, f, std::make_unique<MiniArray>(fields_[f], b.extent, layout_)});
        results_ |= gxy_field(rank(b.rank), "grid", b.index, fields_[f].name.c_str(), of_,
                              arrays_.back().values->array());
      }
    }
    for (int r = 0; r < int(sims_.size()); r++) {
      if (!tells(r)) continue;
      for (int b = now[size_t(r)]; b < std::max(1, blocks_[size_t(r)]); b++) {
        tell({r, b, {}}, {0, 0, 0});
        for (const MiniField& f : fields_)
          results_ |= gxy_field(rank(r), "grid", b, f.name.c_str(), of_,
                                {nullptr, int(f.type), f.components, {0, 0, 0}, 0, 0});
      }
      blocks_[size_t(r)] = now[size_t(r)];
    }
  }

  gxy_sim* rank(int r) { return sims_[size_t(r)].get(); }
  int results() const { return results_; }  ///< of all calls so far; 0: all of them are fine
  int64_t step() const { return step_; }

  /// Computes the next step, and publishes it on all ranks. Returns how many have taken it.
  int publish() {
    fill(++step_);
    int taken = 0;
    for (const auto& s : sims_)
      if (s) taken += gxy_publish(s.get(), step_, 0.5 * double(step_)) == GXY_TAKEN;
    return taken;
  }
  /// The same, with a thread for each rank, since they wait for each other.
  int publishTogether() {
    fill(++step_);
    std::atomic<int> taken = 0;
    onThreads([&](gxy_sim* s) { taken += gxy_publish(s, step_, 0.5 * double(step_)) == GXY_TAKEN; });
    return taken;
  }
  /// Computes the next step, and returns its number.
  int64_t next() {
    fill(++step_);
    return step_;
  }
  /// Publishes the next step as the last, and forgets its values. Then closes the simulation.
  void publishLastAndClose(double seconds) {
    fill(++step_);
    for (const auto& s : sims_) results_ |= gxy_publish_last(s.get(), step_, 0.5 * double(step_));
    fill(step_ + 1000);
    onThreads([&](gxy_sim* s) { gxy_close(s, seconds); });
    for (auto& s : sims_) static_cast<void>(s.release());
  }
  int64_t published() {
    gxy_stat statistics{};
    gxy_statistics(rank(0), &statistics);
    return statistics.published;
  }
  void closeRank(int r) { sims_[size_t(r)].reset(); }

 private:
  void fill(int64_t step) {
    for (Array& a : arrays_) a.values->fill(grid_, step, a.field);
  }
  template <class Action>
  void onThreads(Action action) {
    std::vector<std::thread> threads;
    for (const auto& s : sims_) threads.emplace_back(action, s.get());
    for (std::thread& t : threads) t.join();
  }
  void tell(const insitu::Block& b, const Index3& count) {
    results_ |= gxy_grid(rank(b.rank), "grid", b.index, of_, grid_.points.data(), b.extent.first.data(),
                         count.data(), &grid_.origin[0], &grid_.spacing[0]);
  }

  Grid grid_;
  std::vector<MiniField> fields_;
  const Layout layout_;
  const int of_;
  std::vector<std::unique_ptr<gxy_sim, void (*)(gxy_sim*)>> sims_;
  std::vector<int> blocks_;  ///< by rank: how many
  struct Array {
    int rank = 0;
    size_t field = 0;
    std::unique_ptr<MiniArray> values;
  };
  std::vector<Array> arrays_;
  int results_ = 0;
  int64_t step_ = 0;
};

}  // namespace gxy::test
