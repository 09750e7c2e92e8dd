!> Error of a contact table: its forces against direct evaluation, in poses between its points,
!>
!>     |F_table - F_direct|/max(|F_direct|, 5 kN),
!>
!> as rms and largest value in four places: tread alone, flange alone, both, and going over the rail. It is a sample and no bound.
!> F_direct is the central difference of the energy; for half-spaces the whole wheel is pressed as one system, unless the zones
!> do not act on each other.
!>
!> The poses follow an additive recurrence (Kronecker's sequence), which is the same for every table: a station of the
!> wheel touches the rail's point of the same normal, at some roll angle, and is pressed in by some depth. Only poses
!> that a run can reach are compared. Penetrations are found without the table, so that a contact which the table misses
!> is an error of all its force.
!>
!> S has to be positive, for a contact does not pull. The points in service at which `wheel_potential` refuses a pose because
!> a contact would pull are counted.
module table_error
  use bspline, only: axis_type, spline_2d_at, spline_3d_at
  use contact_zones, only: zone_type
  use strip_law, only: set_moduli, zone_energy
  use station_scan, only: new_scan, scan_depth, scan_type, touch
  use wheel_rail_pair, only: mirror, pair_type, rail_point, rolled
  use kinds, only: dp
  use progress, only: goes_on, monitor_type
  use halfspace_patches, only: force_between, patches_type, press_patches
  use patch_grids, only: elements_type
  use contact_table, only: accuracy_type, table_type, find_roll, wheel_potential
  use zone_tables, only: inside, outside_lateral, outside_law, outside_roll, roll_type, zone_pose
  use service_poses, only: error_allowance, find_allowance, force_floor, request_type, tread_share
  implicit none
  private
  public :: measure, direct_force

  ! Numbers of poses in service and in rolling over; half-spaces take far longer than strips.
  integer, parameter :: strip_poses(2) = [1000, 200], halfspace_poses(2) = [400, 150], most_draws = 240000
  ! The recurrence has irrational steps: the fractions of square roots of primes.
  real(dp), parameter :: irrational(4) = [0.414213562373095_dp, 0.732050807568877_dp, 0.236067977499790_dp, &
    0.645751311064591_dp]
  ! Half-spaces are solved on finer grids than for the table, to a smaller tolerance.
  integer, parameter :: elements_x = 6, elements_s = 24
  real(dp), parameter :: tolerance = 1e-3_dp

  ! No run stands on the wheel's rim, where the profile ends [m].
  real(dp), parameter :: rim_width = 3e-3_dp

  real(dp), parameter :: too_deep = 10e-3_dp   ! depth inside the rail that no run reaches [m]

contains

  !> Fill in the errors of a table. `stopped` is true, and the errors not known, if the watcher asked to stop.
  subroutine measure(request, table, stopped, watcher)
    type(request_type), intent(in) :: request
    type(table_type), intent(inout) :: table
    logical, intent(out) :: stopped
    class(monitor_type), intent(inout), optional :: watcher
    type(elements_type) :: elements
    type(scan_type) :: scan
    real(dp), allocatable :: pose(:, :), error(:)
    integer, allocatable :: place(:)       ! of the accuracy: tread, flange, both, rolling over
    logical, allocatable :: touching(:, :), solved(:)
    integer :: wanted(2), drawn(2), failed, i, k, n
    logical :: usable, known

    stopped = .false.
    table%accuracy = accuracy_type()
    wanted = strip_poses
    if (request%model == 'halfspace') wanted = halfspace_poses
    scan = new_scan(request%side%pair)
    n = sum(wanted)
    allocate (pose(3, n), error(n), place(n), touching(2, n), solved(n))
    drawn = 0
    failed = 0
    do i = 1, most_draws
      if (all(drawn >= wanted)) exit
      ! Draws of all zones alternate between service and rolling over.
      k = merge(1, 2, modulo(i/size(table%zones), 2) == 0)
      if (drawn(k) >= wanted(k)) cycle
      n = sum(drawn) + 1
      call draw_pose(request, table, i, k == 2, scan, pose(:, n), usable, known)
      if (.not. known) failed = failed + 1
      if (.not. usable) cycle
      drawn(k) = drawn(k) + 1
      place(n) = merge(1, 4, k == 1)
    end do
    elements = elements_type(elements_x, elements_s, tolerance, request%e_star, request%influence == 'flat', .true.)
    n = sum(drawn)
    !$omp parallel do schedule(dynamic) shared(stopped)
    do i = 1, n
      if (.not. goes_on(stopped, watcher)) cycle
      call compare_forces(request, elements, table, pose(:, i), error(i), touching(:, i), solved(i))
    end do
    if (stopped) return
    table%accuracy%unsolved = failed + count(.not. solved(:n))
    where (place(:n) == 1 .and. touching(2, :n)) place(:n) = merge(3, 2, touching(1, :n))
    do i = 1, 4
      associate (here => place(:n) == i .and. solved(:n))
        table%accuracy%poses(i) = count(here)
        if (.not. any(here)) cycle
        table%accuracy%rms(i) = sqrt(sum(error(:n)**2, here)/count(here))
        table%accuracy%largest(i) = maxval(error(:n), here)
      end associate
    end do
  end subroutine measure

  !> Compute the i-th pose of the sequence, and whether a run can reach it. That is not known if the search for the height at
  !> which a zone touches found none, although the zone is inside the rail; then the pose is not usable.
  subroutine draw_pose(request, table, i, rolling_over, scan, pose, usable, known)
    type(request_type), intent(in) :: request
    type(table_type), intent(in) :: table
    integer, intent(in) :: i
    logical, intent(in) :: rolling_over    !! or in service
    type(scan_type), intent(inout) :: scan !! workspace
    real(dp), intent(out) :: pose(3)
    logical, intent(out) :: usable, known
    real(dp) :: x(4), point(2), normal(2), deepest_other, depth, allowance, depths(size(table%zones), 2)
    integer :: z, j, station, side, rim

    associate (pair => request%side%pair, zones => request%side%zones, extent => request%extent)
      known = .true.
      x = modulo(i*irrational, 1.0_dp)
      rim = count(pair%s < pair%s(size(pair%s)) - rim_width)
      z = 1 + mod(i, size(zones))
      station = zones(z)%first + nint(x(1)*(min(zones(z)%last, rim) - zones(z)%first))
      pose(3) = extent%service_roll*(2*x(2) - 1)
      if (rolling_over) pose(3) = extent%small_roll - (extent%small_roll + extent%largest_roll)*x(2)
      depth = extent%depth*merge(1.0_dp, tread_share, zones(z)%past_root)*x(3)**2
      call rail_point(pair, pair%angle(station) + pose(3), point, normal, usable)
      if (.not. usable) return
      pose(:2) = point - rolled(pair%r(:, station), pose(3)) - depth*normal
      allowance = error_allowance(request, pose, .false.)
      usable = allowance >= 1 .and. (allowance > 1 .eqv. rolling_over) .and. .not. leaves_table(table, pose)
      if (.not. usable) return
      depths = -1
      call direct_penetration(pair, zones(z), pose, scan, depths(z, 1), known)
      usable = known .and. depths(z, 1) > 0 .and. depths(z, 1) <= extent%depth
      ! The left wheel alone excludes most poses that are out of reach.
      do side = 1, 2
        do j = 1, size(zones)
          if (.not. usable) return
          if (side == 1 .and. j == z) cycle
          call direct_penetration(pair, zones(j), merge(pose, mirror*pose, side == 1), scan, depths(j, side), known)
          usable = known
        end do
        if (usable) call find_allowance(request, table, z, depths(z, 1), pose, .false., allowance, deepest_other, depths)
        usable = usable .and. allowance > 0
      end do
    end associate
  end subroutine draw_pose

  !> Whether a pose of the left wheel is beside the table, where a run stops with an error.
  pure logical function leaves_table(table, pose)
    type(table_type), intent(in) :: table
    real(dp), intent(in) :: pose(3)        !! [m, rad]
    type(roll_type) :: roll, opposite
    real(dp) :: energy(2), gradient(3, 2), hessian(6)
    integer :: status

    call find_roll(table, pose(3), .false., roll, opposite, status)
    if (status == inside) call wheel_potential(table, pose, roll, .false., energy, gradient, hessian, status)
    leaves_table = status == outside_lateral .or. status == outside_roll
  end function leaves_table

  !> Compute how far a zone of the left wheel lies inside the rail along the zone's normal [m]; -1 if it does not. `known` is
  !> false if the search failed.
  subroutine direct_penetration(pair, zone, pose, scan, depth, known)
    type(pair_type), intent(in) :: pair
    type(zone_type), intent(in) :: zone
    real(dp), intent(in) :: pose(3)        !! [m, rad]
    type(scan_type), intent(inout) :: scan !! workspace
    real(dp), intent(out) :: depth
    logical, intent(out) :: known
    real(dp) :: station

    known = .true.
    scan%fresh = .true.
    call scan_depth(pair, pose(:2), pose(3), zone%first, zone%last, scan)
    scan%fresh = .false.
    depth = maxval(scan%depth(zone%first:zone%last))
    ! Where the wheel lies too deep for any run, a search for the height at which it touches would take long.
    if (depth <= 0 .or. depth > too_deep) return
    call touch(pair, scan, zone%first, zone%last, pose(:2), pose(3), zone%alpha, depth, station, known)
    if (.not. known) depth = -1
  end subroutine direct_penetration

  !> Compare the table's force on the left wheel with the direct one.
  subroutine compare_forces(request, elements, table, pose, error, touching, ok)
    type(request_type), intent(in) :: request
    type(elements_type), intent(in) :: elements
    type(table_type), intent(in) :: table
    real(dp), intent(in) :: pose(3)        !! [m, rad]
    real(dp), intent(out) :: error         !! relative to max(|F|, force_floor)
    logical, intent(out) :: touching(2)    !! tread and flange, by the direct evaluation
    logical, intent(out) :: ok             !! whether the direct evaluation converged
    type(roll_type) :: roll, opposite
    real(dp) :: energy(2), gradient(3, 2), hessian(6), exact(2)
    logical :: carrying(size(table%zones))
    integer :: status

    call find_roll(table, pose(3), .false., roll, opposite, status)
    gradient = 0
    if (status == inside) call wheel_potential(table, pose, roll, .false., energy, gradient, hessian, status)
    call direct_force(request, elements, pose, exact, carrying, ok)
    touching = [any(carrying .and. .not. table%zones%past_root), any(carrying .and. table%zones%past_root)]
    if (status /= inside) gradient = 0
    error = norm2(-sum(gradient(:2, :), 2) - exact)/max(norm2(exact), force_floor)
  end subroutine compare_forces

  !> Compute the force [N] (y, z) of the rail on the left wheel in a pose, without a table, and which zones carry. `ok` is false
  !> if a half-space solution did not converge.
  subroutine direct_force(request, elements, pose, force, carrying, ok)
    type(request_type), intent(in) :: request
    type(elements_type), intent(in) :: elements   !! of half-spaces
    real(dp), intent(in) :: pose(3)        !! [m, rad]
    real(dp), intent(out) :: force(2)
    logical, intent(out) :: carrying(:)    !! (zone)
    logical, intent(out) :: ok
    ! Step of the central difference of the energy, relative to the largest overlap. The energy on a grid is far more exact
    ! than the sum of the loads.
    real(dp), parameter :: share_halfspace = 0.02_dp, share = 1e-3_dp
    real(dp) :: energy(2), step, way(2), depth
    type(patches_type), dimension(merge(size(request%side%zones), 1, request%influence == 'apart')) :: middle, beside
    type(scan_type) :: scan
    real(dp) :: moduli(merge(0, size(request%side%pair%s), request%model == 'halfspace'))
    logical :: solved, touching(size(carrying)), halfspace
    integer :: i, k, z

    force = 0
    ok = .true.
    halfspace = request%model == 'halfspace'
    if (halfspace) then
      call press_wheel(request, elements, pose, middle, energy(1), carrying, ok)
      step = share_halfspace*maxval([(maxval(middle(i)%overlaps%list%depth), i=1, size(middle))])
    else
      scan = new_scan(request%side%pair)
      moduli = 0
      do z = 1, merge(size(carrying), 0, request%model == 'strip')
        call set_moduli(request%side%pair, request%side%zones(z), request%e_star, pose(3), moduli)
      end do
      call press_springs(request, pose, moduli, scan, energy(1), carrying, depth)
      step = share*depth
    end if
    if (.not. any(carrying)) return
    do i = 1, 2
      do k = 1, 2
        way = merge(sign(step, k - 1.5_dp), 0.0_dp, [1, 2] == i)
        if (halfspace) then
          call press_wheel(request, elements, [pose(:2) + way, pose(3)], beside, energy(k), touching, solved, middle)
          ok = ok .and. solved
        else
          call press_springs(request, [pose(:2) + way, pose(3)], moduli, scan, energy(k), touching, depth)
        end if
      end do
      force(i) = (energy(1) - energy(2))/(2*step)
    end do
  end subroutine direct_force

  !> Compute the energy [J] of strips or of Hertz's springs at the left wheel in a pose, which zones carry, and the largest
  !> depth [m].
  subroutine press_springs(request, pose, moduli, scan, energy, carrying, depth)
    type(request_type), intent(in) :: request     !! of model 'strip' or 'hertz'
    real(dp), intent(in) :: pose(3)        !! [m, rad]
    real(dp), intent(in) :: moduli(:)      !! of strips, at all stations [Pa]
    type(scan_type), intent(inout) :: scan !! fresh, or of a pose nearby
    real(dp), intent(out) :: energy, depth
    logical, intent(out) :: carrying(:)    !! (zone)
    integer :: z

    energy = 0
    depth = 0
    associate (pair => request%side%pair, zones => request%side%zones)
      call scan_depth(pair, pose(:2), pose(3), minval(zones%first), maxval(zones%last), scan)
      scan%fresh = .false.
      do z = 1, size(zones)
        carrying(z) = any(scan%depth(zones(z)%first:zones(z)%last) > 0)
        if (.not. carrying(z)) cycle
        depth = max(depth, maxval(scan%depth(zones(z)%first:zones(z)%last)))
        energy = energy + zone_energy(pair, zones(z), request%model, request%e_star, pose(3), scan, moduli)
      end do
    end associate
  end subroutine press_springs

  !> Compute the energy [J] of half-spaces at the left wheel in a pose, and which zones carry.
  subroutine press_wheel(request, elements, pose, patches, energy, carrying, ok, nearby)
    type(request_type), intent(in) :: request
    type(elements_type), intent(in) :: elements
    real(dp), intent(in) :: pose(3)        !! [m, rad]
    type(patches_type), intent(inout) :: patches(:)  !! of the wheel, or of every zone if zones are apart
    real(dp), intent(out) :: energy
    logical, intent(out) :: carrying(:)    !! (zone)
    logical, intent(out) :: ok
    type(patches_type), intent(in), optional :: nearby(:)   !! patches of a pose nearby
    type(scan_type) :: scan
    real(dp) :: part(3)
    integer :: i, z, first, last

    energy = 0
    ok = .true.
    associate (pair => request%side%pair, zones => request%side%zones)
      scan = new_scan(pair)
      call scan_depth(pair, pose(:2), pose(3), minval(zones%first), maxval(zones%last), scan)
      do i = 1, size(patches)
        first = merge(zones(i)%first, minval(zones%first), size(patches) > 1)
        last = merge(zones(i)%last, maxval(zones%last), size(patches) > 1)
        if (present(nearby)) then
          call press_patches(pair, elements, first, last, pose(:2), pose(3), scan, patches(i), nearby(i))
        else
          call press_patches(pair, elements, first, last, pose(:2), pose(3), scan, patches(i))
        end if
        energy = energy + patches(i)%energy
        ok = ok .and. patches(i)%ok
      end do
      do z = 1, size(zones)
        part = force_between(patches(min(z, size(patches))), pair%s(zones(z)%first), pair%s(zones(z)%last))
        carrying(z) = any(abs(part) > 0)
      end do
    end associate
  end subroutine press_wheel

end module table_error
