!> The little that is needed of the operating system.
module system
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_int, c_null_char, c_ptr
  use text, only: str
  implicit none
  private
  public :: on_terminal, replace_file, scratch_name, same_file

  interface
    integer(c_int) function c_isatty(descriptor) bind(c, name='isatty')
      import :: c_int
      integer(c_int), value :: descriptor
    end function c_isatty
    integer(c_int) function c_rename(from, to) bind(c, name='rename')
      import :: c_char, c_int
      character(kind=c_char), intent(in) :: from(*), to(*)
    end function c_rename
    integer(c_int) function c_getpid() bind(c, name='getpid')
      import :: c_int
    end function c_getpid
    type(c_ptr) function c_realpath(path, resolved) bind(c, name='realpath')
      import :: c_char, c_ptr
      character(kind=c_char), intent(in) :: path(*)
      character(kind=c_char), intent(out) :: resolved(*)
    end function c_realpath
  end interface

contains

  !> Whether two paths lead to the same file, which need not be there yet.
  logical function same_file(a, b)
    character(*), intent(in) :: a, b

    same_file = resolved(a) == resolved(b)
  end function same_file

  !> The absolute path without links; of a file to come, its folder's.
  recursive function resolved(path) result(absolute)
    character(*), intent(in) :: path
    character(:), allocatable :: absolute
    integer, parameter :: path_max = 4096
    character(path_max) :: buffer
    integer :: slash

    if (c_associated(c_realpath(path//c_null_char, buffer))) then
      absolute = buffer(:index(buffer, c_null_char) - 1)
      return
    end if
    slash = index(path, '/', back=.true.)
    absolute = path
    if (slash == 0 .and. path /= '.') absolute = resolved('.')//'/'//path
    if (slash > 1 .and. slash < len(path)) absolute = resolved(path(:slash - 1))//path(slash:)
  end function resolved

  !> Whether standard error goes to a terminal.
  logical function on_terminal()
    on_terminal = c_isatty(2_c_int) == 1
  end function on_terminal

  !> A name beside `file` for writing it before it is complete.
  function scratch_name(file) result(name)
    character(*), intent(in) :: file
    character(:), allocatable :: name

    name = file//'.part'//str(int(c_getpid()))
  end function scratch_name

  !> Rename a finished file over the old one, in one step; where that fails the
  !> finished file is removed.
  subroutine replace_file(from, to, stat)
    character(*), intent(in) :: from, to
    integer, intent(out) :: stat
    integer :: unit, ignored

    stat = int(c_rename(from//c_null_char, to//c_null_char))
    if (stat == 0) return
    open (newunit=unit, file=from, iostat=ignored)
    if (ignored == 0) close (unit, status='delete', iostat=ignored)
  end subroutine replace_file

end module system
