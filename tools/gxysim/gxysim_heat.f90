! SPDX-License-Identifier: Apache-2.0
!
! gxysim_heat_f90 NX NY NZ STEPS FILE.npy NAME SECONDS [--world]: the simulation of heat.c, in Fortran 2003. The same steps, published in a stream
! NAME, and the same file in the end, to the bit. It waits SECONDS for the last step. With --world, ranks of `gxyserver --world` are in the same MPI job. heat.c says what is computed.
program gxysim_heat
  use mpi
  use galaxy_insitu
  use galaxy_insitu_mpi
  implicit none
  integer, parameter :: real8 = c_double
  integer :: whole(3), steps, world, comm, rank, ranks, blocks(3), first(3), own(3), step, level, a, e
  real(real8), allocatable, target :: T(:, :, :)
  real(real8), allocatable :: next(:, :, :), q(:, :, :)
  real(real8) :: c(3), dt
  character(len=1000) :: output, name, last
  type(c_ptr) :: g

  call MPI_Init_thread(MPI_THREAD_MULTIPLE, level, e)  ! for a server in these processes
  call get_command_argument(8, last)
  world = MPI_COMM_WORLD
  if (last == "--world") world = gxy_split_world()
  call MPI_Comm_rank(world, rank, e)
  call MPI_Comm_size(world, ranks, e)
  whole = [(argument(a), a = 1, 3)]
  steps = argument(4)
  call get_command_argument(5, output)
  call get_command_argument(6, name)
  blocks = 0
  call MPI_Dims_create(ranks, 3, blocks, e)
  call MPI_Cart_create(world, 3, blocks, [.false., .false., .false.], .false., comm, e)
  call box_of(rank, first, own)
  allocate (T(0:own(1) + 1, 0:own(2) + 1, 0:own(3) + 1))
  allocate (next(0:own(1) + 1, 0:own(2) + 1, 0:own(3) + 1), q(0:own(1) + 1, 0:own(2) + 1, 0:own(3) + 1))

  c = real(whole - 1, real8) * real(whole - 1, real8)
  dt = 0.45d0 / ((c(1) + c(2)) + c(3))
  c = dt * c
  call start()
  g = gxy_open_mpi(trim(name), comm)
  e = gxy_grid(g, "grid", 0, GXY_OF_POINTS, whole, first, own, [0d0, 0d0, 0d0], 1 / real(whole - 1, real8))
  e = gxy_field(g, "grid", 0, "temperature", GXY_OF_POINTS, gxy_values(T(1, 1, 1), shape(T)))
  do step = 1, steps
    call exchange()
    call advance()
    if (step < steps) e = gxy_publish(g, step, step * dt)
  end do
  e = gxy_publish_last(g, steps, steps * dt)
  call save_values()
  call gxy_close(g, real(argument(7), real8))
  if (last == "--world") call gxy_end_world()
  call MPI_Finalize(e)

