!> Errors as values: a procedure that can fail has an argument `type(error_type), allocatable, intent(out) :: error`; it is
!> allocated when something went wrong.  Nothing in the library prints or stops.
module errors
  implicit none
  private
  public :: error_type, refuse, fatal_error, place_error, append_advice

  !> The fields of an error, as far as it has them, and the message that is composed of them here.
  type :: error_type
    character(:), allocatable :: message           !! one line
    character(:), allocatable :: file              !! that is wrong, or in which something is
    integer :: line = 0                            !! of the file; 0: none
    character(:), allocatable :: group, variable   !! of the namelist
    character(:), allocatable :: expected, found
    logical :: missing = .false.                   !! there is no such file
  end type error_type

contains

  !> An error of what was expected and what was found. Its message is 'FILE, line LINE, &GROUP VARIABLE DETAIL: expected EXPECTED,
  !> found FOUND REST', less what is not given.
  pure subroutine refuse(error, expected, found, file, line, group, variable, detail, rest)
    type(error_type), allocatable, intent(out) :: error
    character(*), intent(in) :: expected, found
    character(*), intent(in), optional :: file
    integer, intent(in), optional :: line
    character(*), intent(in), optional :: group, variable   !! an empty one is none
    character(*), intent(in), optional :: detail    !! follows the variable in the message, as does its value
    character(*), intent(in), optional :: rest      !! follows what was found: the line that is quoted, an advice
    character(:), allocatable :: ending

    ending = ''
    if (present(rest)) ending = rest
    call fatal_error(error, 'expected '//expected//', found '//found//ending, file, line, group, variable, detail)
    error%expected = printable(expected)
    error%found = printable(found)
  end subroutine refuse

  !> An error that a statement tells. Its message is 'FILE, line LINE, &GROUP VARIABLE DETAIL: STATEMENT', less what is not given.
  pure subroutine fatal_error(error, statement, file, line, group, variable, detail)
    type(error_type), allocatable, intent(out) :: error
    character(*), intent(in) :: statement
    character(*), intent(in), optional :: file
    integer, intent(in), optional :: line
    character(*), intent(in), optional :: group, variable   !! an empty one is none
    character(*), intent(in), optional :: detail    !! follows the variable in the message, as does its value
    character(:), allocatable :: place
    character(12) :: number

    allocate (error)
    place = ''
    if (present(detail)) place = detail
    if (given(variable)) then
      error%variable = printable(variable)
      place = ' '//trim(variable)//place
    end if
    if (given(group)) then
      error%group = printable(group)
      place = ', &'//trim(group)//place
    end if
    if (present(line)) then
      error%line = line
      write (number, '(i0)') line
      place = ', line '//trim(number)//place
    end if
    if (present(file)) then
      error%file = printable(file)
      place = file//place
    else if (index(place, ', ') == 1) then
      place = place(3:)
    end if
    if (place /= '') place = place//': '
    error%message = printable(place//statement)
  end subroutine fatal_error

  !> Tell where the error was met, before its own place: in a variable of the case, which names the file that is wrong, or in
  !> the file of the case.
  pure subroutine place_error(error, file, group, variable)
    type(error_type), allocatable, intent(inout) :: error
    character(*), intent(in), optional :: file
    character(*), intent(in), optional :: group, variable    !! both or none

    if (present(group)) then
      error%message = '&'//group//' '//variable//': '//error%message
      error%group = group
      error%variable = variable
    end if
    if (present(file)) then
      error%message = printable(file)//merge(', ', ': ', allocated(error%group))//error%message
      if (.not. allocated(error%file)) error%file = printable(file)
    end if
  end subroutine place_error

  !> Tell at the end of the message what to do.
  pure subroutine append_advice(error, advice)
    type(error_type), allocatable, intent(inout) :: error
    character(*), intent(in) :: advice

    error%message = error%message//'; '//printable(advice)
  end subroutine append_advice

  !> Whether there is an argument that is not empty.
  pure logical function given(text)
    character(*), intent(in), optional :: text

    given = .false.
    if (present(text)) given = text /= ''
  end function given

  !> A text in which '?' stands for every character that cannot be printed.
  pure function printable(text)
    character(*), intent(in) :: text
    character(len_trim(text)) :: printable
    integer :: i

    printable = text
    do i = 1, len(printable)
      if (iachar(text(i:i)) < 32 .or. iachar(text(i:i)) == 127) printable(i:i) = '?'
    end do
  end function printable

end module errors
