!> What the influence of a wheel's and of a rail's own body differs by from that of half-spaces.
!>
!> A body bends where a half-space does not. Its surface is divided into strips of one width along the rolling direction x. A load
!> on strip j, even over its width and concentrated in x, moves strip i into the body by that of a half-space with the local
!> normals, and by G(x, i, j)/E* more. Over the strips and over x, G is a cubic spline through its values (Catmull-Rom), with a
!> continuous derivative.
!>
!> A half-space of the pair shares its influence evenly among both bodies, by distances along the wheel. Distances along the rail
!> differ where both surfaces part, so the rail's half has those of the rail.
module body_influence
  use halfspace, only: mesh_type
  use kinds, only: dp, pi
  implicit none
  private
  public :: body_type, new_body, add_bodies, displacement_of_bodies

  integer, parameter, public :: of_wheel = 1, of_rail = 2
  character(*), parameter, public :: body_kinds(2) = [character(5) :: 'wheel', 'rail']

  integer, parameter :: n_x = 41                  ! values of G over x
  real(dp), parameter :: step_x = 3e-3_dp         ! between them [m]; beyond the last one G is that of the last one

  !> The body of a wheel or of a rail.
  type :: body_type
    integer :: kind = 0                    !! of_wheel or of_rail
    real(dp) :: first = 0                  !! station of the first strip's middle on the profile [m]
    real(dp) :: width = 0                  !! of the strips [m]
    real(dp), allocatable :: g(:, :, :)    !! G over (x, strip, strip) [1/m]
  end type body_type

  !> Four values of a spline with their weights.
  type :: cubic_type
    integer :: place(4)
    real(dp) :: weight(4)
  end type cubic_type

