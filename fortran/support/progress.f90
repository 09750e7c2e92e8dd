!> A watcher of a long computation learns how far the computation is, and may ask it to stop. The watcher of the executable
!> shows the progress on the terminal.
module progress
  use, intrinsic :: iso_fortran_env, only: error_unit, int64
  use kinds, only: dp
  use system, only: on_terminal
  implicit none
  private
  public :: monitor_type, terminal_monitor, goes_on, table_reached

  type, abstract :: monitor_type
    logical :: stop = .false.            !! set it to end the computation early
    real(dp) :: table_share = 0          !! of the work on a contact table, that is done
  contains
    procedure(report), deferred :: report
  end type monitor_type

  abstract interface
    subroutine report(this, stage, share)
      import :: dp, monitor_type
      class(monitor_type), intent(inout) :: this
      character(*), intent(in) :: stage  !! 'table' or 'integration'
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

  !> A stage of the work on a contact table has ended.
  subroutine table_reached(share, watcher)
    real(dp), intent(in) :: share          !! of the work
    class(monitor_type), intent(inout), optional :: watcher

    if (.not. present(watcher)) return
    watcher%table_share = share
    call watcher%report('table', share)
  end subroutine table_reached

  !> Whether a piece of the work on a contact table is to be done. The thread that began the work asks the watcher.
  logical function goes_on(stopped, watcher)
    !$ use omp_lib, only: omp_get_thread_num
    logical, intent(inout) :: stopped      !! shared by the threads
    class(monitor_type), intent(inout), optional :: watcher
    logical :: no_more

    !$omp atomic read
    no_more = stopped
    goes_on = .not. no_more
    if (.not. present(watcher) .or. .not. goes_on) return
    !$ if (omp_get_thread_num() /= 0) return
    call watcher%report('table', watcher%table_share)
    goes_on = .not. watcher%stop
    if (goes_on) return
    !$omp atomic write
    stopped = .true.
  end function goes_on

  subroutine begin(this)
    class(terminal_monitor), intent(inout) :: this

    this%visible = on_terminal()
    call system_clock(this%started)
  end subroutine begin

  subroutine show(this, stage, share)
    class(terminal_monitor), intent(inout) :: this
    character(*), intent(in) :: stage
    real(dp), intent(in) :: share
    integer(int64) :: now, rate

    if (.not. this%visible) return
    call system_clock(now, rate)
    if (now - this%started < rate) return
    this%shown = .true.
    write (error_unit, '(a,i3,a)', advance='no') achar(13)//'ldbench: '//stage//' ', nint(100*share), ' %   '
  end subroutine show

  subroutine clear(this)
    class(terminal_monitor), intent(inout) :: this

    if (this%shown) write (error_unit, '(a)', advance='no') achar(13)//repeat(' ', 40)//achar(13)
    this%shown = .false.
  end subroutine clear

end module progress