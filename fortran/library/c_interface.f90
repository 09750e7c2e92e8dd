!> The functions of `ldbench.h`, by which programs in C, and languages that can call C, have the core's cases, forces and runs.
!>
!> Every function returns a status and, where it is not `ok`, says in one line why. None stops, prints, or leaves anything changed
!> in the process. Null pointers and numbers of closed cases are refused.
module c_interface
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_int64_t, c_ptr
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use c_texts, only: clear, give, need, no_room, ok, outside, refused, tell, text_at, told
  use case, only: case_type, text_length
  use changed_numbers, only: get_number, set_number
  use columns, only: column_type, contact_columns, list_columns, most_columns
  use elastic_run, only: initial_motion
  use errors, only: error_type, fatal_error, refuse
  use events, only: event_kinds
  use kinds, only: dp, version
  use motion_state, only: contact_state, motion_type
  use motion_steps, only: advance_motion, refuse_pose
  use open_cases, only: add_case, case_at, close_case
  use places, only: folder_of
  use prepared_cases, only: paths_of, prepare_located, prepared_type, read_lines_of_case, release, simulate_prepared
  use row_sink, only: row_writer
  use run_monitor, only: run_type
  use run_results, only: describe_results, describe_setup
  use run_tables, only: keep_tables
  use text, only: line_type, read_lines, split_lines, str
  use elastic_contacts, only: contacts
  use wheelset, only: right_tread
  use zone_tables, only: inside
  implicit none
  private

  !> `ldbench_facts` of ldbench.h.
  type, bind(c) :: facts_type
    real(c_double) :: mass, roll_inertia, pitch_inertia, weight
    real(c_double) :: held(3), rest(3)
    real(c_double) :: start(3), velocity(3)
    real(c_double) :: lateral_force, lateral_ramp, t_end
    real(c_double) :: clearance(2)
    integer(c_int) :: columns
  end type facts_type

  !> `ldbench_contact_point` of ldbench.h.
  type, bind(c) :: contact_point
    real(c_double) :: energy, force(3), angle, normal_force, y, z, radius
  end type contact_point

  !> `ldbench_event` of ldbench.h.
  type, bind(c) :: event_point
    real(c_double) :: t, angle, force
    integer(c_int) :: kind, cause
  end type event_point

  !> Rows of a run in the caller's memory, as far as there is room; all are counted.
  type, extends(row_writer) :: given_rows
    real(c_double), pointer :: values(:, :) => null()   !! (column, row)
    integer :: n = 0
  contains
    procedure :: write_row
  end type given_rows

