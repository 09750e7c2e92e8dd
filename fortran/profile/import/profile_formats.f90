!> Reads the points of a profile file.  The contents tell the format: plain columns y z, MiniProf (.whl, .ban) or
!> SIMPACK (.prw, .prr).
!>
!> An old MiniProf file has free lines of heading, one of which names MiniProf, a blank line, then rows of X, Y and
!> more.  A new one has `Key=Value` lines, among them ColumnDef=X,Y,A,C, XYPoints, XOffset and YOffset, then the rows
!> (Greenwood Engineering, "MiniProf for Windows, Technical Reference", 2008).  A SIMPACK file has `header.begin` with
!> type 0 (rail) or 1 (wheel), `spline.begin` with shifts, bounds, mirrors and the unit, and `point.begin` with rows of y,
!> z and a weight, z down (E. Vollebregt, "User guide for CONTACT", section on profile files).
module profile_formats
  use errors, only: error_type, fatal_error
  use kinds, only: dp
  use text, only: clip, line_type, lower, str, to_real
  implicit none
  private
  public :: raw_type, read_points

  !> What a profile file says.
  type :: raw_type
    integer :: n = 0                       !! number of points
    real(dp), allocatable :: points(:, :)  !! y, z in the file's unit, (2, n)
    integer, allocatable :: line(:)        !! line of each point in the file
    character(:), allocatable :: format    !! 'plain', 'MiniProf', 'SIMPACK'
    character(5) :: kind = ''              !! 'wheel' or 'rail'; '' where the file does not say it
    real(dp) :: unit = 0                   !! the file's unit; 0 where the file does not say it [mm]
    logical :: reconstruction = .false.    !! whether the file says that it is a reconstruction
    integer :: announced = -1              !! number of points; -1 where the file does not say it
  end type raw_type

  real(dp), parameter :: largest = 1e4_dp  !! coordinate, in any unit

