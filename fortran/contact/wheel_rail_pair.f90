!> A wheel on its rail: both curves in the track frame, and their points with a given tangent angle.
!>
!> All of this is the LEFT wheel and rail (Y outward, Z up, roll phi lifts the left wheel).  The right side is
!> treated as a left side at (-y, z, -phi).  The yaw angle is zero, so the cross-section through the axle is the
!> whole contact geometry.
module wheel_rail_pair
  use body_influence, only: body_type
  use curve, only: curve_point, curve_type, near_interval
  use kinds, only: degree, dp
  implicit none
  private
  public :: pair_type, same_pair, rolled, wheel_station, rail_station, rail_curvature, rail_point, mean_curvature
  public :: mirror, least_cosine, window, angle_step

  !> A wheel and a rail, placed.
  type :: pair_type
    type(curve_type) :: rail           !! left rail in the track frame [m]
    type(curve_type) :: wheel          !! left wheel in the wheelset frame, origin at the axle centre [m]
    real(dp) :: axle_height = 0        !! Z of the axle of the centred wheelset that stands on rigid rails [m]
    real(dp) :: centred_station = 0    !! the running point: station at which the centred wheel touches [m]
    real(dp) :: gauge_face = 0         !! Y of the rail's gauge point [m]
    real(dp) :: crown = 0              !! Y of the rail's highest point [m]
    real(dp) :: flange_tip(2) = 0      !! lowest point of the wheel, wheelset frame [m]
    ! Stations of the wheel, from the flange to the field side.
    real(dp), allocatable :: s(:)          !! arc length [m]
    real(dp), allocatable :: r(:, :)       !! position, wheelset frame, (2, n) [m]
    real(dp), allocatable :: t(:, :)       !! dr/ds, (2, n)
    real(dp), allocatable :: angle(:)      !! tangent angle [rad]
    real(dp), allocatable :: curvature(:)  !! convex positive, mean over `window` [1/m]
    integer :: steepest = 0                !! index of the flange face's steepest station
    integer :: tread_end = 0               !! index of the tread's last station before a chamfer
    real(dp), allocatable :: rail_angle(:) !! tangent angle at the rail's knots, made monotone [rad]
    !> Curvature of the rail at the tangent angles from the last of `rail_angle` up, at equal steps, convex positive [1/m].
    real(dp), allocatable :: rail_curvature(:)
    !> Bodies whose elasticity differs from that of half-spaces; not allocated where all are half-spaces.
    type(body_type), allocatable :: bodies(:)
  end type pair_type

  !> Factors that mirror a pose, a velocity or a force (y, z, roll) from left to right.
  real(dp), parameter :: mirror(3) = [-1, 1, -1]
  real(dp), parameter :: window = 2e-3_dp   !! arc over which curvature is a mean: below the size of a patch [m]
  real(dp), parameter :: angle_step = 0.02_dp*degree   !! between the values of `rail_curvature` [rad]
  !> Least cosine of a contact angle, that of 87 degrees, in the relative curvature in rolling direction.
  real(dp), parameter :: least_cosine = 0.05_dp

contains

  !> Whether two placed pairs are the same, number by number.
  pure logical function same_pair(a, b) result(same)
    type(pair_type), intent(in) :: a, b

    same = size(a%wheel%a) == size(b%wheel%a) .and. size(a%rail%a) == size(b%rail%a)
    if (same) same = all(abs(a%wheel%a - b%wheel%a) <= 0) .and. all(abs(a%rail%a - b%rail%a) <= 0)
  end function same_pair

  !> A vector of the wheelset frame in the track frame.
  pure function rolled(r, roll) result(x)
    real(dp), intent(in) :: r(2), roll
    real(dp) :: x(2)

    x = [r(1)*cos(roll) - r(2)*sin(roll), r(1)*sin(roll) + r(2)*cos(roll)]
  end function rolled

  !> Station [m] of the wheel where the tangent angle falls below `angle` [rad], between the flange face and the
  !> tread's chamfer.
  pure real(dp) function wheel_station(pair, angle) result(s)
    type(pair_type), intent(in) :: pair
    real(dp), intent(in) :: angle

    s = pair%s(first_below(pair%angle, pair%steepest, pair%tread_end, angle))
  end function wheel_station

  !> Index after `first` of the first of falling values that is not above x, by bisection; `last` where all others are above.
  pure integer function first_below(values, first, last, x) result(high)
    real(dp), intent(in) :: values(:), x
    integer, intent(in) :: first, last
    integer :: low, middle

    low = first
    high = last
    do while (high - low > 1)
      middle = (low + high)/2
      if (values(middle) > x) then
        low = middle
      else
        high = middle
      end if
    end do
  end function first_below

  !> Curvature [1/m] of the rail where its tangent angle is `angle` [rad], convex positive; the first or last one where the
  !> rail has no such angle.
  pure real(dp) function rail_curvature(pair, angle) result(curvature)
    type(pair_type), intent(in) :: pair
    real(dp), intent(in) :: angle
    real(dp) :: x
    integer :: i, n

    n = size(pair%rail_curvature)
    x = (angle - pair%rail_angle(size(pair%rail_angle)))/angle_step
    x = max(0.0_dp, min(x, n - 1.0_dp))
    i = min(int(x), n - 2)
    curvature = pair%rail_curvature(i + 1) + (x - i)*(pair%rail_curvature(i + 2) - pair%rail_curvature(i + 1))
  end function rail_curvature

  !> The rail's point [m] and outward normal where its tangent angle is `angle` [rad].  `ok` is false where the rail
  !> has no such angle.
  pure subroutine rail_point(pair, angle, point, normal, ok)
    type(pair_type), intent(in) :: pair
    real(dp), intent(in) :: angle
    real(dp), intent(out) :: point(2), normal(2)
    logical, intent(out) :: ok
    real(dp) :: s, d1(2), d2(2)
    integer :: i

    ok = angle < pair%rail_angle(1) .and. angle > pair%rail_angle(size(pair%rail_angle))
    s = rail_station(pair, angle)
    i = near_interval(pair%rail, s)
    call curve_point(pair%rail, s, i, point, d1, d2)
    normal = [-d1(2), d1(1)]/norm2(d1)
  end subroutine rail_point

  !> Station [m] of the rail where its tangent angle is `angle` [rad]; the first or last one where it has no such angle.
  pure real(dp) function rail_station(pair, angle) result(station)
    type(pair_type), intent(in) :: pair
    real(dp), intent(in) :: angle
    real(dp) :: share
    integer :: i

    i = first_below(pair%rail_angle, 1, size(pair%rail_angle), angle)
    share = (pair%rail_angle(i - 1) - angle)/max(pair%rail_angle(i - 1) - pair%rail_angle(i), 1e-12_dp)
    share = max(0.0_dp, min(share, 1.0_dp))
    station = pair%rail%s(i - 1) + share*(pair%rail%s(i) - pair%rail%s(i - 1))
  end function rail_station

  !> d(angle)/ds [1/m], mean over a window about station s [m]: on a finer scale the curvature of profiles that were
  !> measured, or rounded to six decimals, is noise.
  pure real(dp) function mean_curvature(c, s) result(curvature)
    type(curve_type), intent(in) :: c
    real(dp), intent(in) :: s
    real(dp) :: r(2), a(2), b(2), d2(2)
    integer :: i

    i = near_interval(c, s)
    call curve_point(c, s - window/2, i, r, a, d2)
    call curve_point(c, s + window/2, i, r, b, d2)
    curvature = atan2(a(1)*b(2) - a(2)*b(1), dot_product(a, b))/window
  end function mean_curvature

end module wheel_rail_pair