contains

  integer function argument(number)
    integer, intent(in) :: number
    character(len=20) :: text
    call get_command_argument(number, text)
    read (text, *) argument
  end function argument

  ! What a rank owns: points are counted from 0.
  subroutine box_of(owner, begin, points)
    integer, intent(in) :: owner
    integer, intent(out) :: begin(3), points(3)
    integer :: place(3)
    call MPI_Cart_coords(comm, owner, 3, place, e)
    begin = whole * place / blocks
    points = whole * (place + 1) / blocks - begin
  end subroutine box_of

  real(real8) function ball(x, y, z, cx, cy, cz, radius)
    real(real8), intent(in) :: x, y, z, cx, cy, cz, radius
    real(real8) :: s
    s = 1 - (((x - cx) * (x - cx) + (y - cy) * (y - cy)) + (z - cz) * (z - cz)) / (radius * radius)
    ball = 0
    if (s > 0) ball = 64 * (s * s)
  end function ball

  subroutine start()
    integer :: i, j, k
    real(real8) :: x, y, z
    T = 0
    do k = 1, own(3)
      z = real(first(3) + k - 1, real8) / real(whole(3) - 1, real8)
      do j = 1, own(2)
        y = real(first(2) + j - 1, real8) / real(whole(2) - 1, real8)
        do i = 1, own(1)
          x = real(first(1) + i - 1, real8) / real(whole(1) - 1, real8)
          if (first(3) + k == 1) T(i, j, k) = 8 * ((x * (1 - x)) * (y * (1 - y)))
          q(i, j, k) = ball(x, y, z, 0.3d0, 0.4d0, 0.6d0, 0.2d0) + ball(x, y, z, 0.7d0, 0.65d0, 0.4d0, 0.15d0)
        end do
      end do
    end do
  end subroutine start

  ! One layer of T across an axis, with the ghosts of the other axes.
  function layer(axis, begin) result(made)
    integer, intent(in) :: axis, begin
    integer :: made, starts(3), counts(3)
    starts = 0
    counts = own + 2
    starts(axis) = begin
    counts(axis) = 1
    call MPI_Type_create_subarray(3, own + 2, counts, starts, MPI_ORDER_FORTRAN, MPI_DOUBLE_PRECISION, made, e)
    call MPI_Type_commit(made, e)
  end function layer

  subroutine exchange()
    integer :: axis, below, above, types(4), i
    do axis = 1, 3
      call MPI_Cart_shift(comm, axis - 1, 1, below, above, e)
      types = [layer(axis, 0), layer(axis, 1), layer(axis, own(axis)), layer(axis, own(axis) + 1)]
      call MPI_Sendrecv(T, 1, types(2), below, 0, T, 1, types(4), above, 0, comm, MPI_STATUS_IGNORE, e)
      call MPI_Sendrecv(T, 1, types(3), above, 1, T, 1, types(1), below, 1, comm, MPI_STATUS_IGNORE, e)
      do i = 1, 4
        call MPI_Type_free(types(i), e)
      end do
    end do
  end subroutine exchange

  subroutine advance()
    integer :: i, j, k, low(3), high(3)
    real(real8) :: two, flow
    low = max(1, 2 - first)
    high = min(own, whole - 1 - first)
    do k = low(3), high(3)
      do j = low(2), high(2)
        do i = low(1), high(1)
          two = 2 * T(i, j, k)
          flow = (c(1) * ((T(i - 1, j, k) + T(i + 1, j, k)) - two) + c(2) * ((T(i, j - 1, k) + T(i, j + 1, k)) - two)) &
            + c(3) * ((T(i, j, k - 1) + T(i, j, k + 1)) - two)
          next(i, j, k) = T(i, j, k) + (flow + dt * q(i, j, k))
        end do
      end do
    end do
    T(low(1):high(1), low(2):high(2), low(3):high(3)) = next(low(1):high(1), low(2):high(2), low(3):high(3))
  end subroutine advance

  subroutine save_values()
    real(real8), allocatable :: all(:, :, :)
    character(len=117) :: description
    integer :: request, box, part, begin(3), points(3)
    call MPI_Type_create_subarray(3, own + 2, own, [1, 1, 1], MPI_ORDER_FORTRAN, MPI_DOUBLE_PRECISION, part, e)
    call MPI_Type_commit(part, e)
    call MPI_Isend(T, 1, part, 0, 2, comm, request, e)
    if (rank == 0) then
      allocate (all(whole(1), whole(2), whole(3)))
      do a = 0, ranks - 1
        call box_of(a, begin, points)
        call MPI_Type_create_subarray(3, whole, points, begin, MPI_ORDER_FORTRAN, MPI_DOUBLE_PRECISION, box, e)
        call MPI_Type_commit(box, e)
        call MPI_Recv(all, 1, box, a, 2, comm, MPI_STATUS_IGNORE, e)
        call MPI_Type_free(box, e)
      end do
      write (description, "(a, i0, a, i0, a, i0, a)") "{'descr': '<f8', 'fortran_order': False, 'shape': (", whole(3), ", ", &
        whole(2), ", ", whole(1), "), }"
      open (10, file=output, access="stream", form="unformatted", status="replace", action="write")
      write (10) char(147) // "NUMPY" // char(1) // char(0) // char(118) // char(0) // description // char(10)
      write (10) all
      close (10)
    end if
    call MPI_Wait(request, MPI_STATUS_IGNORE, e)
    call MPI_Type_free(part, e)
  end subroutine save_values
end program gxysim_heat
