!> Errors as values: a procedure that can fail has an argument `type(error_type), allocatable, intent(out) :: error`; it is
!> allocated when something went wrong.  Nothing in the library prints or stops.
module errors
  implicit none
  private
  public :: error_type, fatal_error

  type :: error_type
    character(:), allocatable :: message  !! one line: file, group, variable, expected, found
  end type error_type

contains

  !> `error` is not intent(out): it would be freed before a message that quotes the error so far is put together.
  pure subroutine fatal_error(error, message)
    type(error_type), allocatable, intent(inout) :: error
    character(*), intent(in) :: message   !! a character that cannot be printed becomes '?'
    integer :: i

    if (.not. allocated(error)) allocate (error)
    error%message = trim(message)
    do i = 1, len_trim(message)
      if (iachar(message(i:i)) < 32 .or. iachar(message(i:i)) == 127) error%message(i:i) = '?'
    end do
  end subroutine fatal_error

end module errors