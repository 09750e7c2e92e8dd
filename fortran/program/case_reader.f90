!> Read a case from the lines of a namelist file. Fortran's own reading of namelists cannot say where an error is.
module case_reader
  use case, only: admissible, case_type, list_variables, range_text, text_length, to_angle, variable_type
  use errors, only: error_type, refuse
  use kinds, only: dp
  use text, only: clip, line_type, lower, to_real
  implicit none
  private
  public :: read_case

  integer, parameter :: nothing = 0, plain = 1, quoted = 2, mark = 3   ! kinds of words

  !> The position that the reader has reached, and the last word.
  type :: reader_type
    character(:), allocatable :: file      !! for messages
    type(line_type), allocatable :: lines(:)
    integer :: line = 1, column = 1        !! position of the next character
    character(:), allocatable :: group     !! the open group, or ''
    integer :: kind = nothing
    character(:), allocatable :: word      !! without quotes
    character(:), allocatable :: shown     !! as it stands in the file
  contains
    procedure :: next
    procedure :: next_quoted
    procedure :: fail
  end type reader_type

contains

  !> Set variables from the lines of a namelist file. Groups come in any order, each at most once; a comment begins with
  !> `!`. Anything that is not understood is an error that names file, line, group and variable and quotes the line.
  subroutine read_case(file, lines, c, error)
    character(*), intent(in) :: file               !! for messages
    type(line_type), intent(in) :: lines(:)
    type(case_type), target, intent(inout) :: c
    type(error_type), allocatable, intent(out) :: error
    type(variable_type), allocatable :: list(:)
    type(reader_type) :: reader
    logical, allocatable :: seen(:)
    character(:), allocatable :: groups_seen

    call list_variables(c, list)
    allocate (seen(size(list)))
    seen = .false.
    groups_seen = ' '
    reader%file = file
    reader%lines = lines
    reader%group = ''
    do
      call reader%next(error)
      if (allocated(error)) return
      if (reader%kind == nothing) exit
      if (reader%group == '') then
        call open_group(reader, list, groups_seen, error)
      else if (reader%kind == mark .and. reader%word == '/') then
        reader%group = ''
      else if (reader%kind /= mark .or. reader%word /= ',') then
        call read_variable(reader, list, seen, error)
      end if
      if (allocated(error)) return
    end do
    if (reader%group /= '') then
      call refuse(error, '/ at the end of the group', 'the end of the file', file, group=reader%group)
    else if (len_trim(groups_seen) == 0) then
      call refuse(error, 'namelist groups such as &case', 'nothing', file)
    end if
  end subroutine read_case

  !> Open the group that the last word names.
  subroutine open_group(reader, list, groups_seen, error)
    type(reader_type), intent(inout) :: reader
    type(variable_type), intent(in) :: list(:)
    character(:), allocatable, intent(inout) :: groups_seen    !! names between blanks
    type(error_type), allocatable, intent(out) :: error
    character(:), allocatable :: group, names
    integer :: k

    if (reader%kind /= plain .or. index(reader%word, '&') /= 1) then
      call reader%fail('', 'a group such as &wheelset', reader%shown, error)
      return
    end if
    group = lower(reader%word(2:))
    reader%group = group
    if (.not. any([(list(k)%group == group, k=1, size(list))])) then
      names = ''
      do k = 1, size(list)
        if (index(names//' ', ' &'//list(k)%group//' ') == 0) names = names//' &'//list(k)%group
      end do
      call reader%fail('', 'one of'//names, reader%word, error)
    else if (index(groups_seen, ' '//group//' ') > 0) then
      call reader%fail('', 'each group once', 'a second '//reader%word, error)
    end if
    groups_seen = groups_seen//group//' '
  end subroutine open_group

  !> Read a variable, whose name is the last word, its = and its value.
  subroutine read_variable(reader, list, seen, error)
    type(reader_type), intent(inout) :: reader
    type(variable_type), intent(inout) :: list(:)
    logical, intent(inout) :: seen(:)
    type(error_type), allocatable, intent(out) :: error
    character(:), allocatable :: name, names
    integer :: j, k

    name = reader%word
    do k = size(list), 1, -1
      if (list(k)%group == reader%group .and. lower(list(k)%name) == lower(name)) exit
    end do
    if (reader%kind /= plain .or. k == 0) then
      names = ''
      do j = 1, size(list)
        if (list(j)%group == reader%group) names = names//' '//list(j)%name
      end do
      call reader%fail('', 'one of'//names, name, error)
      return
    end if
    if (seen(k)) then
      call reader%fail(name, 'once', 'a second time', error)
      return
    end if
    seen(k) = .true.
    call reader%next(error)
    if (allocated(error)) return
    if (reader%kind /= mark .or. reader%word /= '=') then
      call reader%fail(name, '=', reader%shown, error)
      return
    end if
    call reader%next(error)
    if (.not. allocated(error)) call set_value(reader, list(k), error)
  end subroutine read_variable

  !> Set a variable to the last word.
  subroutine set_value(reader, variable, error)
    type(reader_type), intent(in) :: reader
    type(variable_type), intent(inout) :: variable
    type(error_type), allocatable, intent(out) :: error
    real(dp) :: x
    logical :: ok

    if (associated(variable%text)) then
      ok = (reader%kind == quoted .or. (variable%slope .and. reader%kind == plain)) .and. len(reader%word) <= text_length
      if (ok) variable%text = reader%word
    else
      ok = .false.
      if (variable%slope .and. reader%kind /= mark) then
        call to_angle(reader%word, x, ok)
      else if (reader%kind == plain) then
        call to_real(reader%word, x, ok)
      end if
      if (ok .and. associated(variable%i)) ok = abs(x) < 1e9_dp .and. abs(x - anint(x)) <= 0
      if (ok .and. associated(variable%i)) variable%i = nint(x)
      if (ok .and. associated(variable%x)) variable%x = x
    end if
    if (ok) ok = admissible(variable)
    if (.not. ok) call reader%fail(variable%name, trim(range_text(variable)), reader%shown, error)
  end subroutine set_value

  !> Go to the next word: plain text, a quoted text, or one of = , /.
  subroutine next(this, error)
    class(reader_type), intent(inout) :: this
    type(error_type), allocatable, intent(out) :: error
    character(:), allocatable :: t
    integer :: from

    this%kind = nothing
    this%word = ''
    this%shown = 'the end of the file'
    do
      if (this%line > size(this%lines)) return
      t = this%lines(this%line)%text//'!'           ! every line ends with a comment
      from = this%column - 1 + verify(t(this%column:), ' ')
      if (t(from:from) /= '!') exit
      this%line = this%line + 1
      this%column = 1
    end do
    this%column = from
    select case (t(from:from))
    case ('=', ',', '/')
      this%kind = mark
      this%column = from + 1
      this%word = t(from:from)
    case ('''', '"')
      this%kind = quoted
      call this%next_quoted(t(:len(t) - 1), error)
      if (allocated(error)) return
    case default
      this%kind = plain
      this%column = from - 1 + scan(t(from:), ' =,/!''"')
      this%word = t(from:this%column - 1)
    end select
    this%shown = t(from:this%column - 1)
  end subroutine next

  !> Go to the end of a text in quotes. Two quotes in a row stand for one quote in the text.
  subroutine next_quoted(this, t, error)
    class(reader_type), intent(inout) :: this
    character(*), intent(in) :: t                  !! the line
    type(error_type), allocatable, intent(out) :: error
    character :: quote
    integer :: from, length

    from = this%column
    quote = t(from:from)
    do
      length = index(t(this%column + 1:), quote) - 1
      if (length < 0) then
        call this%fail('', 'a closing quote', t(from:), error)
        return
      end if
      this%word = this%word//t(this%column + 1:this%column + length)
      this%column = this%column + length + 2
      if (index(t(this%column:), quote) /= 1) exit
      this%word = this%word//quote
    end do
  end subroutine next_quoted

  subroutine fail(this, name, expected, found, error)
    class(reader_type), intent(in) :: this
    character(*), intent(in) :: name, expected, found
    type(error_type), allocatable, intent(out) :: error
    integer :: at

    at = min(this%line, size(this%lines))
    call refuse(error, expected, clip(found), this%file, at, clip(this%group), name, &
      rest='  ['//clip(adjustl(this%lines(at)%text))//']')
  end subroutine fail

end module case_reader
