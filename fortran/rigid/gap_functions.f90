!> Gaps between rigid wheels and rails, with their first and second derivatives.
!>
!> A contact is a zone of a wheel against the rail.  The gap is the least distance of the zone's points p(s, q)
!> from the rail, along the rail's outward normal n:
!>
!>     g(q) = min over s of d(s, q),   dg/dq = n . dp/dq,
!>     g_qq = d_qq - d_qs d_sq/d_ss    at the wheel's point s that is nearest.
!>
!> The second derivatives of d follow from kappa/(1 + kappa g) along the rail's tangent (kappa: the rail's curvature,
!> convex positive) and from the wheel's curvature.  The accelerations of closed contacts need them.
module gap_functions
  use contact_zones, only: on_flange, side_type
  use curve, only: curve_point, curve_type, near_interval
  use kinds, only: dp
  use station_scan, only: deepest, new_scan, scan_depth, scan_type
  use wheel_rail_pair, only: mirror, pair_type, rail_curvature, rolled
  use wheelset, only: flanges, left_tread, treads
  implicit none
  private
  public :: gap_type, contacts_type, new_contacts, search_stations, find_gap, accept_depth, clear_point, tightest
  public :: is_short, stride

  real(dp), parameter :: stride = 2.5e-5_dp    !! shorter pieces of a curve, between two knots, may hold an edge [m]

  !> The point of a zone that is nearest to the rail, and the gap there.
  type :: gap_type
    integer :: wheel = 1                 !! 1 left, 2 right
    integer :: contact = left_tread      !! name under which it is reported: left_tread to right_flange
    integer :: first = 0, last = 0       !! the zone's first and last station on the wheel
    real(dp) :: apart = 3e-5_dp          !! two points of the zone that are closer together are one [m]
    real(dp) :: touching = 1e-12_dp      !! gap of a contact that is closed at an event, at most [m]
    real(dp) :: s = 0, foot = 0          !! arc lengths of the nearest points on wheel and rail [m]
    integer :: at_wheel = 1, at_rail = 1 !! knot intervals of s and foot
    real(dp) :: gap = 0                  !! distance along the rail's normal, over `lowest` [m]
    real(dp) :: lowest = 0               !! the least distance, not positive, that the contact may have (see `accept_depth`) [m]
    real(dp) :: gradient(3) = 0          !! dg/dq, q = (y, z, roll)
    real(dp) :: hessian(3, 3) = 0        !! d2g/dq2
    logical :: edge = .false.            !! the nearest point is an end of the zone
    logical :: rim = .false.             !! that end is the wheel's end on the field side
    logical :: absent = .false.          !! a rival point that the zone does not have
  end type gap_type

  !> The contacts of the left wheel, then of the right wheel, then as often their rivals (see `rival_points`).
  type :: contacts_type
    integer :: n = 0                     !! number of zones of both wheels, without rivals
    integer :: points = 2                !! points of every zone, with its rivals
    type(gap_type), allocatable :: c(:)  !! (points*n)
    type(scan_type) :: scan(2)           !! workspace of a search, left and right
    real(dp) :: searched(3) = 0          !! pose of the last search
    logical :: stale = .true.            !! a new search is due wherever the wheelset is
  end type contacts_type

