!> The plane curve through points: cubic splines over the cumulative chord length, which is the arc length to within 1e-6.
!> The noise of the points says whether such a curve suits them.
module curve_fit
  use curve, only: curve_type, extend
  use errors, only: error_type, fatal_error
  use kinds, only: dp
  implicit none
  private
  public :: interpolate, point_noise

contains

  !> The natural cubic splines y(s), z(s) through at least three points.  Fails where points repeat.
  subroutine interpolate(y, z, c, error)
    real(dp), intent(in) :: y(:), z(:)     !! [m], in the order of the walk along the curve
    type(curve_type), intent(out) :: c
    type(error_type), allocatable, intent(out) :: error
    real(dp) :: f2(size(y), 2), diagonal(size(y) - 2), beside(size(y) - 2), r(size(y) - 1), q(3)
    integer :: n, i
    logical :: solved

    n = size(y)
    c%n = n
    allocate (c%s(0:n + 1), c%a(2, 4, 0:n))
    c%s(1:n) = chord_stations(y, z)
    r = 1/(c%s(2:n) - c%s(1:n - 1))
    f2 = 0
    do i = 1, n - 2
      q = [r(i), -r(i) - r(i + 1), r(i + 1)]
      f2(i + 1, 1) = dot_product(q, y(i:i + 2))
      f2(i + 1, 2) = dot_product(q, z(i:i + 2))
      diagonal(i) = (1/r(i) + 1/r(i + 1))/3
      beside(i) = 1/(6*r(i + 1))
    end do
    call solve_tridiagonal(diagonal, beside, f2(2:n - 1, :), solved)
    if (.not. (n > 2 .and. solved)) then
      call fatal_error(error, 'spline: singular system, repeated points?')
      return
    end if
    do i = 1, n - 1
      c%a(1, :, i) = cubic(y(i:i + 1), f2(i:i + 1, 1), c%s(i + 1) - c%s(i))
      c%a(2, :, i) = cubic(z(i:i + 1), f2(i:i + 1, 2), c%s(i + 1) - c%s(i))
    end do
    call extend(c)
  end subroutine interpolate

  !> Solve a symmetric positive definite tridiagonal system by Cholesky's method.  A library's last digits would depend on the
  !> processor, and with them every curve, table and chaotic result.
  pure subroutine solve_tridiagonal(diagonal, beside, b, solved)
    real(dp), intent(inout) :: diagonal(:), beside(:)  !! matrix elements (i, i) and (i, i + 1); factors afterwards
    real(dp), intent(inout) :: b(:, :)                 !! right-hand sides in columns; solutions afterwards
    logical, intent(out) :: solved                     !! the matrix is positive definite
    integer :: i, n

    n = size(diagonal)
    solved = .false.
    do i = 1, n
      if (.not. diagonal(i) > 0) return
      diagonal(i) = sqrt(diagonal(i))
      b(i, :) = b(i, :)/diagonal(i)
      if (i == n) exit
      beside(i) = beside(i)*(1/diagonal(i))
      diagonal(i + 1) = diagonal(i + 1) - beside(i)**2
      b(i + 1, :) = b(i + 1, :) - beside(i)*b(i, :)
    end do
    do i = n, 1, -1
      if (i < n) b(i, :) = b(i, :) - beside(i)*b(i + 1, :)
      b(i, :) = b(i, :)/diagonal(i)
    end do
    solved = .true.
  end subroutine solve_tridiagonal

  !> Cumulative chord length up to every point.
  pure function chord_stations(y, z) result(s)
    real(dp), intent(in) :: y(:), z(:)
    real(dp) :: s(size(y))
    integer :: i

    s(1) = 0
    do i = 2, size(y)
      s(i) = s(i - 1) + hypot(y(i) - y(i - 1), z(i) - z(i - 1))
    end do
  end function chord_stations

  !> Coefficients of the cubic with end values f and end second derivatives f2.
  pure function cubic(f, f2, h) result(c)
    real(dp), intent(in) :: f(2), f2(2), h
    real(dp) :: c(4)

    c = [f(1), (f(2) - f(1))/h - h*(2*f2(1) + f2(2))/6, f2(1)/2, (f2(2) - f2(1))/(6*h)]
  end function cubic

  !> Noise of points [m], across the curve, rms: how far each point is from the cubic through its two neighbours on either
  !> side.  The median leaves out the few points at which the curve itself has a corner.  0 where too few points lie close
  !> together.
  pure real(dp) function point_noise(y, z) result(noise)
    real(dp), intent(in) :: y(:), z(:)     !! [m], in the order of the walk along the curve
    real(dp), parameter :: widest = 1e-3_dp    ! largest spacing [m]
    integer, parameter :: fewest = 10              ! points
    real(dp), parameter :: deviation = 1.4826_dp   ! standard deviation of normal noise, over the median of its absolute value
    integer, parameter :: others(4) = [-2, -1, 1, 2]
    real(dp) :: s(size(y)), off(size(y)), weight(4), rest(3), away(2), way(2)
    integer :: i, j, n

    noise = 0
    s = chord_stations(y, z)
    n = 0
    do i = 3, size(y) - 2
      associate (gap => s(i - 1:i + 2) - s(i - 2:i + 1), at => s(i + others) - s(i))
        if (.not. (minval(gap) > 0 .and. maxval(gap) <= widest)) cycle
        do j = 1, 4
          rest = pack(at, others /= others(j))
          weight(j) = product(rest/(rest - at(j)))      ! Lagrange's, at the point
        end do
      end associate
      away = [y(i), z(i)] - [dot_product(weight, y(i + others)), dot_product(weight, z(i + others))]
      way = [y(i + 1) - y(i - 1), z(i + 1) - z(i - 1)]
      if (.not. norm2(way) > 0) cycle
      n = n + 1
      off(n) = abs(way(1)*away(2) - way(2)*away(1))/norm2(way)/sqrt(1 + sum(weight**2))
    end do
    if (n < fewest) return
    noise = deviation*minval(off(:n), [(2*count(off(:n) <= off(i)) >= n, i=1, n)])
  end function point_noise

end module curve_fit
