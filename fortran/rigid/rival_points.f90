!> Other points of a zone that are nearer to the rail than their neighbours: rivals of the nearest point.
!>
!> Where a profile is hollow over a fraction of a millimetre, as a spline beside a jump of curvature is, the contact
!> does not roll through the hollow.  It jumps over it to a point that closes as any other contact does.  Such a point may be
!> an edge of the wheel: it stays where it is on the wheel while the contact angle turns from one side of the edge to the other.
module rival_points
  use contact_zones, only: side_type
  use curve, only: curve_point, curve_type, near_interval
  use gap_functions, only: clear_point, contacts_type, find_gap, gap_type, is_short, search_stations, stride
  use kinds, only: dp
  use station_scan, only: scan_type
  use wheel_rail_pair, only: mirror, pair_type, rolled
  implicit none
  private
  public :: search_rivals, drop_merged_rivals

  real(dp), parameter :: near = 1e-4_dp            ! gaps that a step may close [m]
  real(dp), parameter :: reach = 48*stride         ! the search beside a known point goes as far [m]

contains

  !> Find the nearest point of every zone at the pose q, and the rivals that the zone has.  Points that carry a force
  !> are kept.
  subroutine search_rivals(side, q, closed, contacts)
    type(side_type), intent(in) :: side(:) !! left, right
    real(dp), intent(in) :: q(3)           !! y, z [m], roll [rad]
    logical, intent(in) :: closed(:)       !! points that carry a force, (points*n)
    type(contacts_type), intent(inout) :: contacts
    type(gap_type) :: held(size(contacts%c)), p(contacts%points)
    logical :: on(contacts%points)
    integer :: k, i, n

    held = contacts%c
    call search_stations(side, q, contacts)
    n = contacts%n
    do k = 1, n
      on = closed(k::n)
      p = held(k::n)
      do i = 1, contacts%points
        if (on(i)) call find_gap(side, q, p(i))
      end do
      if (.not. any(on)) then
        p(1) = contacts%c(k)
        on(1) = .true.
      end if
      associate (found => contacts%c(k))
        p = unpack(rivals(side, q, contacts%scan(found%wheel), pack(p, on), found, count(.not. on)), .not. on, p)
      end associate
      contacts%c(k::n) = p
    end do
  end subroutine search_rivals

  !> A zone's other points that are nearer to the rail than their neighbours, the lowest ones first.  The search goes in small
  !> strides and over short pieces of the curves beside the points that are kept, then over the stations of a scan at the pose q.
  function rivals(side, q, scan, kept, nearest, room) result(list)
    type(side_type), intent(in) :: side(:)   !! left, right
    real(dp), intent(in) :: q(3)
    type(scan_type), intent(in) :: scan
    type(gap_type), intent(in) :: kept(:)    !! points of the zone that are no rivals
    type(gap_type), intent(in) :: nearest    !! the nearest point among the stations
    integer, intent(in) :: room              !! number of rivals wanted
    type(gap_type) :: list(room)             !! absent where there are fewer
    type(gap_type) :: x
    real(dp) :: pose(3)
    integer :: i

    list = kept(1)
    call clear_point(list)
    if (room == 0) return
    pose = merge(q, mirror*q, nearest%wheel == 1)
    associate (pair => side(nearest%wheel)%pair, first => kept(1))
      do i = 1, size(kept)
        if (kept(i)%gap <= near) call search_beside(pair, kept(i))
      end do
      if (first%gap <= near) then
        do i = first%first, first%last - 1
          if (abs(pair%s(i) - first%s) < reach .or. scan%depth(i) < -near) cycle
          if (scan%slope(i) <= 0 .or. scan%slope(i + 1) >= 0) cycle
          x = first
          x%lowest = 0
          x%s = pair%s(i)
          x%at_wheel = near_interval(pair%wheel, x%s)
          x%foot = scan%foot(i)
          x%at_rail = scan%interval(i)
          call find_gap(side, q, x)
          call add_lower(x, near)
          if (room > 1 .and. x%gap < near) call search_beside(pair, x)
        end do
      end if
      if (room > 1 .and. nearest%gap < near) call search_beside(pair, nearest)
      call add_lower(nearest, huge(near))
    end associate

  contains

    !> Find the points that are nearer than their neighbours within `reach` of the point c.
    subroutine search_beside(pair, c)
      type(pair_type), intent(in) :: pair
      type(gap_type), intent(in) :: c
      type(gap_type) :: p, last, middle, lower
      real(dp) :: ends(2), slope, before, between, bend, bend_before, ignored, s
      integer :: i, way
      logical :: found

      ends = pair%s([c%first, c%last])
      do way = -1, 1, 2
        p = c
        p%lowest = 0
        slope = 0
        bend = 0
        if (room > 1) call find_slope(pair, pose, p, slope, bend)
        i = 1
        do
          before = slope
          bend_before = bend
          last = p
          s = c%s + way*i*stride
          if (abs(s - c%s) > 1.01_dp*reach) exit
          i = i + 1
          if (way*(s - next_knot(pair, p, way)) > 0) then
            s = next_knot(pair, p, way)
            i = i - 1
          end if
          p%s = s
          if (p%s <= ends(1) .or. p%s >= ends(2)) exit
          call find_slope(pair, pose, p, slope, bend)
          found = way*before < 0 .and. way*slope >= 0
          if (room > 1 .and. bend_before*bend < 0 .and. before*slope > 0 .and. way*before*bend > 0) then
            ! The slope may change its sign twice between both stations: it is then least or largest here.
            middle = last
            middle%s = last%s + (p%s - last%s)*bend_before/(bend_before - bend)
            call find_slope(pair, pose, middle, between, ignored)
            found = before*between < 0
          end if
          if (.not. found) cycle
          ! Newton's method is to begin where the slope grows along the wheel.
          lower = p
          if (room > 1 .and. bend <= 0) lower = last
          call find_gap(side, q, lower)
          call add_lower(lower, near)
        end do
      end do
    end subroutine search_beside

    !> Put the point x on the list if its gap is below `most` and lower than the last one's.
    subroutine add_lower(x, most)
      type(gap_type), intent(in) :: x
      real(dp), intent(in) :: most           !! [m]
      integer :: i

      if (any(abs(x%s - kept%s) <= x%apart)) return
      if (.not. x%gap < min(list(room)%gap, most)) return
      do i = 1, room - 1
        if (list(i)%absent .or. abs(x%s - list(i)%s) > x%apart) cycle
        if (x%gap >= list(i)%gap) return
        list(i:room - 1) = list(i + 1:)
        exit
      end do
      i = count(list(:room - 1)%gap <= x%gap) + 1
      list(i + 1:) = list(i:room - 1)
      list(i) = x
    end subroutine add_lower

  end function rivals

  !> Station at which the search from the point p meets the next end of a short piece of the wheel's or the rail's curve [m].
  pure real(dp) function next_knot(pair, p, way) result(s)
    type(pair_type), intent(in) :: pair
    type(gap_type), intent(in) :: p
    integer, intent(in) :: way               !! 1 or -1: towards larger or smaller stations
    real(dp), parameter :: least = 1e-7_dp   ! two stations of a search are as far apart [m]

    s = p%s + way*max(least, min(to_knot(pair%wheel, p%s, p%at_wheel, way), to_knot(pair%rail, p%foot, p%at_rail, way)))
  end function next_knot

  !> Distance from station s of a curve, in interval i, to the next knot at an end of a short interval; huge where the next
  !> knot is none [m].
  pure real(dp) function to_knot(c, s, i, way)
    type(curve_type), intent(in) :: c
    real(dp), intent(in) :: s
    integer, intent(in) :: i
    integer, intent(in) :: way
    integer :: k

    k = i
    if (way > 0) then
      k = i + 1
    else if (s <= c%s(i)) then
      k = i - 1
    end if
    to_knot = huge(to_knot)
    if (k < 1 .or. k > c%n) return
    if (is_short(c, k - 1) .or. is_short(c, k)) to_knot = abs(c%s(k) - s)
  end function to_knot

  !> Growth of the distance from the rail along the wheel at the point p%s, and the growth of that; p%foot becomes the nearest
  !> point of the rail.
  pure subroutine find_slope(pair, pose, p, slope, bend)
    type(pair_type), intent(in) :: pair
    real(dp), intent(in) :: pose(3)        !! y, z [m], roll [rad]; mirrored for the right wheel
    type(gap_type), intent(inout) :: p
    real(dp), intent(out) :: slope
    real(dp), intent(out) :: bend          !! [1/m]
    real(dp), dimension(2) :: r, r1, r2, e, f, f1, f2
    real(dp) :: step, unit
    integer :: iter

    call curve_point(pair%wheel, p%s, p%at_wheel, r, r1, r2)
    e = pose(:2) + rolled(r, pose(3))
    do iter = 1, 20
      call curve_point(pair%rail, p%foot, p%at_rail, f, f1, f2)
      step = dot_product(e - f, f1)/max(dot_product(f1, f1) - dot_product(e - f, f2), 0.2_dp)
      if (abs(step) < 1e-9_dp) exit
      p%foot = p%foot + step
    end do
    r1 = rolled(r1, pose(3))
    slope = (f1(1)*r1(2) - f1(2)*r1(1))/norm2(f1)
    r2 = rolled(r2, pose(3))
    unit = 1/norm2(f1)
    bend = (f1(2)*f2(1) - f1(1)*f2(2))*dot_product(f1, r1)**2*unit**5 + (f1(1)*r2(2) - f1(2)*r2(1))*unit
  end subroutine find_slope

  !> Drop one of two points of a zone that have come together; a point that carries a force stays.
  pure subroutine drop_merged_rivals(n, closed, c)
    integer, intent(in) :: n               !! number of zones of both wheels
    logical, intent(in) :: closed(:)
    type(gap_type), intent(inout) :: c(:)  !! contacts, then their rivals
    integer :: i, j

    do i = 1, size(c) - n
      do j = i + n, size(c), n
        if (c(i)%absent .or. c(j)%absent) cycle
        if (closed(i) .and. closed(j)) cycle
        if (abs(c(i)%s - c(j)%s) > c(i)%apart) cycle
        call clear_point(c(merge(i, j, closed(j))))
      end do
    end do
  end subroutine drop_merged_rivals

end module rival_points
