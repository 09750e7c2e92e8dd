!> Tensor-product cubic B-splines on graded axes: fit, value, gradient, Hessian.
!>
!> An axis maps x = centre + scale sinh(xi) onto equally spaced xi (fine near the
!> centre, coarse far away), or is uniform.  Interpolation at n points by n + 2
!> coefficients; at both ends the third derivative runs through the first
!> interior knot ("not a knot").  C. de Boor, A Practical Guide to Splines.
module bspline
  use kinds, only: dp
  implicit none
  private
  public :: axis_type, basis_type, graded_axis, uniform_axis, axis_point, axis_holds, axis_basis, &
    fit_axis, fit_2d, fit_3d, spline_2d_value, spline_2d, spline_3d

  type :: axis_type
    integer :: n = 0              !! points
    real(dp) :: centre = 0        !! where the axis is finest
    real(dp) :: scale = 0         !! sinh scale; 0: uniform, x = xi
    real(dp) :: first = 0         !! xi of the first point
    real(dp) :: step = 0          !! of xi
    real(dp) :: per_step = 0, per_scale = 0   !! 1/step, 1/scale: to multiply is faster than to divide
    real(dp) :: low = 0, high = 0 !! x of the first and the last point
  end type axis_type

  !> The four B-splines that live in one cell, with derivatives with respect to x.
  type :: basis_type
    integer :: i                  !! index of the first coefficient
    real(dp) :: b(4, 0:2)         !! value, first, second derivative
  end type basis_type

  interface
    subroutine dgbtrf(m, n, kl, ku, ab, ldab, ipiv, info)
      import :: dp
      integer, intent(in) :: m, n, kl, ku, ldab
      real(dp), intent(inout) :: ab(ldab, *)
      integer, intent(out) :: ipiv(*), info
    end subroutine dgbtrf
    subroutine dgbtrs(trans, n, kl, ku, nrhs, ab, ldab, ipiv, b, ldb, info)
      import :: dp
      character, intent(in) :: trans
      integer, intent(in) :: n, kl, ku, nrhs, ldab, ldb, ipiv(*)
      real(dp), intent(in) :: ab(ldab, *)
      real(dp), intent(inout) :: b(ldb, *)
      integer, intent(out) :: info
    end subroutine dgbtrs
  end interface

