!> What the program makes of profile files, without a contact table.
!>
!> usage: read_profiles other < files
!> Reads lines `kind path`, kind in two columns, 1 for a wheel that goes on the rail `other`, 2 for a rail that carries the
!> wheel `other`; writes for each the error or, of a negative kind too, the clearance [m], else `good`.
program read_profiles
  use case, only: case_type
  use contact_zones, only: find_zones, least_turn
  use errors, only: error_type
  use placement, only: place_profiles
  use profile, only: is_rail, is_wheel, read_profile
  use geometry_functions, only: clearance
  use run_setup, only: setup_type
  implicit none
  save
  type(error_type), allocatable :: error
  type(setup_type) :: setup
  type(case_type) :: c
  character(256) :: other, path
  integer :: kind, stat
  logical :: ok

  call get_command_argument(1, other)
  do
    read (*, '(i2, 1x, a)', iostat=stat) kind, path
    if (stat /= 0) exit
    c%wheel_profile = merge(path, other, abs(kind) == is_wheel)
    c%rail_profile = merge(path, other, abs(kind) == is_rail)
    call read_profile(trim(c%wheel_profile), is_wheel, setup%wheel(1), error)
    if (.not. allocated(error)) call read_profile(trim(c%rail_profile), is_rail, setup%rail(1), error)
    if (.not. allocated(error)) call place_profiles(setup%wheel(1)%curve, setup%rail(1)%curve, &
      setup%wheel(1)%file, setup%rail(1)%file, c%gauge, c%gauge_depth, c%back_to_back, c%rolling_radius, setup%side(1)%pair, error)
    if (.not. allocated(error)) call find_zones(setup%side(1)%pair, least_turn, setup%side(1)%zones)
    setup%side(1)%threshold = [cos(c%flange_angle), sin(c%flange_angle)]
    if (allocated(error)) then
      write (*, '(a)') error%message
    else if (kind > 0) then
      write (*, '(a)') 'good'
    else
      setup%side(2) = setup%side(1)
      call clearance(setup%side, setup%side(1)%clearance, ok)
      write (*, '(es24.16)') merge(setup%side(1)%clearance, -1.0d0, ok)
    end if
  end do
end program read_profiles
