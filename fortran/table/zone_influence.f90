!> Influence of the zones of a wheel on each other: the mean influence of the loads of two zones, in half-spaces that are
!> pressed as a whole. It depends on where the loads are, and hardly on how large they are, so that few points of a table do.
!>
!> Where only one of two zones carries, it is the influence on the point of the other zone that is nearest to touching: in
!> this way a zone begins to carry where it does in the whole wheel.
module zone_influence
  use bspline, only: axis_type, fit_3d, graded_points, new_axis
  use contact_table, only: coupled_forces, find_roll, table_type
  use zone_coupling, only: pair_influence, pair_table
  use zone_tables, only: inside, roll_type, zone_penetration, zone_pose
  use grid_refinement, only: first_roll, grid_type, new_grid
  use halfspace_correction, only: fill_gaps, heights
  use halfspace_patches, only: force_between, influence_between, patches_type, press_patches
  use kinds, only: dp
  use patch_grids, only: elements_type
  use progress, only: goes_on, monitor_type
  use service_poses, only: find_allowance, request_type
  use station_scan, only: new_scan, scan_depth, scan_type
  use strip_law, only: set_moduli
  use table_sampling, only: press_zone
  implicit none
  private
  public :: add_pairs

  integer, parameter :: points(2) = [81, 21]        ! of u and roll
  real(dp), parameter :: fine_u = 1e-3_dp           ! u is fine within this distance of 0 [m]
  real(dp), parameter :: depths(*) = [0.0_dp, 0.02_dp, 0.05_dp, 0.1_dp, 0.16_dp, 0.24_dp, 0.34_dp, 0.45_dp, 0.6_dp, 0.8_dp, &
    1.0_dp]                                         ! points of the penetration, relative to the table's depth

