!> The generator of the contact table of a wheel/rail pair: it tabulates h and S of
!> `contact_table` for every zone, on axes that it halves where the splines miss the accuracy that
!> is asked for, in the force of poses that a run can come to.
!>
!> For half-spaces S of the strips is multiplied by the ratio of both energies (`halfspace_correction`).
!>
!> Rows of one roll angle are sampled in several threads; none depends on another, so that the
!> table is the same for any number of them.
module table_builder
  use, intrinsic :: iso_fortran_env, only: int64
  use bspline, only: axis_type, fit_2d, fit_3d, graded_points, new_axis
  use contact_zones, only: zone_type
  use wheel_rail_pair, only: pair_type
  use kinds, only: dp
  use contact_table, only: bound_heights, table_type, zone_pose, zone_table
  use progress, only: goes_on, monitor_type, share_of_round
  use halfspace_correction, only: multiply, ratio_type, solve_ratios
  use service_poses, only: error_allowance, extent_type, find_reach, force_floor, hertz_factor, roll_lever
  use axis_refinement, only: cell_errors, fine_flange, fine_roll, fine_tread, grading, halve_cells, least_q, least_roll, least_u, &
    spread_roll, spread_u, united
  use table_sampling, only: reference_shift, sample_row
  implicit none
  private
  public :: build_table, build_memory

  !> Values of a zone at the points of its axes.
  type :: samples_type
    type(axis_type) :: u, q
    real(dp), allocatable :: h(:, :)       !! (u, roll) [m]
    real(dp), allocatable :: s(:, :, :)    !! (q, u, roll)
    logical, allocatable :: good(:, :)     !! (u, roll): sampled
  end type samples_type

  integer, parameter :: first_u = 31, first_roll = 21, first_q = 15     ! points
  integer, parameter :: most_rounds = 9, rounds_of_q = 4, rounds_of_hertz = 4
  ! Where contact moves from one arc of the profiles to the next h bends sharply, and misses more than is estimated.
  real(dp), parameter :: of_kinks = 3
  ! Errors of strips going over, of those that are allowed: the crown and the corner of a rail touch at once there.
  real(dp), parameter :: stricter_over = 0.35_dp
  ! Shares of the accuracy that the splines of strips and of the ratio may use up.
  real(dp), parameter :: share_strip = 0.7_dp, share_ratio = 0.3_dp

