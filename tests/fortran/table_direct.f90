!> Left-wheel contact at given poses, from the table and by direct evaluation.
!>
!> usage: table_direct input.nml < poses
!> Reads lines `y z roll` (axle centre above top of rail) from standard input; writes for
!> tread, then flange: F_y, F_z, M_x and energy from the table, the same directly.  The
!> direct force is that of strips, whatever the model.
program table_direct
  use case, only: case_type
  use shared, only: direct_type, new_direct, read_prepared, zone_contact
  use kinds, only: dp
  use run_setup, only: setup_type
  use wheelset, only: contact_state, contacts
  implicit none
  save
  type(case_type) :: c
  type(setup_type) :: setup
  type(direct_type) :: direct
  type(contact_state) :: state
  real(dp) :: pose(3), forces(3, 2), energies(2), force(3), energy
  integer :: stat, z, branch

  call read_prepared(c, setup)
  direct = new_direct(c, setup)
  do
    read (*, *, iostat=stat) pose
    if (stat /= 0) exit
    call contacts(setup%wheelset, pose, state)
    if (state%status /= 0) error stop 'a pose is not on the table'
    forces = 0
    energies = 0
    do z = 1, size(setup%side(1)%zones)
      branch = merge(2, 1, setup%side(1)%zones(z)%flange)
      call zone_contact(direct, setup, z, pose, energy, force)
      forces(:, branch) = forces(:, branch) + force
      energies(branch) = energies(branch) + energy
    end do
    write (*, '(16es24.16)') (-state%slope(:, branch), state%energy(branch), forces(:, branch), &
      energies(branch), branch=1, 2)
  end do
end program table_direct
