!> The terminal's progress line by a clock of the caller's.
!>
!> usage: progress_line shown|hidden < reports
!> Reports, one a line: seconds on the clock, stage, share done.  After the last the line is cleared.
module hand_clock
  use, intrinsic :: iso_fortran_env, only: int64
  use kinds, only: dp
  implicit none
  private
  public :: seconds, hand_time

  real(dp) :: seconds = 0

contains

  subroutine hand_time(now, rate)
    integer(int64), intent(out) :: now, rate

    rate = 1000
    now = nint(rate*seconds, int64)
  end subroutine hand_time

end module hand_clock
program progress_line
  use hand_clock, only: hand_time, seconds
  use kinds, only: dp
  use terminal, only: terminal_monitor
  implicit none
  save
  type(terminal_monitor) :: watcher
  character(16) :: word, stage
  real(dp) :: share
  integer :: status

  call get_command_argument(1, word)
  watcher%clock => hand_time
  call watcher%begin()
  watcher%visible = word == 'shown'
  do
    read (*, *, iostat=status) seconds, stage, share
    if (status /= 0) exit
    call watcher%report(trim(stage), share)
  end do
  call watcher%clear()
end program progress_line
