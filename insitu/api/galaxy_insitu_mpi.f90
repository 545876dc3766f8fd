! SPDX-License-Identifier: Apache-2.0
!
! galaxy_insitu_mpi.h for Fortran 2003: what simulations with MPI can use beside the module galaxy_insitu. That header says what the
! functions do, and docs/insitu.md is the guide. It is shipped as source, and compiled with the simulation's own MPI after
! galaxy_insitu.f90.
!
! Communicators are integers, as of the module mpi. With mpi_f08, give comm%MPI_VAL, and take world%MPI_VAL = gxy_split_world().
module galaxy_insitu_mpi
  use, intrinsic :: iso_c_binding
  use mpi
  implicit none
  private

  public :: gxy_open_mpi, gxy_split_world, gxy_end_world

  interface
    function c_prepare(options, library) result(able) bind(c, name="gxy_prepare_here")
      import :: c_ptr, c_char, c_int
      type(c_ptr), value :: options
      character(kind=c_char), intent(in) :: library(*)
      integer(c_int) :: able
    end function c_prepare

    function c_open(name, rank, ranks, options) result(sim) bind(c, name="gxy_open")
      import :: c_ptr, c_char, c_int
      character(kind=c_char), intent(in) :: name(*)
      integer(c_int), value :: rank, ranks
      type(c_ptr), value :: options
      type(c_ptr) :: sim
    end function c_open

    function c_open_here(name, rank, ranks, options, comm) result(sim) bind(c, name="gxy_open_here_fortran")
      import :: c_ptr, c_char, c_int
      character(kind=c_char), intent(in) :: name(*)
      integer(c_int), value :: rank, ranks
      type(c_ptr), value :: options, comm
      type(c_ptr) :: sim
    end function c_open_here

    subroutine c_set_here(address, token) bind(c, name="gxy_set_here")
      import :: c_char
      character(kind=c_char), intent(in) :: address(*), token(*)
    end subroutine c_set_here
  end interface

contains

  ! As gxy_open, with rank and ranks of a communicator. Collective. If "to" is "here", a server runs in these processes from then on,
  ! until the last stream that was opened so is closed: gxy_close is collective then, and comes before MPI_Finalize. MPI needs
  ! MPI_THREAD_MULTIPLE for that.
  function gxy_open_mpi(name, comm, options) result(sim)
    character(len=*), intent(in) :: name
    integer, intent(in) :: comm
    character(len=*), intent(in), optional :: options
    type(c_ptr) :: sim
    character(len=MPI_MAX_LIBRARY_VERSION_STRING) :: library
    character(kind=c_char), allocatable, target :: letters(:)
    type(c_ptr) :: given
    integer :: rank, ranks, length, able(2), all_able(2), i, e
    integer(c_int), target :: handle
    given = c_null_ptr
    if (present(options)) then
      allocate (letters(len_trim(options) + 1))
      letters = c_null_char
      do i = 1, len_trim(options)
        letters(i) = options(i:i)
      end do
      if (size(letters) > 1) given = c_loc(letters)
    end if
    call MPI_Comm_rank(comm, rank, e)
    call MPI_Comm_size(comm, ranks, e)
    call MPI_Get_library_version(library, length, e)
    able(1) = c_prepare(given, library(1:length) // c_null_char)
    able(2) = -able(1)
    call MPI_Allreduce(able, all_able, 2, MPI_INTEGER, MPI_MIN, comm, e)
    if (all_able(1) == 0 .and. all_able(2) == 0) then
      sim = c_open(trim(name) // c_null_char, rank, ranks, given)
    else if (all_able(1) == 1) then
      handle = comm
      sim = c_open_here(trim(name) // c_null_char, rank, ranks, given, c_loc(handle))
    else
      sim = c_open_here(trim(name) // c_null_char, rank, ranks, given, c_null_ptr)
    end if
  end function gxy_open_mpi

  ! For one MPI world, `mpirun -np M simulation : -np N gxyserver --world`: returns a communicator of the simulation's ranks, which
  ! stands in for MPI_COMM_WORLD from then on, and waits until the server listens. Collective over all ranks of the simulation, once, after
  ! MPI_Init. Only in such a world.
  function gxy_split_world() result(mine)
    integer :: mine, rank, server, root, e
    integer, parameter :: length = 512
    character(kind=c_char) :: texts(2 * length)
    texts = c_null_char
    server = huge(0_c_int)
    call MPI_Comm_rank(MPI_COMM_WORLD, rank, e)
    call MPI_Comm_split(MPI_COMM_WORLD, 0, rank, mine, e)
    call MPI_Allreduce(server, root, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD, e)
    call MPI_Bcast(texts, size(texts), MPI_CHAR, root, MPI_COMM_WORLD, e)
    call c_set_here(texts(1:length), texts(length + 1:))
  end function gxy_split_world

  ! Ends the server of such a world. Collective over all ranks of the simulation, after their last gxy_close and before MPI_Finalize.
  subroutine gxy_end_world()
    integer :: all_ranks, e
    call MPI_Ibarrier(MPI_COMM_WORLD, all_ranks, e)
    call MPI_Wait(all_ranks, MPI_STATUS_IGNORE, e)
  end subroutine gxy_end_world
end module galaxy_insitu_mpi
