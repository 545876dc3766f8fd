// SPDX-License-Identifier: Apache-2.0
/// The interface of galaxy_insitu.h for C++11: an object that closes its stream when it goes. docs/insitu.md is the guide.
/// Nothing here throws; functions return gxy_result, and ignoring it is safe. The rules of the C interface hold.
#ifndef GALAXY_INSITU_HPP
#define GALAXY_INSITU_HPP

#include <array>
#include <cstdint>
#include <type_traits>

#include "insitu/api/galaxy_insitu.h"

namespace gxy {

/// The gxy_type of a C++ type of numbers.
template <class T>
constexpr int insituType() {
  static_assert(std::is_arithmetic<T>::value && !std::is_same<T, bool>::value && sizeof(T) <= 8,
                "expected integers of 8 to 64 bits, float or double");
  return std::is_floating_point<T>::value ? (sizeof(T) == 4 ? GXY_FLOAT32 : GXY_FLOAT64)
                                          : (sizeof(T) == 1   ? GXY_INT8
                                             : sizeof(T) == 2 ? GXY_INT16
                                             : sizeof(T) == 4 ? GXY_INT32
                                                              : GXY_INT64) +
                                                (std::is_signed<T>::value ? 0 : 1);
}

/// One stream on one rank. It can be moved and not copied. Two threads must not use it at the same time.
class Simulation {
 public:
  using Indices = std::array<std::int64_t, 3>;  ///< By axis: x, y, z.
  using Coordinates = std::array<double, 3>;    ///< By axis, in the simulation's unit of length.

  /// Begins the stream `name` on this rank, as gxy_open() does. `options` is a JSON object or null.
  explicit Simulation(const char* name, int rank = 0, int ranks = 1, const char* options = nullptr) noexcept
      : sim_(gxy_open(name, rank, ranks, options)) {}
  ~Simulation() { close(); }
  Simulation(Simulation&& other) noexcept : sim_(other.sim_), of_(other.of_) { other.sim_ = nullptr; }
  Simulation& operator=(Simulation&& other) noexcept {
    if (this == &other) return *this;
    close();
    sim_ = other.sim_;
    of_ = other.of_;
    other.sim_ = nullptr;
    return *this;
  }
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  /// Says what this rank owns of a uniform grid: `count` points from `first` on, of `size` points, or cells with GXY_OF_CELLS. Called again, it
  /// changes that from the next publish on, as gxy_grid() says.
  gxy_result grid(const Indices& size, const Indices& first, const Indices& count,
                  const Coordinates& origin = Coordinates{{0, 0, 0}},
                  const Coordinates& spacing = Coordinates{{1, 1, 1}}, gxy_of of = GXY_OF_POINTS,
                  int block = 0, const char* mesh = "grid") noexcept {
    of_ = of;
    return gxy_result(gxy_grid(sim_, mesh, block, of, size.data(), first.data(), count.data(), origin.data(),
                               spacing.data()));
  }

  /// Says where a field of the block lies. values() and strided() make the array. Its memory is read in publish() only.
  gxy_result field(const char* name, const gxy_array& values, int block = 0,
                   const char* mesh = "grid") noexcept {
    return gxy_result(gxy_field(sim_, mesh, block, name, of_, values));
  }

  /// Says which particles this rank has now, as gxy_points() does; row() makes the arrays. `ids` may be left out, and `box`, the
  /// least x, y, z and then the largest, may be null. Called again, with all fields, when the particles change.
  gxy_result points(std::int64_t count, const gxy_array& positions, const gxy_array& ids = gxy_array(),
                    const double* box = nullptr, const char* mesh = "points") noexcept {
    return gxy_result(gxy_points(sim_, mesh, count, positions, ids, box));
  }

  /// Says where a field of the particles lies. row() makes the array.
  gxy_result pointField(const char* name, const gxy_array& values, const char* mesh = "points") noexcept {
    return gxy_result(gxy_field(sim_, mesh, 0, name, GXY_OF_POINTS, values));
  }

