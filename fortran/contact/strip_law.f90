!> Elastic energy of one zone of a wheel on its rail, evaluated directly in one pose.
!>
!>     U = 1/2 integral k(s) g+(s)^2 ds       (model 'strip')
!>     U = 2/5 C_H(A, B) delta^(5/2)          (model 'hertz')
!>
!> Here g is the depth of the wheel's station s inside the rail and delta the largest depth of the zone.  The modulus
!> k = 3/4 C_H(A, B) sqrt(B) lets the strips return Hertz's law N = C_H delta^(3/2) wherever the curvatures A
!> (rolling) and B (transverse) are constant.  The model 'hertz' has one spring per zone, with curvatures of the whole
!> interpenetration, so that its energy changes continuously where the deepest station jumps or the curvature does: A is
!> the mean weighted by g+, B the curvature of the parabola with the same delta and the same integral J of g+^2, for which
!> J = 16/15 delta^(5/2)/sqrt(B).  Model 'halfspace' is in `halfspace_patches`.
module strip_law
  use contact_zones, only: zone_type
  use hertz, only: hertz_stiffness, strip_modulus
  use kinds, only: dp
  use root_bracket, only: bracket_type
  use station_scan, only: deepest, scan_type
  use wheel_rail_pair, only: least_cosine, pair_type, rail_curvature
  implicit none
  private
  public :: zone_energy, modulus_near

  real(dp), parameter :: least_ratio = 0.02_dp    ! B/A: longer patches are line contacts

  ! Gauss-Legendre, four points on [0, 1]: exact for the cubic depth squared times a linear modulus.
  real(dp), parameter :: gauss_t(4) = 0.5_dp + 0.5_dp*[-0.861136311594052575_dp, &
    -0.339981043584856265_dp, 0.339981043584856265_dp, 0.861136311594052575_dp]
  real(dp), parameter :: gauss_w(4) = 0.5_dp*[0.347854845137453857_dp, 0.652145154862546143_dp, &
    0.652145154862546143_dp, 0.347854845137453857_dp]

