!> Placement of a wheel's and a rail's profile in the track frame: the gauge, the distance of the wheels' backs and
!> the rolling radius say where they are.
module placement
  use curve, only: curve_frame, curve_point, curve_type
  use errors, only: error_type, fatal_error, refuse
  use root_bracket, only: bracket_type
  use kinds, only: degree, dp
  use station_scan, only: new_scan, scan_type, touch
  use text, only: str
  use wheel_rail_pair, only: angle_step, mean_curvature, pair_type, rail_station, rolled
  implicit none
  private
  public :: place_profiles

contains

  !> Place the curves of a left wheel and a left rail.  The rail is turned by `inclination` first; then its highest point is the top
  !> of rail, and its gauge is measured at the innermost point down to `gauge_depth` (EN 13848-1).  Fails where the rail does not
  !> reach down to `gauge_depth`, and where the centred wheelset does not stand on its treads; the messages name the files.
  subroutine place_profiles(wheel, rail, wheel_file, rail_file, gauge, gauge_depth, hidden, inclination, back_to_back, &
    rolling_radius, pair, error)
    type(curve_type), intent(in) :: wheel   !! y outward from the wheel's back, z up [m]
    type(curve_type), intent(in) :: rail    !! y outward, z up, y from any point [m]
    character(*), intent(in) :: wheel_file, rail_file   !! for messages
    real(dp), intent(in) :: gauge           !! between the rails, gauge_depth below their top [m]
    real(dp), intent(in) :: gauge_depth     !! [m]
    real(dp), intent(in) :: hidden          !! depth to which the rail goes on behind its first point [m]
    real(dp), intent(in) :: inclination     !! of the rail to the track's centre, beyond its file [rad]
    real(dp), intent(in) :: back_to_back    !! [m]
    real(dp), intent(in) :: rolling_radius  !! at the centred contact point [m]
    type(pair_type), intent(out) :: pair
    type(error_type), allocatable, intent(out) :: error
    type(scan_type) :: scan
    real(dp), parameter :: least_head = 0.04_dp    ! width of a rail's head, but of models [m]
    real(dp) :: top, above, lift, r(2), angle, curvature
    logical :: ok

    pair%rail = rail
    pair%wheel = wheel
    if (abs(inclination) > 0) call turn(pair%rail, inclination)

    top = maxval(pair%rail%a(2, 1, :))
    call find_gauge_point(pair%rail, top - gauge_depth, top - hidden, r, ok)
    if (.not. ok .and. abs(inclination) > 0) then
      call refuse(error, 'a gauge face '//str(gauge_depth)//' m below the top of the turned rail', &
        'none on '//rail_file, group='track', variable='rail_inclination', detail=' = '//str(inclination)//' rad', &
        rest='; give a smaller angle, or a file that goes farther down')
      return
    else if (.not. ok) then
      call fatal_error(error, 'the rail has no gauge face '//str(gauge_depth)// &
        ' m below its top; &track gauge_depth must lie within the profile', rail_file)
      return
    end if
    pair%rail%a(1, 1, :) = pair%rail%a(1, 1, :) + gauge/2 - r(1)
    pair%rail%a(2, 1, :) = pair%rail%a(2, 1, :) - top
    pair%wheel%a(1, 1, :) = pair%wheel%a(1, 1, :) + back_to_back/2
    pair%gauge_face = gauge/2
    pair%crown = pair%rail%a(1, 1, maxloc(pair%rail%a(2, 1, 1:), 1))
    call set_stations(pair)
    call set_rail_curves(pair)

    ! The centred wheel is lowered until it touches.  Its contact point is then at the rolling radius.
    scan = new_scan(pair)
    ! A small rail has sharp corners, past which a search from far above would miss its top.
    above = 1
    if (maxval(pair%rail%a(1, 1, 1:)) - minval(pair%rail%a(1, 1, 1:)) < least_head) above = 5e-3_dp
    call touch(pair, scan, 1, size(pair%s), [0.0_dp, above - minval(pair%r(2, :))], 0.0_dp, 0.0_dp, &
      lift, pair%centred_station, ok)
    if (ok) then
      call curve_frame(pair%wheel, pair%centred_station, r, angle, curvature)
      call find_tread(pair)
      ! A wheel that stands on its flange has no flange face between tip and contact.
      ok = abs(angle) < 20*degree .and. pair%centred_station < pair%s(size(pair%s)) &
        .and. pair%steepest < count(pair%s <= pair%centred_station)
    end if
    if (.not. ok) then
      call fatal_error(error, '&track gauge = '//str(gauge)//' m with &wheelset back_to_back = '//str(back_to_back)// &
        ' m does not put the treads of '//wheel_file//' on '//rail_file//' at gauge_depth = '//str(gauge_depth)//' m')
      error%group = 'track'        ! the statement begins with the variable
      error%variable = 'gauge'
      return
    end if
    pair%axle_height = above - minval(pair%r(2, :)) + lift + r(2) + rolling_radius
    pair%wheel%a(2, 1, :) = pair%wheel%a(2, 1, :) - (r(2) + rolling_radius)
    pair%r(2, :) = pair%r(2, :) - (r(2) + rolling_radius)
    pair%flange_tip = pair%r(:, minloc(pair%r(2, :), 1))
  end subroutine place_profiles

  !> Turn a curve by an angle [rad] from y to z. About which point does not matter: what is placed is moved afterwards.
  pure subroutine turn(c, angle)
    type(curve_type), intent(inout) :: c
    real(dp), intent(in) :: angle
    integer :: i, k

    do i = 0, c%n
      do k = 1, 4
        c%a(:, k, i) = rolled(c%a(:, k, i), angle)
      end do
    end do
  end subroutine turn

  !> The rail's innermost point r [m] from its top down to height z [m].  `ok` is false where the rail does not reach z, neither by
  !> its curve nor by points that lie farther out than the curve's first point, down to `hidden` [m].
  subroutine find_gauge_point(rail, z, hidden, r, ok)
    type(curve_type), intent(in) :: rail
    real(dp), intent(in) :: z, hidden
    real(dp), intent(out) :: r(2)
    logical, intent(out) :: ok
    type(bracket_type) :: range
    real(dp) :: d1(2), d2(2), s
    integer :: i, iter

    do i = 1, rail%n
      if (rail%a(2, 1, i) > z) exit
    end do
    ok = i <= rail%n .and. (i > 1 .or. hidden <= z)
    if (.not. ok) return
    r = rail%a(:, 1, i)
    if (i > 1) then
      i = i - 1
      range = bracket_type(rail%s(i), rail%a(2, 1, i) - z, rail%s(i + 1), rail%a(2, 1, i + 1) - z)
      do iter = 1, 100
        s = range%guess()
        call curve_point(rail, s, i, r, d1, d2)
        if (abs(r(2) - z) < 1e-15_dp) exit
        call range%narrow(s, r(2) - z)
      end do
    end if
    call find_innermost(rail, i + 1, r)
  end subroutine find_gauge_point

  !> Put the innermost point of a rail's gauge side, from knot `first` up to the top, in the place of r [m] where that is farther
  !> out.
  subroutine find_innermost(rail, first, r)
    type(curve_type), intent(in) :: rail
    integer, intent(in) :: first
    real(dp), intent(inout) :: r(2)
    real(dp), parameter :: same = 1e-7_dp  ! on an upright side all points are as far in, but for rounding [m]
    type(bracket_type) :: range
    real(dp) :: d1(2), d2(2), end1(2), end2(2), point(2), s
    integer :: i, k, last, iter

    last = maxloc(rail%a(2, 1, 1:), 1)
    if (first > last) return
    k = first - 1 + minloc(rail%a(1, 1, first:last), 1)
    if (rail%a(1, 1, k) > r(1) - same) return
    r = rail%a(:, 1, k)
    if (k == 1 .or. k == rail%n) return
    ! y of the curve is least near its knot with the least y, where dy/ds = 0.
    i = k
    call curve_point(rail, rail%s(k - 1), i, point, end1, d2)
    call curve_point(rail, rail%s(k + 1), i, point, end2, d2)
    if (end1(1) >= 0 .or. end2(1) <= 0) return
    range = bracket_type(rail%s(k - 1), end1(1), rail%s(k + 1), end2(1))
    do iter = 1, 100
      s = range%guess()
      call curve_point(rail, s, i, point, d1, d2)
      if (abs(d1(1)) < 1e-12_dp) exit
      call range%narrow(s, d1(1))
    end do
    if (point(1) < r(1)) r = point
  end subroutine find_innermost

  !> The steepest station of the flange face, between the flange's tip and the running point, and the last station of
  !> the tread before its chamfer.
  pure subroutine find_tread(pair)
    type(pair_type), intent(inout) :: pair
    real(dp), parameter :: chamfer = 25*degree   ! a tread is less steep
    integer :: tip, running

    tip = minloc(pair%r(2, :), 1)
    running = count(pair%s <= pair%centred_station)
    pair%steepest = min(tip, running) - 1 + maxloc(pair%angle(min(tip, running):running), 1)
    pair%tread_end = running + findloc(pair%angle(running + 1:) > chamfer, .true., 1) - 1
    if (pair%tread_end < running) pair%tread_end = size(pair%s)
  end subroutine find_tread

  !> The wheel's stations: every knot of the profile except those that are too near to the one before, and between two
  !> knots as many as the largest spacing asks for.
  pure subroutine set_stations(pair)
    type(pair_type), intent(inout) :: pair
    real(dp), parameter :: largest_spacing = 0.26e-3_dp, least_spacing = 0.1e-3_dp   ! distances of stations [m]
    real(dp) :: s(ceiling(pair%wheel%last()/least_spacing) + 2*pair%wheel%n), previous, d2(2)
    integer :: n, i, j, k, cuts

    n = 1
    s(1) = pair%wheel%s(1)
    do i = 2, pair%wheel%n
      previous = s(n)
      if (pair%wheel%s(i) - previous < least_spacing .and. i < pair%wheel%n) cycle
      cuts = ceiling((pair%wheel%s(i) - previous)/largest_spacing)
      do j = 1, cuts
        n = n + 1
        s(n) = previous + j*(pair%wheel%s(i) - previous)/cuts
      end do
    end do
    pair%s = s(:n)
    allocate (pair%r(2, n), pair%t(2, n), pair%angle(n), pair%curvature(n))
    k = 1
    do i = 1, n
      call curve_point(pair%wheel, pair%s(i), k, pair%r(:, i), pair%t(:, i), d2)
      pair%angle(i) = atan2(pair%t(2, i), pair%t(1, i))
      pair%curvature(i) = mean_curvature(pair%wheel, pair%s(i))
    end do
  end subroutine set_stations

  !> Set the tangent angles at the rail's knots, made to fall from the gauge side to the field side, and the rail's curvature as a
  !> continuous function of the tangent angle. The arc's curvature jumps where an angle belongs to a whole stretch, as on a
  !> straight gauge face: the strip modulus of all wheel stations with that angle would jump at one roll angle, and with it
  !> the force. So the curvature is averaged over angles too, with weights that fall linearly to 0 at twice `half`.
  pure subroutine set_rail_curves(pair)
    type(pair_type), intent(inout) :: pair
    real(dp), parameter :: half = 0.1_dp*degree
    integer, parameter :: steps = nint(half/angle_step)
    real(dp) :: low
    real(dp), allocatable :: x(:), mean(:)
    integer :: i, n, round

    pair%rail_angle = atan2(pair%rail%a(2, 2, 1:), pair%rail%a(1, 2, 1:))
    do i = 2, pair%rail%n
      pair%rail_angle(i) = min(pair%rail_angle(i), pair%rail_angle(i - 1))
    end do
    low = pair%rail_angle(pair%rail%n)
    n = max(2, ceiling((pair%rail_angle(1) - low)/angle_step) + 1)
    allocate (x(n), mean(n))
    do i = 1, n
      x(i) = -mean_curvature(pair%rail, rail_station(pair, low + (i - 1)*angle_step))
    end do
    do round = 1, 2
      do i = 1, n
        associate (from => max(1, i - steps), to => min(n, i + steps))
          mean(i) = sum(x(from:to))/(to - from + 1)
        end associate
      end do
      x = mean
    end do
    pair%rail_curvature = x
  end subroutine set_rail_curves

end module placement
