!> Gaps between rigid wheels and rails, and the forces that keep them closed.
!>
!> A contact is a zone of a wheel against its rail.  Its gap is the least distance of the zone's points
!> p(s, q) from the rail, along the rail's outward normal n:
!>
!>     g(q) = min over s of d(s, q),   dg/dq = n . dp/dq,
!>     g_qq = d_qq - d_qs d_sq/d_ss    at the wheel's point s that is nearest,
!>
!> with d's second derivatives from kappa/(1 + kappa g) along the rail's tangent (kappa: the rail's curvature,
!> convex positive) and from the wheel's own: the accelerations of closed contacts need them.
module gap_functions
  use contact_zones, only: side_type
  use curve, only: curve_point, near_interval
  use wheel_rail_pair, only: deepest, new_scan, pair_type, rolled, scan_depth, scan_type
  use kinds, only: dp
  use wheelset, only: contact_state, left_flange, left_tread, right_flange, right_tread
  implicit none
  private
  public :: gap_type, contacts_type, new_contacts, find_gap, search, search_rivals, part_rivals, tightest, bending, &
    couplings, closing_forces, set_state, close_gaps, stop_gaps, complement, eliminate, most_closed

  !> A zone of one wheel and the rail.
  type :: gap_type
    integer :: wheel = 1                 !! 1 left, 2 right
    integer :: contact = left_tread      !! as which it is reported
    integer :: first = 0, last = 0       !! its stations
    real(dp) :: s = 0, foot = 0          !! the nearest points: stations on wheel and rail [m]
    integer :: at_wheel = 1, at_rail = 1 !! their knot intervals
    real(dp) :: gap = 0                  !! [m]
    real(dp) :: slope(3) = 0             !! dg/dq, q = (y, z, roll)
    real(dp) :: bend(3, 3) = 0           !! its second derivatives
    logical :: edge = .false.            !! the nearest point is the zone's end
    logical :: rim = .false.             !! that end is the wheel's, on the field side
    logical :: idle = .false.            !! no such point: a rival where the zone has only one
  end type gap_type

  !> All of them, of the left wheel then of the right, then their rivals, and what a search needs.
  type :: contacts_type
    integer :: n = 0                     !! without the rivals
    type(gap_type), allocatable :: c(:)  !! (n), with rivals (2 n)
    type(scan_type) :: scan(2)
    real(dp) :: searched(3) = 0          !! pose of the last search
    logical :: stale = .true.            !! a new one is due wherever the wheelset is
  end type contacts_type

  integer, parameter :: most_closed = 3   !! contacts that three degrees of freedom can keep closed

  ! Points of a zone that are nearer together than this are one [m].
  real(dp), parameter :: apart = 3e-5_dp
  real(dp), parameter :: mirror(3) = [-1, 1, -1]

