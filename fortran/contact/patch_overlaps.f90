!> Stretches of a wheel in which the undeformed bodies overlap in one pose.  Each holds one pressed patch, or several.
module patch_overlaps
  use kinds, only: dp
  use station_scan, only: scan_type
  use wheel_rail_pair, only: least_cosine, pair_type
  implicit none
  private
  public :: overlap_type, overlaps_type, find_overlaps, expected_area, moved_area, same_overlap, most_patches

  integer, parameter :: most_patches = 4

  type :: overlap_type
    real(dp) :: ends(2) = 0      !! first and last s [m]
    real(dp) :: half_x = 0       !! half of the length along x [m]
    real(dp) :: depth = 0        !! largest overlap [m]
    real(dp) :: station = 0      !! s of the largest overlap [m]
    real(dp) :: tops(2) = 0      !! first and last s at which the overlap has a maximum [m]
  end type overlap_type

  !> The overlaps of a pose, in the order of the wheel's stations.
  type :: overlaps_type
    integer :: n = 0
    type(overlap_type) :: list(most_patches)   !! the first n of them
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
    integer :: node, shallowest

    node = start - 1 + maxloc(scan%depth(start:finish), 1)
    if (overlaps%n == most_patches) then
      shallowest = minloc(overlaps%list%depth, 1)
      if (scan%depth(node) <= overlaps%list(shallowest)%depth) return
      overlaps%list(shallowest:most_patches - 1) = overlaps%list(shallowest + 1:)
      overlaps%n = most_patches - 1
    end if
    overlaps%n = overlaps%n + 1
    associate (new => overlaps%list(overlaps%n))
      new%depth = scan%depth(node)
      new%station = pair%s(node)
      ! Where the depth only grows, the station before the overlap stands for the first maximum.
      new%tops = pair%s([ &
        max(1, start - 1 + findloc(scan%depth(start:finish - 1) > scan%depth(start + 1:finish), .true., 1)), &
        start + findloc(scan%depth(start:finish - 1) < scan%depth(start + 1:finish), .true., 1, back=.true.)])
      if (finish - start < 2) new%tops = pair%s(node)
      new%half_x = min(sqrt(2*scan%depth(node)*(-pair%r(2, node))/max(scan%normal(2, node), least_cosine)), &
        -pair%r(2, node)/2)
      new%ends = pair%s([start, finish])
      if (start > first) new%ends(1) = new%ends(1) - way_to_edge(start, start - 1)
      if (finish < last) new%ends(2) = new%ends(2) + way_to_edge(finish, finish + 1)
    end associate

  contains

    !> Way [m] from a station in the overlap to the edge of the overlap before the next station.
    pure real(dp) function way_to_edge(inner, outer) result(way)
      integer, intent(in) :: inner, outer

      way = abs(pair%s(outer) - pair%s(inner))*scan%depth(inner)/(scan%depth(inner) - scan%depth(outer))
    end function way_to_edge

  end subroutine add_overlap

  !> The area that an overlap is expected to press: half of its length along x, its first and its last s [m].  It is the
  !> ellipse of Hertz's theory; its axis ratio is as fitted by Brewe and Hamrock (1977).
  pure function expected_area(overlap) result(area)
    type(overlap_type), intent(in) :: overlap
    real(dp) :: area(3), bend(2), share(2)

    bend = [1/overlap%half_x**2, 4/(overlap%ends(2) - overlap%ends(1))**2]
    share = [bend(1)*(bend(2)/bend(1))**1.272_dp, bend(2)]
    share = sqrt(share/sum(share))
    area = [share(1)*overlap%half_x, overlap%station + share(2)*(overlap%ends - overlap%station)]
    if (area(2) >= area(3)) area(2:3) = overlap%ends
    ! An overlap with two maxima may be one patch or two.
    area(2) = min(area(2), (overlap%tops(1) + overlap%ends(1))/2)
    area(3) = max(area(3), (overlap%tops(2) + overlap%ends(2))/2)
  end function expected_area

  !> Whether overlaps of two poses nearby are the same one: they have stations in common and about the same length.
  pure logical function same_overlap(old, new) result(same)
    type(overlap_type), intent(in) :: old, new
    real(dp), parameter :: alike = 0.1_dp

    same = min(old%ends(2), new%ends(2)) > max(old%ends(1), new%ends(1)) &
      .and. abs((new%ends(2) - new%ends(1))/(old%ends(2) - old%ends(1)) - 1) < alike
  end function same_overlap

  !> The area that has the same shares of a new overlap as `area` has of an old one.
  pure function moved_area(area, old, new) result(moved)
    real(dp), intent(in) :: area(3)        !! half of the length along x, first and last s [m]
    type(overlap_type), intent(in) :: old, new
    real(dp) :: moved(3)

    moved = [area(1)*new%half_x/old%half_x, new%ends(1) + (area(2:) - old%ends(1)) &
      *(new%ends(2) - new%ends(1))/(old%ends(2) - old%ends(1))]
  end function moved_area

end module patch_overlaps
