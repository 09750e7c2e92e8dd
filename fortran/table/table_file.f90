!> What contact tables keep in files: the values that were solved. A file saves time, and no result depends on it.
!>
!> A file consists of words of 64 bits, of which the last one is a checksum of the others. The procedures `pass...` say once what a
!> file holds: they write it, or read it from a file whose checksum is right.
module table_file
  use, intrinsic :: iso_fortran_env, only: int64
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use errors, only: error_type, fatal_error, refuse
  use kinds, only: dp
  use contact_table, only: table_type
  use system, only: scratch_file
  implicit none
  private
  public :: save_values, load_values

  ! Files of other versions of the program have something else behind the kind, or another key.
  character(*), parameter :: kind = 'ldbench contact table', magic = kind//'   '

  !> The words of a file that is being written or read.
  type :: words_type
    integer(int64), allocatable :: word(:)
    integer :: n = 0                   !! words passed so far
    logical :: reading = .false.
    logical :: ok = .true.             !! false if the words that are read are not those of the table
  end type words_type

contains

  !> Write the values of a table to a file, complete or not at all. A file that cannot be written is an error.
  subroutine save_values(file, table, error)
    character(*), intent(in) :: file
    type(table_type), intent(inout) :: table
    type(error_type), allocatable, intent(out) :: error
    type(scratch_file) :: out
    type(words_type) :: s
    integer(int64) :: last(1)

    allocate (s%word(0))
    call pass_table(s, table)
    last = checksum(s%word(:s%n))
    call pass(s, last)
    call out%begin(file)
    call out%put(transfer(s%word(:s%n), repeat(' ', 8*s%n)))
    call out%finish()
    if (.not. out%ok) call fatal_error(error, 'cannot be written', group='table', variable='file', detail=' = '//file)
    if (out%ok) table%kept = table%solutions(1)
  end subroutine save_values

  !> Read the values of a table that has its points. `found` is false if the file is absent, damaged or made for something else.
  !> A file that is no table is an error, for the table would replace it.
  subroutine load_values(file, table, found, error)
    character(*), intent(in) :: file
    type(table_type), intent(inout) :: table
    logical, intent(out) :: found
    type(error_type), allocatable, intent(out) :: error
    type(words_type) :: s
    character(len(kind)) :: mark
    integer(int64) :: bytes
    integer :: unit, stat, n

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
    call pass_table(s, table)
    found = s%ok .and. s%n == n
  end subroutine load_values

  !> Pass the values of a table, behind its key.
  subroutine pass_table(s, table)
    type(words_type), intent(inout) :: s
    type(table_type), intent(inout) :: table
    integer(int64) :: head(2)
    integer :: i

    call pass_text(s, magic)
    head(1) = len(table%key)
    call pass(s, head(:1))
    s%ok = s%ok .and. head(1) == len(table%key)
    if (s%ok) call pass_text(s, table%key)
    if (.not. s%ok) return
    head = table%solutions
    call pass(s, head)
    do i = 1, size(table%zones)
      associate (t => table%zones(i))
        call pass_values(s, size(t%h_at), t%h_at)
        call pass_values(s, size(t%s_at), t%s_at)
      end associate
    end do
    if (allocated(table%pairs)) then
      do i = 1, size(table%pairs)
        call pass_values(s, size(table%pairs(i)%c_at), table%pairs(i)%c_at)
      end do
    end if
    if (.not. (s%reading .and. s%ok)) return
    table%solutions = int(head)
    table%found = table%solutions(1)
    table%kept = table%found
  end subroutine pass_table

  !> Pass the known ones of n values, behind their number and their places.
  subroutine pass_values(s, n, x)
    type(words_type), intent(inout) :: s
    integer, intent(in) :: n
    real(dp), intent(inout) :: x(n)
    integer(int64) :: known(1)
    integer(int64), allocatable :: place(:), word(:)
    integer :: i

    place = pack([(int(i, int64), i=1, n)], .not. ieee_is_nan(x))
    known = size(place)
    call pass(s, known)
    s%ok = s%ok .and. known(1) >= 0 .and. known(1) <= n
    if (.not. s%ok) return
    if (s%reading) place = spread(0_int64, 1, int(known(1)))
    call pass(s, place)
    s%ok = s%ok .and. all(place >= 1 .and. place <= n)
    if (.not. s%ok) return
    word = transfer(x(place), place)
    call pass(s, word)
    if (s%reading .and. s%ok) x(place) = transfer(word, x)
  end subroutine pass_values

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
