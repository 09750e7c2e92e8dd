!> Repairs points as they are measured: repeated points, points off the curve, points that double back.  What is done is
!> said in words; points that cannot be repaired are refused with their line.
module profile_repair
  use errors, only: error_type, fatal_error
  use kinds, only: degree, dp
  use text, only: str
  implicit none
  private
  public :: mended_type, mend_points, check_points, mended_text

  !> What was repaired.
  type :: mended_type
    integer :: repeated = 0            !! points dropped because they are where their neighbour is
    integer :: outliers = 0            !! points dropped because they are off the curve
    real(dp) :: farthest = 0           !! largest distance of a dropped point from the curve [mm]
    integer :: group = 1               !! number of points put together to one because their spacing is below their noise
    integer :: moved = 0               !! points that doubled back, put between their neighbours
    real(dp) :: move = 0               !! largest move of such a point [mm]
  end type mended_type

  real(dp), parameter :: largest_turn = 120*degree   !! turn at a point: a larger one means that two points are exchanged
  real(dp), parameter :: least_spacing = 1e-2_dp     !! nearer points say nothing more [mm]
  real(dp), parameter :: largest_move = 0.3_dp       !! a point that doubles back farther is no measuring error [mm]
  real(dp), parameter :: least_miss = 0.15_dp        !! a point that is nearer to the curve stays [mm]
  real(dp), parameter :: least_share = 0.9_dp        !! share of the points that must be on the curve
  integer, parameter :: enough_points = 200          !! points are put together only where there are more
  real(dp), parameter :: largest_backward = 0.03_dp  !! share of points that turn back: above, the noise exceeds the spacing

