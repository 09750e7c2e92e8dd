!> Ratio of half-space to strip energy, by which S of the strips is multiplied: a smooth function c(u, phi, q) of the pose,
!> because the strips already carry the geometry.
!>
!> A zone is pressed alone; what zones do to each other is in `zone_influence`. The ratio has axes of its own, coarser than
!> those of S.
module halfspace_correction
  use grid_refinement, only: adapt, axis_errors, find_cell_errors, first_roll, first_u, grading, gridded_function, &
    grid_type, least_q, least_roll, least_u, new_grid, rules_type, united, weigh_errors
  use bspline, only: axis_type, fit_2d, fit_3d, new_axis, spline_2d_at, spline_3d_at
  use kinds, only: dp
  use patch_grids, only: elements_type
  use contact_table, only: table_type
  use zone_tables, only: bound_heights, zone_table
  use progress, only: monitor_type
  use service_poses, only: estimated_force, request_type
  use table_sampling, only: sample_ratios
  implicit none
  private
  public :: solve_ratios, multiply, fill_gaps, heights

  type, extends(gridded_function) :: ratio_type
    type(elements_type) :: elements
    integer :: solutions(2) = 0                 !! poses solved, and those that did not converge
  contains
    procedure :: sample
    procedure :: complete
    procedure :: find_errors
  end type ratio_type

  ! Numbers of u, roll, q. The points of q are every second one of the strips', and one more near 0.
  integer, parameter :: first_points(3) = [29, 21, 9]
  integer, parameter :: most_rounds = 5
  integer, parameter :: most_values = 700000    ! twice what new profiles need; a fifth is solved, the rest continued
  ! Solutions have noise, which would be stiffness in smaller cells. On the tread, where the lateral stiffness is only
  ! gravitational, it would be visible in larger ones, too [m].
  real(dp), parameter :: least_flange = 0.05e-3_dp, least_tread = 0.1e-3_dp

