!> Tensor-product cubic B-splines on axes of any points: fit, value, gradient, Hessian.
!>
!> The knots are the points; beyond the ends the knots continue at the last spacing. A spline through n points has
!> n + 2 coefficients: at both ends the third derivative does not jump at the first interior knot ("not a knot").
!> Four B-splines are not zero in a cell; they are kept as polynomials. C. de Boor, A Practical Guide to Splines.
module bspline
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use kinds, only: dp
  implicit none
  private
  public :: axis_type, basis_type, new_axis, graded_points, axis_holds, axis_basis, &
    fit_axis, fit_2d, fit_3d, third_jumps, spline_2d_value, spline_2d, spline_3d, spline_3d_line, &
    spline_2d_at, spline_3d_at

  type :: axis_type
    integer :: n = 0              !! points
    real(dp), allocatable :: x(:) !! ascending
    real(dp) :: low = 0, high = 0 !! the first and the last point
    real(dp), allocatable :: cell(:, :, :)   !! (B-spline, power of x - x(i), cell i)
    integer, allocatable :: bin(:)           !! last cell that begins before the end of each of equal bins
    real(dp) :: bins_per_length = 0       !! bins per unit length
  end type axis_type

  !> The four B-splines that are not zero in one cell, with derivatives with respect to x.
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
  end function new_axis

  !> Return n points from first to last, spaced as scale*sinh of even steps: finest at 0.
  pure function graded_points(first, last, scale, n) result(x)
    real(dp), intent(in) :: first, last, scale
    integer, intent(in) :: n
    real(dp) :: x(n), low, high
    integer :: i

    low = asinh(first/scale)
    high = asinh(last/scale)
    x = [first, (scale*sinh(low + (i - 1)*(high - low)/(n - 1)), i=2, n - 1), last]
  end function graded_points

  !> Whether x lies between the ends of an axis; false for NaN.
  pure logical function axis_holds(axis, x)
    type(axis_type), intent(in) :: axis
    real(dp), intent(in) :: x

    axis_holds = x >= axis%low .and. x <= axis%high
  end function axis_holds

  !> Compute the B-splines at x, which must lie on the axis, without their second derivatives if `second` is false.
  pure subroutine axis_basis(axis, x, basis, second)
    type(axis_type), intent(in) :: axis
    real(dp), intent(in) :: x
    type(basis_type), intent(out) :: basis
    logical, intent(in), optional :: second
    real(dp) :: t
    integer :: i

    i = axis%bin(int((x - axis%low)*axis%bins_per_length) + 1)
    do while (i < axis%n - 1)
      if (x < axis%x(i + 1)) exit
      i = i + 1
    end do
    basis%i = i
    t = x - axis%x(i)
    associate (c => axis%cell(:, :, i))
      basis%b(:, 0) = c(:, 1) + t*(c(:, 2) + t*(c(:, 3) + t*c(:, 4)))
      basis%b(:, 1) = c(:, 2) + t*(2*c(:, 3) + t*(3*c(:, 4)))
      if (present(second)) then
        if (.not. second) return
      end if
      basis%b(:, 2) = 2*c(:, 3) + t*(6*c(:, 4))
    end associate
  end subroutine axis_basis

  !> Compute the B-splines at many points, without their second derivatives.
  pure subroutine axis_bases(axis, x, basis)
    type(axis_type), intent(in) :: axis
    real(dp), intent(in) :: x(:)
    type(basis_type), intent(out) :: basis(:)
    integer :: i

    do i = 1, size(x)
      call axis_basis(axis, x(i), basis(i), second=.false.)
    end do
  end subroutine axis_bases

  !> Compute the coefficients c(n + 2, m) of the m splines through values f(n, m) at the points of an axis. They are NaN if
  !> the system is singular.
  subroutine fit_axis(axis, f, c)
    type(axis_type), intent(in) :: axis
    real(dp), intent(in) :: f(:, :)
    real(dp), intent(out) :: c(:, :)
    integer, parameter :: k = 4                     ! bandwidth of the end rows
    real(dp) :: ab(3*k + 1, size(f, 1) + 2), row(5)
    integer :: n, i, j, ipiv(size(f, 1) + 2), info

    n = size(f, 1) + 2
    ab = 0
    row = jump_row(axis, 2)*(axis%x(3) - axis%x(1))**3
    do j = 1, 5
      ab(2*k + 1 + 1 - j, j) = row(j)
    end do
    row = jump_row(axis, axis%n - 1)*(axis%x(axis%n) - axis%x(axis%n - 2))**3
    do j = n - 4, n
      ab(2*k + 1 + n - j, j) = row(j - n + 5)
    end do
    do i = 2, n - 1
      ! The fourth B-spline of a cell begins with it, the first of the cell before ends there.
      if (i < n - 1) row(:3) = axis%cell(:3, 0, i - 1)
      if (i == n - 1) row(:3) = at_end(axis)
      do j = i - 1, i + 1
        ab(2*k + 1 + i - j, j) = row(j - i + 2)
      end do
    end do
    c(1, :) = 0
    c(2:n - 1, :) = f
    c(n, :) = 0
    call dgbtrf(n, n, k, k, ab, 3*k + 1, ipiv, info)
    if (info == 0) call dgbtrs('N', n, k, k, size(f, 2), ab, 3*k + 1, ipiv, c, n, info)
    ! With NaN no pose is inside the table.
    if (info /= 0) c = ieee_value(1.0_dp, ieee_quiet_nan)
  end subroutine fit_axis

  !> Return the three B-splines that do not vanish at the last point.
  pure function at_end(axis) result(b)
    type(axis_type), intent(in) :: axis
    real(dp) :: b(3)
    type(basis_type) :: basis

    call axis_basis(axis, axis%high, basis, second=.false.)
    b = basis%b(2:, 0)
  end function at_end

  !> Return the row that gives the jump of the third derivative at an interior point i from the coefficients i - 1..i + 3.
  pure function jump_row(axis, i) result(row)
    type(axis_type), intent(in) :: axis
    integer, intent(in) :: i
    real(dp) :: row(5)

    row = 6*([0.0_dp, axis%cell(:, 3, i)] - [axis%cell(:, 3, i - 1), 0.0_dp])
  end function jump_row

  !> Compute the jumps of the third derivative at the points of an axis, for splines through values f(n, m).
  subroutine third_jumps(axis, f, jump)
    type(axis_type), intent(in) :: axis
    real(dp), intent(in) :: f(:, :)
    real(dp), intent(out) :: jump(:, :)    !! shape of f; 0 at both ends
    real(dp) :: c(size(f, 1) + 2, size(f, 2)), row(5)
    integer :: i, j

    call fit_axis(axis, f, c)
    jump = 0
    do i = 2, axis%n - 1
      row = jump_row(axis, i)
      do j = 1, size(f, 2)
        jump(i, j) = dot_product(row, c(i - 1:i + 3, j))
      end do
    end do
  end subroutine third_jumps

  !> Compute the coefficients c(n1 + 2, n2 + 2) of the spline through values f(n1, n2).
  subroutine fit_2d(x, y, f, c)
    type(axis_type), intent(in) :: x, y
    real(dp), intent(in) :: f(:, :)
    real(dp), allocatable, intent(out) :: c(:, :)
    real(dp) :: a(size(f, 1) + 2, size(f, 2)), b(size(f, 2) + 2, size(f, 1) + 2)

    call fit_axis(x, f, a)
    call fit_axis(y, transpose(a), b)
    c = transpose(b)
  end subroutine fit_2d

  !> Compute the coefficients c(n1 + 2, n2 + 2, n3 + 2) of the spline through values f(n1, n2, n3).
  subroutine fit_3d(x, y, z, f, c)
    type(axis_type), intent(in) :: x, y, z
    real(dp), intent(in) :: f(:, :, :)
    real(dp), allocatable, intent(out) :: c(:, :, :)
    real(dp), allocatable :: a(:, :), b(:, :, :)
    integer :: n(3)

    n = shape(f)
    allocate (a(n(1) + 2, n(2)*n(3)))
    call fit_axis(x, reshape(f, [n(1), n(2)*n(3)]), a)
    b = reshape(a, [n(2), n(1) + 2, n(3)], order=[2, 1, 3])
    deallocate (a)
    allocate (a(n(2) + 2, (n(1) + 2)*n(3)))
    call fit_axis(y, reshape(b, [n(2), (n(1) + 2)*n(3)]), a)
    b = reshape(a, [n(3), n(2) + 2, n(1) + 2], order=[2, 3, 1])
    deallocate (a)
    allocate (a(n(3) + 2, (n(2) + 2)*(n(1) + 2)))
    call fit_axis(z, reshape(b, [n(3), (n(2) + 2)*(n(1) + 2)]), a)
    c = reshape(a, [n(1) + 2, n(2) + 2, n(3) + 2], order=[3, 2, 1])
  end subroutine fit_3d

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

  !> Evaluate the spline with coefficients c on the axes x, y at all points (u(i), v(j)): f(i, j).
  pure subroutine spline_2d_at(x, y, c, u, v, f)
    type(axis_type), intent(in) :: x, y
    real(dp), intent(in) :: c(:, :), u(:), v(:)
    real(dp), intent(out) :: f(:, :)
    type(basis_type) :: bx(size(u)), by(size(v))
    integer :: i, j

    call axis_bases(x, u, bx)
    call axis_bases(y, v, by)
    do j = 1, size(v)
      do i = 1, size(u)
        f(i, j) = spline_2d_value(c, bx(i), by(j))
      end do
    end do
  end subroutine spline_2d_at

  !> Evaluate the spline with coefficients c on the axes x, y, z at all points (u(i), v(j), w(k)): f(i, j, k). It sums over one
  !> axis after the other.
  pure subroutine spline_3d_at(x, y, z, c, u, v, w, f)
    type(axis_type), intent(in) :: x, y, z
    real(dp), intent(in) :: c(:, :, :), u(:), v(:), w(:)
    real(dp), intent(out) :: f(:, :, :)
    real(dp) :: plane(size(c, 1), size(c, 2)), line(size(c, 1))
    type(basis_type) :: bx(size(u)), by(size(v)), bz(size(w))
    integer :: i, j, k, l

    call axis_bases(x, u, bx)
    call axis_bases(y, v, by)
    call axis_bases(z, w, bz)
    do k = 1, size(w)
      plane = 0
      do l = 1, 4
        plane = plane + bz(k)%b(l, 0)*c(:, :, bz(k)%i + l - 1)
      end do
      do j = 1, size(v)
        line = 0
        do l = 1, 4
          line = line + by(j)%b(l, 0)*plane(:, by(j)%i + l - 1)
        end do
        do i = 1, size(u)
          f(i, j, k) = dot_product(bx(i)%b(:, 0), line(bx(i)%i:bx(i)%i + 3))
        end do
      end do
    end do
  end subroutine spline_3d_at

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