!> Reads a wheel's or a rail's profile.  The points of a file, as people really have them, are turned over, converted to
!> millimetres, repaired and fitted by a smooth curve in metres.
module profile
  use curve, only: curve_type
  use curve_fit, only: fit_curve
  use errors, only: error_type, fatal_error
  use profile_formats, only: raw_type, read_points
  use kinds, only: dp
  use profile_repair, only: check_points, mend_points, mended_text, mended_type
  use profile_orientation, only: cut_faces, is_rail, is_wheel, put_in_order, recognise, tape_circle, turn_over
  use text, only: checksum, line_type, read_lines, str
  implicit none
  private
  public :: profile_type, read_profile

  !> A profile and how its file was read.
  type :: profile_type
    character(:), allocatable :: file      !! as named in the namelist
    character(8) :: checksum = ''          !! CRC-32 of the file's lines
    logical :: reconstruction = .false.    !! the file says that it is one
    integer :: kind = 0                    !! is_wheel or is_rail
    character(:), allocatable :: taken     !! how the file was read; '' for y z in mm, z up, as written
    character(:), allocatable :: mended    !! what was repaired; '' for nothing
    real(dp), allocatable :: points(:, :)  !! points after repair, a wheel's y from its back, (2, n) [mm]
    type(curve_type) :: curve              !! y, z [m], y increasing from first to last station
  end type profile_type

  integer, parameter :: least_points = 10
  real(dp), parameter :: least_span = 10, largest_span = 1000   !! plausible widths [mm]
  real(dp), parameter :: inch = 25.4_dp                         !! [mm]

