! SPDX-License-Identifier: Apache-2.0
!
! The interface of galaxy_insitu.h for Fortran 2003. That header says what the functions do, and docs/insitu.md is the guide.
! It is shipped as source, since compiled modules fit one compiler only: compile it with the simulation, and link
! libgalaxy_insitu.
!
! Texts are plain strings: blanks at their ends are left out, and the ending C_NULL_CHAR is added here. Functions return one of
! GXY_TAKEN, GXY_NOT_TAKEN, GXY_OFF, GXY_LOST and GXY_WRONG. Indices that are told to gxy_grid count from 0, as in C.
module galaxy_insitu
  use, intrinsic :: iso_c_binding
  implicit none
  private

  public :: gxy_version, gxy_open, gxy_grid, gxy_points, gxy_cells, gxy_all_of, gxy_field, gxy_values, gxy_publish, gxy_publish_last
  public :: gxy_skip, gxy_wanted, gxy_wanted_settle, gxy_steered
  public :: gxy_statistics, gxy_message, gxy_close
  public :: c_ptr, c_int64_t, c_double

  ! Results.
  integer(c_int), parameter, public :: GXY_TAKEN = 0, GXY_NOT_TAKEN = 1, GXY_OFF = 2, GXY_LOST = 3, GXY_WRONG = -1
  ! Types of values.
  integer(c_int), parameter, public :: GXY_INT8 = 0, GXY_UINT8 = 1, GXY_INT16 = 2, GXY_UINT16 = 3, GXY_INT32 = 4, &
    GXY_UINT32 = 5, GXY_INT64 = 6, GXY_UINT64 = 7, GXY_FLOAT32 = 8, GXY_FLOAT64 = 9
  ! What a decomposition counts and what a field has values of.
  integer(c_int), parameter, public :: GXY_OF_POINTS = 0, GXY_OF_CELLS = 1

  ! Types of the cells that gxy_cells takes. The numbers are those of VTK.
  integer(c_int), parameter, public :: GXY_LINE = 3, GXY_POLY_LINE = 4, GXY_TRIANGLE = 5, GXY_TRIANGLE_STRIP = 6, &
    GXY_POLYGON = 7, GXY_PIXEL = 8, GXY_QUAD = 9, GXY_TETRAHEDRON = 10, GXY_VOXEL = 11, GXY_HEXAHEDRON = 12, GXY_WEDGE = 13, &
    GXY_PYRAMID = 14
  ! All types of VTK, so that those that are not taken are named where they are wrong.
  integer(c_int) :: cell_type_number
  integer(c_int), save, target :: cell_types(81) = [(cell_type_number, cell_type_number = 1, 81)]

  ! Where the values of a field lie. gxy_values makes it for arrays of the commonest types.
  type, bind(c), public :: gxy_array
    type(c_ptr) :: data
    integer(c_int) :: type
    integer(c_int) :: components
    integer(c_int64_t) :: stride(3)
    integer(c_int64_t) :: component_stride
    integer(c_int) :: memory
  end type gxy_array

  ! Counts of a stream, and seconds.
  type, bind(c), public :: gxy_stat
    integer(c_int64_t) :: offered, taken, published, bytes
    real(c_double) :: publish_seconds, longest_seconds
  end type gxy_stat

  ! gxy_values(FIRST, SHAPE) describes an array without gaps. FIRST is its first owned element, SHAPE that of the whole array,
  ! ghosts included: gxy_values(energy(1, 1, 1), shape(energy)). In a shape of rank 4, the first dimension counts components.
  ! Arrays of particles and of cells have rank 1, or rank 2 with components first: gxy_values(x(1, 1), shape(x)) for x(3, n). Without
  ! particles or cells, give any element.
  ! The array stays where it is until the next gxy_field or gxy_close, and has the attribute target: else the compiler may think
  ! that nobody reads it in gxy_publish.
  interface gxy_values
    module procedure values_float64, values_float32, values_int32, values_int64
  end interface gxy_values

  ! gxy_grid(SIM, MESH, BLOCK, OF, SIZE, FIRST, COUNT, ORIGIN, SPACING), with indices of 32 or of 64 bits. Without
  ! ORIGIN and SPACING, the grid begins at 0, 0, 0, and its spacing is 1. Called again, it changes what the rank owns from the next publish on.
  interface gxy_grid
    module procedure grid_int32, grid_int64
  end interface gxy_grid

  ! gxy_points(SIM, MESH, COUNT, POSITIONS, IDS, BOX), with a count of 32 or of 64 bits. IDS and BOX may be left out.
  interface gxy_points
    module procedure points_int32, points_int64
  end interface gxy_points

  ! gxy_cells(SIM, MESH, POINTS, POSITIONS, CELLS, TYPES, CONNECTIVITY, OFFSETS), with counts of 32 or of 64 bits. OFFSETS may be left out
  ! for cells of one type with a fixed number of points: gxy_all_of(GXY_TRIANGLE) as TYPES. CONNECTIVITY counts points from 0. A
  ! connectivity of rank 2, as triangles(3, n), is given with its size: gxy_values(triangles(1, 1), [3 * n]).
  interface gxy_cells
    module procedure cells_int32, cells_int64
  end interface gxy_cells

  ! gxy_publish(SIM, STEP, TIME), with a step of 32 or of 64 bits.
  interface gxy_publish
    module procedure publish_int32
    function publish_int64(sim, step, time) result(taken) bind(c, name="gxy_publish")
      import :: c_ptr, c_int, c_int64_t, c_double
      type(c_ptr), value :: sim
      integer(c_int64_t), value :: step
      real(c_double), value :: time
      integer(c_int) :: taken
    end function publish_int64
  end interface gxy_publish

  ! gxy_publish_last(SIM, STEP, TIME), likewise.
  interface gxy_publish_last
    module procedure publish_last_int32
    function publish_last_int64(sim, step, time) result(taken) bind(c, name="gxy_publish_last")
      import :: c_ptr, c_int, c_int64_t, c_double
      type(c_ptr), value :: sim
      integer(c_int64_t), value :: step
      real(c_double), value :: time
      integer(c_int) :: taken
    end function publish_last_int64
  end interface gxy_publish_last

  interface
    function gxy_version() result(version) bind(c, name="gxy_version")
      import :: c_int
      integer(c_int) :: version
    end function gxy_version

    function gxy_statistics(sim, statistics) result(taken) bind(c, name="gxy_statistics")
      import :: c_ptr, c_int, gxy_stat
      type(c_ptr), value :: sim
      type(gxy_stat), intent(out) :: statistics
      integer(c_int) :: taken
    end function gxy_statistics

    function gxy_skip(sim, step, time) result(taken) bind(c, name="gxy_skip")
      import :: c_ptr, c_int, c_int64_t, c_double
      type(c_ptr), value :: sim
      integer(c_int64_t), value :: step
      real(c_double), value :: time
      integer(c_int) :: taken
    end function gxy_skip

    function gxy_wanted(sim, step, time) result(wanted) bind(c, name="gxy_wanted")
      import :: c_ptr, c_int, c_int64_t, c_double
      type(c_ptr), value :: sim
      integer(c_int64_t), value :: step
      real(c_double), value :: time
      integer(c_int) :: wanted
    end function gxy_wanted

    function gxy_wanted_settle(sim, step, any_rank) result(taken) bind(c, name="gxy_wanted_settle")
      import :: c_ptr, c_int, c_int64_t
      type(c_ptr), value :: sim
      integer(c_int64_t), value :: step
      integer(c_int), value :: any_rank
      integer(c_int) :: taken
    end function gxy_wanted_settle

    subroutine gxy_close(sim, seconds) bind(c, name="gxy_close")
      import :: c_ptr, c_double
      type(c_ptr), value :: sim
      real(c_double), value :: seconds
    end subroutine gxy_close

    function c_open(name, rank, ranks, options) result(sim) bind(c, name="gxy_open")
      import :: c_ptr, c_char, c_int
      character(kind=c_char), intent(in) :: name(*)
      type(c_ptr), value :: options
      integer(c_int), value :: rank, ranks
      type(c_ptr) :: sim
    end function c_open

    function c_grid(sim, mesh, block, of, size, first, count, origin, spacing) result(taken) bind(c, name="gxy_grid")
      import :: c_ptr, c_char, c_int, c_int64_t, c_double
      type(c_ptr), value :: sim
      character(kind=c_char), intent(in) :: mesh(*)
      integer(c_int), value :: block, of
      integer(c_int64_t), intent(in) :: size(3), first(3), count(3)
      real(c_double), intent(in) :: origin(3), spacing(3)
      integer(c_int) :: taken
    end function c_grid

    function c_field(sim, mesh, block, field, of, values) result(taken) bind(c, name="gxy_field")
      import :: c_ptr, c_char, c_int, gxy_array
      type(c_ptr), value :: sim
      character(kind=c_char), intent(in) :: mesh(*), field(*)
      integer(c_int), value :: block, of
      type(gxy_array), value :: values
      integer(c_int) :: taken
    end function c_field

    function c_points(sim, mesh, count, positions, ids, box) result(taken) bind(c, name="gxy_points")
      import :: c_ptr, c_char, c_int, c_int64_t, gxy_array
      type(c_ptr), value :: sim
      character(kind=c_char), intent(in) :: mesh(*)
      integer(c_int64_t), value :: count
      type(gxy_array), value :: positions, ids
      type(c_ptr), value :: box
      integer(c_int) :: taken
    end function c_points

    function c_cells(sim, mesh, points, positions, cells, types, offsets, connectivity) result(taken) bind(c, name="gxy_cells")
      import :: c_ptr, c_char, c_int, c_int64_t, gxy_array
      type(c_ptr), value :: sim
      character(kind=c_char), intent(in) :: mesh(*)
      integer(c_int64_t), value :: points, cells
      type(gxy_array), value :: positions, types, offsets, connectivity
      integer(c_int) :: taken
    end function c_cells

    function c_steered(sim, parameter, value) result(changed) bind(c, name="gxy_steered")
      import :: c_ptr, c_char, c_int, c_double
      type(c_ptr), value :: sim
      character(kind=c_char), intent(in) :: parameter(*)
      real(c_double), intent(inout) :: value
      integer(c_int) :: changed
    end function c_steered

    function c_message(sim) result(text) bind(c, name="gxy_message")
      import :: c_ptr
      type(c_ptr), value :: sim
      type(c_ptr) :: text
    end function c_message

    function c_length(text) result(length) bind(c, name="strlen")
      import :: c_ptr, c_size_t
      type(c_ptr), value :: text
      integer(c_size_t) :: length
    end function c_length
  end interface

