!> Elastic normal contact of one wheel and its rail, evaluated directly.
!>
!> The elastic energy of a pose is
!>
!>     U = 1/2 integral k(s) g+(s)^2 ds                     (model 'strip')
!>     U = 2/5 C_H delta^(5/2) per zone                     (model 'hertz')
!>
!>     U = 1/2 integral p D dA, exact                       (model 'halfspace', of `halfspace_patches`)
!>
!> with g the depth of the wheel's station s inside the rail, delta the largest
!> depth of the zone, and k = 3/4 C_H(A, B) sqrt(B) so that the strips return
!> Hertz's law N = C_H delta^(3/2) wherever the curvatures A (rolling) and
!> B (transverse) are constant.
!>
!> Zones: the wheel is cut where it cannot touch, in the middle of the arcs whose
!> curvature relative to the rail's point of the same normal is negative.  A zone
!> then holds one patch that moves smoothly, which makes its energy smooth in
!> the pose.  The cut nearest to `split_angle` parts the tread from the flange.
module contact_zones
  use errors, only: error_type, fatal_error
  use station_scan, only: deepest, scan_type
  use wheel_rail_pair, only: pair_type, rail_curvature
  use hertz, only: hertz_stiffness, strip_modulus
  use kinds, only: dp, degree
  use text, only: str
  implicit none
  private
  public :: zone_type, side_type, stiffest, find_zones, set_moduli, zone_energy, zone_force, max_zones

  integer, parameter :: max_zones = 6

  !> Energy of half-spaces over that of strips, at most.  A patch of the tread that reaches over the cut to the flange
  !> leaves a sliver there.  In the whole patch its pressure is that of an edge, next to nothing; a half-space pressed in
  !> by the sliver alone is up to 60 times stiffer than the strips.
  real(dp), parameter :: stiffest = 1.5_dp

  !> A stretch of the wheel that carries one patch.
  type :: zone_type
    integer :: first = 0, last = 0     !! its stations
    logical :: flange = .false.        !! flange, or tread
    real(dp) :: alpha = 0              !! mean contact angle [rad]
    real(dp) :: pole(2) = 0            !! the point nearest to all contact normals, wheelset frame [m]
  end type zone_type

  !> One side of the wheelset, as if it were the left one.
  type :: side_type
    type(pair_type) :: pair
    type(zone_type), allocatable :: zones(:)   !! from the tread to the flange
    real(dp) :: clearance = 0          !! of the rigid wheelset to this side [m]
  end type side_type

  real(dp), parameter :: least_cut = 0.4e-3_dp    ! shortest arc that counts as a gap [m]
  real(dp), parameter :: least_zone = 1e-3_dp     ! shortest zone: half the window of the mean curvature [m]
  real(dp), parameter :: least_ratio = 0.02_dp    ! of B to A: flatter patches are line contacts
  real(dp), parameter :: least_cosine = 0.05_dp   ! of the contact angle in A

  ! Gauss-Legendre, four points on [0, 1]: exact for the cubic depth squared
  ! times a linear modulus.
  real(dp), parameter :: gauss_t(4) = 0.5_dp + 0.5_dp*[-0.861136311594052575_dp, &
    -0.339981043584856265_dp, 0.339981043584856265_dp, 0.861136311594052575_dp]
  real(dp), parameter :: gauss_w(4) = 0.5_dp*[0.347854845137453857_dp, 0.652145154862546143_dp, &
    0.652145154862546143_dp, 0.347854845137453857_dp]

