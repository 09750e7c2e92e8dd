!> A watcher of a long computation learns how far the computation is, and may ask it to stop. The watcher of the executable
!> shows the progress on the terminal.
module progress
  use, intrinsic :: iso_fortran_env, only: error_unit, int64
  use kinds, only: dp
  use system, only: on_terminal
  implicit none
  private
  public :: monitor_type, terminal_monitor, goes_on, share_of_round, build_share

  !> Share of the work on a contact table that building takes; the rest measures the error.
  real(dp), parameter :: build_share = 0.85_dp

  type, abstract :: monitor_type
    logical :: stop = .false.            !! set it to end the computation early
    real(dp) :: from = 0, to = 1         !! the part of the stage to which the reported shares belong
  contains
    procedure(report), deferred :: report
    procedure :: tell
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

  !> Report a share of the part of the stage that is under way.
  subroutine tell(this, stage, share)
    class(monitor_type), intent(inout) :: this
    character(*), intent(in) :: stage
    real(dp), intent(in) :: share

    call this%report(stage, this%from + share*(this%to - this%from))
  end subroutine tell

  !> Count a piece of the work and say whether it is to be done. The thread that began the work tells the watcher, who may
  !> ask it to stop.
  logical function goes_on(work, done, all, stopped, watcher)
    !$ use omp_lib, only: omp_get_thread_num
    real(dp), intent(in) :: work(2)
    integer, intent(inout) :: done         !! shared by the threads, as `stopped` is
    integer, intent(in) :: all
    logical, intent(inout) :: stopped
    class(monitor_type), intent(inout), optional :: watcher
    integer :: before
    logical :: no_more

    !$omp atomic capture
    before = done
    done = done + 1
    !$omp end atomic
    !$omp atomic read
    no_more = stopped
    goes_on = .not. no_more
    if (.not. present(watcher) .or. .not. goes_on) return
    !$ if (omp_get_thread_num() /= 0) return
    call watcher%tell('table', work(1) + (work(2) - work(1))*before/all)
    goes_on = .not. watcher%stop
    if (goes_on) return
    !$omp atomic write
    stopped = .true.
  end function goes_on

  !> Share of the work that is done before and after a round. Each round is expected to leave 0.6 of the remaining work.
  pure function share_of_round(work, round) result(part)
    real(dp), intent(in) :: work(2)
    integer, intent(in) :: round
    real(dp) :: part(2)

    part = work(1) + (work(2) - work(1))*[1 - 0.6_dp**(round - 1), 1 - 0.6_dp**round]
  end function share_of_round

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