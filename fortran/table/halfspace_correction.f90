!> Energy of half-spaces over that of strips, by which S of the strips is multiplied: a smooth
!> function c(u, phi, q) of the pose, because the strips already carry the geometry.
!>
!> It is solved at the points of axes of its own, coarser than those of S, which are halved where
!> the spline through it misses the accuracy asked for; of the new points those are solved around which it does,
!> the spline gives the others.
module halfspace_correction
  use bspline, only: axis_type, fit_2d, fit_3d, graded_points, new_axis, spline_2d_at, spline_3d_at
  use contact_zones, only: zone_type
  use wheel_rail_pair, only: pair_type
  use kinds, only: dp
  use halfspace_patches, only: elements_type, new_elements
  use contact_table, only: bound_heights, table_type, zone_pose, zone_table
  use progress, only: goes_on, monitor_type, share_of_round
  use service_poses, only: error_allowance, extent_type, find_reach, force_floor, hertz_factor, roll_lever
  use axis_refinement, only: cell_errors, fine_flange, fine_roll, fine_tread, grading, halve_cells, least_q, least_roll, least_u, &
    spread_roll, spread_u, united
  use table_sampling, only: sample_ratios
  implicit none
  private
  public :: ratio_type, solve_ratios, multiply

  !> Ratio of half-space to strip energy at the points of axes of its own.
  type :: ratio_type
    type(axis_type) :: u, roll, q
    real(dp), allocatable :: c(:, :, :)      !! (q, u, roll)
    logical, allocatable :: open(:, :, :)    !! to be solved, if a run comes there
    logical, allocatable :: there(:, :, :)   !! solved, or between such points
    real(dp), allocatable :: area(:, :, :, :)   !! pressed by a single patch: (3, q, u, roll)
  end type ratio_type

  integer, parameter :: first_points(3) = [27, 21, 7]          ! of u, roll, q
  integer, parameter :: most_rounds = 6, rounds_of_q = 3
  ! Grids over half a patch on tread and flange, as exact as their energies have to be: worn treads want more than the
  ! 4 x 16 elements that do for new ones.
  integer, parameter :: elements_x(2) = [5, 6], elements_s = 20
  real(dp), parameter :: tolerance(2) = [5e-4_dp, 1e-2_dp]      ! of tread and flange
  real(dp), parameter :: enough = 0.25_dp    ! errors of the spline, of those allowed, with which points are not solved
  ! The tread's lateral stiffness is that of gravity, on which noise of finer cells would tell.
  real(dp), parameter :: least_tread = 0.1e-3_dp   ! [m]

