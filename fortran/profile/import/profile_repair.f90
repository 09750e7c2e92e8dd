!> Points as they are measured, mended: repeated points, points off the curve, points that
!> double back.  What is done is told; what cannot be mended is refused by line.
module profile_repair
  use errors, only: error_type, fatal_error
  use kinds, only: degree, dp
  use text, only: str
  implicit none
  private
  public :: mended_type, mend_points, check_points, mended_text

  type :: mended_type
    integer :: repeated = 0            !! points dropped, for they stand where their neighbour does
    integer :: outliers = 0            !! points dropped, for they are off the curve
    real(dp) :: farthest = 0           !! by this at most [mm]
    integer :: group = 1               !! points that were put together to one, for they lie nearer than their noise
    integer :: moved = 0               !! points that doubled back, put between their neighbours
    real(dp) :: move = 0               !! by this at most [mm]
  end type mended_type

  real(dp), parameter :: largest_turn = 120*degree   !! at a point: more is two points exchanged
  real(dp), parameter :: nearest = 1e-2_dp           !! points that are nearer say nothing more [mm]
  real(dp), parameter :: doubling = 0.3_dp           !! a point that must move farther is no measuring error [mm]
  real(dp), parameter :: off = 0.15_dp               !! a point that is less off the curve stays [mm]
  real(dp), parameter :: least_share = 0.9_dp        !! of the points that must be good
  integer, parameter :: many = 200                   !! so many points remain at least when points are put together
  real(dp), parameter :: turning = 0.03_dp           !! share of points that turn back: noise above spacing

