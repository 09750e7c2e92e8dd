!> Contact tables in files.
module table_file
  use, intrinsic :: iso_fortran_env, only: int64
  use bspline, only: new_axis
  use contact, only: max_zones
  use errors, only: error_type, fatal_error
  use kinds, only: dp
  use potential, only: accuracy_type, bound_heights, contact_table
  use system, only: finish_file, make_folder, scratch_name
  implicit none
  private
  public :: save_table, load_table

  character(*), parameter :: kind = 'ldbench contact table', magic = kind//' 10'

contains

  !> Write a table to a file, complete or not at all.
  subroutine save_table(file, table, error)
    character(*), intent(in) :: file
    type(contact_table), intent(in) :: table
    type(error_type), allocatable, intent(out) :: error
    character(:), allocatable :: scratch
    integer :: unit, stat, i

    call make_folder(file)
    scratch = scratch_name(file)
    open (newunit=unit, file=scratch, access='stream', form='unformatted', action='write', &
      status='replace', iostat=stat)
    if (stat /= 0) then
      call fatal_error(error, '&table file = '//file//': cannot be written')
      return
    end if
    write (unit, iostat=stat) magic, len(table%key), table%key, size(table%zones), table%accuracy
    do i = 1, size(table%zones)
      associate (t => table%zones(i))
        if (stat == 0) write (unit, iostat=stat) t%flange, t%along, t%pole, t%origin, t%ceiling, &
          t%u%n, t%roll%n, t%q%n, t%u%x, t%roll%x, t%q%x, t%h, t%s
      end associate
    end do
    if (stat == 0) write (unit, iostat=stat) fingerprint(table), magic
    call finish_file(unit, scratch, file, stat)
    if (stat /= 0) call fatal_error(error, '&table file = '//file//': cannot be written')
  end subroutine save_table

  !> Read a table that was made for `key`; `found` is false when the file is absent, damaged or
  !> made for something else.  An error when it is no table: it would be lost.
  subroutine load_table(file, key, table, found, error)
    character(*), intent(in) :: file, key
    type(contact_table), intent(out) :: table
    logical, intent(out) :: found
    type(error_type), allocatable, intent(out) :: error
    character(len(magic)) :: mark
    character(len(key)) :: stored
    type(accuracy_type) :: accuracy
    real(dp), allocatable :: u(:), roll(:), q(:)
    integer :: unit, stat, length, n, i, points(3)
    integer(int64) :: sum_stored, bytes

    found = .false.
    open (newunit=unit, file=file, access='stream', form='unformatted', action='read', &
      status='old', iostat=stat)
    if (stat /= 0) return
    inquire (unit=unit, size=bytes)
    n = int(min(bytes, len(kind, int64)))
    read (unit, iostat=stat) mark(:n)
    if (stat /= 0 .or. mark(:n) /= kind(:n)) then
      call fatal_error(error, '&table file = '//file//': expected a contact table or no file, found another one')
      close (unit)
      return
    end if
    read (unit, pos=1, iostat=stat) mark, length
    if (stat == 0) found = mark == magic .and. length == len(key)
    if (found) then
      read (unit, iostat=stat) stored, n, accuracy
      found = stat == 0
      if (found) found = stored == key .and. n >= 1 .and. n <= max_zones
    end if
    if (found) then
      table%key = key
      table%accuracy = accuracy
      allocate (table%zones(n))
      do i = 1, n
        associate (t => table%zones(i))
          read (unit, iostat=stat) t%flange, t%along, t%pole, t%origin, t%ceiling, points
          if (stat == 0 .and. any(points < 5 .or. points > 10000)) stat = 1
          if (stat /= 0) exit
          allocate (u(points(1)), roll(points(2)), q(points(3)), t%h(points(2) + 2, points(1) + 2), &
            t%s(points(3) + 2, points(2) + 2, points(1) + 2), stat=stat)
          if (stat == 0) read (unit, iostat=stat) u, roll, q, t%h, t%s
          if (stat == 0) then
            if (.not. (rising(u) .and. rising(roll) .and. rising(q))) stat = 1
          end if
          if (stat /= 0) exit
          t%u = new_axis(u)
          t%roll = new_axis(roll)
          t%q = new_axis(q)
          deallocate (u, roll, q)
        end associate
      end do
      if (stat == 0) read (unit, iostat=stat) sum_stored, mark
      found = stat == 0
      if (found) found = mark == magic
      if (found) found = sum_stored == fingerprint(table)
      if (found) then
        do i = 1, n
          call bound_heights(table%zones(i))
        end do
      end if
    end if
    close (unit)
  end subroutine load_table

  !> Whether numbers from a file, which may be anything, are the points of an axis.
  pure logical function rising(x)
    real(dp), intent(in) :: x(:)

    rising = all(x(2:) > x(:size(x) - 1)) .and. all(abs(x) < 1e3_dp)
  end function rising

  !> A number that changes with every bit of the table.
  integer(int64) function fingerprint(table) result(mix)
    type(contact_table), intent(in) :: table
    integer :: i, k

    mix = 0
    call stir([real(table%accuracy%poses, dp), table%accuracy%rms, table%accuracy%largest])
    do i = 1, size(table%zones)
      associate (t => table%zones(i))
        call stir([merge(1.0_dp, 0.0_dp, t%flange), t%along, t%pole, t%origin, t%ceiling])
        call stir(t%u%x)
        call stir(t%roll%x)
        call stir(t%q%x)
        do k = 1, size(t%h, 2)
          call stir(t%h(:, k))
        end do
        do k = 1, size(t%s, 3)
          call stir(reshape(t%s(:, :, k), [size(t%s, 1)*size(t%s, 2)]))
        end do
      end associate
    end do
  contains

    subroutine stir(numbers)
      real(dp), intent(in) :: numbers(:)
      integer :: j

      do j = 1, size(numbers)
        mix = ieor(ishftc(mix, 5), transfer(numbers(j), mix))
      end do
    end subroutine stir

  end function fingerprint

end module table_file
