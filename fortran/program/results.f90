!> A list of results with name, value, unit and words. Each result is printed twice: with all digits as an entry of a namelist
!> group, for the comments of a column file, and in a sentence on the terminal.
module results
  use, intrinsic :: iso_fortran_env, only: int64
  use kinds, only: dp
  use text, only: shortest, str, with_zero
  implicit none
  private
  public :: result_list, newline, rounded

  character, parameter :: newline = new_line('a')

  !> `result_list('', '', '')` is empty.
  type :: result_list
    character(:), allocatable :: entries     !! lines of a namelist group
    character(:), allocatable :: warnings    !! lines
    character(:), allocatable :: sentences   !! the text on the terminal, with the warnings
    logical :: silent = .false.              !! what is added has no sentence
  contains
    procedure, private :: add_numbers, add_count, add_text
    generic :: add => add_numbers, add_count, add_text
    procedure, private :: add_entry
    procedure :: append
    procedure :: warn
  end type result_list

contains

  !> Add numbers. On the terminal they stand where `words` has marks #, in a format such as 'f0.3', or else with all digits.
  !> A result without a name or without words is printed only once.
  subroutine add_numbers(this, name, x, unit, words, form, factor)
    class(result_list), intent(inout) :: this
    character(*), intent(in) :: name
    real(dp), intent(in) :: x(:)                   !! in SI units
    character(*), intent(in) :: unit               !! and meaning
    character(*), intent(in), optional :: words, form
    real(dp), intent(in), optional :: factor       !! unit on the terminal over SI unit
    character(:), allocatable :: value, rest
    real(dp) :: shown
    integer :: k, mark

    value = ''
    rest = ''
    if (present(words)) rest = words
    do k = 1, size(x)
      value = value//', '//trim(shortest(x(k)))
      mark = index(rest, '#')
      if (mark == 0) cycle
      shown = x(k)
      if (present(factor)) shown = factor*x(k)
      if (present(form)) then
        call this%append(rest(:mark), rounded(shown, form))
      else
        call this%append(rest(:mark), shortest(shown))
      end if
      rest = rest(mark + 1:)
    end do
    call this%add_entry(name, value(3:), unit)
    call this%append(rest)
  end subroutine add_numbers

  subroutine add_count(this, name, n, words)
    class(result_list), intent(inout) :: this
    character(*), intent(in) :: name, words
    integer(int64), intent(in) :: n

    call this%add_entry(name, str(n), '')
    call this%append(words, str(n))
  end subroutine add_count

  subroutine add_text(this, name, text, words)
    class(result_list), intent(inout) :: this
    character(*), intent(in) :: name, text, words

    call this%add_entry(name, "'"//text//"'", '')
    call this%append(words, text)
  end subroutine add_text

  !> Add an entry to the group. The components of an event stand in one line.
  subroutine add_entry(this, name, value, unit)
    class(result_list), intent(inout) :: this
    character(*), intent(in) :: name, value, unit

    if (name == '') return
    if (index(name, '%') > 0 .and. index(name, '%t') == 0) then
      this%entries = this%entries(:len(this%entries) - 1)//', '//name//' = '//value
    else
      this%entries = this%entries//'  '//name//' = '//value
    end if
    if (unit /= '') this%entries = this%entries//'  ! '//unit
    this%entries = this%entries//newline
  end subroutine add_entry

  !> Add words on the terminal, with a value in the place of the mark #.
  subroutine append(this, words, value)
    class(result_list), intent(inout) :: this
    character(*), intent(in) :: words
    character(*), intent(in), optional :: value
    integer :: mark

    if (this%silent) return
    mark = index(words, '#')
    if (mark == 0 .or. .not. present(value)) then
      this%sentences = this%sentences//words
    else
      this%sentences = this%sentences//words(:mark - 1)//trim(value)//words(mark + 1:)
    end if
  end subroutine append

  subroutine warn(this, words)
    class(result_list), intent(inout) :: this
    character(*), intent(in) :: words

    this%warnings = this%warnings//'warning: '//words//newline
    call this%append('warning: '//words//newline)
  end subroutine warn

  !> A number in a format such as 'f0.3'.
  pure function rounded(x, form) result(word)
    real(dp), intent(in) :: x
    character(*), intent(in) :: form
    character(40) :: word

    write (word, '('//form//')') x
    word = with_zero(adjustl(word))
    if (word(1:1) == '-' .and. verify(word, '-0. ') == 0) word = word(2:)      ! a small negative number, rounded to zero
  end function rounded

end module results