  /// Says which lines, triangles or cells with a volume this rank has now, as gxy_cells() does; row() makes the arrays, and allOf() one for cells of one type. Without
  /// `offsets`, all cells are of one type with a fixed number of points. Called again, with all fields, when the cells change.
  gxy_result cells(std::int64_t points, const gxy_array& positions, std::int64_t cells,
                   const gxy_array& types, const gxy_array& connectivity,
                   const gxy_array& offsets = gxy_array(), const char* mesh = "cells") noexcept {
    return gxy_result(gxy_cells(sim_, mesh, points, positions, cells, types, offsets, connectivity));
  }

  /// Says where a field of the points or of the cells of a mesh of cells lies. row() makes the array.
  gxy_result cellsField(const char* name, const gxy_array& values, gxy_of of = GXY_OF_POINTS,
                        const char* mesh = "cells") noexcept {
    return gxy_result(gxy_field(sim_, mesh, 0, name, of, values));
  }

  /// Counts a step that this rank cannot publish, so that all ranks go on counting alike. It is left out on all of them.
  gxy_result skip(std::int64_t step, double time) noexcept { return gxy_result(gxy_skip(sim_, step, time)); }

  /// Whether the next publish(), of this step and time, will be taken, as gxy_wanted() says; off or wrong use: not.
  bool wanted(std::int64_t step, double time) noexcept { return gxy_wanted(sim_, step, time) == 1; }

  /// Says what the ranks have agreed on: whether any of them wants the step.
  gxy_result settle(std::int64_t step, bool any) noexcept {
    return gxy_result(gxy_wanted_settle(sim_, step, any ? 1 : 0));
  }

  /// Whether somebody has given a parameter another value since the last call, as gxy_steered() says; then `value` is that.
  bool steered(const char* parameter, double& value) noexcept {
    return gxy_steered(sim_, parameter, &value) == 1;
  }

  /// Offers a step. It never waits, unless the option "policy" says so. Steps ascend.
  gxy_result publish(std::int64_t step, double time) noexcept {
    return gxy_result(gxy_publish(sim_, step, time));
  }

  /// Offers the last step, which close() waits for. Afterwards only close() may follow.
  gxy_result publishLast(std::int64_t step, double time) noexcept {
    return gxy_result(gxy_publish_last(sim_, step, time));
  }

  /// The counts of this stream. They are zeros where the stream is used wrongly.
  gxy_stat statistics() const noexcept {
    gxy_stat counts = gxy_stat();
    gxy_statistics(sim_, &counts);
    return counts;
  }

  /// The text about the last result, or about why there is no connection. It is valid until the next call.
  const char* message() const noexcept { return gxy_message(sim_); }

  /// Ends the stream, as gxy_close() does. Afterwards everything is wrong use. The destructor calls it.
  void close(double seconds = 5) noexcept {
    gxy_close(sim_, seconds);
    sim_ = nullptr;
  }

 private:
  gxy_sim* sim_;
  gxy_of of_ = GXY_OF_POINTS;
};

/// Values whose first owned one is at `firstOwned`, with strides in bytes by axis. The components of a point lie
/// `componentStride` bytes apart; 0 means that they stand together.
template <class T>
gxy_array strided(const T* firstOwned, const Simulation::Indices& strides, int components = 1,
                  std::int64_t componentStride = 0) noexcept {
  return gxy_array{
      firstOwned, insituType<T>(), components, {strides[0], strides[1], strides[2]}, componentStride, 0};
}

/// Values in an array without gaps of so many points by axis, ghosts included, x being the fastest. The components of a point stand
/// together. `firstOwned` points to the first owned value, which need not be the array's first.
template <class T>
gxy_array values(const T* firstOwned, const Simulation::Indices& size, int components = 1) noexcept {
  const std::int64_t point = std::int64_t(sizeof(T)) * components;
  return strided(firstOwned, {{point, point * size[0], point * size[0] * size[1]}}, components);
}

/// Values of particles, points or cells, one after the other. The components of one stand together. `stride`: the bytes from one to the
/// next; 0: there are no gaps.
template <class T>
gxy_array row(const T* first, int components = 1, std::int64_t stride = 0) noexcept {
  return strided(first, {{stride != 0 ? stride : std::int64_t(sizeof(T)) * components, 0, 0}}, components);
}

/// Types of cells that are all of this one.
inline gxy_array allOf(gxy_cell type) noexcept {
  static const std::uint8_t types[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14};
  return strided(&types[type], {{0, 0, 0}});
}

}  // namespace gxy

#endif
