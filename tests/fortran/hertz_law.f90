!> Hertz's law for the benchmark's steel.
!>
!> usage: hertz_law < contacts
!> Reads lines `A B` (relative curvatures [1/m]); writes the ratio of minor to major semi-axis, C_H [N/m^1.5], strip modulus [Pa].
program hertz_law
  use case, only: case_type
  use hertz, only: contact_modulus, ellipse, hertz_stiffness, strip_modulus
  use kinds, only: dp
  implicit none
  save
  type(case_type) :: c
  real(dp) :: A, B, e_star, ratio, k, D
  integer :: stat

  e_star = contact_modulus(c%youngs_modulus, c%poisson)
  do
    read (*, *, iostat=stat) A, B
    if (stat /= 0) exit
    call ellipse(max(A, B)/min(A, B), ratio, k, D)
    write (*, '(3es24.16)') ratio, hertz_stiffness(e_star, A, B), strip_modulus(e_star, A, B)
  end do
end program hertz_law
