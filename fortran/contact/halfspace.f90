!> Frictionless normal contact of elastic half-spaces on grids of rectangles.
!>
!> Loads f >= 0, each spread evenly over one element, press the surfaces apart by A f (J. Boussinesq; closed form for a
!> rectangle: A. E. H. Love, Phil. Trans. A 228 (1929) 377-420). With D the undeformed interpenetration the solution is
!> the minimum of f.A f/2 - f.D over f >= 0. There A f = D under pressure and A f >= D elsewhere: no tension, no
!> interpenetration (J. J. Kalker, Three-Dimensional Elastic Bodies in Rolling Contact, 1990, ch. 4). Conjugate
!> gradients with an active set find the minimum: I. A. Polonsky, L. M. Keer, Wear 231 (1999) 206-219.
!>
!> The normals of a curved surface differ. A load displaces both bodies along its own normal; along the surface the
!> displacements of two bodies of one material cancel. The part of the displacement along the normal of another element
!> is the cosine of the angle between both normals, by which the influence is multiplied. The matrix of cosines is
!> positive semidefinite, so A stays positive definite (I. Schur, J. reine angew. Math. 140 (1911) 1-28).
!>
!> Every patch has a grid of its own, symmetric about x = 0 (rolling direction); the unknowns are the loads of the half
!> x > 0. Elements of different grids act on each other as point loads.
module halfspace
  use kinds, only: dp, pi
  implicit none
  private
  public :: mesh_type, set_influence, solve_loads, displace

  !> A grid. Elements (i, j) are centred at x = (i - 1/2) dx > 0 and s = low + (j - 1/2) ds.
  type :: mesh_type
    real(dp) :: dx = 0, ds = 0, low = 0    !! [m]
  end type mesh_type

