! SPDX-License-Identifier: Apache-2.0
program wave
  use mpi
  use galaxy_insitu
  implicit none
  integer :: rank, ranks, begin, layers, step, i, j, k, e
  real(c_double), allocatable, target :: height(:, :, :), x(:)  ! each rank has a slab of the height along z
  type(c_ptr) :: sim

  call MPI_Init(e); call MPI_Comm_rank(MPI_COMM_WORLD, rank, e); call MPI_Comm_size(MPI_COMM_WORLD, ranks, e)
  begin = 32 * rank / ranks; layers = 32 * (rank + 1) / ranks - begin; allocate (height(48, 40, layers))
  sim = gxy_open("wave", rank, ranks)
  e = gxy_grid(sim, "grid", 0, GXY_OF_POINTS, [48, 40, 32], [0, 0, begin], [48, 40, layers])
  e = gxy_field(sim, "grid", 0, "height", GXY_OF_POINTS, gxy_values(height(1, 1, 1), shape(height)))
  do step = 1, 8
    x = [(0.03125d0 * (i - 3 * step), i = 0, 47)]
    forall (j = 1:40, k = 1:layers) height(:, j, k) = x - x * x * x + 0.03125d0 * (j - k - begin)
    if (step < 8) e = gxy_publish(sim, step, 0.125d0 * step)
  end do
  e = gxy_publish_last(sim, 8, 1d0)
  call gxy_close(sim, 10d0); call MPI_Finalize(e)
end program wave
