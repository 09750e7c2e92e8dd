!> The half-space solver on its own.
!>
!> usage: halfspace_pressure < problems
!> Reads problems from standard input: a line `nx ns dx ds e_star`, then the undeformed
!> interpenetration [m] of the nx x ns elements, x fastest.  Writes a line `ok iterations`
!> and the pressures [Pa], in the same order, for each.
program halfspace_pressure
  use halfspace, only: set_influence, solve_pressure
  use kinds, only: dp
  implicit none
  real(dp), allocatable :: a(:, :), depth(:), p(:), r(:)
  real(dp) :: dx, ds, e_star
  integer :: nx, ns, stat, iterations
  logical :: ok

  do
    read (*, *, iostat=stat) nx, ns, dx, ds, e_star
    if (stat /= 0) exit
    allocate (a(nx*ns, nx*ns), depth(nx*ns), p(nx*ns), r(nx*ns))
    read (*, *) depth
    call set_influence(nx, ns, dx, ds, e_star, a)
    p = 0
    call solve_pressure(a, depth, 1e-9_dp, p, r, ok, iterations)
    write (*, '(i0,1x,i0)') merge(1, 0, ok), iterations
    write (*, '(es24.16)') p
    deallocate (a, depth, p, r)
  end do
end program halfspace_pressure