contains

  !> Compute the ratios of all zones of a table of strips.
  subroutine solve_ratios(request, accuracy, elements, table, ratio, solutions, stopped, watcher)
    type(request_type), intent(in) :: request
    type(elements_type), intent(in) :: elements
    real(dp), intent(in) :: accuracy         !! error of the force that the ratios may cause, relative to the force
    type(table_type), intent(in), target :: table
    type(grid_type), allocatable, intent(out) :: ratio(:)
    integer, intent(inout) :: solutions(2)   !! poses solved, and those that did not converge
    logical, intent(out) :: stopped
    class(monitor_type), intent(inout), optional :: watcher
    type(ratio_type) :: c
    integer :: z, n(3)

    allocate (c%grid(size(table%zones)))
    c%request = request
    c%table => table
    c%tolerance = accuracy
    c%elements = elements
    n = min(first_points, request%most)
    do z = 1, size(table%zones)
      associate (t => table%zones(z))
        c%grid(z) = new_grid(first_u(t%u%low, t%u%high, t%past_root, n(1)), first_roll(request%extent, n(2)), &
          new_axis(first_depths(n(3), t%q%high)), &
          [merge(least_flange, least_tread, t%past_root), 2*least_roll, 2*least_q], 1.0_dp)
      end associate
    end do
    call adapt(c, rules_type(request%most, most_values, most_rounds), stopped, watcher)
    solutions = c%solutions
    call move_alloc(c%grid, ratio)
  end subroutine solve_ratios

  !> Solve zone z at the j-th roll angle.
  subroutine sample(this, z, j)
    class(ratio_type), intent(inout) :: this
    integer, intent(in) :: z, j
    integer :: solutions(2)

    solutions = 0
    associate (g => this%grid(z))
      g%h(:, j) = heights(this%table, z, g%u%x, g%roll%x(j))
      call sample_ratios(this%request, z, this%elements, this%table, g%roll%x(j), g%u%x, g%h(:, j), g%q%x, g%f(:, :, j), &
        g%known(:, :, j), solutions)
    end associate
    !$omp critical
    this%solutions = this%solutions + solutions
    !$omp end critical
  end subroutine sample

  !> Continue the ratios to the poses that no run reaches.
  subroutine complete(this)
    class(ratio_type), intent(inout) :: this
    integer :: z

    !$omp parallel do schedule(dynamic)
    do z = 1, size(this%grid)
      call fill_gaps(this%grid(z))
    end do
  end subroutine complete

  !> Estimate the errors of the ratio: an error changes the force by as much.
  subroutine find_errors(this, z, error)
    class(ratio_type), intent(inout) :: this
    integer, intent(in) :: z
    type(axis_errors), intent(out) :: error
    real(dp), allocatable :: force(:, :, :), weight(:, :, :)
    integer :: m

    associate (g => this%grid(z))
      allocate (force, weight, mold=g%f)
      do m = 1, g%q%n
        force(m, :, :) = estimated_force(this%request%e_star, g%q%x(m)**2)
      end do
      call weigh_errors(this, z, force, weight)
      call find_cell_errors(g, force*weight, this%request%extent%lever, error)
    end associate
  end subroutine find_errors

  !> Return h of a zone at many u [m].
  pure function heights(table, z, u, roll) result(h)
    type(table_type), intent(in) :: table
    integer, intent(in) :: z
    real(dp), intent(in) :: u(:), roll
    real(dp) :: h(size(u)), line(1, size(u))

    call spline_2d_at(table%roll, table%zones(z)%u, table%zones(z)%h, [roll], u, line)
    h = line(1, :)
  end function heights

  !> Return the first n points of q. The strips' modulus is averaged over a width larger than the smallest patches, so
  !> that the ratio still varies near q = 0.
  pure function first_depths(n, deepest) result(q)
    integer, intent(in) :: n
    real(dp), intent(in) :: deepest
    real(dp) :: q(n)
    integer :: i

    q = [0.0_dp, 0.06_dp*deepest, (((i - 2)/real(n - 2, dp))**grading*deepest, i=3, n)]
  end function first_depths

  !> Evaluate the ratio at other points: c(q, roll, u).
  subroutine values_at(r, q, roll, u, c)
    type(grid_type), intent(in) :: r
    real(dp), intent(in) :: q(:), roll(:), u(:)
    real(dp), intent(out) :: c(:, :, :)
    real(dp), allocatable :: spline(:, :, :)

    call fit_3d(r%q, r%roll, r%u, reshape(r%f, [r%q%n, r%roll%n, r%u%n], order=[1, 3, 2]), spline)
    call spline_3d_at(r%q, r%roll, r%u, spline, q, roll, u, c)
  end subroutine values_at

  !> Continue the ratio to the poses that no run reaches: along q as at the nearest u that knows more, then along q, along roll, on
  !> which it hardly depends, and along u.
  pure subroutine fill_gaps(r)
    type(grid_type), intent(inout) :: r
    logical :: known(size(r%f, 1), size(r%f, 2), size(r%f, 3))
    integer :: i, j, m, from, other

    known = r%known
    do j = 1, r%roll%n
      do i = 1, r%u%n
        from = findloc(r%known(:, i, j), .true., 1, back=.true.)
        do m = from + 1, merge(r%q%n, 0, from > 1)
          other = minloc(abs(r%u%x - r%u%x(i)), 1, r%known(m, :, j) .and. r%known(from, :, j))
          if (other == 0) exit
          r%f(m, i, j) = r%f(from, i, j)*r%f(m, other, j)/r%f(from, other, j)
          known(m, i, j) = .true.
        end do
      end do
      do i = 1, r%u%n
        call continue_line(r%q%x, r%f(:, i, j), known(:, i, j))
      end do
    end do
    do m = 1, r%q%n
      do i = 1, r%u%n
        call continue_line(r%roll%x, r%f(m, i, :), known(m, i, :))
      end do
      do j = 1, r%roll%n
        call continue_line(r%u%x, r%f(m, :, j), known(m, :, j))
      end do
    end do
    where (.not. known) r%f = 1
  end subroutine fill_gaps

  !> Fill in the unknown values of a line: linear between known ones, beyond them linear for two cells, then constant.
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

  !> Turn a zone's table of strips into one of half-spaces, on axes with the points of both. Points of q below the first of the
  !> strips are left out: patches that small would show the rounding of the profiles' points.
  subroutine multiply(r, old_roll, roll, t)
    type(grid_type), intent(in) :: r
    type(axis_type), intent(in) :: old_roll, roll   !! the table's points; the table's and the ratios' points
    type(zone_table), intent(inout) :: t
    type(axis_type) :: u, q
    real(dp), allocatable :: h(:, :), s(:, :, :), c(:, :, :)

    u = united(t%u, r%u, least_u)
    q = united(t%q, new_axis([0.0_dp, pack(r%q%x, r%q%x > t%q%x(2))]), least_q)
    allocate (h(roll%n, u%n), s(q%n, roll%n, u%n), c(q%n, roll%n, u%n))
    call spline_2d_at(old_roll, t%u, t%h, roll%x, u%x, h)
    call spline_3d_at(t%q, old_roll, t%u, t%s, q%x, roll%x, u%x, s)
    call values_at(r, q%x, roll%x, u%x, c)
    t%u = u
    t%q = q
    call fit_2d(roll, u, h, t%h)
    call fit_3d(q, roll, u, s*c, t%s)
    call bound_heights(t)
  end subroutine multiply

end module halfspace_correction