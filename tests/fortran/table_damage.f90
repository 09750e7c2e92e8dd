!> Every byte of a contact table's file with one of its bits turned over, and the file cut off at every length.
!>
!> usage: table_damage case.nml file
!> `file` is that of the case.  Prints how often the damaged file was used, refused and counted as missing; the file
!> is whole again, but for the last cut.
program table_damage
  use, intrinsic :: iso_fortran_env, only: int64
  use case, only: case_type
  use errors, only: error_type
  use contact_table, only: table_type
  use shared, only: read_prepared
  use run_setup, only: setup_type
  use table_file, only: load_table
  implicit none
  save
  type(case_type) :: c
  type(setup_type) :: setup
  character(256) :: file
  character :: byte
  integer(int64) :: bytes, i
  integer :: counts(3), unit

  call read_prepared(c, setup)
  call get_command_argument(2, file)
  inquire (file=trim(file), size=bytes)
  counts = 0
  call count_outcome()
  if (any(counts /= [1, 0, 0])) error stop 'the whole file is not used'
  counts = 0
  do i = 1, bytes
    call write_byte(int(ishft(1, int(modulo(i, 8_int64)))))
    call count_outcome()
    call write_byte(int(ishft(1, int(modulo(i, 8_int64)))))
  end do
  do i = bytes - 1, 0, -1
    open (newunit=unit, file=trim(file), access='stream', form='unformatted', status='old')
    if (i > 0) read (unit, pos=i) byte
    endfile (unit)
    close (unit)
    call count_outcome()
  end do
  print '(3i8)', counts

contains

  subroutine write_byte(bit)
    integer, intent(in) :: bit

    open (newunit=unit, file=trim(file), access='stream', form='unformatted', status='old')
    read (unit, pos=i) byte
    write (unit, pos=i) achar(ieor(iachar(byte), bit))
    close (unit)
  end subroutine write_byte

  subroutine count_outcome()
    type(table_type) :: table
    type(error_type), allocatable :: error
    logical :: found

    call load_table(trim(file), setup%wheelset%table%key, table, found, error)
    if (found) counts(1) = counts(1) + 1
    if (allocated(error)) counts(2) = counts(2) + 1
    if (.not. found .and. .not. allocated(error)) counts(3) = counts(3) + 1
  end subroutine count_outcome

end program table_damage
