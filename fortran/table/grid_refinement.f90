!> Functions of (q, u, roll), one per zone of a contact table, on axes that are halved where the spline errs.
!>
!> In a cell of length d a cubic spline through values of f misses f by about d^4 f''''/384 and the slope by
!> d^3 f'''' sqrt(3)/216: this is the error of Hermite's interpolation, which the spline has between equally spaced points
!> (C. A. Hall, J. Approx. Theory 1 (1968) 209-218). The fourth derivative is estimated by the jump of the spline's third
!> derivative at a point over the distance between the middles of the neighbouring cells.
!>
!> In a cell the force may err by tolerance*allowance*max(|F|, 5 kN, estimated force of the deepest other zone of the wheel);
!> the allowance is 1 in service and more in rolling over (`service_poses`).
!>
!> An extension of `gridded_function` says how values are computed and how an error of them changes the force.
module grid_refinement
  use bspline, only: axis_type, graded_points, new_axis, third_jumps
  use kinds, only: dp
  use contact_table, only: table_type
  use zone_tables, only: zone_pose
  use progress, only: goes_on, monitor_type
  use service_poses, only: estimated_force, extent_type, find_allowance, force_floor, request_type
  implicit none
  private
  public :: grid_type, gridded_function, rules_type, axis_errors
  public :: adapt, new_grid, first_u, first_roll, weigh_errors, find_cell_errors, cell_errors
  public :: scaled, united, grading, least_u, least_roll, least_q

  real(dp), parameter :: grading = 1.25_dp   ! of the first points of q towards 0
  ! Shorter cells are not halved: patches are larger [m, rad, sqrt(m)].
  real(dp), parameter :: least_u = 0.02e-3_dp, least_roll = 0.5e-3_dp, least_q = 0.5e-3_dp

  !> Values of a function of (q, u, roll) at the points of its axes.
  type :: grid_type
    type(axis_type) :: u, roll, q
    real(dp), allocatable :: f(:, :, :)      !! (q, u, roll)
    logical, allocatable :: known(:, :, :)   !! computed
    real(dp), allocatable :: h(:, :)         !! where the zone touches, (u, roll) [m]
    real(dp) :: least(3) = 0                 !! cells of u, roll, q of less than twice this length are not halved
    real(dp) :: otherwise = 0                !! the value where none was computed
  end type grid_type

  !> When the halving of cells ends.
  type :: rules_type
    integer :: most(3) = 0                   !! points of u, roll, q, at most
    integer :: most_values = 0               !! points of all zones, at most
    integer :: rounds = 0                    !! of sampling, at most
    logical :: common_roll = .false.         !! whether all zones have the same roll axis
  end type rules_type

  !> Largest errors in the cells of every axis, relative to those allowed.
  type :: axis_errors
    real(dp), allocatable :: u(:), roll(:), q(:)
  end type axis_errors

  !> A function of every zone, whose errors are judged by the force of poses that a run can reach.
  type, abstract :: gridded_function
    type(request_type) :: request
    type(table_type), pointer :: table => null()
    real(dp) :: tolerance = 0                !! error allowed in service, relative to the force
    real(dp) :: rollover_factor = 1          !! multiplies the error allowance in rolling over
    type(grid_type), allocatable :: grid(:)
  contains
    procedure(sample), deferred :: sample
    procedure(complete), deferred :: complete
    procedure(find_errors), deferred :: find_errors
  end type gridded_function

  abstract interface
    !> Compute the unknown values of zone z at the j-th roll angle. Several threads do that at once.
    subroutine sample(this, z, j)
      import :: gridded_function
      class(gridded_function), intent(inout) :: this
      integer, intent(in) :: z, j
    end subroutine sample
    !> Use the values of a round: all rows are sampled.
    subroutine complete(this)
      import :: gridded_function
      class(gridded_function), intent(inout) :: this
    end subroutine complete
    !> Estimate the errors of zone z.
    subroutine find_errors(this, z, error)
      import :: axis_errors, gridded_function
      class(gridded_function), intent(inout) :: this
      integer, intent(in) :: z
      type(axis_errors), intent(out) :: error
    end subroutine find_errors
  end interface