contains

  !> The influence A [m/N] of the loads of elements, and of their mirror images at -x, on the elements of several grids.
  !> Elements are numbered along x, along s, and by grid.
  pure subroutine set_influence(nx, ns, mesh, angle, e_star, A)
    integer, intent(in) :: nx, ns          !! elements of every grid over x > 0 and s
    type(mesh_type), intent(in) :: mesh(:)
    real(dp), intent(in) :: angle(:, :)    !! of the wheel's tangent, (ns, grid) [rad]
    real(dp), intent(in) :: e_star         !! [Pa]
    real(dp), intent(out) :: A(:, :)       !! (nx*ns*grids, nx*ns*grids)
    real(dp) :: u(0:2*nx - 1, 0:ns - 1), v(nx, nx, 0:ns - 1), x(nx), distance, scale
    real(dp), dimension(ns, size(mesh)) :: c, s
    integer :: g, h, i, j, k, l, row, column

    c = cos(angle)
    s = sin(angle)
    do g = 1, size(mesh)
      call unit_influence(nx, ns, mesh(g)%ds/mesh(g)%dx, u)
      scale = 1/(e_star*mesh(g)%ds)
      do j = 0, ns - 1
        do k = 1, nx
          do i = 1, nx
            v(i, k, j) = scale*(u(abs(i - k), j) + u(i + k - 1, j))
          end do
        end do
      end do
      do l = 1, ns
        do j = 1, ns
          row = place(1, j, g)
          do k = 1, nx
            A(row:row + nx - 1, place(k, l, g)) = (c(j, g)*c(l, g) + s(j, g)*s(l, g))*v(:, k, abs(j - l))
          end do
        end do
      end do
    end do
    do h = 2, size(mesh)
      do g = 1, h - 1
        x = [(i - 0.5_dp, i=1, nx)]*mesh(g)%dx
        do l = 1, ns
          do j = 1, ns
            distance = mesh(h)%low + (l - 0.5_dp)*mesh(h)%ds - mesh(g)%low - (j - 0.5_dp)*mesh(g)%ds
            scale = (c(j, g)*c(l, h) + s(j, g)*s(l, h))/(pi*e_star)
            row = place(1, j, g)
            do k = 1, nx
              column = place(k, l, h)
              associate (x_load => (k - 0.5_dp)*mesh(h)%dx)
                A(row:row + nx - 1, column) = scale*(1/sqrt((x - x_load)**2 + distance**2) &
                  + 1/sqrt((x + x_load)**2 + distance**2))
              end associate
              A(column, row:row + nx - 1) = A(row:row + nx - 1, column)
            end do
          end do
        end do
      end do
    end do

  contains

    pure integer function place(i, j, g)
      integer, intent(in) :: i, j, g

      place = i + nx*(j - 1 + ns*(g - 1))
    end function place

  end subroutine set_influence

  !> Displacement u(i, j) at the distance of i and j elements from the load of an element with dx = 1, ds = `ratio`, for a
  !> unit pressure and E* = 1: differences of F(x, y) = x asinh(y/x) + y asinh(x/y), with d2F/dxdy = 1/sqrt(x^2 + y^2), at
  !> the corners (i - 1/2, j - 1/2). F is odd in x and in y.
  pure subroutine unit_influence(nx, ns, ratio, u)
    integer, intent(in) :: nx, ns
    real(dp), intent(in) :: ratio
    real(dp), intent(out) :: u(0:2*nx - 1, 0:ns - 1)
    real(dp) :: f(0:2*nx, 0:ns), x, y, r
    integer :: i, j

    do j = 1, ns
      y = (j - 0.5_dp)*ratio
      do i = 1, 2*nx
        x = i - 0.5_dp
        r = sqrt(x**2 + y**2)
        f(i, j) = x*log((y + r)/x) + y*log((x + r)/y)
      end do
    end do
    f(0, 1:) = -f(1, 1:)
    f(:, 0) = -f(:, 1)
    u = (f(1:, 1:) - f(:2*nx - 1, 1:) - f(1:, :ns - 1) + f(:2*nx - 1, :ns - 1))/pi
  end subroutine unit_influence

  !> Loads f [N] of the elements for their interpenetrations `depth` [m]. On entry f is a first guess. `ok` is false where the
  !> iteration does not reach the tolerance. The energy f.(depth + r) of both halves has the square of the error of f.
  pure subroutine solve_loads(A, depth, tolerance, f, r, ok, iterations)
    real(dp), intent(in), contiguous :: A(:, :)   !! from `set_influence` [m/N]
    real(dp), intent(in) :: depth(:)
    real(dp), intent(in) :: tolerance      !! error of the depth under pressure, relative to its maximum
    real(dp), intent(inout) :: f(:)
    real(dp), intent(out) :: r(:)          !! residual, depth - A f [m]
    logical, intent(out) :: ok
    integer, intent(out) :: iterations
    integer, parameter :: most = 1000
    real(dp), dimension(size(f)) :: t, q, z, flexibility, correction
    real(dp) :: limit, g, g_old, share, tau, next
    logical :: fresh, guessed
    integer :: i

    iterations = 0
    ok = maxval(depth) <= 0
    if (ok) then
      f = 0
      r = depth
      return
    end if
    limit = tolerance*maxval(depth)
    flexibility = [(A(i, i), i=1, size(f))]
    ! Without a guess: as in Hertz's theory, the surfaces touch where they would overlap by more than half the maximum.
    if (all(f <= 0)) f = sqrt(max(2*depth - maxval(depth), 0.0_dp))/flexibility
    t = 0
    g_old = 1
    guessed = .true.
    do iterations = 1, most
      if (guessed) then
        call displace(A, f, q)
        tau = sum(f*depth)/sum(f*q)
        f = f*tau
        r = depth - q*tau
        fresh = .true.
      end if
      ok = all(merge(abs(r), r, f > 0) <= limit)
      if (ok) exit
      z = merge(r/flexibility, 0.0_dp, f > 0)
      g = sum(r*z)
      ! All loads may have been clipped to zero.
      guessed = g <= 0
      if (guessed) then
        f = max(r, 0.0_dp)/flexibility
        cycle
      end if
      share = merge(0.0_dp, g/g_old, fresh)
      t = merge(z + share*t, 0.0_dp, f > 0)
      g_old = g
      call displace(A, t, q)
      tau = sum(r*t)/sum(t*q)
      ! Where the surfaces overlap without pressure, pressure must appear, and the search directions start anew.
      correction = 0
      do i = 1, size(f)
        if (f(i) > 0) then
          next = f(i) + tau*t(i)
          f(i) = max(next, 0.0_dp)
          correction(i) = f(i) - next
        else if (r(i) > 0) then
          f(i) = r(i)/(2*flexibility(i))
          correction(i) = f(i)
        end if
      end do
      r = r - tau*q
      fresh = any(abs(correction) > 0)
      if (fresh) then
        ! These are few elements, so the product costs little.
        call displace(A, correction, q)
        r = r - q
      end if
    end do
  end subroutine solve_loads

  !> q = A f, summed over the elements that carry a load. (The compiler's matmul rounds by where its arrays lie in memory.)
  pure subroutine displace(A, f, q)
    real(dp), intent(in), contiguous :: A(:, :), f(:)
    real(dp), intent(out), contiguous :: q(:)
    integer :: k

    q = 0
    do k = 1, size(f)
      if (abs(f(k)) > 0) q = q + f(k)*A(:, k)
    end do
  end subroutine displace

end module halfspace