contains

  !> Repair points.  Fails where too many are off the curve.
  subroutine mend_points(file, points, line, mended, error)
    character(*), intent(in) :: file                   !! for messages
    real(dp), allocatable, intent(inout) :: points(:, :)   !! y, z in the order of the file, (2, n) [mm]
    integer, allocatable, intent(inout) :: line(:)         !! line of each point in the file
    type(mended_type), intent(out) :: mended
    type(error_type), allocatable, intent(out) :: error
    integer :: n, given, first

    n = size(line)
    call drop_repeated(points, line, n, mended)
    given = n
    first = 0
    call drop_outliers(points, line, n, mended, first)
    if (n < least_share*given) then
      call fatal_error(error, file//', line '//str(first)//': expected points along a curve, found '// &
        str(mended%outliers)//' of '//str(given)//' off it, this one the first')
      return
    end if
    do while (n > enough_points .and. backward_share(points, n) > largest_backward)
      call put_together(points, line, n)
      mended%group = 2*mended%group
    end do
    call straighten(points, line, n, mended)
    points = points(:, :n)
    line = line(:n)
  end subroutine mend_points

  !> What was repaired, in words; '' for nothing.
  subroutine mended_text(mended, words)
    type(mended_type), intent(in) :: mended
    character(:), allocatable, intent(out) :: words

    words = ''
    if (mended%repeated > 0) words = words//', '//str(mended%repeated)//' repeated dropped'
    if (mended%outliers > 0) words = words//', '//str(mended%outliers)//' off the curve by up to '// &
      str(round(mended%farthest))//' mm dropped'
    if (mended%group > 1) words = words//', each '//str(mended%group)//' put together to one'
    if (mended%moved > 0) words = words//', '//str(mended%moved)//' that doubled back moved by up to '// &
      str(round(mended%move))//' mm'
    if (words /= '') words = 'points mended: '//words(3:)

  contains

    pure real(dp) function round(x)
      real(dp), intent(in) :: x
      round = anint(1e3_dp*x)/1e3_dp
    end function round

  end subroutine mended_text

  !> Drop points that are where the point before is.
  pure subroutine drop_repeated(points, line, n, mended)
    real(dp), intent(inout) :: points(:, :)
    integer, intent(inout) :: line(:), n
    type(mended_type), intent(inout) :: mended
    integer :: i, k

    k = min(1, n)
    do i = 2, n
      if (norm2(points(:, i) - points(:, k)) < least_spacing) cycle
      k = k + 1
      points(:, k) = points(:, i)
      line(k) = line(i)
    end do
    mended%repeated = n - k
    n = k
  end subroutine drop_repeated

  !> Drop points that are off the curve.  A point is off the curve when the chord of its neighbours, and the lines
  !> through the two points before and through the two points after, all miss it by much more than they miss other
  !> points nearby.  `first` becomes the line of the first such point.
  pure subroutine drop_outliers(points, line, n, mended, first)
    real(dp), intent(inout) :: points(:, :)
    integer, intent(inout) :: line(:), n, first
    type(mended_type), intent(inout) :: mended
    integer, parameter :: passes = 4, nearby = 20
    real(dp), parameter :: times = 8, share = 0.35_dp   ! least miss relative to the usual miss and to the spacing
    real(dp) :: miss(n), usual
    logical :: bad(n)
    integer :: pass, i, k

    do pass = 1, passes
      if (n < 10) return
      miss(:n) = 0
      do i = 3, n - 2
        miss(i) = min(distance(points(:, i - 1), points(:, i + 1)), distance(points(:, i - 2), points(:, i - 1)), &
          distance(points(:, i + 2), points(:, i + 1)))
      end do
      bad(:n) = .false.
      do i = 3, n - 2
        if (miss(i) < max(least_miss, maxval(miss(i - 1:i + 1)))) cycle
        usual = median(miss(max(3, i - nearby):min(n - 2, i + nearby)))
        bad(i) = miss(i) > max(least_miss, times*usual, share*norm2(points(:, i + 1) - points(:, i - 1))/2)
      end do
      if (.not. any(bad(:n))) return
      k = 0
      do i = 1, n
        if (bad(i)) then
          if (first == 0) first = line(i)
          mended%outliers = mended%outliers + 1
          mended%farthest = max(mended%farthest, miss(i))
          cycle
        end if
        k = k + 1
        points(:, k) = points(:, i)
        line(k) = line(i)
      end do
      n = k
    end do

  contains

    !> Distance of point i from the line through a and b [mm].
    pure real(dp) function distance(a, b)
      real(dp), intent(in) :: a(2), b(2)
      real(dp) :: t(2)

      t = (b - a)/max(norm2(b - a), tiny(1.0_dp))
      distance = abs(t(1)*(points(2, i) - a(2)) - t(2)*(points(1, i) - a(1)))
    end function distance

  end subroutine drop_outliers

  !> The median of some numbers.
  pure real(dp) function median(x)
    real(dp), intent(in) :: x(:)
    real(dp) :: sorted(size(x)), key
    integer :: i, j

    sorted = x
    do i = 2, size(x)
      key = sorted(i)
      do j = i - 1, 1, -1
        if (sorted(j) <= key) exit
        sorted(j + 1) = sorted(j)
      end do
      sorted(j + 1) = key
    end do
    median = sorted((size(x) + 1)/2)
  end function median

  !> Share of the points at which the curve turns back.
  pure real(dp) function backward_share(points, n)
    real(dp), intent(in) :: points(:, :)
    integer, intent(in) :: n
    integer :: i

    backward_share = count([(turn(points(:, i - 1), points(:, i), points(:, i + 1)) > largest_turn, i=2, n - 1)])/real(n, dp)
  end function backward_share

  !> Put every two points together to one in their middle.
  pure subroutine put_together(points, line, n)
    real(dp), intent(inout) :: points(:, :)
    integer, intent(inout) :: line(:), n
    integer :: i

    n = n/2
    do i = 1, n
      points(:, i) = (points(:, 2*i - 1) + points(:, 2*i))/2
      line(i) = line(2*i - 1)
    end do
  end subroutine put_together

  !> Where the points turn back over a short way, or make a small loop, exchange two neighbours or put one point in the
  !> place of two, until they turn back no more.
  subroutine straighten(points, line, n, mended)
    real(dp), intent(inout) :: points(:, :)
    integer, intent(inout) :: line(:), n
    type(mended_type), intent(inout) :: mended
    integer, parameter :: sweeps = 60, loop = 4   ! sweeps, and segments of a loop, at most
    real(dp) :: first(2), second(2), way(n)     ! way: how far a point has been moved [mm]
    integer :: i, k, m, sweep, before
    logical :: back

    way = 0
    do sweep = 1, sweeps
      before = n
      k = 1
      i = 2
      do while (i <= n)
        ! points(:k) are done; point i comes next.
        back = .false.
        if (k > 1 .and. i < n) then
          back = turn(points(:, k - 1), points(:, k), points(:, i)) > largest_turn
          do m = i, min(i + loop, n - 1)
            if (.not. back) back = crosses(points(:, k - 1:k), points(:, m:m + 1))
          end do
        end if
        if (back .and. apart(k, i) < largest_move) then
          first = points(:, k)
          second = points(:, i)
          if (max(turn(points(:, k - 1), second, first), turn(second, first, points(:, i + 1))) < largest_turn/2) then
            ! The two points had only changed places.
            points(:, k:k + 1) = reshape([second, first], [2, 2])
            line(k:k + 1) = [line(i), line(k)]
            way(k:k + 1) = way([i, k]) + norm2(second - first)
            mended%moved = mended%moved + 2
            k = k + 1
            i = i + 1
          else
            call unite(k, i)
          end if
          mended%move = max(mended%move, way(k))
          i = i + 1
          cycle
        end if
        if (back .and. k > 2) then
          if (apart(k - 1, k) < largest_move) then
            call unite(k - 1, k)
            k = k - 1
            mended%move = max(mended%move, way(k))
            cycle
          end if
        end if
        k = k + 1
        points(:, k) = points(:, i)
        line(k) = line(i)
        way(k) = way(i)
        i = i + 1
      end do
      n = k
      if (n == before .and. sweep > 1) exit
    end do

  contains

    !> How far points k and i would have been moved if one point took their place [mm].
    pure real(dp) function apart(k, i)
      integer, intent(in) :: k, i

      apart = norm2(points(:, i) - points(:, k))/2 + max(way(k), way(i))
    end function apart

    !> Put points k and i together to one in their middle, as point k.
    subroutine unite(k, i)
      integer, intent(in) :: k, i

      way(k) = apart(k, i)
      points(:, k) = (points(:, k) + points(:, i))/2
      mended%moved = mended%moved + 2
    end subroutine unite

  end subroutine straighten

  !> Fails where the curve through the points crosses itself or turns too much at a point.
  subroutine check_points(file, points, line, error)
    character(*), intent(in) :: file
    real(dp), intent(in) :: points(:, :)
    integer, intent(in) :: line(:)
    type(error_type), allocatable, intent(out) :: error
    integer :: n, i, j

    n = size(points, 2)
    do i = 1, n - 3
      do j = i + 2, n - 1
        ! Bounding boxes first: the exact test runs for near neighbours only.
        if (min(points(1, i), points(1, i + 1)) > max(points(1, j), points(1, j + 1))) cycle
        if (max(points(1, i), points(1, i + 1)) < min(points(1, j), points(1, j + 1))) cycle
        if (.not. crosses(points(:, i:i + 1), points(:, j:j + 1))) cycle
        call fatal_error(error, file//': the curve crosses itself between lines '// &
          str(min(line(i), line(j + 1)))//' and '//str(max(line(i), line(j + 1))))
        return
      end do
    end do
    do i = 2, n - 1
      if (turn(points(:, i - 1), points(:, i), points(:, i + 1)) <= largest_turn) cycle
      call fatal_error(error, file//', line '//str(line(i))//': expected a curve that turns by at most '// &
        str(nint(largest_turn/degree))//' degrees at a point, found '// &
        str(nint(turn(points(:, i - 1), points(:, i), points(:, i + 1))/degree)))
      return
    end do
  end subroutine check_points

  !> Angle between the two segments of three points [rad].
  pure real(dp) function turn(first, second, third)
    real(dp), intent(in) :: first(2), second(2), third(2)
    real(dp) :: a(2), b(2)

    a = second - first
    b = third - second
    turn = abs(atan2(a(1)*b(2) - a(2)*b(1), dot_product(a, b)))
  end function turn

  !> Whether two segments cross or touch.
  pure logical function crosses(a, b)
    real(dp), intent(in) :: a(2, 2), b(2, 2)   !! two segments, (coordinate, end)

    crosses = side(a, b(:, 1))*side(a, b(:, 2)) <= 0 .and. side(b, a(:, 1))*side(b, a(:, 2)) <= 0 &
      .and. max(minval(a(2, :)), minval(b(2, :))) <= min(maxval(a(2, :)), maxval(b(2, :))) &
      .and. max(minval(a(1, :)), minval(b(1, :))) <= min(maxval(a(1, :)), maxval(b(1, :)))
  end function crosses

  !> Positive where a point is on the left of a segment, negative on the right [mm2].
  pure real(dp) function side(a, point)
    real(dp), intent(in) :: a(2, 2), point(2)

    side = (a(1, 2) - a(1, 1))*(point(2) - a(2, 1)) - (a(2, 2) - a(2, 1))*(point(1) - a(1, 1))
  end function side

end module profile_repair
