!> Hertz's law for two elastic bodies that touch at a point.
!>
!> K. L. Johnson, Contact Mechanics (Cambridge 1985), section 4.2.  The gap of the undeformed bodies is A x^2 + B y^2.
!> The contact ellipse has semi-axes a (along x) and b (along y).  For two bodies of the same material
!> 1/E* = 2 (1 - nu^2)/E.
module hertz
  use kinds, only: dp, pi
  implicit none
  private
  public :: ellipse, hertz_stiffness, strip_modulus, contact_modulus

contains

  !> E* [Pa] of two bodies of the same material.
  elemental real(dp) function contact_modulus(youngs_modulus, poisson) result(e_star)
    real(dp), intent(in) :: youngs_modulus   !! [Pa]
    real(dp), intent(in) :: poisson

    e_star = youngs_modulus/(2*(1 - poisson**2))
  end function contact_modulus

  !> C_H [N/m^1.5] in N = C_H delta^(3/2), for E* [Pa] and relative curvatures A, B > 0 [1/m].
  elemental real(dp) function hertz_stiffness(e_star, A, B) result(c_h)
    real(dp), intent(in) :: e_star, A, B
    real(dp) :: k, D, ratio

    call ellipse(max(A, B)/min(A, B), ratio, k, D)
    c_h = pi*e_star/1.5_dp*sqrt(D/min(A, B)/k**3)
  end function hertz_stiffness

  !> The modulus k [Pa] with which a row of independent strips carries Hertz's force, where a strip of depth g(y) carries
  !> k g(y) per unit width: k = 3/4 C_H sqrt(B).
  elemental real(dp) function strip_modulus(e_star, A, B) result(k)
    real(dp), intent(in) :: e_star, A, B

    k = 0.75_dp*hertz_stiffness(e_star, A, B)*sqrt(B)
  end function strip_modulus

  !> Axis ratio (minor/major, <= 1) of the contact ellipse for a ratio `curvatures` >= 1 of the relative curvatures, and
  !> the complete elliptic integrals K(e) and D = (K - E)/e^2 of the ellipse's eccentricity e.
  elemental subroutine ellipse(curvatures, ratio, k, D)
    real(dp), intent(in) :: curvatures
    real(dp), intent(out) :: ratio, k, D
    real(dp) :: x, x_old, f, f_old, slope
    integer :: iter

    ! Secant iteration for log(ratio) on log((K - D)/(ratio^2 D)) = log(curvatures),
    ! started from the fit of D. E. Brewe, B. J. Hamrock, J. Lubr. Technol. 99 (1977) 485-487.
    x_old = 0
    f_old = -log(curvatures)
    x = min(-0.636_dp*log(curvatures), -1e-3_dp)
    do iter = 1, 40
      ratio = exp(x)
      call integrals(ratio, k, D)
      f = log((k - D)/(ratio**2*D)) - log(curvatures)
      slope = (f - f_old)/(x - x_old)
      if (abs(f) <= 4*epsilon(x)*max(1.0_dp, log(curvatures)) .or. abs(slope) <= 0) exit
      x_old = x
      f_old = f
      x = min(x - f/slope, 0.0_dp)
      if (abs(x - x_old) <= 2*epsilon(x)) exit
    end do
  end subroutine ellipse

  !> K(e) and D = (K(e) - E(e))/e^2 for e^2 = 1 - ratio^2 by the arithmetic-geometric mean (Abramowitz and Stegun 17.6).
  elemental subroutine integrals(ratio, k, D)
    real(dp), intent(in) :: ratio
    real(dp), intent(out) :: k, D
    real(dp) :: a, g, a_next, e2, c2, total, power
    integer :: iter

    e2 = (1 - ratio)*(1 + ratio)
    a = 1
    g = ratio
    total = 0.5_dp        ! sum of 2^(n-1) c_n^2/e^2, c_0 = e
    c2 = e2
    power = 0.5_dp
    do iter = 1, 12
      ! c_{n+1}^2 = ((a - g)/2)^2, written so that the division by e^2 is safe
      ! for a circle: a_n^2 - g_n^2 = c_n^2.
      c2 = (c2/(2*(a + g)))**2
      power = 2*power
      if (e2 > 0) total = total + power*c2/e2
      a_next = (a + g)/2
      g = sqrt(a*g)
      a = a_next
      if (c2 <= 1e-34_dp) exit
    end do
    k = pi/(2*a)
    D = k*total
  end subroutine integrals

end module hertz
