!> The half-space solver on its own.
!>
!> usage: halfspace_pressure < problems
!> Reads problems from standard input: a line `nx ns dx ds e_star`, then the undeformed
!> interpenetration [m] of the nx x ns elements, x fastest.  Writes a line `ok iterations`
!> and the pressures [Pa], in the same order, for each.
program halfspace_pressure
  use halfspace, only: mesh_type, set_influence, solve_loads
  use kinds, only: dp
  implicit none
  save
  real(dp), allocatable :: depth(:), f(:), r(:), influence(:, :), flat(:, :)
  real(dp) :: dx, ds, e_star
  integer :: nx, ns, stat, iterations
  logical :: ok

  do
    read (*, *, iostat=stat) nx, ns, dx, ds, e_star
    if (stat /= 0) exit
    allocate (depth(nx*ns), f(nx*ns), r(nx*ns), influence(nx*ns, nx*ns), flat(ns, 1))
    read (*, *) depth
    flat = 0
    call set_influence(nx, ns, [mesh_type(dx, ds)], flat, e_star, influence)
    f = 0
    call solve_loads(influence, depth, 1e-9_dp, f, r, ok, iterations)
    write (*, '(i0,1x,i0)') merge(1, 0, ok), iterations
    write (*, '(es24.16)') f/(dx*ds)
    deallocate (depth, f, r, influence, flat)
  end do
end program halfspace_pressure
