!> Steps that are cut where they change the total energy by more than a tolerance, or where they fail.
!>
!> Two, four or more equal steps replace such a step. The criterion is the same for the reversed step, so the integration stays
!> reversible.
module cut_steps
  use, intrinsic :: iso_fortran_env, only: int64
  use errors, only: error_type
  use integrators, only: advance, energy_change, energy_rounding, integrator_type, step_ok
  use kinds, only: dp
  use motion_state, only: motion_type
  use wheelset, only: wheelset_type
  implicit none
  private
  public :: cutting_type, step_watcher, cut_step, short_step

  type :: cutting_type
    real(dp) :: tolerance = 0              !! change of the total energy that a step may make [J]; 0: any
    integer :: most_halvings = 20          !! of a step
  end type cutting_type

  !> A watcher is told of every step, and counts.
  type, abstract :: step_watcher
    integer(int64) :: cuts = 0             !! number of steps that were cut
    integer(int64) :: missed = 0           !! steps that miss the tolerance after all halvings
    integer(int64) :: evaluations = 0      !! evaluations of the contacts
  contains
    procedure(after_step), deferred :: after_step
  end type step_watcher

  abstract interface
    !> A step has been made from `old` to `new`.
    subroutine after_step(this, old, new, error)
      import :: error_type, motion_type, step_watcher
      class(step_watcher), intent(inout) :: this
      type(motion_type), intent(in) :: old, new
      type(error_type), allocatable, intent(out) :: error
    end subroutine after_step
  end interface

contains

  !> Make one step, or the shorter ones that replace it. The motion ends where a step fails after all halvings.
  recursive subroutine cut_step(w, integrator, cutting, motion, dt, halvings, watcher, status, error)
    type(wheelset_type), intent(in) :: w
    type(integrator_type), intent(in) :: integrator
    type(cutting_type), intent(in) :: cutting
    type(motion_type), intent(inout) :: motion
    real(dp), intent(in) :: dt             !! [s]
    integer, intent(in) :: halvings        !! number of halvings that have led to this step
    class(step_watcher), intent(inout) :: watcher
    integer, intent(out) :: status         !! of `integrators`
    type(error_type), allocatable, intent(out) :: error   !! of the watcher
    type(motion_type) :: old, new
    integer :: evaluations, more, i
    real(dp) :: change, allowed

    call advance(w, integrator, motion, dt, new, evaluations, status)
    watcher%evaluations = watcher%evaluations + evaluations
    more = 0
    if (status /= step_ok) then
      if (halvings == cutting%most_halvings) return
      more = 1
    else if (cutting%tolerance > 0) then
      change = energy_change(w, motion, new)
      allowed = cutting%tolerance
      if (abs(change) > allowed) allowed = max(allowed, energy_rounding(w, motion), energy_rounding(w, new))
      if (abs(change) > allowed) then
        ! The change goes with dt^(order + 1).
        more = (exponent(change/allowed) + integrator%order)/(integrator%order + 1)
        more = min(max(1, more), cutting%most_halvings - halvings)
        if (more == 0) watcher%missed = watcher%missed + 1
      end if
    end if
    if (more == 0) then
      old = motion
      motion = new
      call watcher%after_step(old, new, error)
      return
    end if
    watcher%cuts = watcher%cuts + 1
    do i = 1, 2**more
      call cut_step(w, integrator, cutting, motion, dt/2**more, halvings + more, watcher, status, error)
      if (status /= step_ok .or. allocated(error)) return
    end do
  end subroutine cut_step

  !> The motion at a time t near the end `old` of a step, in as many equal steps as the tolerance needs.
  subroutine short_step(w, integrator, cutting, old, t, there, found, evaluations)
    type(wheelset_type), intent(in) :: w
    type(integrator_type), intent(in) :: integrator
    type(cutting_type), intent(in) :: cutting
    type(motion_type), intent(in) :: old
    real(dp), intent(in) :: t                    !! [s]
    type(motion_type), intent(out) :: there
    logical, intent(out) :: found                !! the steps converged
    integer(int64), intent(inout) :: evaluations
    type(motion_type) :: from
    integer, parameter :: most_halvings = 6
    integer :: more, halvings, i, status

    there = old
    found = .true.
    if (abs(t - old%t) <= 0) return
    do halvings = 0, most_halvings
      there = old
      do i = 1, 2**halvings
        from = there
        call advance(w, integrator, from, (t - old%t)/2**halvings, there, more, status)
        evaluations = evaluations + more
        if (status /= step_ok) exit
      end do
      if (status /= step_ok) cycle
      if (cutting%tolerance <= 0 .or. abs(energy_change(w, old, there)) <= cutting%tolerance) exit
    end do
    found = status == step_ok
  end subroutine short_step

end module cut_steps
