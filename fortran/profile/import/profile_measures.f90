!> What a workshop and a track engineer measure of a profile, and which part of it is what.
module profile_measures
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use curve, only: curve_frame, curve_type
  use kinds, only: degree, dp
  use profile_orientation, only: is_wheel
  implicit none
  private
  public :: survey_type, survey, part_names, measure_names

  character(*), parameter :: part_names(*) = [character(12) :: 'flange back', 'flange', 'throat', 'tread', 'chamfer', &
    'gauge side', 'head', 'field side']

  !> Of a wheel (EN 15313): flange height Sh above the tape circle, 70 mm from the back; flange thickness Sd
  !> 10 mm beyond the tape circle's level; qR, the lateral way along the flange face from there to 2 mm
  !> from the tip; steepest angle of the flange face; slope of the tread, mean over 20 mm about the tape
  !> circle; hollow, the most that the tread rises before a lower part farther out.
  !> Of a rail: radii of the crown (3 degrees about the inclination of the head), of the shoulder (5 to 12 degrees
  !> from it) and of the corner (35 to 70) on the gauge side, mean over their arcs; lateral position of
  !> the gauge point and of the top in the file; inclination at which the head is symmetric.
  character(*), parameter :: measure_names(6, 2) = reshape([character(16) :: &
    'Sh', 'Sd', 'qR', 'flange_angle', 'tread_slope', 'hollow', &
    'crown_radius', 'shoulder_radius', 'corner_radius', 'gauge_point_y', 'top_y', 'inclination'], [6, 2])

  type :: survey_type
    real(dp), allocatable :: s(:)          !! stations [m]
    real(dp), allocatable :: r(:, :)       !! y, z, (2, n) [m]
    real(dp), allocatable :: angle(:)      !! of the tangent [rad]
    real(dp), allocatable :: curvature(:)  !! d(angle)/ds [1/m]
    integer, allocatable :: part(:)        !! of part_names
    real(dp) :: measure(6) = 0             !! of measure_names [m, rad, 1]; NaN where the profile does not go so far
  end type survey_type

  real(dp), parameter :: pitch = 0.1e-3_dp             ! of the stations [m]
  real(dp), parameter :: tape_circle = 70e-3_dp        ! from the wheel's back [m]
  real(dp), parameter :: steep = 60*degree             ! sides are steeper than a head
  real(dp), parameter :: gentle = 10*degree, chamfer = 25*degree   ! a tread is less steep

