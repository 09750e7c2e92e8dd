!> The functions of `ldbench.h`, by which programs in C, and languages that can call C, have the core's cases, forces and runs.
!>
!> Every function returns a status and, where it is not `ok`, says in one line why. None stops, prints, or leaves anything changed
!> in the process. Null pointers and numbers of closed cases are refused.
module c_interface
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_double, c_f_pointer, c_int, c_int64_t, c_null_char, c_ptr
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use case, only: case_type, list_variables, text_length, variable_type
  use case_check, only: check_case
  use columns, only: column_type, contact_columns, list_columns, most_columns
  use cut_steps, only: cut_step, cutting_type, step_watcher
  use elastic_run, only: initial_motion
  use errors, only: error_type, fatal_error, refuse
  use events, only: event_kinds
  use integrators, only: evaluate_contacts, integrator_type, step_diverged, step_ok
  use kinds, only: dp, version
  use motion_state, only: motion_type
  use places, only: folder_of
  use open_cases, only: add_case, case_at, close_case
  use prepared_cases, only: finished_type, paths_of, prepare_located, prepared_type, read_lines_of_case, release, row_list, &
    simulate_prepared
  use row_sink, only: row_writer
  use run_monitor, only: run_type
  use run_results, only: describe_results, describe_setup
  use run_setup, only: set_wheelset
  use run_tables, only: keep_tables
  use text, only: line_type, lower, read_lines, split_lines, str
  use wheelset, only: contact_state, contacts, external_force, right_tread
  use zone_tables, only: inside
  implicit none
  private

  enum, bind(c)
    enumerator :: ok = 0, refused, outside, no_room     ! LDBENCH_OK and so on of ldbench.h
  end enum

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

  !> Remembers how short steps had to be.
  type, extends(step_watcher) :: shortest_step
    real(dp) :: dt = huge(1.0_dp)          !! [s]
  contains
    procedure :: after_step
  end type shortest_step

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
    call text_at(path, 'path', file, error)
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
    call text_at(text, 'text', words, error)
    if (.not. allocated(error)) call text_at(name, 'name', file, error)
    if (.not. allocated(error)) then
      call split_lines(words, lines)
      call open_lines(file, lines, tables, handle, error)
    end if
    status = told(error, message, size)
  end function ldbench_open_text

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

    if (.not. c_associated(handle)) then
      call fatal_error(error, 'handle: expected a place for it, found a null pointer')
      return
    end if
    call c_f_pointer(handle, number)
    number = 0
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
    type(case_type), allocatable, target :: c
    type(variable_type) :: variable
    real(c_double), pointer :: found
    type(error_type), allocatable :: error
    character(:), allocatable :: word

    call clear(message, size)
    call look_up(handle, p, error)
    if (.not. allocated(error)) call text_at(name, 'name', word, error)
    call need(value, 'value', error)
    if (.not. allocated(error)) then
      allocate (c, source=p%c)
      call find_number(c, word, variable, error)
    end if
    if (.not. allocated(error)) then
      call c_f_pointer(value, found)
      found = variable%x
    end if
    status = told(error, message, size)
  end function ldbench_get

  !> Change a number of a case on which its table does not depend.
  subroutine set_number(p, name, value, error)
    type(prepared_type), intent(inout) :: p
    character(*), intent(in) :: name
    real(dp), intent(in) :: value
    type(error_type), allocatable, intent(out) :: error
    type(case_type), allocatable, target :: c
    type(variable_type) :: variable

    allocate (c, source=p%c)
    call find_number(c, name, variable, error)
    if (allocated(error)) return
    variable%x = value
    call check_case(trim(c%name), c, error)
    if (allocated(error)) return
    call set_wheelset(c, p%setup, error)
    if (.not. allocated(error)) p%c = c
  end subroutine set_number

  !> The variable of a number on which the contact table does not depend.
  subroutine find_number(c, name, variable, error)
    type(case_type), target, intent(inout) :: c
    character(*), intent(in) :: name
    type(variable_type), intent(out) :: variable     !! points into c
    type(error_type), allocatable, intent(out) :: error
    character(*), parameter :: groups = ' wheelset initial loading ', fixed = ' rolling_radius back_to_back '
    type(variable_type), allocatable :: list(:)
    integer :: k

    call list_variables(c, list)
    do k = 1, ubound(list, 1)
      if (lower(list(k)%name) /= lower(name) .or. .not. associated(list(k)%x)) cycle
      if (index(groups, ' '//list(k)%group//' ') == 0 .or. index(fixed, ' '//list(k)%name//' ') > 0) cycle
      variable = list(k)
      return
    end do
    call fatal_error(error, 'name: expected a number of &wheelset, &initial or &loading on which the contact table does not '// &
      'depend, found '//name)
  end subroutine find_number

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
      call outside_words(q, error)
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
    call advance_motion(p, t, q, v, t_next, status, error)
    call tell(error, message, size)
  end function ldbench_advance

  !> Steps of the case's integrator, no longer than its `dt`, from one time to another.
  subroutine advance_motion(p, t, q, v, t_next, status, error)
    type(prepared_type), intent(in) :: p
    real(dp), intent(in) :: t, t_next          !! [s]
    real(dp), intent(inout) :: q(3), v(3)      !! at t, then at t_next
    integer(c_int), intent(out) :: status
    type(error_type), allocatable, intent(out) :: error
    type(integrator_type) :: integrator
    type(cutting_type) :: cutting
    type(motion_type) :: motion
    type(shortest_step) :: watcher
    integer :: n, i, ended

    associate (c => p%c)
      integrator = integrator_type(c%order, c%beta, c%gamma, c%tolerance, c%max_iterations)
      cutting = cutting_type(c%error_tolerance, c%energy_tolerance, c%max_halvings)
      n = max(1, ceiling((t_next - t)/c%dt*(1 - 1e-9_dp)))
    end associate
    motion%t = t
    motion%q = q
    motion%v = v
    call evaluate_contacts(p%setup%wheelset, motion, ended)
    do i = 1, n
      if (ended /= step_ok) exit
      call cut_step(p%setup%wheelset, integrator, cutting, motion, (t_next - t)/n, 0, watcher, ended, error)
    end do
    status = ok
    if (ended == step_diverged) then
      call fatal_error(error, 'expected steps that converge, found one at t = '//str(motion%t)//' s that does not, '// &
        'after steps down to '//str(watcher%dt)//' s; shorten &integrator dt')
      status = refused
    else if (ended /= step_ok) then
      call outside_words(motion%q, error)
      status = outside
    else
      q = motion%q
      v = motion%v
    end if
  end subroutine advance_motion

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

  subroutine need(pointer, name, error)
    type(c_ptr), intent(in) :: pointer
    character(*), intent(in) :: name
    type(error_type), allocatable, intent(inout) :: error

    if (allocated(error) .or. c_associated(pointer)) return
    call fatal_error(error, name//': expected an address, found a null pointer')
  end subroutine need

  subroutine check_pose(q, error)
    real(dp), intent(in) :: q(3)
    type(error_type), allocatable, intent(out) :: error

    if (.not. all(ieee_is_finite(q))) call fatal_error(error, 'pose: expected finite numbers, found others')
  end subroutine check_pose

  subroutine outside_words(q, error)
    real(dp), intent(in) :: q(3)
    type(error_type), allocatable, intent(out) :: error

    call refuse(error, 'a pose within the extent of &table', 'y = '//str(q(1))//' m, z = '//str(q(2))//' m, roll = '// &
      str(q(3))//' rad')
  end subroutine outside_words

  !> The characters at an address, up to the null character.
  subroutine text_at(address, name, text, error)
    type(c_ptr), intent(in) :: address
    character(*), intent(in) :: name
    character(:), allocatable, intent(out) :: text
    type(error_type), allocatable, intent(out) :: error
    character(kind=c_char), pointer :: letters(:)
    integer, parameter :: most = 1000000
    integer :: n, k

    text = ''
    call need(address, name, error)
    if (allocated(error)) return
    call c_f_pointer(address, letters, [most])
    n = 0
    do while (n < most)
      if (letters(n + 1) == c_null_char) exit
      n = n + 1
    end do
    deallocate (text)
    allocate (character(n) :: text)
    do k = 1, n
      text(k:k) = letters(k)
    end do
  end subroutine text_at

  !> Write a text, as much of it as there is room for, and the null character.
  integer(c_int) function give(text, address, size) result(status)
    character(*), intent(in) :: text
    type(c_ptr), intent(in) :: address
    integer(c_int), intent(in) :: size
    character(kind=c_char), pointer :: letters(:)
    integer :: n, k

    status = no_room
    if (.not. c_associated(address) .or. size < 1) return
    call c_f_pointer(address, letters, [int(size)])
    n = min(len(text), int(size) - 1)
    do k = 1, n
      letters(k) = text(k:k)
    end do
    letters(n + 1) = c_null_char
    if (n == len(text)) status = ok
  end function give

  !> An empty message.
  subroutine clear(message, size)
    type(c_ptr), intent(in) :: message
    integer(c_int), intent(in) :: size
    integer(c_int) :: ignored

    ignored = give('', message, size)
  end subroutine clear

  !> The status of an error, whose message is written.
  integer(c_int) function told(error, message, size) result(status)
    type(error_type), allocatable, intent(in) :: error
    type(c_ptr), intent(in) :: message
    integer(c_int), intent(in) :: size

    status = merge(refused, ok, allocated(error))
    call tell(error, message, size)
  end function told

  !> Write the message of an error.
  subroutine tell(error, message, size)
    type(error_type), allocatable, intent(in) :: error
    type(c_ptr), intent(in) :: message
    integer(c_int), intent(in) :: size
    integer(c_int) :: ignored

    if (allocated(error)) ignored = give(error%message, message, size)
  end subroutine tell

  subroutine write_row(this, row, error)
    class(given_rows), intent(inout) :: this
    real(dp), intent(in) :: row(:)
    type(error_type), allocatable, intent(out) :: error

    this%n = this%n + 1
    if (this%n <= ubound(this%values, 2)) this%values(:, this%n) = row
  end subroutine write_row

  subroutine after_step(this, old, new, error)
    class(shortest_step), intent(inout) :: this
    type(motion_type), intent(in) :: old, new
    type(error_type), allocatable, intent(out) :: error

    this%dt = min(this%dt, new%t - old%t)
  end subroutine after_step

end module c_interface
