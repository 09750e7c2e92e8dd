!> Elastic energy of a left wheel that is lowered onto its rail, by half-spaces as for contact tables.
!>
!> usage: press_wheel wheel rail < problems
!> Reads lines `rolling_radius depth` [m] from standard input, the depth from where the centred wheel touches; writes
!> the energy [J] and the vertical force [N].
program press_wheel
  use case, only: case_type
  use errors, only: error_type
  use placement, only: place_profiles
  use station_scan, only: new_scan, scan_depth, scan_type
  use wheel_rail_pair, only: pair_type
  use hertz, only: contact_modulus
  use kinds, only: dp
  use halfspace_patches, only: force_between, patches_type, press_patches
  use patch_grids, only: elements_type
  use profile, only: is_rail, is_wheel, profile_type, read_profile
  implicit none
  save
  type(error_type), allocatable :: error
  type(case_type) :: c
  type(profile_type) :: wheel, rail
  type(pair_type) :: pair
  type(scan_type) :: work
  type(elements_type) :: elements
  type(patches_type) :: patches
  character(256) :: file(2)
  real(dp) :: radius, depth, centre(2), force(3)
  integer :: stat

  call get_command_argument(1, file(1))
  call get_command_argument(2, file(2))
  call read_profile(trim(file(1)), is_wheel, wheel, error)
  if (.not. allocated(error)) call read_profile(trim(file(2)), is_rail, rail, error)
  elements = elements_type(8, 32, 1e-4_dp, contact_modulus(c%youngs_modulus, c%poisson), .false.)
  do
    if (allocated(error)) error stop error%message
    read (*, *, iostat=stat) radius, depth
    if (stat /= 0) exit
    call place_profiles(wheel%curve, rail%curve, wheel%file, rail%file, c%gauge, c%gauge_depth, c%back_to_back, radius, &
      pair, error)
    if (allocated(error)) cycle
    centre = [0.0_dp, pair%axle_height - depth]
    work = new_scan(pair)
    call scan_depth(pair, centre, 0.0_dp, 1, size(pair%s), work)
    call press_patches(pair, elements, 1, size(pair%s), centre, 0.0_dp, work, patches)
    if (.not. patches%ok) error stop 'the half-space solution failed'
    force = force_between(patches, pair%s(1), pair%s(size(pair%s)))
    write (*, '(2es24.16)') patches%energy, force(2)
  end do
end program press_wheel
