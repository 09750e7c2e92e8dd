!> Where the points of a contact table lie. The rule knows the geometry alone, so that tables of a pair have the same points
!> whatever runs they serve.
!>
!> Points of u are close where the contact runs along the wheel fast as the wheel shifts: in the throat of a flange a shift of 1 mm
!> moves it by 10 mm, and where it moves from one arc of the profiles to the next it jumps.
module table_layout
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use bspline, only: axis_type, new_axis
  use contact_law, only: law_type
  use contact_table, only: table_type
  use contact_zones, only: zone_type
  use kinds, only: dp
  use station_scan, only: new_scan, scan_type, touch
  use wheel_rail_pair, only: pair_type, rail_point, rolled
  use zone_tables, only: zone_table
  use zone_parts, only: border_of
  implicit none
  private
  public :: lay_out

  ! In a cell of u the contact moves by `travel` along the wheel, unless the cell were shorter than `least_travel` or longer than
  ! `longest_u` [m].
  real(dp), parameter :: travel = 1e-3_dp, least_travel = 0.05e-3_dp, longest_u = 1e-3_dp
  ! Where h has a kink its spline is above it, by `rounding` at most, so that the contact closes too early by that; but no cell is
  ! shorter than `shortest_u` [m].
  real(dp), parameter :: rounding = 3e-6_dp, shortest_u = 0.01e-3_dp
  ! The path of the contact is followed in steps over the shifts from which a flange is reached [m].
  real(dp), parameter :: step = 0.5e-3_dp, reach = 20e-3_dp
  real(dp), parameter :: outer_u = 0.4e-3_dp      ! beyond [m]
  ! A kink of the path has another place at another roll angle: the path is followed at so many to either side, and cells are short
  ! as far as this from a kink [m].
  integer, parameter :: path_rolls = 2
  real(dp), parameter :: widening = 0.5e-3_dp
  ! h has every fourth point of S, so that S makes up smoothly for the kinks of h, which cells of h round off.
  integer, parameter :: stride = 4
  ! Cells of the roll angle, where the wheelset stands on both rails and where it goes over one [rad].
  real(dp), parameter :: shortest_roll = 2e-3_dp, longest_roll = 8e-3_dp, upright = 0.02_dp
  ! The root of the penetration: its points, and the first one that is solved, of the last one. Smaller patches would show
  ! the rounding of the profiles' points.
  integer, parameter :: points_q = 20
  real(dp), parameter :: first_q = 0.047_dp, grading = 1.25_dp
  ! The influence of zones on each other hardly depends on the load. Its points of u are those of h that are `least_pair_u` apart
  ! [m]; its cells of the roll angle [rad] and its points of the penetration, relative to the largest, are these.
  real(dp), parameter :: least_pair_u = 0.3e-3_dp, pair_roll = 10e-3_dp
  real(dp), parameter :: pair_depths(*) = [0.0_dp, 0.01_dp, 0.03_dp, 0.06_dp, 0.1_dp, 0.16_dp, 0.24_dp, 0.34_dp, 0.45_dp, 0.6_dp, &
    0.8_dp, 1.0_dp]
  ! These cells are for this accuracy; the error of a spline goes with the fourth power of its cells.
  real(dp), parameter :: usual_accuracy = 2e-3_dp

