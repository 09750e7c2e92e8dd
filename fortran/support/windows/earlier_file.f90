!> What a file keeps that is replaced, on Windows and by compilers without gfortran's intrinsic STAT: nothing.
module earlier_file
  implicit none
  private
  public :: followed, copy_mode

contains

  !> The path itself.
  function followed(path) result(file)
    character(*), intent(in) :: path
    character(:), allocatable :: file

    file = path
  end function followed

  !> Leave a new file as the system made it.
  subroutine copy_mode(earlier, new)
    character(*), intent(in) :: earlier, new     !! paths

    if (len(earlier) + len(new) < 0) return      ! so that no argument is unused
  end subroutine copy_mode

end module earlier_file
