!> What happens where something is wrong that no input brings about.
!>
!> usage: error_paths case.nml
!> Prints an error that quotes the one before it, and the statuses of the pose at rest: as the table is, and where its S
!> has the other sign.
program error_paths
  use case, only: case_type
  use errors, only: error_type, fatal_error
  use shared, only: read_prepared
  use run_setup, only: setup_type
  use wheelset, only: contact_state, contacts
  implicit none
  save
  type(case_type) :: c
  type(setup_type) :: setup
  type(error_type), allocatable :: error
  type(contact_state) :: state
  integer :: sound, z

  call fatal_error(error, 'spline: singular system, repeated points?')
  call fatal_error(error, 'wheel.yz: '//error%message)
  print '(a)', error%message
  call read_prepared(c, setup)
  call contacts(setup%wheelset, setup%equilibrium, state)
  sound = state%status
  do z = 1, size(setup%wheelset%table%zones)
    setup%wheelset%table%zones(z)%s = -setup%wheelset%table%zones(z)%s
  end do
  call contacts(setup%wheelset, setup%equilibrium, state)
  print '(2i2)', sound, state%status
end program error_paths
