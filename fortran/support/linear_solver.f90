!> A few linear equations.
module linear_solver
  use kinds, only: dp
  implicit none
  private
  public :: solve_linear

contains

  !> Replace x by the solution of a y = x, by Gaussian elimination with pivots; a is overwritten.  `ok` is false if a is
  !> singular.
  pure subroutine solve_linear(a, x, ok)
    real(dp), intent(inout) :: a(:, :), x(:)
    logical, intent(out) :: ok
    real(dp) :: row(size(x)), scale
    integer :: i, j, p

    ok = .true.
    scale = maxval(abs(a))
    do i = 1, size(x)
      p = i - 1 + maxloc(abs(a(i:, i)), 1)
      ok = abs(a(p, i)) > 1e-9_dp*scale
      if (.not. ok) return
      row = a(i, :)
      a(i, :) = a(p, :)
      a(p, :) = row
      x([i, p]) = x([p, i])
      do j = i + 1, size(x)
        x(j) = x(j) - a(j, i)/a(i, i)*x(i)
        a(j, i:) = a(j, i:) - a(j, i)/a(i, i)*a(i, i:)
      end do
    end do
    do i = size(x), 1, -1
      x(i) = (x(i) - dot_product(a(i, i + 1:), x(i + 1:)))/a(i, i)
    end do
  end subroutine solve_linear

end module linear_solver
