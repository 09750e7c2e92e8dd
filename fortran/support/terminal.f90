!> A progress line on standard error, when that is a terminal and the work takes more than a second.
module terminal
  use, intrinsic :: iso_fortran_env, only: error_unit, int64
  use kinds, only: dp
  use progress, only: monitor_type
  use system, only: on_terminal
  implicit none
  private
  public :: terminal_monitor

  type, extends(monitor_type) :: terminal_monitor
    logical :: visible = .false.         !! standard error is a terminal
    logical :: shown = .false.           !! there is a line to clear
    integer(int64) :: started = 0        !! [ticks of system_clock]
  contains
    procedure :: begin
    procedure :: report
    procedure :: clear
  end type terminal_monitor

contains

  subroutine begin(this)
    class(terminal_monitor), intent(inout) :: this

    this%visible = on_terminal()
    call system_clock(this%started)
  end subroutine begin

  subroutine report(this, stage, share)
    class(terminal_monitor), intent(inout) :: this
    character(*), intent(in) :: stage
    real(dp), intent(in) :: share
    integer(int64) :: now, rate

    if (.not. this%visible) return
    call system_clock(now, rate)
    if (now - this%started < rate) return
    this%shown = .true.
    write (error_unit, '(a,i3,a)', advance='no') achar(13)//'ldbench: '//stage//' ', nint(100*share), ' %   '
  end subroutine report

  subroutine clear(this)
    class(terminal_monitor), intent(inout) :: this

    if (this%shown) write (error_unit, '(a)', advance='no') achar(13)//repeat(' ', 40)//achar(13)
    this%shown = .false.
  end subroutine clear

end module terminal