contains

  integer(c_int) function ldbench_version(text, size) bind(c) result(status)
    type(c_ptr), value :: text
    integer(c_int), value :: size

    status = give(version, text, size)
  end function ldbench_version

  integer(c_int) function ldbench_open(path, tables, handle, message, size) bind(c) result(status)
    type(c_ptr), value :: path, tables, handle, message
    integer(c_int), value :: size
    type(line_type), allocatable :: lines(:)
    type(error_type), allocatable :: error
    character(:), allocatable :: file

    call clear(message, size)
    call no_case(handle, error)
    if (.not. allocated(error)) call text_at(path, 'path', file, error)
    if (.not. allocated(error)) call read_lines(file, lines, error)
    if (.not. allocated(error)) call open_lines(file, lines, tables, handle, error)
    status = told(error, message, size)
  end function ldbench_open

  integer(c_int) function ldbench_open_text(text, name, tables, handle, message, size) bind(c) result(status)
    type(c_ptr), value :: text, name, tables, handle, message
    integer(c_int), value :: size
    type(line_type), allocatable :: lines(:)
    type(error_type), allocatable :: error
    character(:), allocatable :: file, words

    call clear(message, size)
    call no_case(handle, error)
    if (.not. allocated(error)) call text_at(text, 'text', words, error)
    if (.not. allocated(error)) call text_at(name, 'name', file, error)
    if (.not. allocated(error)) then
      call split_lines(words, lines)
      call open_lines(file, lines, tables, handle, error)
    end if
    status = told(error, message, size)
  end function ldbench_open_text

  !> The number of no case, which stays where a case cannot be opened.
  subroutine no_case(handle, error)
    type(c_ptr), intent(in) :: handle
    type(error_type), allocatable, intent(out) :: error
    integer(c_int64_t), pointer :: number

    if (c_associated(handle)) then
      call c_f_pointer(handle, number)
      number = 0
    else
      call fatal_error(error, 'handle: expected a place for it, found a null pointer')
    end if
  end subroutine no_case

  !> Read, check and prepare the case of a namelist; `file` is its path.
  subroutine open_lines(file, lines, tables, handle, error)
    character(*), intent(in) :: file
    type(line_type), intent(in) :: lines(:)
    type(c_ptr), intent(in) :: tables, handle
    type(error_type), allocatable, intent(out) :: error
    type(prepared_type), pointer :: p
    type(case_type), allocatable :: c
    integer(c_int64_t), pointer :: number
    character(:), allocatable :: folder

    call c_f_pointer(handle, number)
    folder = ''
    if (c_associated(tables)) call text_at(tables, 'tables', folder, error)
    allocate (c)
    call folder_of(file, c%places%folder)
    if (.not. allocated(error)) call read_lines_of_case(file, lines, c, error)
    if (allocated(error)) return
    if (len(folder) > text_length) call fatal_error(error, 'tables: expected at most '//str(text_length)// &
      ' characters, found '//str(len(folder)))
    if (allocated(error)) return
    c%table_folder = folder
    allocate (p)
    call prepare_located(p, c, paths_of(c), error)
    if (.not. allocated(error)) then
      call add_case(p, number)
      if (number == 0) call fatal_error(error, 'expected fewer cases in one process, found more than there are numbers for')
    end if
    if (.not. allocated(error)) return
    call release(p)
    deallocate (p)
  end subroutine open_lines

  integer(c_int) function ldbench_facts(handle, facts, message, size) bind(c) result(status)
    integer(c_int64_t), value :: handle
    type(c_ptr), value :: facts, message
    integer(c_int), value :: size
    type(prepared_type), pointer :: p
    type(facts_type), pointer :: found
    type(error_type), allocatable :: error
    type(motion_type) :: motion
    real(dp) :: values(most_columns)
    integer :: n

    call clear(message, size)
    call look_up(handle, p, error)
    call need(facts, 'facts', error)
    if (.not. allocated(error)) call initial_motion(p%c, p%setup, motion, error)
    if (.not. allocated(error)) then
      call c_f_pointer(facts, found)
      call list_columns(p%c, p%setup, motion, 0.0_dp, values, n)
      associate (w => p%setup%wheelset, c => p%c)
        found = facts_type(w%mass, w%roll_inertia, w%pitch_inertia, w%weight(), p%setup%equilibrium, p%setup%rest, motion%q, &
          motion%v, w%lateral_force, w%lateral_ramp, c%t_end, p%setup%side%clearance, n)
      end associate
    end if
    status = told(error, message, size)
  end function ldbench_facts

  integer(c_int) function ldbench_warnings(handle, text, size) bind(c) result(status)
    integer(c_int64_t), value :: handle
    type(c_ptr), value :: text
    integer(c_int), value :: size
    character(*), parameter :: mark = 'warning: '
    type(prepared_type), pointer :: p
    type(error_type), allocatable :: error
    type(line_type), allocatable :: lines(:)
    character(:), allocatable :: words, found
    integer :: k

    call look_up(handle, p, error)
    if (allocated(error)) then
      status = told(error, text, size)
      return
    end if
    call describe_setup(p%c, p%setup, words)
    call split_lines(words, lines)
    found = ''
    do k = 1, ubound(lines, 1)
      if (index(lines(k)%text, mark) == 1) found = found//lines(k)%text(len(mark) + 1:)//new_line('a')
    end do
    status = give(found, text, size)
  end function ldbench_warnings

  integer(c_int) function ldbench_set(handle, name, value, message, size) bind(c) result(status)
    integer(c_int64_t), value :: handle
    type(c_ptr), value :: name, message
    real(c_double), value :: value
    integer(c_int), value :: size
    type(prepared_type), pointer :: p
    type(error_type), allocatable :: error
    character(:), allocatable :: word

    call clear(message, size)
    call look_up(handle, p, error)
    if (.not. allocated(error)) call text_at(name, 'name', word, error)
    if (.not. allocated(error)) call set_number(p, word, value, error)
    status = told(error, message, size)
  end function ldbench_set

  integer(c_int) function ldbench_get(handle, name, value, message, size) bind(c) result(status)
    integer(c_int64_t), value :: handle
    type(c_ptr), value :: name, value, message
    integer(c_int), value :: size
    type(prepared_type), pointer :: p
    real(c_double), pointer :: found
    real(dp) :: x
    type(error_type), allocatable :: error
    character(:), allocatable :: word

    call clear(message, size)
    call look_up(handle, p, error)
    if (.not. allocated(error)) call text_at(name, 'name', word, error)
    call need(value, 'value', error)
    if (.not. allocated(error)) call get_number(p, word, x, error)
    if (.not. allocated(error)) then
      call c_f_pointer(value, found)
      found = x
    end if
    status = told(error, message, size)
  end function ldbench_get

  integer(c_int) function ldbench_contact(handle, pose, energy, force, points, stiffness, message, size) bind(c) result(status)
    integer(c_int64_t), value :: handle
    type(c_ptr), value :: pose, energy, force, points, stiffness, message
    integer(c_int), value :: size
    type(prepared_type), pointer :: p
    real(c_double), pointer :: q(:), u, f(:), h(:)
    type(contact_point), pointer :: point(:)
    type(contact_state) :: state
    type(error_type), allocatable :: error
    real(dp) :: row(7), station
    integer :: k

    call clear(message, size)
    call look_up_elastic(handle, p, error)
    call need(pose, 'pose', error)
    if (.not. allocated(error)) then
      call c_f_pointer(pose, q, [3])
      call check_pose(q, error)
    end if
    if (allocated(error)) then
      status = told(error, message, size)
      return
    end if
    call contacts(p%setup%wheelset, q, state, with_hessian=c_associated(stiffness))
    if (state%status /= inside) then
      call refuse_pose(q, error)
      call tell(error, message, size)
      status = outside
      return
    end if
    if (c_associated(energy)) then
      call c_f_pointer(energy, u)
      u = (state%energy(1) + state%energy(2)) + (state%energy(3) + state%energy(4))
    end if
    if (c_associated(force)) then
      call c_f_pointer(force, f, [3])
      f = -state%gradient
    end if
    if (c_associated(stiffness)) then
      call c_f_pointer(stiffness, h, [6])
      h = state%hessian
    end if
    if (c_associated(points)) then
      call c_f_pointer(points, point, [4])
      do k = 1, 4
        call contact_columns(p%setup%side(merge(2, 1, k >= right_tread))%pair, q, state, k, row, station)
        point(k) = contact_point(state%energy(k), -state%slope(:, k), row(1), row(2), row(5), row(6), row(7))
      end do
    end if
    status = ok
  end function ldbench_contact

  integer(c_int) function ldbench_advance(handle, t, pose, velocity, t_next, message, size) bind(c) result(status)
    integer(c_int64_t), value :: handle
    real(c_double), value :: t, t_next
    type(c_ptr), value :: pose, velocity, message
    integer(c_int), value :: size
    type(prepared_type), pointer :: p
    real(c_double), pointer :: q(:), v(:)
    type(error_type), allocatable :: error
    logical :: left_table

    call clear(message, size)
    call look_up_elastic(handle, p, error)
    call need(pose, 'pose', error)
    call need(velocity, 'velocity', error)
    if (.not. allocated(error)) then
      call c_f_pointer(pose, q, [3])
      call c_f_pointer(velocity, v, [3])
      call check_pose(q, error)
      if (.not. (allocated(error) .or. all(ieee_is_finite([v, t, t_next])) .and. t_next >= t)) &
        call fatal_error(error, 'expected finite velocities and a time after the present one, found others')
    end if
    if (allocated(error)) then
      status = told(error, message, size)
      return
    end if
    call advance_motion(p, t, q, v, t_next, left_table, error)
    status = told(error, message, size)
    if (left_table) status = outside
  end function ldbench_advance

  integer(c_int) function ldbench_columns(handle, text, size) bind(c) result(status)
    integer(c_int64_t), value :: handle
    type(c_ptr), value :: text
    integer(c_int), value :: size
    type(prepared_type), pointer :: p
    type(error_type), allocatable :: error
    type(motion_type) :: motion
    type(column_type) :: columns(most_columns)
    real(dp) :: values(most_columns)
    character(:), allocatable :: words
    integer :: n, k

    call look_up(handle, p, error)
    if (allocated(error)) then
      status = told(error, text, size)
      return
    end if
    call list_columns(p%c, p%setup, motion, 0.0_dp, values, n, columns)
    words = ''
    do k = 1, n
      words = words//trim(columns(k)%name)//' '//trim(columns(k)%unit)//new_line('a')
    end do
    status = give(words, text, size)
  end function ldbench_columns

  integer(c_int) function ldbench_simulate(handle, capacity, rows, n_rows, most_events, events, n_events, results, results_size, &
    message, size) bind(c) result(status)
    integer(c_int64_t), value :: handle
    integer(c_int), value :: capacity, most_events, results_size, size
    type(c_ptr), value :: rows, n_rows, events, n_events, results, message
    type(prepared_type), pointer :: p
    type(error_type), allocatable :: error

    call clear(message, size)
    call look_up(handle, p, error)
    call need(n_rows, 'n_rows', error)
    if (allocated(error)) then
      status = told(error, message, size)
      return
    end if
    block
      type(run_type), allocatable :: run
      type(given_rows) :: writer
      type(error_type), allocatable :: warning
      type(event_point), pointer :: event(:)
      integer(c_int), pointer :: number
      character(:), allocatable :: words
      integer :: k, columns

      columns = columns_of(p)
      if (.not. c_associated(rows) .or. capacity < 1) then
        allocate (writer%values(columns, 0))
      else
        call c_f_pointer(rows, writer%values, [columns, int(capacity)])
      end if
      allocate (run)
      call simulate_prepared(p, writer, run, warning, error)
      if (.not. c_associated(rows) .or. capacity < 1) deallocate (writer%values)
      status = told(error, message, size)
      if (status /= ok) return
      call c_f_pointer(n_rows, number)
      number = writer%n
      if (writer%n > capacity .and. c_associated(rows)) status = no_room
      if (c_associated(n_events)) then
        call c_f_pointer(n_events, number)
        number = run%log%n
      end if
      if (c_associated(events) .and. most_events > 0) then
        call c_f_pointer(events, event, [int(most_events)])
        do k = 1, min(run%log%n, int(most_events))
          associate (one => run%log%list(k))
            event(k) = event_point(one%t, one%angle, one%force, one%kind, one%cause)
          end associate
        end do
      end if
      if (c_associated(results)) then
        call describe_results(p%c, run, words)
        status = max(status, give(words, results, results_size))
      end if
    end block
  end function ldbench_simulate

  integer(c_int) function ldbench_event_name(kind, text, size) bind(c) result(status)
    integer(c_int), value :: kind
    type(c_ptr), value :: text
    integer(c_int), value :: size

    status = refused
    if (kind >= 1 .and. kind <= ubound(event_kinds, 1)) status = give(trim(event_kinds(kind)), text, size)
  end function ldbench_event_name

  integer(c_int) function ldbench_close(handle, message, size) bind(c) result(status)
    integer(c_int64_t), value :: handle
    type(c_ptr), value :: message
    integer(c_int), value :: size
    type(prepared_type), pointer :: p
    type(error_type), allocatable :: error, ignored

    call clear(message, size)
    call look_up(handle, p, error)
    if (.not. allocated(error)) then
      if (p%c%formulation == 'elastic') call keep_tables(p%c, p%setup, ignored)
      call close_case(handle)
    end if
    status = told(error, message, size)
  end function ldbench_close

  integer function columns_of(p) result(n)
    type(prepared_type), intent(in) :: p
    type(motion_type) :: motion
    real(dp) :: values(most_columns)

    call list_columns(p%c, p%setup, motion, 0.0_dp, values, n)
  end function columns_of

  !> The open case of a number.
  subroutine look_up(handle, p, error)
    integer(c_int64_t), intent(in) :: handle
    type(prepared_type), pointer, intent(out) :: p
    type(error_type), allocatable, intent(out) :: error

    p => case_at(handle)
    if (.not. associated(p)) call fatal_error(error, 'handle: expected an open case, found '//str(handle)// &
      ', which ldbench_open did not give or ldbench_close has closed')
  end subroutine look_up

  !> An open case with elastic contacts.
  subroutine look_up_elastic(handle, p, error)
    integer(c_int64_t), intent(in) :: handle
    type(prepared_type), pointer, intent(out) :: p
    type(error_type), allocatable, intent(out) :: error

    call look_up(handle, p, error)
    if (allocated(error)) return
    if (p%c%formulation /= 'elastic') call refuse(error, '''elastic'', which alone has forces that follow from the pose', &
      ''''//trim(p%c%formulation)//'''', group='contact', variable='formulation')
  end subroutine look_up_elastic

  subroutine check_pose(q, error)
    real(dp), intent(in) :: q(3)
    type(error_type), allocatable, intent(out) :: error

    if (.not. all(ieee_is_finite(q))) call fatal_error(error, 'pose: expected finite numbers, found others')
  end subroutine check_pose

  subroutine write_row(this, row, error)
    class(given_rows), intent(inout) :: this
    real(dp), intent(in) :: row(:)
    type(error_type), allocatable, intent(out) :: error

    this%n = this%n + 1
    if (this%n <= ubound(this%values, 2)) this%values(:, this%n) = row
  end subroutine write_row

end module c_interface