contains

  !> n points from first to last, spaced as scale*sinh about the centre.
  pure function graded_axis(first, last, centre, scale, n) result(axis)
    real(dp), intent(in) :: first, last, centre, scale
    integer, intent(in) :: n
    type(axis_type) :: axis

    axis%n = n
    axis%centre = centre
    axis%scale = scale
    axis%first = asinh((first - centre)/scale)
    axis%step = (asinh((last - centre)/scale) - axis%first)/(n - 1)
    axis%per_step = 1/axis%step
    axis%per_scale = 1/scale
    axis%low = first
    axis%high = last
  end function graded_axis

  pure function uniform_axis(first, last, n) result(axis)
    real(dp), intent(in) :: first, last
    integer, intent(in) :: n
    type(axis_type) :: axis

    axis%n = n
    axis%first = first
    axis%step = (last - first)/(n - 1)
    axis%per_step = 1/axis%step
    axis%low = first
    axis%high = last
  end function uniform_axis

  pure real(dp) function axis_point(axis, i) result(x)
    type(axis_type), intent(in) :: axis
    integer, intent(in) :: i

    x = axis%first + (i - 1)*axis%step
    if (axis%scale > 0) x = axis%centre + axis%scale*sinh(x)
  end function axis_point

  pure logical function axis_holds(axis, x)
    type(axis_type), intent(in) :: axis
    real(dp), intent(in) :: x

    axis_holds = x >= axis%low .and. x <= axis%high
  end function axis_holds

  !> B-splines at x, which must lie on the axis; without their second derivatives if `bend` is false.
  pure subroutine axis_basis(axis, x, basis, bend)
    type(axis_type), intent(in) :: axis
    real(dp), intent(in) :: x
    type(basis_type), intent(out) :: basis
    logical, intent(in), optional :: bend
    real(dp) :: t, d1, far, root, xi

    if (axis%scale > 0) then
      far = x - axis%centre
      root = sqrt(axis%scale**2 + far**2)
      xi = sign(log((abs(far) + root)*axis%per_scale), far)      ! asinh, at a third of its price
      d1 = axis%per_step/root
    else
      far = 0
      root = 1
      xi = x
      d1 = axis%per_step
    end if
    t = (xi - axis%first)*axis%per_step
    basis%i = max(1, min(int(t) + 1, axis%n - 1))
    t = t - (basis%i - 1)
    basis%b(:, 0) = [(1 - t)**3, 4 - 3*t**2*(2 - t), 4 - 3*(1 - t)**2*(1 + t), t**3]*(1/6.0_dp)
    basis%b(:, 1) = [-(1 - t)**2, t*(3*t - 4), (1 - t)*(1 + 3*t), t**2]*(0.5_dp*d1)
    if (present(bend)) then
      if (.not. bend) return
    end if
    basis%b(:, 2) = [1 - t, 3*t - 2, 1 - 3*t, t]*d1**2 - basis%b(:, 1)*(far/root**2)
  end subroutine axis_basis

  !> Coefficients along one axis: values f(n, m) at the points of the axis give
  !> c(n + 2, m).
  subroutine fit_axis(f, c)
    real(dp), intent(in) :: f(:, :)
    real(dp), intent(out) :: c(:, :)
    integer, parameter :: k = 4                     ! bandwidth of the end rows
    real(dp), parameter :: end_row(5) = [1, -4, 6, -4, 1]
    real(dp) :: ab(3*k + 1, size(f, 1) + 2)
    integer :: n, i, ipiv(size(f, 1) + 2), info

    n = size(f, 1) + 2
    ab = 0
    do i = 1, 5
      ab(2*k + 1 + 1 - i, i) = end_row(i)
      ab(2*k + 1 + 5 - i, n - 5 + i) = end_row(i)
    end do
    do i = 2, n - 1
      ab(2*k + 2, i - 1) = 1/6.0_dp
      ab(2*k + 1, i) = 4/6.0_dp
      ab(2*k, i + 1) = 1/6.0_dp
    end do
    c(1, :) = 0
    c(2:n - 1, :) = f
    c(n, :) = 0
    call dgbtrf(n, n, k, k, ab, 3*k + 1, ipiv, info)
    if (info == 0) call dgbtrs('N', n, k, k, size(f, 2), ab, 3*k + 1, ipiv, c, n, info)
  end subroutine fit_axis

  !> Coefficients c(n1 + 2, n2 + 2) of values f(n1, n2).
  subroutine fit_2d(f, c)
    real(dp), intent(in) :: f(:, :)
    real(dp), allocatable, intent(out) :: c(:, :)
    real(dp) :: a(size(f, 1) + 2, size(f, 2)), b(size(f, 2) + 2, size(f, 1) + 2)

    call fit_axis(f, a)
    call fit_axis(transpose(a), b)
    c = transpose(b)
  end subroutine fit_2d

  !> Coefficients c(n1 + 2, n2 + 2, n3 + 2) of values f(n1, n2, n3).
  subroutine fit_3d(f, c)
    real(dp), intent(in) :: f(:, :, :)
    real(dp), allocatable, intent(out) :: c(:, :, :)
    real(dp), allocatable :: a(:, :), b(:, :, :)
    integer :: n(3)

    n = shape(f)
    allocate (a(n(1) + 2, n(2)*n(3)))
    call fit_axis(reshape(f, [n(1), n(2)*n(3)]), a)
    b = reshape(a, [n(2), n(1) + 2, n(3)], order=[2, 1, 3])
    deallocate (a)
    allocate (a(n(2) + 2, (n(1) + 2)*n(3)))
    call fit_axis(reshape(b, [n(2), (n(1) + 2)*n(3)]), a)
    b = reshape(a, [n(3), n(2) + 2, n(1) + 2], order=[2, 3, 1])
    deallocate (a)
    allocate (a(n(3) + 2, (n(2) + 2)*(n(1) + 2)))
    call fit_axis(reshape(b, [n(3), (n(2) + 2)*(n(1) + 2)]), a)
    c = reshape(a, [n(1) + 2, n(2) + 2, n(3) + 2], order=[3, 2, 1])
  end subroutine fit_3d

  !> Value alone of sum c(i, j) X_i Y_j.
  pure real(dp) function spline_2d_value(c, x, y) result(v)
    real(dp), intent(in) :: c(:, :)
    type(basis_type), intent(in) :: x, y
    integer :: j

    v = 0
    do j = 1, 4
      v = v + y%b(j, 0)*dot_product(c(x%i:x%i + 3, y%i + j - 1), x%b(:, 0))
    end do
  end function spline_2d_value

  !> Value and gradient of sum c(i, j) X_i Y_j.
  pure subroutine spline_2d_gradient(c, x, y, v)
    real(dp), intent(in), contiguous :: c(:, :)
    type(basis_type), intent(in) :: x, y
    real(dp), intent(out) :: v(3)          !! f, fx, fy
    real(dp) :: t(4), ty(4)
    integer :: i, j

    t = 0
    ty = 0
    do j = 1, 4
      do i = 1, 4
        t(i) = t(i) + y%b(j, 0)*c(x%i + i - 1, y%i + j - 1)
        ty(i) = ty(i) + y%b(j, 1)*c(x%i + i - 1, y%i + j - 1)
      end do
    end do
    v = [dot_product(t, x%b(:, 0)), dot_product(t, x%b(:, 1)), dot_product(ty, x%b(:, 0))]
  end subroutine spline_2d_gradient

  !> Value, gradient (x, y) and, where `bend`, Hessian (xx, xy, yy) of sum c(i, j) X_i Y_j.
  pure subroutine spline_2d(c, x, y, bend, v)
    real(dp), intent(in), contiguous :: c(:, :)
    type(basis_type), intent(in) :: x, y
    logical, intent(in) :: bend
    real(dp), intent(inout) :: v(6)        !! f, fx, fy, fxx, fxy, fyy; the last three where `bend`
    real(dp) :: a(4, 0:2)
    integer :: j

    if (.not. bend) then
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

  !> Value and gradient of sum c(i, j, k) X_i Y_j Z_k.
  pure subroutine spline_3d_gradient(c, x, y, z, v)
    real(dp), intent(in), contiguous :: c(:, :, :)
    type(basis_type), intent(in) :: x, y, z
    real(dp), intent(out) :: v(4)          !! f, fx, fy, fz
    real(dp) :: b(4, 4, 4), s(4, 4), sy(4, 4), t(4), ty(4), tz(4)
    integer :: j, k

    do k = 1, 4
      do j = 1, 4
        b(:, k, j) = c(x%i:x%i + 3, y%i + j - 1, z%i + k - 1)
      end do
    end do
    s = y%b(1, 0)*b(:, :, 1) + y%b(2, 0)*b(:, :, 2) + y%b(3, 0)*b(:, :, 3) + y%b(4, 0)*b(:, :, 4)
    sy = y%b(1, 1)*b(:, :, 1) + y%b(2, 1)*b(:, :, 2) + y%b(3, 1)*b(:, :, 3) + y%b(4, 1)*b(:, :, 4)
    t = z%b(1, 0)*s(:, 1) + z%b(2, 0)*s(:, 2) + z%b(3, 0)*s(:, 3) + z%b(4, 0)*s(:, 4)
    ty = z%b(1, 0)*sy(:, 1) + z%b(2, 0)*sy(:, 2) + z%b(3, 0)*sy(:, 3) + z%b(4, 0)*sy(:, 4)
    tz = z%b(1, 1)*s(:, 1) + z%b(2, 1)*s(:, 2) + z%b(3, 1)*s(:, 3) + z%b(4, 1)*s(:, 4)
    v = [dot_product(t, x%b(:, 0)), dot_product(t, x%b(:, 1)), dot_product(ty, x%b(:, 0)), dot_product(tz, x%b(:, 0))]
  end subroutine spline_3d_gradient

  !> Value, gradient and, where `bend`, Hessian of sum c(i, j, k) X_i Y_j Z_k.
  pure subroutine spline_3d(c, x, y, z, bend, v)
    real(dp), intent(in), contiguous :: c(:, :, :)
    type(basis_type), intent(in) :: x, y, z
    logical, intent(in) :: bend
    real(dp), intent(inout) :: v(10)       !! f, fx, fy, fz, fxx, fxy, fxz, fyy, fyz, fzz; from the fifth where `bend`
    real(dp) :: a(4, 6), w(4), p(4, 0:2)
    integer :: j, k, d

    if (.not. bend) then
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
