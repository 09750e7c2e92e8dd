!> The elastic potential of the whole wheelset at given poses.
!>
!> usage: contact_state input.nml < poses
!> Writes a line `equilibrium, rigid height (axle centre above top of rail), clearance` [m],
!> then for each line `y z roll` that it reads: energy of LT LF RT RF, the gradient of each
!> (4 x 3), the Hessian of their sum (yy yz yr zz zr rr), and 0 or why it is off the table.
program contact_state
  use case, only: case_type, read_case
  use errors, only: error_type
  use kinds, only: dp
  use simulation, only: prepare, setup_type
  use text, only: line_type, read_lines
  use wheelset, only: state_type => contact_state, contacts
  implicit none
  type(case_type) :: c
  type(setup_type) :: setup
  type(error_type), allocatable :: error
  type(line_type), allocatable :: lines(:)
  type(state_type) :: state
  real(dp) :: pose(3)
  character(256) :: file
  integer :: stat

  call get_command_argument(1, file)
  call read_lines(trim(file), lines, error)
  if (.not. allocated(error)) call read_case(trim(file), lines, c, error)
  if (.not. allocated(error)) call prepare(c, setup, error)
  if (allocated(error)) error stop error%message
  write (*, '(3es24.16)') setup%equilibrium, setup%pair%axle_height, setup%clearance
  do
    read (*, *, iostat=stat) pose
    if (stat /= 0) exit
    call contacts(setup%wheelset, pose, state)
    write (*, '(22es24.16,i3)') state%energy, state%slope, state%hessian, state%status
  end do
end program contact_state
