!> Contact tables in files. A file consists of words of 64 bits, of which the last one is a checksum of the others.
!>
!> The procedures `pass...` say once what a file holds: they write it, or read it from a file whose checksum is right.
module table_file
  use, intrinsic :: iso_fortran_env, only: int64
  use bspline, only: axis_type, new_axis
  use contact_zones, only: max_zones
  use errors, only: error_type, fatal_error, refuse
  use kinds, only: dp
  use contact_table, only: accuracy_type, table_type
  use zone_coupling, only: pair_table
  use zone_tables, only: bound_heights, zone_table
  use system, only: scratch_file
  implicit none
  private
  public :: save_table, load_table

  ! Files of other versions of the program have something else behind the kind, or another key.
  character(*), parameter :: kind = 'ldbench contact table', magic = kind//'   '

  integer, parameter :: least_points = 5, most_points = 10000   ! of an axis

  !> The words of a file that is being written or read.
  type :: words_type
    integer(int64), allocatable :: word(:)
    integer :: n = 0                   !! words passed so far
    logical :: reading = .false.
    logical :: ok = .true.             !! false if the words that are read are no table
  end type words_type

contains

  !> Write a table to a file, complete or not at all. A file that cannot be written is an error.
  subroutine save_table(file, table, error)
    character(*), intent(in) :: file
    type(table_type), intent(in) :: table
    type(error_type), allocatable, intent(out) :: error
    type(scratch_file) :: out
    type(table_type) :: copy
    type(words_type) :: s
    integer(int64) :: last(1)

    copy = table
    allocate (s%word(0))
    call pass_table(s, table%key, copy)
    last = checksum(s%word(:s%n))
    call pass(s, last)
    call out%begin(file)
    call out%put(transfer(s%word(:s%n), repeat(' ', 8*s%n)))
    call out%finish()
    if (.not. out%ok) call fatal_error(error, 'cannot be written', group='table', variable='file', detail=' = '//file)
  end subroutine save_table

  !> Read the table that was made for `key`. `found` is false if the file is absent, damaged or made for something else.
  !> A file that is no table is an error, for the table would replace it.
  subroutine load_table(file, key, table, found, error)
    character(*), intent(in) :: file, key
    type(table_type), intent(out) :: table
    logical, intent(out) :: found
    type(error_type), allocatable, intent(out) :: error
    type(words_type) :: s
    character(len(kind)) :: mark
    integer(int64) :: bytes
    integer :: unit, stat, n, z

    found = .false.
    open (newunit=unit, file=file, access='stream', form='unformatted', action='read', status='old', iostat=stat)
    if (stat /= 0) return
    inquire (unit=unit, size=bytes)
    n = int(min(bytes, len(kind, int64)))
    read (unit, iostat=stat) mark(:n)
    if (stat /= 0 .or. mark(:n) /= kind(:n)) then
      call refuse(error, 'a contact table or no file', 'a file of another kind', &
        group='table', variable='file', detail=' = '//file, rest='; name another one')
    else if (n == len(kind) .and. modulo(bytes, 8_int64) == 0) then
      allocate (s%word(bytes/8), stat=stat)
      if (stat == 0) read (unit, pos=1, iostat=stat) s%word
      n = size(s%word) - 1
      if (stat == 0) found = s%word(n + 1) == checksum(s%word(:n))
    end if
    close (unit)
    if (.not. found) return
    s%reading = .true.
    call pass_table(s, key, table)
    found = s%ok .and. s%n == n
    if (.not. found) return
    do z = 1, size(table%zones)
      call bound_heights(table%zones(z))
    end do
  end subroutine load_table

  !> Pass a table that is made for `key`.
  subroutine pass_table(s, key, table)
    type(words_type), intent(inout) :: s
    character(*), intent(in) :: key
    type(table_type), intent(inout) :: table
    integer(int64) :: head(10), n_pairs(1)
    real(dp) :: errors(8)
    integer :: i

    call pass_text(s, magic)
    if (.not. s%reading) then
      head = [len(key), size(table%zones), table%accuracy%poses, table%accuracy%unsolved, table%solutions, &
        table%roll%n]
      errors = [table%accuracy%rms, table%accuracy%largest]
      n_pairs = -1
      if (allocated(table%pairs)) n_pairs = size(table%pairs)
    end if
    call pass(s, head)
    s%ok = s%ok .and. head(1) == len(key) .and. head(2) >= 1 .and. head(2) <= max_zones
    if (s%ok) call pass_text(s, key)
    if (.not. s%ok) return
    call pass_numbers(s, 8, errors)
    call pass_axis(s, head(10), table%roll)
    if (s%reading) then
      table%key = key
      head = max(0_int64, min(head, int(huge(1), int64)))
      table%accuracy = accuracy_type(int(head(7)), int(head(3:6)), errors(:4), errors(5:))
      table%solutions = int(head(8:9))
      allocate (table%zones(head(2)))
    end if
    do i = 1, size(table%zones)
      if (s%ok) call pass_zone(s, table%roll%n, table%zones(i))
    end do
    call pass(s, n_pairs)
    s%ok = s%ok .and. n_pairs(1) <= max_zones**2
    if (.not. s%ok .or. n_pairs(1) < 0) return
    if (s%reading) allocate (table%pairs(n_pairs(1)))
    do i = 1, size(table%pairs)
      if (s%ok) call pass_pair(s, size(table%zones), table%pairs(i))
    end do
  end subroutine pass_table

  !> Pass the axes and the coefficients of one zone.
  subroutine pass_zone(s, n_roll, t)
    type(words_type), intent(inout) :: s
    integer, intent(in) :: n_roll              !! points of the roll angle
    type(zone_table), intent(inout) :: t
    integer(int64) :: head(3)
    real(dp) :: numbers(8)

    if (.not. s%reading) then
      head = [merge(1, 0, t%past_root), t%u%n, t%q%n]
      numbers = [t%along, t%pole, t%origin, t%ceiling, t%tip]
    end if
    call pass(s, head)
    call pass_numbers(s, 8, numbers)
    call pass_axis(s, head(2), t%u)
    call pass_axis(s, head(3), t%q)
    if (s%reading) then
      s%ok = s%ok .and. product(head(2:) + 2)*(n_roll + 2) <= size(s%word)
      if (.not. s%ok) return
      t%past_root = head(1) == 1
      t%along = numbers(1:2)
      t%pole = numbers(3:4)
      t%origin = numbers(5:6)
      t%ceiling = numbers(7)
      t%tip = numbers(8)
      allocate (t%h(n_roll + 2, t%u%n + 2), t%s(t%q%n + 2, n_roll + 2, t%u%n + 2))
    end if
    call pass_numbers(s, size(t%h), t%h)
    call pass_numbers(s, size(t%s), t%s)
  end subroutine pass_zone

  !> Pass the influence of two zones on each other.
  subroutine pass_pair(s, n_zones, t)
    type(words_type), intent(inout) :: s
    integer, intent(in) :: n_zones
    type(pair_table), intent(inout) :: t
    integer(int64) :: head(5)

    if (.not. s%reading) head = [t%zone, t%u%n, t%roll%n, t%p%n]
    call pass(s, head)
    s%ok = s%ok .and. all(head(:2) > 0 .and. head(:2) <= n_zones)
    call pass_axis(s, head(3), t%u)
    call pass_axis(s, head(4), t%roll)
    call pass_axis(s, head(5), t%p)
    if (s%reading) then
      s%ok = s%ok .and. product(head(3:) + 2) <= size(s%word)
      if (.not. s%ok) return
      t%zone = int(head(:2))
      allocate (t%c(t%p%n + 2, t%roll%n + 2, t%u%n + 2))
    end if
    call pass_numbers(s, size(t%c), t%c)
  end subroutine pass_pair

  !> Pass words; those that are read are 0 if the file does not have them.
  pure subroutine pass(s, word)
    type(words_type), intent(inout) :: s
    integer(int64), intent(inout) :: word(:)
    integer :: n

    n = s%n + size(word)
    if (s%reading) then
      s%ok = s%ok .and. n < size(s%word)
      word = 0
      if (s%ok) word = s%word(s%n + 1:n)
    else
      if (n > size(s%word)) s%word = [s%word, spread(0_int64, 1, n)]
      s%word(s%n + 1:n) = word
    end if
    s%n = n
  end subroutine pass

  !> Pass n numbers, whose bits are words.
  subroutine pass_numbers(s, n, x)
    type(words_type), intent(inout) :: s
    integer, intent(in) :: n
    real(dp), intent(inout) :: x(n)
    integer(int64), allocatable :: word(:)

    allocate (word(n))
    word = transfer(x, word)
    call pass(s, word)
    x = transfer(word, x)
  end subroutine pass_numbers

  !> Pass the n points of an axis. Those of a damaged file may be no axis.
  subroutine pass_axis(s, n, axis)
    type(words_type), intent(inout) :: s
    integer(int64), intent(in) :: n
    type(axis_type), intent(inout) :: axis
    real(dp), allocatable :: x(:)

    s%ok = s%ok .and. n >= least_points .and. n <= most_points
    if (.not. s%ok) return
    allocate (x(n), source=0.0_dp)
    if (.not. s%reading) x = axis%x
    call pass_numbers(s, int(n), x)
    s%ok = s%ok .and. all(x(2:) > x(:n - 1)) .and. all(abs(x) < 1e3_dp)
    if (s%reading .and. s%ok) axis = new_axis(x)
  end subroutine pass_axis

  !> Pass a text, which a file that is read must have. Blanks fill up the last word.
  subroutine pass_text(s, text)
    type(words_type), intent(inout) :: s
    character(*), intent(in) :: text
    integer(int64) :: expected((len(text) + 7)/8), word((len(text) + 7)/8)
    character(8*size(word)) :: filled

    filled = text
    expected = transfer(filled, expected)
    word = expected
    call pass(s, word)
    s%ok = s%ok .and. all(word == expected)
  end subroutine pass_text

  !> Return a number that changes with every word. Between two words the generator xorshift64 makes a step (G. Marsaglia,
  !> J. Stat. Softw. 8 (2003) 14), which is invertible and has the period 2^64 - 1.  The CRC-32 of profiles, which a user can
  !> check, takes nine times as long with a table of its bytes, and is not needed here.
  pure integer(int64) function checksum(word) result(mix)
    integer(int64), intent(in) :: word(:)
    integer :: i

    mix = 0
    do i = 1, size(word)
      mix = ieor(mix, word(i))
      mix = ieor(mix, shiftl(mix, 13))
      mix = ieor(mix, shiftr(mix, 7))
      mix = ieor(mix, shiftl(mix, 17))
    end do
  end function checksum

end module table_file
