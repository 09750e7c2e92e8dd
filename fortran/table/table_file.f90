!> What contact tables keep in a folder: the values that were solved, a file for every key. A file saves time, and no result depends
!> on it.
!>
!> A file consists of words of 64 bits, of which the last one is a checksum of the others. The procedures `pass...` say once what a
!> file holds: they write it, or read it from a file whose checksum is right.
module table_file
  use, intrinsic :: iso_fortran_env, only: int64
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use contact_table, only: table_type
  use errors, only: error_type, fatal_error
  use fingerprint, only: table_sources
  use kinds, only: dp
  use system, only: last_slash, make_folder, read_file, scratch_file
  use text, only: lower
  implicit none
  private
  public :: save_values, load_values, find_table_path

  ! `table_sources` is the checksum of the sources that make tables: what another version of the program has solved is not used.
  character(*), parameter :: magic = 'ldbench contact table '//table_sources

  !> The words of a file that is being written or read.
  type :: words_type
    integer(int64), allocatable :: word(:)
    integer :: n = 0                   !! words passed so far
    logical :: reading = .false.
    logical :: ok = .true.             !! false if the words that are read are not those of the table
  end type words_type

contains

  !> Give the path of a table in a folder. The name tells the law, and the key by its checksum, so that tables of different keys have
  !> different files. Versions of the program replace each other's.
  subroutine find_table_path(folder, table, path)
    character(*), intent(in) :: folder
    type(table_type), intent(in) :: table
    character(:), allocatable, intent(out) :: path
    character(16) :: number

    write (number, '(z16.16)') checksum(words_of(table%key))
    path = folder(:verify(folder, '/\', back=.true.))//'/'//trim(table%law%model)//'_'//lower(number)//'.table'
  end subroutine find_table_path

  !> Write the values of a table to its file, together with those that other runs have added to the file, complete or not at all.
  !> The folder is made if it is missing. A file that cannot be written is an error.
  subroutine save_values(file, table, error)
    character(*), intent(in) :: file
    type(table_type), intent(inout) :: table
    type(error_type), allocatable, intent(out) :: error
    type(table_type), allocatable :: both
    type(scratch_file) :: out
    type(words_type) :: s
    integer(int64) :: last(1)
    logical :: found

    ! A copy, because other threads may read the table, and because summaries tell what a run found when it began.
    allocate (both, source=table)
    call make_folder(file(:last_slash(file) - 1))
    allocate (s%word(0))
    ! Threads add to a file in turn, or one of two at the same time would lose what it has solved. Two processes may still do so,
    ! and then a later run solves it again.
    !$omp critical (table_files)
    call load_values(file, both, found)
    call pass_table(s, both)
    last = checksum(s%word(:s%n))
    call pass(s, last)
    call out%begin(file)
    call out%put(transfer(s%word(:s%n), repeat(' ', 8*s%n)))
    call out%finish()
    !$omp end critical (table_files)
    if (.not. out%ok) call fatal_error(error, 'cannot be written; later runs solve their contacts anew', file)
    if (out%ok) table%kept = table%solutions(1)
  end subroutine save_values

  !> Add the values of a file to a table that has its points. `found` is false if the file is absent, damaged or made for something
  !> else.
  subroutine load_values(file, table, found)
    character(*), intent(in) :: file
    type(table_type), intent(inout) :: table
    logical, intent(out) :: found
    type(words_type) :: s
    character(:), allocatable :: bytes
    logical :: opened
    integer :: n

    call read_file(file, bytes, opened, found)
    n = len(bytes)/8 - 1
    found = found .and. n >= 0 .and. modulo(len(bytes), 8) == 0
    if (.not. found) return
    s%word = transfer(bytes, 0_int64, n + 1)
    found = s%word(n + 1) == checksum(s%word(:n))
    if (.not. found) return
    s%reading = .true.
    call pass_table(s, table)
    found = s%ok .and. s%n == n
  end subroutine load_values

  !> Pass the values of a table, behind its key.
  subroutine pass_table(s, table)
    type(words_type), intent(inout) :: s
    type(table_type), intent(inout) :: table
    integer(int64) :: head(1)
    integer :: i

    call pass_text(s, magic)
    head = len(table%key)
    call pass(s, head)
    s%ok = s%ok .and. head(1) == len(table%key)
    if (s%ok) call pass_text(s, table%key)
    if (.not. s%ok) return
    head = table%solutions(2)
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
    table%solutions = [solved(table), max(table%solutions(2), int(head(1)))]
    table%found = table%solutions(1)
    table%kept = table%found
  end subroutine pass_table

  !> Number of half-space solutions that the values of a table came from (see `table_growth`).
  pure integer function solved(table)
    type(table_type), intent(in) :: table
    integer :: i

    solved = 0
    do i = 1, size(table%zones)
      solved = solved + count(.not. ieee_is_nan(table%zones(i)%s_at(2:, :, :)))
    end do
    if (.not. allocated(table%pairs)) return
    do i = 1, size(table%pairs)
      ! One solution has the influences of all zones on the second one.
      if (table%pairs(i)%zone(1) == 1) solved = solved + count(.not. ieee_is_nan(table%pairs(i)%c_at))
    end do
  end function solved

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

  !> Pass a text, which a file that is read must have.
  subroutine pass_text(s, text)
    type(words_type), intent(inout) :: s
    character(*), intent(in) :: text
    integer(int64) :: word((len(text) + 7)/8)

    word = words_of(text)
    call pass(s, word)
    s%ok = s%ok .and. all(word == words_of(text))
  end subroutine pass_text

  !> A text as words. Blanks fill up the last one.
  pure function words_of(text) result(word)
    character(*), intent(in) :: text
    integer(int64) :: word((len(text) + 7)/8)
    character(8*size(word)) :: filled

    filled = text
    word = transfer(filled, word)
  end function words_of

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
