!> What Python holds of the core: prepared cases and finished runs behind integer handles (addresses), cases as arrays over the
!> list of namelist variables, and a monitor that shares a few numbers with another thread.
module handles
  use, intrinsic :: iso_c_binding, only: c_f_pointer, c_loc, c_null_ptr
  use, intrinsic :: iso_fortran_env, only: int64
  use case, only: case_type, list_variables, text_length, variable_type
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use curve, only: curve_frame, curve_type
  use errors, only: error_type
  use kinds, only: dp
  use places, only: places_type
  use prepared_cases, only: adapt, finished_type, located, prepare_located, prepared_type, release, simulate_prepared
  use progress, only: monitor_type
  use column_files, only: begin_columns, column_file, finish_columns
  use run_setup, only: place_sides, setup_type
  use station_scan, only: scan_type, set_depth, touch
  use text, only: str
  use wheel_rail_pair, only: pair_type, rolled
  implicit none
  private
  public :: prepared_type, new_prepared, prepared_at, free_prepared_at, prepare_located, adapt
  public :: prepare_rigid, finished_type, new_run, run_at, free_run_at, simulate_watched, write_finished
  public :: export_case, import_case, import_places, give, give_error, outline, wheel_contact

  !> Tells how far the work is, and is told to stop, through memory of the caller's.
  type, extends(monitor_type) :: shared_monitor
    real(dp), pointer :: progress(:) => null()   !! 1 when the integration has begun, share done
    integer, pointer :: stop_asked(:) => null()  !! not 0: stop
  contains
    procedure :: report
  end type shared_monitor

