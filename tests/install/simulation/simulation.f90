! SPDX-License-Identifier: Apache-2.0
! Ends with 0 if publishing is off, as asked for.
program simulation
  use galaxy_insitu
  implicit none
  real(8), target :: values(2, 2, 2)
  type(c_ptr) :: sim
  integer :: e, result
  values = 0
  sim = gxy_open("installed", 0, 1)
  e = gxy_grid(sim, "grid", 0, GXY_OF_POINTS, [2, 2, 2], [0, 0, 0], [2, 2, 2])
  e = gxy_field(sim, "grid", 0, "value", GXY_OF_POINTS, gxy_values(values(1, 1, 1), shape(values)))
  result = gxy_publish(sim, 1, 0.5d0)
  call gxy_close(sim, 0d0)
  if (result /= GXY_OFF) stop 1
end program simulation
