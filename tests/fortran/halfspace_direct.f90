!> Left-wheel contact forces at given poses, from the table of the case's model and from direct half-space solutions.
!>
!> usage: halfspace_direct input.nml < poses
!> Reads lines `y z roll` (axle centre above top of rail) from standard input; writes for tread and flange: F_y, F_z, M_x
!> from the table, then directly, with the whole wheel as one elastic system.
program halfspace_direct
  use case, only: case_type
  use shared, only: direct_type, new_direct, read_prepared, wheel_contact
  use kinds, only: dp
  use run_setup, only: setup_type
  use wheelset, only: contact_state, contacts
  implicit none
  save
  type(case_type) :: c
  type(setup_type) :: setup
  type(direct_type) :: direct
  type(contact_state) :: state
  real(dp) :: pose(3), forces(3, 2), energy
  integer :: stat, branch

  call read_prepared(c, setup)
  direct = new_direct(c, setup)
  do
    read (*, *, iostat=stat) pose
    if (stat /= 0) exit
    call contacts(setup%wheelset, pose, state, wheel=1)
    if (state%status /= 0) error stop 'a pose is not on the table'
    call wheel_contact(direct, setup, pose, energy, forces)
    write (*, '(12es24.16)') (-state%slope(:, branch), forces(:, branch), branch=1, 2)
  end do
end program halfspace_direct
