!> A wheel on its rail: placement of the two profiles in the track frame, depth
!> of every station of the wheel inside the rail, rigid touching.
!>
!> Everything here is the LEFT wheel and rail (Y outward, Z up, roll phi lifts
!> the left wheel); the right side is the same at (-y, z, -phi).  With the yaw
!> angle held at zero the cross-section through the axle is the whole contact
!> geometry.
module wheel_rail_pair
  use curve, only: curve_point, curve_frame, curve_type, find_interval, near_interval
  use errors, only: error_type, fatal_error
  use kinds, only: dp, degree
  use profile, only: profile_type
  use text, only: str
  implicit none
  private
  public :: pair_type, scan_type, place_profiles, same_pair, new_scan, scan_depth, keep_feet, deepest, &
    touch, wheel_station, rolled, rail_curvature, rail_point, set_depth

  !> A pair of placed profiles.
  type :: pair_type
    type(curve_type) :: rail           !! left rail in the track frame [m]
    type(curve_type) :: wheel          !! left wheel in the wheelset frame, origin at the axle centre [m]
    real(dp) :: axle_height = 0        !! of the centred, rigid, touching wheelset [m]
    real(dp) :: centred_station = 0    !! of the wheel's contact point then [m]
    real(dp) :: gauge_face = 0         !! Y of the rail's gauge point [m]
    real(dp) :: crown = 0              !! Y of the rail's highest point [m]
    real(dp) :: flange_tip(2) = 0      !! lowest point of the wheel, wheelset frame [m]
    ! The wheel's stations: every knot of the profile but those too near, and between them to at most max_spacing.
    real(dp), allocatable :: s(:)          !! station [m]
    real(dp), allocatable :: r(:, :)       !! position, wheelset frame, (2, n) [m]
    real(dp), allocatable :: t(:, :)       !! dr/ds, (2, n)
    real(dp), allocatable :: angle(:)      !! tangent angle [rad]
    real(dp), allocatable :: curvature(:)  !! convex positive, mean over `window` [1/m]
    integer :: steepest = 0                !! station of the flange face
    integer :: tread_end = 0               !! the last before a chamfer
    real(dp), allocatable :: rail_angle(:) !! tangent angle at the rail's knots, made monotone [rad]
  end type pair_type

  !> The wheel's stations in one pose.
  type :: scan_type
    real(dp), allocatable :: point(:, :)   !! position, track frame, (2, n) [m]
    real(dp), allocatable :: depth(:)      !! g: depth inside the rail along its normal [m]
    real(dp), allocatable :: slope(:)      !! dg/ds
    real(dp), allocatable :: normal(:, :)  !! the rail's outward normal at the foot, (2, n)
    real(dp), allocatable :: foot(:)       !! station on the rail of the nearest point [m]
    integer, allocatable :: interval(:)    !! its knot interval
    real(dp), allocatable :: rate(:)       !! of the foot, per move of the station along the rail
    real(dp), allocatable :: step(:)       !! of the search for the foot [m]
    real(dp) :: centre(2) = 0, roll = 0    !! pose of the scan [m, rad]
    logical :: fresh = .true.              !! no feet known yet
  end type scan_type

  real(dp), parameter :: max_spacing = 0.26e-3_dp, least_spacing = 0.1e-3_dp   !! of the wheel's stations [m]
  real(dp), parameter :: window = 2e-3_dp   !! arc over which curvature is a mean: below the size of a patch [m]