contains

  !> Rolling curvature [1/m] at station i of the wheel, for a roll angle.
  pure real(dp) function rolling_curvature(pair, i, roll) result(A)
    type(pair_type), intent(in) :: pair
    integer, intent(in) :: i
    real(dp), intent(in) :: roll      !! [rad]

    A = max(cos(pair%angle(i) + roll), least_cosine)/(-2*pair%r(2, i))
  end function rolling_curvature

  !> Relative curvatures of wheel and rail at station i of the wheel, for a roll angle.
  pure subroutine relative_curvatures(pair, i, roll, A, B)
    type(pair_type), intent(in) :: pair
    integer, intent(in) :: i
    real(dp), intent(in) :: roll      !! [rad]
    real(dp), intent(out) :: A, B     !! rolling and transverse [1/m]

    A = rolling_curvature(pair, i, roll)
    B = max((pair%curvature(i) + rail_curvature(pair, pair%angle(i) + roll))/2, least_ratio*A)
  end subroutine relative_curvatures

  !> Strip modulus k [Pa] at station i of the wheel, for a roll angle.
  pure real(dp) function modulus_at(pair, i, e_star, roll) result(k)
    type(pair_type), intent(in) :: pair
    integer, intent(in) :: i
    real(dp), intent(in) :: e_star, roll   !! [Pa, rad]
    real(dp) :: A, B

    call relative_curvatures(pair, i, roll, A, B)
    k = strip_modulus(e_star, A, B)*hypot(pair%t(1, i), pair%t(2, i))
  end function modulus_at

  !> Strip modulus k [Pa] at the station of the wheel after s [m], for a roll angle.
  pure real(dp) function modulus_near(pair, s, e_star, roll) result(k)
    type(pair_type), intent(in) :: pair
    real(dp), intent(in) :: s, e_star, roll   !! [m, Pa, rad]

    k = modulus_at(pair, min(count(pair%s < s) + 1, size(pair%s)), e_star, roll)
  end function modulus_near

  !> Elastic energy [J] of a zone in the pose of a scan.
  pure real(dp) function zone_energy(pair, zone, model, e_star, roll, scan) result(energy)
    type(pair_type), intent(in) :: pair
    type(zone_type), intent(in) :: zone
    character(*), intent(in) :: model      !! 'strip' or 'hertz'
    real(dp), intent(in) :: e_star, roll   !! [Pa, rad]
    type(scan_type), intent(in) :: scan
    real(dp) :: depth, station, modulus(2), part, share(2), area, moment, power, A, B
    integer :: i, node, last
    logical :: spring

    spring = model == 'hertz'
    modulus = 1
    last = 0                               ! station whose modulus is known
    energy = 0
    area = 0
    moment = 0
    do i = zone%first, zone%last - 1
      if (all(scan%depth(i:i + 1) < 0) .and. (scan%slope(i) <= 0 .or. scan%slope(i + 1) >= 0)) cycle
      if (.not. spring) then
        if (last == i) modulus(1) = modulus(2)
        if (last /= i) modulus(1) = modulus_at(pair, i, e_star, roll)
        modulus(2) = modulus_at(pair, i + 1, e_star, roll)
        last = i + 1
      end if
      call interval_integrals(pair%s(i + 1) - pair%s(i), scan%depth(i:i + 1), scan%slope(i:i + 1), modulus, part, share)
      energy = energy + part
      if (.not. spring) cycle
      area = area + sum(share)
      moment = moment + share(1)*rolling_curvature(pair, i, roll) + share(2)*rolling_curvature(pair, i + 1, roll)
    end do
    if (.not. spring .or. energy <= 0) return
    ! For the spring the loop has summed up J/2.
    call deepest(pair, scan, zone%first, zone%last, depth, station, node)
    A = moment/area
    power = max(depth, 0.0_dp)**2.5_dp
    B = max((8*power/(15*energy))**2, least_ratio*A)
    energy = 0.4_dp*hertz_stiffness(e_star, A, B)*power
  end function zone_energy

  !> Integrals over the interval between two stations: the energy 1/2 integral of k g+^2 [J], and the force as the
  !> integral of k g+ [N], shared out to the left and right stations.  The depth g is the Hermite cubic.
  pure subroutine interval_integrals(h, g, dg, k, energy, share)
    real(dp), intent(in) :: h                  !! length of the interval [m]
    real(dp), intent(in) :: g(2), dg(2), k(2)  !! depth [m], its slope dg/ds and modulus [Pa] at the two stations
    real(dp), intent(out) :: energy, share(2)
    real(dp) :: c(0:3), start, finish, peak, top
    real(dp), dimension(4) :: t, depth, w

    energy = 0
    share = 0
    c(0) = g(1)
    c(1) = h*dg(1)
    c(2) = 3*(g(2) - g(1)) - h*(2*dg(1) + dg(2))
    c(3) = 2*(g(1) - g(2)) + h*(dg(1) + dg(2))
    start = 0
    finish = 1
    if (all(g < 0)) then
      peak = c(1)/(sqrt(max(c(2)**2 - 3*c(3)*c(1), 0.0_dp)) - c(2))
      top = value(peak)
      if (top <= 0) return
      start = zero(0.0_dp, peak)
      finish = zero(peak, 1.0_dp)
    else if (g(1) < 0) then
      start = zero(0.0_dp, 1.0_dp)
    else if (g(2) < 0) then
      finish = zero(0.0_dp, 1.0_dp)
    end if
    t = start + gauss_t*(finish - start)
    depth = max(value(t), 0.0_dp)
    w = gauss_w*((finish - start)*h)*(k(1) + t*(k(2) - k(1)))*depth
    energy = sum(w*depth)/2
    share = [sum(w*(1 - t)), sum(w*t)]

  contains

    elemental real(dp) function value(t)
      real(dp), intent(in) :: t
      value = c(0) + t*(c(1) + t*(c(2) + t*c(3)))
    end function value

    !> The zero of the cubic between a and b.
    pure real(dp) function zero(a, b) result(t)
      real(dp), intent(in) :: a, b
      type(bracket_type) :: range
      integer :: iter

      range = bracket_type(a, value(a), b, value(b))
      do iter = 1, 100
        t = range%guess()
        if (abs(value(t)) <= 4*epsilon(t)*maxval(abs(c)) .or. abs(range%b - range%a) <= 4*epsilon(t)) exit
        call range%narrow(t, value(t))
      end do
    end function zero

  end subroutine interval_integrals

end module strip_law
