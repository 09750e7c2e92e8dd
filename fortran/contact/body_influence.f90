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
  public :: body_type, new_body, over_halfspace, add_bodies, displacement_of_bodies

  integer, parameter, public :: of_wheel = 1, of_rail = 2
  character(*), parameter, public :: body_kinds(2) = [character(5) :: 'wheel', 'rail']

  integer, parameter :: n_x = 41                  ! values of G over x
  real(dp), parameter :: step_x = 3e-3_dp         ! between them [m]

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

  !> G between one place and strips, (x, strip) [1/m].
  type :: row_type
    real(dp), allocatable :: g(:, :)
  end type row_type

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

  !> The influence of strips on themselves over that of half-spaces, where x is one step: the least and the largest.
  pure function over_halfspace(body) result(ratio)
    type(body_type), intent(in) :: body
    real(dp) :: ratio(2), g(size(body%g, 2))
    integer :: i

    g = [(body%g(2, i, i), i=1, size(g))]
    ratio = 1 + 2*pi*step_x*[minval(g), maxval(g)]
  end function over_halfspace

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
    real(dp) :: v(nx, nx), station(ns, size(mesh), 2), x(nx, size(mesh)), of_x(n_x), half, away(2), length
    type(cubic_type) :: strip(ns, size(mesh), size(bodies)), near(nx, nx), far(nx, nx)
    type(row_type) :: row(size(bodies))
    integer :: b, g, h, i, j, k, l, at, other, last
    logical :: has_rail

    has_rail = any(bodies%kind == of_rail)
    do g = 1, size(mesh)
      x(:, g) = [((i - 0.5_dp)*mesh(g)%dx, i=1, nx)]
      station(:, g, of_wheel) = [(mesh(g)%low + (j - 0.5_dp)*mesh(g)%ds, j=1, ns)]
      station(:, g, of_rail) = foot(:, g)
      do b = 1, size(bodies)
        strip(:, g, b) = strip_of(bodies(b), station(:, g, bodies(b)%kind))
      end do
    end do
    do h = 1, size(mesh)
      do g = 1, h
        do k = 1, nx
          near(:, k) = apart(abs(x(:, g) - x(k, h)))
          far(:, k) = apart(x(:, g) + x(k, h))
        end do
        last = maxval(far(nx, nx)%place)
        do j = 1, ns
          at = nx*(j - 1 + ns*(g - 1))
          do b = 1, size(bodies)
            call set_row(bodies(b), strip(j, g, b), strip(:, h, b), last, row(b))
          end do
          do l = merge(j, 1, g == h), ns
            call sum_rows(row, strip(l, h, :), last, of_x)
            if (g == h) then
              v = between(near(:, 1), far(:, nx), of_x)
            else
              do k = 1, nx
                do i = 1, nx
                  v(i, k) = value(near(i, k), of_x) + value(far(i, k), of_x)
                end do
              end do
            end if
            if (has_rail .and. (g /= h .or. j /= l)) then
              half = cos(angle(j, g) - angle(l, h))/(2*pi)
              away = abs(station(j, g, :) - station(l, h, :))
              length = (mesh(g)%dx + mesh(h)%dx)/2
              do k = 1, nx
                v(:, k) = v(:, k) + half*(further(x(:, g) - x(k, h), away(1), away(2), length) &
                  + further(x(:, g) + x(k, h), away(1), away(2), length))
              end do
            end if
            v = v/e_star
            other = nx*(l - 1 + ns*(h - 1))
            A(at + 1:at + nx, other + 1:other + nx) = A(at + 1:at + nx, other + 1:other + nx) + v
            if (at /= other) A(other + 1:other + nx, at + 1:at + nx) = A(other + 1:other + nx, at + 1:at + nx) + transpose(v)
          end do
        end do
      end do
    end do
  end subroutine add_bodies

  !> G between the elements of two rows of one grid and their mirror images. Few distances occur: those from the first element, and
  !> from the mirror image of the last one.
  pure function between(first, last, of_x) result(v)
    type(cubic_type), intent(in) :: first(:), last(:)
    real(dp), intent(in) :: of_x(:)
    real(dp) :: v(size(first), size(first)), of_distance(0:2*size(first) - 1)
    integer :: i, k, n

    n = size(first)
    do i = 1, n
      of_distance(i - 1) = value(first(i), of_x)
      of_distance(n + i - 1) = value(last(i), of_x)
    end do
    do k = 1, n
      do i = 1, n
        v(i, k) = of_distance(abs(i - k)) + of_distance(i + k - 1)
      end do
    end do
  end function between

  !> What bodies add to the displacement at x = 0 and a station of the wheel by the loads of both halves of grids [m].
  pure real(dp) function displacement_of_bodies(bodies, mesh, angle, foot, e_star, f, s, angle_s, foot_s) result(u)
    type(body_type), intent(in) :: bodies(:)
    type(mesh_type), intent(in) :: mesh(:)
    real(dp), intent(in) :: angle(:, :), foot(:, :)   !! see `add_bodies`
    real(dp), intent(in) :: e_star
    real(dp), intent(in) :: f(:, :, :)         !! loads (nx, ns, grid) [N]
    real(dp), intent(in) :: s, angle_s         !! station [m] and the tangent's angle there [rad]
    real(dp), intent(in) :: foot_s             !! station of the rail below it [m]
    real(dp) :: here(2), there(size(f, 2), 2), x(size(f, 1)), of_x(n_x), one(size(f, 1))
    type(cubic_type) :: along(size(f, 1)), strip(size(f, 2), size(bodies))
    type(row_type) :: row(size(bodies))
    integer :: b, g, i, j, last

    u = 0
    here = [s, foot_s]
    do g = 1, size(mesh)
      x = [((i - 0.5_dp)*mesh(g)%dx, i=1, size(x))]
      along = apart(x)
      last = maxval(along(size(x))%place)
      there(:, of_wheel) = [(mesh(g)%low + (j - 0.5_dp)*mesh(g)%ds, j=1, size(there, 1))]
      there(:, of_rail) = foot(:, g)
      do b = 1, size(bodies)
        strip(:, b) = strip_of(bodies(b), there(:, bodies(b)%kind))
        call set_row(bodies(b), strip_of(bodies(b), here(bodies(b)%kind)), strip(:, b), last, row(b))
      end do
      do j = 1, size(f, 2)
        if (all(f(:, j, g) <= 0)) cycle
        call sum_rows(row, strip(j, :), last, of_x)
        one = [(value(along(i), of_x), i=1, size(x))]
        if (any(bodies%kind == of_rail)) one = one + cos(angle(j, g) - angle_s)/(2*pi) &
          *further(x, abs(there(j, 1) - here(1)), abs(there(j, 2) - here(2)), mesh(g)%dx)
        u = u + 2*dot_product(f(:, j, g), one)/e_star
      end do
    end do
  end function displacement_of_bodies

  !> G between a place and all strips that some other places need, over the first values of x.
  pure subroutine set_row(body, place, others, last, row)
    type(body_type), intent(in) :: body
    type(cubic_type), intent(in) :: place, others(:)
    integer, intent(in) :: last
    type(row_type), intent(out) :: row
    integer :: i, j, low, high

    low = huge(low)
    high = 0
    do i = 1, size(others)
      low = min(low, minval(others(i)%place))
      high = max(high, maxval(others(i)%place))
    end do
    allocate (row%g(last, low:high), source=0.0_dp)
    do j = low, high
      do i = 1, 4
        row%g(:, j) = row%g(:, j) + place%weight(i)*body%g(:last, place%place(i), j)
      end do
    end do
  end subroutine set_row

  !> G of bodies together at places of the strips that their rows have, over the first values of x.
  pure subroutine sum_rows(row, places, last, g)
    type(row_type), intent(in) :: row(:)
    type(cubic_type), intent(in) :: places(:)
    integer, intent(in) :: last
    real(dp), intent(out) :: g(:)
    integer :: b, i

    g(:last) = 0
    do b = 1, size(row)
      do i = 1, 4
        g(:last) = g(:last) + places(b)%weight(i)*row(b)%g(:, places(b)%place(i))
      end do
    end do
  end subroutine sum_rows

  !> Where a station is among the strips of a body.
  elemental type(cubic_type) function strip_of(body, station)
    type(body_type), intent(in) :: body
    real(dp), intent(in) :: station

    strip_of = cubic((station - body%first)/body%width, size(body%g, 2))
  end function strip_of

  !> By how much a load's influence on a point is larger at another distance, over x [1/m]. The load is spread over the length of an
  !> element: within a quarter of it the influence hardly grows any more. Where places of the wheel share one of the rail, they are
  !> apart by half their distance on the wheel at least.
  elemental real(dp) function further(x, away, instead, length)
    real(dp), intent(in) :: x, away, instead, length   !! [m]

    further = 1/sqrt(x**2 + max(instead, away/2)**2 + (length/4)**2) - 1/sqrt(x**2 + away**2 + (length/4)**2)
  end function further

  !> Where a distance along x is among the values of G.
  elemental type(cubic_type) function apart(x)
    real(dp), intent(in) :: x              !! [m]
    real(dp), parameter :: last = (n_x - 1)*step_x

    apart = cubic(x/step_x, n_x)
    apart%weight = apart%weight*last/max(x, last)
  end function apart

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
