!> What happens in the executable when there is no memory left: one line, and no backtrace.
module memory
  use, intrinsic :: iso_c_binding, only: c_int, c_new_line, c_size_t
  use system, only: c_write
  implicit none
  private
  public :: no_memory

  interface
    subroutine c_exit(status) bind(c, name='_exit')
      import :: c_int
      integer(c_int), value :: status
    end subroutine c_exit
  end interface

contains

  !> Replaces the procedure of gfortran's library that an ALLOCATE without `stat` calls when it fails. The argument is a text
  !> for printf, which is not needed. The body needs no memory.
  subroutine no_memory() bind(c, name='_gfortran_os_error_at')
    character(*), parameter :: message = 'ldbench: error: expected more memory, found none left'//c_new_line
    integer(c_size_t) :: ignored

    ignored = c_write(2_c_int, message, len(message, c_size_t))
    call c_exit(1_c_int)
  end subroutine no_memory

end module memory