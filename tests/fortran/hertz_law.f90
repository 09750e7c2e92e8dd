!> Hertz's law for the benchmark's steel.
!>
!> usage: hertz_law < contacts
!> Reads lines `A B N` (relative curvatures [1/m], normal force [N]); writes approach,
!> semi-axes along A and B [m], largest pressure [Pa], C_H [N/m^1.5], strip modulus [Pa].
program hertz_law
  use case, only: case_type
  use hertz, only: contact_modulus, hertz_contact, hertz_stiffness, strip_modulus
  use kinds, only: dp
  implicit none
  save
  type(case_type) :: c
  real(dp) :: curvature(2), force, e_star, approach, semi(2), p0
  integer :: stat

  e_star = contact_modulus(c%youngs_modulus, c%poisson)
  do
    read (*, *, iostat=stat) curvature, force
    if (stat /= 0) exit
    call hertz_contact(e_star, curvature(1), curvature(2), force, approach, semi(1), semi(2), p0)
    write (*, '(6es24.16)') approach, semi, p0, hertz_stiffness(e_star, curvature(1), curvature(2)), &
      strip_modulus(e_star, curvature(1), curvature(2))
  end do
end program hertz_law
