!> Zones of the left wheel.
!>
!> usage: zone_cuts input.nml
!> Writes the numbers of the wheel's stations and zones, and of each of at most six zones: first and last station, its length
!> [mm], 1 for the flange's side.
program zone_cuts
  use case, only: case_type
  use case_reader, only: read_case
  use contact_zones, only: max_zones
  use errors, only: error_type
  use kinds, only: dp
  use run_setup, only: place_sides, setup_type
  use text, only: line_type, read_lines
  implicit none
  save
  type(case_type) :: c
  type(setup_type) :: setup
  type(error_type), allocatable :: error
  type(line_type), allocatable :: lines(:)
  character(256) :: file
  real(dp) :: found(4, max_zones)
  integer :: z

  call get_command_argument(1, file)
  call read_lines(trim(file), lines, error)
  if (.not. allocated(error)) call read_case(trim(file), lines, c, error)
  if (.not. allocated(error)) call place_sides(c, setup, error)
  if (allocated(error)) error stop error%message
  associate (pair => setup%side(1)%pair, zones => setup%side(1)%zones)
    found = 0
    do z = 1, size(zones)
      found(:, z) = [real(zones(z)%first, dp), real(zones(z)%last, dp), &
        1e3_dp*(pair%s(zones(z)%last) - pair%s(zones(z)%first)), merge(1.0_dp, 0.0_dp, zones(z)%flange)]
    end do
    write (*, '(2i5, *(2f7.0, f10.4, f4.0))') size(pair%s), size(zones), found
  end associate
end program zone_cuts