contains

  !> A body from the influence of loads that are waves along x.
  pure function new_body(kind, first, width, wave, of_waves) result(body)
    integer, intent(in) :: kind
    real(dp), intent(in) :: first, width       !! [m]
    real(dp), intent(in) :: wave(:)            !! wave numbers, ascending [1/m]
    real(dp), intent(in) :: of_waves(:, :, :)  !! E* times the difference by loads cos(kx) per length, (wave, strip, strip)
    type(body_type) :: body
    real(dp) :: share(n_x, size(wave))
    integer :: j

    body%kind = kind
    body%first = first
    body%width = width
    allocate (body%g(n_x, size(of_waves, 2), size(of_waves, 3)))
    call set_shares(wave, share)
    do j = 1, size(of_waves, 3)
      body%g(:, :, j) = matmul(share, of_waves(:, :, j))
    end do
  end function new_body

  !> Shares of the waves in G(x) = (1/pi) integral of A(k) cos(kx) dk [1/m]. Between two waves A is linear in ln k, below the first
  !> one it is that of the first. It falls to 0 from half the last wave number to that, so that G does not ring.
  pure subroutine set_shares(wave, share)
    real(dp), intent(in) :: wave(:)
    real(dp), intent(out) :: share(:, :)
    integer, parameter :: parts = 200          ! of an interval: a wave has at least six of them over the range of x
    real(dp) :: k, at
    integer :: w, p

    share = 0
    do p = 1, parts
      k = wave(1)*(p - 0.5_dp)/parts
      share(:, 1) = share(:, 1) + cosine(k, wave(1)/parts)
    end do
    do w = 2, size(wave)
      do p = 1, parts
        at = (p - 0.5_dp)/parts
        k = wave(w - 1)*(wave(w)/wave(w - 1))**at
        associate (part => cosine(k, k*log(wave(w)/wave(w - 1))/parts))
          share(:, w - 1) = share(:, w - 1) + (1 - at)*part
          share(:, w) = share(:, w) + at*part
        end associate
      end do
    end do

  contains

    pure function cosine(k, dk)
      real(dp), intent(in) :: k, dk
      real(dp) :: cosine(size(share, 1))
      integer :: i

      cosine = [(cos(k*i*step_x), i=0, size(share, 1) - 1)]*dk/pi*cos(pi/2*max(0.0_dp, 2*k/wave(size(wave)) - 1))**2
    end function cosine

  end subroutine set_shares

  !> Add what bodies differ by from half-spaces to the influence of elements on each other, see `set_influence` [m/N].
  pure subroutine add_bodies(bodies, nx, ns, mesh, angle, foot, e_star, A)
    type(body_type), intent(in) :: bodies(:)
    integer, intent(in) :: nx, ns          !! elements of every grid over x > 0 and s
    type(mesh_type), intent(in) :: mesh(:)
    real(dp), intent(in) :: angle(:, :)    !! of the wheel's tangent, (ns, grid) [rad]
    real(dp), intent(in) :: foot(:, :)     !! stations of the rail that the rows of elements are pressed on, (ns, grid) [m]
    real(dp), intent(in) :: e_star         !! [Pa]
    real(dp), intent(inout) :: A(:, :)
    type(cubic_type) :: near(nx, nx), far(nx, nx)
    real(dp) :: v(nx, nx), station(ns, size(mesh), 2), x(nx, size(mesh)), away, half, of_x(n_x)
    type(cubic_type) :: strip(ns, size(mesh), size(bodies))
    integer :: b, g, h, i, j, k, l, row, column, last
    logical :: has_rail

    has_rail = any(bodies%kind == of_rail)
    do g = 1, size(mesh)
      x(:, g) = [((i - 0.5_dp)*mesh(g)%dx, i=1, nx)]
      station(:, g, of_wheel) = [(mesh(g)%low + (j - 0.5_dp)*mesh(g)%ds, j=1, ns)]
      station(:, g, of_rail) = foot(:, g)
      do b = 1, size(bodies)
        strip(:, g, b) = cubic((station(:, g, bodies(b)%kind) - bodies(b)%first)/bodies(b)%width, size(bodies(b)%g, 2))
      end do
    end do
    do h = 1, size(mesh)
      do g = 1, h
        do k = 1, nx
          near(:, k) = cubic(abs(x(:, g) - x(k, h))/step_x, n_x)
          far(:, k) = cubic((x(:, g) + x(k, h))/step_x, n_x)
        end do
        last = maxval(far(nx, nx)%place)
        do l = 1, ns
          do j = 1, merge(l, ns, g == h)
            v = 0
            do b = 1, size(bodies)
              call over_x(bodies(b), strip(j, g, b), strip(l, h, b), last, of_x)
              do k = 1, nx
                do i = 1, nx
                  v(i, k) = v(i, k) + value(near(i, k), of_x) + value(far(i, k), of_x)
                end do
              end do
            end do
            if (has_rail .and. (g /= h .or. j /= l)) then
              away = abs(station(j, g, of_wheel) - station(l, h, of_wheel))
              half = cos(angle(j, g) - angle(l, h))/(2*pi)
              associate (on_rail => abs(foot(j, g) - foot(l, h)))
                do k = 1, nx
                  v(:, k) = v(:, k) + half*(further(x(:, g) - x(k, h), away, on_rail) + further(x(:, g) + x(k, h), away, on_rail))
                end do
              end associate
            end if
            v = v/e_star
            row = nx*(j - 1 + ns*(g - 1))
            column = nx*(l - 1 + ns*(h - 1))
            A(row + 1:row + nx, column + 1:column + nx) = A(row + 1:row + nx, column + 1:column + nx) + v
            if (row /= column) A(column + 1:column + nx, row + 1:row + nx) = &
              A(column + 1:column + nx, row + 1:row + nx) + transpose(v)
          end do
        end do
      end do
    end do
  end subroutine add_bodies

  !> What bodies add to the displacement at x = 0 and a station of the wheel by the loads of both halves of grids [m].
  pure real(dp) function displacement_of_bodies(bodies, mesh, angle, foot, e_star, f, s, angle_s, foot_s) result(u)
    type(body_type), intent(in) :: bodies(:)
    type(mesh_type), intent(in) :: mesh(:)
    real(dp), intent(in) :: angle(:, :), foot(:, :)   !! see `add_bodies`
    real(dp), intent(in) :: e_star
    real(dp), intent(in) :: f(:, :, :)         !! loads (nx, ns, grid) [N]
    real(dp), intent(in) :: s, angle_s         !! station [m] and the tangent's angle there [rad]
    real(dp), intent(in) :: foot_s             !! station of the rail below it [m]
    real(dp) :: here(2), there(2), x(size(f, 1)), of_x(n_x), one(size(f, 1))
    type(cubic_type) :: along(size(f, 1))
    integer :: b, g, i, j

    u = 0
    here = [s, foot_s]
    do g = 1, size(mesh)
      x = [((i - 0.5_dp)*mesh(g)%dx, i=1, size(f, 1))]
      along = cubic(x/step_x, n_x)
      do j = 1, size(f, 2)
        if (all(f(:, j, g) <= 0)) cycle
        there = [mesh(g)%low + (j - 0.5_dp)*mesh(g)%ds, foot(j, g)]
        one = 0
        if (any(bodies%kind == of_rail)) one = cos(angle(j, g) - angle_s)/(2*pi) &
          *further(x, abs(there(1) - here(1)), abs(there(2) - here(2)))
        do b = 1, size(bodies)
          associate (body => bodies(b))
            call over_x(body, strip_of(body, there(body%kind)), strip_of(body, here(body%kind)), n_x, of_x)
          end associate
          one = one + [(value(along(i), of_x), i=1, size(along))]
        end do
        u = u + 2*dot_product(f(:, j, g), one)/e_star
      end do
    end do
  end function displacement_of_bodies

  pure type(cubic_type) function strip_of(body, station)
    type(body_type), intent(in) :: body
    real(dp), intent(in) :: station

    strip_of = cubic((station - body%first)/body%width, size(body%g, 2))
  end function strip_of

  !> By how much a load's influence on a point is larger at another distance, over x [1/m].
  elemental real(dp) function further(x, away, instead)
    real(dp), intent(in) :: x, away, instead   !! [m]

    further = 1/sqrt(x**2 + instead**2) - 1/sqrt(x**2 + away**2)
  end function further

  !> G between two places of a body, over the first values of x.
  pure subroutine over_x(body, one, other, last, g)
    type(body_type), intent(in) :: body
    type(cubic_type), intent(in) :: one, other
    integer, intent(in) :: last
    real(dp), intent(out) :: g(:)
    integer :: i, j

    g(:last) = 0
    do j = 1, 4
      do i = 1, 4
        g(:last) = g(:last) + one%weight(i)*other%weight(j)*body%g(:last, one%place(i), other%place(j))
      end do
    end do
  end subroutine over_x

  pure real(dp) function value(at, values)
    type(cubic_type), intent(in) :: at
    real(dp), intent(in) :: values(:)

    value = sum(at%weight*values(at%place))
  end function value

  !> The four of n values, numbered from 0 by t, that the spline through them has at t, and their weights. At the first and the
  !> last one it is level, and beyond them constant.
  elemental type(cubic_type) function cubic(t, n)
    real(dp), intent(in) :: t
    integer, intent(in) :: n
    real(dp) :: u
    integer :: i, k

    u = max(0.0_dp, min(t, n - 1.0_dp))
    i = min(int(u), n - 2)
    u = u - i
    cubic%place = [(n - abs(n - 1 - abs(i + k)), k=-1, 2)]
    cubic%weight = [-u*(1 - u)**2, 2 - u**2*(5 - 3*u), u*(1 + u*(4 - 3*u)), -u**2*(1 - u)]/2
  end function cubic

end module body_influence
