!> Peaks of normal forces between the ends of steps: a peak is known one step after it has passed.
module force_peaks
  use kinds, only: dp
  implicit none
  private
  public :: passed_peak, find_peak

contains

  !> Whether a force was largest about one step ago.
  pure logical function passed_peak(force)
    real(dp), intent(in) :: force(3)             !! two steps ago, one step ago and now [N]

    passed_peak = force(2) > force(1) .and. force(2) >= force(3)
  end function passed_peak

  !> Time at which the parabola through the forces of three steps is largest.
  pure subroutine find_peak(force, time, t, found)
    real(dp), intent(in) :: force(3), time(3)    !! [N, s]
    real(dp), intent(out) :: t                   !! [s]
    logical, intent(out) :: found                !! the parabola has a maximum
    real(dp) :: rise, fall, bend

    rise = (force(2) - force(1))/(time(2) - time(1))
    fall = (force(3) - force(2))/(time(3) - time(2))
    bend = (fall - rise)/(time(3) - time(1))
    t = time(2)
    found = bend < 0
    if (found) t = time(2) - (rise + bend*(time(2) - time(1)))/(2*bend)
  end subroutine find_peak

end module force_peaks
