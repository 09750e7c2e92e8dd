!> Linear complementarity problems with at most three positive unknowns.
module complementarity
  use kinds, only: dp
  use linear_solver, only: solve_linear
  implicit none
  private
  public :: solve_complementarity

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

end module complementarity
