!> Depth of the wheel's stations inside the rail in one pose of the axle, and the pose in which rigid bodies touch.
module station_scan
  use curve, only: curve_point, curve_type, find_interval
  use kinds, only: dp
  use wheel_rail_pair, only: pair_type
  implicit none
  private
  public :: scan_type, new_scan, scan_depth, deepest, touch, set_depth

  !> Depths of the wheel's stations in one pose.
  type :: scan_type
    real(dp), allocatable :: point(:, :)   !! position, track frame, (2, n) [m]
    real(dp), allocatable :: depth(:)      !! g: depth inside the rail along the rail's normal [m]
    real(dp), allocatable :: slope(:)      !! dg/ds
    real(dp), allocatable :: normal(:, :)  !! the rail's outward normal at the foot, (2, n)
    real(dp), allocatable :: foot(:)       !! station on the rail of the nearest point [m]
    integer, allocatable :: interval(:)    !! knot interval of the foot
    real(dp), allocatable :: rate(:)       !! d(foot)/d(displacement of the wheel's station along the rail's tangent)
    real(dp), allocatable :: step(:)       !! last Newton step of the foot [m]
    real(dp) :: centre(2) = 0, roll = 0    !! pose of the scan [m, rad]
    logical :: fresh = .true.              !! the next scan searches the feet anew; callers clear it to go on from known feet
  end type scan_type

