!> The generator of the contact table of a wheel/rail pair: it tabulates h and S of `contact_table` for every zone, on axes
!> that are halved until the force reaches the accuracy in all poses that a run can reach.
!>
!> For half-spaces S of the strips is multiplied by the ratio of both energies (`halfspace_correction`).
!>
!> Rows of one roll angle are sampled in several threads; none depends on another, so that the table is the same for any
!> number of threads.
module table_builder
  use grid_refinement, only: adapt, axis_errors, cell_errors, find_cell_errors, first_roll, first_u, grading, &
    gridded_function, grid_type, least_q, least_roll, least_u, new_grid, rules_type, scaled, united, weigh_errors
  use bspline, only: axis_type, fit_2d, fit_3d, new_axis
  use kinds, only: dp
  use contact_table, only: table_type
  use zone_tables, only: bound_heights, zone_table
  use progress, only: monitor_type, table_reached
  use halfspace_correction, only: multiply, solve_ratios
  use patch_grids, only: elements_type
  use service_poses, only: request_type
  use wheel_rail_pair, only: pair_type, rail_point
  use zone_influence, only: add_pairs
  use table_sampling, only: reference_shift, sample_row
  implicit none
  private
  public :: build_table

  !> S of strips or of Hertzian contacts, and h.
  type, extends(gridded_function) :: energy_type
  contains
    procedure :: sample
    procedure :: complete
    procedure :: find_errors
  end type energy_type

  integer, parameter :: first_points(3) = [31, 21, 15]          ! of u, roll, q
  integer, parameter :: most_rounds = 11
  integer, parameter :: most_values = 1800000   ! four and a half times those of new profiles
  ! Where wheel and rail have nearly equal radii a contact runs along millimetres of the wheel within some 0.01 mm of u.
  real(dp), parameter :: least_u_strip = least_u/4   ! [m]
  ! Where contact moves from one arc of the profiles to the next h bends sharply: a factor of safety.
  real(dp), parameter :: kink_factor = 3
  ! Strips are allowed smaller errors in rolling over: the crown and the corner of a rail touch at once there. With half-spaces
  ! the ratio errs more.
  real(dp), parameter :: rollover_factor = 0.35_dp
  ! Share of the accuracy that the spline of the strips, and that of the ratio, may use up in a cell.
  real(dp), parameter :: share = 0.4_dp
  ! Grids over half a patch. The energy has the square of the solver's error.
  integer, parameter :: elements_x = 5, elements_s = 20
  real(dp), parameter :: solver_tolerance = 2e-3_dp
  ! Shares of the work on a table of half-spaces that are done after strips, ratios and pairs.
  real(dp), parameter :: after_strips = 0.25_dp, after_ratios = 0.7_dp, after_pairs = 0.85_dp