contains

  !> Make a table for a law without any value.
  subroutine lay_out(law, key, table)
    type(law_type), intent(in) :: law
    character(*), intent(in) :: key
    type(table_type), intent(out) :: table
    real(dp) :: fineness, nan
    integer :: i, j, n, z

    nan = ieee_value(1.0_dp, ieee_quiet_nan)
    fineness = max(0.5_dp, min((law%accuracy/usual_accuracy)**0.25_dp, 2.0_dp))
    table%key = key
    table%law = law
    table%border = border_of(law%side%pair, law%side%border)
    table%roll = new_axis(mirrored(growing(law%extent%roll, fineness*shortest_roll, fineness*longest_roll, upright)))
    n = size(law%side%zones)
    allocate (table%zones(n))
    do z = 1, n
      associate (t => table%zones(z), n_roll => table%roll%n)
        call place_zone(law, law%side%zones(z), t)
        t%u = new_axis(points_of_u(law, law%side%zones(z), t, fineness))
        t%u_h = new_axis([t%u%x(:t%u%n - 2:stride), t%u%high])
        i = nint(points_q/fineness)
        t%q = new_axis(sqrt(law%extent%depth)*[0.0_dp, (first_q + (1 - first_q)*((j - 2)/real(i - 2, dp))**grading, j=2, i)])
        allocate (t%h_at(n_roll, t%u_h%n), t%s_at(t%q%n, n_roll, t%u%n), t%h(n_roll + 2, t%u_h%n + 2), &
          t%s(t%q%n + 2, n_roll + 2, t%u%n + 2), source=nan)
        allocate (t%h_bound(n_roll - 1, t%u_h%n - 1), source=huge(nan))
      end associate
    end do
    if (law%model /= 'halfspace' .or. law%influence == 'apart') return
    allocate (table%pairs(n*(n - 1)/2))
    n = 0
    do j = 2, size(table%zones)
      do i = 1, j - 1
        n = n + 1
        associate (pair => table%pairs(n), u => table%zones(j)%u_h)
          pair%zone = [i, j]
          pair%u = new_axis(thinned(u%x, least_pair_u))
          pair%roll = new_axis(mirrored(growing(law%extent%roll, pair_roll, 4*pair_roll, upright)))
          pair%p = new_axis(pair_depths*law%extent%depth)
          allocate (pair%c_at(pair%p%n, pair%roll%n, pair%u%n), pair%c(pair%p%n + 2, pair%roll%n + 2, pair%u%n + 2), source=nan)
        end associate
      end do
    end do
  end subroutine lay_out

  !> Place the coordinates of a zone. In the reference pose the zone just touches, where the wheelset is likely to be when it does.
  subroutine place_zone(law, zone, t)
    type(law_type), intent(in) :: law
    type(zone_type), intent(in) :: zone
    type(zone_table), intent(inout) :: t
    real(dp) :: centre(2)

    t%past_root = zone%past_root
    t%pole = zone%pole
    t%along = [cos(zone%alpha), sin(zone%alpha)]
    centre = [reference_shift(law%side%pair, zone), law%side%pair%axle_height]
    t%origin = [dot_product(centre + t%pole, t%along), dot_product(centre + t%pole, [-t%along(2), t%along(1)])]
    t%ceiling = law%side%pair%axle_height + t%pole(2) + law%extent%lift
    t%tip = tip_coordinate(law%side%pair, t, zone%first)
    t%u%low = (-law%extent%lateral - centre(1))*t%along(1) - law%extent%drop*t%along(2)
    t%u%high = (law%extent%lateral - centre(1))*t%along(1) + law%extent%lift*t%along(2)
  end subroutine place_zone

  !> Points of u of a zone [m].
  function points_of_u(law, zone, t, fineness) result(u)
    type(law_type), intent(in) :: law
    type(zone_type), intent(in) :: zone
    type(zone_table), intent(in) :: t
    real(dp), intent(in) :: fineness       !! factor on the length of cells
    real(dp), allocatable :: u(:)
    integer, parameter :: n = nint(reach/step), wide = nint(widening/step)
    real(dp) :: station(-n:n), h(-n:n), bend(-n:n), cell(-n:n), across(2), centre(2), shift, move, roll, x
    type(scan_type) :: scan
    logical :: ok(-n:n)
    integer :: i, j, k

    scan = new_scan(law%side%pair)
    across = [-t%along(2), t%along(1)]
    cell = longest_u
    do j = -path_rolls, path_rolls
      roll = upright*j/path_rolls
      shift = 0.02_dp
      do i = -n, n
        scan%fresh = i == -n
        centre = (t%origin(1) + i*step)*t%along + (t%origin(2) + shift)*across - rolled(t%pole, roll)
        call touch(law%side%pair, scan, zone%first, zone%last, centre, roll, zone%alpha, move, station(i), ok(i))
        if (ok(i)) shift = shift + move
        h(i) = shift
      end do
      bend = 0
      do i = -n + 1, n - 2
        if (all(ok(i - 1:i + 2))) bend(i) = abs(h(i + 2) - h(i + 1) - h(i) + h(i - 1))/step
      end do
      do i = -n, n - 1
        if (.not. (ok(i) .and. ok(i + 1))) cycle
        x = max(least_travel, travel*step/max(abs(station(i + 1) - station(i)), tiny(x)))
        ! A cell of h, which is `stride` times as long, rounds a kink by an eighth of its length times the change of slope.
        x = max(shortest_u, min(x, 8*rounding/(stride*max(bend(i), tiny(x)))))
        do k = max(-n, i - wide), min(n, i + 1 + wide)
          cell(k) = min(cell(k), x)
        end do
      end do
    end do
    ! Cells grow by at most a half from one to the next.
    do i = -n + 1, n
      cell(i) = min(cell(i), cell(i - 1) + 0.5_dp*step)
    end do
    do i = n - 1, -n, -1
      cell(i) = min(cell(i), cell(i + 1) + 0.5_dp*step)
    end do
    cell = fineness*cell
    u = [t%u%low]
    do
      x = max(-reach, min(u(size(u)), reach))/step
      i = min(floor(x), n - 1)
      x = u(size(u)) + merge(cell(i) + (x - i)*(cell(i + 1) - cell(i)), outer_u, abs(u(size(u))) < reach)
      if (x > t%u%high) exit
      u = [u, x]
    end do
    u = [u, x]
  end function points_of_u

  !> Points from 0 to `last` whose distances are about `short` up to `near` and grow with the distance up to `long`.
  pure function growing(last, short, long, near) result(x)
    real(dp), intent(in) :: last, short, long, near
    real(dp), allocatable :: x(:)

    x = [0.0_dp]
    do while (x(size(x)) < last)
      x = [x, x(size(x)) + max(short, min(short*x(size(x))/near, long))]
    end do
    x = x*(last/x(size(x)))
  end function growing

  !> The first and the last of some points, and those between that are not nearer than `least` to one that is taken before.
  pure function thinned(x, least) result(few)
    real(dp), intent(in) :: x(:), least
    real(dp), allocatable :: few(:)
    integer :: i

    few = [x(1)]
    do i = 2, size(x) - 1
      if (x(i) - few(size(few)) >= least .and. x(size(x)) - x(i) >= least) few = [few, x(i)]
    end do
    few = [few, x(size(x))]
  end function thinned

  !> Points on both sides of 0 from those on one side, whose first one is 0.
  pure function mirrored(x)
    real(dp), intent(in) :: x(:)
    real(dp) :: mirrored(2*size(x) - 1)

    mirrored = [-x(size(x):2:-1), x]
  end function mirrored

  !> Return u of a zone at roll angle 0 where it touches on the flange's tip at half the steepest angle; huge if the zone, with
  !> the first station `first`, does not reach so far.
  real(dp) function tip_coordinate(pair, t, first) result(u)
    type(pair_type), intent(in) :: pair
    type(zone_table), intent(in) :: t
    integer, intent(in) :: first
    real(dp) :: point(2), normal(2)
    integer :: i
    logical :: ok

    u = huge(u)
    if (first >= pair%steepest) return
    i = findloc(pair%angle(:pair%steepest) < pair%angle(pair%steepest)/2, .true., 1, back=.true.)
    if (i < first) return
    call rail_point(pair, pair%angle(i), point, normal, ok)
    if (ok) u = dot_product(point - pair%r(:, i) + t%pole, t%along) - t%origin(1)
  end function tip_coordinate

  !> Return the lateral shift of the wheelset at which a zone is expected to touch [m]: 0 for the tread; for a flange zone
  !> the shift at which the zone is as low as the tread in running.
  real(dp) function reference_shift(pair, zone) result(y)
    type(pair_type), intent(in) :: pair
    type(zone_type), intent(in) :: zone
    type(scan_type) :: scan
    real(dp) :: low, high, shift, station
    integer :: iter
    logical :: ok

    y = 0
    if (.not. zone%past_root) return
    scan = new_scan(pair)
    low = -0.02_dp
    high = 0.04_dp
    do iter = 1, 20
      y = (low + high)/2
      scan%fresh = .true.
      call touch(pair, scan, zone%first, zone%last, [y, pair%axle_height + 0.03_dp], 0.0_dp, 0.0_dp, &
        shift, station, ok)
      if (ok .and. shift > -0.03_dp) then
        high = y
      else
        low = y
      end if
    end do
  end function reference_shift

end module table_layout