contains

  !> Put wheel and rail where gauge, back-to-back and rolling radius say.
  subroutine place_profiles(wheel, rail, gauge, gauge_depth, back_to_back, rolling_radius, pair, error)
    type(profile_type), intent(in) :: wheel, rail
    real(dp), intent(in) :: gauge           !! between the rails, gauge_depth below their top [m]
    real(dp), intent(in) :: gauge_depth     !! [m]
    real(dp), intent(in) :: back_to_back    !! [m]
    real(dp), intent(in) :: rolling_radius  !! at the centred contact point [m]
    type(pair_type), intent(out) :: pair
    type(error_type), allocatable, intent(out) :: error
    type(scan_type) :: work
    real(dp) :: top, lift, r(2), angle, curvature
    integer :: i, low(1)
    logical :: ok

    pair%rail = rail%curve
    pair%wheel = wheel%curve

    top = maxval(pair%rail%a(2, 1, :))
    call gauge_point(pair%rail, top - gauge_depth, r, ok)
    if (.not. ok) then
      call fatal_error(error, rail%file//': the rail has no gauge face '//str(gauge_depth)// &
        ' m below its top; &track gauge_depth must lie within the profile')
      return
    end if
    pair%rail%a(1, 1, :) = pair%rail%a(1, 1, :) + gauge/2 - r(1)
    pair%rail%a(2, 1, :) = pair%rail%a(2, 1, :) - top
    pair%wheel%a(1, 1, :) = pair%wheel%a(1, 1, :) + back_to_back/2
    pair%gauge_face = gauge/2
    pair%crown = pair%rail%a(1, 1, maxloc(pair%rail%a(2, 1, :), 1) - 1 + lbound(pair%rail%a, 3))
    call set_stations(pair)

    ! Lower the centred wheel until it touches; its contact point is then at
    ! the rolling radius.
    work = new_scan(pair)
    call touch(pair, work, 1, size(pair%s), [0.0_dp, 1.0_dp - minval(pair%r(2, :))], 0.0_dp, 0.0_dp, &
      lift, pair%centred_station, ok)
    if (ok) then
      call curve_frame(pair%wheel, pair%centred_station, r, angle, curvature)
      call find_tread(pair)
      ! A wheel that stands on its flange has no flange face between tip and contact.
      ok = abs(angle) < 20*degree .and. pair%centred_station < pair%s(size(pair%s)) &
        .and. pair%steepest < count(pair%s <= pair%centred_station)
    end if
    if (.not. ok) then
      call fatal_error(error, '&track gauge = '//str(gauge)//' m with &wheelset back_to_back = '// &
        str(back_to_back)//' m does not put the treads of '//wheel%file//' on '//rail%file)
      return
    end if
    pair%axle_height = 1 - minval(pair%r(2, :)) + lift + r(2) + rolling_radius
    pair%wheel%a(2, 1, :) = pair%wheel%a(2, 1, :) - (r(2) + rolling_radius)
    pair%r(2, :) = pair%r(2, :) - (r(2) + rolling_radius)
    low = minloc(pair%r(2, :))
    i = low(1)
    pair%flange_tip = pair%r(:, i)
  end subroutine place_profiles

  !> Whether two placed pairs are the same, number by number.
  pure logical function same_pair(a, b) result(same)
    type(pair_type), intent(in) :: a, b

    same = same_curve(a%wheel, b%wheel)
    if (same) same = same_curve(a%rail, b%rail)
  end function same_pair

  pure logical function same_curve(a, b) result(same)
    type(curve_type), intent(in) :: a, b

    same = a%n == b%n
    if (same) same = all(abs(a%s(:a%n) - b%s(:b%n)) <= 0) .and. all(abs(a%a - b%a) <= 0)
  end function same_curve

  !> The point of the rail's gauge side at height z.
  subroutine gauge_point(rail, z, r, ok)
    type(curve_type), intent(in) :: rail
    real(dp), intent(in) :: z
    real(dp), intent(out) :: r(2)
    logical, intent(out) :: ok
    real(dp) :: d1(2), d2(2), s, low, high
    integer :: i, iter

    do i = 1, rail%n
      if (rail%a(2, 1, i) > z) exit
    end do
    ok = i > 1 .and. i <= rail%n
    if (.not. ok) return
    i = i - 1
    low = rail%s(i)
    high = rail%s(i + 1)
    s = low
    do iter = 1, 20
      call curve_point(rail, s, i, r, d1, d2)
      s = min(max(s + (z - r(2))/d1(2), low), high)
    end do
    call curve_point(rail, s, i, r, d1, d2)
    if (abs(r(2) - z) < 1e-12_dp) return
    ! Where the face is no graph over its height, Newton's method may find nothing.
    do iter = 1, 60
      s = (low + high)/2
      call curve_point(rail, s, i, r, d1, d2)
      if (r(2) > z) high = s
      if (r(2) <= z) low = s
    end do
  end subroutine gauge_point

  !> The flange face, between the flange's tip and the running point, and the tread up to its chamfer.
  subroutine find_tread(pair)
    type(pair_type), intent(inout) :: pair
    real(dp), parameter :: chamfer = 25*degree
    integer :: tip, running

    tip = minloc(pair%r(2, :), 1)
    running = count(pair%s <= pair%centred_station)
    pair%steepest = min(tip, running) - 1 + maxloc(pair%angle(min(tip, running):running), 1)
    pair%tread_end = running + findloc(pair%angle(running + 1:) > chamfer, .true., 1) - 1
    if (pair%tread_end < running) pair%tread_end = size(pair%s)
  end subroutine find_tread

  subroutine set_stations(pair)
    type(pair_type), intent(inout) :: pair
    real(dp) :: s(ceiling(pair%wheel%last()/least_spacing) + 2*pair%wheel%n), from, r(2), d1(2), d2(2)
    integer :: n, i, j, k, cuts

    n = 1
    s(1) = pair%wheel%s(1)
    do i = 2, pair%wheel%n
      from = s(n)
      if (pair%wheel%s(i) - from < least_spacing .and. i < pair%wheel%n) cycle
      cuts = ceiling((pair%wheel%s(i) - from)/max_spacing)
      do j = 1, cuts
        n = n + 1
        s(n) = from + j*(pair%wheel%s(i) - from)/cuts
      end do
    end do
    pair%s = s(:n)
    allocate (pair%r(2, n), pair%t(2, n), pair%angle(n), pair%curvature(n))
    k = 1
    do i = 1, n
      call curve_point(pair%wheel, pair%s(i), k, r, d1, d2)
      pair%r(:, i) = r
      pair%t(:, i) = d1
      pair%angle(i) = atan2(d1(2), d1(1))
      pair%curvature(i) = mean_curvature(pair%wheel, pair%s(i))
    end do
    allocate (pair%rail_angle(pair%rail%n))
    k = 1
    do i = 1, pair%rail%n
      call curve_point(pair%rail, pair%rail%s(i), k, r, d1, d2)
      pair%rail_angle(i) = atan2(d1(2), d1(1))
      if (i > 1) pair%rail_angle(i) = min(pair%rail_angle(i), pair%rail_angle(i - 1))
    end do
  end subroutine set_stations

  pure function new_scan(pair) result(work)
    type(pair_type), intent(in) :: pair
    type(scan_type) :: work
    integer :: n

    n = size(pair%s)
    allocate (work%point(2, n), work%depth(n), work%slope(n), work%normal(2, n), work%foot(n), work%interval(n), &
      work%rate(n), work%step(n))
    work%point = 0
    work%depth = 0
    work%slope = 0
    work%normal = 0
    work%foot = 0
    work%interval = 1
    work%rate = 1
    work%step = 0
    work%fresh = .true.
  end function new_scan

  !> A vector of the wheelset frame in the track frame.
  pure function rolled(r, roll) result(x)
    real(dp), intent(in) :: r(2), roll
    real(dp) :: x(2)

    x = [r(1)*cos(roll) - r(2)*sin(roll), r(1)*sin(roll) + r(2)*cos(roll)]
  end function rolled

  !> Depth inside the rail of the wheel's stations first..last, with the axle
  !> centre at `centre` [m] and the roll angle `roll` [rad].  Feet of an earlier
  !> scan start the search.
  pure subroutine scan_depth(pair, centre, roll, first, last, work)
    type(pair_type), intent(in) :: pair
    real(dp), intent(in) :: centre(2), roll
    integer, intent(in) :: first, last
    type(scan_type), intent(inout) :: work
    real(dp) :: y(2), z(2), t(2)
    integer :: i

    y = [cos(roll), sin(roll)]
    z = [-y(2), y(1)]
    do i = first, last
      work%point(:, i) = centre + (pair%r(1, i)*y + pair%r(2, i)*z)
    end do
    if (work%fresh) then
      call nearest_knot(pair%rail, work%point(:, first), work%interval(first), work%foot(first))
      do i = first, last
        if (i > first) work%foot(i) = work%foot(i - 1)
        if (i > first) work%interval(i) = work%interval(i - 1)
        call set_depth(pair%rail, 1, work%point(:, i), work%foot(i), work%interval(i), work%depth(i), &
          work%normal(:, i), work%rate(i), work%step(i))
      end do
    else
      call move_feet(work, centre - work%centre, first, last)
      i = last - first + 1
      call set_depth(pair%rail, i, work%point(:, first:last), work%foot(first:last), work%interval(first:last), &
        work%depth(first:last), work%normal(:, first:last), work%rate(first:last), &
        work%step(first:last))
    end if
    work%centre = centre
    work%roll = roll
    do i = first, last
      t = pair%t(1, i)*y + pair%t(2, i)*z
      work%slope(i) = -(work%normal(1, i)*t(1) + work%normal(2, i)*t(2))
    end do
  end subroutine scan_depth

  !> The same of those stations alone that may be the deepest, low..high, with one
  !> more to either side; the depth of the others becomes an upper bound.
  pure subroutine scan_deepest(pair, centre, roll, first, last, work, low, high)
    type(pair_type), intent(in) :: pair
    real(dp), intent(in) :: centre(2), roll
    integer, intent(in) :: first, last
    type(scan_type), intent(inout) :: work
    integer, intent(out) :: low, high
    real(dp) :: move(2), way, least

    low = first
    high = last
    if (.not. work%fresh .and. abs(roll - work%roll) <= 0) then
      ! No depth changes by more than the wheel moves.
      move = centre - work%centre
      way = norm2(move)
      least = maxval(work%depth(first:last)) - 2*way
      low = max(first, first + findloc(work%depth(first:last) >= least, .true., 1) - 2)
      high = min(last, first + findloc(work%depth(first:last) >= least, .true., 1, back=.true.))
      call move_feet(work, move, first, low - 1)
      call move_feet(work, move, high + 1, last)
      work%depth(first:low - 1) = work%depth(first:low - 1) + way
      work%depth(high + 1:last) = work%depth(high + 1:last) + way
    end if
    call scan_depth(pair, centre, roll, low, high, work)
  end subroutine scan_deepest

  !> Let a scan go on from the feet of another.
  pure subroutine keep_feet(from, first, last, work)
    type(scan_type), intent(in) :: from
    integer, intent(in) :: first, last
    type(scan_type), intent(inout) :: work

    work%centre = from%centre
    work%roll = from%roll
    work%fresh = from%fresh
    work%normal(:, first:last) = from%normal(:, first:last)
    work%foot(first:last) = from%foot(first:last)
    work%interval(first:last) = from%interval(first:last)
    work%rate(first:last) = from%rate(first:last)
  end subroutine keep_feet

  !> Where the feet are expected after a move of the wheel.
  pure subroutine move_feet(work, move, first, last)
    type(scan_type), intent(inout) :: work
    real(dp), intent(in) :: move(2)
    integer, intent(in) :: first, last
    integer :: i

    do i = first, last
      work%foot(i) = work%foot(i) + (move(1)*work%normal(2, i) - move(2)*work%normal(1, i))*work%rate(i)
    end do
  end subroutine move_feet

  !> Depth [m] of points inside the rail along the rail's normal, and that normal.  `foot`
  !> and `interval` are those of points nearby on entry, their own on return; a move of the
  !> point along the rail's tangent moves the foot by `rate` times that.  `step` is the last of the
  !> search for the foot [m].
  pure subroutine set_depth(rail, n, p, foot, interval, depth, normal, rate, step)
    type(curve_type), intent(in) :: rail
    integer, intent(in) :: n
    real(dp), intent(in) :: p(2, n)        !! track frame [m]
    real(dp), intent(inout) :: foot(n)
    integer, intent(inout) :: interval(n)
    real(dp), intent(out) :: depth(n), normal(2, n), rate(n), step(n)
    real(dp), parameter :: tolerance = 3e-6_dp   ! [m]; Newton squares it
    integer :: i, iter

    do i = 1, n
      call find_interval(rail%s, foot(i), interval(i))
    end do
    call step_foot(rail%n, rail%s, rail%a, n, p, interval, foot, depth, normal, rate, step)
    do i = 1, n
      do iter = 1, 200
        if (abs(step(i)) < tolerance) exit
        call find_interval(rail%s, foot(i), interval(i))
        call step_foot(rail%n, rail%s, rail%a, 1, p(:, i), interval(i), foot(i), depth(i), normal(:, i), &
          rate(i), step(i))
      end do
    end do
  end subroutine set_depth

  !> A step of Newton's method on (p - r(s)).r'(s) = 0; free of branches, so that it goes
  !> for two points at a time.  Depth and normal follow the step, when it is tiny, by
  !> Taylor's series.
  pure subroutine step_foot(knots, s, a, n, p, interval, foot, depth, normal, rate, step)
    integer, intent(in) :: knots, n
    real(dp), intent(in) :: s(0:knots), a(2, 4, 0:knots), p(2, n)
    integer, intent(in) :: interval(n)
    real(dp), intent(inout) :: foot(n)
    real(dp), intent(out) :: depth(n), normal(2, n), rate(n), step(n)
    real(dp), parameter :: longest = 3e-3_dp   ! [m]
    real(dp) :: t, y, z, y1, z1, y2, z2, unit
    integer :: i, k

    do i = 1, n
      k = interval(i)
      t = foot(i) - s(k)
      y = p(1, i) - (a(1, 1, k) + t*(a(1, 2, k) + t*(a(1, 3, k) + t*a(1, 4, k))))
      z = p(2, i) - (a(2, 1, k) + t*(a(2, 2, k) + t*(a(2, 3, k) + t*a(2, 4, k))))
      y1 = a(1, 2, k) + t*(2*a(1, 3, k) + t*3*a(1, 4, k))
      z1 = a(2, 2, k) + t*(2*a(2, 3, k) + t*3*a(2, 4, k))
      y2 = 2*a(1, 3, k) + 6*t*a(1, 4, k)
      z2 = 2*a(2, 3, k) + 6*t*a(2, 4, k)
      rate(i) = 1/max(y1**2 + z1**2 - y*y2 - z*z2, 0.2_dp)
      step(i) = max(-longest, min((y*y1 + z*z1)*rate(i), longest))
      foot(i) = foot(i) + step(i)
      y = y - step(i)*(y1 + 0.5_dp*step(i)*y2)
      z = z - step(i)*(z1 + 0.5_dp*step(i)*z2)
      y1 = y1 + step(i)*y2
      z1 = z1 + step(i)*z2
      unit = 1/sqrt(y1**2 + z1**2)
      normal(1, i) = -z1*unit
      normal(2, i) = y1*unit
      depth(i) = (z1*y - y1*z)*unit
    end do
  end subroutine step_foot

  pure subroutine nearest_knot(c, p, i, s)
    type(curve_type), intent(in) :: c
    real(dp), intent(in) :: p(2)
    integer, intent(out) :: i
    real(dp), intent(out) :: s

    i = minloc((c%a(1, 1, 1:) - p(1))**2 + (c%a(2, 1, 1:) - p(2))**2, 1)
    s = c%s(i)
  end subroutine nearest_knot

  !> The deepest point among the stations first..last of a scan, on the cubic
  !> Hermite interpolant of the depth.
  pure subroutine deepest(pair, work, first, last, depth, station, node)
    type(pair_type), intent(in) :: pair
    type(scan_type), intent(in) :: work
    integer, intent(in) :: first, last
    real(dp), intent(out) :: depth, station
    integer, intent(out) :: node              !! the nearest station below
    real(dp) :: h, t, g
    integer :: i

    node = first - 1 + maxloc(work%depth(first:last), 1)
    depth = work%depth(node)
    station = pair%s(node)
    do i = max(first, node - 1), min(last - 1, node)
      if (work%slope(i) <= 0 .or. work%slope(i + 1) >= 0) cycle
      h = pair%s(i + 1) - pair%s(i)
      call hermite_top(work%depth(i), h*work%slope(i), work%depth(i + 1), h*work%slope(i + 1), t, g)
      if (g > depth) then
        depth = g
        station = pair%s(i) + t*h
        node = i
      end if
    end do
  end subroutine deepest

  !> Maximum of the Hermite cubic with values a, b and slopes da > 0 > db on [0, 1].
  pure subroutine hermite_top(a, da, b, db, t, top)
    real(dp), intent(in) :: a, da, b, db
    real(dp), intent(out) :: t, top
    real(dp) :: c2, c3, disc

    c2 = 3*(b - a) - 2*da - db
    c3 = 2*(a - b) + da + db
    disc = sqrt(max(c2**2 - 3*c3*da, 0.0_dp))
    t = max(0.0_dp, min(da/(disc - c2), 1.0_dp))
    top = a + t*(da + t*(c2 + t*c3))
  end subroutine hermite_top

  !> Move the wheel along (-sin alpha, cos alpha) from `centre` until its stations
  !> first..last just touch the rail.  `ok` is false when they pass beside it.
  pure subroutine touch(pair, work, first, last, centre, roll, alpha, shift, station, ok)
    type(pair_type), intent(in) :: pair
    type(scan_type), intent(inout) :: work
    integer, intent(in) :: first, last
    real(dp), intent(in) :: centre(2), roll, alpha
    real(dp), intent(out) :: shift        !! along the direction [m]
    real(dp), intent(out) :: station      !! of the wheel's point that touches [m]
    logical, intent(out) :: ok
    real(dp), parameter :: steepest = 0.15_dp   ! cos of normal to direction, 81 degrees
    real(dp) :: along(2), depth, climb
    integer :: iter, node, low, high

    along = [-sin(alpha), cos(alpha)]
    shift = 0
    ok = .false.
    do iter = 1, 60
      call scan_deepest(pair, centre + shift*along, roll, first, last, work, low, high)
      work%fresh = .false.
      call deepest(pair, work, low, high, depth, station, node)
      climb = dot_product(work%normal(:, node), along)
      if (abs(depth) < 2e-14_dp) exit
      shift = shift + depth/max(climb, steepest)
      if (abs(shift) > 2) return
    end do
    ok = climb > steepest .and. abs(depth) < 1e-11_dp
  end subroutine touch

  !> The wheel's station nearest to where its tangent angle is `angle`, on the
  !> tread side of the flange face.
  pure real(dp) function wheel_station(pair, angle) result(s)
    type(pair_type), intent(in) :: pair
    real(dp), intent(in) :: angle
    integer :: low, high, mid

    low = pair%steepest
    high = pair%tread_end
    do while (high - low > 1)
      mid = (low + high)/2
      if (pair%angle(mid) < angle) then
        high = mid
      else
        low = mid
      end if
    end do
    s = pair%s(high)
  end function wheel_station

  !> Curvature (convex positive) [1/m] of the rail where its tangent angle is `angle`.
  pure real(dp) function rail_curvature(pair, angle) result(curvature)
    type(pair_type), intent(in) :: pair
    real(dp), intent(in) :: angle

    curvature = -mean_curvature(pair%rail, rail_station(pair, angle))
  end function rail_curvature

  !> The rail's point and normal where its tangent angle is `angle`; not `ok` beyond its ends.
  pure subroutine rail_point(pair, angle, point, normal, ok)
    type(pair_type), intent(in) :: pair
    real(dp), intent(in) :: angle
    real(dp), intent(out) :: point(2), normal(2)
    logical, intent(out) :: ok
    real(dp) :: s, d1(2), d2(2)
    integer :: i

    ok = angle < pair%rail_angle(1) .and. angle > pair%rail_angle(size(pair%rail_angle))
    s = rail_station(pair, angle)
    i = near_interval(pair%rail, s)
    call curve_point(pair%rail, s, i, point, d1, d2)
    normal = [-d1(2), d1(1)]/norm2(d1)
  end subroutine rail_point

  !> Station [m] of the rail where its tangent angle is `angle`.
  pure real(dp) function rail_station(pair, angle) result(station)
    type(pair_type), intent(in) :: pair
    real(dp), intent(in) :: angle
    real(dp) :: share
    integer :: low, high, mid

    low = 1
    high = size(pair%rail_angle)
    do while (high - low > 1)
      mid = (low + high)/2
      if (pair%rail_angle(mid) > angle) then
        low = mid
      else
        high = mid
      end if
    end do
    share = (pair%rail_angle(low) - angle)/max(pair%rail_angle(low) - pair%rail_angle(high), 1e-12_dp)
    share = max(0.0_dp, min(share, 1.0_dp))
    station = pair%rail%s(low) + share*(pair%rail%s(high) - pair%rail%s(low))
  end function rail_station

  !> d(angle)/ds [1/m], mean over a window about s: the curvature of profiles that
  !> were measured, or rounded to six decimals, is noise on a finer scale.
  pure real(dp) function mean_curvature(c, s) result(curvature)
    type(curve_type), intent(in) :: c
    real(dp), intent(in) :: s
    real(dp) :: r(2), a(2), b(2), d2(2)
    integer :: i

    i = near_interval(c, s)
    call curve_point(c, s - window/2, i, r, a, d2)
    call curve_point(c, s + window/2, i, r, b, d2)
    curvature = atan2(a(1)*b(2) - a(2)*b(1), dot_product(a, b))/window
  end function mean_curvature

end module wheel_rail_pair