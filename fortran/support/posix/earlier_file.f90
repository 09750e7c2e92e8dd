!> What a file keeps that is replaced: the link that leads to it, and who may read it. Systems of POSIX have links and modes.
module earlier_file
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_intptr_t, c_null_char, c_size_t
  implicit none
  private
  public :: followed, copy_mode

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

  !> The path of the file that symbolic links lead to, whether the file exists or not; a path that is no link stays as it is.
  function followed(path) result(file)
    character(*), intent(in) :: path
    character(:), allocatable :: file
    integer, parameter :: most = 40         ! links that Linux follows; links in a circle have no end
    character(4096) :: target               ! longer than any path of the systems in use
    integer :: k, length

    file = path
    do k = 1, most
      target = ''
      length = int(c_readlink(file//c_null_char, target, len(target, c_size_t)))
      if (length <= 0) return               ! the path is no link
      if (target(1:1) == '/') then
        file = target(:length)
      else
        file = file(:index(file, '/', back=.true.))//target(:length)
      end if
    end do
  end function followed

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

end module earlier_file