contains

  subroutine mend_points(file, points, at, mended, error)
    character(*), intent(in) :: file                   !! for messages
    real(dp), allocatable, intent(inout) :: points(:, :)   !! y, z in the order of the file, (2, n) [mm]
    integer, allocatable, intent(inout) :: at(:)           !! line of each
    type(mended_type), intent(out) :: mended
    type(error_type), allocatable, intent(out) :: error
    integer :: n, given, first

    n = size(at)
    call drop_repeated(points, at, n, mended)
    given = n
    first = 0
    call drop_outliers(points, at, n, mended, first)
    if (n < least_share*given) then
      call fatal_error(error, file//', line '//str(first)//': expected points along a curve, found '// &
        str(mended%outliers)//' of '//str(given)//' off it, this one the first')
      return
    end if
    do while (n > many .and. backward(points, n) > turning)
      call put_together(points, at, n)
      mended%group = 2*mended%group
    end do
    call straighten(points, at, n, mended)
    points = points(:, :n)
    at = at(:n)
  end subroutine mend_points

  !> What was done, in words; '' for nothing.
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

  pure subroutine drop_repeated(points, at, n, mended)
    real(dp), intent(inout) :: points(:, :)
    integer, intent(inout) :: at(:), n
    type(mended_type), intent(inout) :: mended
    integer :: i, k

    k = min(1, n)
    do i = 2, n
      if (norm2(points(:, i) - points(:, k)) < nearest) cycle
      k = k + 1
      points(:, k) = points(:, i)
      at(k) = at(i)
    end do
    mended%repeated = n - k
    n = k
  end subroutine drop_repeated

  !> A point is off the curve when the chord of its neighbours, and the lines on from the two before and
  !> the two after it, all miss it by much more than those of other points nearby.
  pure subroutine drop_outliers(points, at, n, mended, first)
    real(dp), intent(inout) :: points(:, :)
    integer, intent(inout) :: at(:), n, first
    type(mended_type), intent(inout) :: mended
    integer, parameter :: passes = 4, nearby = 20
    real(dp), parameter :: times = 8, share = 0.35_dp   ! of what is usual, of the spacing
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
        if (miss(i) < max(off, maxval(miss(i - 1:i + 1)))) cycle
        usual = middle(miss(max(3, i - nearby):min(n - 2, i + nearby)))
        bad(i) = miss(i) > max(off, times*usual, share*norm2(points(:, i + 1) - points(:, i - 1))/2)
      end do
      if (.not. any(bad(:n))) return
      k = 0
      do i = 1, n
        if (bad(i)) then
          if (first == 0) first = at(i)
          mended%outliers = mended%outliers + 1
          mended%farthest = max(mended%farthest, miss(i))
          cycle
        end if
        k = k + 1
        points(:, k) = points(:, i)
        at(k) = at(i)
      end do
      n = k
    end do

  contains

    !> Of point i from the line through a and b.
    pure real(dp) function distance(a, b)
      real(dp), intent(in) :: a(2), b(2)
      real(dp) :: t(2)

      t = (b - a)/max(norm2(b - a), tiny(1.0_dp))
      distance = abs(t(1)*(points(2, i) - a(2)) - t(2)*(points(1, i) - a(1)))
    end function distance

  end subroutine drop_outliers

  !> The middle one of some numbers.
  pure real(dp) function middle(x)
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
    middle = sorted((size(x) + 1)/2)
  end function middle

  !> Share of the points at which the way turns back.
  pure real(dp) function backward(points, n)
    real(dp), intent(in) :: points(:, :)
    integer, intent(in) :: n
    integer :: i

    backward = count([(turn(points(:, i - 1), points(:, i), points(:, i + 1)) > largest_turn, i=2, n - 1)])/real(n, dp)
  end function backward

  !> One point for every two, between them.
  pure subroutine put_together(points, at, n)
    real(dp), intent(inout) :: points(:, :)
    integer, intent(inout) :: at(:), n
    integer :: i

    n = n/2
    do i = 1, n
      points(:, i) = (points(:, 2*i - 1) + points(:, 2*i))/2
      at(i) = at(2*i - 1)
    end do
  end subroutine put_together

  !> Where the points turn back over a short way, or make a small loop, exchange two neighbours or put
  !> one point in the place of two, until they do so no more.
  subroutine straighten(points, at, n, mended)
    real(dp), intent(inout) :: points(:, :)
    integer, intent(inout) :: at(:), n
    type(mended_type), intent(inout) :: mended
    integer, parameter :: sweeps = 60, loop = 4   ! of so many segments at most
    real(dp) :: first(2), second(2), way(n)     ! that a point has been moved [mm]
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
        if (back .and. apart(k, i) < doubling) then
          first = points(:, k)
          second = points(:, i)
          if (max(turn(points(:, k - 1), second, first), turn(second, first, points(:, i + 1))) < largest_turn/2) then
            ! They had only changed places.
            points(:, k:k + 1) = reshape([second, first], [2, 2])
            at(k:k + 1) = [at(i), at(k)]
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
          if (apart(k - 1, k) < doubling) then
            call unite(k - 1, k)
            k = k - 1
            mended%move = max(mended%move, way(k))
            cycle
          end if
        end if
        k = k + 1
        points(:, k) = points(:, i)
        at(k) = at(i)
        way(k) = way(i)
        i = i + 1
      end do
      n = k
      if (n == before .and. sweep > 1) exit
    end do

  contains

    !> How far points k and i would have moved where one takes their place [mm].
    pure real(dp) function apart(k, i)
      integer, intent(in) :: k, i

      apart = norm2(points(:, i) - points(:, k))/2 + max(way(k), way(i))
    end function apart

    subroutine unite(k, i)
      integer, intent(in) :: k, i

      way(k) = apart(k, i)
      points(:, k) = (points(:, k) + points(:, i))/2
      mended%moved = mended%moved + 2
    end subroutine unite

  end subroutine straighten

  !> What must hold in the end.
  subroutine check_points(file, points, at, error)
    character(*), intent(in) :: file
    real(dp), intent(in) :: points(:, :)
    integer, intent(in) :: at(:)
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
          str(min(at(i), at(j + 1)))//' and '//str(max(at(i), at(j + 1))))
        return
      end do
    end do
    do i = 2, n - 1
      if (turn(points(:, i - 1), points(:, i), points(:, i + 1)) <= largest_turn) cycle
      call fatal_error(error, file//', line '//str(at(i))//': expected a curve that turns by at most '// &
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

  pure logical function crosses(a, b)
    real(dp), intent(in) :: a(2, 2), b(2, 2)   !! two segments, (coordinate, end)

    crosses = side(a, b(:, 1))*side(a, b(:, 2)) <= 0 .and. side(b, a(:, 1))*side(b, a(:, 2)) <= 0 &
      .and. max(minval(a(2, :)), minval(b(2, :))) <= min(maxval(a(2, :)), maxval(b(2, :))) &
      .and. max(minval(a(1, :)), minval(b(1, :))) <= min(maxval(a(1, :)), maxval(b(1, :)))
  end function crosses

  pure real(dp) function side(a, point)
    real(dp), intent(in) :: a(2, 2), point(2)

    side = (a(1, 2) - a(1, 1))*(point(2) - a(2, 1)) - (a(2, 2) - a(2, 1))*(point(1) - a(1, 1))
  end function side

end module profile_repair