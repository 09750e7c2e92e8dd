!> What files have on systems of POSIX and nowhere else: links that lead to them, and modes, which say who may read them.
module links_and_modes
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_intptr_t, c_null_char, c_size_t
  implicit none
  private
  public :: read_link, follow_links, copy_mode

  interface
    integer(c_intptr_t) function c_readlink(path, target, room) bind(c, name='readlink')
      import :: c_char, c_intptr_t, c_size_t
      character(kind=c_char), intent(in) :: path(*)
      character(kind=c_char), intent(inout) :: target(*)
      integer(c_size_t), value :: room
    end function c_readlink
    integer(c_int) function c_chmod(path, mode) bind(c, name='chmod')
      import :: c_char, c_int
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int), value :: mode
    end function c_chmod
  end interface

contains

  !> The target of a symbolic link; '' where a path is none.
  subroutine read_link(path, target)
    character(*), intent(in) :: path
    character(:), allocatable, intent(out) :: target
    character(4096) :: buffer              ! longer than any path of the systems in use
    integer :: n

    buffer = ''
    n = int(c_readlink(path//c_null_char, buffer, len(buffer, c_size_t)))
    target = buffer(:max(n, 0))
  end subroutine read_link

  !> The path of the file that symbolic links lead to, whether the file exists or not; a path that is no link stays as it is.
  subroutine follow_links(path, file)
    character(*), intent(in) :: path
    character(:), allocatable, intent(out) :: file
    integer, parameter :: most = 40        ! links that Linux follows; links in a circle have no end
    character(:), allocatable :: target
    integer :: k

    file = path
    do k = 1, most
      call read_link(file, target)
      if (target == '') return
      if (target(1:1) /= '/') target = file(:index(file, '/', back=.true.))//target
      call move_alloc(target, file)
    end do
  end subroutine follow_links

  !> Give a new file the mode of the earlier one, if there is one: nobody else may read it.
  subroutine copy_mode(earlier, new)
    character(*), intent(in) :: earlier, new     !! paths
    integer, parameter :: permissions = int(o'777')
    integer :: facts(13), status                 ! of the file, as gfortran's STAT lists them; the third one is the mode
    integer(c_int) :: ignored
    intrinsic :: stat

    call stat(earlier, facts, status)
    if (status == 0) ignored = c_chmod(new//c_null_char, int(iand(facts(3), permissions), c_int))
  end subroutine copy_mode

end module links_and_modes
