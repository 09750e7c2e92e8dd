!> Rigid contact geometry of the whole wheelset: where it stands on both rails at a lateral displacement, the flange
!> clearance, and contact angles, rolling radii and contact points there.
module rigid_geometry
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use root_bracket, only: bracket_type
  use contact_zones, only: on_flange, side_type
  use curve, only: curve_frame
  use station_scan, only: new_scan, scan_type, touch
  use wheel_rail_pair, only: pair_type, rolled
  use kinds, only: dp
  implicit none
  private
  public :: clearance, rigid_contact, geometry_at

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

  !> Roll angle and height at which the rigid wheelset stands on both rails: the least roll angle where there are several.
  !> `ok` is false where the wheelset does not stand on both rails.
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

  !> Lateral displacement y [m] at which the contact of the left wheel of the rigid wheelset moves, or jumps, onto the flange. `ok`
  !> is false where there is none between 0 and 0.05 m.
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
      real(dp) :: roll, z, station(2)
      logical :: ok

      call rigid_contact(side, y, roll, z, station, ok)
      touches_flange = .not. ok
      if (ok) touches_flange = on_flange(side(1), station(1))
    end function touches_flange

  end subroutine clearance

  !> Geometry functions at any y: Y, roll, Z, contact angles left and right, rolling radii, their difference, contact points y, z
  !> left and right; NaN where the rigid wheelset does not stand on both rails.
  subroutine geometry_at(side, height, y, rows)
    type(side_type), intent(in) :: side(:) !! left, right
    real(dp), intent(in) :: height         !! height of the axle centre at Z = 0 [m]
    real(dp), intent(in) :: y(:)           !! [m]
    real(dp), intent(out) :: rows(:, :)    !! (12, y)
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

end module rigid_geometry
