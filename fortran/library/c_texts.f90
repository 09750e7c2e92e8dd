!> Texts, statuses and messages between the core and C.
module c_texts
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_f_pointer, c_int, c_null_char, c_ptr
  use errors, only: error_type, fatal_error
  implicit none
  private
  public :: ok, refused, outside, no_room, need, text_at, give, clear, told, tell

  enum, bind(c)
    enumerator :: ok = 0, refused, outside, no_room     ! LDBENCH_OK and so on of ldbench.h
  end enum

contains

  !> Refuse a null pointer.
  subroutine need(pointer, name, error)
    type(c_ptr), intent(in) :: pointer
    character(*), intent(in) :: name
    type(error_type), allocatable, intent(inout) :: error

    if (allocated(error) .or. c_associated(pointer)) return
    call fatal_error(error, name//': expected an address, found a null pointer')
  end subroutine need

  !> The characters at an address, up to the null character.
  subroutine text_at(address, name, text, error)
    type(c_ptr), intent(in) :: address
    character(*), intent(in) :: name
    character(:), allocatable, intent(out) :: text
    type(error_type), allocatable, intent(out) :: error
    character(kind=c_char), pointer :: letters(:)
    integer, parameter :: most = 1000000
    integer :: n, k

    text = ''
    call need(address, name, error)
    if (allocated(error)) return
    call c_f_pointer(address, letters, [most])
    n = 0
    do while (n < most)
      if (letters(n + 1) == c_null_char) exit
      n = n + 1
    end do
    deallocate (text)
    allocate (character(n) :: text)
    do k = 1, n
      text(k:k) = letters(k)
    end do
  end subroutine text_at

  !> Write a text, as much of it as there is room for, and the null character.
  integer(c_int) function give(text, address, size) result(status)
    character(*), intent(in) :: text
    type(c_ptr), intent(in) :: address
    integer(c_int), intent(in) :: size
    character(kind=c_char), pointer :: letters(:)
    integer :: n, k

    status = no_room
    if (.not. c_associated(address) .or. size < 1) return
    call c_f_pointer(address, letters, [int(size)])
    n = min(len(text), int(size) - 1)
    do k = 1, n
      letters(k) = text(k:k)
    end do
    letters(n + 1) = c_null_char
    if (n == len(text)) status = ok
  end function give

  !> An empty message.
  subroutine clear(message, size)
    type(c_ptr), intent(in) :: message
    integer(c_int), intent(in) :: size
    integer(c_int) :: ignored

    ignored = give('', message, size)
  end subroutine clear

  !> The status of an error, whose message is written.
  integer(c_int) function told(error, message, size) result(status)
    type(error_type), allocatable, intent(in) :: error
    type(c_ptr), intent(in) :: message
    integer(c_int), intent(in) :: size

    status = merge(refused, ok, allocated(error))
    call tell(error, message, size)
  end function told

  !> Write the message of an error.
  subroutine tell(error, message, size)
    type(error_type), allocatable, intent(in) :: error
    type(c_ptr), intent(in) :: message
    integer(c_int), intent(in) :: size
    integer(c_int) :: ignored

    if (allocated(error)) ignored = give(error%message, message, size)
  end subroutine tell

end module c_texts