contains

  !> Cut the wheel into zones, from the field side of the tread to the flange.
  subroutine find_zones(pair, split_angle, zones, error)
    type(pair_type), intent(in) :: pair
    real(dp), intent(in) :: split_angle              !! [rad]
    type(zone_type), allocatable, intent(out) :: zones(:)
    type(error_type), allocatable, intent(out) :: error
    integer :: cuts(max_zones), begins(max_zones), n_cuts, parting, top, running, split, i, from, nearest
    real(dp) :: turn(max_zones), hollow

    top = pair%steepest
    running = count(pair%s <= pair%centred_station)
    split = running
    do while (split > top .and. pair%angle(split) < split_angle)
      split = split - 1
    end do
    if (split == running) then
      call fatal_error(error, '&contact split_angle = '//str(split_angle)// &
        ' rad: expected more than the tread''s angle where the centred wheel touches, '// &
        str(pair%angle(running))//' rad')
      return
    else if (split == top) then
      call fatal_error(error, '&contact split_angle = '//str(split_angle)// &
        ' rad: expected at most the flange''s steepest angle, '//str(maxval(pair%angle(top + 1:running)))//' rad')
      return
    end if

    ! Arcs of negative relative curvature between running point and flange face; where there are too many,
    ! as on profiles that conform, those over which the normals part most.
    cuts = 0
    turn = 0
    n_cuts = 0
    from = 0
    hollow = 0
    do i = running, top, -1
      if (pair%curvature(i) + rail_curvature(pair, pair%angle(i)) < 0) then
        if (from == 0) from = i
        hollow = hollow - (pair%curvature(i) + rail_curvature(pair, pair%angle(i)))*(pair%s(i + 1) - pair%s(i))
        cycle
      end if
      if (from > 0) then
        if (pair%s(from) - pair%s(i) > least_cut) call add_cut()
      end if
      from = 0
      hollow = 0
    end do
    ! The tread ends at the last gap that begins before the split angle, else at one right behind it, else there.
    parting = 0
    do i = 1, n_cuts
      if (begins(i) > split .or. parting == 0 .and. pair%s(split) - pair%s(cuts(i)) < least_zone) parting = cuts(i)
    end do
    if (parting == 0) then
      parting = split
      nearest = count(cuts(:n_cuts) > split)
      cuts(nearest + 2:n_cuts + 1) = cuts(nearest + 1:n_cuts)
      cuts(nearest + 1) = split
      n_cuts = n_cuts + 1
    end if

    allocate (zones(n_cuts + 1))
    zones(1)%last = size(pair%s)
    do i = 1, n_cuts
      zones(i)%first = cuts(i)
      zones(i + 1)%last = cuts(i)
      zones(i + 1)%flange = cuts(i) <= parting
    end do
    zones(n_cuts + 1)%first = 1
    do i = 1, n_cuts + 1
      call set_pole(pair, top, zones(i))
    end do

  contains

    !> Note the arc from..i, in the place of the last one where that is too near, of the flattest where all are taken.
    subroutine add_cut()
      integer :: flattest

      if (n_cuts > 0) then
        if (pair%s(cuts(n_cuts)) - pair%s((from + i)/2) < least_zone) then
          if (turn(n_cuts) > hollow) return
          n_cuts = n_cuts - 1
        end if
      end if
      if (n_cuts == max_zones - 2) then
        flattest = minloc(turn(:n_cuts), 1)
        if (turn(flattest) > hollow) return
        cuts(flattest:n_cuts - 1) = cuts(flattest + 1:n_cuts)
        begins(flattest:n_cuts - 1) = begins(flattest + 1:n_cuts)
        turn(flattest:n_cuts - 1) = turn(flattest + 1:n_cuts)
        n_cuts = n_cuts - 1
      end if
      n_cuts = n_cuts + 1
      cuts(n_cuts) = (from + i)/2
      begins(n_cuts) = from
      turn(n_cuts) = hollow
    end subroutine add_cut

  end subroutine find_zones

  !> Mean angle and pole of a zone from the stations that carry it in service.
  pure subroutine set_pole(pair, top, zone)
    type(pair_type), intent(in) :: pair
    integer, intent(in) :: top                   !! station of the flange face
    type(zone_type), intent(inout) :: zone
    real(dp), parameter :: service = 20e-3_dp   ! either side of the running point [m]
    real(dp), parameter :: weight = 1e-3_dp     ! holds the pole of a straight line
    real(dp) :: middle(2), a(2, 2), b(2), t(2)
    integer :: j, lo, hi

    lo = max(zone%first, top)
    hi = zone%last
    if (zone%last == size(pair%s)) then
      lo = max(zone%first, count(pair%s < pair%centred_station - service))
      hi = min(zone%last, count(pair%s < pair%centred_station + service) + 1)
    end if
    zone%alpha = sum(pair%angle(lo:hi))/(hi - lo + 1)
    middle = sum(pair%r(:, lo:hi), 2)/(hi - lo + 1)
    ! Least squares: sum ((r - pole).t)^2 + weight |pole - middle|^2.
    a = reshape([weight, 0.0_dp, 0.0_dp, weight], [2, 2])
    b = 0
    do j = lo, hi
      t = pair%t(:, j)
      a = a + spread(t, 2, 2)*spread(t, 1, 2)/(hi - lo + 1)
      b = b + t*dot_product(pair%r(:, j) - middle, t)/(hi - lo + 1)
    end do
    zone%pole = middle + [a(2, 2)*b(1) - a(1, 2)*b(2), a(1, 1)*b(2) - a(2, 1)*b(1)] &
      /(a(1, 1)*a(2, 2) - a(1, 2)*a(2, 1))
    ! Behind the flange tip the rail cannot be reached from this direction.
    do while (zone%first < top .and. pair%angle(zone%first) < zone%alpha - 80*degree)
      zone%first = zone%first + 1
    end do
  end subroutine set_pole

  !> Relative curvatures at a wheel's station for a given roll angle.
  pure subroutine relative_curvatures(pair, angle, radius, wheel_curvature, roll, A, B)
    type(pair_type), intent(in) :: pair
    real(dp), intent(in) :: angle, radius, wheel_curvature   !! of the wheel there [rad, m, 1/m]
    real(dp), intent(in) :: roll      !! [rad]
    real(dp), intent(out) :: A, B     !! rolling and transverse [1/m]

    A = max(cos(angle + roll), least_cosine)/(2*radius)
    B = max((wheel_curvature + rail_curvature(pair, angle + roll))/2, least_ratio*A)
  end subroutine relative_curvatures

  !> Strip modulus k [Pa] of a zone's stations at a roll angle.
  pure subroutine set_moduli(pair, zone, e_star, roll, k)
    type(pair_type), intent(in) :: pair
    type(zone_type), intent(in) :: zone
    real(dp), intent(in) :: e_star, roll   !! [Pa, rad]
    real(dp), intent(inout) :: k(:)        !! (stations of the wheel)
    real(dp) :: A, B
    integer :: i

    do i = zone%first, zone%last
      call relative_curvatures(pair, pair%angle(i), -pair%r(2, i), pair%curvature(i), roll, A, B)
      k(i) = strip_modulus(e_star, A, B)*hypot(pair%t(1, i), pair%t(2, i))
    end do
  end subroutine set_moduli

  !> Elastic energy [J] of a scanned zone.
  pure real(dp) function zone_energy(pair, zone, model, e_star, roll, work, k) result(energy)
    type(pair_type), intent(in) :: pair
    type(zone_type), intent(in) :: zone
    character(*), intent(in) :: model      !! 'strip' or 'hertz'
    real(dp), intent(in) :: e_star, roll   !! [Pa, rad]
    type(scan_type), intent(in) :: work
    real(dp), intent(in), contiguous :: k(:)   !! of set_moduli, for 'strip'
    real(dp) :: part, left, right, depth, station, A, B
    integer :: i, n, node

    energy = 0
    if (model == 'hertz') then
      call deepest(pair, work, zone%first, zone%last, depth, station, node)
      if (depth <= 0) return
      call relative_curvatures(pair, pair%angle(node), -pair%r(2, node), pair%curvature(node), roll, A, B)
      energy = 0.4_dp*hertz_stiffness(e_star, A, B)*depth**2.5_dp
    else
      n = 0
      do i = zone%first, zone%last
        if (i < zone%last) then
          if (all(work%depth(i:i + 1) > 0)) then
            n = n + 1
            cycle
          end if
        end if
        energy = energy + whole_cells(n, pair%s(i - n:i), work%depth(i - n:i), work%slope(i - n:i), k(i - n:i))
        n = 0
        if (i == zone%last) exit
        call cell(pair%s(i + 1) - pair%s(i), work%depth(i:i + 1), work%slope(i:i + 1), k(i:i + 1), &
          part, left, right)
        energy = energy + part
      end do
    end if
  end function zone_energy

  !> The energy of `cell` summed over n intervals in a row that are pressed from end to end,
  !> in closed form: a loop without branches.
  pure real(dp) function whole_cells(n, s, g, dg, k) result(energy)
    integer, intent(in) :: n
    real(dp), intent(in) :: s(n + 1), g(n + 1), dg(n + 1), k(n + 1)
    real(dp), parameter :: w(8) = 1/[1.0_dp, 2.0_dp, 3.0_dp, 4.0_dp, 5.0_dp, 6.0_dp, 7.0_dp, 8.0_dp]
    real(dp) :: h, c0, c1, c2, c3, k1, k2
    integer :: i

    energy = 0
    do i = 1, n
      h = s(i + 1) - s(i)
      c0 = g(i)
      c1 = h*dg(i)
      c2 = 3*(g(i + 1) - g(i)) - h*(2*dg(i) + dg(i + 1))
      c3 = 2*(g(i) - g(i + 1)) + h*(dg(i) + dg(i + 1))
      k1 = k(i)
      k2 = k(i + 1) - k(i)
      ! Coefficients of g^2 times the integrals of (k1 + k2 t) t^j, j = 0..6.
      energy = energy + h/2*(c0**2*(k1*w(1) + k2*w(2)) + 2*c0*c1*(k1*w(2) + k2*w(3)) &
        + (2*c0*c2 + c1**2)*(k1*w(3) + k2*w(4)) + 2*(c0*c3 + c1*c2)*(k1*w(4) + k2*w(5)) &
        + (2*c1*c3 + c2**2)*(k1*w(5) + k2*w(6)) + 2*c2*c3*(k1*w(6) + k2*w(7)) &
        + c3**2*(k1*w(7) + k2*w(8)))
    end do
  end function whole_cells

  !> Force of the rail on a scanned zone of strips, and its moment about the
  !> axle centre, the moduli k taken as fixed: (F_y [N], F_z [N], M_x [N m]).
  pure function zone_force(pair, zone, roll, work, k) result(force)
    type(pair_type), intent(in) :: pair
    type(zone_type), intent(in) :: zone
    real(dp), intent(in) :: roll           !! [rad]
    type(scan_type), intent(in) :: work
    real(dp), intent(in) :: k(:)           !! of set_moduli
    real(dp) :: force(3), part, share(0:1), n(2), x(2)
    integer :: i, j

    force = 0
    do i = zone%first, zone%last - 1
      call cell(pair%s(i + 1) - pair%s(i), work%depth(i:i + 1), work%slope(i:i + 1), k(i:i + 1), &
        part, share(0), share(1))
      do j = 0, 1
        n = work%normal(:, i + j)
        x = [pair%r(1, i + j)*cos(roll) - pair%r(2, i + j)*sin(roll), &
             pair%r(1, i + j)*sin(roll) + pair%r(2, i + j)*cos(roll)]
        force = force + share(j)*[n(1), n(2), x(1)*n(2) - x(2)*n(1)]
      end do
    end do
  end function zone_force

  !> One interval of stations: 1/2 integral of k g+^2, and the integral of k g+
  !> shared out to the two stations.  The depth is the Hermite cubic.
  pure subroutine cell(h, g, dg, k, energy, left, right)
    real(dp), intent(in) :: h, g(2), dg(2), k(2)
    real(dp), intent(out) :: energy, left, right
    real(dp) :: c(0:3), from, to, peak, top
    real(dp), dimension(4) :: t, depth, w

    energy = 0
    left = 0
    right = 0
    if (all(g < 0) .and. (dg(1) <= 0 .or. dg(2) >= 0)) return
    c(0) = g(1)
    c(1) = h*dg(1)
    c(2) = 3*(g(2) - g(1)) - h*(2*dg(1) + dg(2))
    c(3) = 2*(g(1) - g(2)) + h*(dg(1) + dg(2))
    from = 0
    to = 1
    if (all(g < 0)) then
      peak = c(1)/(sqrt(max(c(2)**2 - 3*c(3)*c(1), 0.0_dp)) - c(2))
      top = value(peak)
      if (top <= 0) return
      from = zero(0.0_dp, peak)
      to = zero(peak, 1.0_dp)
    else if (g(1) < 0) then
      from = zero(0.0_dp, 1.0_dp)
    else if (g(2) < 0) then
      to = zero(0.0_dp, 1.0_dp)
    end if
    t = from + gauss_t*(to - from)
    depth = max(value(t), 0.0_dp)
    w = gauss_w*((to - from)*h)*(k(1) + t*(k(2) - k(1)))*depth
    energy = sum(w*depth)/2
    left = sum(w*(1 - t))
    right = sum(w*t)

  contains

    elemental real(dp) function value(t)
      real(dp), intent(in) :: t
      value = c(0) + t*(c(1) + t*(c(2) + t*c(3)))
    end function value

    !> The zero of the cubic in a bracket: Newton, bisected where it leaves.
    pure real(dp) function zero(a, b) result(t)
      real(dp), intent(in) :: a, b
      real(dp) :: lo, hi, f, slope, rising, t_old
      integer :: iter

      lo = a
      hi = b
      rising = sign(1.0_dp, value(b) - value(a))
      t = (a*value(b) - b*value(a))/(value(b) - value(a))
      do iter = 1, 60
        f = value(t)*rising
        if (f > 0) hi = t
        if (f <= 0) lo = t
        slope = (c(1) + t*(2*c(2) + t*3*c(3)))*rising
        t_old = t
        t = t - f/merge(slope, 1.0_dp, slope > 0)
        if (slope <= 0 .or. t < lo .or. t > hi) t = (lo + hi)/2
        if (abs(t - t_old) <= 4*epsilon(t)) exit
      end do
    end function zero

  end subroutine cell

end module contact_zones