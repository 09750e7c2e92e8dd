!> The solver of small linear systems on its own.
!>
!> usage: linear_solution < systems
!> Reads a line `n`, the matrix row by row and the right-hand side, as often as there are any. Writes for each system a line: 1 if it
!> has a solution, else 0, and x.
program linear_solution
  use kinds, only: dp
  use linear_solver, only: solve_linear
  implicit none
  real(dp), allocatable :: a(:, :), x(:)
  integer :: n, status
  logical :: ok

  do
    read (*, *, iostat=status) n
    if (status /= 0) exit
    allocate (a(n, n), x(n))
    read (*, *) a
    a = transpose(a)
    read (*, *) x
    call solve_linear(a, x, ok)
    print '(i0, *(es25.16))', merge(1, 0, ok), x
    deallocate (a, x)
  end do
end program linear_solution