contains

  !> Sample the ratios of all zones, on axes that are halved like those of S.
  subroutine solve_ratios(pair, zones, e_star, extent, aim, most, table, ratio, solutions, work, stopped, watcher)
    type(pair_type), intent(in) :: pair
    type(zone_type), intent(in) :: zones(:)
    real(dp), intent(in) :: e_star
    type(extent_type), intent(in) :: extent
    real(dp), intent(in) :: aim
    integer, intent(in) :: most(3)
    type(table_type), intent(in) :: table
    type(ratio_type), intent(inout) :: ratio(:)
    integer, intent(out) :: solutions(2)   !! poses solved, and those that did not converge
    real(dp), intent(in) :: work(2)
    logical, intent(out) :: stopped
    class(monitor_type), intent(inout), optional :: watcher
    type(elements_type) :: elements(2)
    integer :: z, round
    logical :: finer(size(zones))

    elements(1) = new_elements(elements_x(1), elements_s, tolerance(1), e_star)
    elements(2) = new_elements(elements_x(2), elements_s, tolerance(2), e_star)
    do z = 1, size(zones)
      call start_ratio(ratio(z), graded_points(table%zones(z)%u%low, table%zones(z)%u%high, 0.0_dp, &
        merge(fine_flange, fine_tread, zones(z)%flange), min(first_points(1), most(1))), &
        graded_points(-extent%roll, extent%roll, 0.0_dp, fine_roll, min(first_points(2), most(2))), &
        first_depths(min(first_points(3), most(3)), table%zones(z)%q%high))
    end do
    solutions = 0
    do round = 1, most_rounds
      call solve_rows()
      if (stopped) return
      !$omp parallel do schedule(dynamic)
      do z = 1, size(zones)
        call fill_gaps(ratio(z))
        call refine_ratio(z, finer(z))
      end do
      if (.not. any(finer)) exit
    end do
    ! The last halving has no values yet.
    if (any(finer)) call solve_rows()
    do z = 1, size(zones)
      call fill_gaps(ratio(z))
    end do

  contains

    subroutine solve_rows()
      integer :: row, z, j, done, n(0:size(zones))

      n(0) = 0
      do z = 1, size(zones)
        n(z) = n(z - 1) + ratio(z)%roll%n
      end do
      done = 0
      stopped = .false.
      !$omp parallel do schedule(dynamic) private(z, j) reduction(+:solutions)
      do row = 1, n(size(zones))
        if (.not. goes_on(share_of_round(work, round), done, n(size(zones)), stopped, watcher)) cycle
        z = count(n(:size(zones) - 1) < row)
        j = row - n(z - 1)
        call sample_ratios(pair, zones, z, elements(merge(2, 1, zones(z)%flange)), table, extent, &
          ratio(z)%roll%x(j), ratio(z)%u%x, &
          heights(table%zones(z), ratio(z)%u%x, ratio(z)%roll%x(j)), ratio(z)%q%x, ratio(z)%open(:, :, j), &
          ratio(z)%c(:, :, j), ratio(z)%there(:, :, j), ratio(z)%area(:, :, :, j), solutions)
      end do
    end subroutine solve_rows

    !> Halve the axes where the force misses `aim`: an error of c changes the force like c itself, its slopes
    !> by the energy.
    subroutine refine_ratio(z, finer)
      integer, intent(in) :: z
      logical, intent(out) :: finer
      type(ratio_type) :: new
      real(dp), allocatable, dimension(:, :, :) :: by_value, of_u, of_roll, of_q
      logical, allocatable :: counts(:, :, :)
      type(axis_type) :: u, a, q
      real(dp), allocatable :: h(:)
      real(dp) :: depth, other, pose(3), allowance, force, c_h
      integer :: i, j, m
      logical :: more(3), within

      associate (r => ratio(z))
        allocate (by_value(r%q%n, r%u%n, r%roll%n), source=0.0_dp)
        allocate (counts(r%q%n, r%u%n, r%roll%n), source=.false.)
        do j = 1, r%roll%n
          h = heights(table%zones(z), r%u%x, r%roll%x(j))
          do i = 1, r%u%n
            do m = 2, r%q%n
              if (.not. r%there(m, i, j)) cycle
              depth = r%q%x(m)**2
              pose = zone_pose(table%zones(z), r%u%x(i), h(i) - depth, r%roll%x(j))
              allowance = error_allowance(pair, extent, pose, .true.)
              if (allowance <= 0) cycle
              call find_reach(table, extent, z, depth, pose, .true., within, other)
              if (.not. within) cycle
              c_h = hertz_factor*e_star
              force = c_h*depth**1.5_dp
              by_value(m, i, j) = force/(aim*allowance*max(force, force_floor, c_h*max(other, 0.0_dp)**1.5_dp))
              counts(m, i, j) = error_allowance(pair, extent, pose, .false.) > 0
              if (counts(m, i, j)) call find_reach(table, extent, z, depth, pose, .false., counts(m, i, j), other)
            end do
          end do
        end do
        ! Axes are halved for what a run comes to, points are solved for its surroundings, too.
        call judge(r, merge(by_value, 0.0_dp, counts), of_u, of_roll, of_q)
        u = r%u
        a = r%roll
        q = r%q
        call halve_cells(u, maxval(maxval(of_u, 3), 2), merge(4*least_u, least_tread, table%zones(z)%flange), most(1), more(1))
        call halve_cells(a, maxval(maxval(of_roll, 3), 2), 2*least_roll, most(2), more(2))
        more(3) = .false.
        if (round <= rounds_of_q) call halve_cells(q, maxval(maxval(of_q, 3), 2), 2*least_q, most(3), more(3))
        finer = any(more)
        if (.not. finer) return
        call start_ratio(new, u%x, a%x, q%x)
        call judge(r, by_value, of_u, of_roll, of_q)
        call carry_over(r, by_value, of_u, of_roll, of_q, new)
        r = new
      end associate
    end subroutine refine_ratio

  end subroutine solve_ratios

  !> h of a zone at many u, in steps of 10 nm.  A solution starts from its neighbour's, so that the last digits of the
  !> spline, which another processor rounds otherwise, would grow along a row until other cells are halved.
  pure function heights(t, u, roll) result(h)
    type(zone_table), intent(in) :: t
    real(dp), intent(in) :: u(:), roll
    real(dp), parameter :: step = 1e-8_dp      ! [m]
    real(dp) :: h(size(u)), line(1, size(u))

    call spline_2d_at(t%roll, t%u, t%h, [roll], u, line)
    h = anint(line(1, :)/step)*step
  end function heights

  !> Errors of the cells along u (u, q, roll), roll (roll, q, u), and q (q, u, roll), where c has the weights `by_value`
  !> (q, u, roll) at the points, and its slopes those of the energy.
  subroutine judge(r, by_value, of_u, of_roll, of_q)
    type(ratio_type), intent(in) :: r
    real(dp), intent(in) :: by_value(:, :, :)
    real(dp), allocatable, dimension(:, :, :), intent(out) :: of_u, of_roll, of_q
    integer :: nq, nu, nr

    nq = r%q%n
    nu = r%u%n
    nr = r%roll%n
    of_u = reshape(cell_errors(r%u, spread_u(r%c), spread_u(by_value), &
      spread_u(scaled(by_value, 0.4_dp*r%q%x**2))), [nu - 1, nq, nr])
    of_roll = reshape(cell_errors(r%roll, spread_roll(r%c), spread_roll(by_value), &
      spread_roll(scaled(by_value, 0.4_dp*r%q%x**2))/roll_lever), [nr - 1, nq, nu])
    of_q = reshape(cell_errors(r%q, reshape(r%c, [nq, nu*nr]), reshape(by_value, [nq, nu*nr]), &
      reshape(scaled(by_value, 0.2_dp*r%q%x), [nq, nu*nr])), [nq - 1, nu, nr])
  end subroutine judge

  pure function scaled(f, factor)
    real(dp), intent(in) :: f(:, :, :), factor(:)
    real(dp) :: scaled(size(f, 1), size(f, 2), size(f, 3))
    integer :: m

    do m = 1, size(f, 1)
      scaled(m, :, :) = f(m, :, :)*factor(m)
    end do
  end function scaled

  pure subroutine start_ratio(r, u, roll, q)
    type(ratio_type), intent(out) :: r
    real(dp), intent(in) :: u(:), roll(:), q(:)

    r%u = new_axis(u)
    r%roll = new_axis(roll)
    r%q = new_axis(q)
    allocate (r%c(size(q), size(u), size(roll)), source=1.0_dp)
    allocate (r%there(size(q), size(u), size(roll)), source=.false.)
    allocate (r%area(3, size(q), size(u), size(roll)), source=-1.0_dp)
    allocate (r%open(size(q), size(u), size(roll)), source=.true.)
  end subroutine start_ratio

  !> Square roots of penetrations.  The strips' modulus is a mean over more than the smallest patches: the ratio
  !> varies down to 0.
  pure function first_depths(n, deepest) result(q)
    integer, intent(in) :: n
    real(dp), intent(in) :: deepest
    real(dp) :: q(n)
    integer :: i

    q = [0.0_dp, 0.06_dp*deepest, (((i - 2)/real(n - 2, dp))**grading*deepest, i=3, n)]
  end function first_depths

  !> Values at the points of finer axes, from the old ones and their errors: those of common points, and the
  !> spline's where it errs little.
  subroutine carry_over(old, by_value, of_u, of_roll, of_q, new)
    type(ratio_type), intent(in) :: old
    real(dp), intent(in) :: by_value(:, :, :)  !! (q, u, roll), weights of c; 0 where none is known
    real(dp), intent(in) :: of_u(:, :, :)      !! of cells: (u, q, roll)
    real(dp), intent(in) :: of_roll(:, :, :)   !! (roll, q, u)
    real(dp), intent(in) :: of_q(:, :, :)      !! (q, u, roll)
    type(ratio_type), intent(inout) :: new
    real(dp), allocatable :: c(:, :, :)
    integer :: cell_u(2, new%u%n), cell_roll(2, new%roll%n), cell_q(2, new%q%n), wide(2, 3), i, j, m
    real(dp) :: error

    allocate (c(new%q%n, new%roll%n, new%u%n))
    call values_at(old, new%q%x, new%roll%x, new%u%x, c)
    cell_u = places(old%u%x, new%u%x)
    cell_roll = places(old%roll%x, new%roll%x)
    cell_q = places(old%q%x, new%q%x)
    do j = 1, new%roll%n
      do i = 1, new%u%n
        do m = 1, new%q%n
          associate (k => cell_u(:, i), l => cell_roll(:, j), n => cell_q(:, m))
            if (k(2) == k(1) .and. l(2) == l(1) .and. n(2) == n(1)) then
              new%there(m, i, j) = old%there(n(1), k(1), l(1))
              new%open(m, i, j) = old%open(n(1), k(1), l(1))
              new%c(m, i, j) = old%c(n(1), k(1), l(1))
              new%area(:, m, i, j) = old%area(:, n(1), k(1), l(1))
              cycle
            end if
            ! The next cells and lines count, too: on coarse axes a bend shows at a few points only.
            wide = reshape([max(k(1) - 1, 1), min(k(2) + 1, old%u%n), max(l(1) - 1, 1), min(l(2) + 1, old%roll%n), &
              max(n(1) - 1, 1), min(n(2) + 1, old%q%n)], [2, 3])
            error = 0
            if (k(2) > k(1)) error = maxval(of_u(wide(1, 1):wide(2, 1) - 1, wide(1, 3):wide(2, 3), wide(1, 2):wide(2, 2)))
            if (l(2) > l(1)) error = max(error, &
              maxval(of_roll(wide(1, 2):wide(2, 2) - 1, wide(1, 3):wide(2, 3), wide(1, 1):wide(2, 1))))
            if (n(2) > n(1)) error = max(error, &
              maxval(of_q(wide(1, 3):wide(2, 3) - 1, wide(1, 1):wide(2, 1), wide(1, 2):wide(2, 2))))
            new%there(m, i, j) = error <= enough .and. all(old%there(n(1):n(2), k(1):k(2), l(1):l(2))) &
              .and. all(by_value(n(1):n(2), k(1):k(2), l(1):l(2)) > 0)
            new%open(m, i, j) = .not. new%there(m, i, j)
            new%c(m, i, j) = c(m, j, i)
            if (minval(old%area(1, n(1):n(2), k(1):k(2), l(1):l(2))) > 0) new%area(:, m, i, j) = &
              sum(sum(sum(old%area(:, n(1):n(2), k(1):k(2), l(1):l(2)), 4), 3), 2) &
              /((n(2) - n(1) + 1)*(k(2) - k(1) + 1)*(l(2) - l(1) + 1))
          end associate
        end do
      end do
    end do

  contains

    !> First and last of the old points around every new one; they are the same where it is one of them.
    pure function places(old, new) result(cell)
      real(dp), intent(in) :: old(:), new(:)
      integer :: cell(2, size(new))
      integer :: i, k

      k = 1
      do i = 1, size(new)
        if (k < size(old)) then
          if (new(i) >= old(k + 1)) k = k + 1
        end if
        cell(:, i) = [k, k + merge(1, 0, new(i) > old(k))]
      end do
    end function places

  end subroutine carry_over

  !> The ratio at other points, (q, roll, u).
  subroutine values_at(r, q, roll, u, c)
    type(ratio_type), intent(in) :: r
    real(dp), intent(in) :: q(:), roll(:), u(:)
    real(dp), intent(out) :: c(:, :, :)
    real(dp), allocatable :: spline(:, :, :)

    call fit_3d(r%q, r%roll, r%u, reshape(r%c, [r%q%n, r%roll%n, r%u%n], order=[1, 3, 2]), spline)
    call spline_3d_at(r%q, r%roll, r%u, spline, q, roll, u, c)
  end subroutine values_at

  !> Where no run comes the ratio goes on along roll, on which it hardly depends, else along u, else along q.
  pure subroutine fill_gaps(r)
    type(ratio_type), intent(inout) :: r
    logical :: known(size(r%c, 1), size(r%c, 2), size(r%c, 3))
    integer :: i, j, m

    known = r%there
    do j = 1, r%roll%n
      do i = 1, r%u%n
        call continue_line(r%q%x, r%c(:, i, j), known(:, i, j))
      end do
    end do
    do m = 1, r%q%n
      do i = 1, r%u%n
        call continue_line(r%roll%x, r%c(m, i, :), known(m, i, :))
      end do
      do j = 1, r%roll%n
        call continue_line(r%u%x, r%c(m, :, j), known(m, :, j))
      end do
    end do
    where (.not. known) r%c = 1
  end subroutine fill_gaps

  !> Straight between known values; beyond them for two cells, then constant.
  pure subroutine continue_line(x, f, known)
    real(dp), intent(in) :: x(:)
    real(dp), intent(inout) :: f(:)
    logical, intent(inout) :: known(:)
    integer :: i, low, high, n

    if (all(known) .or. .not. any(known)) return
    n = size(f)
    low = 0
    high = 0
    do i = 1, n
      if (known(i)) then
        low = i
        cycle
      end if
      if (high < i) high = i - 1 + findloc(known(i:), .true., 1)
      if (low > 0 .and. high >= i) then
        f(i) = f(low) + (f(high) - f(low))*(x(i) - x(low))/(x(high) - x(low))
      else if (low > 1) then
        f(i) = f(low)
        if (known(low - 1)) f(i) = f(low) + (f(low) - f(low - 1))*min((x(i) - x(low))/(x(low) - x(low - 1)), 2.0_dp)
      else if (low == 0) then
        f(i) = f(high)
        if (high < n) then
          if (known(high + 1)) f(i) = f(high) + (f(high) - f(high + 1)) &
            *min((x(high) - x(i))/(x(high + 1) - x(high)), 2.0_dp)
        end if
      else
        f(i) = f(low)
      end if
    end do
    known = .true.
  end subroutine continue_line

  !> The table of half-spaces from that of strips, on axes that have the points of both; of q none below the first of
  !> the strips, which patches smaller than the rounding of the profiles' points would give.
  subroutine multiply(r, roll, most, t)
    type(ratio_type), intent(in) :: r
    type(axis_type), intent(in) :: roll    !! the table's and the ratios' points
    integer, intent(in) :: most(3)
    type(zone_table), intent(inout) :: t
    type(axis_type) :: u, q
    real(dp), allocatable :: h(:, :), s(:, :, :), c(:, :, :)

    u = united(t%u, r%u, least_u, most(1))
    q = united(t%q, new_axis([0.0_dp, pack(r%q%x, r%q%x > t%q%x(2))]), least_q, most(3))
    allocate (h(roll%n, u%n), s(q%n, roll%n, u%n), c(q%n, roll%n, u%n))
    call spline_2d_at(t%roll, t%u, t%h, roll%x, u%x, h)
    call spline_3d_at(t%q, t%roll, t%u, t%s, q%x, roll%x, u%x, s)
    call values_at(r, q%x, roll%x, u%x, c)
    t%u = u
    t%roll = roll
    t%q = q
    call fit_2d(roll, u, h, t%h)
    call fit_3d(q, roll, u, s*c, t%s)
    call bound_heights(t)
  end subroutine multiply

end module halfspace_correction