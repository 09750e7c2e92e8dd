!> The error that a table of strips states: as it is, without its flange, and with the opposite sign of S.
!>
!> usage: missed_contact case.nml
!> Prints for each of the three tables the largest error on the tread and on the flange, of max(|F|, 5 kN), and the number
!> of points in service at which the contact would pull, and the status of the pose at rest.
program missed_contact
  use table_error, only: measure
  use case, only: case_type
  use kinds, only: dp
  use zone_tables, only: bound_heights
  use run_tables, only: table_request
  use shared, only: read_prepared
  use run_setup, only: setup_type
  use wheelset, only: contact_state, contacts
  implicit none
  save
  type(case_type) :: c
  type(setup_type), target :: setup
  type(contact_state) :: state
  integer :: k, z
  logical :: stopped

  call read_prepared(c, setup)
  associate (table => setup%wheelset%table)
    do k = 1, 3
      do z = 1, size(table%zones)
        if (k == 3) table%zones(z)%s = -table%zones(z)%s
        if (k /= 2 .or. .not. table%zones(z)%flange) cycle
        table%zones(z)%h = table%zones(z)%h - 1.0_dp
        call bound_heights(table%zones(z))
      end do
      call measure(table_request(c, setup%side(1)), table, stopped)
      call contacts(setup%wheelset, setup%equilibrium, state)
      print '(2es12.4, i8, i2)', table%accuracy%largest(:2), table%accuracy%pulling, state%status
    end do
  end associate
end program missed_contact
