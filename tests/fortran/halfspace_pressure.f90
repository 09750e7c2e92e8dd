!> The half-space solver on its own.
!>
!> usage: halfspace_pressure < problems
!> Reads problems from standard input: a line `nx ns dx ds e_star`, then the undeformed
!> interpenetration [m] of the nx x ns elements, x fastest.  Writes a line `ok iterations`
!> and the pressures [Pa], in the same order, for each.
program halfspace_pressure
  use halfspace, only: mesh_type, new_system, set_influence, solve_pressure, system_type, unit_influence
  use kinds, only: dp
  implicit none
  save
  type(system_type) :: system
  real(dp), allocatable :: depth(:, :), p(:, :), r(:, :)
  real(dp) :: dx, ds, e_star, self
  integer :: nx, ns, stat, iterations
  logical :: ok

  do
    read (*, *, iostat=stat) nx, ns, dx, ds, e_star
    if (stat /= 0) exit
    allocate (depth(nx*ns, 1), p(nx*ns, 1), r(nx*ns, 1))
    read (*, *) depth
    system = new_system(nx, ns, 1)
    call unit_influence(nx, ns, ds/dx, system%own, self, system%inverse)
    call set_influence([mesh_type(dx, ds)], [self], e_star, system)
    p = 0
    call solve_pressure(system, depth, 1e-9_dp, p, r, ok, iterations)
    write (*, '(i0,1x,i0)') merge(1, 0, ok), iterations
    write (*, '(es24.16)') p
    deallocate (depth, p, r)
  end do
end program halfspace_pressure
