!> Energy of half-spaces over that of strips, by which S of the strips is multiplied: a smooth
!> function c(u, phi, q) of the pose, because the strips already carry the geometry.
!>
!> It is solved at the points of axes of its own, coarser than those of S, which are halved where
!> the spline through it misses the accuracy asked for.
module ratios
  use bspline, only: axis_basis, axis_type, basis_type, fit_3d, graded_points, new_axis, spline_2d_value, &
    spline_3d_value
  use contact, only: zone_type
  use geometry, only: pair_type
  use kinds, only: dp
  use patches, only: elements_type, new_elements
  use potential, only: contact_table, zone_pose, zone_table
  use progress, only: count_work, monitor_type, share_of_round
  use reach, only: extent_type, find_reach, least_force, lever, strictness
  use refine, only: fine_flange, fine_roll, fine_tread, grading, halve_cells, judge_cells, least_q, least_roll, least_u, &
    spread_roll, spread_u
  use samples, only: sample_ratios
  implicit none
  private
  public :: ratio_type, solve_ratios, multiply

  !> Ratio of half-space to strip energy at the points of axes of its own.
  type :: ratio_type
    type(axis_type) :: u, roll, q
    real(dp), allocatable :: c(:, :, :)      !! (q, u, roll)
    logical, allocatable :: there(:, :, :)   !! solved
    real(dp), allocatable :: area(:, :, :, :)   !! pressed by a single patch: (3, q, u, roll)
    logical, allocatable :: done(:, :)       !! (u, roll): what there is to solve is solved
  end type ratio_type

  integer, parameter :: first_points(3) = [21, 21, 7]          ! of u, roll, q
  integer, parameter :: most_rounds = 6, rounds_of_q = 3
  ! Grids of 6 x 24 elements over half a patch, as exact as their energies have to be.
  integer, parameter :: elements_x = 6, elements_s = 24
  real(dp), parameter :: tolerance(2) = [5e-4_dp, 1e-2_dp]      ! of tread and flange
  ! The tread's lateral stiffness is that of gravity, on which noise of finer cells would tell.
  real(dp), parameter :: least_tread = 0.1e-3_dp   ! [m]

