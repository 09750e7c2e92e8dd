!> Cases that are ready to be integrated, and runs whose rows are in memory: what other languages hold of the core.
module prepared_cases
  use case, only: case_type, text_length
  use case_check, only: check_case
  use case_reader, only: read_case
  use errors, only: error_type, refuse
  use kinds, only: dp
  use places, only: find_file
  use progress, only: monitor_type
  use row_sink, only: row_writer
  use run_monitor, only: run_type
  use run_setup, only: set_wheelset, setup_type
  use run_tables, only: free_tables, keep_tables
  use simulation, only: prepare, simulate
  use text, only: checksum, line_type, read_lines, str
  implicit none
  private
  public :: prepared_type, row_list, finished_type, located, read_lines_of_case, prepare_located, adapt, simulate_prepared, &
    release, rename, paths_of

  !> A case, ready to be integrated.
  type :: prepared_type
    type(case_type) :: c
    type(setup_type) :: setup
    logical :: owns_table = .false.
  end type prepared_type

  !> All rows, in memory.
  type, extends(row_writer) :: row_list
    integer :: n = 0
    real(dp), allocatable :: values(:, :)   !! (column, row), the first n of them
  contains
    procedure :: write_row
  end type row_list

  !> A run with its rows.
  type, extends(run_type) :: finished_type
    type(row_list) :: kept
    type(error_type), allocatable :: warning   !! contact tables could not be kept
  end type finished_type

contains

  !> The case that the lines of a namelist file describe; `file` is for messages.
  subroutine read_lines_of_case(file, lines, c, error)
    character(*), intent(in) :: file
    type(line_type), intent(in) :: lines(:)
    type(case_type), target, intent(inout) :: c
    type(error_type), allocatable, intent(out) :: error

    call read_case(file, lines, c, error)
    if (.not. allocated(error)) call check_case(file, c, error)
  end subroutine read_lines_of_case

  !> The files of a case: wheel and rail of the left side, those of the right side, bodies; text_length characters each.
  pure function paths_of(c) result(paths)
    type(case_type), intent(in) :: c
    character(5*text_length) :: paths

    paths = c%wheel_profile//c%rail_profile//c%wheel_profile_right//c%rail_profile_right//c%bodies
  end function paths_of

  !> A case by the paths where its files are, in the order of `paths_of`.
  pure type(case_type) function located(c, paths)
    type(case_type), intent(in) :: c
    character(*), intent(in) :: paths
    character(text_length) :: path(5)

    path = transfer(paths(:5*text_length), path)
    located = c
    located%wheel_profile = path(1)
    located%rail_profile = path(2)
    located%wheel_profile_right = path(3)
    located%rail_profile_right = path(4)
    located%bodies = path(5)
  end function located

  !> The names of profiles as the case has them.
  subroutine rename(c, setup)
    type(case_type), intent(in) :: c
    type(setup_type), intent(inout) :: setup

    setup%wheel(1)%file = trim(c%wheel_profile)
    setup%rail(1)%file = trim(c%rail_profile)
    setup%wheel(2)%file = trim(merge(c%wheel_profile, c%wheel_profile_right, c%wheel_profile_right == ''))
    setup%rail(2)%file = trim(merge(c%rail_profile, c%rail_profile_right, c%rail_profile_right == ''))
  end subroutine rename

  !> Prepare a case whose files are at other paths; it keeps their names as its namelist has them.
  subroutine prepare_located(p, c, paths, error)
    type(prepared_type), intent(inout) :: p
    type(case_type), intent(in) :: c
    character(*), intent(in) :: paths      !! in the order of `paths_of`
    type(error_type), allocatable, intent(out) :: error
    type(error_type), allocatable :: ignored

    p%c = c
    call prepare(located(c, paths), p%setup, error)
    p%owns_table = .true.
    call rename(c, p%setup)
    if (.not. allocated(error) .and. c%formulation == 'elastic') call keep_tables(c, p%setup, ignored)
  end subroutine prepare_located

  !> A case with the contact table of another, `from`, which must have the same geometry and material, and must stay as long as
  !> this one.
  subroutine adapt(p, from, c, paths, error)
    type(prepared_type), intent(inout) :: p
    type(prepared_type), intent(in) :: from
    type(case_type), intent(in) :: c
    character(*), intent(in) :: paths      !! in the order of `paths_of`
    type(error_type), allocatable, intent(out) :: error

    p%c = c
    associate (found => located(c, paths))
      call same_file(found%wheel_profile, 'profile', from%setup%wheel(1)%checksum)
      call same_file(found%rail_profile, 'profile', from%setup%rail(1)%checksum)
      call same_file(merge(found%wheel_profile, found%wheel_profile_right, found%wheel_profile_right == ''), 'profile', &
        from%setup%wheel(2)%checksum)
      call same_file(merge(found%rail_profile, found%rail_profile_right, found%rail_profile_right == ''), 'profile', &
        from%setup%rail(2)%checksum)
      if (from%setup%bodies_sum /= '') call same_file(found%bodies, 'file of bodies', from%setup%bodies_sum)
    end associate
    if (allocated(error)) return
    p%setup = from%setup
    call rename(c, p%setup)
    call set_wheelset(c, p%setup, error)

  contains

    subroutine same_file(path, what, sum)
      character(*), intent(in) :: path, what, sum
      type(line_type), allocatable :: lines(:)
      character(:), allocatable :: there

      if (allocated(error)) return
      call find_file(c%places, trim(path), there, error)
      if (.not. allocated(error)) call read_lines(there, lines, error)
      if (allocated(error)) return
      if (checksum(lines) /= sum) call refuse(error, 'the '//what//' of the contact table, CRC-32 '//sum, checksum(lines), &
        trim(path))
    end subroutine same_file

  end subroutine adapt

  !> Integrate a prepared case; its rows go to a writer.
  subroutine simulate_prepared(p, writer, run, warning, error, watcher)
    type(prepared_type), intent(in) :: p
    class(row_writer), intent(inout) :: writer
    type(run_type), intent(out) :: run
    type(error_type), allocatable, intent(out) :: warning    !! contact tables could not be kept
    type(error_type), allocatable, intent(out) :: error
    class(monitor_type), intent(inout), optional :: watcher

    call simulate(p%c, p%setup, writer, run, error, watcher)
    if (.not. allocated(error) .and. p%c%formulation == 'elastic') call keep_tables(p%c, p%setup, warning)
  end subroutine simulate_prepared

  !> Give back the tables of a case.
  subroutine release(p)
    type(prepared_type), intent(inout) :: p

    if (p%owns_table) call free_tables(p%setup)
  end subroutine release

  subroutine write_row(this, row, error)
    class(row_list), intent(inout) :: this
    real(dp), intent(in) :: row(:)
    type(error_type), allocatable, intent(out) :: error
    real(dp), allocatable :: grown(:, :)
    integer :: stat

    if (.not. allocated(this%values)) allocate (this%values(size(row), 1024))
    if (this%n == size(this%values, 2)) then
      allocate (grown(size(row), 2*this%n), stat=stat)
      if (stat /= 0) then
        call refuse(error, 'memory for '//str(2*this%n)//' rows', 'less')
        return
      end if
      grown(:, :this%n) = this%values
      call move_alloc(grown, this%values)
    end if
    this%n = this%n + 1
    this%values(:, this%n) = row
  end subroutine write_row

end module prepared_cases
