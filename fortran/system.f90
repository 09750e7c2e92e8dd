!> The little that is needed of the operating system.
module system
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char
  use text, only: str
  implicit none
  private
  public :: on_terminal, replace_file, scratch_name

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
  end interface

contains

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
