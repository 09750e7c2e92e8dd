!> Frictionless normal contact of elastic half-spaces on grids of rectangles.
!>
!> Pressures p >= 0, constant on each element, press the surfaces apart by A p (J. Boussinesq; closed form for a
!> rectangle: A. E. H. Love, Phil. Trans. A 228 (1929) 377-420).  With D the undeformed interpenetration the solution is
!> the minimum of p.A p/2 - p.D over p >= 0.  There A p = D under pressure and A p >= D elsewhere: no tension, no
!> interpenetration (J. J. Kalker, Three-Dimensional Elastic Bodies in Rolling Contact, 1990, ch. 4).  Conjugate
!> gradients with an active set find the minimum: I. A. Polonsky, L. M. Keer, Wear 231 (1999) 206-219;
!> E. A. H. Vollebregt, J. Comput. Phys. 257 (2014) 333-351.
!>
!> Every patch has a grid of its own, symmetric about x = 0 (rolling direction); the unknowns are the pressures of the
!> half x > 0.  All elements of a grid are alike, so the influence of a row of elements on the others is always the same
!> vector, shifted: A is never formed.  Patches act on each other as rows of point loads.
module halfspace
  use kinds, only: dp, pi
  implicit none
  private
  public :: mesh_type, system_type, new_system, unit_influence, set_influence, solve_pressure

  !> A grid.  Elements (i, j) are centred at x = (i - 1/2) dx > 0 and s = low + (j - 1/2) ds.
  type :: mesh_type
    real(dp) :: dx = 0, ds = 0, low = 0    !! [m]
  end type mesh_type

  !> The influence A of several grids of nx by ns elements.  A is symmetric in units of the displacement of an element
  !> under its own pressure, for pressures weighted with sqrt(area times that displacement).
  type :: system_type
    integer :: nx = 0, ns = 0, n = 0       !! elements over x and s; number of grids
    real(dp), allocatable :: own(:, :, :)         !! influence in a grid, of unit_influence, (nx*(2*ns - 1), nx, grid)
    real(dp), allocatable :: inverse(:, :, :)     !! inverse among neighbours, of unit_influence, (0:1, 0:1, grid)
    real(dp), allocatable :: cross(:, :, :, :)    !! influence on a grid of another, (nx*ns, nx*ns, grid, other grid)
    real(dp), allocatable :: weight(:)            !! sqrt(area/displacement under unit pressure) [sqrt(m Pa)]
    real(dp), allocatable :: compliance(:)        !! displacement of an element under its own unit pressure [m/Pa]
  end type system_type

