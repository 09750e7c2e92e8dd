!> A plane curve through measured points: cubic smoothing splines y(s), z(s)
!> over the cumulative chord length s (arc length to within 1e-6), continued
!> as straight lines beyond both ends.
!>
!> Smoothing: C. H. Reinsch, "Smoothing by spline functions", Numer. Math. 10
!> (1967) 177-183.
module curve
  use errors, only: error_type, fatal_error
  use kinds, only: dp
  implicit none
  private
  public :: curve_type, fit_curve, curve_point, curve_frame, find_interval, near_interval

  type :: curve_type
    integer :: n = 0                     !! knots
    real(dp), allocatable :: s(:)        !! station of each knot [m], (0:n+1); 0 is the first too, n+1 never reached
    real(dp), allocatable :: a(:, :, :)  !! cubic coefficients of y and z in (s - s_i), (2, 4, 0:n); straight in 0 and n
  contains
    procedure :: first => first_station
    procedure :: last => last_station
  end type curve_type

  interface
    subroutine dpbsv(uplo, n, kd, nrhs, ab, ldab, b, ldb, info)
      import :: dp
      character, intent(in) :: uplo
      integer, intent(in) :: n, kd, nrhs, ldab, ldb
      real(dp), intent(inout) :: ab(ldab, *), b(ldb, *)
      integer, intent(out) :: info
    end subroutine dpbsv
  end interface

