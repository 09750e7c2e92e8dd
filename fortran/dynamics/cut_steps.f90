!> Steps that are cut where their error exceeds a tolerance, where they change the total energy by more than another one, or where
!> they fail.
!>
!> Two, four or more equal steps replace such a step. The criteria are the same for the reversed step, so the integration stays
!> reversible. The energy alone does not see errors that keep it, such as those of long steps between contacts; the estimate of the
!> error alone leaves too much of the energy's change where contacts close, which the integrator makes with half its order.
module cut_steps
  use, intrinsic :: iso_fortran_env, only: int64
  use errors, only: error_type, refuse
  use integrators, only: advance, integrator_type, step_ok
  use kinds, only: dp
  use motion_state, only: energy_change, energy_rounding, motion_type
  use text, only: str
  use elastic_contacts, only: elastic_wheelset
  implicit none
  private
  public :: cutting_type, step_watcher, cut_step, short_step

  ! A run ends where a step needs more parts: then its forces do not follow from its energy, and halving goes on to the end. Steps
  ! of the longest dt with the smallest useful tolerances need some ten thousand.
  integer, parameter :: most_parts = 100000

  type :: cutting_type
    real(dp) :: error = 0                  !! of the position that a step may make, by its estimate [m]; 0: any
    real(dp) :: energy = 0                 !! change of the total energy that a step may make [J]; 0: any
    integer :: most_halvings = 20          !! of a step
  end type cutting_type

  !> A watcher is told of every step, and counts.
  type, abstract :: step_watcher
    integer(int64) :: cuts = 0             !! number of steps that were cut
    integer(int64) :: missed = 0           !! steps that miss a tolerance after all halvings
    integer(int64) :: evaluations = 0      !! evaluations of the contacts
    integer :: parts = 0                   !! steps that replace the step in hand
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
    type(elastic_wheelset), intent(in) :: w
    type(integrator_type), intent(in) :: integrator
    type(cutting_type), intent(in) :: cutting
    type(motion_type), intent(inout) :: motion
    real(dp), intent(in) :: dt             !! [s]
    integer, intent(in) :: halvings        !! number of halvings that have led to this step
    class(step_watcher), intent(inout) :: watcher
    integer, intent(out) :: status         !! of `integrators`
    type(error_type), allocatable, intent(out) :: error   !! of the watcher, or of a step that needs too many parts
    type(motion_type) :: old, new
    integer :: evaluations, more, i
    real(dp) :: excess

    if (halvings == 0) watcher%parts = 0
    call advance(w, integrator, motion, dt, new, evaluations, status)
    watcher%evaluations = watcher%evaluations + evaluations
    more = 0
    if (status /= step_ok) then
      if (halvings == cutting%most_halvings) return
      more = 1
    else
      excess = excess_of(w, cutting, motion, new)
      if (excess > 1) then
        ! Error and change of the energy go with dt^(order + 1).
        more = (exponent(excess) + integrator%order)/(integrator%order + 1)
        more = min(max(1, more), cutting%most_halvings - halvings)
        if (more == 0) watcher%missed = watcher%missed + 1
      end if
    end if
    if (more == 0) then
      watcher%parts = watcher%parts + 1
      if (watcher%parts > most_parts) then
        call refuse_parts(cutting, motion%t, new%error > cutting%error .and. cutting%error > 0, error)
        return
      end if
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

  !> Say that a step needs too many parts, and by which tolerance.
  subroutine refuse_parts(cutting, t, by_error, error)
    type(cutting_type), intent(in) :: cutting
    real(dp), intent(in) :: t              !! [s]
    logical, intent(in) :: by_error        !! the estimated error is over its tolerance; else the change of the energy is
    type(error_type), allocatable, intent(out) :: error
    character(:), allocatable :: tolerance

    tolerance = str(cutting%energy)//' J'
    if (by_error) tolerance = str(cutting%error)//' m'
    call refuse(error, 'steps that keep to their tolerances in at most '//str(most_parts)//' parts', &
      'one at t = '//str(t)//' s that needs more', group='integrator', &
      variable=trim(merge('error_tolerance ', 'energy_tolerance', by_error)), detail=' = '//tolerance, &
      rest='; give a larger tolerance, or fewer max_halvings')
  end subroutine refuse_parts

  !> The error of a step over its tolerance or, where the error is inside, the change of the total energy: that of a step with a
  !> large error does not tell how short steps must be.
  pure real(dp) function excess_of(w, cutting, old, new) result(excess)
    type(elastic_wheelset), intent(in) :: w
    type(cutting_type), intent(in) :: cutting
    type(motion_type), intent(in) :: old, new
    real(dp) :: change

    excess = 0
    if (cutting%error > 0) excess = new%error/cutting%error
    if (cutting%energy > 0 .and. excess <= 1) then
      change = abs(energy_change(w, old, new))
      if (change > cutting%energy) &
        excess = max(excess, change/max(cutting%energy, energy_rounding(w, old), energy_rounding(w, new)))
    end if
  end function excess_of

  !> The motion at a time t near the end `old` of a step, in as many equal steps as the tolerances need.
  subroutine short_step(w, integrator, cutting, old, t, there, found, evaluations)
    type(elastic_wheelset), intent(in) :: w
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
      if (excess_of(w, cutting, old, there) <= 1) exit
    end do
    found = status == step_ok
  end subroutine short_step

end module cut_steps
