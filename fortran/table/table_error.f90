!> The error of a contact table: its forces against direct evaluation, at poses between its points.
!>
!> Poses follow one another as an additive recurrence (R. Kronecker's sequence), the same for every
!> table: a station of the wheel touches the rail's point of the same normal, at some roll angle, pressed
!> in by some depth.  Those count that a run can come to.  The table is not asked how deep a zone lies in
!> the rail: a contact that it misses is an error of all its force.
module table_error
  use contact_zones, only: zone_type
  use strip_law, only: set_moduli, stiffest, zone_energy, zone_force
  use station_scan, only: new_scan, scan_depth, scan_type, touch
  use wheel_rail_pair, only: pair_type, rail_point, rolled
  use kinds, only: dp
  use halfspace_patches, only: patches_type, press_patches
  use patch_grids, only: elements_type, new_elements
  use contact_table, only: accuracy_type, table_type, find_roll, inside, roll_type, wheel_potential
  use service_poses, only: extent_type, find_reach, first_roll, last_roll, least_force, strictness
  implicit none
  private
  public :: measure, direct_force

  ! Poses in service and going over; half-spaces take far longer than strips.
  integer, parameter :: of_strips(2) = [1000, 200], of_halfspaces(2) = [600, 200], tries = 240000
  ! Square roots of primes, less their whole part.
  real(dp), parameter :: steps(4) = [0.414213562373095_dp, 0.732050807568877_dp, 0.236067977499790_dp, &
    0.645751311064591_dp]

contains

  !> Fill in the errors of a table of 'strip' or 'halfspace'.
  subroutine measure(pair, zones, model, e_star, extent, table)
    type(pair_type), intent(in) :: pair
    type(zone_type), intent(in) :: zones(:)
    character(*), intent(in) :: model
    real(dp), intent(in) :: e_star         !! [Pa]
    type(extent_type), intent(in) :: extent
    type(table_type), intent(inout) :: table
    type(elements_type) :: elements
    type(scan_type) :: scan
    ! The rail's height over its width [m]: a vertical depth of `hopeless` is no penetration that a run comes to.
    real(dp), parameter :: strip = 0.5e-3_dp, hopeless = 10e-3_dp
    real(dp), allocatable :: top(:)
    real(dp) :: gauge_side
    real(dp), allocatable :: pose(:, :), error(:)
    integer, allocatable :: place(:)
    logical, allocatable :: touching(:, :), solved(:)
    integer :: wanted(2), drawn(2), i, n

    table%accuracy = accuracy_type()
    if (model == 'hertz') return
    wanted = of_strips
    if (model == 'halfspace') wanted = of_halfspaces
    scan = new_scan(pair)
    gauge_side = minval(pair%rail%a(1, 1, :))
    allocate (top(0:floor((maxval(pair%rail%a(1, 1, :)) - gauge_side)/strip)), source=-1.0_dp)
    do i = 1, pair%rail%n
      n = floor((pair%rail%a(1, 1, i) - gauge_side)/strip)
      top(n) = max(top(n), pair%rail%a(2, 1, i))
    end do
    n = sum(wanted)
    allocate (pose(3, n), error(n), place(n), touching(2, n), solved(n))
    drawn = 0
    do i = 1, tries
      if (all(drawn >= wanted)) exit
      call draw(i, pose(:, min(sum(drawn) + 1, sum(wanted))), n)
      if (n == 0) cycle
      drawn(n) = drawn(n) + 1
      place(sum(drawn)) = n
    end do
    if (model == 'halfspace') elements = new_elements(8, 32, 1e-4_dp, e_star)
    n = sum(drawn)
    !$omp parallel do schedule(dynamic)
    do i = 1, n
      call compare(pose(:, i), error(i), touching(:, i), solved(i))
    end do
    table%accuracy%unsolved = count(.not. solved(:n))
    where (place(:n) == 2)
      place(:n) = 4
    elsewhere (touching(2, :n))
      place(:n) = merge(3, 2, touching(1, :n))
    end where
    do i = 1, 4
      associate (here => place(:n) == i .and. solved(:n))
        table%accuracy%poses(i) = count(here)
        if (.not. any(here)) cycle
        table%accuracy%rms(i) = sqrt(sum(error(:n)**2, here)/count(here))
        table%accuracy%largest(i) = maxval(error(:n), here)
      end associate
    end do

  contains

    !> The i-th pose; n: in service (1), going over (2), or none that counts.
    subroutine draw(i, pose, n)
      integer, intent(in) :: i
      real(dp), intent(out) :: pose(3)
      integer, intent(out) :: n
      real(dp) :: x(4), point(2), normal(2), other, depth, strict, depths(size(zones), 2)
      integer :: z, j, k, side
      logical :: ok, within

      n = 0
      x = modulo(i*steps, 1.0_dp)
      z = 1 + mod(i, size(zones))
      k = zones(z)%first + nint(x(1)*(zones(z)%last - zones(z)%first))
      ! Every other one goes over.
      pose(3) = 0.02_dp*(2*x(2) - 1)
      if (modulo(i/size(zones), 2) == 1) pose(3) = first_roll - (first_roll + last_roll)*x(2)
      depth = extent%depth*merge(1.0_dp, 0.45_dp, zones(z)%flange)*x(3)**2
      call rail_point(pair, pair%angle(k) + pose(3), point, normal, ok)
      if (.not. ok) return
      pose(:2) = point - rolled(pair%r(:, k), pose(3)) - depth*normal
      strict = strictness(pair, extent, pose, .false.)
      k = merge(1, 2, modulo(i/size(zones), 2) == 0)
      if (strict < 1 .or. (strict > 1 .neqv. k == 2) .or. drawn(k) >= wanted(k)) return
      ! A run that leaves the extent of its table stops and says so.
      if (abs(pose(1) + pair%axle_height*sin(pose(3))) > extent%lateral) return
      depths = -1
      depths(z, 1) = penetration(zones(z), pose)
      if (depths(z, 1) <= 0 .or. depths(z, 1) > extent%depth) return
      ! The left wheel first: it is enough for most poses that are out of reach.
      do side = 1, 2
        do j = 1, size(zones)
          if (side == 1 .and. j == z) cycle
          depths(j, side) = penetration(zones(j), merge(1, -1, [side == 1, .true., side == 1])*pose)
        end do
        call find_reach(table, extent, z, depths(z, 1), pose, .false., within, other, depths)
        if (.not. within) return
      end do
      n = k
    end subroutine draw

    !> How far a zone of the left wheel lies inside the rail along its normal [m]; -1 where it does not.
    real(dp) function penetration(zone, pose) result(depth)
      type(zone_type), intent(in) :: zone
      real(dp), intent(in) :: pose(3)
      real(dp) :: x(2), y(2), z(2), station
      integer :: first, last, i, j
      logical :: ok

      depth = -1
      y = rolled([1.0_dp, 0.0_dp], pose(3))
      z = [-y(2), y(1)]
      first = 0
      do i = zone%first, zone%last
        x = pose(:2) + (pair%r(1, i)*y + pair%r(2, i)*z)
        j = floor((x(1) - gauge_side)/strip)
        if (j < 0 .or. j > ubound(top, 1) .or. x(2) >= 0) cycle
        ! No foot is looked for where the wheel lies too deep for any run: the search would be long.
        if (x(2) < top(j) - hopeless) then
          depth = hopeless
          return
        end if
        if (first == 0) first = i
        last = i
      end do
      if (first == 0) return
      first = max(zone%first, first - 1)
      last = min(zone%last, last + 1)
      scan%fresh = .true.
      call scan_depth(pair, pose(:2), pose(3), first, last, scan)
      scan%fresh = .false.
      ok = any(scan%depth(first:last) > 0)
      if (ok) call touch(pair, scan, first, last, pose(:2), pose(3), zone%alpha, depth, station, ok)
      if (.not. ok) depth = -1
    end function penetration

    subroutine compare(pose, error, touching, ok)
      real(dp), intent(in) :: pose(3)
      real(dp), intent(out) :: error
      logical, intent(out) :: touching(2), ok    !! of tread and flange; whether the direct evaluation converged
      type(roll_type) :: roll, opposite
      real(dp) :: energy(2), gradient(3, 2), hessian(6), exact(2, 2), wheel(2)
      integer :: status

      call find_roll(table, pose(3), .false., roll, opposite, status)
      gradient = 0
      if (status == inside) call wheel_potential(table, pose, roll, .false., energy, gradient, hessian, status)
      call direct_force(pair, zones, model, e_star, elements, pose, exact, ok)
      touching = abs(exact(1, :)) + abs(exact(2, :)) > 0
      wheel = sum(exact, 2)
      if (status /= inside) gradient = 0
      error = norm2(-sum(gradient(:2, :), 2) - wheel)/max(norm2(wheel), least_force)
    end subroutine compare

  end subroutine measure

  !> Force [N] (y, z) on tread and flange of the left wheel in a pose, without a table.
  subroutine direct_force(pair, zones, model, e_star, elements, pose, force, ok)
    type(pair_type), intent(in) :: pair
    type(zone_type), intent(in) :: zones(:)
    character(*), intent(in) :: model      !! 'strip' or 'halfspace'
    real(dp), intent(in) :: e_star         !! [Pa]
    type(elements_type), intent(in) :: elements   !! of half-spaces
    real(dp), intent(in) :: pose(3)        !! [m, rad]
    real(dp), intent(out) :: force(2, 2)
    logical, intent(out) :: ok
    type(scan_type) :: work
    type(patches_type) :: patches
    type(zone_type) :: pressed
    real(dp) :: k(size(pair%s)), part(3), energy, strip(2)
    integer :: z, branch, first, last

    force = 0
    strip = 0
    ok = .true.
    work = new_scan(pair)
    do z = 1, size(zones)
      work%fresh = .true.
      call scan_depth(pair, pose(:2), pose(3), zones(z)%first, zones(z)%last, work)
      associate (sunk => work%depth(zones(z)%first:zones(z)%last) > 0)
        if (.not. any(sunk)) cycle
        ! The stations inside the rail and their neighbours.
        pressed = zones(z)
        pressed%first = max(zones(z)%first, zones(z)%first + findloc(sunk, .true., 1) - 2)
        pressed%last = min(zones(z)%last, zones(z)%first + findloc(sunk, .true., 1, back=.true.))
      end associate
      call set_moduli(pair, pressed, e_star, pose(3), k)
      branch = merge(2, 1, zones(z)%flange)
      part = zone_force(pair, pressed, pose(3), work, k)
      force(:, branch) = force(:, branch) + part(:2)
      strip(branch) = strip(branch) + zone_energy(pair, pressed, 'strip', e_star, pose(3), work, k)
    end do
    if (model /= 'halfspace') return
    do branch = 1, 2
      if (strip(branch) <= 0) cycle
      first = minval(zones%first, zones%flange .eqv. branch == 2)
      last = maxval(zones%last, zones%flange .eqv. branch == 2)
      work%fresh = .true.
      patches%n = 0
      call scan_depth(pair, pose(:2), pose(3), first, last, work)
      call press_patches(pair, elements, first, last, pose(:2), pose(3), work, patches, energy, ok, part)
      ok = ok .and. patches%unsolved == 0
      if (.not. ok) return
      if (energy < stiffest*strip(branch)) then
        force(:, branch) = part(:2)
      else
        force(:, branch) = stiffest*force(:, branch)
      end if
    end do
  end subroutine direct_force

end module table_error