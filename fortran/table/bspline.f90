!> Tensor-product cubic B-splines on axes of any points: coefficients, value, gradient, Hessian.
!>
!> The knots are the points; beyond the ends the knots continue at the last spacing. A spline on n points has n + 2
!> coefficients. A coefficient depends on the values at three points only, the nearest ones, so that it is known where they are:
!> it is the blossom of the parabola through them at the inner knots of its B-spline. Such a spline is any given cubic, and misses
!> other functions by about d^4 f''''/36 in cells of length d (C. de Boor, G. J. Fix, J. Approx. Theory 8 (1973) 19-45; T. Lyche,
!> L. L. Schumaker, J. Approx. Theory 15 (1975) 294-325).
!>
!> Four B-splines are not zero in a cell; they are kept as polynomials. C. de Boor, A Practical Guide to Splines.
module bspline
  use kinds, only: dp
  implicit none
  private
  public :: axis_type, basis_type, new_axis, axis_holds, axis_cell, axis_basis, spline_2d_value, spline_2d, spline_3d, &
    spline_3d_line

  type :: axis_type
    integer :: n = 0              !! points
    real(dp), allocatable :: x(:) !! ascending
    real(dp) :: low = 0, high = 0 !! the first and the last point
    real(dp), allocatable :: cell(:, :, :)   !! (B-spline, power of x - x(i), cell i)
    integer, allocatable :: bin(:)           !! last cell that begins before the end of each of equal bins
    real(dp) :: bins_per_length = 0       !! bins per unit length
    ! A coefficient is the sum of weight(k)*(value at the point first + k - 1) over k.
    integer, allocatable :: first(:)         !! (coefficient)
    real(dp), allocatable :: weight(:, :)    !! (k, coefficient)
  end type axis_type

  !> The four B-splines that are not zero in one cell, with derivatives with respect to x.
  type :: basis_type
    integer :: i                  !! index of the first coefficient
    real(dp) :: b(4, 0:2)         !! value, first, second derivative
  end type basis_type

contains

  !> Return the axis on at least five ascending points.
  pure function new_axis(points) result(axis)
    real(dp), intent(in) :: points(:)
    type(axis_type) :: axis
    integer, parameter :: n_bins = 1024
    real(dp) :: t(-2:size(points) + 3), b(5, 0:3), wider(4, 0:3), up, down
    integer :: n, i, j, k, l

    n = size(points)
    axis%n = n
    allocate (axis%x, source=points)
    axis%low = points(1)
    axis%high = points(n)
    t(1:n) = points
    t(-2:0) = points(1) + [-3, -2, -1]*(points(2) - points(1))
    t(n + 1:) = points(n) + [1, 2, 3]*(points(n) - points(n - 1))
    allocate (axis%cell(4, 0:3, n - 1), axis%bin(n_bins))
    do i = 1, n - 1
      ! De Boor's recurrence from order 1 to 4 on polynomials of x - x(i); b(l) begins at knot i - 4 + l.
      b = 0
      b(4, 0) = 1
      do k = 2, 4
        wider = 0
        do l = 5 - k, 4
          j = i - 4 + l
          if (l > 5 - k) then
            up = 1/(t(j + k - 1) - t(j))
            wider(l, 0) = wider(l, 0) + (t(i) - t(j))*up*b(l, 0)
            wider(l, 1:) = wider(l, 1:) + (t(i) - t(j))*up*b(l, 1:) + up*b(l, :2)
          end if
          if (l < 4) then
            down = 1/(t(j + k) - t(j + 1))
            wider(l, 0) = wider(l, 0) + (t(j + k) - t(i))*down*b(l + 1, 0)
            wider(l, 1:) = wider(l, 1:) + (t(j + k) - t(i))*down*b(l + 1, 1:) - down*b(l + 1, :2)
          end if
        end do
        b(:4, :) = wider
      end do
      axis%cell(:, :, i) = b(:4, :)
    end do
    axis%bins_per_length = n_bins*(1 - epsilon(1.0_dp))/(axis%high - axis%low)
    ! With the rounding of `axis_basis`, a point that lies in a later bin is never below the cell's beginning.
    k = 1
    do i = 1, n - 1
      l = n_bins
      if (i < n - 1) l = int((points(i + 1) - axis%low)*axis%bins_per_length) + 1
      axis%bin(k:l) = i
      k = l + 1
    end do
    allocate (axis%first(n + 2), axis%weight(3, n + 2))
    do i = 1, n + 2
      axis%first(i) = max(1, min(i - 2, n - 2))
      axis%weight(:, i) = blossom(points(axis%first(i):axis%first(i) + 2), t(i - 2:i))
    end do
  end function new_axis

  !> Weights of the values at three points x in the blossom, at three knots t, of the parabola through them.
  pure function blossom(x, t) result(weight)
    real(dp), intent(in) :: x(3), t(3)
    real(dp) :: weight(3), mean, product
    integer :: k

    mean = sum(t)/3
    product = (t(1)*t(2) + t(1)*t(3) + t(2)*t(3))/3
    do k = 1, 3
      associate (a => x(1 + mod(k, 3)), b => x(1 + mod(k + 1, 3)))
        weight(k) = (product - (a + b)*mean + a*b)/((x(k) - a)*(x(k) - b))
      end associate
    end do
  end function blossom

  !> Whether x lies between the ends of an axis; false for NaN.
  pure logical function axis_holds(axis, x)
    type(axis_type), intent(in) :: axis
    real(dp), intent(in) :: x

    axis_holds = x >= axis%low .and. x <= axis%high
  end function axis_holds

  !> The cell of an axis that holds x; x must lie on the axis.
  pure integer function axis_cell(axis, x) result(i)
    type(axis_type), intent(in) :: axis
    real(dp), intent(in) :: x

    i = axis%bin(int((x - axis%low)*axis%bins_per_length) + 1)
    do while (i < axis%n - 1)
      if (x < axis%x(i + 1)) exit
      i = i + 1
    end do
  end function axis_cell

  !> Compute the B-splines at x in a cell, without their second derivatives if `second` is false.
  pure subroutine axis_basis(axis, cell, x, basis, second)
    type(axis_type), intent(in) :: axis
    integer, intent(in) :: cell
    real(dp), intent(in) :: x
    type(basis_type), intent(out) :: basis
    logical, intent(in) :: second
    real(dp) :: t

    basis%i = cell
    t = x - axis%x(cell)
    associate (c => axis%cell(:, :, cell))
      basis%b(:, 0) = c(:, 1) + t*(c(:, 2) + t*(c(:, 3) + t*c(:, 4)))
      basis%b(:, 1) = c(:, 2) + t*(2*c(:, 3) + t*(3*c(:, 4)))
      if (second) basis%b(:, 2) = 2*c(:, 3) + t*(6*c(:, 4))
    end associate
  end subroutine axis_basis

  !> Return the value of sum c(i, j) X_i Y_j.
  pure real(dp) function spline_2d_value(c, x, y) result(v)
    real(dp), intent(in) :: c(:, :)
    type(basis_type), intent(in) :: x, y
    integer :: j

    v = 0
    do j = 1, 4
      v = v + y%b(j, 0)*dot_product(c(x%i:x%i + 3, y%i + j - 1), x%b(:, 0))
    end do
  end function spline_2d_value

  !> Compute the value and the gradient of sum c(i, j) X_i Y_j.
  pure subroutine spline_2d_gradient(c, x, y, v)
    real(dp), intent(in), contiguous :: c(:, :)
    type(basis_type), intent(in) :: x, y
    real(dp), intent(out) :: v(3)          !! f, fx, fy
    real(dp) :: t(4), ty(4)
    integer :: i, j

    t = y%b(1, 0)*c(x%i:x%i + 3, y%i)
    ty = y%b(1, 1)*c(x%i:x%i + 3, y%i)
    do j = 2, 4
      do i = 1, 4
        t(i) = t(i) + y%b(j, 0)*c(x%i + i - 1, y%i + j - 1)
        ty(i) = ty(i) + y%b(j, 1)*c(x%i + i - 1, y%i + j - 1)
      end do
    end do
    v = [dot_product(t, x%b(:, 0)), dot_product(t, x%b(:, 1)), dot_product(ty, x%b(:, 0))]
  end subroutine spline_2d_gradient

  !> Compute the value, the gradient (x, y) and, if `second`, the Hessian (xx, xy, yy) of sum c(i, j) X_i Y_j.
  pure subroutine spline_2d(c, x, y, second, v)
    real(dp), intent(in), contiguous :: c(:, :)
    type(basis_type), intent(in) :: x, y
    logical, intent(in) :: second
    real(dp), intent(inout) :: v(6)        !! f, fx, fy, fxx, fxy, fyy; the last three if `second`
    real(dp) :: a(4, 0:2)
    integer :: j

    if (.not. second) then
      call spline_2d_gradient(c, x, y, v(:3))
      return
    end if
    do j = 1, 4
      a(j, 0) = dot_product(c(x%i:x%i + 3, y%i + j - 1), x%b(:, 0))
      a(j, 1) = dot_product(c(x%i:x%i + 3, y%i + j - 1), x%b(:, 1))
      a(j, 2) = dot_product(c(x%i:x%i + 3, y%i + j - 1), x%b(:, 2))
    end do
    v(1) = dot_product(a(:, 0), y%b(:, 0))
    v(2) = dot_product(a(:, 1), y%b(:, 0))
    v(3) = dot_product(a(:, 0), y%b(:, 1))
    v(4) = dot_product(a(:, 2), y%b(:, 0))
    v(5) = dot_product(a(:, 1), y%b(:, 1))
    v(6) = dot_product(a(:, 0), y%b(:, 2))
  end subroutine spline_2d

  !> Compute the value and the gradient of sum c(i, j, k) X_i Y_j Z_k.
  pure subroutine spline_3d_gradient(c, x, y, z, v)
    real(dp), intent(in), contiguous :: c(:, :, :)
    type(basis_type), intent(in) :: x, y, z
    real(dp), intent(out) :: v(4)          !! f, fx, fy, fz
    real(dp) :: s(4), sy(4), t(4), ty(4), tz(4)
    integer :: i, j, k

    t = 0
    ty = 0
    tz = 0
    do k = 1, 4
      s = y%b(1, 0)*c(x%i:x%i + 3, y%i, z%i + k - 1)
      sy = y%b(1, 1)*c(x%i:x%i + 3, y%i, z%i + k - 1)
      do j = 2, 4
        do i = 1, 4
          s(i) = s(i) + y%b(j, 0)*c(x%i + i - 1, y%i + j - 1, z%i + k - 1)
          sy(i) = sy(i) + y%b(j, 1)*c(x%i + i - 1, y%i + j - 1, z%i + k - 1)
        end do
      end do
      t = t + z%b(k, 0)*s
      ty = ty + z%b(k, 0)*sy
      tz = tz + z%b(k, 1)*s
    end do
    v = [dot_product(t, x%b(:, 0)), dot_product(t, x%b(:, 1)), dot_product(ty, x%b(:, 0)), dot_product(tz, x%b(:, 0))]
  end subroutine spline_3d_gradient

  !> Compute the sums over j and k of c(i, j, k) Y_j Z_k for four i from `first` on.
  pure subroutine spline_3d_line(c, first, y, z, line)
    real(dp), intent(in), contiguous :: c(:, :, :)
    integer, intent(in) :: first
    type(basis_type), intent(in) :: y, z
    real(dp), intent(out) :: line(4)
    real(dp) :: s(4)
    integer :: j, k

    line = 0
    do k = 1, 4
      s = 0
      do j = 1, 4
        s = s + y%b(j, 0)*c(first:first + 3, y%i + j - 1, z%i + k - 1)
      end do
      line = line + z%b(k, 0)*s
    end do
  end subroutine spline_3d_line

  !> Compute the value, the gradient and, if `second`, the Hessian of sum c(i, j, k) X_i Y_j Z_k.
  pure subroutine spline_3d(c, x, y, z, second, v)
    real(dp), intent(in), contiguous :: c(:, :, :)
    type(basis_type), intent(in) :: x, y, z
    logical, intent(in) :: second
    real(dp), intent(inout) :: v(10)       !! f, fx, fy, fz, fxx, fxy, fxz, fyy, fyz, fzz; from the fifth if `second`
    real(dp) :: a(4, 6), w(4), p(4, 0:2)
    integer :: j, k, d

    if (.not. second) then
      call spline_3d_gradient(c, x, y, z, v(:4))
      return
    end if
    do k = 1, 4
      do j = 1, 4
        w = c(x%i:x%i + 3, y%i + j - 1, z%i + k - 1)
        do d = 0, 2
          p(j, d) = w(1)*x%b(1, d) + w(2)*x%b(2, d) + w(3)*x%b(3, d) + w(4)*x%b(4, d)
        end do
      end do
      a(k, 1) = dot_product(p(:, 0), y%b(:, 0))
      a(k, 2) = dot_product(p(:, 1), y%b(:, 0))
      a(k, 3) = dot_product(p(:, 0), y%b(:, 1))
      a(k, 4) = dot_product(p(:, 2), y%b(:, 0))
      a(k, 5) = dot_product(p(:, 1), y%b(:, 1))
      a(k, 6) = dot_product(p(:, 0), y%b(:, 2))
    end do
    v(1) = dot_product(a(:, 1), z%b(:, 0))
    v(2) = dot_product(a(:, 2), z%b(:, 0))
    v(3) = dot_product(a(:, 3), z%b(:, 0))
    v(4) = dot_product(a(:, 1), z%b(:, 1))
    v(5) = dot_product(a(:, 4), z%b(:, 0))
    v(6) = dot_product(a(:, 5), z%b(:, 0))
    v(7) = dot_product(a(:, 2), z%b(:, 1))
    v(8) = dot_product(a(:, 6), z%b(:, 0))
    v(9) = dot_product(a(:, 3), z%b(:, 1))
    v(10) = dot_product(a(:, 1), z%b(:, 2))
  end subroutine spline_3d

end module bspline