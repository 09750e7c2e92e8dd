!> Frictionless normal contact of elastic half-spaces on a grid of rectangles.
!>
!> Pressures p >= 0, constant on each element, press the surfaces apart by A p
!> (J. Boussinesq; closed form for a rectangle: A. E. H. Love, Phil. Trans. A 228
!> (1929) 377-420).  With D the undeformed interpenetration the solution is the
!> minimum of p.A p/2 - p.D over p >= 0: there A p = D under pressure and A p >= D
!> elsewhere (no tension, no interpenetration; J. J. Kalker, Three-Dimensional
!> Elastic Bodies in Rolling Contact, 1990, ch. 4).  The minimum is found by
!> conjugate gradients with an active set: I. A. Polonsky, L. M. Keer, Wear 231
!> (1999) 206-219; E. A. H. Vollebregt, J. Comput. Phys. 257 (2014) 333-351.
!>
!> The grid is symmetric about x = 0 (rolling direction); unknowns are those of
!> the half x > 0.
module halfspace
  use kinds, only: dp, pi
  implicit none
  private
  public :: set_influence, solve_pressure

contains

  !> Displacement [m] per pressure [Pa] of the elements (i, j), i = 1..nx over
  !> x = (i - 1/2) dx > 0, j = 1..ns over s, each with its mirror image at -x.
  !> Column-major numbering i + (j - 1) nx.
  subroutine set_influence(nx, ns, dx, ds, e_star, a)
    integer, intent(in) :: nx, ns
    real(dp), intent(in) :: dx, ds         !! [m]
    real(dp), intent(in) :: e_star         !! [Pa]
    real(dp), intent(out) :: a(nx*ns, nx*ns)
    real(dp) :: u(0:2*nx - 1, 0:ns - 1), corner(0:2*nx, 0:ns)
    integer :: i, j, k, l

    ! Primitive of 1/r at the corners (i - 1/2, j - 1/2) of the element at the origin's distance.
    do j = 0, ns
      do i = 0, 2*nx
        corner(i, j) = primitive((i - 0.5_dp)*dx, (j - 0.5_dp)*ds)
      end do
    end do
    do j = 0, ns - 1
      do i = 0, 2*nx - 1
        u(i, j) = (corner(i + 1, j + 1) - corner(i, j + 1) - corner(i + 1, j) + corner(i, j))/(pi*e_star)
      end do
    end do
    do l = 1, ns
      do k = 1, nx
        do j = 1, ns
          do i = 1, nx
            a(i + (j - 1)*nx, k + (l - 1)*nx) = u(abs(i - k), abs(j - l)) + u(i + k - 1, abs(j - l))
          end do
        end do
      end do
    end do
  end subroutine set_influence

  !> d2F/dxdy = 1/sqrt(x^2 + y^2).
  elemental real(dp) function primitive(x, y) result(f)
    real(dp), intent(in) :: x, y

    f = x*asinh(y/abs(x)) + y*asinh(x/abs(y))
  end function primitive

  !> Pressures [Pa] for interpenetrations `depth` [m].  `p` is the first guess on
  !> entry.  `ok` is false when the iteration does not reach the tolerance.  p.(depth + r)/2,
  !> minus the minimum, has the error of p squared.
  subroutine solve_pressure(a, depth, tolerance, p, r, ok, iterations)
    real(dp), intent(in) :: a(:, :)        !! of set_influence
    real(dp), intent(in) :: depth(:)
    real(dp), intent(in) :: tolerance      !! of the depth under pressure, relative to its maximum
    real(dp), intent(inout) :: p(:)
    real(dp), intent(out) :: r(:)          !! residual, depth - A p [m]
    logical, intent(out) :: ok
    integer, intent(out) :: iterations
    integer, parameter :: most = 1000
    real(dp), dimension(size(p)) :: t, q
    logical :: pressed(size(p))
    real(dp) :: g, g_old, tau, limit
    logical :: fresh

    limit = tolerance*maxval(depth)
    ok = limit <= 0
    iterations = 0
    if (ok) p = 0
    if (ok) r = depth
    if (ok) return
    if (all(p <= 0)) then
      ! Hertz: the surfaces touch where they would overlap by more than half.
      p = sqrt(max(2*depth - maxval(depth), 0.0_dp))
      call displace(a, p, q)
      p = p*dot_product(p, depth)/dot_product(p, q)
    end if
    p = max(p, 0.0_dp)
    t = 0
    g_old = 1
    fresh = .true.
    do iterations = 1, most
      ! While nothing is clipped, the residual follows from the step itself.
      if (fresh) then
        call displace(a, p, q)
        r = depth - q
      end if
      pressed = p > 0
      ok = all(merge(abs(r), r, pressed) <= limit)
      if (ok) exit
      g = sum(r**2, pressed)
      if (fresh) g_old = huge(g)
      where (pressed)
        t = r + g/g_old*t
      elsewhere
        t = 0
      end where
      g_old = g
      call displace(a, t, q)
      tau = sum(r*t, pressed)/dot_product(t, q)
      ! Where the surfaces overlap without pressure, pressure has to appear, and
      ! the directions start anew.
      fresh = any(.not. pressed .and. r > 0) .or. any(pressed .and. p + tau*t <= 0)
      where (pressed)
        p = max(p + tau*t, 0.0_dp)
      elsewhere (r > 0)
        p = tau*r
      end where
      if (.not. fresh) r = r - tau*q
    end do
  end subroutine solve_pressure

  !> q = A p, column by column: only elements under pressure count.
  pure subroutine displace(a, p, q)
    real(dp), intent(in) :: a(:, :), p(:)
    real(dp), intent(out) :: q(:)
    integer :: l

    q = 0
    do l = 1, size(p)
      if (abs(p(l)) > 0) q = q + p(l)*a(:, l)
    end do
  end subroutine displace

end module halfspace
