!> What happens in a run, and when: flange contacts, wheels that lift off and land,
!> passages of the centre, derailment.  Times are those of the end of the step in
!> which it happens; the passage of the centre is interpolated.
module events
  use kinds, only: dp
  use wheelset, only: contact_state, left_flange, left_tread, right_flange, right_tread
  implicit none
  private
  public :: event_log, event_type, watch, event_kinds, derailed, &
    left_flange_contact, right_flange_contact, left_lift_off, left_landing, right_lift_off, &
    right_landing, centre_passage, derailment

  enum, bind(c)
    enumerator :: left_flange_contact = 1, right_flange_contact, left_lift_off, left_landing, &
      right_lift_off, right_landing, centre_passage, derailment
  end enum
  character(20), parameter :: event_kinds(8) = [character(20) :: 'left flange contact', &
    'right flange contact', 'left wheel lift-off', 'left wheel landing', 'right wheel lift-off', &
    'right wheel landing', 'centre passage', 'derailment']

  integer, parameter :: kept = 5   !! events of a kind that are recorded; later ones are counted
  real(dp), parameter :: aside = 1e-6_dp   !! from the centre, before a passage counts [m]

  type :: event_type
    integer :: kind = 0
    real(dp) :: t = 0              !! [s]
    real(dp) :: force = 0          !! lateral force then [N]
  end type event_type

  type :: event_log
    integer :: n = 0
    type(event_type) :: list(kept*size(event_kinds))
    integer :: counts(size(event_kinds)) = 0
    logical :: away = .false.         !! from the centre since the last passage
    logical :: returned = .false.     !! to the centre after both flanges had been hit
    logical :: derailed = .false.
  end type event_log

contains

  !> Compare the two ends of a step.
  subroutine watch(log, t, dt, y_old, y, old, new, lateral_force, off_the_rail)
    type(event_log), intent(inout) :: log
    real(dp), intent(in) :: t, dt          !! end of the step, its length [s]
    real(dp), intent(in) :: y_old, y       !! lateral position at its ends [m]
    type(contact_state), intent(in) :: old, new
    real(dp), intent(in) :: lateral_force  !! [N]
    logical, intent(in) :: off_the_rail
    logical :: before(4), now(4)
    logical :: both_hit

    before = old%energy > 0
    now = new%energy > 0
    if (any(before .neqv. now)) then
      if (now(left_flange) .and. .not. before(left_flange)) call note(left_flange_contact, t)
      if (now(right_flange) .and. .not. before(right_flange)) call note(right_flange_contact, t)
      call wheel(left_tread, left_flange, left_lift_off, left_landing)
      call wheel(right_tread, right_flange, right_lift_off, right_landing)
    end if
    log%away = log%away .or. abs(y_old) > aside
    if (log%away .and. y_old*y <= 0) then
      log%away = .false.
      both_hit = log%counts(left_flange_contact) > 0 .and. log%counts(right_flange_contact) > 0
      if (both_hit) log%returned = .true.
      call note(centre_passage, t - dt*y/(y - y_old))
    end if
    if (off_the_rail .and. .not. log%derailed) then
      log%derailed = .true.
      call note(derailment, t)
    end if

  contains

    subroutine wheel(tread, flange, lift_off, landing)
      integer, intent(in) :: tread, flange, lift_off, landing

      if (before(tread) .or. before(flange)) then
        if (.not. (now(tread) .or. now(flange))) call note(lift_off, t)
      else
        if (now(tread) .or. now(flange)) call note(landing, t)
      end if
    end subroutine wheel

    subroutine note(kind, time)
      integer, intent(in) :: kind
      real(dp), intent(in) :: time

      log%counts(kind) = log%counts(kind) + 1
      if (log%counts(kind) > kept) return
      log%n = log%n + 1
      log%list(log%n) = event_type(kind, time, lateral_force)
    end subroutine note

  end subroutine watch

  !> A flange's tip is past the gauge face and above the rail head, or rolls over it.
  pure logical function derailed(q, flange_tip, gauge_face)
    real(dp), intent(in) :: q(3)            !! axle centre y, z [m], roll [rad]
    real(dp), intent(in) :: flange_tip(2)   !! of the left wheel, wheelset frame [m]
    real(dp), intent(in) :: gauge_face      !! Y of the left rail's gauge face [m]
    real(dp), parameter :: sunk = 3e-3_dp   ! the crown's fall to its shoulders and elastic depth [m]
    real(dp) :: rise(2), reach(2)

    rise = q(2) + [1, -1]*flange_tip(1)*sin(q(3)) + flange_tip(2)*cos(q(3))
    reach = [1, -1]*(q(1) - flange_tip(2)*sin(q(3))) + flange_tip(1)*cos(q(3))
    derailed = any(rise > -sunk .and. reach > gauge_face)
  end function derailed

end module events
