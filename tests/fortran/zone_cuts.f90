!> Zones of the left wheel for many split angles.
!>
!> usage: zone_cuts input.nml < split_angles
!> Reads split angles [rad] from standard input; writes for each: the wheel's stations, where it is refused
!> 0, else the zones, and of each of at most six: first and last station, its length [mm], 1 for the flange.
program zone_cuts
  use case, only: case_type
  use case_reader, only: read_case
  use contact_zones, only: find_zones, max_zones, zone_type
  use errors, only: error_type
  use kinds, only: dp
  use run_setup, only: prepare_geometry, setup_type
  use text, only: line_type, read_lines
  implicit none
  save
  type(case_type) :: c
  type(setup_type) :: setup
  type(error_type), allocatable :: error
  type(line_type), allocatable :: lines(:)
  type(zone_type), allocatable :: zones(:)
  character(256) :: file
  real(dp) :: split, found(4, max_zones)
  integer :: stat, z

  call get_command_argument(1, file)
  call read_lines(trim(file), lines, error)
  if (.not. allocated(error)) call read_case(trim(file), lines, c, error)
  if (.not. allocated(error)) call prepare_geometry(c, setup, error)
  if (allocated(error)) error stop error%message
  associate (pair => setup%side(1)%pair)
    do
      read (*, *, iostat=stat) split
      if (stat /= 0) exit
      call find_zones(pair, split, zones, error)
      found = 0
      if (.not. allocated(error)) then
        do z = 1, size(zones)
          found(:, z) = [real(zones(z)%first, dp), real(zones(z)%last, dp), &
            1e3_dp*(pair%s(zones(z)%last) - pair%s(zones(z)%first)), merge(1.0_dp, 0.0_dp, zones(z)%flange)]
        end do
      end if
      z = 0
      if (.not. allocated(error)) z = size(zones)
      write (*, '(2i5, *(2f7.0, f10.4, f4.0))') size(pair%s), z, found
    end do
  end associate
end program zone_cuts