contains

  !> Contacts of two sides, before any search, with room for the rivals of every zone.
  !>
  !> An edge is a short piece of a curve, or several, with much of its turn.  Beside it a curve through points is hollow, so
  !> that a zone with edges may have several points that are nearer to the rail than their neighbours.
  function new_contacts(side) result(contacts)
    type(side_type), intent(in) :: side(:)    !! left, right
    type(contacts_type) :: contacts
    integer, parameter :: most_points = 8     ! of a zone with edges
    ! Beside an edge points are nearer to each other, and gaps of open contacts are smaller.
    real(dp), parameter :: least_distance = 1e-7_dp, least_gap = 1e-14_dp   ! [m]
    integer :: wheel

    allocate (contacts%c(0))
    do wheel = 1, 2
      contacts%scan(wheel) = new_scan(side(wheel)%pair)
      call add_stretches(side(wheel), wheel, contacts%c)
      associate (pair => side(wheel)%pair)
        if (.not. (any_short(pair%wheel) .or. any_short(pair%rail))) cycle
        contacts%points = most_points
        where (contacts%c%wheel == wheel)
          contacts%c%apart = least_distance
          contacts%c%touching = least_gap
        end where
      end associate
    end do
    contacts%n = size(contacts%c)
    contacts%c = reshape(spread(contacts%c, 2, contacts%points), [contacts%points*contacts%n])
    call clear_point(contacts%c(contacts%n + 1:))
  end function new_contacts

  !> Add the contacts of a wheel: one for each of its zones, or for several that a contact can roll through.
  pure subroutine add_stretches(side, wheel, c)
    type(side_type), intent(in) :: side
    integer, intent(in) :: wheel              !! 1 left, 2 right
    type(gap_type), allocatable, intent(inout) :: c(:)
    integer :: k

    do k = 1, size(side%zones)
      associate (zone => side%zones(k))
        if (k > 1) then
          if (is_passable(side%pair, zone%last)) then
            c(size(c))%first = zone%first
            cycle
          end if
        end if
        c = [c, gap_type(wheel=wheel, first=zone%first, last=zone%last)]
      end associate
    end do
  end subroutine add_stretches

  !> Whether a station of the wheel where two zones meet can touch: wheel and rail are together convex there.
  pure logical function is_passable(pair, station)
    type(pair_type), intent(in) :: pair
    integer, intent(in) :: station

    is_passable = pair%curvature(station) + rail_curvature(pair, pair%angle(station)) > 0
  end function is_passable

  !> Whether interval i of a curve is so short that it may hold an edge.
  pure logical function is_short(c, i)
    type(curve_type), intent(in) :: c
    integer, intent(in) :: i

    is_short = .false.
    if (i > 0 .and. i < c%n) is_short = c%s(i + 1) - c%s(i) < stride
  end function is_short

  !> Whether a curve has an interval that may hold an edge.
  pure logical function any_short(c)
    type(curve_type), intent(in) :: c
    integer :: i

    any_short = any([(is_short(c, i), i=1, c%n - 1)])
  end function any_short

  !> Find the nearest point of every zone at the pose q: first among the stations of the wheel, then exactly.
  subroutine search_stations(side, q, contacts)
    type(side_type), intent(in) :: side(:)    !! left, right
    real(dp), intent(in) :: q(3)              !! axle centre y, z [m], roll [rad]
    type(contacts_type), intent(inout) :: contacts
    real(dp) :: depth, pose(3)
    integer :: k, wheel, node, first, last

    do wheel = 1, 2
      pose = merge(q, mirror*q, wheel == 1)
      first = minval(contacts%c%first, contacts%c%wheel == wheel)
      last = maxval(contacts%c%last, contacts%c%wheel == wheel)
      associate (scan => contacts%scan(wheel), pair => side(wheel)%pair)
        call scan_depth(pair, pose(:2), pose(3), first, last, scan)
        scan%fresh = .false.
        do k = 1, contacts%n
          if (contacts%c(k)%wheel /= wheel) cycle
          associate (c => contacts%c(k))
            call deepest(pair, scan, c%first, c%last, depth, c%s, node)
            c%absent = .false.
            c%lowest = 0
            c%foot = scan%foot(node)
            c%at_wheel = near_interval(pair%wheel, c%s)
            call find_gap(side, q, c)
          end associate
        end do
      end associate
    end do
    contacts%searched = q
    contacts%stale = .false.
  end subroutine search_stations

  !> Find a contact's nearest points, gap and derivatives at the pose q, by Newton's method from its present points.
  pure subroutine find_gap(side, q, c)
    type(side_type), intent(in) :: side(:) !! left, right
    real(dp), intent(in) :: q(3)           !! axle centre y, z [m], roll [rad]
    type(gap_type), intent(inout) :: c
    real(dp), parameter :: longest = 5e-4_dp   ! longest step [m]
    real(dp), parameter :: close = 1e-9_dp     ! the last step [m]: Newton's method squares the error once more
    integer, parameter :: patience = 12        ! number of steps in which Newton's method converges if it does
    real(dp), dimension(2) :: r, r1, r2, x, x1, x2, f, f1, f2, e, t, n
    real(dp) :: pose(3), along, across, a12, a21, a22, det, unit, curved, sharp, ds, df, before, limit, most, last_step, &
      ends(2), spin(3), shear(3)
    integer :: iter, i

    if (c%absent) return
    pose = q
    if (c%wheel == 2) pose = mirror*q
    ends = side(c%wheel)%pair%s([c%first, c%last])
    c%edge = .false.
    c%rim = .false.
    last_step = longest
    limit = longest
    before = 0
    do iter = 1, 60
      call curve_point(side(c%wheel)%pair%wheel, c%s, c%at_wheel, r, r1, r2)
      call curve_point(side(c%wheel)%pair%rail, c%foot, c%at_rail, f, f1, f2)
      x = rolled(r, pose(3))
      x1 = rolled(r1, pose(3))
      x2 = rolled(r2, pose(3))
      e = pose(:2) + x - f
      unit = 1/norm2(f1)
      t = unit*f1
      n = [-t(2), t(1)]
      c%gap = dot_product(n, e)
      ! The rail's convexity and the second derivative of the distance along the wheel.
      curved = (f1(2)*f2(1) - f1(1)*f2(2))*unit**3
      curved = curved/max(1 + curved*c%gap, 0.1_dp)
      sharp = curved*dot_product(t, x1)**2 + dot_product(n, x2)
      along = dot_product(e, f1)                      ! 0: f is the foot of the wheel's point
      across = f1(1)*x1(2) - f1(2)*x1(1)              ! 0: the tangents are parallel
      if (last_step < close) then
        ! An end of the zone is left if the gap falls from there into the zone.
        if (.not. c%edge .or. merge(across, -across, c%s <= ends(1)) >= 0) exit
        c%edge = .false.
      end if
      a12 = min(dot_product(e, f2) - dot_product(f1, f1), -0.2_dp)
      if (c%edge) then
        ds = 0
        df = -along/a12
      else if (sharp > 0) then
        a21 = f1(1)*x2(2) - f1(2)*x2(1)
        a22 = f2(1)*x1(2) - f2(2)*x1(1)
        det = dot_product(x1, f1)*a22 - a12*a21
        ds = (a12*across - a22*along)/det
        df = (a21*along - dot_product(x1, f1)*across)/det
      else
        ds = -sign(longest, across)
        df = -(along + dot_product(x1, f1)*ds)/a12
      end if
      ! Newton's steps may alternate for ever over a jump of curvature: a step back is at most half of the last one.
      if (iter > patience .and. ds*before < 0) limit = min(limit, abs(before)/2)
      most = min(limit, longest_step(side(c%wheel)%pair%wheel, c%at_wheel), longest_step(side(c%wheel)%pair%rail, c%at_rail))
      if (most < longest .and. abs(ds) > most) df = -(along + dot_product(x1, f1)*sign(most, ds))/a12
      ds = max(-most, min(ds, most))
      before = ds
      df = max(-longest, min(df, longest))
      if ((c%s <= ends(1) .and. ds < 0) .or. (c%s >= ends(2) .and. ds > 0)) then
        c%edge = .true.
        ds = 0
        df = -along/a12
      end if
      c%s = max(ends(1), min(c%s + ds, ends(2)))
      c%foot = c%foot + df
      last_step = max(abs(ds), abs(df))
    end do

    c%gap = c%gap - c%lowest
    c%contact = merge(flanges(c%wheel), treads(c%wheel), on_flange(side(c%wheel), c%s))
    c%rim = c%edge .and. c%last == size(side(c%wheel)%pair%s) .and. c%s >= ends(2)
    spin = [t(1), t(2), x(1)*t(2) - x(2)*t(1)]
    c%gradient = [n(1), n(2), x(1)*n(2) - x(2)*n(1)]
    do i = 1, 3
      c%hessian(:, i) = curved*spin*spin(i)
    end do
    c%hessian(3, 3) = c%hessian(3, 3) - dot_product(n, x)
    if (.not. c%edge .and. sharp > 0) then
      shear = curved*dot_product(t, x1)*spin
      shear(3) = shear(3) + x1(1)*n(2) - x1(2)*n(1)
      do i = 1, 3
        c%hessian(:, i) = c%hessian(:, i) - shear*shear(i)/sharp
      end do
    end if
    if (c%wheel == 2) then
      c%gradient = mirror*c%gradient
      do i = 1, 3
        c%hessian(:, i) = mirror(i)*mirror*c%hessian(:, i)
      end do
    end if
  end subroutine find_gap

  !> The longest step of Newton's method in interval i of a curve [m]: beside an edge the step must not pass it.
  pure real(dp) function longest_step(c, i)
    type(curve_type), intent(in) :: c
    integer, intent(in) :: i

    longest_step = huge(longest_step)
    if (is_short(c, i)) longest_step = c%s(i + 1) - c%s(i)
  end function longest_step

  !> Let an open contact that has come inside the rail stay as deep. Where wheel and rail conform, the nearest point jumps by a
  !> millimetre, to one that was found too late and is up to some 0.1 um inside; to move the wheelset out would be work.
  elemental subroutine accept_depth(c, closed)
    type(gap_type), intent(inout) :: c
    logical, intent(in) :: closed
    real(dp) :: distance

    if (closed .or. c%absent) return
    distance = c%gap + c%lowest
    c%lowest = min(distance, 0.0_dp)
    c%gap = distance - c%lowest
  end subroutine accept_depth

  !> Mark a rival point as one that the zone does not have.
  elemental subroutine clear_point(c)
    type(gap_type), intent(inout) :: c

    c%absent = .true.
    c%lowest = 0
    c%gap = huge(1.0_dp)
    c%gradient = 0
    c%hessian = 0
  end subroutine clear_point

  !> Index of the contact of a wheel (1 left, 2 right) with the least gap.
  pure integer function tightest(contacts, wheel) result(k)
    type(contacts_type), intent(in) :: contacts
    integer, intent(in) :: wheel

    k = minloc(contacts%c%gap, 1, mask=contacts%c%wheel == wheel)
  end function tightest

end module gap_functions
