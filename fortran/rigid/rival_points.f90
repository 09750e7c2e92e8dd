!> A second point of a zone that is nearer to the rail than its neighbours: a rival of the nearest point.
!>
!> Where a profile is hollow over a fraction of a millimetre, as a spline beside a jump of curvature is, the contact
!> does not roll through the hollow.  It jumps over it to a point that closes as any other contact does.
module rival_points
  use contact_zones, only: side_type
  use curve, only: curve_point, near_interval
  use gap_functions, only: clear_point, contacts_type, find_gap, gap_type, search_stations
  use kinds, only: dp
  use station_scan, only: scan_type
  use wheel_rail_pair, only: mirror, pair_type, rolled
  implicit none
  private
  public :: search_rivals, drop_merged_rivals

  real(dp), parameter :: least_distance = 3e-5_dp  ! two points of a zone that are closer together are one [m]
  real(dp), parameter :: near = 1e-4_dp            ! gaps that a step may close [m]
  real(dp), parameter :: stride = 2.5e-5_dp        ! step of the search along the wheel beside a known point [m]
  integer, parameter :: strides = 48

contains

  !> Find the nearest point of every zone at the pose q, and a rival if the zone has one.  Points that carry a force
  !> are kept.
  subroutine search_rivals(side, q, closed, contacts)
    type(side_type), intent(in) :: side(:) !! left, right
    real(dp), intent(in) :: q(3)           !! y, z [m], roll [rad]
    logical, intent(in) :: closed(:)       !! points that carry a force, (2 n)
    type(contacts_type), intent(inout) :: contacts
    type(gap_type) :: held(2*contacts%n), found
    integer :: k, nearest, second

    held = contacts%c
    call search_stations(side, q, contacts)
    do k = 1, contacts%n
      nearest = k
      second = contacts%n + k
      if (closed(second) .and. .not. closed(nearest)) then
        nearest = contacts%n + k
        second = k
      end if
      found = contacts%c(k)
      if (closed(nearest)) then
        contacts%c(nearest) = held(nearest)
        call find_gap(side, q, contacts%c(nearest))
      end if
      if (closed(second)) then
        contacts%c(second) = held(second)
        call find_gap(side, q, contacts%c(second))
      else
        call find_rival(side, q, contacts%scan(found%wheel), contacts%c(nearest), contacts%c(second))
        if (abs(found%s - contacts%c(nearest)%s) > least_distance .and. found%gap < contacts%c(second)%gap) &
          contacts%c(second) = found
      end if
    end do
  end subroutine search_rivals

  !> The lowest of a zone's other points that are nearer to the rail than their neighbours.  The search goes in small
  !> strides beside the point c, then over the stations of a scan at the pose q.
  subroutine find_rival(side, q, scan, c, rival)
    type(side_type), intent(in) :: side(:) !! left, right
    real(dp), intent(in) :: q(3)
    type(scan_type), intent(in) :: scan
    type(gap_type), intent(in) :: c
    type(gap_type), intent(out) :: rival   !! absent if there is none
    type(gap_type) :: p
    real(dp) :: pose(3), ends(2), slope, before
    integer :: i, way

    rival = c
    call clear_point(rival)
    if (c%gap > near) return
    pose = merge(q, mirror*q, c%wheel == 1)
    associate (pair => side(c%wheel)%pair)
      ends = pair%s([c%first, c%last])
      do way = -1, 1, 2
        p = c
        p%lowest = 0
        slope = 0
        do i = 1, strides
          before = slope
          p%s = c%s + way*i*stride
          if (p%s <= ends(1) .or. p%s >= ends(2)) exit
          call find_slope(pair, pose, p, slope)
          if (way*before < 0 .and. way*slope >= 0) call take_lower(p)
        end do
      end do
      do i = c%first, c%last - 1
        if (abs(pair%s(i) - c%s) < strides*stride .or. scan%depth(i) < -near) cycle
        if (scan%slope(i) <= 0 .or. scan%slope(i + 1) >= 0) cycle
        p = c
        p%lowest = 0
        p%s = pair%s(i)
        p%at_wheel = near_interval(pair%wheel, p%s)
        p%foot = scan%foot(i)
        p%at_rail = scan%interval(i)
        call take_lower(p)
      end do
    end associate

  contains

    !> The nearest point that is found from `start` becomes the rival if it is lower than the present one.
    subroutine take_lower(start)
      type(gap_type), intent(in) :: start
      type(gap_type) :: x

      x = start
      call find_gap(side, q, x)
      if (abs(x%s - c%s) > least_distance .and. x%gap < min(rival%gap, near)) rival = x
    end subroutine take_lower

  end subroutine find_rival

  !> Growth of the distance from the rail along the wheel at the point p%s; p%foot becomes the nearest point of the rail.
  pure subroutine find_slope(pair, pose, p, slope)
    type(pair_type), intent(in) :: pair
    real(dp), intent(in) :: pose(3)        !! y, z [m], roll [rad]; mirrored for the right wheel
    type(gap_type), intent(inout) :: p
    real(dp), intent(out) :: slope
    real(dp), dimension(2) :: r, r1, r2, e, f, f1, f2
    real(dp) :: step
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
  end subroutine find_slope

  !> Drop one of two points of a zone that have come together; a point that carries a force stays.
  pure subroutine drop_merged_rivals(closed, c)
    logical, intent(in) :: closed(:)
    type(gap_type), intent(inout) :: c(:)  !! contacts, then their rivals
    integer :: k, n

    n = size(c)/2
    do k = 1, n
      if (c(k)%absent .or. c(n + k)%absent) cycle
      if (closed(k) .and. closed(n + k)) cycle
      if (abs(c(k)%s - c(n + k)%s) > least_distance) cycle
      call clear_point(c(merge(k, n + k, closed(n + k))))
    end do
  end subroutine drop_merged_rivals

end module rival_points
