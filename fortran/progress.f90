!> Somebody who watches a long computation: told how far it is, may ask it to stop.
module progress
  use kinds, only: dp
  implicit none
  private
  public :: monitor_type

  type, abstract :: monitor_type
    logical :: stop = .false.            !! set it to end the computation early
    real(dp) :: from = 0, to = 1         !! the share of the stage that is under way
  contains
    procedure(report), deferred :: report
    procedure :: tell
  end type monitor_type

  abstract interface
    subroutine report(this, stage, share)
      import :: dp, monitor_type
      class(monitor_type), intent(inout) :: this
      character(*), intent(in) :: stage  !! 'table' or 'integration'
      real(dp), intent(in) :: share      !! done, 0 to 1
    end subroutine report
  end interface

contains

  !> Report the share done of what is under way.
  subroutine tell(this, stage, share)
    class(monitor_type), intent(inout) :: this
    character(*), intent(in) :: stage
    real(dp), intent(in) :: share

    call this%report(stage, this%from + share*(this%to - this%from))
  end subroutine tell

end module progress