contains

  function new_contacts(side, rivals) result(all)
    type(side_type), intent(in) :: side(:)    !! left, right
    logical, intent(in), optional :: rivals   !! two points of every zone, see search_rivals
    type(contacts_type) :: all
    integer :: wheel, k

    all%n = size(side(1)%zones) + size(side(2)%zones)
    allocate (all%c(all%n))
    do wheel = 1, 2
      all%scan(wheel) = new_scan(side(wheel)%pair)
      do k = 1, size(side(wheel)%zones)
        associate (c => all%c((wheel - 1)*size(side(1)%zones) + k), zone => side(wheel)%zones(k))
          c%wheel = wheel
          c%first = zone%first
          c%last = zone%last
          c%contact = merge(merge(left_flange, right_flange, wheel == 1), merge(left_tread, right_tread, wheel == 1), &
            zone%flange)
        end associate
      end do
    end do
    if (.not. present(rivals)) return
    all%c = [all%c, all%c]
    all%c(all%n + 1:)%idle = .true.
    all%c(all%n + 1:)%gap = huge(1.0_dp)
  end function new_contacts

  !> The nearest points among all stations of every zone, then exactly.
  subroutine search(side, q, all)
    type(side_type), intent(in) :: side(:)
    real(dp), intent(in) :: q(3)
    type(contacts_type), intent(inout) :: all
    real(dp) :: depth, own(3)
    integer :: k, wheel, node, first, last

    do wheel = 1, 2
      own = merge(q, mirror*q, wheel == 1)
      first = minval(all%c%first, all%c%wheel == wheel)
      last = maxval(all%c%last, all%c%wheel == wheel)
      call scan_depth(side(wheel)%pair, own(:2), own(3), first, last, all%scan(wheel))
      all%scan(wheel)%fresh = .false.
      do k = 1, all%n
        if (all%c(k)%wheel /= wheel) cycle
        call deepest(side(wheel)%pair, all%scan(wheel), all%c(k)%first, all%c(k)%last, depth, all%c(k)%s, node)
        all%c(k)%idle = .false.
        all%c(k)%foot = all%scan(wheel)%foot(node)
        all%c(k)%at_wheel = near_interval(side(wheel)%pair%wheel, all%c(k)%s)
        call find_gap(side, q, all%c(k))
      end do
    end do
    all%searched = q
    all%stale = .false.
  end subroutine search

  !> The same, and of every zone a second point that is nearer than its neighbours, if there is one: where a profile
  !> is hollow over a fraction of a millimetre, as a spline beside a jump of curvature is, contact passes over the
  !> hollow at once, to a point that comes down as any other contact does.  Points that carry a force are kept.
  subroutine search_rivals(side, q, closed, all)
    type(side_type), intent(in) :: side(:) !! left, right
    real(dp), intent(in) :: q(3)
    logical, intent(in) :: closed(:)       !! (2 n)
    type(contacts_type), intent(inout) :: all
    type(gap_type) :: held(2*all%n), found
    integer :: k, own, other

    held = all%c
    call search(side, q, all)
    do k = 1, all%n
      own = merge(all%n + k, k, closed(all%n + k) .and. .not. closed(k))
      other = 2*k + all%n - own
      found = all%c(k)
      if (closed(own)) then
        all%c(own) = held(own)
        call find_gap(side, q, all%c(own))
      end if
      if (closed(other)) then
        all%c(other) = held(other)
        call find_gap(side, q, all%c(other))
      else
        call find_rival(side, q, all%scan(found%wheel), all%c(own), all%c(other))
        if (abs(found%s - all%c(own)%s) > apart .and. found%gap < all%c(other)%gap) all%c(other) = found
      end if
    end do
  end subroutine search_rivals

  !> The lowest of a zone's other points that are nearer to the rail than their neighbours: finely about the point
  !> that is known, then among the stations of a scan at q.
  subroutine find_rival(side, q, scan, c, rival)
    type(side_type), intent(in) :: side(:) !! left, right
    real(dp), intent(in) :: q(3)
    type(scan_type), intent(in) :: scan
    type(gap_type), intent(in) :: c
    type(gap_type), intent(out) :: rival
    real(dp), parameter :: near = 1e-4_dp               ! gaps that a step may close [m]
    real(dp), parameter :: stride = 2.5e-5_dp           ! [m]
    integer, parameter :: strides = 48
    type(gap_type) :: p
    real(dp) :: own(3), ends(2), slope, before
    integer :: i, way

    rival = c
    rival%idle = .true.
    rival%gap = huge(1.0_dp)
    rival%slope = 0
    rival%bend = 0
    if (c%gap > near) return
    own = merge(q, mirror*q, c%wheel == 1)
    ends = side(c%wheel)%pair%s([c%first, c%last])
    do way = -1, 1, 2
      p = c
      slope = 0
      do i = 1, strides
        before = slope
        p%s = c%s + way*i*stride
        if (p%s <= ends(1) .or. p%s >= ends(2)) exit
        call find_slope(side(c%wheel)%pair, own, p, slope)
        if (way*before < 0 .and. way*slope >= 0) call take(p)
      end do
    end do
    associate (pair => side(c%wheel)%pair)
      do i = c%first, c%last - 1
        if (abs(pair%s(i) - c%s) < strides*stride .or. scan%depth(i) < -near) cycle
        if (scan%slope(i) <= 0 .or. scan%slope(i + 1) >= 0) cycle
        p = c
        p%s = pair%s(i)
        p%at_wheel = near_interval(pair%wheel, p%s)
        p%foot = scan%foot(i)
        p%at_rail = scan%interval(i)
        call take(p)
      end do
    end associate

  contains

    subroutine take(start)
      type(gap_type), intent(in) :: start
      type(gap_type) :: x

      x = start
      call find_gap(side, q, x)
      if (abs(x%s - c%s) > apart .and. x%gap < min(rival%gap, near)) rival = x
    end subroutine take

  end subroutine find_rival

  !> How the distance from the rail grows along the wheel at a point p%s; p%foot is the nearest point of the rail.
  pure subroutine find_slope(pair, own, p, slope)
    type(pair_type), intent(in) :: pair
    real(dp), intent(in) :: own(3)         !! pose, mirrored for the right wheel
    type(gap_type), intent(inout) :: p
    real(dp), intent(out) :: slope
    real(dp), dimension(2) :: r, r1, r2, e, f, f1, f2
    real(dp) :: step
    integer :: iter

    call curve_point(pair%wheel, p%s, p%at_wheel, r, r1, r2)
    e = own(:2) + rolled(r, own(3))
    do iter = 1, 20
      call curve_point(pair%rail, p%foot, p%at_rail, f, f1, f2)
      step = dot_product(e - f, f1)/max(dot_product(f1, f1) - dot_product(e - f, f2), 0.2_dp)
      if (abs(step) < 1e-9_dp) exit
      p%foot = p%foot + step
    end do
    r1 = rolled(r1, own(3))
    slope = (f1(1)*r1(2) - f1(2)*r1(1))/norm2(f1)
  end subroutine find_slope

  !> A rival that has come to a contact's own point, or beside it, is none; what is closed stays.
  pure subroutine part_rivals(closed, c)
    logical, intent(in) :: closed(:)
    type(gap_type), intent(inout) :: c(:)  !! contacts, then their rivals
    integer :: k, n, gone

    n = size(c)/2
    do k = 1, n
      if (c(k)%idle .or. c(n + k)%idle .or. abs(c(k)%s - c(n + k)%s) > apart .or. closed(k) .and. closed(n + k)) cycle
      gone = merge(k, n + k, closed(n + k))
      c(gone)%idle = .true.
      c(gone)%gap = huge(1.0_dp)
      c(gone)%slope = 0
      c(gone)%bend = 0
    end do
  end subroutine part_rivals

  !> A contact's nearest points, gap and derivatives at q, by Newton's method from the ones it has.
  pure subroutine find_gap(side, q, c)
    type(side_type), intent(in) :: side(:) !! left, right
    real(dp), intent(in) :: q(3)           !! axle centre y, z [m], roll [rad]
    type(gap_type), intent(inout) :: c
    real(dp), parameter :: longest = 5e-4_dp, close = 1e-9_dp   ! steps [m]; Newton squares the last
    integer, parameter :: patience = 12                         ! steps in which Newton's method has settled if it does
    real(dp), dimension(2) :: r, r1, r2, x, x1, x2, f, f1, f2, e, t, n
    real(dp) :: own(3), along, across, a12, a21, a22, det, unit, curved, sharp, ds, df, before, reach, last_step, &
      ends(2), spin(3), shear(3)
    integer :: iter, i

    if (c%idle) return
    own = q
    if (c%wheel == 2) own = mirror*q
    ends = side(c%wheel)%pair%s([c%first, c%last])
    c%edge = .false.
    c%rim = .false.
    last_step = longest
    reach = longest
    before = 0
    do iter = 1, 60
      call curve_point(side(c%wheel)%pair%wheel, c%s, c%at_wheel, r, r1, r2)
      call curve_point(side(c%wheel)%pair%rail, c%foot, c%at_rail, f, f1, f2)
      x = rolled(r, own(3))
      x1 = rolled(r1, own(3))
      x2 = rolled(r2, own(3))
      e = own(:2) + x - f
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
        ! The zone's end, unless the gap falls from there into the zone.
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
      ! Over a jump of curvature Newton's steps may go to and fro for ever: then back by half at most.
      if (iter > patience .and. ds*before < 0) reach = min(reach, abs(before)/2)
      if (reach < longest .and. abs(ds) > reach) df = -(along + dot_product(x1, f1)*sign(reach, ds))/a12
      ds = max(-reach, min(ds, reach))
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

    c%rim = c%edge .and. c%last == size(side(c%wheel)%pair%s) .and. c%s >= ends(2)
    spin = [t(1), t(2), x(1)*t(2) - x(2)*t(1)]
    c%slope = [n(1), n(2), x(1)*n(2) - x(2)*n(1)]
    do i = 1, 3
      c%bend(:, i) = curved*spin*spin(i)
    end do
    c%bend(3, 3) = c%bend(3, 3) - dot_product(n, x)
    if (.not. c%edge .and. sharp > 0) then
      shear = curved*dot_product(t, x1)*spin
      shear(3) = shear(3) + x1(1)*n(2) - x1(2)*n(1)
      do i = 1, 3
        c%bend(:, i) = c%bend(:, i) - shear*shear(i)/sharp
      end do
    end if
    if (c%wheel == 2) then
      c%slope = mirror*c%slope
      do i = 1, 3
        c%bend(:, i) = mirror(i)*mirror*c%bend(:, i)
      end do
    end if
  end subroutine find_gap

  !> The contact of a wheel with the least gap.
  pure integer function tightest(all, wheel) result(k)
    type(contacts_type), intent(in) :: all
    integer, intent(in) :: wheel

    k = minloc(all%c%gap, 1, mask=all%c%wheel == wheel)
  end function tightest

  !> What the bend of a gap adds to its acceleration at the velocity v [m/s^2].
  pure real(dp) function bending(c, v)
    type(gap_type), intent(in) :: c
    real(dp), intent(in) :: v(3)

    bending = dot_product(v, matmul(c%bend, v))
  end function bending

  !> G = J M^-1 J' of contacts: how a force at one opens another.
  pure function couplings(inertia, c) result(g)
    real(dp), intent(in) :: inertia(3)
    type(gap_type), intent(in) :: c(:)
    real(dp) :: g(size(c), size(c))
    integer :: i, j

    do j = 1, size(c)
      do i = 1, size(c)
        g(i, j) = sum(c(i)%slope*c(j)%slope/inertia)
      end do
    end do
  end function couplings

  !> Bring the gaps of contacts to rest by impulses: J v = 0.
  pure subroutine stop_gaps(inertia, c, v)
    real(dp), intent(in) :: inertia(3)
    type(gap_type), intent(in) :: c(:)     !! at most three
    real(dp), intent(inout) :: v(3)
    real(dp) :: g(size(c), size(c)), x(size(c))
    integer :: i
    logical :: ok

    g = couplings(inertia, c)
    do i = 1, size(c)
      x(i) = -dot_product(c(i)%slope, v)
    end do
    call eliminate(g, x, ok)
    if (.not. ok) return
    do i = 1, size(c)
      v = v + x(i)*c(i)%slope/inertia
    end do
  end subroutine stop_gaps

  !> Normal forces [N] that keep the gaps of contacts at rest, whatever their sign:
  !> d2g/dt2 = J M^-1 (f + J' force) + v.H v = 0.
  pure subroutine closing_forces(inertia, f, v, c, force, ok)
    real(dp), intent(in) :: inertia(3), f(3), v(3)
    type(gap_type), intent(in) :: c(:)     !! at most three
    real(dp), intent(out) :: force(size(c))
    logical, intent(out) :: ok
    real(dp) :: g(size(c), size(c))
    integer :: i

    g = couplings(inertia, c)
    do i = 1, size(c)
      force(i) = -sum(c(i)%slope*f/inertia) - bending(c(i), v)
    end do
    call eliminate(g, force, ok)
  end subroutine closing_forces

  !> Move q, in the kinetic metric, until the contacts are closed.
  pure subroutine close_gaps(side, inertia, c, q, ok)
    type(side_type), intent(in) :: side(:)
    real(dp), intent(in) :: inertia(3)
    type(gap_type), intent(inout) :: c(:)
    real(dp), intent(inout) :: q(3)
    logical, intent(out) :: ok
    real(dp) :: g(size(c), size(c)), x(size(c)), move(3)
    integer :: iter, i

    do iter = 1, 30
      do i = 1, size(c)
        call find_gap(side, q, c(i))
      end do
      g = couplings(inertia, c)
      x = -c%gap
      call eliminate(g, x, ok)
      if (.not. ok) return
      move = 0
      do i = 1, size(c)
        move = move + x(i)*c(i)%slope/inertia
      end do
      if (maxval(abs(c%gap)) < 1e-16_dp) exit
      q = q + move
      ok = all(abs(c%gap) < 1e-13_dp)
      if (ok .and. maxval(abs(move)) < 1e-13_dp) exit
    end do
  end subroutine close_gaps

  !> x >= 0 with a x + b >= 0 and one of both zero in every component; a is symmetric, not negative.
  !> With up to three of them positive every choice is tried, the fewest first.
  pure subroutine complement(a, b, x, ok)
    real(dp), intent(in) :: a(:, :), b(:)
    real(dp), intent(out) :: x(size(b))
    logical, intent(out) :: ok
    integer :: n, i, j, k

    n = size(b)
    call try([integer ::], a, b, x, ok)
    do i = 1, n
      if (ok) return
      call try([i], a, b, x, ok)
    end do
    do i = 1, n
      do j = i + 1, n
        if (ok) return
        call try([i, j], a, b, x, ok)
      end do
    end do
    do i = 1, n
      do j = i + 1, n
        do k = j + 1, n
          if (ok) return
          call try([i, j, k], a, b, x, ok)
        end do
      end do
    end do
  end subroutine complement

  !> The same with the choice of components that may be positive.
  pure subroutine try(choice, a, b, x, ok)
    integer, intent(in) :: choice(:)
    real(dp), intent(in) :: a(:, :), b(:)
    real(dp), intent(out) :: x(size(b))
    logical, intent(out) :: ok
    real(dp), parameter :: slack = 1e-11_dp
    real(dp) :: part(size(choice), size(choice)), y(size(choice)), w(size(b))

    x = 0
    part = a(choice, choice)
    y = -b(choice)
    call eliminate(part, y, ok)
    if (.not. ok) return
    w = b + matmul(a(:, choice), y)
    w(choice) = 0
    ok = all(y >= 0) .and. all(w >= -slack*maxval(abs(b)))
    if (ok) x(choice) = y
  end subroutine try

  !> x = a^-1 x by Gauss's elimination with pivots; a is lost.
  pure subroutine eliminate(a, x, ok)
    real(dp), intent(inout) :: a(:, :), x(:)
    logical, intent(out) :: ok
    real(dp) :: row(size(x)), scale
    integer :: i, j, p

    ok = .true.
    scale = maxval(abs(a))
    do i = 1, size(x)
      p = i - 1 + maxloc(abs(a(i:, i)), 1)
      ok = abs(a(p, i)) > 1e-9_dp*scale
      if (.not. ok) return
      row = a(i, :)
      a(i, :) = a(p, :)
      a(p, :) = row
      x([i, p]) = x([p, i])
      do j = i + 1, size(x)
        x(j) = x(j) - a(j, i)/a(i, i)*x(i)
        a(j, i:) = a(j, i:) - a(j, i)/a(i, i)*a(i, i:)
      end do
    end do
    do i = size(x), 1, -1
      x(i) = (x(i) - dot_product(a(i, i + 1:), x(i + 1:)))/a(i, i)
    end do
  end subroutine eliminate

  !> What the columns and events want to know of closed contacts.
  pure subroutine set_state(c, force, state)
    type(gap_type), intent(in) :: c(:)
    real(dp), intent(in) :: force(:)       !! of each [N]
    type(contact_state), intent(out) :: state
    integer :: i, k

    do i = 1, size(c)
      k = c(i)%contact
      state%rigid(k) = .true.
      state%slope(:, k) = state%slope(:, k) - force(i)*c(i)%slope
      state%pulls(k) = dot_product(state%slope(:, k), c(i)%slope) > 0
    end do
    state%gradient = (state%slope(:, left_tread) + state%slope(:, left_flange)) &
      + (state%slope(:, right_tread) + state%slope(:, right_flange))
  end subroutine set_state

end module gap_functions