contains

  !> A scan with room for all stations of a pair's wheel, without feet.
  pure function new_scan(pair) result(scan)
    type(pair_type), intent(in) :: pair
    type(scan_type) :: scan
    integer :: n

    n = size(pair%s)
    allocate (scan%point(2, n), scan%normal(2, n), scan%depth(n), scan%slope(n), scan%foot(n), scan%step(n), source=0.0_dp)
    allocate (scan%rate(n), source=1.0_dp)
    allocate (scan%interval(n), source=1)
  end function new_scan

  !> Depth inside the rail of the wheel's stations first..last, in a pose.  The feet of an earlier scan start the
  !> search.
  pure subroutine scan_depth(pair, centre, roll, first, last, scan)
    type(pair_type), intent(in) :: pair
    real(dp), intent(in) :: centre(2), roll   !! position of the axle, track frame, and roll angle [m, rad]
    integer, intent(in) :: first, last
    type(scan_type), intent(inout) :: scan
    real(dp) :: y(2), z(2), t(2), move(2)
    integer :: i

    y = [cos(roll), sin(roll)]
    z = [-y(2), y(1)]
    do i = first, last
      scan%point(:, i) = centre + (pair%r(1, i)*y + pair%r(2, i)*z)
    end do
    if (scan%fresh) then
      ! The search begins at the rail's knot nearest to the first station.
      associate (knot => pair%rail%a(:, 1, 1:), p => scan%point(:, first))
        scan%interval(first) = minloc((knot(1, :) - p(1))**2 + (knot(2, :) - p(2))**2, 1)
      end associate
      scan%foot(first) = pair%rail%s(scan%interval(first))
      do i = first, last
        if (i > first) then
          scan%foot(i) = scan%foot(i - 1)
          scan%interval(i) = scan%interval(i - 1)
        end if
        call set_depth(pair%rail, 1, scan%point(:, i), scan%foot(i), scan%interval(i), scan%depth(i), &
          scan%normal(:, i), scan%rate(i), scan%step(i))
      end do
    else
      ! The feet are expected to move along the rail with the wheel.
      move = centre - scan%centre
      do i = first, last
        scan%foot(i) = scan%foot(i) + (move(1)*scan%normal(2, i) - move(2)*scan%normal(1, i))*scan%rate(i)
      end do
      call set_depth(pair%rail, last - first + 1, scan%point(:, first:last), scan%foot(first:last), scan%interval(first:last), &
        scan%depth(first:last), scan%normal(:, first:last), scan%rate(first:last), scan%step(first:last))
    end if
    scan%centre = centre
    scan%roll = roll
    do i = first, last
      t = pair%t(1, i)*y + pair%t(2, i)*z
      scan%slope(i) = -(scan%normal(1, i)*t(1) + scan%normal(2, i)*t(2))
    end do
  end subroutine scan_depth

  !> Depths [m] of n points inside a rail and the rail's outward normals at their feet.  The foot of a point p is where
  !> p is nearest to the rail's curve r(s): there p - r(s) is normal to the curve.  On entry `foot` and `interval` belong to
  !> points nearby, on return to the points p.  When a point moves along the rail's tangent, its foot moves by `rate`
  !> times that distance.
  pure subroutine set_depth(rail, n, p, foot, interval, depth, normal, rate, step)
    type(curve_type), intent(in) :: rail
    integer, intent(in) :: n
    real(dp), intent(in) :: p(2, n)            !! points, track frame [m]
    real(dp), intent(inout) :: foot(n)         !! station of the foot on the rail [m]
    integer, intent(inout) :: interval(n)      !! knot interval of the foot
    real(dp), intent(out) :: depth(n), normal(2, n), rate(n)
    real(dp), intent(out) :: step(n)           !! last Newton step of the foot [m]
    real(dp), parameter :: tolerance = 3e-6_dp ! step [m]: the foot's error is about the square of it
    integer :: i, iter

    do i = 1, n
      call find_interval(rail%s, foot(i), interval(i))
    end do
    call step_foot(rail%n, rail%s, rail%a, n, p, interval, foot, depth, normal, rate, step)
    do i = 1, n
      do iter = 1, 40
        if (abs(step(i)) < tolerance) exit
        call find_interval(rail%s, foot(i), interval(i))
        call step_foot(rail%n, rail%s, rail%a, 1, p(:, i), interval(i), foot(i), depth(i), normal(:, i), &
          rate(i), step(i))
      end do
      if (abs(step(i)) >= tolerance) call search_foot(rail, p(:, i), foot(i), interval(i), depth(i), normal(:, i), rate(i), step(i))
    end do
  end subroutine set_depth

  !> The foot of one point where Newton's method finds none: far from a curve through noisy points or waves, the distance has a
  !> minimum at each of them. The nearest knot and its neighbours enclose the least one, which the golden section finds.
  pure subroutine search_foot(rail, p, foot, interval, depth, normal, rate, step)
    type(curve_type), intent(in) :: rail
    real(dp), intent(in) :: p(2)
    real(dp), intent(out) :: foot, depth, normal(2), rate, step
    integer, intent(inout) :: interval
    real(dp), parameter :: golden = 0.5_dp*(sqrt(5.0_dp) - 1), close = 1e-9_dp    ! ratio, and distance of the ends [m]
    real(dp) :: low, high, a, b, r(2), d1(2), d2(2)
    integer :: knot

    knot = minloc((rail%a(1, 1, 1:) - p(1))**2 + (rail%a(2, 1, 1:) - p(2))**2, 1)
    interval = knot
    low = rail%s(max(knot - 1, 1))
    high = rail%s(min(knot + 1, rail%n))
    ! A foot beyond an end is on the straight line that continues the curve.
    if (knot == 1) low = low - norm2(rail%a(:, 1, knot) - p)
    if (knot == rail%n) high = high + norm2(rail%a(:, 1, knot) - p)
    do while (high - low > close)
      a = high - golden*(high - low)
      b = low + golden*(high - low)
      if (squared(a) < squared(b)) then
        high = b
      else
        low = a
      end if
    end do
    foot = (low + high)/2
    call curve_point(rail, foot, interval, r, d1, d2)
    normal = [-d1(2), d1(1)]/norm2(d1)
    depth = -dot_product(p - r, normal)
    rate = 1/max(dot_product(d1, d1) - dot_product(p - r, d2), 0.2_dp)
    step = 0

  contains

    !> The squared distance of the point from a place on the curve [m2].
    pure real(dp) function squared(s)
      real(dp), intent(in) :: s
      real(dp) :: place(2), first(2), second(2)
      integer :: guess

      guess = interval
      call curve_point(rail, s, guess, place, first, second)
      squared = dot_product(p - place, p - place)
    end function squared

  end subroutine search_foot

  !> One Newton step for (p - r(s)).r'(s) = 0. The loop has no branches, so that the compiler can treat two points at a time.
  !> Depth and normal are updated to the new foot by Taylor's series, which is exact enough once the step is below
  !> `tolerance`.
  pure subroutine step_foot(knots, s, a, n, p, interval, foot, depth, normal, rate, step)
    integer, intent(in) :: knots, n
    real(dp), intent(in) :: s(0:knots), a(2, 4, 0:knots), p(2, n)
    integer, intent(in) :: interval(n)
    real(dp), intent(inout) :: foot(n)
    real(dp), intent(out) :: depth(n), normal(2, n), rate(n), step(n)
    real(dp), parameter :: longest = 3e-3_dp   ! step [m]
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

  !> The deepest point of the stations first..last of a scan, on the cubic Hermite interpolant of the depth. The deepest
  !> point need not be beside the deepest station: two places may be as deep as each other within 0.1 um. So all tops count.
  pure subroutine deepest(pair, scan, first, last, depth, station, node)
    type(pair_type), intent(in) :: pair
    type(scan_type), intent(in) :: scan
    integer, intent(in) :: first, last
    real(dp), intent(out) :: depth, station   !! [m]
    integer, intent(out) :: node              !! index of the last station before the point
    real(dp) :: h, a, b, da, db, c2, c3, t, top
    integer :: i

    node = first - 1 + maxloc(scan%depth(first:last), 1)
    depth = scan%depth(node)
    station = pair%s(node)
    do i = first, last - 1
      if (scan%slope(i) <= 0 .or. scan%slope(i + 1) >= 0) cycle
      h = pair%s(i + 1) - pair%s(i)
      a = scan%depth(i)
      b = scan%depth(i + 1)
      da = h*scan%slope(i)
      db = h*scan%slope(i + 1)
      c2 = 3*(b - a) - 2*da - db
      c3 = 2*(a - b) + da + db
      t = max(0.0_dp, min(da/(sqrt(max(c2**2 - 3*c3*da, 0.0_dp)) - c2), 1.0_dp))
      top = a + t*(da + t*(c2 + t*c3))
      if (top > depth) then
        depth = top
        station = pair%s(i) + t*h
        node = i
      end if
    end do
  end subroutine deepest

  !> Move the wheel along (-sin alpha, cos alpha) from `centre` until the deepest of the stations first..last is on the rail.
  !> `ok` is false where they pass beside the rail.
  pure subroutine touch(pair, scan, first, last, centre, roll, alpha, shift, station, ok)
    type(pair_type), intent(in) :: pair
    type(scan_type), intent(inout) :: scan
    integer, intent(in) :: first, last
    real(dp), intent(in) :: centre(2), roll, alpha
    real(dp), intent(out) :: shift        !! along the direction [m]
    real(dp), intent(out) :: station      !! station of the wheel that touches [m]
    logical, intent(out) :: ok
    real(dp), parameter :: least_climb = 0.15_dp   ! cosine between the rail's normal and the direction: 81 degrees
    real(dp) :: along(2), depth, climb
    integer :: iter, node

    along = [-sin(alpha), cos(alpha)]
    shift = 0
    ok = .false.
    do iter = 1, 60
      call scan_depth(pair, centre + shift*along, roll, first, last, scan)
      scan%fresh = .false.
      call deepest(pair, scan, first, last, depth, station, node)
      climb = dot_product(scan%normal(:, node), along)
      if (abs(depth) < 2e-14_dp) exit
      shift = shift + depth/max(climb, least_climb)
      if (abs(shift) > 2) return
    end do
    ok = climb > least_climb .and. abs(depth) < 1e-11_dp
  end subroutine touch

end module station_scan
