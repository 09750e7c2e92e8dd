!> Hertz's law for the benchmark's steel.
!>
!> usage: hertz_law < contacts
!> Reads lines `A B N` (relative curvatures [1/m], normal force [N]); writes approach,
!> semi-axes along A and B [m], largest pressure [Pa], C_H [N/m^1.5], strip modulus [Pa].
program hertz_law
  use case, only: case_type
  use hertz, only: contact_modulus, ellipse, hertz_stiffness, strip_modulus
  use kinds, only: dp, pi
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

contains

  !> Approach [m], semi-axes a, b [m] and largest pressure p0 [Pa] under a normal force N [N], for E* [Pa] and relative
  !> curvatures A, B > 0 [1/m].
  pure subroutine hertz_contact(e_star, A, B, N, approach, semi_a, semi_b, p0)
    real(dp), intent(in) :: e_star, A, B, N
    real(dp), intent(out) :: approach, semi_a, semi_b, p0
    real(dp) :: k, D, ratio, major

    call ellipse(max(A, B)/min(A, B), ratio, k, D)
    major = (1.5_dp*N*D/(pi*e_star*min(A, B)))**(1/3.0_dp)
    approach = 1.5_dp*N*k/(pi*e_star*major)
    p0 = 1.5_dp*N/(pi*ratio*major**2)
    semi_a = merge(major, ratio*major, A <= B)
    semi_b = merge(major, ratio*major, A > B)
  end subroutine hertz_contact

end program hertz_law
