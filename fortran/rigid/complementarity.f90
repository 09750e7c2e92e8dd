!> Small dense systems: linear equations, and linear complementarity problems with at most three positive unknowns.
module complementarity
  use kinds, only: dp
  implicit none
  private
  public :: solve_complementarity, solve_linear

contains

  !> Find x >= 0 with a x + b >= 0 where every component of one of them is zero.  The matrix a is symmetric and has no
  !> negative eigenvalue.  Every choice of at most three positive unknowns is tried, the smallest choices first.
  !> `ok` is false if none solves the problem.
  pure subroutine solve_complementarity(a, b, x, ok)
    real(dp), intent(in) :: a(:, :), b(:)
    real(dp), intent(out) :: x(size(b))
    logical, intent(out) :: ok
    integer :: chosen, choice, i

    do chosen = 0, min(3, size(b))
      do choice = 0, 2**size(b) - 1
        if (popcnt(choice) /= chosen) cycle
        call try_choice(pack([(i, i=1, size(b))], [(btest(choice, i - 1), i=1, size(b))]), a, b, x, ok)
        if (ok) return
      end do
    end do
  end subroutine solve_complementarity

  !> Solve the complementarity problem for a given choice of unknowns that may be positive.
  pure subroutine try_choice(choice, a, b, x, ok)
    integer, intent(in) :: choice(:)
    real(dp), intent(in) :: a(:, :), b(:)
    real(dp), intent(out) :: x(size(b))
    logical, intent(out) :: ok
    real(dp), parameter :: slack = 1e-11_dp    ! rounding allowed in a x + b, relative to b
    real(dp) :: part(size(choice), size(choice)), y(size(choice)), w(size(b))

    x = 0
    part = a(choice, choice)
    y = -b(choice)
    call solve_linear(part, y, ok)
    if (.not. ok) return
    w = b + matmul(a(:, choice), y)
    w(choice) = 0
    ok = all(y >= 0) .and. all(w >= -slack*maxval(abs(b)))
    if (ok) x(choice) = y
  end subroutine try_choice

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

end module complementarity