contains

  !> A system with room for `most` grids of nx by ns elements.
  pure function new_system(nx, ns, most) result(system)
    integer, intent(in) :: nx, ns, most
    type(system_type) :: system

    system%nx = nx
    system%ns = ns
    allocate (system%own(nx*(2*ns - 1), nx, most), system%inverse(0:1, 0:1, most))
    allocate (system%weight(most), system%compliance(most))
  end function new_system

  !> Displacement per pressure of elements with dx = 1, ds = `ratio` and E* = 1.  `self` is the displacement of an
  !> element under its own unit pressure.  v holds displacements relative to `self`: v(i, j - l, k) is the influence of
  !> element (k, l), together with its mirror image at -x, on element (i, j).  `inverse` holds the pressures that displace
  !> an element by `self` and none of its eight neighbours: of the element and of its neighbours along x, s and both.
  pure subroutine unit_influence(nx, ns, ratio, v, self, inverse)
    integer, intent(in) :: nx, ns          !! at least 2 and 3
    real(dp), intent(in) :: ratio
    real(dp), intent(out) :: v(nx, -(ns - 1):ns - 1, nx), self, inverse(0:1, 0:1)
    real(dp) :: u(0:2*nx - 1, 0:ns - 1), corner(0:2*nx, 0:ns)
    integer :: i, j, k

    ! Primitive of 1/r at the corners (i - 1/2, j - 1/2) of elements around the origin.
    do j = 0, ns
      do i = 0, 2*nx
        corner(i, j) = primitive(i - 0.5_dp, (j - 0.5_dp)*ratio)
      end do
    end do
    do j = 0, ns - 1
      do i = 0, 2*nx - 1
        u(i, j) = (corner(i + 1, j + 1) - corner(i, j + 1) - corner(i + 1, j) + corner(i, j))/pi
      end do
    end do
    self = u(0, 0)
    u = u/self
    do k = 1, nx
      do j = -(ns - 1), ns - 1
        do i = 1, nx
          v(i, j, k) = u(abs(i - k), abs(j)) + u(i + k - 1, abs(j))
        end do
      end do
    end do
    inverse = inverse_of_neighbours(u(:2, :2))
  end subroutine unit_influence

  !> Pressures on three by three elements that displace the middle one by 1 and the others by 0.  They are symmetric.
  pure function inverse_of_neighbours(u) result(inverse)
    real(dp), intent(in) :: u(0:2, 0:2)    !! displacement of an element at a distance, (x, s)
    real(dp) :: inverse(0:1, 0:1)
    real(dp) :: a(4, 5)                    ! displacements by pressures (0, 0), (1, 0), (0, 1), (1, 1); those wanted
    integer :: row, column, i, j, k, l

    a = 0
    a(1, 5) = 1
    do l = -1, 1
      do k = -1, 1
        column = 1 + abs(k) + 2*abs(l)
        do j = 0, 1
          do i = 0, 1
            row = 1 + i + 2*j
            a(row, column) = a(row, column) + u(abs(i - k), abs(j - l))
          end do
        end do
      end do
    end do
    ! Gauss-Jordan elimination; the diagonal is larger than the rest.
    do k = 1, 4
      a(k, :) = a(k, :)/a(k, k)
      do i = 1, 4
        if (i /= k) a(i, :) = a(i, :) - a(i, k)*a(k, :)
      end do
    end do
    inverse = reshape(a(:, 5), [2, 2])
  end function inverse_of_neighbours

  !> F(x, y) with d2F/dxdy = 1/sqrt(x^2 + y^2).
  elemental real(dp) function primitive(x, y) result(f)
    real(dp), intent(in) :: x, y

    f = x*asinh(y/abs(x)) + y*asinh(x/abs(y))
  end function primitive

  !> Set the system for the grids `mesh`.  Its `own` influence is already set.
  pure subroutine set_influence(mesh, self, e_star, system)
    type(mesh_type), intent(in) :: mesh(:)
    real(dp), intent(in) :: self(:)        !! from `unit_influence`
    real(dp), intent(in) :: e_star         !! [Pa]
    type(system_type), intent(inout) :: system
    real(dp) :: x(system%nx), distance, scale
    integer :: g, h, i, j, k, l

    system%n = size(mesh)
    do g = 1, system%n
      system%compliance(g) = self(g)*mesh(g)%dx/e_star
      system%weight(g) = sqrt(mesh(g)%dx*mesh(g)%ds/system%compliance(g))
    end do
    if (system%n > 1 .and. .not. allocated(system%cross)) allocate (system%cross(system%nx*system%ns, &
      system%nx*system%ns, size(system%weight), size(system%weight)))
    do h = 2, system%n
      do g = 1, h - 1
        scale = system%weight(g)*system%weight(h)/(pi*e_star)
        x = [(i - 0.5_dp, i=1, system%nx)]*mesh(g)%dx
        do l = 1, system%ns
          do k = 1, system%nx
            associate (column => system%cross(:, k + (l - 1)*system%nx, g, h), x_load => (k - 0.5_dp)*mesh(h)%dx)
              do j = 1, system%ns
                distance = mesh(h)%low + (l - 0.5_dp)*mesh(h)%ds - mesh(g)%low - (j - 0.5_dp)*mesh(g)%ds
                column((j - 1)*system%nx + 1:j*system%nx) = scale*(1/sqrt((x - x_load)**2 + distance**2) &
                  + 1/sqrt((x + x_load)**2 + distance**2))
              end do
            end associate
          end do
        end do
        system%cross(:, :, h, g) = transpose(system%cross(:, :, g, h))
      end do
    end do
  end subroutine set_influence

  !> Pressures p [Pa] for interpenetrations `depth` [m], both (nx*ns, grid).  On entry p is a first guess.  `ok` is false
  !> where the iteration does not reach the tolerance.  The energy p.(depth + r)/2 has the square of the error of p.
  pure subroutine solve_pressure(system, depth, tolerance, p, r, ok, iterations)
    type(system_type), intent(in) :: system
    real(dp), intent(in) :: depth(system%nx*system%ns, system%n)
    real(dp), intent(in) :: tolerance      !! error of the depth under pressure, relative to its maximum
    real(dp), intent(inout) :: p(system%nx*system%ns, system%n)
    real(dp), intent(out) :: r(system%nx*system%ns, system%n)   !! residual, depth - A p [m]
    logical, intent(out) :: ok
    integer, intent(out) :: iterations
    integer, parameter :: most = 1000
    real(dp), dimension(size(p, 1), size(p, 2)) :: d, t, q, z, correction
    real(dp) :: limit(size(p, 2)), g, g_old, share, tau, next
    logical :: fresh, guessed
    integer :: i, k

    iterations = 0
    ok = maxval(depth) <= 0
    if (ok) p = 0
    if (ok) r = depth
    if (ok) return
    do k = 1, system%n
      d(:, k) = depth(:, k)*system%weight(k)
      limit(k) = tolerance*maxval(depth)*system%weight(k)
    end do
    ! Without a guess: as in Hertz's theory, the surfaces touch where they would overlap by more than half the maximum.
    if (all(p <= 0)) p = sqrt(max(2*depth - maxval(depth), 0.0_dp))
    do k = 1, system%n
      p(:, k) = max(p(:, k), 0.0_dp)*(system%weight(k)*system%compliance(k))
    end do
    t = 0
    g_old = 1
    guessed = .true.
    do iterations = 1, most
      if (guessed) then
        call displace(system, p, q)
        tau = sum(p*d)/sum(p*q)
        p = p*tau
        r = d - q*tau
        fresh = .true.
      end if
      ok = .true.
      do k = 1, system%n
        do i = 1, size(p, 1)
          if (p(i, k) > 0) then
            ok = ok .and. abs(r(i, k)) <= limit(k)
          else
            ok = ok .and. r(i, k) <= limit(k)
          end if
        end do
      end do
      if (ok) exit
      call precondition(system, p, r, z)
      g = sum(r*z)
      ! All pressures may have been clipped to zero.
      guessed = g <= 0
      if (guessed) then
        p = max(r, 0.0_dp)
        cycle
      end if
      share = merge(0.0_dp, g/g_old, fresh)
      do k = 1, system%n
        do i = 1, size(p, 1)
          t(i, k) = merge(z(i, k) + share*t(i, k), 0.0_dp, p(i, k) > 0)
        end do
      end do
      g_old = g
      call displace(system, t, q)
      tau = sum(r*t)/sum(t*q)
      ! Where the surfaces overlap without pressure, pressure must appear, and the search directions start anew.
      correction = 0
      do k = 1, system%n
        do i = 1, size(p, 1)
          if (p(i, k) > 0) then
            next = p(i, k) + tau*t(i, k)
            p(i, k) = max(next, 0.0_dp)
            correction(i, k) = p(i, k) - next
          else if (r(i, k) > 0) then
            p(i, k) = tau*system%inverse(0, 0, k)*r(i, k)
            correction(i, k) = p(i, k)
          end if
        end do
      end do
      r = r - tau*q
      fresh = any(abs(correction) > 0)
      if (fresh) then
        ! These are few elements, so the product costs little.
        call displace(system, correction, q)
        r = r - q
      end if
    end do
    do k = 1, system%n
      p(:, k) = p(:, k)/(system%weight(k)*system%compliance(k))
      r(:, k) = r(:, k)/system%weight(k)
    end do
  end subroutine solve_pressure

  !> z is about the inverse of A times r among the elements under pressure, and 0 elsewhere: every element and its eight
  !> neighbours count alone.  With it the gradients need half the iterations.
  pure subroutine precondition(system, p, r, z)
    type(system_type), intent(in) :: system
    real(dp), intent(in) :: p(system%nx, system%ns, system%n), r(system%nx, system%ns, system%n)
    real(dp), intent(out) :: z(system%nx, system%ns, system%n)
    real(dp) :: e(0:system%nx + 1, 0:system%ns + 1)
    integer :: g, i, j

    e = 0
    do g = 1, system%n
      associate (nx => system%nx, ns => system%ns, c => system%inverse(:, :, g))
        e(1:nx, 1:ns) = merge(r(:, :, g), 0.0_dp, p(:, :, g) > 0)
        e(0, :) = e(1, :)              ! the mirror image at -x
        do j = 1, ns
          do i = 1, nx
            z(i, j, g) = c(1, 1)*e(i, j) + c(2, 1)*(e(i - 1, j) + e(i + 1, j)) + c(1, 2)*(e(i, j - 1) + e(i, j + 1)) &
              + c(2, 2)*(e(i - 1, j - 1) + e(i + 1, j - 1) + e(i - 1, j + 1) + e(i + 1, j + 1))
          end do
        end do
        where (p(:, :, g) <= 0) z(:, :, g) = 0
      end associate
    end do
  end subroutine precondition

  !> q = A p, summed over the elements that are under pressure.
  pure subroutine displace(system, p, q)
    type(system_type), intent(in) :: system
    real(dp), intent(in), contiguous :: p(:, :)
    real(dp), intent(out), contiguous :: q(:, :)
    integer :: g, h, k, l, m, first, n, offset

    q = 0
    m = system%nx*system%ns
    do g = 1, system%n
      do l = 1, system%ns
        offset = (system%ns - l)*system%nx
        associate (load => p((l - 1)*system%nx + 1:l*system%nx, g), w => system%own(offset + 1:offset + m, :, g))
          first = findloc(abs(load) > 0, .true., 1)
          if (first == 0) cycle
          n = findloc(abs(load) > 0, .true., 1, back=.true.)
          ! Three columns at a time: q is read from memory and written once for all three.
          do k = first, n - 2, 3
            q(:, g) = q(:, g) + (load(k)*w(:, k) + load(k + 1)*w(:, k + 1) + load(k + 2)*w(:, k + 2))
          end do
          do k = n - mod(n - first + 1, 3) + 1, n
            q(:, g) = q(:, g) + load(k)*w(:, k)
          end do
        end associate
      end do
      do h = 1, system%n
        if (h == g) cycle
        do l = 1, m
          if (abs(p(l, h)) > 0) q(:, g) = q(:, g) + p(l, h)*system%cross(:, l, g, h)
        end do
      end do
    end do
  end subroutine displace

end module halfspace
