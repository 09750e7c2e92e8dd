!> Small text helpers: numbers from words, words from numbers, reading a whole file, checksums.
!>
!> No function of the core has a result of deferred length: gfortran keeps that length in static memory wherever such a
!> function is called, so that two threads exchange the lengths of their texts. A result has a length that follows from
!> the arguments, or a subroutine gives the text.
module text
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use, intrinsic :: iso_fortran_env, only: int64
  use errors, only: error_type, fatal_error, refuse
  use kinds, only: dp
  use system, only: read_file
  implicit none
  private
  public :: line_type, lower, to_real, str, shortest, with_zero, clip, read_lines, split_lines, checksum, joined

  type :: line_type
    character(:), allocatable :: text
  end type line_type

  !> The shortest plain text of a number.
  interface str
    module procedure str_real, str_integer, str_long
  end interface str

contains

  pure function lower(word) result(low)
    character(*), intent(in) :: word
    character(len(word)) :: low
    integer :: i, code

    do i = 1, len(word)
      code = iachar(word(i:i))
      if (code >= iachar('A') .and. code <= iachar('Z')) code = code + 32
      low(i:i) = achar(code)
    end do
  end function lower

  !> Convert a word to a number. Unlike a list-directed read, the procedure takes the whole word or nothing: it refuses
  !> `1568kg`, `1/2`, `NaN` and `1e999`.
  pure subroutine to_real(word, x, ok)
    character(*), intent(in) :: word
    real(dp), intent(out) :: x
    logical, intent(out) :: ok
    integer :: stat

    x = 0
    ok = len_trim(word) > 0 .and. len_trim(word) < 64
    if (.not. ok) return
    ok = is_number(trim(word))
    if (.not. ok) return
    read (word, '(f64.0)', iostat=stat) x
    ok = stat == 0
    if (ok) ok = ieee_is_finite(x)
  end subroutine to_real

  !> [sign] digits with at most one point [exponent: e or d, sign, digits].
  pure logical function is_number(word)
    character(*), intent(in) :: word
    character(*), parameter :: digits = '0123456789'
    integer :: mark, from, point, exponent

    mark = scan(word, 'eEdD')
    if (mark == 0) mark = len(word) + 1
    from = merge(2, 1, scan(word(1:1), '+-') == 1)
    point = index(word(:mark - 1), '.')
    is_number = verify(word(from:mark - 1), digits//'.') == 0 .and. scan(word(from:mark - 1), digits) > 0 &
      .and. index(word(point + 1:mark - 1), '.') == 0
    if (.not. is_number .or. mark > len(word)) return
    is_number = mark < len(word)
    if (.not. is_number) return
    from = mark + merge(2, 1, scan(word(mark + 1:mark + 1), '+-') == 1)
    is_number = from <= len(word) .and. len(word) < from + 4 .and. verify(word(from:), digits) == 0
    if (.not. is_number) return
    ! A larger exponent could overflow. Where overflow traps, the conversion must not even be tried.
    read (word(from:), *) exponent
    is_number = mark + exponent < 300 .or. word(mark + 1:mark + 1) == '-'
  end function is_number

  !> A number with the fewest digits after its point that read back to the same number. `str` works this out twice, first
  !> for its length.
  pure function shortest(x) result(word)
    real(dp), intent(in) :: x
    character(40) :: word
    character(len(word)) :: trial
    integer :: too_few, enough, digits
    real(dp) :: back
    logical :: same

    too_few = 0
    enough = 20
    word = with_digits(x, enough)
    do while (enough - too_few > 1)
      digits = (too_few + enough)/2
      trial = with_digits(x, digits)
      call to_real(trim(trial), back, same)
      if (same) same = abs(back - x) <= 0
      if (same) then
        enough = digits
        word = trial
      else
        too_few = digits
      end if
    end do
    word = with_zero(word)
  end function shortest

  !> A number with so many digits after its point, and with an exponent if it is small or large.
  pure function with_digits(x, digits) result(word)
    real(dp), intent(in) :: x
    integer, intent(in) :: digits
    character(40) :: word
    character(12) :: form

    if (abs(x) >= 1e-3_dp .and. abs(x) < 1e7_dp .or. abs(x) <= 0) then
      write (form, '("(f0.",i0,")")') digits
    else
      write (form, '("(es0.",i0,"e0)")') digits
    end if
    write (word, form) x
  end function with_digits

  pure function str_real(x) result(word)
    real(dp), intent(in) :: x
    character(len_trim(shortest(x))) :: word

    word = shortest(x)
  end function str_real

  !> Put a zero before the point with which a number begins, if blanks behind the number leave room.
  pure function with_zero(number) result(word)
    character(*), intent(in) :: number
    character(len(number)) :: word

    word = number
    if (index(word, '.') == 1) word = '0'//word
    if (index(word, '-.') == 1) word = '-0'//word(2:)
  end function with_zero

  pure function decimal(i) result(word)
    integer(int64), intent(in) :: i
    character(24) :: word

    write (word, '(i0)') i
  end function decimal

  pure function str_integer(i) result(word)
    integer, intent(in) :: i
    character(len_trim(decimal(int(i, int64)))) :: word

    word = decimal(int(i, int64))
  end function str_integer

  pure function str_long(i) result(word)
    integer(int64), intent(in) :: i
    character(len_trim(decimal(i))) :: word

    word = decimal(i)
  end function str_long

  !> The first 80 characters of a text, for a message.
  pure function clip(text) result(short)
    character(*), intent(in) :: text
    character(min(len_trim(text), 80)) :: short

    short = text
    if (len_trim(text) > 80) short(78:) = '...'
  end function clip

  !> Read all lines of a file, or of standard input when `path` is '-'. `split_lines` says what a line is.
  subroutine read_lines(path, lines, error)
    character(*), intent(in) :: path
    type(line_type), allocatable, intent(out) :: lines(:)
    type(error_type), allocatable, intent(out) :: error
    character(:), allocatable :: bytes, name
    logical :: folder, there, opened, ok

    name = path
    if (path == '-') name = 'standard input'
    call read_file(path, bytes, opened, ok)
    if (ok) then
      call split_lines(bytes, lines)
      return
    end if
    inquire (file=path//'/.', exist=folder)    ! only here, because Windows answers so for any file
    if (folder) then
      call refuse(error, 'a file', 'a folder', name)
    else if (.not. opened) then
      call fatal_error(error, 'cannot be opened for reading', name)
      inquire (file=path, exist=there)
      error%missing = .not. there
    else
      call fatal_error(error, 'cannot be read completely', name)
    end if
  end subroutine read_lines

  !> The lines of a text, ended by newline, carriage return or both.  Tabs become blanks; a mark of the order of bytes is left out.
  pure subroutine split_lines(text, lines)
    character(*), intent(in) :: text
    type(line_type), allocatable, intent(out) :: lines(:)
    character(*), parameter :: newline = achar(10), return = achar(13), tab = achar(9), mark = char(239)//char(187)//char(191)
    integer :: n, from, to, pass, i

    do pass = 1, 2
      if (pass == 2) allocate (lines(n))
      n = 0
      from = merge(4, 1, index(text, mark) == 1)
      do while (from <= len(text))
        to = from - 1 + scan(text(from:), newline//return)
        if (to < from) to = len(text) + 1
        n = n + 1
        if (pass == 2) then
          lines(n)%text = text(from:to - 1)
          do i = from, to - 1
            if (text(i:i) == tab) lines(n)%text(i - from + 1:i - from + 1) = ' '
          end do
        end if
        from = to + 1
        if (text(to:min(from, len(text))) == return//newline) from = from + 1
      end do
    end do
  end subroutine split_lines

  !> Words as a name.
  pure function joined(words) result(name)
    character(*), intent(in) :: words
    character(len_trim(words)) :: name
    integer :: k

    name = words
    do k = 1, len(name)
      if (scan(name(k:k), ' -') > 0) name(k:k) = '_'
    end do
  end function joined

  !> CRC-32 (ISO 3309) of some lines, tabs counted as blanks and line ends as one newline, as eight hexadecimal digits.
  pure function checksum(lines) result(hex)
    type(line_type), intent(in) :: lines(:)
    character(8) :: hex
    integer(int64) :: crc
    integer :: i, j

    crc = int(z'FFFFFFFF', int64)
    do i = 1, size(lines)
      do j = 1, len(lines(i)%text)
        crc = next(crc, iachar(lines(i)%text(j:j)))
      end do
      crc = next(crc, 10)
    end do
    write (hex, '(z8.8)') ieor(crc, int(z'FFFFFFFF', int64))

  contains

    pure integer(int64) function next(crc, byte)
      integer(int64), intent(in) :: crc
      integer, intent(in) :: byte
      integer :: bit

      next = ieor(crc, int(byte, int64))
      do bit = 1, 8
        next = ieor(shiftr(next, 1), iand(-iand(next, 1_int64), int(z'EDB88320', int64)))
      end do
    end function next

  end function checksum

end module text