!> Files as the contact table of a case, whatever they hold.
!>
!> usage: load_tables case.nml < paths
!> Answers for each path, one a line: used or missing.
program load_tables
  use case, only: case_type
  use contact_table, only: table_type
  use shared, only: read_prepared
  use run_setup, only: setup_type
  use table_file, only: load_values
  use table_layout, only: lay_out
  implicit none
  save
  type(case_type) :: c
  type(setup_type) :: setup
  type(table_type) :: table
  character(256) :: path
  integer :: status

  call read_prepared(c, setup)
  call lay_out(setup%wheelset%table%law, setup%wheelset%table%key, table)
  do
    read (*, '(a)', iostat=status) path
    if (status /= 0) exit
    call answer()
  end do

contains

  subroutine answer()
    logical :: found

    call load_values(trim(path), table, found)
    print '(a)', trim(merge('used   ', 'missing', found))
    flush (6)
  end subroutine answer

end program load_tables