contains

  !> Add the influences of all pairs of zones to a table. `stopped` is true if the watcher asked to stop.
  subroutine add_pairs(request, elements, table, solutions, stopped, watcher)
    type(request_type), intent(in) :: request
    type(elements_type), intent(in) :: elements
    type(table_type), intent(inout) :: table
    integer, intent(inout) :: solutions(2)   !! poses solved, and those that did not converge
    logical, intent(out) :: stopped
    class(monitor_type), intent(inout), optional :: watcher
    type(grid_type), allocatable :: grid(:)  ! of the zones before j
    type(pair_table) :: pairs(size(table%zones)*(size(table%zones) - 1)/2)
    type(axis_type) :: u, roll, p
    integer :: i, j, m, n, n_pairs

    n = size(table%zones)
    p = new_axis(depths*request%extent%depth)
    roll = first_roll(request%extent, points(2))
    allocate (table%pairs(0))
    n_pairs = 0
    stopped = .false.
    do j = 2, n
      u = new_axis(graded_points(table%zones(j)%u%low, table%zones(j)%u%high, fine_u, points(1)))
      ! An array constructor of types with allocatable components would leak in gfortran.
      if (allocated(grid)) deallocate (grid)
      allocate (grid(j - 1))
      do i = 1, j - 1
        grid(i) = new_grid(u, roll, p, [0.0_dp, 0.0_dp, 0.0_dp], 0.0_dp)
      end do
      !$omp parallel do schedule(dynamic) shared(stopped) reduction(+:solutions)
      do m = 1, points(2)
        if (goes_on(stopped, watcher)) &
          call sample_pairs(request, elements, table, j, m, grid, solutions)
      end do
      if (stopped) return
      do i = 1, j - 1
        if (.not. any(grid(i)%known)) cycle
        call fill_gaps(grid(i))
        n_pairs = n_pairs + 1
        pairs(n_pairs) = new_pair(i, j, grid(i))
      end do
      table%pairs = pairs(:n_pairs)
    end do
  end subroutine add_pairs

  type(pair_table) function new_pair(i, j, grid) result(pair)
    integer, intent(in) :: i, j
    type(grid_type), intent(in) :: grid

    pair%zone = [i, j]
    pair%u = grid%u
    pair%roll = grid%roll
    pair%p = grid%q
    call fit_3d(grid%q, grid%roll, grid%u, reshape(grid%f, [grid%q%n, grid%roll%n, grid%u%n], order=[1, 3, 2]), pair%c)
  end function new_pair

  !> Solve the poses at the m-th roll angle of zone j in which zones before it touch, too. The pairs of those are in the table.
  subroutine sample_pairs(request, elements, table, j, m, grid, solutions)
    type(request_type), intent(in) :: request
    type(elements_type), intent(in) :: elements
    type(table_type), intent(in) :: table
    integer, intent(in) :: j, m
    type(grid_type), intent(inout) :: grid(:)     !! of the zones before j
    integer, intent(inout) :: solutions(2)
    type(scan_type) :: scan
    type(patches_type) :: patches
    type(roll_type) :: roll, opposite
    real(dp) :: h(grid(1)%u%n), pose(3), allowance, deepest_other, k(size(request%side%pair%s))
    real(dp) :: c(size(table%zones), size(table%zones))   ! influences of zones on each other [m/N]
    integer :: i, l, v, status
    logical :: touching(size(table%zones))

    call find_roll(table, grid(1)%roll%x(m), .false., roll, opposite, status)
    if (status /= inside) return
    h = heights(table, j, grid(1)%u%x, roll%angle)
    do i = 1, j
      call set_moduli(request%side%pair, request%side%zones(i), elements%e_star, roll%angle, k)
    end do
    associate (side => request%side, u => grid(1)%u, p => grid(1)%q)
      scan = new_scan(side%pair)
      do v = 1, u%n
        do l = 1, p%n
          pose = zone_pose(table%zones(j), u%x(v), h(v) - p%x(l), roll%angle)
          call find_allowance(request, table, j, p%x(max(1, l - 2)), pose, .true., allowance, deepest_other)
          if (allowance <= 0 .or. deepest_other <= 0) cycle
          touching = [(zone_penetration(table%zones(i), pose, roll) > 0 .or. i == j, i=1, size(touching))]
          if (.not. any(touching(:j - 1))) cycle
          scan%fresh = .true.
          call scan_depth(side%pair, pose(:2), pose(3), minval(side%zones%first), maxval(side%zones%last), scan)
          call press_patches(side%pair, elements, minval(side%zones%first), maxval(side%zones%last), pose(:2), pose(3), scan, &
            patches)
          solutions = solutions + [1, merge(0, 1, patches%ok)]
          call find_influences()
          if (carrying() == 2) call match_energy(request, elements, table, pose, roll, j, patches%energy, k, scan, c, &
            solutions)
          do i = 1, j - 1
            if (c(i, j) <= 0) cycle
            grid(i)%f(l, v, m) = c(i, j)
            grid(i)%known(l, v, m) = .true.
          end do
        end do
      end do
    end associate

  contains

    !> Number of zones that carry.
    integer function carrying()
      real(dp) :: force(3)
      integer :: z

      carrying = 0
      do z = 1, size(touching)
        associate (zone => request%side%zones(z))
          force = force_between(patches, request%side%pair%s(zone%first), request%side%pair%s(zone%last))
        end associate
        if (norm2(force) > 0) carrying = carrying + 1
      end do
    end function carrying

    !> The influences c of the zones up to j that touch, for forces along the normals w of their coordinates.
    subroutine find_influences()
      real(dp) :: influence, load(2), angle
      integer :: i, order(2)

      c = 0
      do i = 1, j - 1
        if (.not. touching(i) .or. patches%n == 0) cycle
        order = [i, j]
        call influence_between(request%side%pair, elements, scan, patches, request%side%zones(order)%first, &
          request%side%zones(order)%last, influence, load, angle)
        if (any(load > 0)) c(i, j) = influence/(along_zone(i, load(1), angle)*along_zone(j, load(2), angle))
        c(j, i) = c(i, j)
      end do
      do i = 1, size(table%pairs)
        order = table%pairs(i)%zone
        if (order(2) >= j) cycle
        c(order(1), order(2)) = pair_influence(table%zones, table%pairs(i), pose, roll)
        c(order(2), order(1)) = c(order(1), order(2))
      end do
    end subroutine find_influences

    !> Force of a zone along w, per sum of its loads; of a zone without loads that at the angle of its nearest point.
    real(dp) function along_zone(z, load, angle) result(part)
      integer, intent(in) :: z
      real(dp), intent(in) :: load, angle    !! [N]; of the wheel's tangent [rad]
      real(dp) :: force(3)

      associate (zone => request%side%zones(z))
        part = cos(angle + roll%angle - zone%alpha)
        if (load <= 0) return
        force = force_between(patches, request%side%pair%s(zone%first), request%side%pair%s(zone%last))
        part = dot_product(force(:2), [-sin(zone%alpha), cos(zone%alpha)])/load
      end associate
    end function along_zone

  end subroutine sample_pairs

  !> Scale the influences on zone j so that the coupled zones have the energy of the whole wheel; patches that meet make it
  !> differ. The factor minimises (error of the energy/noise)^2 + (factor - 1)^2. The energy is stationary in the shifts, so
  !> that the table's shifts suffice.
  subroutine match_energy(request, elements, table, pose, roll, j, whole, k, scan, c, solutions)
    type(request_type), intent(in) :: request
    type(elements_type), intent(in) :: elements
    type(table_type), intent(in) :: table
    real(dp), intent(in) :: pose(3)
    type(roll_type), intent(in) :: roll      !! of the pose
    integer, intent(in) :: j
    real(dp), intent(in) :: whole            !! energy of the whole wheel [J]
    real(dp), intent(in) :: k(:)             !! moduli of the strips [Pa]
    type(scan_type), intent(inout) :: scan   !! workspace
    real(dp), intent(inout) :: c(:, :)       !! (zone, zone) [m/N]
    integer, intent(inout) :: solutions(2)
    real(dp), parameter :: noise = 2e-3_dp, least = 1.0_dp, largest = 1.5_dp   ! of the energies; of the factor
    real(dp), dimension(size(table%zones)) :: force, shift
    real(dp) :: energy, alone, strip, coupling, factor
    integer :: z
    logical :: ok

    call coupled_forces(table, pose, roll, c, force, shift)
    coupling = dot_product(force(:j), c(:j, j))*force(j)
    if (coupling <= 0) return
    energy = dot_product(force(:j), shift(:j))/2
    do z = 1, j
      if (force(z) <= 0) cycle
      scan%fresh = .true.
      call press_zone(request, z, elements, [pose(:2) + shift(z)*across(z), pose(3)], k, scan, strip, alone, ok)
      solutions = solutions + [1, merge(0, 1, ok)]
      energy = energy + alone
    end do
    factor = max(least, min(1 + (energy - whole)*coupling/(coupling**2 + (noise*whole)**2), largest))
    c(:, j) = factor*c(:, j)
    c(j, :) = c(:, j)

  contains

    pure function across(z)
      integer, intent(in) :: z
      real(dp) :: across(2)

      across = [-sin(request%side%zones(z)%alpha), cos(request%side%zones(z)%alpha)]
    end function across

  end subroutine match_energy

end module zone_influence
