!> Which way a profile lies in its file and whether it is a wheel or a rail, told by the shape, and which of its points
!> can be running surface.
module profile_orientation
  use kinds, only: degree, dp, pi
  implicit none
  private
  public :: recognise, turn_over, put_in_order, cut_faces, is_wheel, is_rail, tape_circle

  integer, parameter :: is_wheel = 1, is_rail = 2

  real(dp), parameter :: tape_circle = 70        !! distance from the wheel's back (EN 15313) [mm]
  real(dp), parameter :: face = 60*degree        !! a steeper end of a profile is a face
  real(dp), parameter :: chord = 3               !! length over which directions are taken: larger than any noise [mm]
  real(dp), parameter :: least_flange = 12       !! least height of a flange [mm]
  real(dp), parameter :: head_depth = 10, deepest_side = 60   !! the sides of a rail's head are between, below its top [mm]

contains

  !> Whether points show a wheel or a rail, and which axes must be turned over so that z is up and y goes from the
  !> track to the field side, as on a left wheel or rail.  The y of a symmetric rail stays.
  pure subroutine recognise(points, kind, found, flip)
    real(dp), intent(in) :: points(:, :)   !! (2, n) [mm]
    integer, intent(in) :: kind            !! is_wheel, is_rail, or 0 for either
    integer, intent(out) :: found          !! is_wheel, is_rail, or 0 for neither
    logical, intent(out) :: flip(2)        !! whether to turn over y, z

    found = 0
    flip = .false.
    if (kind /= is_rail) call recognise_wheel(points, found, flip)
    if (kind /= is_wheel .and. found == 0) call recognise_rail(points, found, flip)
  end subroutine recognise

  !> Recognise a wheel: without the faces at both ends, its flange reaches farthest from the level of the tread.
  pure subroutine recognise_wheel(points, found, flip)
    real(dp), intent(in) :: points(:, :)
    integer, intent(out) :: found
    logical, intent(out) :: flip(2)
    real(dp) :: angle(size(points, 2)), s(size(points, 2)), level, low, high, tip, middle
    integer :: first, last, n

    found = 0
    flip = .false.
    n = size(points, 2)
    call directions(points, chord, s, angle)
    first = 1
    do while (first < n - 5 .and. abs(sin(angle(first))) > sin(face))
      first = first + 1
    end do
    last = n
    do while (last > first + 5 .and. abs(sin(angle(last))) > sin(face))
      last = last - 1
    end do
    level = median(points(2, first:last), s(first:last))
    low = level - minval(points(2, first:last))
    high = maxval(points(2, first:last)) - level
    if (max(low, high) < least_flange .or. max(low, high) < 1.5_dp*min(low, high)) return
    flip(2) = high > low
    if (flip(2)) then
      tip = points(1, first - 1 + maxloc(points(2, first:last), 1))
    else
      tip = points(1, first - 1 + minloc(points(2, first:last), 1))
    end if
    middle = (minval(points(1, :)) + maxval(points(1, :)))/2
    flip(1) = tip > middle
    ! A rail's head has its top in the middle, and both of its sides go down.
    if (abs(tip - middle) > 0.15_dp*(maxval(points(1, :)) - minval(points(1, :)))) found = is_wheel
    if (found == 0) flip = .false.
  end subroutine recognise_wheel

  !> Recognise a rail: its head is above its sides.  The side towards the track is the one at y = 0, or the lower one.
  pure subroutine recognise_rail(points, found, flip)
    real(dp), intent(in) :: points(:, :)
    integer, intent(out) :: found
    logical, intent(out) :: flip(2)
    real(dp), parameter :: gauge_depth = 14      ! depth below the top at which the gauge is measured [mm]
    real(dp), parameter :: lean = 3e-3_dp  ! least slope of a head that is not upright
    real(dp) :: z(size(points, 2)), middle, ends, y(2), mean, slope
    integer :: n, i, top, side

    n = size(points, 2)
    found = 0
    flip = .false.
    middle = points(2, minloc(abs(points(1, :) - (minval(points(1, :)) + maxval(points(1, :)))/2), 1))
    ends = (points(2, 1) + points(2, n))/2
    if (abs(middle - ends) < 5) return
    found = is_rail
    flip(2) = middle < ends
    z = merge(-points(2, :), points(2, :), flip(2))
    top = maxloc(z, 1)
    ! y of both sides at the depth of the gauge, or as far down as the file goes.
    do side = 1, 2
      y(side) = points(1, merge(1, n, side == 1))
      do i = top, merge(1, n, side == 1), merge(-1, 1, side == 1)
        if (z(i) > z(top) - gauge_depth) cycle
        y(side) = points(1, i)
        exit
      end do
    end do
    if (minval(abs(y)) < 3 .and. maxval(abs(y)) > 30) then
      flip(1) = sum(y) < 0
      return
    end if
    ! The slope of the head's crown, the middle half of its width.
    mean = sum(y)/2
    slope = crown_slope(points(1, :), z, mean, abs(y(2) - y(1))/4)
    if (abs(slope) > lean) flip(1) = slope < 0
  end subroutine recognise_rail

  !> Slope of the line through the points of a head's crown that are within `reach` of y = `mean` [mm], by least squares;
  !> 0 for fewer than three points.
  pure real(dp) function crown_slope(y, z, mean, reach) result(slope)
    real(dp), intent(in) :: y(:), z(:), mean, reach
    real(dp) :: w(size(y)), cy, cz

    w = merge(1, 0, abs(y - mean) < reach .and. z > maxval(z) - 10)
    slope = 0
    if (sum(w) < 3) return
    cy = sum(w*y)/sum(w)
    cz = sum(w*z)/sum(w)
    slope = sum(w*(y - cy)*(z - cz))/max(sum(w*(y - cy)**2), tiny(1.0_dp))
  end function crown_slope

  !> Turn over the axes of points.
  pure subroutine turn_over(points, flip)
    real(dp), intent(inout) :: points(:, :)
    logical, intent(in) :: flip(2)

    if (flip(1)) points(1, :) = -points(1, :)
    if (flip(2)) points(2, :) = -points(2, :)
  end subroutine turn_over

  !> Put points in order towards the field side.  A closed contour begins at its lowest point.
  pure subroutine put_in_order(points, line)
    real(dp), intent(inout) :: points(:, :)
    integer, intent(inout) :: line(:)
    real(dp), parameter :: closed = 3      ! the ends of a closed contour are nearer [mm]
    integer :: n, low, top

    n = size(points, 2)
    if (norm2(points(:, n) - points(:, 1)) < closed) then
      low = minloc(points(2, :), 1)
      points = cshift(points, low - 1, 2)
      line = cshift(line, low - 1)
      top = maxloc(points(2, :), 1)
      if (points(1, max(top - 1, 1)) <= points(1, min(top + 1, n))) return
    else if (points(1, 1) <= points(1, n)) then
      return
    end if
    points = points(:, n:1:-1)
    line = line(n:1:-1)
  end subroutine put_in_order

  !> The points first..last that can be running surface or hold it: without the part of a wheel's back above the level
  !> of its tread, without its rim face, and without the part of a rail below the sides of its head.
  pure subroutine cut_faces(points, kind, first, last)
    real(dp), intent(in) :: points(:, :)   !! turned and in order [mm]
    integer, intent(in) :: kind            !! is_wheel or is_rail
    integer, intent(out) :: first, last
    real(dp), parameter :: undercut = 0.5_dp   ! way in y below a head by which its side ends [mm]
    real(dp), parameter :: upright = 0.02_dp   ! largest way in y along a vertical side [mm]
    real(dp) :: angle(size(points, 2)), s(size(points, 2)), extreme
    integer :: n, i, tip, tape, side, edge

    n = size(points, 2)
    first = 1
    last = n
    if (kind == is_wheel) then
      tip = minloc(points(2, :), 1)
      tape = min(n, count(points(1, :) < minval(points(1, :tip)) + tape_circle) + 1)
      if (tape <= tip) return
      do i = 1, tip
        if (points(2, i) > points(2, tape)) first = i
      end do
      call directions(points, chord/2, s, angle)
      do last = tape, n
        ! Points that go back have another direction than a face.
        if (angle(last) > face .and. angle(last) < pi - face) exit
      end do
      last = min(last, n)
    else
      tip = maxloc(points(2, :), 1)
      do side = -1, 1, 2
        extreme = points(1, tip)
        edge = tip
        do i = tip, merge(1, n, side < 0), side
          if (side*(points(1, i) - extreme) > 0) extreme = points(1, i)
          if (side*(points(1, i) - extreme) > -upright) edge = i
          if (side*(points(1, i) - extreme) < -undercut .and. points(2, i) < points(2, tip) - head_depth &
            .or. points(2, i) < points(2, tip) - deepest_side) then
            if (side < 0) first = edge
            if (side > 0) last = edge
            exit
          end if
        end do
      end do
    end if
  end subroutine cut_faces

  !> Stations of points [mm], and the direction [rad] of a chord of the given length about each point.
  pure subroutine directions(points, length, s, angle)
    real(dp), intent(in) :: points(:, :), length
    real(dp), intent(out) :: s(:), angle(:)
    integer :: i, low, high, n

    n = size(s)
    s(1) = 0
    do i = 2, n
      s(i) = s(i - 1) + norm2(points(:, i) - points(:, i - 1))
    end do
    low = 1
    high = 1
    do i = 1, n
      do while (low < i - 1 .and. s(min(low + 1, n)) <= s(i) - length/2)
        low = low + 1
      end do
      high = max(high, min(i + 1, n))
      do while (high < n .and. s(high) < s(i) + length/2)
        high = high + 1
      end do
      angle(i) = atan2(points(2, high) - points(2, low), points(1, high) - points(1, low))
    end do
  end subroutine directions

  !> Median of x over the length s: on half of the length x is smaller.
  pure real(dp) function median(x, s)
    real(dp), intent(in) :: x(:), s(:)
    real(dp) :: low, high
    integer :: i, iter

    low = minval(x)
    high = maxval(x)
    do iter = 1, 50
      median = (low + high)/2
      if (sum([((s(i + 1) - s(i)), i=1, size(x) - 1)], mask=x(:size(x) - 1) < median) > (s(size(x)) - s(1))/2) then
        high = median
      else
        low = median
      end if
    end do
  end function median

end module profile_orientation