contains

  !> Tabulate all zones of a side. `stopped` is true, and the table not complete, if the watcher asked to stop.
  subroutine build_table(request, key, table, stopped, watcher)
    type(request_type), intent(in) :: request
    character(*), intent(in) :: key
    type(table_type), intent(out), target :: table
    logical, intent(out) :: stopped
    class(monitor_type), intent(inout), optional :: watcher
    type(energy_type) :: energy
    type(grid_type), allocatable :: ratio(:)
    type(rules_type) :: rules
    type(axis_type) :: roll
    type(elements_type) :: elements
    integer :: z, n
    logical :: halfspace

    n = size(request%side%zones)
    halfspace = request%model == 'halfspace'
    table%key = key
    allocate (table%zones(n), energy%grid(n))
    energy%request = request
    energy%table => table
    energy%tolerance = request%accuracy*share
    if (.not. halfspace) energy%rollover_factor = rollover_factor
    rules = rules_type(request%most, most_values, most_rounds, common_roll=.true.)
    do z = 1, n
      call start_zone(energy, z)
    end do
    call table_reached(0.0_dp, watcher)
    call adapt(energy, rules, stopped, watcher)
    if (stopped) return
    call table_reached(merge(after_strips, after_pairs, halfspace), watcher)
    if (halfspace) then
      elements = elements_type(elements_x, elements_s, solver_tolerance, request%e_star, request%influence == 'flat', .true.)
      call solve_ratios(request, request%accuracy*share, elements, table, ratio, table%solutions, stopped, watcher)
      if (stopped) return
      call table_reached(after_ratios, watcher)
      roll = table%roll
      do z = 1, n
        roll = united(roll, ratio(z)%roll, least_roll)
      end do
      !$omp parallel do schedule(dynamic)
      do z = 1, n
        call multiply(ratio(z), table%roll, roll, table%zones(z))
      end do
      table%roll = roll
      if (request%influence /= 'apart') call add_pairs(request, elements, table, table%solutions, stopped, watcher)
      call table_reached(after_pairs, watcher)
    end if
  end subroutine build_table

  !> Place the coordinates of a zone, and choose the first axes.
  subroutine start_zone(energy, z)
    type(energy_type), intent(inout) :: energy
    integer, intent(in) :: z
    type(axis_type) :: u, roll, q
    real(dp) :: centre(2), corners(2)
    integer :: i, n(3)

    n = min(first_points, energy%request%most)
    associate (pair => energy%request%side%pair, zone => energy%request%side%zones(z), extent => energy%request%extent, &
      t => energy%table%zones(z))
      t%past_root = zone%past_root
      t%pole = zone%pole
      t%along = [cos(zone%alpha), sin(zone%alpha)]
      ! In the reference pose the zone just touches, where the wheelset is likely to be when it does.
      centre = [reference_shift(pair, zone), pair%axle_height]
      t%origin = [dot_product(centre + t%pole, t%along), dot_product(centre + t%pole, [-t%along(2), t%along(1)])]
      t%ceiling = pair%axle_height + t%pole(2) + extent%lift
      t%tip = tip_coordinate(pair, t, zone%first)
      corners = [-extent%lateral - centre(1), extent%lateral - centre(1)]*t%along(1) &
        + [-extent%drop, extent%lift]*t%along(2)
      u = first_u(corners(1), corners(2), zone%past_root, n(1))
      roll = first_roll(extent, n(2))
      q = new_axis([(((i - 1)/real(n(3) - 1, dp))**grading*sqrt(extent%depth), i=1, n(3))])
    end associate
    energy%grid(z) = new_grid(u, roll, q, [least_u_strip, least_roll, least_q], 0.0_dp)
  end subroutine start_zone

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

  !> Compute h and S of zone z at the j-th roll angle.
  subroutine sample(this, z, j)
    class(energy_type), intent(inout) :: this
    integer, intent(in) :: z, j
    logical, allocatable :: known(:)

    associate (g => this%grid(z))
      known = all(g%known(:, :, j), 1)
      call sample_row(this%request, z, this%table%zones(z), g%roll%x(j), g%u%x, g%q%x, known, g%h(:, j), g%f(:, :, j))
      g%known(:, :, j) = spread(known, 1, g%q%n)
    end associate
  end subroutine sample

  !> Fit the splines of the table.
  subroutine complete(this)
    class(energy_type), intent(inout) :: this
    integer :: z

    this%table%roll = this%grid(1)%roll
    !$omp parallel do
    do z = 1, size(this%grid)
      associate (t => this%table%zones(z), g => this%grid(z))
        t%u = g%u
        t%q = g%q
        call fit_2d(g%roll, g%u, transpose(g%h), t%h)
        call fit_3d(g%q, g%roll, g%u, reshape(g%f, [g%q%n, g%roll%n, g%u%n], order=[1, 3, 2]), t%s)
        call bound_heights(t)
      end associate
    end do
  end subroutine complete

  !> Estimate the errors of S and of h. The force is 2.5 q^3 S, if slopes of S are left aside, and its derivative with respect
  !> to the penetration 3.75 q S.
  subroutine find_errors(this, z, error)
    class(energy_type), intent(inout) :: this
    integer, intent(in) :: z
    type(axis_errors), intent(out) :: error
    real(dp), allocatable :: force(:, :, :), weight(:, :, :), value_h(:, :), slope_h(:, :)
    integer :: i, j

    associate (g => this%grid(z), h => this%grid(z)%h)
      allocate (weight, mold=g%f)
      allocate (value_h, slope_h, mold=h)
      force = scaled(g%f, 2.5_dp*g%q%x**3)
      call weigh_errors(this, z, force, weight)
      do j = 1, g%roll%n
        do i = 1, g%u%n
          value_h(i, j) = max(0.0_dp, maxval(kink_factor*3.75_dp*g%q%x*g%f(:, i, j)*weight(:, i, j)))
          slope_h(i, j) = max(0.0_dp, maxval(kink_factor*force(:, i, j)*weight(:, i, j)))
        end do
      end do
      weight = scaled(weight, 2.5_dp*g%q%x**3)
      call find_cell_errors(g, weight, this%request%extent%lever, error)
      error%u = max(error%u, cell_errors(g%u, h, value_h, slope_h))
      error%roll = max(error%roll, cell_errors(g%roll, transpose(h), transpose(value_h), &
        transpose(slope_h)/this%request%extent%lever))
    end associate
  end subroutine find_errors

end module table_builder