contains

  !> Sample the ratios of all zones, on axes that are halved like those of S.
  subroutine solve_ratios(pair, zones, e_star, extent, aim, most, table, ratio, work, stopped, watcher)
    type(pair_type), intent(in) :: pair
    type(zone_type), intent(in) :: zones(:)
    real(dp), intent(in) :: e_star
    type(extent_type), intent(in) :: extent
    real(dp), intent(in) :: aim
    integer, intent(in) :: most(3)
    type(contact_table), intent(in) :: table
    type(ratio_type), intent(inout) :: ratio(:)
    real(dp), intent(in) :: work(2)
    logical, intent(out) :: stopped
    class(monitor_type), intent(inout), optional :: watcher
    type(elements_type) :: elements(2)
    integer :: z, round
    logical :: finer(size(zones))

    elements(1) = new_elements(elements_x, elements_s, tolerance(1), e_star)
    elements(2) = new_elements(elements_x, elements_s, tolerance(2), e_star)
    do z = 1, size(zones)
      call start_ratio(ratio(z), graded_points(table%zones(z)%u%low, table%zones(z)%u%high, 0.0_dp, &
        merge(fine_flange, fine_tread, zones(z)%flange), min(first_points(1), most(1))), &
        graded_points(-extent%roll, extent%roll, 0.0_dp, fine_roll, min(first_points(2), most(2))), &
        first_depths(min(first_points(3), most(3)), table%zones(z)%q%high))
    end do
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
      !$omp parallel do schedule(dynamic) private(z, j)
      do row = 1, n(size(zones))
        call count_work(share_of_round(work, round), done, n(size(zones)), stopped, watcher)
        if (stopped) cycle
        z = count(n(:size(zones) - 1) < row)
        j = row - n(z - 1)
        call sample_ratios(pair, zones, z, elements(merge(2, 1, zones(z)%flange)), table, extent, &
          ratio(z)%roll%x(j), ratio(z)%u%x, &
          heights(table%zones(z), ratio(z)%u%x, ratio(z)%roll%x(j)), ratio(z)%q%x, ratio(z)%done(:, j), &
          ratio(z)%c(:, :, j), ratio(z)%there(:, :, j), ratio(z)%area(:, :, :, j))
      end do
    end subroutine solve_rows

    !> Halve the axes where the force misses `aim`: an error of c changes the force like c itself, its slopes
    !> by the energy.
    subroutine refine_ratio(z, finer)
      integer, intent(in) :: z
      logical, intent(out) :: finer
      type(ratio_type) :: new
      real(dp), allocatable, dimension(:, :, :) :: by_value
      real(dp), allocatable :: of_u(:), of_roll(:), of_q(:)
      type(axis_type) :: u, a, q
      real(dp), allocatable :: h(:)
      real(dp) :: depth, other, pose(3), strict, force, c_h
      integer :: i, j, m
      logical :: more(3), within

      associate (r => ratio(z))
        allocate (by_value(r%q%n, r%u%n, r%roll%n), source=0.0_dp)
        do j = 1, r%roll%n
          h = heights(table%zones(z), r%u%x, r%roll%x(j))
          do i = 1, r%u%n
            do m = 2, r%q%n
              if (.not. r%there(m, i, j)) cycle
              depth = r%q%x(m)**2
              pose = zone_pose(table%zones(z), r%u%x(i), h(i) - depth, r%roll%x(j))
              strict = strictness(pair, extent, pose, .false.)
              if (strict <= 0) cycle
              call find_reach(table, extent, z, depth, pose, .false., within, other)
              if (.not. within) cycle
              c_h = 0.7_dp*e_star
              force = c_h*depth**1.5_dp
              by_value(m, i, j) = force/(aim*strict*max(force, least_force, c_h*max(other, 0.0_dp)**1.5_dp))
            end do
          end do
        end do
        allocate (of_u(r%u%n - 1), of_roll(r%roll%n - 1), of_q(r%q%n - 1), source=0.0_dp)
        call judge_cells(r%u, spread_u(r%c), spread_u(by_value), spread_u(scaled(by_value, 0.4_dp*r%q%x**2)), of_u)
        call judge_cells(r%roll, spread_roll(r%c), spread_roll(by_value), &
          spread_roll(scaled(by_value, 0.4_dp*r%q%x**2))/lever, of_roll)
        call judge_cells(r%q, reshape(r%c, [r%q%n, r%u%n*r%roll%n]), reshape(by_value, [r%q%n, r%u%n*r%roll%n]), &
          reshape(scaled(by_value, 0.2_dp*r%q%x), [r%q%n, r%u%n*r%roll%n]), of_q)
        u = r%u
        a = r%roll
        q = r%q
        call halve_cells(u, of_u, merge(4*least_u, least_tread, table%zones(z)%flange), most(1), more(1))
        call halve_cells(a, of_roll, 2*least_roll, most(2), more(2))
        more(3) = .false.
        if (round <= rounds_of_q) call halve_cells(q, of_q, 2*least_q, most(3), more(3))
        finer = any(more)
        if (.not. finer) return
        call start_ratio(new, u%x, a%x, q%x)
        call carry_over(r, new)
        r = new
      end associate
    end subroutine refine_ratio

  end subroutine solve_ratios

  !> h of a zone at many u.
  pure function heights(t, u, roll) result(h)
    type(zone_table), intent(in) :: t
    real(dp), intent(in) :: u(:), roll
    real(dp) :: h(size(u))
    type(basis_type) :: bu, br
    integer :: i

    call axis_basis(t%roll, roll, br, .false.)
    do i = 1, size(u)
      call axis_basis(t%u, u(i), bu, .false.)
      h(i) = spline_2d_value(t%h, br, bu)
    end do
  end function heights

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
    allocate (r%done(size(u), size(roll)), source=.false.)
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

  !> Keep what was solved at points of the finer axes.
  pure subroutine carry_over(old, new)
    type(ratio_type), intent(in) :: old
    type(ratio_type), intent(inout) :: new
    integer :: i, j, m, k, l, n

    l = 1
    do j = 1, new%roll%n
      if (new%roll%x(j) > old%roll%x(l)) l = l + 1
      if (new%roll%x(j) < old%roll%x(l)) cycle
      k = 1
      do i = 1, new%u%n
        if (new%u%x(i) > old%u%x(k)) k = k + 1
        if (new%u%x(i) < old%u%x(k)) cycle
        n = 1
        do m = 1, new%q%n
          if (new%q%x(m) > old%q%x(n)) n = n + 1
          if (new%q%x(m) < old%q%x(n)) cycle
          new%c(m, i, j) = old%c(n, k, l)
          new%there(m, i, j) = old%there(n, k, l)
          new%area(:, m, i, j) = old%area(:, n, k, l)
        end do
        new%done(i, j) = new%q%n == old%q%n .and. old%done(k, l)
      end do
    end do
  end subroutine carry_over

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

  !> S of half-spaces from S of strips.
  subroutine multiply(r, q, u, roll, s)
    type(ratio_type), intent(in) :: r
    type(axis_type), intent(in) :: q, u, roll
    real(dp), intent(inout) :: s(:, :, :)    !! (q, u, roll)
    real(dp), allocatable :: c(:, :, :)
    type(basis_type) :: bu, br, bq(q%n)
    integer :: i, j, m

    call fit_3d(r%q, r%roll, r%u, reshape(r%c, [r%q%n, r%roll%n, r%u%n], order=[1, 3, 2]), c)
    do m = 1, q%n
      call axis_basis(r%q, q%x(m), bq(m), .false.)
    end do
    do j = 1, roll%n
      call axis_basis(r%roll, roll%x(j), br, .false.)
      do i = 1, u%n
        call axis_basis(r%u, u%x(i), bu, .false.)
        do m = 1, q%n
          s(m, i, j) = s(m, i, j)*spline_3d_value(c, bq(m), br, bu)
        end do
      end do
    end do
  end subroutine multiply

end module ratios
