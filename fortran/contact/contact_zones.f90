!> Zones of a wheel: stretches that are tabulated by themselves.
!>
!> The wheel is cut at places that cannot touch: in the arcs whose curvature relative to the rail's point with the same normal
!> is negative, at the mean of the angles of the arc's ends. So a zone mostly holds one patch that moves smoothly, which makes
!> the elastic energy smooth in the pose. Zones are coordinates of the contact table. Whether a contact is called the tread's
!> or the flange's is another question, which the border of a side answers.
module contact_zones
  use kinds, only: degree, dp
  use wheel_rail_pair, only: pair_type, rail_curvature, window
  implicit none
  private
  public :: zone_type, side_type, find_zones, on_flange, border_station, max_zones, least_turn

  integer, parameter :: max_zones = 6

  !> Least angle of the flange's points of the wheel, unless the case has another one: 25 degrees [rad].
  real(dp), parameter, public :: usual_flange_angle = 0.4363_dp

  !> A stretch of the wheel between two cuts.
  type :: zone_type
    integer :: first = 0, last = 0     !! indices of its stations
    logical :: past_root = .false.     !! lies on the flange's side of the running tread, by the cut nearest to `root_angle`
    real(dp) :: alpha = 0              !! mean contact angle [rad]
    real(dp) :: pole(2) = 0            !! the point nearest to all contact normals, wheelset frame [m]
  end type zone_type

  !> One side of the wheelset, treated as a left side.
  type :: side_type
    type(pair_type) :: pair
    type(zone_type), allocatable :: zones(:)   !! ordered from the tread to the flange
    real(dp) :: clearance = 0          !! lateral way of the centred rigid wheelset until this flange touches [m]
    real(dp) :: border = 0             !! station of the wheel between flange and tread [m]
  end type side_type

  !> An arc of the wheel that cannot touch.
  type :: gap_type
    integer :: start = 0               !! index of the station at which the arc starts, on its tread side
    integer :: cut = 0                 !! index of the station at the mean of the angles of its ends
    real(dp) :: turn = 0               !! angle by which the normals of wheel and rail part over the arc [rad]
  end type gap_type

  real(dp), parameter :: root_angle = 10*degree   ! about where tread and flange of usual profiles part
  real(dp), parameter :: least_gap = 0.4e-3_dp    ! shortest arc that counts as a gap [m]
  ! Turn of an arc [rad]. Elastic patches on either side of a flatter one are one patch under load, which a cut would halve.
  real(dp), parameter :: least_turn = 0.03_dp
  real(dp), parameter :: least_zone = window/2     ! shortest zone [m]: the mean curvature does not show shorter arcs

