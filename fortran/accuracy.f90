!> The error of a contact table: its forces against direct evaluation, at poses between its points.
!>
!> Poses follow one another as an additive recurrence (R. Kronecker's sequence), the same for every
!> table: a station of the wheel touches the rail's point of the same normal, at some roll angle, pressed
!> in by some depth.  Those count that a run can come to.
module accuracy
  use contact, only: set_moduli, zone_force, zone_type
  use geometry, only: new_scan, pair_type, rail_point, rolled, scan_depth, scan_type
  use kinds, only: dp
  use patches, only: elements_type, new_elements, patches_type, press_patches
  use potential, only: accuracy_type, contact_table, find_roll, height_over, inside, roll_type, wheel_potential
  use reach, only: extent_type, find_reach, least_force, strictness
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
    type(contact_table), intent(inout) :: table
    type(elements_type) :: elements
    real(dp), allocatable :: pose(:, :), error(:)
    integer, allocatable :: place(:)
    logical, allocatable :: touching(:, :)
    integer :: wanted(2), drawn(2), i, n

    table%accuracy = accuracy_type()
    if (model == 'hertz') return
    wanted = of_strips
    if (model == 'halfspace') wanted = of_halfspaces
    n = sum(wanted)
    allocate (pose(3, n), error(n), place(n), touching(2, n))
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
      call compare(pose(:, i), error(i), touching(:, i))
    end do
    where (place(:n) == 2)
      place(:n) = 4
    elsewhere (touching(2, :n))
      place(:n) = merge(3, 2, touching(1, :n))
    end where
    do i = 1, 4
      table%accuracy%poses(i) = count(place(:n) == i)
      if (table%accuracy%poses(i) == 0) cycle
      table%accuracy%rms(i) = sqrt(sum(error(:n)**2, place(:n) == i)/count(place(:n) == i))
      table%accuracy%largest(i) = maxval(error(:n), place(:n) == i)
    end do

  contains

    !> The i-th pose; n: in service (1), going over (2), or none that counts.
    subroutine draw(i, pose, n)
      integer, intent(in) :: i
      real(dp), intent(out) :: pose(3)
      integer, intent(out) :: n
      type(roll_type) :: roll, opposite
      real(dp) :: x(4), point(2), normal(2), other, depth, strict
      integer :: z, k, status
      logical :: ok, within

      n = 0
      x = modulo(i*steps, 1.0_dp)
      z = 1 + mod(i, size(zones))
      k = zones(z)%first + nint(x(1)*(zones(z)%last - zones(z)%first))
      ! Every other one goes over.
      pose(3) = 0.02_dp*(2*x(2) - 1)
      if (modulo(i/size(zones), 2) == 1) pose(3) = 0.02_dp - 0.35_dp*x(2)
      depth = extent%depth*merge(1.0_dp, 0.45_dp, zones(z)%flange)*x(3)**2
      call rail_point(pair, pair%angle(k) + pose(3), point, normal, ok)
      if (.not. ok) return
      pose(:2) = point - rolled(pair%r(:, k), pose(3)) - depth*normal
      call find_roll(table, pose(3), .false., roll, opposite, status)
      if (status /= inside) return
      depth = height_over(table%zones(z), pose, roll)
      if (depth <= 0 .or. depth > extent%depth) return
      call find_reach(table, extent, z, depth, pose, .false., within, other)
      if (.not. within) return
      strict = strictness(pair, extent, pose, .false.)
      n = merge(1, 2, modulo(i/size(zones), 2) == 0)
      if (strict < 1 .or. (strict > 1 .neqv. n == 2)) n = 0
      if (n > 0) then
        if (drawn(n) >= wanted(n)) n = 0
      end if
    end subroutine draw

    subroutine compare(pose, error, touching)
      real(dp), intent(in) :: pose(3)
      real(dp), intent(out) :: error
      logical, intent(out) :: touching(2)
      type(roll_type) :: roll, opposite
      real(dp) :: energy(2), gradient(3, 2), hessian(6), exact(2, 2), wheel(2)
      integer :: status
      logical :: ok

      call find_roll(table, pose(3), .false., roll, opposite, status)
      call wheel_potential(table, pose, roll, .false., energy, gradient, hessian, status)
      call direct_force(pair, zones, model, e_star, elements, pose, exact, ok)
      touching = abs(exact(1, :)) + abs(exact(2, :)) > 0
      wheel = sum(exact, 2)
      error = 0
      if (ok .and. status == inside) error = norm2(-sum(gradient(:2, :), 2) - wheel)/max(norm2(wheel), least_force)
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
    real(dp) :: k(size(pair%s)), part(3), energy
    integer :: z, branch, first, last

    force = 0
    ok = .true.
    work = new_scan(pair)
    if (model == 'halfspace') then
      do branch = 1, 2
        first = minval(zones%first, zones%flange .eqv. branch == 2)
        last = maxval(zones%last, zones%flange .eqv. branch == 2)
        work%fresh = .true.
        patches%n = 0
        call scan_depth(pair, pose(:2), pose(3), first, last, work)
        call press_patches(pair, elements, first, last, pose(:2), pose(3), work, patches, energy, ok, part)
        if (.not. ok) return
        force(:, branch) = part(:2)
      end do
    else
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
      end do
    end if
  end subroutine direct_force

end module accuracy