contains

  !> Read the points of a file from its lines.  Fails, with file and line, where the lines do not follow a format.
  subroutine read_points(file, lines, raw, error)
    character(*), intent(in) :: file               !! for messages
    type(line_type), intent(in) :: lines(:)
    type(raw_type), intent(out) :: raw
    type(error_type), allocatable, intent(out) :: error
    integer :: i, stat

    allocate (raw%points(2, size(lines)), raw%line(size(lines)), stat=stat)
    if (stat /= 0) then
      call fatal_error(error, file//': expected memory for the points of '//str(size(lines))//' lines, found less')
      return
    end if
    raw%format = 'plain'
    do i = 1, size(lines)
      if (index(lower(lines(i)%text), 'reconstruction') > 0) raw%reconstruction = .true.
      if (any(first_word(lines(i)%text) == ['header.begin', 'spline.begin', 'point.begin '])) raw%format = 'SIMPACK'
    end do
    if (raw%format == 'SIMPACK') then
      call read_simpack(file, lines, raw, error)
    else
      call read_columns(file, lines, raw, error)
    end if
    raw%points = raw%points(:, :raw%n)
    raw%line = raw%line(:raw%n)
  end subroutine read_points

  !> Read rows of numbers below a heading: plain and MiniProf.
  subroutine read_columns(file, lines, raw, error)
    character(*), intent(in) :: file
    type(line_type), intent(in) :: lines(:)
    type(raw_type), intent(inout) :: raw
    type(error_type), allocatable, intent(out) :: error
    character(:), allocatable :: row, key, value
    real(dp) :: x(2), offset(2)
    integer :: i, start, column(2)
    logical :: ok

    column = [1, 2]
    offset = 0
    start = 1
    row = ''
    do i = 1, size(lines)
      if (raw%n == 0) then
        if (is_miniprof(lines(i)%text)) then
          raw%format = 'MiniProf'
          ! The heading may hold numbers.  It ends with a blank line.
          if (start == 1) start = next_blank(lines, i)
        end if
        if (i < start) cycle
        call split_key(lines(i)%text, key, value)
        if (key /= '') then
          call take_key()
          if (allocated(error)) return
        end if
      end if
      row = uncommented(lines(i)%text, '#!%')
      if (raw%format == 'MiniProf' .and. index(adjustl(row), '"') == 1) cycle
      if (len_trim(row) == 0) cycle
      call take_numbers(row, column, x, ok)
      if (.not. ok) then
        if (raw%n == 0 .and. is_words(lines(i)%text)) cycle
        call refuse(file, i, 'two numbers, y and z in mm', lines(i)%text, error)
        return
      end if
      call add_point(file, raw, x + offset, i, lines(i)%text, error)
      if (allocated(error)) return
    end do

  contains

    !> Take the value of a MiniProf key that matters.
    subroutine take_key()
      real(dp) :: number
      integer :: k
      logical :: ok

      select case (key)
      case ('columndef')
        raw%format = 'MiniProf'
        column = [column_of(value, 'X'), column_of(value, 'Y')]
        if (any(column == 0)) call refuse(file, i, 'columns X and Y', value, error)
      case ('xoffset', 'yoffset', 'xypoints')
        raw%format = 'MiniProf'
        if (value == '') return
        call to_real(value, number, ok)
        if (ok) ok = abs(number) < largest .and. (key /= 'xypoints' .or. number > 0)
        if (.not. ok) then
          call refuse(file, i, 'a number after '//key//'=', value, error)
        else if (key == 'xypoints') then
          raw%announced = nint(number)
        else
          k = merge(1, 2, key == 'xoffset')
          offset(k) = number
        end if
      end select
    end subroutine take_key

  end subroutine read_columns

  !> Read sections and keys: SIMPACK.
  subroutine read_simpack(file, lines, raw, error)
    character(*), intent(in) :: file
    type(line_type), intent(in) :: lines(:)
    type(raw_type), intent(inout) :: raw
    type(error_type), allocatable, intent(out) :: error
    character(:), allocatable :: row, key, value, as_written, section
    real(dp) :: x(2), weight(1), shift(2), low(2), high(2), mirror(2), number
    integer :: i
    logical :: ok

    shift = 0
    low = 1
    high = 0
    mirror = 0
    raw%unit = 1e3_dp
    section = ''
    do i = 1, size(lines)
      row = uncommented(lines(i)%text, '!#%')
      if (len_trim(row) == 0) cycle
      key = trim(first_word(row))
      if (index(key, '.begin') > 1 .and. index(key, '.begin') == len(key) - 5) then
        if (section /= merge('spline', '      ', key == 'point.begin')) then
          call refuse(file, i, 'the sections header, spline and in it point, one after the other', key, error)
          return
        end if
        section = key(:len(key) - 6)
      else if (index(key, '.end') > 1 .and. index(key, '.end') == len(key) - 3) then
        if (section == '' .or. key /= section//'.end') then
          call refuse(file, i, 'the end of the section that is open', key, error)
          return
        end if
        section = ''
        if (key == 'point.end') section = 'spline'
        if (key == 'spline.end') exit
      else if (section == 'point') then
        call take_numbers(row, [1, 2], x, ok)
        if (.not. ok) then
          call refuse(file, i, 'two numbers, y and z', lines(i)%text, error)
          return
        end if
        call take_numbers(row, [3], weight, ok)
        if (ok) ok = weight(1) <= 0
        if (ok) cycle
        x = x + shift
        if (any((x < low .or. x > high) .and. low < high)) cycle
        call add_point(file, raw, merge(-x, x, mirror > 0), i, lines(i)%text, error)
        if (allocated(error)) return
      else
        call split_key(lines(i)%text(:len(row)), key, as_written)
        call split_key(row, key, value)
        call take_key()
        if (allocated(error)) return
      end if
    end do
    if (section == 'point') call fatal_error(error, file//': expected point.end, found the end of the file')

  contains

    !> Take the value of a SIMPACK key that matters.
    subroutine take_key()
      character(12), parameter :: known(*) = [character(12) :: 'shift.y', 'shift.z', 'mirror.y', 'mirror.z', &
        'bound.y.min', 'bound.z.min', 'bound.y.max', 'bound.z.max', 'rotate', 'units.len.f', 'type']
      integer :: k

      if (section == '' .or. section == 'spline' .and. key == 'type') return
      if (.not. any(key == known)) return
      call to_real(value, number, ok)
      if (ok) ok = abs(number) < 1e9_dp
      if (.not. ok) then
        call refuse(file, i, 'a number for '//key, as_written, error)
        return
      end if
      k = merge(1, 2, index(key, '.y') > 0)
      select case (key)
      case ('shift.y', 'shift.z')
        shift(k) = number
      case ('mirror.y', 'mirror.z')
        mirror(k) = number
      case ('bound.y.min', 'bound.z.min')
        low(k) = number
      case ('bound.y.max', 'bound.z.max')
        high(k) = number
      case ('rotate')
        if (abs(number) > 0) call refuse(file, i, 'rotate = 0', as_written, error)
      case ('units.len.f')
        if (number <= 0) then
          call refuse(file, i, 'units.len.f above 0', as_written, error)
        else
          raw%unit = 1e3_dp/number
        end if
      case ('type')
        if (nint(number) /= 0 .and. nint(number) /= 1) then
          call refuse(file, i, 'type 0, a rail, or 1, a wheel', as_written, error)
        else
          raw%kind = merge('wheel', 'rail ', nint(number) == 1)
        end if
      end select
    end subroutine take_key

  end subroutine read_simpack

  !> The error that a line is not what was expected.
  subroutine refuse(file, line, expected, found, error)
    character(*), intent(in) :: file, expected, found
    integer, intent(in) :: line
    type(error_type), allocatable, intent(out) :: error

    call fatal_error(error, file//', line '//str(line)//': expected '//expected//', found "'//clip(found)//'"')
  end subroutine refuse

  !> Add a point.  Fails where a coordinate is too large.
  subroutine add_point(file, raw, x, line, text, error)
    character(*), intent(in) :: file, text
    type(raw_type), intent(inout) :: raw
    real(dp), intent(in) :: x(2)
    integer, intent(in) :: line
    type(error_type), allocatable, intent(out) :: error

    if (any(abs(x) > largest)) then
      call refuse(file, line, 'millimetres', text, error)
      return
    end if
    raw%n = raw%n + 1
    raw%points(:, raw%n) = x
    raw%line(raw%n) = line
  end subroutine add_point

  !> Whether a line of heading names MiniProf.
  pure logical function is_miniprof(line)
    character(*), intent(in) :: line
    character(:), allocatable :: word

    word = lower(adjustl(line))
    is_miniprof = index(word, 'miniprof') == 1 .or. index(word, '#miniwheelprof') == 1 .or. index(word, '#minirailprof') == 1
  end function is_miniprof

  !> The first blank line after line i that numbers follow; 1 where there is no such line.
  pure integer function next_blank(lines, i) result(line)
    type(line_type), intent(in) :: lines(:)
    integer, intent(in) :: i

    do line = i + 1, size(lines) - 1
      if (len_trim(lines(line)%text) == 0 .and. scan(first_word(lines(line + 1)%text), '0123456789') > 0) return
    end do
    line = 1
  end function next_blank

  !> Split `key = value`: the key in lower case, and the value.  The key is '' where the line has no `=`.
  pure subroutine split_key(line, key, value)
    character(*), intent(in) :: line
    character(:), allocatable, intent(out) :: key, value
    integer :: mark

    key = ''
    value = ''
    mark = index(line, '=')
    if (mark < 2) return
    key = lower(trim(adjustl(line(:mark - 1))))
    value = trim(adjustl(line(mark + 1:)))
  end subroutine split_key

  !> Position of a letter in a list such as X,Y,A,C; 0 where the list does not have it.
  pure integer function column_of(list, letter) result(column)
    character(*), intent(in) :: list
    character, intent(in) :: letter
    integer :: i

    column = 1
    do i = 1, len(list)
      if (list(i:i) == letter) return
      if (list(i:i) == ',') column = column + 1
    end do
    column = 0
  end function column_of

  !> The first word of a line in lower case; '' for a word of more than 16 letters.
  pure function first_word(line) result(word)
    character(*), intent(in) :: line
    character(16) :: word
    character(:), allocatable :: rest

    rest = adjustl(line)
    rest = rest(:index(rest//' ', ' ') - 1)
    word = lower(rest)
    if (len(rest) > len(word)) word = ''
  end function first_word

  !> A line up to a comment, which starts with one of the marks; commas and semicolons become blanks.
  pure function uncommented(line, marks) result(row)
    character(*), intent(in) :: line, marks
    character(scan(line//marks(1:1), marks) - 1) :: row
    integer :: i

    row = line
    do i = 1, len(row)
      if (scan(row(i:i), ',;') == 1) row(i:i) = ' '
    end do
  end function uncommented

  !> Whether a line is a heading: it begins with a letter and is not a misspelt number.
  pure logical function is_words(line)
    character(*), intent(in) :: line
    character(:), allocatable :: word

    word = lower(adjustl(line))
    is_words = len(word) > 0
    if (is_words) is_words = verify(word(1:1), 'abcdefghijklmnopqrstuvwxyz"''(') == 0 &
      .and. index(word, 'nan') /= 1 .and. index(word, 'inf') /= 1
  end function is_words

  !> The numbers x of some columns of a row.  `ok` is false where one of them is no number.
  pure subroutine take_numbers(row, columns, x, ok)
    character(*), intent(in) :: row
    integer, intent(in) :: columns(:)
    real(dp), intent(out) :: x(:)
    logical, intent(out) :: ok
    integer :: k, column, start, finish

    x = 0
    ok = .true.
    start = 1
    do column = 1, maxval(columns)
      k = verify(row(start:), ' ')
      ok = k > 0
      if (.not. ok) return
      start = start + k - 1
      finish = start + index(row(start:)//' ', ' ') - 2
      k = findloc(columns, column, 1)
      if (k > 0) call to_real(row(start:finish), x(k), ok)
      if (.not. ok) return
      start = finish + 1
    end do
  end subroutine take_numbers

end module profile_formats