contains

  !> Cut the wheel into zones, at places that cannot touch, from the field side of the tread to the flange.
  pure subroutine find_zones(pair, least, zones)
    type(pair_type), intent(in) :: pair
    real(dp), intent(in) :: least          !! arcs that turn by less are no cuts [rad]
    type(zone_type), allocatable, intent(out) :: zones(:)
    type(gap_type), allocatable :: gaps(:)
    integer :: running, split, parting, i

    running = count(pair%s <= pair%centred_station)
    split = running
    do while (split > pair%steepest .and. (pair%angle(split) < root_angle .or. split == running))
      split = split - 1
    end do
    call find_gaps(pair, running, least, gaps)
    call part_flange(pair, split, gaps, parting)

    allocate (zones(size(gaps) + 1))
    zones%first = [gaps%cut, 1]
    zones%last = [size(pair%s), gaps%cut]
    zones%past_root = zones%last <= parting
    do i = 1, size(zones)
      call set_pole(pair, zones(i))
    end do
  end subroutine find_zones

  !> The station [m] of a wheel at which its tread ends and its flange begins: from the running point, the first one that is at
  !> least as steep as `angle`. If none is, the flange begins at the steepest one, so that the flange's tip is always the flange's.
  pure real(dp) function border_station(pair, angle) result(s)
    type(pair_type), intent(in) :: pair
    real(dp), intent(in) :: angle          !! `flange_angle` of the case [rad]
    integer :: running, i

    running = count(pair%s <= pair%centred_station)
    i = pair%steepest - 1 + findloc(pair%angle(pair%steepest:running) >= angle, .true., 1, back=.true.)
    i = max(i, pair%steepest)
    s = pair%s(i)
    if (pair%angle(i) < angle .or. i == running) return
    associate (a => pair%angle(i:i + 1))
      s = s + (pair%s(i + 1) - s)*(a(1) - angle)/(a(1) - a(2))
    end associate
  end function border_station

  !> Whether the station s [m] of the wheel of a side is the flange's.
  pure logical function on_flange(side, s)
    type(side_type), intent(in) :: side
    real(dp), intent(in) :: s

    on_flange = s < side%border
  end function on_flange

  !> Find the arcs of negative relative curvature, from the running point to the flange face.
  pure subroutine find_gaps(pair, running, least, gaps)
    type(pair_type), intent(in) :: pair
    integer, intent(in) :: running         !! index of the running point
    real(dp), intent(in) :: least          !! turn of an arc [rad]
    type(gap_type), allocatable, intent(out) :: gaps(:)
    real(dp) :: curvature, turn
    integer :: start, cut, i

    allocate (gaps(0))
    start = 0
    turn = 0
    do i = running, pair%steepest, -1
      curvature = pair%curvature(i) + rail_curvature(pair, pair%angle(i))
      if (curvature < 0) then
        if (start == 0) start = i
        turn = turn - curvature*(pair%s(i + 1) - pair%s(i))
      else if (start > 0) then
        if (pair%s(start) - pair%s(i) > least_gap .and. turn > least) then
          cut = i - 1 + minloc(abs(pair%angle(i:start) - (pair%angle(i) + pair%angle(start))/2), 1)
          call add_gap(pair, gap_type(start, cut, turn), gaps)
        end if
        start = 0
        turn = 0
      end if
    end do
  end subroutine find_gaps

  !> Add a gap.  Where the last gap is too near, the one with the larger turn stays.  Where there is no room, as on profiles
  !> that conform, the gap with the least turn goes.
  pure subroutine add_gap(pair, gap, gaps)
    type(pair_type), intent(in) :: pair
    type(gap_type), intent(in) :: gap
    type(gap_type), allocatable, intent(inout) :: gaps(:)
    integer :: n, flattest

    n = size(gaps)
    if (n > 0) then
      if (pair%s(gaps(n)%cut) - pair%s(gap%cut) < least_zone) then
        if (gaps(n)%turn > gap%turn) return
        gaps = gaps(:n - 1)
      end if
    end if
    ! One cut more may be needed to part the flange.
    if (size(gaps) == max_zones - 2) then
      flattest = minloc(gaps%turn, 1)
      if (gaps(flattest)%turn > gap%turn) return
      gaps = [gaps(:flattest - 1), gaps(flattest + 1:)]
    end if
    gaps = [gaps, gap]
  end subroutine add_gap

  !> The cut that parts the tread from the flange. It is that of the last gap that starts before the root's angle, or that of the
  !> next gap, if its angle is nearer to the root's. Where no gap starts before the root's angle, it is that of a gap right
  !> behind it; where there is none either, a cut is added at the root's angle.
  pure subroutine part_flange(pair, split, gaps, parting)
    type(pair_type), intent(in) :: pair
    integer, intent(in) :: split           !! index of the station with the root's angle
    type(gap_type), allocatable, intent(inout) :: gaps(:)
    integer, intent(out) :: parting        !! index of the station of the cut
    integer :: i, before

    parting = 0
    before = count(gaps%start > split)
    if (before > 0) parting = gaps(before)%cut
    if (before < size(gaps)) then
      i = gaps(before + 1)%cut
      if (before > 0) then
        if (abs(pair%angle(i) - pair%angle(split)) < abs(pair%angle(parting) - pair%angle(split))) parting = i
      else if (pair%s(split) - pair%s(i) < least_zone) then
        parting = i
      end if
    end if
    if (parting > 0) return
    parting = split
    before = count(gaps%cut > split)
    gaps = [gaps(:before), gap_type(cut=split), gaps(before + 1:)]
  end subroutine part_flange

  !> Mean angle and pole of a zone from its stations that touch in service.
  pure subroutine set_pole(pair, zone)
    type(pair_type), intent(in) :: pair
    type(zone_type), intent(inout) :: zone
    real(dp), parameter :: service = 20e-3_dp   ! on either side of the running point [m]
    real(dp), parameter :: weight = 1e-3_dp     ! holds the pole of a straight line
    real(dp) :: middle(2), a(2, 2), b(2), t(2)
    integer :: j, lo, hi

    lo = max(zone%first, pair%steepest)
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
    ! Stations behind the flange tip whose normals point away from the rail do not touch in this zone.
    do while (zone%first < pair%steepest .and. pair%angle(zone%first) < zone%alpha - 80*degree)
      zone%first = zone%first + 1
    end do
  end subroutine set_pole

end module contact_zones