contains

  ! A text as C has it.
  function in_c(text) result(ended)
    character(len=*), intent(in) :: text
    character(kind=c_char, len=:), allocatable :: ended
    ended = trim(text) // c_null_char
  end function in_c

  ! Begins the stream `name` on rank `rank` of `ranks`. `options` is a JSON object; it may be left out or blank.
  function gxy_open(name, rank, ranks, options) result(sim)
    character(len=*), intent(in) :: name
    integer(c_int), intent(in) :: rank, ranks
    character(len=*), intent(in), optional :: options
    type(c_ptr) :: sim
    character(kind=c_char), allocatable, target :: letters(:)
    character(kind=c_char, len=:), allocatable :: given
    integer :: i
    given = in_c("")
    if (present(options)) given = in_c(options)
    allocate (letters(len(given)))
    do i = 1, len(given)
      letters(i) = given(i:i)
    end do
    if (letters(1) == c_null_char) then
      sim = c_open(in_c(name), rank, ranks, c_null_ptr)
    else
      sim = c_open(in_c(name), rank, ranks, c_loc(letters))
    end if
  end function gxy_open

  function grid_int64(sim, mesh, block, of, size, first, count, origin, spacing) result(taken)
    type(c_ptr), intent(in) :: sim
    character(len=*), intent(in) :: mesh
    integer(c_int), intent(in) :: block, of
    integer(c_int64_t), intent(in) :: size(3), first(3), count(3)
    real(c_double), intent(in), optional :: origin(3), spacing(3)
    integer(c_int) :: taken
    real(c_double) :: begin(3), between(3)
    begin = 0
    between = 1
    if (present(origin)) begin = origin
    if (present(spacing)) between = spacing
    taken = c_grid(sim, in_c(mesh), block, of, size, first, count, begin, between)
  end function grid_int64

  function grid_int32(sim, mesh, block, of, size, first, count, origin, spacing) result(taken)
    type(c_ptr), intent(in) :: sim
    character(len=*), intent(in) :: mesh
    integer(c_int), intent(in) :: block, of
    integer(c_int32_t), intent(in) :: size(3), first(3), count(3)
    real(c_double), intent(in), optional :: origin(3), spacing(3)
    integer(c_int) :: taken
    taken = grid_int64(sim, mesh, block, of, int(size, c_int64_t), int(first, c_int64_t), int(count, c_int64_t), &
      origin, spacing)
  end function grid_int32

  function gxy_field(sim, mesh, block, field, of, values) result(taken)
    type(c_ptr), intent(in) :: sim
    character(len=*), intent(in) :: mesh, field
    integer(c_int), intent(in) :: block, of
    type(gxy_array), intent(in) :: values
    integer(c_int) :: taken
    taken = c_field(sim, in_c(mesh), block, in_c(field), of, values)
  end function gxy_field

  function points_int64(sim, mesh, count, positions, ids, box) result(taken)
    type(c_ptr), intent(in) :: sim
    character(len=*), intent(in) :: mesh
    integer(c_int64_t), intent(in) :: count
    type(gxy_array), intent(in) :: positions
    type(gxy_array), intent(in), optional :: ids
    real(c_double), intent(in), optional :: box(6)
    integer(c_int) :: taken
    type(gxy_array) :: numbers
    real(c_double), target :: domain(6)
    type(c_ptr) :: where_to
    numbers = gxy_array(c_null_ptr, 0, 0, 0_c_int64_t, 0_c_int64_t, 0)
    where_to = c_null_ptr
    if (present(ids)) numbers = ids
    if (present(box)) then
      domain = box
      where_to = c_loc(domain)
    end if
    taken = c_points(sim, in_c(mesh), count, positions, numbers, where_to)
  end function points_int64

  function points_int32(sim, mesh, count, positions, ids, box) result(taken)
    type(c_ptr), intent(in) :: sim
    character(len=*), intent(in) :: mesh
    integer(c_int32_t), intent(in) :: count
    type(gxy_array), intent(in) :: positions
    type(gxy_array), intent(in), optional :: ids
    real(c_double), intent(in), optional :: box(6)
    integer(c_int) :: taken
    taken = points_int64(sim, mesh, int(count, c_int64_t), positions, ids, box)
  end function points_int32

  function cells_int64(sim, mesh, points, positions, cells, types, connectivity, offsets) result(taken)
    type(c_ptr), intent(in) :: sim
    character(len=*), intent(in) :: mesh
    integer(c_int64_t), intent(in) :: points, cells
    type(gxy_array), intent(in) :: positions, types, connectivity
    type(gxy_array), intent(in), optional :: offsets
    integer(c_int) :: taken
    type(gxy_array) :: begins
    begins = gxy_array(c_null_ptr, 0, 0, 0_c_int64_t, 0_c_int64_t, 0)
    if (present(offsets)) begins = offsets
    taken = c_cells(sim, in_c(mesh), points, positions, cells, types, begins, connectivity)
  end function cells_int64

  function cells_int32(sim, mesh, points, positions, cells, types, connectivity, offsets) result(taken)
    type(c_ptr), intent(in) :: sim
    character(len=*), intent(in) :: mesh
    integer(c_int32_t), intent(in) :: points, cells
    type(gxy_array), intent(in) :: positions, types, connectivity
    type(gxy_array), intent(in), optional :: offsets
    integer(c_int) :: taken
    taken = cells_int64(sim, mesh, int(points, c_int64_t), positions, int(cells, c_int64_t), types, connectivity, offsets)
  end function cells_int32

  ! Types of cells that are all of this one.
  function gxy_all_of(cell_type) result(types)
    integer(c_int), intent(in) :: cell_type
    type(gxy_array) :: types
    types = gxy_array(c_null_ptr, GXY_INT32, 1, 0_c_int64_t, 0_c_int64_t, 0)
    if (cell_type >= 1 .and. cell_type <= size(cell_types)) types%data = c_loc(cell_types(cell_type))
  end function gxy_all_of

  ! 1 if somebody has given a parameter another value since the last call: VALUE has it then.
  function gxy_steered(sim, parameter_name, value) result(changed)
    type(c_ptr), intent(in) :: sim
    character(len=*), intent(in) :: parameter_name
    real(c_double), intent(inout) :: value
    integer(c_int) :: changed
    changed = c_steered(sim, in_c(parameter_name), value)
  end function gxy_steered

  ! The text about the last result, or about why there is no connection.
  function gxy_message(sim) result(message)
    type(c_ptr), intent(in) :: sim
    character(len=:), allocatable :: message
    character(kind=c_char), pointer :: letters(:)
    type(c_ptr) :: text
    integer :: i
    text = c_message(sim)
    call c_f_pointer(text, letters, [c_length(text)])
    allocate (character(len=size(letters)) :: message)
    do i = 1, size(letters)
      message(i:i) = letters(i)
    end do
  end function gxy_message

  function publish_int32(sim, step, time) result(taken)
    type(c_ptr), intent(in) :: sim
    integer(c_int32_t), intent(in) :: step
    real(c_double), intent(in) :: time
    integer(c_int) :: taken
    taken = publish_int64(sim, int(step, c_int64_t), time)
  end function publish_int32

  function publish_last_int32(sim, step, time) result(taken)
    type(c_ptr), intent(in) :: sim
    integer(c_int32_t), intent(in) :: step
    real(c_double), intent(in) :: time
    integer(c_int) :: taken
    taken = publish_last_int64(sim, int(step, c_int64_t), time)
  end function publish_last_int32

  function values_float64(first, shape_of_array) result(values)
    real(c_double), intent(in), target :: first
    integer, intent(in) :: shape_of_array(:)
    type(gxy_array) :: values
    values = without_gaps(c_loc(first), GXY_FLOAT64, 8_c_int64_t, shape_of_array)
  end function values_float64

  function values_float32(first, shape_of_array) result(values)
    real(c_float), intent(in), target :: first
    integer, intent(in) :: shape_of_array(:)
    type(gxy_array) :: values
    values = without_gaps(c_loc(first), GXY_FLOAT32, 4_c_int64_t, shape_of_array)
  end function values_float32

  function values_int32(first, shape_of_array) result(values)
    integer(c_int32_t), intent(in), target :: first
    integer, intent(in) :: shape_of_array(:)
    type(gxy_array) :: values
    values = without_gaps(c_loc(first), GXY_INT32, 4_c_int64_t, shape_of_array)
  end function values_int32

  function values_int64(first, shape_of_array) result(values)
    integer(c_int64_t), intent(in), target :: first
    integer, intent(in) :: shape_of_array(:)
    type(gxy_array) :: values
    values = without_gaps(c_loc(first), GXY_INT64, 8_c_int64_t, shape_of_array)
  end function values_int64

  ! Of a grid, an array of a shape of rank 3, or of rank 4 with components first. Of particles, one of rank 1, or of rank 2 with
  ! components first. Any other shape gives strides of 0, which are refused.
  pure function without_gaps(data, type, bytes, shape_of_array) result(values)
    type(c_ptr), intent(in) :: data
    integer(c_int), intent(in) :: type
    integer(c_int64_t), intent(in) :: bytes
    integer, intent(in) :: shape_of_array(:)
    type(gxy_array) :: values
    integer :: axes
    axes = size(shape_of_array)
    values = gxy_array(data, type, 1, 0_c_int64_t, 0_c_int64_t, 0)
    if (axes > 4 .or. axes < 1) return
    if (axes == 4 .or. axes == 2) values%components = int(shape_of_array(1), c_int)
    values%stride(1) = bytes * values%components
    if (axes < 3) return
    values%stride(2) = values%stride(1) * shape_of_array(axes - 2)
    values%stride(3) = values%stride(2) * shape_of_array(axes - 1)
  end function without_gaps
end module galaxy_insitu