contains

  pure subroutine survey(curve, kind, gauge_depth, found)
    type(curve_type), intent(in) :: curve  !! y from the wheel's back [m]
    integer, intent(in) :: kind            !! is_wheel or is_rail
    real(dp), intent(in) :: gauge_depth    !! [m]
    type(survey_type), intent(out) :: found
    integer :: n, i

    n = ceiling(curve%last()/pitch)
    allocate (found%s(n), found%r(2, n), found%angle(n), found%curvature(n), found%part(n))
    do i = 1, n
      found%s(i) = (i - 1)*curve%last()/(n - 1)
      call curve_frame(curve, found%s(i), found%r(:, i), found%angle(i), found%curvature(i))
    end do
    if (kind == is_wheel) then
      call survey_wheel(found)
    else
      call survey_rail(found, gauge_depth)
    end if
  end subroutine survey

  pure subroutine survey_wheel(w)
    type(survey_type), intent(inout) :: w
    real(dp) :: level, high
    integer :: n, tip, tape, face, throat, edge, i

    n = size(w%s)
    tip = minloc(w%r(2, :), 1)
    tape = tip - 1 + findloc(w%r(1, tip:) >= tape_circle, .true., 1)
    if (tape < tip) tape = n
    face = tip - 1 + maxloc(w%angle(tip:tape), 1)
    throat = face - 1 + findloc(w%angle(face:) < gentle, .true., 1)
    if (throat < face) throat = n
    edge = tape - 1 + findloc(w%angle(tape:) > chamfer, .true., 1)
    if (edge < tape) edge = n + 1
    w%part = 4
    w%part(:tip) = 1
    w%part(tip + 1:face) = 2
    w%part(face + 1:throat) = 3
    w%part(edge:) = 5

    level = w%r(2, tape)
    w%measure(1) = level - w%r(2, tip)
    w%measure(2) = crossing(w, tip, tape, level - 10e-3_dp)
    w%measure(3) = w%measure(2) - crossing(w, tip, tape, w%r(2, tip) + 2e-3_dp)
    w%measure(4) = w%angle(face)
    w%measure(5) = slope(pack(w%r(1, :), abs(w%r(1, :) - tape_circle) < 10e-3_dp), &
      pack(w%r(2, :), abs(w%r(1, :) - tape_circle) < 10e-3_dp))
    high = w%r(2, throat)
    do i = throat, min(edge, n + 1) - 1
      high = max(high, w%r(2, i))
      w%measure(6) = max(w%measure(6), high - w%r(2, i))
    end do
  end subroutine survey_wheel

  pure subroutine survey_rail(r, gauge_depth)
    type(survey_type), intent(inout) :: r
    real(dp), intent(in) :: gauge_depth
    real(dp) :: top, lean, angle
    integer :: n, highest, first, last

    n = size(r%s)
    highest = maxloc(r%r(2, :), 1)
    top = r%r(2, highest)
    first = findloc(r%angle(:highest) > steep, .true., 1, back=.true.)
    last = highest - 1 + findloc(r%angle(highest:) < -steep, .true., 1)
    if (last < highest) last = n + 1
    r%part = 7
    r%part(:first) = 6
    r%part(last:) = 8

    lean = inclination(r, highest)
    r%measure(6) = lean
    if (.not. abs(lean) < 1) lean = 0
    r%measure(1) = arc_radius(r, lean + 1.5_dp*degree, lean - 1.5_dp*degree)
    r%measure(2) = arc_radius(r, lean + 12*degree, lean + 5*degree)
    r%measure(3) = arc_radius(r, lean + 70*degree, lean + 35*degree)
    call at_height(r, 1, highest, top - gauge_depth, r%measure(4), angle)
    r%measure(5) = r%r(1, highest)
  end subroutine survey_rail

  !> y where z first rises to a level between stations first and last; NaN where it does not.
  pure real(dp) function crossing(c, first, last, level) result(y)
    type(survey_type), intent(in) :: c
    integer, intent(in) :: first, last
    real(dp), intent(in) :: level
    real(dp) :: angle

    call at_height(c, first, last, level, y, angle)
  end function crossing

  !> y and tangent angle where z first passes a level on the walk from one station to another.
  pure subroutine at_height(c, from, to, level, y, angle)
    type(survey_type), intent(in) :: c
    integer, intent(in) :: from, to
    real(dp), intent(in) :: level
    real(dp), intent(out) :: y, angle
    real(dp) :: share
    integer :: i, j, step

    y = ieee_value(y, ieee_quiet_nan)
    angle = y
    step = merge(1, -1, to >= from)
    do i = from, to - step, step
      j = i + step
      if (c%r(2, i) > level .or. c%r(2, j) < level) cycle
      share = (level - c%r(2, i))/max(c%r(2, j) - c%r(2, i), tiny(share))
      y = c%r(1, i) + share*(c%r(1, j) - c%r(1, i))
      angle = c%angle(i) + share*(c%angle(j) - c%angle(i))
      return
    end do
  end subroutine at_height

  !> Of the line through points by least squares; NaN for fewer than three.
  pure real(dp) function slope(y, z)
    real(dp), intent(in) :: y(:), z(:)
    real(dp) :: mean

    slope = ieee_value(slope, ieee_quiet_nan)
    if (size(y) < 3) return
    mean = sum(y)/size(y)
    slope = sum((y - mean)*z)/sum((y - mean)**2)
  end function slope

  !> The inclination at which a rail's head is symmetric [rad]: turned upright, the midpoints of its chords
  !> at several depths lie above each other; NaN where no inclination does that.
  pure real(dp) function inclination(r, highest) result(lean)
    type(survey_type), intent(in) :: r
    integer, intent(in) :: highest
    real(dp), parameter :: largest = 0.12_dp
    real(dp) :: low, high
    integer :: k

    low = -largest
    high = largest
    lean = ieee_value(lean, ieee_quiet_nan)
    if (.not. (tilt(low) > 0 .and. tilt(high) < 0)) return
    do k = 1, 40
      lean = (low + high)/2
      if (tilt(lean) > 0) then
        low = lean
      else
        high = lean
      end if
    end do

  contains

    !> Of the line of midpoints from the vertical, with the head turned back by an angle.
    pure real(dp) function tilt(angle)
      real(dp), intent(in) :: angle
      integer, parameter :: depths = 11
      type(survey_type) :: turned
      real(dp) :: y(2), depth(depths), middle(depths), tangent
      integer :: i

      turned = r
      turned%r(1, :) = r%r(1, :)*cos(angle) + r%r(2, :)*sin(angle)
      turned%r(2, :) = r%r(2, :)*cos(angle) - r%r(1, :)*sin(angle)
      do i = 1, depths
        depth(i) = maxval(turned%r(2, :)) - (4e-3_dp + 10e-3_dp*(i - 1)/(depths - 1))
        call at_height(turned, 1, highest, depth(i), y(1), tangent)
        call at_height(turned, size(r%s), highest, depth(i), y(2), tangent)
        middle(i) = sum(y)/2
      end do
      tilt = slope(depth, middle)
    end function tilt

  end function inclination

  !> Mean radius of a rail's arc between two tangent angles, on the gauge side; NaN where it has none.
  pure real(dp) function arc_radius(c, steeper, flatter) result(radius)
    type(survey_type), intent(in) :: c
    real(dp), intent(in) :: steeper, flatter   !! [rad]
    integer :: first, last

    radius = ieee_value(radius, ieee_quiet_nan)
    first = findloc(c%angle > steeper, .true., 1, back=.true.)
    last = findloc(c%angle < flatter, .true., 1)
    if (first < 1 .or. last <= first) return
    radius = (c%s(last) - c%s(first))/(c%angle(first) - c%angle(last))
  end function arc_radius

end module profile_measures