contains

  !> Read a profile.  Accepted are the formats of `profile_formats`, either direction, z up or down, y in or out, mm, m
  !> or inches, as the shape says or as `flip` and `unit` say, and points that `profile_repair` can repair.  Refused, with
  !> file and line, are anything else that is not a number, too few points, a curve that turns back or crosses itself,
  !> and widths that no profile has.
  subroutine read_profile(file, kind, smoothing, flip, unit, p, error)
    character(*), intent(in) :: file
    integer, intent(in) :: kind            !! is_wheel, is_rail, or 0: as the shape says
    real(dp), intent(in) :: smoothing      !! rms distance between curve and points [mm]
    character(*), intent(in) :: flip       !! axes to turn over: 'auto', 'none', 'y', 'z' or 'yz'
    character(*), intent(in) :: unit       !! 'auto', 'mm', 'm' or 'in'
    type(profile_type), intent(out) :: p
    type(error_type), allocatable, intent(out) :: error
    type(line_type), allocatable :: lines(:)
    type(raw_type) :: raw
    type(mended_type) :: mended
    logical :: turned(2)
    integer :: first, last

    p%taken = ''
    p%mended = ''
    p%kind = kind
    call read_lines(file, lines, error)
    if (allocated(error)) return
    p%file = file
    p%checksum = checksum(lines)
    call read_points(file, lines, raw, error)
    if (allocated(error)) return
    p%reconstruction = raw%reconstruction
    if (raw%format /= 'plain') call say(p, raw%format)
    if (kind > 0 .and. raw%kind /= '') then
      if (raw%kind /= merge('wheel', 'rail ', kind == is_wheel)) then
        call fatal_error(error, file//': expected a '//trim(merge('wheel', 'rail ', kind == is_wheel))// &
          ', found a file that says it is a '//trim(raw%kind))
        return
      end if
    end if
    if (raw%announced >= 0 .and. raw%announced /= size(raw%line)) &
      call say(p, str(size(raw%line))//' points of the '//str(raw%announced)//' announced')
    call to_millimetres(file, unit, raw, p, error)
    if (allocated(error)) return
    call check_number(file, raw, error)
    if (.not. allocated(error)) call mend_points(file, raw%points, raw%line, mended, error)
    if (.not. allocated(error)) call check_number(file, raw, error)
    if (allocated(error)) return
    call choose_sides(kind, flip, raw, p, turned)
    call turn_over(raw%points, turned)
    call put_in_order(raw%points, raw%line)
    call cut_faces(raw%points, p%kind, first, last)
    if (last - first + 1 >= least_points) then
      if (last - first + 1 < size(raw%line)) call say(p, 'faces beyond the running surface left out')
      if (p%kind == is_wheel) call put_back(raw, p)
      raw%points = raw%points(:, first:last)
      raw%line = raw%line(first:last)
    end if
    call check_points(file, raw%points, raw%line, error)
    if (allocated(error)) return
    p%points = raw%points
    call mended_text(mended, p%mended)
    ! The mean of several points is nearer to the curve than the points are.
    call fit_curve(1e-3_dp*p%points(1, :), 1e-3_dp*p%points(2, :), 1e-3_dp*smoothing/sqrt(real(mended%group, dp)), p%curve, error)
    if (allocated(error)) call fatal_error(error, file//': '//error%message)
  end subroutine read_profile

  !> Add words to the text on how the file was read.
  subroutine say(p, words)
    type(profile_type), intent(inout) :: p
    character(*), intent(in) :: words

    if (p%taken /= '') p%taken = p%taken//', '
    p%taken = p%taken//words
  end subroutine say

  !> Convert to millimetres.  The unit is what the namelist says, else what the file says, else the one that makes the
  !> width plausible.
  subroutine to_millimetres(file, unit, raw, p, error)
    character(*), intent(in) :: file, unit
    type(raw_type), intent(inout) :: raw
    type(profile_type), intent(inout) :: p
    type(error_type), allocatable, intent(out) :: error
    real(dp) :: span, factor

    span = 0
    if (size(raw%line) > 0) span = maxval(raw%points(1, :)) - minval(raw%points(1, :))
    factor = 1
    select case (unit)
    case ('m')
      factor = 1e3_dp
    case ('in')
      factor = inch
    case ('auto')
      if (raw%unit > 0) then
        factor = raw%unit
      else if (span >= 0.02_dp .and. span < 0.5_dp) then
        factor = 1e3_dp
        call say(p, 'in m')
      else if (span >= 1.5_dp .and. span < least_span) then
        factor = inch
        call say(p, 'in inches')
      end if
    end select
    if (abs(factor - 1) > 0) raw%points = factor*raw%points
    if (size(raw%line) < least_points) return
    span = factor*span
    if (span < least_span .or. span > largest_span) call fatal_error(error, file// &
      ': expected y in millimetres over '//str(least_span)//' to '//str(largest_span)//' mm, found a width of '//str(span))
  end subroutine to_millimetres

  !> Fails where there are too few points.
  subroutine check_number(file, raw, error)
    character(*), intent(in) :: file
    type(raw_type), intent(in) :: raw
    type(error_type), allocatable, intent(out) :: error

    if (size(raw%line) < least_points) call fatal_error(error, file//': expected at least '// &
      str(least_points)//' points, found '//str(size(raw%line)))
  end subroutine check_number

  !> Axes to be turned over, and whether the file is a wheel or a rail where neither the caller nor the file says it.
  subroutine choose_sides(kind, flip, raw, p, turned)
    integer, intent(in) :: kind                !! is_wheel, is_rail, or 0: as the shape says
    character(*), intent(in) :: flip
    type(raw_type), intent(in) :: raw
    type(profile_type), intent(inout) :: p
    logical, intent(out) :: turned(2)
    integer :: found

    call recognise(raw%points, kind, found, turned)
    if (p%kind == 0 .and. raw%kind /= '') p%kind = merge(is_wheel, is_rail, raw%kind == 'wheel')
    if (p%kind == 0) p%kind = merge(is_rail, is_wheel, found == is_rail)
    if (flip /= 'auto') turned = [scan(flip, 'y') > 0, scan(flip, 'z') > 0]
    if (all(turned)) then
      call say(p, 'y and z turned over')
    else if (turned(1)) then
      call say(p, 'y turned over')
    else if (turned(2)) then
      call say(p, 'z turned over')
    end if
  end subroutine choose_sides

  !> Let a wheel's y begin at its back.  In the file y may be 0 at the back, at the tape circle, or anywhere else.
  subroutine put_back(raw, p)
    type(raw_type), intent(inout) :: raw
    type(profile_type), intent(inout) :: p
    real(dp), parameter :: near = 3   ! [mm]
    real(dp) :: back

    back = minval(raw%points(1, :))
    if (abs(back + tape_circle) < near) then
      back = -tape_circle
    else if (back > -near) then
      return
    end if
    call say(p, 'wheel back at y = '//str(anint(1e3_dp*back)/1e3_dp)//' mm of the file')
    raw%points(1, :) = raw%points(1, :) - back
  end subroutine put_back

end module profile
