!> Rigid contact geometry of the whole wheelset: where it stands on both rails at a lateral displacement, the flange
!> clearance, and the geometry functions that railway engineers read.
module geometry_functions
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_quiet_nan, ieee_value
  use root_bracket, only: bracket_type
  use contact_zones, only: is_flange, side_type
  use curve, only: curve_frame
  use station_scan, only: new_scan, scan_type, touch
  use wheel_rail_pair, only: pair_type, rolled
  use kinds, only: dp, pi
  implicit none
  private
  public :: clearance, conicity, rigid_contact, &
    geometry_table, geometry_at, geometry_names, geometry_units, geometry_pitch

  !> Columns of the geometry file.
  character(*), parameter :: geometry_names(*) = [character(12) :: 'Y', 'roll', 'Z', 'angle_L', &
    'angle_R', 'radius_L', 'radius_R', 'delta_r', 'y_L', 'z_L', 'y_R', 'z_R', 'conicity']
  character(*), parameter :: geometry_units(*) = [character(12) :: 'm', 'rad', 'm', 'rad', &
    'rad', 'm', 'm', 'm', 'm', 'm', 'm', 'm', '1']
  !> Distance between the rows of the geometry file [m].
  real(dp), parameter :: geometry_pitch = 1e-4_dp

contains

  !> Height z [m] of the axle at which the left wheel touches when it is lowered at lateral position y [m] and roll
  !> angle [rad]. The scan is fresh, or from touching at another roll angle.
  subroutine lower(pair, y, roll, scan, z, station, ok)
    type(pair_type), intent(in) :: pair
    real(dp), intent(in) :: y, roll
    type(scan_type), intent(inout) :: scan
    real(dp), intent(out) :: z, station
    logical, intent(out) :: ok
    real(dp), parameter :: lift = 0.03_dp   ! the whole flange is in the air at the start [m]
    ! Roll by d moves a point at r by |r| d at most; the wheel then rises by up to |r| d/cos(contact angle), here 78 degrees.
    real(dp), parameter :: least_cosine = 0.2_dp
    real(dp) :: start

    if (scan%fresh) then
      ! Roll lifts the wheel by its lever arm.
      start = pair%axle_height + lift - roll*pair%r(1, size(pair%s)/2)
    else
      start = scan%centre(2) + norm2(pair%flange_tip)/least_cosine*abs(roll - scan%roll)
    end if
    call touch(pair, scan, 1, size(pair%s), [y, start], roll, 0.0_dp, z, station, ok)
    z = z + start
  end subroutine lower

  !> Roll angle and height at which the rigid wheelset stands on both rails: the least roll angle where
  !> there are several. `ok` is false where the wheelset does not stand on both rails.
  subroutine rigid_contact(side, y, roll, z, station, ok)
    type(side_type), intent(in) :: side(:) !! left, right
    real(dp), intent(in) :: y              !! lateral displacement of the axle centre [m]
    real(dp), intent(out) :: roll, z       !! [rad, m]
    real(dp), intent(out) :: station(2)    !! contact stations on the left and right wheel [m]
    logical, intent(out) :: ok
    ! Solutions on the tread and on the flange may be near each other. So the search hardly passes the first one: its steps are
    ! those of the secant method, or a stride that grows from the least one, if that is longer.
    real(dp), parameter :: first_stride = 1e-6_dp, least_stride = 1e-9_dp, longest_stride = 1e-3_dp   ! [rad]
    real(dp), parameter :: growth = 2.0_dp
    real(dp), parameter :: largest = 0.2_dp   ! [rad]
    type(scan_type) :: left, right
    type(bracket_type) :: range
    real(dp) :: x(2), f(2), z_left, z_right, f_new, stride, secant
    integer :: iter

    left = new_scan(side(1)%pair)
    right = new_scan(side(2)%pair)
    z = 0
    ! The side that would touch first is lifted until the other one does.
    x = 0
    roll = 0
    stride = least_stride
    secant = first_stride
    f = difference(0.0_dp)
    do while (ok .and. f(1)*f(2) > 0)
      x(1) = x(2)
      f(1) = f(2)
      x(2) = x(1) + sign(min(max(secant, stride), longest_stride), f(1))
      stride = growth*stride
      ok = abs(x(2)) < largest
      if (ok) f(2) = difference(x(2))
      secant = 0
      if (abs(f(2)) < abs(f(1))) secant = abs(f(2)*(x(2) - x(1))/(f(2) - f(1)))
    end do
    if (.not. ok) return
    range = bracket_type(x(1), f(1), x(2), f(2))
    do iter = 1, 100
      roll = range%guess()
      f_new = difference(roll)
      if (.not. ok) return
      if (abs(f_new) < 1e-13_dp .or. abs(range%b - range%a) < 1e-16_dp) exit
      call range%narrow(roll, f_new)
    end do
    z = (z_left + z_right)/2
    ok = abs(f_new) < 1e-9_dp

  contains

    real(dp) function difference(roll)
      real(dp), intent(in) :: roll
      logical :: ok_left, ok_right

      call lower(side(1)%pair, y, roll, left, z_left, station(1), ok_left)
      call lower(side(2)%pair, -y, -roll, right, z_right, station(2), ok_right)
      ok = ok_left .and. ok_right
      difference = z_left - z_right
    end function difference

  end subroutine rigid_contact

  !> Lateral displacement y [m] at which the contact of the left wheel of the rigid wheelset becomes the flange's: its angle
  !> exceeds the threshold of the side, or jumps past it. `ok` is false where there is none between 0 and 0.05 m.
  subroutine clearance(side, y, ok)
    type(side_type), intent(in) :: side(:)    !! left, right
    real(dp), intent(out) :: y
    logical, intent(out) :: ok
    real(dp), parameter :: widest = 0.05_dp, stride = 0.5e-3_dp, close = 1e-12_dp    ! [m]
    real(dp) :: low, high

    y = 0
    low = 0
    high = stride
    ok = .not. touches_flange(low)
    do while (ok)
      if (touches_flange(high)) exit
      low = high
      high = high + stride
      ok = high <= widest
    end do
    if (.not. ok) return
    ! Bisection, because the contact may jump to the flange.
    do while (high - low > close)
      y = (low + high)/2
      if (touches_flange(y)) then
        high = y
      else
        low = y
      end if
    end do
    y = high

  contains

    !> Whether the left wheel stands on its flange, or the wheelset does not stand on both rails.
    logical function touches_flange(y)
      real(dp), intent(in) :: y
      real(dp) :: roll, z, station(2), r(2), angle, curvature
      logical :: ok

      call rigid_contact(side, y, roll, z, station, ok)
      touches_flange = .not. ok
      if (.not. ok) return
      call curve_frame(side(1)%pair%wheel, station(1), r, angle, curvature)
      touches_flange = is_flange(side(1), [-sin(angle + roll), cos(angle + roll)], station(1))
    end function touches_flange

  end subroutine clearance

  !> Equivalent conicity for an amplitude a by harmonic linearisation of the rolling radius difference: 1/(pi a) times the
  !> integral over one period of (delta_r(c + a sin tau)/2) sin tau dtau.  The mean of delta_r over the period is zero
  !> about the centre c, which is off the track's centre where left and right differ.  NaN where such a motion leaves the
  !> range of y.
  pure real(dp) function conicity(amplitude, y, delta_r)
    real(dp), intent(in) :: amplitude      !! [m]
    real(dp), intent(in) :: y(:)           !! lateral displacements, increasing, evenly spaced [m]
    real(dp), intent(in) :: delta_r(:)     !! radius left minus right [m]
    real(dp), parameter :: rounding = 1e-12_dp    ! largest mean where both sides are the same [m]
    type(bracket_type) :: range
    real(dp) :: centre, means(2)
    integer :: iter

    conicity = ieee_value(1.0_dp, ieee_quiet_nan)
    centre = 0
    means = period_means(centre)
    if (abs(means(1)) > rounding) then
      range = bracket_type(centre, means(1), centre, means(1))
      do while (range%fb*range%fa > 0)
        range = bracket_type(range%b, range%fb, range%b - sign(y(2) - y(1), range%fb), 0.0_dp)
        if (range%b - amplitude < y(1) .or. range%b + amplitude > y(size(y))) return
        means = period_means(range%b)
        range%fb = means(1)
      end do
      do iter = 1, 60
        if (abs(means(1)) <= 1e-3_dp*rounding) exit
        centre = range%guess()
        means = period_means(centre)
        call range%narrow(centre, means(1))
      end do
    end if
    conicity = means(2)

  contains

    !> Means over a period about the centre c: of delta_r [m], and of delta_r sin(tau) over the amplitude.
    pure function period_means(c) result(means)
      real(dp), intent(in) :: c
      real(dp) :: means(2)
          integer, parameter :: phases = 200   ! points of the period
      real(dp) :: wave, position, share
      integer :: i, j

      means = 0
      do i = 1, phases
        wave = sin(2*pi*(i - 0.5_dp)/phases)
        position = 1 + (c + amplitude*wave - y(1))/(y(2) - y(1))
        j = max(1, min(int(position), size(y) - 1))
        share = position - j
        means = means + ((1 - share)*delta_r(j) + share*delta_r(j + 1))*[1.0_dp, wave]/[1.0_dp*phases, phases*amplitude]
      end do
    end function period_means

  end function conicity

  !> Rows -last..last of the geometry file, as far as the rigid wheelset stands on both rails; last is -1 where it stands
  !> nowhere.
  subroutine geometry_table(side, height, n, rows, last)
    type(side_type), intent(in) :: side(:)  !! left, right
    real(dp), intent(in) :: height          !! height of the axle centre at Z = 0 [m]
    integer, intent(in) :: n                !! largest possible `last`
    real(dp), intent(out) :: rows(:, -n:)   !! (column, -n..n)
    integer, intent(out) :: last
    integer :: i

    call geometry_at(side, height, geometry_pitch*[(i, i=-n, n)], rows(:12, :))
    last = -1
    do i = 0, n
      if (any(ieee_is_nan(rows(1, [-i, i])))) exit
      last = i
    end do
    if (last < 1) return
    do i = -last, last
      rows(13, i) = conicity(max(abs(i), 1)*geometry_pitch, rows(1, -last:last), rows(8, -last:last))
    end do
  end subroutine geometry_table

  !> Rows of the geometry file, without the conicity, at any y; NaN where the rigid wheelset does not stand on both rails.
  subroutine geometry_at(side, height, y, rows)
    type(side_type), intent(in) :: side(:) !! left, right
    real(dp), intent(in) :: height         !! height of the axle centre at Z = 0 [m]
    real(dp), intent(in) :: y(:)           !! [m]
    real(dp), intent(out) :: rows(:, :)    !! (column, y)
    real(dp) :: roll, z, station(2), r(2), x(2, 2), angle(2), radius(2), curvature
    integer :: i, k
    logical :: ok

    rows = ieee_value(1.0_dp, ieee_quiet_nan)
    do i = 1, size(y)
      call rigid_contact(side, y(i), roll, z, station, ok)
      if (.not. ok) cycle
      do k = 1, 2
        call curve_frame(side(k)%pair%wheel, station(k), r, angle(k), curvature)
        radius(k) = -r(2)
        x(:, k) = rolled(r, merge(roll, -roll, k == 1))
        angle(k) = angle(k) + merge(roll, -roll, k == 1)
      end do
      rows(:, i) = [y(i), roll, z - height, angle, radius, radius(1) - radius(2), &
        y(i) + x(1, 1), z + x(2, 1), y(i) - x(1, 2), z + x(2, 2)]
    end do
  end subroutine geometry_at

end module geometry_functions
