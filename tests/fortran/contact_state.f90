!> The elastic potential of the whole wheelset at given poses.
!>
!> usage: contact_state input.nml < poses
!> Writes a line `equilibrium, rigid height (axle centre above top of rail), clearance to the left` [m],
!> then for each line `y z roll` that it reads: energy of LT LF RT RF, the gradient of each
!> (4 x 3), the Hessian of their sum (yy yz yr zz zr rr), and 0 or why it is off the table.
program contact_state
  use case, only: case_type
  use shared, only: read_prepared
  use kinds, only: dp
  use run_setup, only: setup_type
  use wheelset, only: state_type => contact_state, contacts
  implicit none
  save
  type(case_type) :: c
  type(setup_type) :: setup
  type(state_type) :: state
  real(dp) :: pose(3)
  integer :: stat

  call read_prepared(c, setup)
  write (*, '(3es24.16)') setup%equilibrium(2), setup%centred(2), setup%side(1)%clearance
  do
    read (*, *, iostat=stat) pose
    if (stat /= 0) exit
    call contacts(setup%wheelset, pose, state)
    write (*, '(22es24.16,i3)') state%energy, state%slope, state%hessian, state%status
  end do
end program contact_state
