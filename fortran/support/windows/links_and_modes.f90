!> Stands in on Windows, and for compilers without gfortran's intrinsic STAT: no path is a link, and modes are left alone.
module links_and_modes
  implicit none
  private
  public :: read_link, follow_links, copy_mode

contains

  !> No target.
  subroutine read_link(path, target)
    character(*), intent(in) :: path
    character(:), allocatable, intent(out) :: target

    target = path(:0)
  end subroutine read_link

  !> The path itself.
  subroutine follow_links(path, file)
    character(*), intent(in) :: path
    character(:), allocatable, intent(out) :: file

    file = path
  end subroutine follow_links

  !> Leave a new file as the system made it.
  subroutine copy_mode(earlier, new)
    character(*), intent(in) :: earlier, new     !! paths

    if (len(earlier) + len(new) < 0) return      ! so that no argument is unused
  end subroutine copy_mode

end module links_and_modes