contains

  !> Sample a function and halve the cells in which the spline errs, until no cell errs or a rule ends it. `stopped` is true
  !> if the watcher asked to stop.
  subroutine adapt(values, rules, stopped, watcher)
    class(gridded_function), intent(inout) :: values
    type(rules_type), intent(in) :: rules
    logical, intent(out) :: stopped
    class(monitor_type), intent(inout), optional :: watcher
    integer :: round
    logical :: finer

    stopped = .false.
    do round = 1, rules%rounds
      call sample_rows(values, stopped, watcher)
      if (stopped) return
      call values%complete()
      if (round == rules%rounds) exit
      call refine(values, rules, finer)
      if (.not. finer) exit
    end do
  end subroutine adapt

  !> Sample all rows, each in one thread.
  subroutine sample_rows(values, stopped, watcher)
    class(gridded_function), intent(inout) :: values
    logical, intent(inout) :: stopped
    class(monitor_type), intent(inout), optional :: watcher
    integer :: row, z, before(0:size(values%grid))

    before(0) = 0
    do z = 1, size(values%grid)
      before(z) = before(z - 1) + values%grid(z)%roll%n
    end do
    !$omp parallel do schedule(dynamic) private(z) shared(stopped)
    do row = 1, before(size(values%grid))
      if (.not. goes_on(stopped, watcher)) cycle
      z = count(before(:size(values%grid) - 1) < row)
      call values%sample(z, row - before(z - 1))
    end do
  end subroutine sample_rows

  !> Halve the cells of all zones in which the spline errs.  Where they would have too many points, the cells that err less are
  !> left as they are: profiles that touch in many places at once have no end of cells that err.
  subroutine refine(values, rules, finer)
    class(gridded_function), intent(inout) :: values
    type(rules_type), intent(in) :: rules
    logical, intent(out) :: finer
    type(axis_type), dimension(size(values%grid)) :: u, roll, q
    type(axis_errors) :: error(size(values%grid))
    real(dp), parameter :: largest_scale = 1e6_dp
    real(dp) :: scale
    logical :: changed(3, size(values%grid))
    integer :: z

    !$omp parallel do schedule(dynamic)
    do z = 1, size(values%grid)
      call values%find_errors(z, error(z))
    end do
    if (rules%common_roll) then
      do z = 2, size(values%grid)
        error(1)%roll = max(error(1)%roll, error(z)%roll)
      end do
      do z = 2, size(values%grid)
        error(z)%roll = error(1)%roll
      end do
    end if
    scale = 1
    do
      call halve_axes(values, rules, error, scale, u, roll, q, changed)
      if (sum(u%n*roll%n*q%n) <= rules%most_values .or. .not. any(changed) .or. scale > largest_scale) exit
      scale = 2*scale
    end do
    finer = any(changed) .and. scale <= largest_scale
    if (.not. finer) return
    !$omp parallel do schedule(dynamic)
    do z = 1, size(values%grid)
      if (any(changed(:, z))) call resize(values%grid(z), u(z), roll(z), q(z))
    end do
  end subroutine refine

  !> Halve the cells of all zones whose errors exceed those allowed by a factor `scale`.
  subroutine halve_axes(values, rules, error, scale, u, roll, q, changed)
    class(gridded_function), intent(in) :: values
    type(rules_type), intent(in) :: rules
    type(axis_errors), intent(in) :: error(:)
    real(dp), intent(in) :: scale
    type(axis_type), dimension(:), intent(inout) :: u, roll, q
    logical, intent(out) :: changed(:, :)     !! (u, roll or q; zone)
    integer :: z

    do z = 1, size(values%grid)
      associate (g => values%grid(z))
        u(z) = g%u
        roll(z) = g%roll
        q(z) = g%q
        call halve_cells(u(z), error(z)%u/scale, g%least(1), rules%most(1), changed(1, z))
        call halve_cells(roll(z), error(z)%roll/scale, g%least(2), rules%most(2), changed(2, z))
        call halve_cells(q(z), error(z)%q/scale, g%least(3), rules%most(3), changed(3, z))
      end associate
    end do
  end subroutine halve_axes

  !> Return a grid on axes, with one value at all points, none of which is known.
  pure function new_grid(u, roll, q, least, value) result(grid)
    type(axis_type), intent(in) :: u, roll, q
    real(dp), intent(in) :: least(3), value
    type(grid_type) :: grid

    grid%u = u
    grid%roll = roll
    grid%q = q
    grid%least = least
    grid%otherwise = value
    allocate (grid%f(q%n, u%n, roll%n), source=value)
    allocate (grid%known(q%n, u%n, roll%n), source=.false.)
    allocate (grid%h(u%n, roll%n), source=-1.0_dp)
  end function new_grid

  !> Return the first axis of u with n points, fine about 0: in the throat of the flange a shift of 1 mm moves the patch by
  !> 10 mm, on the tread by about 1 mm.
  pure function first_u(low, high, flange, n) result(axis)
    real(dp), intent(in) :: low, high      !! [m]
    logical, intent(in) :: flange
    integer, intent(in) :: n
    type(axis_type) :: axis
    real(dp), parameter :: fine_flange = 3e-3_dp, fine_tread = 10e-3_dp   ! [m]

    axis = new_axis(graded_points(low, high, merge(fine_flange, fine_tread, flange), n))
  end function first_u

  !> Return the first axis of the roll angle with n points, fine about 0. The largest roll angle of a wheelset that rolls over is
  !> one of them, so that no cell lies half beyond it, where nothing is solved.
  pure function first_roll(extent, n) result(axis)
    type(extent_type), intent(in) :: extent
    integer, intent(in) :: n
    type(axis_type) :: axis
    real(dp), parameter :: fine = 0.02_dp  ! [rad]
    real(dp) :: x(n)
    integer :: i

    x = graded_points(-extent%roll, extent%roll, fine, n)
    i = minloc(abs(x + extent%largest_roll), 1)
    if (i > 1 .and. i <= n/2) then
      x(i) = -extent%largest_roll
      x(n + 1 - i) = extent%largest_roll
    end if
    axis = new_axis(x)
  end function first_roll

  !> Compute the weight of an error of the force at the known points of a zone [1/N]: the error is allowed if its product with
  !> the weight is at most 1. The weight is 0 if no run reaches the point.
  subroutine weigh_errors(this, z, force, weight)
    class(gridded_function), intent(in) :: this
    integer, intent(in) :: z
    real(dp), intent(in) :: force(:, :, :) !! (q, u, roll) [N]
    real(dp), intent(out) :: weight(:, :, :)   !! (q, u, roll)
    real(dp) :: depth, deepest_other, allowance
    integer :: i, j, m

    weight = 0
    associate (g => this%grid(z))
      do j = 1, g%roll%n
        do i = 1, g%u%n
          do m = 2, g%q%n
            if (.not. g%known(m, i, j)) cycle
            depth = g%q%x(m)**2
            call find_allowance(this%request, this%table, z, depth, zone_pose(this%table%zones(z), g%u%x(i), &
              g%h(i, j) - depth, g%roll%x(j)), .false., allowance, deepest_other)
            if (allowance > 1) allowance = this%rollover_factor*allowance
            if (allowance > 0) weight(m, i, j) = 1/(this%tolerance*allowance*max(force(m, i, j), force_floor, &
              estimated_force(this%request%e_star, deepest_other)))
          end do
        end do
      end do
    end associate
  end subroutine weigh_errors

  !> Find the largest errors in the cells of every axis, if a value of f has a weight in the force. Slopes change the force by
  !> the energy, which is 0.4 p = 0.4 q^2 times the force.
  subroutine find_cell_errors(g, weight, lever, error)
    type(grid_type), intent(in) :: g
    real(dp), intent(in) :: weight(:, :, :)   !! (q, u, roll)
    real(dp), intent(in) :: lever          !! of the force about X [m]
    type(axis_errors), intent(out) :: error
    integer :: lines(2)

    lines = [g%q%n, g%u%n*g%roll%n]
    error%u = cell_errors(g%u, along_u(g%f), along_u(weight), along_u(scaled(weight, 0.4_dp*g%q%x**2)))
    error%roll = cell_errors(g%roll, along_roll(g%f), along_roll(weight), along_roll(scaled(weight, 0.4_dp*g%q%x**2))/lever)
    error%q = cell_errors(g%q, reshape(g%f, lines), reshape(weight, lines), reshape(scaled(weight, 0.2_dp*g%q%x), lines))
  end subroutine find_cell_errors

  !> Estimate the most that the splines through lines f(n, m) miss in a cell, multiplied by the weights.
  function cell_errors(axis, f, value_weight, slope_weight) result(error)
    type(axis_type), intent(in) :: axis
    real(dp), intent(in) :: f(:, :)
    real(dp), intent(in) :: value_weight(:, :), slope_weight(:, :)   !! at the points, shape of f
    real(dp) :: error(size(f, 1) - 1)
    real(dp) :: jump(size(f, 1), size(f, 2)), fourth, d
    integer :: i, j, k

    error = 0
    call third_jumps(axis, f, jump)
    do j = 1, size(f, 2)
      do i = 2, axis%n - 1
        if (value_weight(i, j) <= 0 .and. slope_weight(i, j) <= 0) cycle
        ! "Not a knot": there is no jump at the outermost interior points.
        k = min(max(i, 3), axis%n - 2)
        fourth = abs(jump(k, j))*2/(axis%x(k + 1) - axis%x(k - 1))
        do k = i - 1, i
          d = axis%x(k + 1) - axis%x(k)
          error(k) = max(error(k), fourth*d**3*(value_weight(i, j)*d/384 + slope_weight(i, j)*(sqrt(3.0_dp)/216)))
        end do
      end do
    end do
  end function cell_errors

  !> Halve the cells whose error exceeds 1, the worst first, if they are at least 2*least long and there are at most `most`
  !> points. The axis stays as it is if less than 3 % of the cells err, by less than 10 times: at a kink of h cells err
  !> however small they are.
  subroutine halve_cells(axis, error, least, most, finer)
    type(axis_type), intent(inout) :: axis
    real(dp), intent(in) :: error(:)       !! of the cells
    real(dp), intent(in) :: least
    integer, intent(in) :: most
    logical, intent(out) :: finer
    real(dp), parameter :: handful = 0.03_dp, gross = 10
    real(dp) :: points(2*axis%n)
    logical :: halve(axis%n - 1)
    integer :: i, n

    halve = error > 1 .and. axis%x(2:) - axis%x(:axis%n - 1) >= 2*least
    finer = (count(halve) > handful*axis%n .or. any(halve .and. error > gross)) .and. axis%n < most
    if (.not. finer) return
    do while (axis%n + count(halve) > most)
      halve(minloc(error, 1, halve)) = .false.
    end do
    n = 0
    do i = 1, axis%n
      n = n + 1
      points(n) = axis%x(i)
      if (i == axis%n) exit
      if (.not. halve(i)) cycle
      n = n + 1
      points(n) = (axis%x(i) + axis%x(i + 1))/2
    end do
    axis = new_axis(points(:n))
  end subroutine halve_cells

  !> Return the index that every point of a finer axis has on the old one; 0 for new points.
  pure function common_points(old, new) result(index)
    type(axis_type), intent(in) :: old, new
    integer :: index(new%n)
    integer :: i, k

    k = 1
    index = 0
    do i = 1, new%n
      if (new%x(i) < old%x(k)) cycle
      index(i) = k
      k = k + 1
    end do
  end function common_points

  !> Give a grid finer axes. Known values at common points stay known.
  pure subroutine resize(grid, u, roll, q)
    type(grid_type), intent(inout) :: grid
    type(axis_type), intent(in) :: u, roll, q
    type(grid_type) :: new
    integer :: at_u(u%n), at_roll(roll%n), at_q(q%n), i, j, m

    new = new_grid(u, roll, q, grid%least, grid%otherwise)
    at_u = common_points(grid%u, u)
    at_roll = common_points(grid%roll, roll)
    at_q = common_points(grid%q, q)
    do j = 1, roll%n
      do i = 1, u%n
        if (at_u(i) == 0 .or. at_roll(j) == 0) cycle
        new%h(i, j) = grid%h(at_u(i), at_roll(j))
        do m = 1, q%n
          if (at_q(m) == 0) cycle
          new%f(m, i, j) = grid%f(at_q(m), at_u(i), at_roll(j))
          new%known(m, i, j) = grid%known(at_q(m), at_u(i), at_roll(j))
        end do
      end do
    end do
    grid = new
  end subroutine resize

  !> Return an axis with the points of two; points of b nearer than least/2 to one of a are left out.
  pure function united(a, b, least) result(axis)
    type(axis_type), intent(in) :: a, b
    real(dp), intent(in) :: least
    type(axis_type) :: axis
    real(dp) :: x(a%n + b%n)
    integer :: i, j, n

    n = 0
    j = 1
    do i = 1, a%n
      do while (j <= b%n)
        if (b%x(j) >= a%x(i)) exit
        if (b%x(j) > a%x(max(i - 1, 1)) + least/2 .and. b%x(j) < a%x(i) - least/2) then
          n = n + 1
          x(n) = b%x(j)
        end if
        j = j + 1
      end do
      n = n + 1
      x(n) = a%x(i)
    end do
    axis = new_axis(x(:n))
  end function united

  !> Return f(q, u, roll) with every q multiplied by a factor.
  pure function scaled(f, factor)
    real(dp), intent(in) :: f(:, :, :), factor(:)
    real(dp) :: scaled(size(f, 1), size(f, 2), size(f, 3))
    integer :: i, j

    do j = 1, size(f, 3)
      do i = 1, size(f, 2)
        scaled(:, i, j) = f(:, i, j)*factor
      end do
    end do
  end function scaled

  !> Return f(q, u, roll) as lines along u.
  pure function along_u(f) result(lines)
    real(dp), intent(in) :: f(:, :, :)
    real(dp) :: lines(size(f, 2), size(f, 1)*size(f, 3))

    lines = reshape(reshape(f, [size(f, 2), size(f, 1), size(f, 3)], order=[2, 1, 3]), shape(lines))
  end function along_u

  !> Return f(q, u, roll) as lines along roll.
  pure function along_roll(f) result(lines)
    real(dp), intent(in) :: f(:, :, :)
    real(dp) :: lines(size(f, 3), size(f, 1)*size(f, 2))

    lines = transpose(reshape(f, [size(f, 1)*size(f, 2), size(f, 3)]))
  end function along_roll

end module grid_refinement