contains

  subroutine report(this, share)
    class(shared_monitor), intent(inout) :: this
    real(dp), intent(in) :: share
    real(dp), pointer, volatile :: progress(:)
    integer, pointer, volatile :: stop_asked(:)

    progress => this%progress
    stop_asked => this%stop_asked
    progress(1) = 1
    progress(2) = share
    this%stop = stop_asked(1) /= 0
  end subroutine report

  !> Profiles in their places, zones and clearance of a case, whose files are found by the paths given here.
  subroutine prepare_rigid(p, c, paths, error)
    type(prepared_type), intent(inout) :: p
    type(case_type), intent(in) :: c
    character(*), intent(in) :: paths
    type(error_type), allocatable, intent(out) :: error

    p%c = c
    call place_sides(located(c, paths), p%setup, error)
  end subroutine prepare_rigid

  !> The points of a wheel (what = 1) or a rail (2), moved as the core has moved the curve through them [m].
  pure subroutine outline(p, what, side, points)
    type(prepared_type), intent(in) :: p
    integer, intent(in) :: what, side
    real(dp), intent(out) :: points(:, :)

    associate (wheel => p%setup%wheel(side), rail => p%setup%rail(side), pair => p%setup%side(side)%pair)
      if (what == 1) points = placed(wheel%points, wheel%curve, pair%wheel, 0.0_dp)
      if (what == 2) points = placed(rail%points, rail%curve, pair%rail, p%setup%inclination(side))
    end associate
  end subroutine outline

  !> Points [mm] in metres, turned and moved from the curve as it was read to the curve in its place.
  pure function placed(points, read, there, angle)
    real(dp), intent(in) :: points(:, :)
    type(curve_type), intent(in) :: read, there
    real(dp), intent(in) :: angle          !! of the turn [rad]
    real(dp) :: placed(2, size(points, 2))
    integer :: i

    if (abs(angle) <= 0) then
      placed = 1e-3_dp*points + spread(there%a(:, 1, 1) - read%a(:, 1, 1), 2, size(points, 2))
      return
    end if
    do i = 1, size(points, 2)
      placed(:, i) = there%a(:, 1, 1) + rolled(1e-3_dp*points(:, i) - read%a(:, 1, 1), angle)
    end do
  end function placed

  !> Contact of one rigid wheel that is lowered onto its rail, as `wheel_contacts` of the wrapper describes it.
  subroutine wheel_contact(pair, y, roll, scan, row)
    type(pair_type), intent(in) :: pair
    real(dp), intent(in) :: y, roll          !! lateral position of the axle [m], roll angle [rad]
    type(scan_type), intent(inout) :: scan   !! room for the search
    real(dp), intent(out) :: row(6)
    real(dp), parameter :: lift = 0.03_dp    ! the whole flange is in the air at the start [m]
    real(dp) :: start, sunk, station, r(2), angle, curvature
    logical :: ok

    row = ieee_value(1.0_dp, ieee_quiet_nan)
    start = pair%axle_height + lift - roll*pair%r(1, size(pair%s)/2)
    scan%fresh = .true.
    call touch(pair, scan, 1, size(pair%s), [y, start], roll, 0.0_dp, sunk, station, ok)
    if (.not. ok) return
    row(1) = start + sunk
    call sharpen(pair, scan, y, roll, row(1), station)
    call curve_frame(pair%wheel, station, r, angle, curvature)
    row(2) = angle + roll
    row(3:4) = r
    row(5:6) = [y, row(1)] + rolled(r, roll)
  end subroutine wheel_contact

  !> Find a contact again among points that lie closer together than the stations of a scan. The contact of nearly
  !> conforming arcs moves by many times the height by which curvature that jumps between two stations is missed.
  subroutine sharpen(pair, scan, y, roll, z, station)
    type(pair_type), intent(in) :: pair
    type(scan_type), intent(in) :: scan
    real(dp), intent(in) :: y, roll
    real(dp), intent(inout) :: z, station    !! height of the axle, station on the wheel that touches [m]
    integer, parameter :: half = 120         ! points on either side
    real(dp), parameter :: pitch = 2.5e-6_dp ! between points [m]
    real(dp), dimension(-half:half) :: s, foot, depth, rate, step
    real(dp), dimension(2, -half:half) :: p, normal
    integer :: interval(-half:half), i, node
    real(dp) :: r(2), angle, curvature, bend, t

    node = minloc(abs(pair%s - station), 1)
    foot = scan%foot(node)
    interval = scan%interval(node)
    do i = -half, half
      s(i) = max(pair%s(1), min(station + i*pitch, pair%s(size(pair%s))))
      call curve_frame(pair%wheel, s(i), r, angle, curvature)
      p(:, i) = [y, z] + rolled(r, roll)
    end do
    call set_depth(pair%rail, 2*half + 1, p, foot, interval, depth, normal, rate, step)
    i = max(1 - half, min(maxloc(depth, 1) - half - 1, half - 1))
    bend = depth(i + 1) - 2*depth(i) + depth(i - 1)
    t = 0
    if (bend < 0) t = max(-1.0_dp, min(-0.5_dp*(depth(i + 1) - depth(i - 1))/bend, 1.0_dp))
    station = s(i) + t*pitch
    z = z + (depth(i) + t*(depth(i + 1) - depth(i - 1))/4)/normal(2, i)
  end subroutine sharpen

  subroutine simulate_watched(p, run, progress, stop_asked, error)
    type(prepared_type), intent(in) :: p
    type(finished_type), intent(inout) :: run
    real(dp), target, intent(inout) :: progress(:)
    integer, target, intent(inout) :: stop_asked(:)
    type(error_type), allocatable, intent(out) :: error
    type(shared_monitor) :: watcher

    watcher%progress => progress
    watcher%stop_asked => stop_asked
    call simulate_prepared(p, run%kept, run%run_type, run%warning, error, watcher)
  end subroutine simulate_watched

  !> Write the column file of a run.
  subroutine write_finished(p, run, path, kept, error)
    type(prepared_type), intent(in) :: p
    type(finished_type), intent(in) :: run
    character(*), intent(in) :: path
    character(:), allocatable, intent(out) :: kept   !! name of an earlier file of another case from now on; '' if none was there
    type(error_type), allocatable, intent(out) :: error
    type(column_file) :: columns
    integer :: i

    call begin_columns(p%c, p%setup, path, columns, error)
    do i = 1, run%rows
      if (.not. allocated(error)) call columns%write_row(run%kept%values(:, i), error)
    end do
    if (.not. allocated(error)) call finish_columns(p%c, run%run_type, columns, error)
    kept = ''
    if (allocated(columns%kept)) kept = columns%kept
  end subroutine write_finished

  !> The values of a case in the order of the list of variables: numbers, and texts one after the other. The places where its files
  !> are looked for follow the texts of a case from Python.
  subroutine export_case(c, numbers, words)
    type(case_type), intent(in) :: c
    real(dp), intent(out) :: numbers(:)
    character(*), intent(out) :: words
    type(case_type), target :: copy
    type(variable_type), allocatable :: list(:)
    integer :: k

    copy = c
    call list_variables(copy, list)
    numbers = 0
    words = ''
    do k = 1, size(list)
      if (associated(list(k)%x)) numbers(k) = list(k)%x
      if (associated(list(k)%i)) numbers(k) = list(k)%i
      if (associated(list(k)%text)) words(text_length*(k - 1) + 1:text_length*k) = list(k)%text
    end do
  end subroutine export_case

  subroutine import_case(numbers, words, c)
    real(dp), intent(in) :: numbers(:)
    character(*), intent(in) :: words
    type(case_type), target, intent(out) :: c
    type(variable_type), allocatable :: list(:)
    integer :: k

    call list_variables(c, list)
    do k = 1, size(list)
      if (associated(list(k)%x)) list(k)%x = numbers(k)
      if (associated(list(k)%i)) list(k)%i = nint(numbers(k))
      if (associated(list(k)%text)) list(k)%text = words(text_length*(k - 1) + 1:text_length*k)
    end do
    call import_places(words(text_length*size(list) + 1:), c%places)
  end subroutine import_case

  !> The folder of the namelist and that of the shipped files, with the character FS (28) between them.
  pure subroutine import_places(words, places)
    character(*), intent(in) :: words
    type(places_type), intent(out) :: places
    integer :: mark

    mark = index(words, achar(28))
    places%folder = words(:mark - 1)
    places%share = words(mark + 1:)
  end subroutine import_places

  !> A text for Python: in a buffer, with its length.
  subroutine give(text, buffer, length)
    character(*), intent(in) :: text
    character(*), intent(out) :: buffer
    integer, intent(out) :: length

    buffer = text
    length = min(len(text), len(buffer))
  end subroutine give

  !> An error for Python: its message, then its file, line, group, variable, what was expected and found, and 'missing' where
  !> there is no such file, with a character FS (28) between two of them; length 0 when there is none.
  subroutine give_error(error, message, length)
    type(error_type), allocatable, intent(in) :: error
    character(*), intent(out) :: message
    integer, intent(out) :: length
    integer, parameter :: longest = 2048       ! part; Python shows no longer one, and the buffer holds all parts
    character(:), allocatable :: parts

    message = ''
    length = 0
    if (.not. allocated(error)) return
    parts = ''
    call add(error%message)
    call add(error%file)
    if (error%line > 0) then
      call add(str(error%line))
    else
      call add()
    end if
    call add(error%group)
    call add(error%variable)
    call add(error%expected)
    call add(error%found)
    call add(trim(merge('missing', '       ', error%missing)))
    call give(parts(2:), message, length)

  contains

    subroutine add(part)
      character(*), intent(in), optional :: part

      parts = parts//achar(28)
      if (present(part)) parts = parts//part(:min(len(part), longest))
    end subroutine add

  end subroutine give_error

  subroutine new_prepared(p, handle)
    type(prepared_type), pointer, intent(out) :: p
    integer(int64), intent(out) :: handle

    allocate (p)
    handle = transfer(c_loc(p), handle)
  end subroutine new_prepared

  function prepared_at(handle) result(p)
    integer(int64), intent(in) :: handle
    type(prepared_type), pointer :: p

    call c_f_pointer(transfer(handle, c_null_ptr), p)
  end function prepared_at

  subroutine free_prepared_at(handle)
    integer(int64), intent(in) :: handle
    type(prepared_type), pointer :: p

    p => prepared_at(handle)
    call release(p)
    deallocate (p)
  end subroutine free_prepared_at

  subroutine new_run(run, handle)
    type(finished_type), pointer, intent(out) :: run
    integer(int64), intent(out) :: handle

    allocate (run)
    handle = transfer(c_loc(run), handle)
  end subroutine new_run

  function run_at(handle) result(run)
    integer(int64), intent(in) :: handle
    type(finished_type), pointer :: run

    call c_f_pointer(transfer(handle, c_null_ptr), run)
  end function run_at

  subroutine free_run_at(handle)
    integer(int64), intent(in) :: handle
    type(finished_type), pointer :: run

    run => run_at(handle)
    deallocate (run)
  end subroutine free_run_at

end module handles