contains

  !> Fit a curve to points.  `smoothing` is the root-mean-square distance
  !> [same unit as the points] that the curve may keep from them; 0 interpolates.
  subroutine fit_curve(y, z, smoothing, c, error)
    real(dp), intent(in) :: y(:), z(:)
    real(dp), intent(in) :: smoothing
    type(curve_type), intent(out) :: c
    type(error_type), allocatable, intent(out) :: error
    real(dp) :: f(size(y), 2), f2(size(y), 2), d2(2), lambda, low, high
    integer :: n, i, iter

    n = size(y)
    c%n = n
    allocate (c%s(0:n + 1), c%a(2, 4, 0:n))
    c%s(:1) = 0
    c%s(n + 1) = huge(c%s)
    do i = 2, n
      c%s(i) = c%s(i - 1) + hypot(y(i) - y(i - 1), z(i) - z(i - 1))
    end do

    lambda = 0
    call smooth(lambda)
    if (smoothing > 0 .and. .not. allocated(error)) then
      ! The distance grows monotonically with lambda: bisect its logarithm.
      low = -45
      high = 0
      do iter = 1, 60
        lambda = exp(0.5_dp*(low + high))
        call smooth(lambda)
        if (allocated(error)) return
        if (distance() > smoothing) then
          high = log(lambda)
        else
          low = log(lambda)
        end if
      end do
    end if
    if (allocated(error)) return

    do i = 1, n - 1
      c%a(1, :, i) = cubic(f(i:i + 1, 1), f2(i:i + 1, 1), c%s(i + 1) - c%s(i))
      c%a(2, :, i) = cubic(f(i:i + 1, 2), f2(i:i + 1, 2), c%s(i + 1) - c%s(i))
    end do
    c%a(:, :, [0, n]) = 0
    c%a(:, :2, 0) = c%a(:, :2, 1)
    call cubic_point(c%a(:, :, n - 1), c%s(n) - c%s(n - 1), c%a(:, 1, n), c%a(:, 2, n), d2)

  contains

    !> Reinsch: (T + lambda Q'Q) f2 = Q' points, f = points - lambda Q f2.
    subroutine smooth(lambda)
      real(dp), intent(in) :: lambda
      real(dp) :: ab(3, n - 2), rhs(n - 2, 2), r(n - 1), q(3, n - 2)
      integer :: j, info

      r = 1/(c%s(2:n) - c%s(1:n - 1))
      do j = 1, n - 2
        q(:, j) = [r(j), -r(j) - r(j + 1), r(j + 1)]
        rhs(j, 1) = dot_product(q(:, j), y(j:j + 2))
        rhs(j, 2) = dot_product(q(:, j), z(j:j + 2))
      end do
      ab = 0
      do j = 1, n - 2
        ab(3, j) = (1/r(j) + 1/r(j + 1))/3 + lambda*sum(q(:, j)**2)
      end do
      do j = 2, n - 2
        ab(2, j) = 1/(6*r(j)) + lambda*dot_product(q(2:3, j - 1), q(1:2, j))
      end do
      do j = 3, n - 2
        ab(1, j) = lambda*q(3, j - 2)*q(1, j)
      end do
      call dpbsv('U', n - 2, 2, 2, ab, 3, rhs, n - 2, info)
      if (info /= 0) then
        call fatal_error(error, 'smoothing spline: singular system, repeated points?')
        return
      end if
      f2 = 0
      f2(2:n - 1, :) = rhs
      f(:, 1) = y
      f(:, 2) = z
      do j = 1, n - 2
        f(j:j + 2, 1) = f(j:j + 2, 1) - lambda*q(:, j)*rhs(j, 1)
        f(j:j + 2, 2) = f(j:j + 2, 2) - lambda*q(:, j)*rhs(j, 2)
      end do
    end subroutine smooth

    real(dp) function distance()
      distance = sqrt(sum((f(:, 1) - y)**2 + (f(:, 2) - z)**2)/n)
    end function distance

  end subroutine fit_curve

  !> Coefficients of the cubic with end values f and end second derivatives f2.
  pure function cubic(f, f2, h) result(c)
    real(dp), intent(in) :: f(2), f2(2), h
    real(dp) :: c(4)

    c = [f(1), (f(2) - f(1))/h - h*(2*f2(1) + f2(2))/6, f2(1)/2, (f2(2) - f2(1))/(6*h)]
  end function cubic

  pure real(dp) function first_station(c)
    class(curve_type), intent(in) :: c
    first_station = c%s(1)
  end function first_station

  pure real(dp) function last_station(c)
    class(curve_type), intent(in) :: c
    last_station = c%s(c%n)
  end function last_station

  !> Position r and its first two derivatives at station s.  `i` is the knot
  !> interval: a guess on entry (any value), the right one on return.
  pure subroutine curve_point(c, s, i, r, d1, d2)
    type(curve_type), intent(in) :: c
    real(dp), intent(in) :: s
    integer, intent(inout) :: i
    real(dp), intent(out) :: r(2), d1(2), d2(2)

    i = max(0, min(i, c%n))
    call find_interval(c%s, s, i)
    call cubic_point(c%a(:, :, i), s - c%s(i), r, d1, d2)
  end subroutine curve_point

  !> The knot interval i, a guess on entry, of station x on a curve's s.
  pure subroutine find_interval(s, x, i)
    real(dp), intent(in) :: s(0:*), x
    integer, intent(inout) :: i

    do while (x >= s(i + 1))
      i = i + 1
    end do
    do while (x < s(i))
      if (i == 0) exit
      i = i - 1
    end do
  end subroutine find_interval

  !> The knot interval of station s if the knots were equally spaced: a guess.
  pure integer function near_interval(c, s) result(i)
    type(curve_type), intent(in) :: c
    real(dp), intent(in) :: s

    i = 1 + int((c%n - 1)*(s - c%first())/(c%last() - c%first()))
  end function near_interval

  pure subroutine cubic_point(a, t, r, d1, d2)
    real(dp), intent(in) :: a(2, 4), t
    real(dp), intent(out) :: r(2), d1(2), d2(2)

    r = a(:, 1) + t*(a(:, 2) + t*(a(:, 3) + t*a(:, 4)))
    d1 = a(:, 2) + t*(2*a(:, 3) + t*3*a(:, 4))
    d2 = 2*a(:, 3) + 6*t*a(:, 4)
  end subroutine cubic_point

  !> Position, tangent angle to the y axis [rad] and signed curvature d(angle)/ds
  !> [1/m] at station s.
  pure subroutine curve_frame(c, s, r, angle, curvature)
    type(curve_type), intent(in) :: c
    real(dp), intent(in) :: s
    real(dp), intent(out) :: r(2), angle, curvature
    real(dp) :: d1(2), d2(2)
    integer :: i

    i = near_interval(c, s)
    call curve_point(c, s, i, r, d1, d2)
    angle = atan2(d1(2), d1(1))
    curvature = (d1(1)*d2(2) - d1(2)*d2(1))/(d1(1)**2 + d1(2)**2)**1.5_dp
  end subroutine curve_frame

end module curve
