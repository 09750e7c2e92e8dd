!> Depth of the wheel's stations inside the rail, in one pose of the axle; rigid touching.
module station_scan
  use curve, only: curve_type, find_interval
  use kinds, only: dp
  use wheel_rail_pair, only: pair_type
  implicit none
  private
  public :: scan_type, new_scan, scan_depth, keep_feet, deepest, touch, set_depth

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

contains

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

  !> Scan those stations alone that may be the deepest, low..high, with one
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

end module station_scan
