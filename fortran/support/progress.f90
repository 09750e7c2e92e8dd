!> A watcher of a long computation learns how far the computation is, and may ask it to stop. The watcher of the executable
!> shows the progress on the terminal.
module progress
  use, intrinsic :: iso_fortran_env, only: error_unit, int64
  use kinds, only: dp
  use system, only: on_terminal
  implicit none
  private
  public :: monitor_type, terminal_monitor

  type, abstract :: monitor_type
    logical :: stop = .false.            !! set it to end the computation early
  contains
    procedure(report), deferred :: report
  end type monitor_type

  abstract interface
    subroutine report(this, share)
      import :: dp, monitor_type
      class(monitor_type), intent(inout) :: this
      real(dp), intent(in) :: share      !! completed share, 0 to 1
    end subroutine report
  end interface

  !> Shows a line on standard error if standard error is a terminal and the work takes more than a second.
  type, extends(monitor_type) :: terminal_monitor
    logical :: visible = .false.         !! standard error is a terminal
    logical :: shown = .false.           !! there is a line to clear
    integer(int64) :: started = 0        !! [ticks of system_clock]
  contains
    procedure :: begin
    procedure :: report => show
    procedure :: clear
  end type terminal_monitor

contains

  subroutine begin(this)
    class(terminal_monitor), intent(inout) :: this

    this%visible = on_terminal()
    call system_clock(this%started)
  end subroutine begin

  subroutine show(this, share)
    class(terminal_monitor), intent(inout) :: this
    real(dp), intent(in) :: share
    integer(int64) :: now, rate

    if (.not. this%visible) return
    call system_clock(now, rate)
    if (now - this%started < rate) return
    this%shown = .true.
    write (error_unit, '(a,i3,a)', advance='no') achar(13)//'ldbench: integration ', nint(100*share), ' %   '
  end subroutine show

  subroutine clear(this)
    class(terminal_monitor), intent(inout) :: this

    if (this%shown) write (error_unit, '(a)', advance='no') achar(13)//repeat(' ', 40)//achar(13)
    this%shown = .false.
  end subroutine clear

end module progress