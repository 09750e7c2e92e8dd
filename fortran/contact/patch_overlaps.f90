!> Stretches of a wheel in which the undeformed bodies overlap in one pose.  Each holds one pressed patch, or several.
module patch_overlaps
  use kinds, only: dp
  use station_scan, only: scan_type
  use wheel_rail_pair, only: least_cosine, pair_type
  implicit none
  private
  public :: overlaps_type, find_overlaps, near_overlaps, expected_area, most_patches

  integer, parameter :: most_patches = 4

  !> The overlaps of a pose, in the order of the wheel's stations.
  type :: overlaps_type
    integer :: n = 0
    real(dp) :: ends(2, most_patches) = 0      !! first and last s [m]
    real(dp) :: half_x(most_patches) = 0       !! half of the length along x [m]
    real(dp) :: depth(most_patches) = 0        !! largest overlap [m]
    real(dp) :: station(most_patches) = 0      !! s of the largest overlap [m]
    real(dp) :: tops(2, most_patches) = 0      !! first and last s at which the overlap has a maximum [m]
  end type overlaps_type

contains

  !> The overlaps of the stations first..last of a scan.  Where there are too many, the shallowest are left out.
  pure subroutine find_overlaps(pair, first, last, scan, overlaps)
    type(pair_type), intent(in) :: pair
    integer, intent(in) :: first, last
    type(scan_type), intent(in) :: scan
    type(overlaps_type), intent(out) :: overlaps
    integer :: start, i

    start = 0
    do i = first, last
      if (scan%depth(i) <= 0) cycle
      if (start == 0) start = i
      if (i < last) then
        if (scan%depth(i + 1) > 0) cycle
      end if
      call add_overlap(pair, first, last, scan, start, i, overlaps)
      start = 0
    end do
  end subroutine find_overlaps

  !> Add the overlap of the stations start..finish.
  pure subroutine add_overlap(pair, first, last, scan, start, finish, overlaps)
    type(pair_type), intent(in) :: pair
    integer, intent(in) :: first, last     !! stations that are looked at
    type(scan_type), intent(in) :: scan
    integer, intent(in) :: start, finish
    type(overlaps_type), intent(inout) :: overlaps
    integer :: node, n

    node = start - 1 + maxloc(scan%depth(start:finish), 1)
    if (overlaps%n == most_patches) then
      if (scan%depth(node) <= minval(overlaps%depth)) return
      call drop_overlap(minloc(overlaps%depth, 1), overlaps)
    end if
    n = overlaps%n + 1
    overlaps%n = n
    overlaps%depth(n) = scan%depth(node)
    overlaps%station(n) = pair%s(node)
    ! Where the depth only grows, the station before the overlap stands for the first maximum.
    overlaps%tops(:, n) = pair%s([ &
      max(1, start - 1 + findloc(scan%depth(start:finish - 1) > scan%depth(start + 1:finish), .true., 1)), &
      start + findloc(scan%depth(start:finish - 1) < scan%depth(start + 1:finish), .true., 1, back=.true.)])
    if (finish - start < 2) overlaps%tops(:, n) = pair%s(node)
    overlaps%half_x(n) = min(sqrt(2*scan%depth(node)*(-pair%r(2, node))/max(scan%normal(2, node), least_cosine)), &
      -pair%r(2, node)/2)
    overlaps%ends(:, n) = pair%s([start, finish])
    if (start > first) overlaps%ends(1, n) = overlaps%ends(1, n) - way_to_edge(start, start - 1)
    if (finish < last) overlaps%ends(2, n) = overlaps%ends(2, n) + way_to_edge(finish, finish + 1)

  contains

    !> Way [m] from a station in the overlap to the edge of the overlap before the next station.
    pure real(dp) function way_to_edge(inner, outer) result(way)
      integer, intent(in) :: inner, outer

      way = abs(pair%s(outer) - pair%s(inner))*scan%depth(inner)/(scan%depth(inner) - scan%depth(outer))
    end function way_to_edge

  end subroutine add_overlap

  !> Leave out overlap i.
  pure subroutine drop_overlap(i, overlaps)
    integer, intent(in) :: i
    type(overlaps_type), intent(inout) :: overlaps

    associate (n => overlaps%n)
      overlaps%ends(:, i:n - 1) = overlaps%ends(:, i + 1:n)
      overlaps%half_x(i:n - 1) = overlaps%half_x(i + 1:n)
      overlaps%depth(i:n - 1) = overlaps%depth(i + 1:n)
      overlaps%station(i:n - 1) = overlaps%station(i + 1:n)
      overlaps%tops(:, i:n - 1) = overlaps%tops(:, i + 1:n)
      n = n - 1
    end associate
  end subroutine drop_overlap

  !> Whether the overlaps of two poses are the same ones, moved: each overlaps its old place and has kept its size.
  pure logical function near_overlaps(old, new) result(near)
    type(overlaps_type), intent(in) :: old, new
    integer :: i

    near = new%n > 0 .and. new%n == old%n
    do i = 1, new%n
      if (.not. near) exit
      near = abs(sum(new%ends(:, i)) - sum(old%ends(:, i))) < new%ends(2, i) - new%ends(1, i) &
        .and. new%depth(i) < 4*old%depth(i) .and. old%depth(i) < 4*new%depth(i)
    end do
  end function near_overlaps

  !> The area that overlap i is expected to press: half of its length along x, its first and its last s [m].  It is the
  !> ellipse of Hertz's theory; its axis ratio is as fitted by Brewe and Hamrock (1977).
  pure function expected_area(overlaps, i) result(area)
    type(overlaps_type), intent(in) :: overlaps
    integer, intent(in) :: i
    real(dp) :: area(3), bend(2), share(2)

    bend = [1/overlaps%half_x(i)**2, 4/(overlaps%ends(2, i) - overlaps%ends(1, i))**2]
    share = [bend(1)*(bend(2)/bend(1))**1.272_dp, bend(2)]
    share = sqrt(share/sum(share))
    area = [share(1)*overlaps%half_x(i), overlaps%station(i) + share(2)*(overlaps%ends(:, i) - overlaps%station(i))]
    if (area(2) >= area(3)) area(2:3) = overlaps%ends(:, i)
  end function expected_area

end module patch_overlaps
