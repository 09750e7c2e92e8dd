!> The half-space solver on its own.
!>
!> usage: halfspace_pressure < problem
!> Reads a line `nx ns dx ds e_star`, then the undeformed interpenetration [m] of the nx x ns elements, x fastest. Writes 1 if the
!> solution reached its tolerance, else 0, and the pressures [Pa] in the same order.
program halfspace_pressure
  use halfspace, only: mesh_type, set_influence, solve_loads
  use kinds, only: dp
  implicit none
  save
  real(dp), allocatable :: depth(:), f(:), r(:), influence(:, :), flat(:, :)
  real(dp) :: dx, ds, e_star
  integer :: nx, ns, iterations
  logical :: ok

  read (*, *) nx, ns, dx, ds, e_star
  allocate (depth(nx*ns), f(nx*ns), r(nx*ns), influence(nx*ns, nx*ns), flat(ns, 1))
  read (*, *) depth
  flat = 0
  f = 0
  call set_influence(nx, ns, [mesh_type(dx, ds)], flat, e_star, influence)
  call solve_loads(influence, depth, 1e-9_dp, f, r, ok, iterations)
  write (*, '(i0)') merge(1, 0, ok)
  write (*, '(es24.16)') f/(dx*ds)
end program halfspace_pressure
