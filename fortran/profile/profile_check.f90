!> Conditions that points must satisfy to be a wheel's or a rail's profile.
module profile_check
  use errors, only: error_type, refuse
  use kinds, only: degree, dp
  use text, only: str
  implicit none
  private
  public :: check_points, is_wheel, is_rail

  integer, parameter :: is_wheel = 1, is_rail = 2
  integer, parameter :: least_points = 10
  !> Plausible widths: least of a file that Python has not made, of a model 1:10, and largest [mm].
  real(dp), parameter :: least_width = 10, least_model = 5, largest_width = 1000
  real(dp), parameter :: least_spacing = 1e-3_dp                 !! nearer points are one point [mm]
  real(dp), parameter :: largest_turn = 120*degree               !! turn at a point: above, two points are exchanged
  real(dp), parameter :: near_origin = 3                         !! y of a wheel's back, of a gauge point [mm]
  !> Height above or below the middle that is clear [mm], and narrower profiles of models have less of it [mm].
  real(dp), parameter :: clear = 5, full_width = 50

contains

  !> Fails where the points are too few, too narrow, too wide, in the wrong order, not along one curve, or not of the kind.
  subroutine check_points(file, kind, strict, points, line, error)
    character(*), intent(in) :: file
    integer, intent(in) :: kind                !! is_wheel or is_rail
    logical, intent(in) :: strict              !! whether faces and gaps are refused, too
    real(dp), intent(in) :: points(:, :)       !! y, z, (2, n) [mm]
    integer, intent(in) :: line(:)             !! of each point in the file
    type(error_type), allocatable, intent(out) :: error
    integer :: n, tip
    real(dp) :: middle, height, least

    n = size(points, 2)
    if (n < least_points) then
      call refuse(error, 'at least '//str(least_points)//' points', str(n), file)
      return
    end if
    associate (y => points(1, :), z => points(2, :))
      if (maxval(y) - minval(y) < merge(least_width, least_model, strict) .or. maxval(y) - minval(y) > largest_width) then
        call refuse(error, 'y in mm over '//str(least_width)//' to '//str(largest_width)//' mm', &
          'a width of '//str(maxval(y) - minval(y)), file)
      else if (y(n) <= y(1)) then
        call refuse(error, 'points in the order of increasing y', &
          'the first at y = '//str(y(1))//' and the last at y = '//str(y(n)), file)
      else
        call check_curve(file, points, line, error)
      end if
      if (allocated(error)) return
      middle = (minval(y) + maxval(y))/2
      height = z(minloc(abs(y - middle), 1))
      least = clear*min(1.0_dp, (maxval(y) - minval(y))/full_width)
      tip = minloc(z, 1)
      if (kind == is_wheel .and. (tip == 1 .or. y(tip) >= middle .or. z(tip) > height - least)) then
        call refuse(error, &
          'a wheel, with z up and y from its back: a flange whose tip is below the middle and nearer to the back', &
          'the lowest point at y = '//str(y(tip))//', '//str(height - z(tip))//' mm below the middle', file)
      else if (kind == is_rail .and. max(z(1), z(n)) > height + least) then
        call refuse(error, 'a rail, with z up: ends below the middle', &
          'an end '//str(max(z(1), z(n)) - height)//' mm above it', file)
      else if (strict) then
        call check_extent(file, kind, points, line, error)
      end if
    end associate
  end subroutine check_points

  !> Fails where there is a gap between points, where a wheel's y does not begin at its back, and where a wheel has the face of
  !> its back above the tread or that of its rim, on which no contact lies.
  subroutine check_extent(file, kind, points, line, error)
    character(*), intent(in) :: file
    integer, intent(in) :: kind
    real(dp), intent(in) :: points(:, :)
    integer, intent(in) :: line(:)
    type(error_type), allocatable, intent(out) :: error
    real(dp), parameter :: upright = 60*degree, end_length = 2     ! slope of a rim's face, over so many mm
    real(dp), parameter :: least_gap = 2, times = 8                ! [mm], and over the mean spacing
    real(dp) :: spacing(size(points, 2) - 1), rim(2)
    integer :: i, n

    n = size(points, 2)
    spacing = [(norm2(points(:, i + 1) - points(:, i)), i=1, n - 1)]
    i = maxloc(spacing, 1)
    if (spacing(i) > max(least_gap, times*sum(spacing)/(n - 1))) then
      call refuse(error, 'points along a curve', 'a gap of '//str(spacing(i))//' mm', file, line(i + 1))
      return
    end if
    if (kind == is_rail) then
      call check_head(file, points, error)
      return
    end if
    i = n - 1
    do while (i > 1 .and. norm2(points(:, n) - points(:, i)) < end_length)
      i = i - 1
    end do
    rim = points(:, n) - points(:, i)
    if (abs(minval(points(1, :))) > near_origin) then
      call refuse(error, 'a wheel''s y from its back, at y = 0', 'the least y = '//str(minval(points(1, :))), file)
    else if (points(2, 1) > points(2, n) .or. abs(rim(2)) > tan(upright)*abs(rim(1))) then
      call refuse(error, 'a wheel without the upright faces of its back and of its rim', 'such a face', file)
    end if
  end subroutine check_extent

  !> Fails where a rail's y is not 0 at its gauge point, as of a right rail, and where more than the head is there.
  subroutine check_head(file, points, error)
    character(*), intent(in) :: file
    real(dp), intent(in) :: points(:, :)
    type(error_type), allocatable, intent(out) :: error
    real(dp), parameter :: gauge_depth = 14, deepest = 60, undercut = 0.5   ! below the top, way back under the head [mm]
    real(dp) :: outermost
    integer :: i, gauge

    associate (y => points(1, :), z => points(2, :))
      gauge = findloc(z >= maxval(z) - gauge_depth, .true., 1)
      if (abs(y(gauge)) > near_origin) then
        call refuse(error, 'a rail''s y from its gauge point, '//str(gauge_depth)//' mm below the top, at y = 0', &
          'y = '//str(y(gauge))//' there', file)
        return
      end if
      outermost = y(1)
      do i = 2, size(y)
        outermost = max(outermost, y(i))
        if (y(i) >= outermost - undercut .and. z(i) >= maxval(z) - deepest) cycle
        call refuse(error, 'points of the head of a rail alone', &
          'points under the head at y = '//str(y(i))//', z = '//str(z(i)), file)
        return
      end do
    end associate
  end subroutine check_head

  !> Fails where points repeat and where the curve through them crosses itself or turns too much at a point.
  subroutine check_curve(file, points, line, error)
    character(*), intent(in) :: file
    real(dp), intent(in) :: points(:, :)
    integer, intent(in) :: line(:)
    type(error_type), allocatable, intent(out) :: error
    real(dp) :: least_after(size(points, 2))   ! y of this and all later points [mm]
    integer :: n, i, j

    n = size(points, 2)
    least_after = points(1, :)
    do i = n - 1, 1, -1
      least_after(i) = min(least_after(i), least_after(i + 1))
    end do
    do i = 2, n
      if (norm2(points(:, i) - points(:, i - 1)) >= least_spacing) cycle
      call refuse(error, 'a point at least '//str(least_spacing)//' mm from the one before', &
        'one at '//str(norm2(points(:, i) - points(:, i - 1))), file, line(i))
      return
    end do
    do i = 1, n - 3
      do j = i + 2, n - 1
        ! The exact test runs for near neighbours only: the curve may come back over this segment, or it has gone past.
        if (least_after(j) > max(points(1, i), points(1, i + 1))) exit
        if (min(points(1, i), points(1, i + 1)) > max(points(1, j), points(1, j + 1))) cycle
        if (max(points(1, i), points(1, i + 1)) < min(points(1, j), points(1, j + 1))) cycle
        if (.not. crosses(points(:, i:i + 1), points(:, j:j + 1))) cycle
        call refuse(error, 'a curve that does not cross itself', &
          'a crossing between lines '//str(line(i))//' and '//str(line(j + 1)), file)
        return
      end do
    end do
    do i = 2, n - 1
      if (turn(points(:, i - 1), points(:, i), points(:, i + 1)) <= largest_turn) cycle
      call refuse(error, 'a curve that turns by at most '//str(nint(largest_turn/degree))//' degrees at a point', &
        str(nint(turn(points(:, i - 1), points(:, i), points(:, i + 1))/degree)), file, line(i))
      return
    end do
  end subroutine check_curve

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

end module profile_check
