! SPDX-License-Identifier: Apache-2.0
! The interface for Fortran without a server. Ends with an error that says what is wrong.
program fortran_test
  use galaxy_insitu
  use, intrinsic :: iso_c_binding
  implicit none
  real(c_double), target :: whole(6, 5, 4), positions(3, 2)
  real(c_float), target :: vectors(3, 4, 3, 2)
  integer(c_int32_t), target :: numbers(4, 3, 2)
  integer(c_int64_t), target :: long_numbers(2)
  type(gxy_array) :: a
  type(gxy_stat) :: s
  type(c_ptr) :: sim
  integer :: e

  call check(gxy_version() == 1, "the version is not 1")

  a = gxy_values(whole(2, 2, 2), shape(whole))
  call check(c_associated(a%data, c_loc(whole(2, 2, 2))), "the data of an array with ghosts begin elsewhere")
  call check(a%type == GXY_FLOAT64 .and. a%components == 1 .and. a%memory == 0, "float64 is something else")
  call check(all(a%stride == [8, 48, 240]), "strides of an array with ghosts")
  a = gxy_values(vectors(1, 1, 1, 1), shape(vectors))
  call check(a%type == GXY_FLOAT32 .and. a%components == 3 .and. a%component_stride == 0, "float32 vectors")
  call check(all(a%stride == [12, 48, 144]), "strides of vectors")
  a = gxy_values(numbers(1, 1, 1), shape(numbers))
  call check(a%type == GXY_INT32 .and. all(a%stride == [4, 16, 48]), "int32")

  sim = gxy_open("heat", 0, 1)
  e = gxy_grid(sim, "grid", 0, GXY_OF_POINTS, [4, 3, 2], [0, 0, 0], [4, 3, 2])
  call check(e == GXY_TAKEN, "a grid is not taken")
  e = gxy_field(sim, "grid", 0, "number  ", GXY_OF_POINTS, gxy_values(numbers(1, 1, 1), shape(numbers)))
  call check(e == GXY_TAKEN, "a field is not taken")
  e = gxy_field(sim, "grid", 0, "flat", GXY_OF_POINTS, gxy_values(numbers(1, 1, 1), [24]))
  call check(e == GXY_WRONG, "an array of rank 1 is taken")
  call check(index(gxy_message(sim), "stride[1] is 0") > 0, gxy_message(sim))
  e = gxy_points(sim, "grid", 2, gxy_values(positions(1, 1), shape(positions)))
  call check(e == GXY_WRONG, "a grid that has particles is taken")
  call check(gxy_message(sim) == 'gxy_points, "grid": this mesh is a grid, expected another name', gxy_message(sim))
  a = gxy_values(positions(1, 1), shape(positions))
  call check(a%components == 3 .and. all(a%stride == [24, 0, 0]), "positions")
  e = gxy_points(sim, "atoms", 2, a, gxy_values(numbers(1, 1, 1), [2]), [0d0, 0d0, 0d0, 1d0, 1d0, 1d0])
  call check(e == GXY_TAKEN, "particles are not taken: " // gxy_message(sim))
  e = gxy_points(sim, "atoms", 0_c_int64_t, a)
  call check(e == GXY_TAKEN, "no particles are not taken: " // gxy_message(sim))
  e = gxy_points(sim, "atoms", 1, a, box=[0d0, 0d0, 2d0, 1d0, 1d0, 1d0])
  call check(e == GXY_WRONG, "an empty box is taken")
  call check(index(gxy_message(sim), "the box is empty") > 0, gxy_message(sim))
  e = gxy_field(sim, "atoms", 0, "mass", GXY_OF_POINTS, gxy_values(positions(1, 1), [2]))
  call check(e == GXY_TAKEN, "a field of particles is not taken: " // gxy_message(sim))
  e = gxy_cells(sim, "surface", 2, a, 1, gxy_all_of(GXY_LINE), gxy_values(numbers(1, 1, 1), [2]))
  call check(e == GXY_TAKEN, "lines are not taken: " // gxy_message(sim))
  e = gxy_cells(sim, "surface", 2, a, 1, gxy_all_of(GXY_POLY_LINE), gxy_values(numbers(1, 1, 1), [2]), &
    gxy_values(long_numbers(1), [2]))
  call check(e == GXY_TAKEN, "lines with offsets are not taken: " // gxy_message(sim))
  e = gxy_cells(sim, "surface", 2_c_int64_t, a, 1_c_int64_t, gxy_all_of(82), gxy_values(numbers(1, 1, 1), [2]))
  call check(e == GXY_WRONG, "cells without a type are taken")
  e = gxy_cells(sim, "surface", 2, a, 1, gxy_all_of(24), gxy_values(numbers(1, 1, 1), [2]))
  call check(e == GXY_WRONG, "quadratic cells are taken")
  call check(index(gxy_message(sim), "24 (quadratic tetrahedra)") > 0, gxy_message(sim))
  e = gxy_cells(sim, "volume", 2, a, 1, gxy_all_of(GXY_PYRAMID), gxy_values(numbers(1, 1, 1), [5]))
  call check(e == GXY_TAKEN, "a pyramid is not taken: " // gxy_message(sim))
  e = gxy_field(sim, "volume", 0, "load", GXY_OF_CELLS, gxy_values(long_numbers(1), [1]))
  call check(e == GXY_TAKEN, "a field of cells with a volume is not taken: " // gxy_message(sim))
  e = gxy_field(sim, "surface", 0, "region", GXY_OF_CELLS, gxy_values(long_numbers(1), [2]))
  call check(e == GXY_TAKEN, "a field of cells is not taken: " // gxy_message(sim))
  call check(gxy_publish(sim, 1, 0.5d0) == GXY_OFF, "a step is not off")
  call check(gxy_publish_last(sim, 2_c_int64_t, 1d0) == GXY_OFF, "the last step is not off")
  call check(gxy_message(sim) == "", "there is a message: " // gxy_message(sim))
  call gxy_close(sim, 0d0)

  sim = gxy_open("heat", 0, 1, '{"to": "127.0.0.1:1", "token-file": "-"}  ')
  e = gxy_grid(sim, "grid", 0, GXY_OF_CELLS, [4_c_int64_t, 3_c_int64_t, 2_c_int64_t], [0_c_int64_t, 0_c_int64_t, 0_c_int64_t], &
    [4_c_int64_t, 3_c_int64_t, 2_c_int64_t], [1d0, 2d0, 3d0], [1d0, 1d0, 2d0])
  call check(e == GXY_TAKEN, "a grid with 64 bits is not taken: " // gxy_message(sim))
  e = gxy_field(sim, "grid", 0, "velocity", GXY_OF_CELLS, gxy_values(vectors(1, 1, 1, 1), shape(vectors)))
  call check(e == GXY_TAKEN, "vectors are not taken: " // gxy_message(sim))
  call check(gxy_skip(sim, 0_c_int64_t, 0d0) == GXY_LOST, "a skipped step is not lost")
  call check(gxy_wanted(sim, 1_c_int64_t, 0.5d0) == 0, "a step is wanted")
  call check(gxy_wanted_settle(sim, 1_c_int64_t, 1) == GXY_TAKEN, "what ranks agree on is wrong")
  call check(gxy_steered(sim, "dt", whole(1, 1, 1)) == GXY_WRONG, "what is not declared is steered")
  call check(gxy_publish(sim, 1_c_int64_t, 0.5d0) == GXY_LOST, "a step is not lost")
  e = gxy_statistics(sim, s)
  call check(e == GXY_TAKEN .and. s%offered == 2 .and. s%taken == 0, "statistics")
  call gxy_close(sim, 0d0)

contains

  subroutine check(holds, otherwise)
    logical, intent(in) :: holds
    character(len=*), intent(in) :: otherwise
    if (holds) return
    print *, otherwise
    stop 1
  end subroutine check
end program fortran_test