contains

  !> Tabulate all zones of a pair for a normal model, to `accuracy` of max(force, 5 kN), with at most `most` points
  !> along u, roll and the root of the depth.
  subroutine build_table(pair, zones, model, e_star, extent, accuracy, most, key, table, watcher)
    type(pair_type), intent(in) :: pair
    type(zone_type), intent(in) :: zones(:)
    character(*), intent(in) :: model      !! 'strip', 'hertz' or 'halfspace'
    real(dp), intent(in) :: e_star         !! [Pa]
    type(extent_type), intent(in) :: extent
    real(dp), intent(in) :: accuracy
    integer, intent(in) :: most(3)
    character(*), intent(in) :: key
    type(table_type), intent(out) :: table
    class(monitor_type), intent(inout), optional :: watcher
    type(samples_type) :: values(size(zones))
    type(ratio_type) :: ratio(size(zones))
    character(:), allocatable :: law
    type(axis_type) :: roll
    real(dp) :: work(2)                    ! its share of the whole work, from and to
    integer :: round, z, solutions(2)
    logical :: finer, stopped

    law = model
    if (model == 'halfspace') law = 'strip'
    work = [0.0_dp, merge(0.4_dp, 1.0_dp, model == 'halfspace')]
    table%key = key
    allocate (table%zones(size(zones)))
    roll = new_axis(graded_points(-extent%roll, extent%roll, 0.0_dp, fine_roll, min(first_roll, most(2))))
    do z = 1, size(zones)
      call start_zone(pair, zones(z), extent, most, table%zones(z), values(z))
      call resize(values(z), values(z)%u, values(z)%q, roll, roll)
    end do
    stopped = .false.
    do round = 1, most_rounds
      call sample_rows(pair, zones, law, e_star, table, roll, values, share_of_round(work, round), stopped, watcher)
      if (stopped) return
      call fit(values, roll, table)
      ! One Hertz spring jumps with the station: no cell is small enough.
      if (round == merge(rounds_of_hertz, most_rounds, model == 'hertz')) exit
      ! Of half-spaces the ratio needs the points more.
      call refine_axes(pair, extent, e_star, accuracy*share_strip, merge(1.0_dp, stricter_over, model == 'halfspace'), &
        most, round <= rounds_of_q, table, values, roll, finer)
      if (.not. finer) exit
    end do
    if (model == 'halfspace') then
      call solve_ratios(pair, zones, e_star, extent, accuracy*share_ratio, most, table, ratio, &
        solutions, [work(2), 1.0_dp], stopped, watcher)
      if (stopped) return
      table%solutions = solutions
      do z = 1, size(zones)
        roll = united(roll, ratio(z)%roll, least_roll, most(2))
      end do
      !$omp parallel do schedule(dynamic)
      do z = 1, size(zones)
        call multiply(ratio(z), roll, most, table%zones(z))
      end do
    end if
    if (present(watcher)) call watcher%tell('table', 1.0_dp)
  end subroutine build_table

  !> Where the zone's coordinates are, and its first axes.
  subroutine start_zone(pair, zone, extent, most, t, v)
    type(pair_type), intent(in) :: pair
    type(zone_type), intent(in) :: zone
    type(extent_type), intent(in) :: extent
    integer, intent(in) :: most(3)
    type(zone_table), intent(inout) :: t
    type(samples_type), intent(inout) :: v
    real(dp) :: centre(2), corners(2)
    integer :: i, n

    t%flange = zone%flange
    t%pole = zone%pole
    t%along = [cos(zone%alpha), sin(zone%alpha)]
    ! Reference pose: the zone just touches, where the wheelset is likely to be
    ! when it does.
    centre = [reference_shift(pair, zone), pair%axle_height]
    t%origin = [dot_product(centre + t%pole, t%along), dot_product(centre + t%pole, [-t%along(2), t%along(1)])]
    t%ceiling = pair%axle_height + t%pole(2) + extent%lift
    corners = [-extent%lateral - centre(1), extent%lateral - centre(1)]*t%along(1) &
      + [-extent%drop, extent%lift]*t%along(2)
    v%u = new_axis(graded_points(corners(1), corners(2), 0.0_dp, merge(fine_flange, fine_tread, zone%flange), &
      min(first_u, most(1))))
    n = min(first_q, most(3))
    v%q = new_axis([(((i - 1)/real(n - 1, dp))**grading*sqrt(extent%depth), i=1, n)])
  end subroutine start_zone

  !> Values on other axes: those at common points are kept, unless q has others.
  pure subroutine resize(v, u, q, roll, new_roll)
    type(samples_type), intent(inout) :: v
    type(axis_type), intent(in) :: u, q, roll, new_roll
    real(dp), allocatable :: h(:, :), s(:, :, :)
    logical, allocatable :: good(:, :)
    integer :: i, j, k, l

    allocate (h(u%n, new_roll%n), s(q%n, u%n, new_roll%n), good(u%n, new_roll%n))
    good = .false.
    h = -1
    s = 0
    if (allocated(v%h)) then
      l = 1
      do j = 1, new_roll%n
        if (new_roll%x(j) > roll%x(l)) l = l + 1
        if (new_roll%x(j) < roll%x(l)) cycle
        k = 1
        do i = 1, u%n
          if (u%x(i) > v%u%x(k)) k = k + 1
          if (u%x(i) < v%u%x(k)) cycle
          h(i, j) = v%h(k, l)
          if (q%n /= v%q%n) cycle
          s(:, i, j) = v%s(:, k, l)
          good(i, j) = v%good(k, l)
        end do
      end do
    end if
    v%u = u
    v%q = q
    call move_alloc(h, v%h)
    call move_alloc(s, v%s)
    call move_alloc(good, v%good)
  end subroutine resize

  !> Sample what is not there.
  subroutine sample_rows(pair, zones, law, e_star, table, roll, values, work, stopped, watcher)
    type(pair_type), intent(in) :: pair
    type(zone_type), intent(in) :: zones(:)
    character(*), intent(in) :: law
    real(dp), intent(in) :: e_star
    type(table_type), intent(in) :: table
    type(axis_type), intent(in) :: roll
    type(samples_type), intent(inout) :: values(:)
    real(dp), intent(in) :: work(2)
    logical, intent(out) :: stopped
    class(monitor_type), intent(inout), optional :: watcher
    integer :: row, z, j, done

    stopped = .false.
    done = 0
    !$omp parallel do schedule(dynamic) private(z, j) shared(done, stopped)
    do row = 1, size(zones)*roll%n
      z = (row - 1)/roll%n + 1
      j = row - (z - 1)*roll%n
      if (.not. goes_on(work, done, size(zones)*roll%n, stopped, watcher)) cycle
      call sample_row(pair, zones(z), law, e_star, table%zones(z), roll%x(j), values(z)%u%x, values(z)%q%x, &
        values(z)%good(:, j), values(z)%h(:, j), values(z)%s(:, :, j))
    end do
  end subroutine sample_rows

  !> The splines through the values.
  subroutine fit(values, roll, table)
    type(samples_type), intent(in) :: values(:)
    type(axis_type), intent(in) :: roll
    type(table_type), intent(inout) :: table
    integer :: z

    !$omp parallel do
    do z = 1, size(values)
      associate (t => table%zones(z), v => values(z))
        t%u = v%u
        t%roll = roll
        t%q = v%q
        call fit_2d(roll, v%u, transpose(v%h), t%h)
        call fit_3d(v%q, roll, v%u, reshape(v%s, [v%q%n, roll%n, v%u%n], order=[1, 3, 2]), t%s)
        call bound_heights(t)
      end associate
    end do
  end subroutine fit

  !> Halve the cells of all axes in which the force errs by more than `aim`; `over`: of what is allowed going over.
  subroutine refine_axes(pair, extent, e_star, aim, over, most, depths, table, values, roll, finer)
    type(pair_type), intent(in) :: pair
    type(extent_type), intent(in) :: extent
    real(dp), intent(in) :: e_star, aim, over
    integer, intent(in) :: most(3)
    logical, intent(in) :: depths          !! whether q may be halved, too
    type(table_type), intent(in) :: table
    type(samples_type), intent(inout) :: values(:)
    type(axis_type), intent(inout) :: roll
    logical, intent(out) :: finer
    type(axis_type) :: u(size(values)), q(size(values)), old
    real(dp) :: of_roll(roll%n - 1, size(values))
    logical :: any_finer(3, size(values))
    integer :: z

    any_finer = .false.
    of_roll = 0
    !$omp parallel do schedule(dynamic)
    do z = 1, size(values)
      call refine_zone(z)
    end do
    old = roll
    call halve_cells(roll, maxval(of_roll, 2), least_roll, most(2), finer)
    finer = finer .or. any(any_finer)
    do z = 1, size(values)
      if (finer) call resize(values(z), u(z), q(z), old, roll)
    end do

  contains

    subroutine refine_zone(z)
      integer, intent(in) :: z
      real(dp), allocatable, dimension(:, :, :) :: by_value, by_slope, scale
      real(dp), allocatable :: of_u(:), of_q(:), flat(:, :), of_h(:, :), tilt_h(:, :)
      real(dp) :: depth, force, other, pose(3), allowance
      integer :: i, j, m, nq, nu, nr
      logical :: within

      associate (v => values(z))
        nq = v%q%n
        nu = v%u%n
        nr = roll%n
        allocate (by_value(nq, nu, nr), by_slope(nq, nu, nr), scale(nq, nu, nr), of_h(nu, nr), tilt_h(nu, nr))
        scale = 0
        of_h = 0
        tilt_h = 0
        do j = 1, nr
          do i = 1, nu
            if (.not. v%good(i, j)) cycle
            do m = 2, nq
              depth = v%q%x(m)**2
              pose = zone_pose(table%zones(z), v%u%x(i), v%h(i, j) - depth, roll%x(j))
              allowance = error_allowance(pair, extent, pose, .false.)
              if (allowance <= 0) cycle
              if (allowance > 1) allowance = over*allowance
              call find_reach(table, extent, z, depth, pose, .false., within, other)
              if (.not. within) cycle
              force = 2.5_dp*v%q%x(m)**3*v%s(m, i, j)
              ! The other's force as Hertz's on a radius of about 0.3 m.
              scale(m, i, j) = 1/(aim*allowance*max(force, force_floor, hertz_factor*e_star*max(other, 0.0_dp)**1.5_dp))
              of_h(i, j) = max(of_h(i, j), of_kinks*3.75_dp*v%q%x(m)*v%s(m, i, j)*scale(m, i, j))
              tilt_h(i, j) = max(tilt_h(i, j), of_kinks*force*scale(m, i, j))
            end do
          end do
        end do
        do m = 1, nq
          by_value(m, :, :) = 2.5_dp*v%q%x(m)**3*scale(m, :, :)
          by_slope(m, :, :) = v%q%x(m)**5*scale(m, :, :)
        end do
        ! Along u: S with (u, q roll); h.
        of_u = max(maxval(cell_errors(v%u, spread_u(v%s), spread_u(by_value), spread_u(by_slope)), 2), &
          maxval(cell_errors(v%u, v%h, of_h, tilt_h), 2))
        of_roll(:, z) = max(maxval(cell_errors(roll, spread_roll(v%s), spread_roll(by_value), &
          spread_roll(by_slope)/roll_lever), 2), &
          maxval(cell_errors(roll, transpose(v%h), transpose(of_h), transpose(tilt_h)/roll_lever), 2))
        u(z) = v%u
        q(z) = v%q
        call halve_cells(u(z), of_u, least_u, most(1), any_finer(1, z))
        if (.not. depths) return
        do m = 1, nq
          by_slope(m, :, :) = 0.5_dp*v%q%x(m)**4*scale(m, :, :)
        end do
        flat = reshape(v%s, [nq, nu*nr])
        of_q = maxval(cell_errors(v%q, flat, reshape(by_value, [nq, nu*nr]), reshape(by_slope, [nq, nu*nr])), 2)
        call halve_cells(q(z), of_q, least_q, most(3), any_finer(3, z))
      end associate
    end subroutine refine_zone

  end subroutine refine_axes

  !> Memory that building a table takes at most [bytes]: of the pairs that were measured, half-spaces of S1002 on 60E1
  !> took most, 243 MB at an accuracy of 1e-3 and 403 MB at 1e-4.
  elemental integer(int64) function build_memory(accuracy)
    real(dp), intent(in) :: accuracy       !! of the force, relative

    build_memory = nint(250e6_dp*(1e-3_dp/accuracy)**0.25_dp, int64)
  end function build_memory

end module table_builder