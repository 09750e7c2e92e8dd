!> Events of a run and their times: flange contacts, lift-off and landing of wheels, passages of the centre, flanges
!> over the rail and derailment. Rigid contacts also have impacts and rails that pull.
!>
!> Derailed means that there is no way back: the tip of a flange is outside the highest point of its rail, the
!> wheelset moves outwards, and the lateral force does not draw it inwards. From there the crown pushes the flange
!> outwards, and the tread of the other wheel rolls down its cone (tried by section `derailment` of `make validate`).
!> A flange whose tip is over the gauge corner, in flight or on the rail's head, has not derailed: it may come down
!> inside. This is a separate event, after which the run goes on.
!>
!> A flange met its rail when a contact closes whose contact angle is at least the threshold of the case, or when the
!> angle of a closed contact passes the threshold: then the contact of the flange closes in the state of the contacts.
!>
!> Times of events lie within the steps. The time at which an elastic contact closes or opens follows from the contact's
!> energy, which is proportional to p^(5/2) of the penetration p, and from the rate of that energy. All other times are
!> interpolated linearly. With rigid contacts a step ends where a contact opens or closes.
module events
  use contact_zones, only: side_type
  use kinds, only: dp
  use motion_state, only: motion_type
  use wheelset, only: closed, external_force, flanges, outwards, treads, wheelset_type
  implicit none
  private
  public :: event_log, event_type, watch, event_kinds, elastic_kinds, impact, kept, never

  character(24), parameter :: event_kinds(12) = [character(24) :: 'left flange contact', &
    'right flange contact', 'left wheel lift-off', 'left wheel landing', 'right wheel lift-off', &
    'right wheel landing', 'centre passage', 'left flange over rail', 'right flange over rail', 'derailment', 'impact', &
    'rail pulls']
  ! Positions in `event_kinds`; two numbers are of the left and of the right side.
  integer, parameter :: flange_contact(2) = [1, 2], lift_off(2) = [3, 5], landing(2) = [4, 6], centre_passage = 7, &
    over_rail(2) = [8, 9], derailment = 10, impact = 11, rail_pulls = 12
  integer, parameter :: elastic_kinds = 10  !! number of kinds that elastic contacts have: the first ones

  integer, parameter :: kept = 5            !! events of a kind that are recorded; later ones are counted
  integer, parameter :: kept_impacts = 100  !! impacts that are recorded
  integer, parameter :: most_moments = 12   ! in a step: one event of a kind, four changes of contacts
  real(dp), parameter :: aside = 1e-6_dp    !! from the centre, before a passage counts [m]

  real(dp), parameter :: never = huge(1.0_dp)

  type :: event_type
    integer :: kind = 0
    real(dp) :: t = never          !! [s]
    real(dp) :: force = 0          !! lateral force at the time of the event [N]
    real(dp) :: angle = 0          !! contact angle of a flange contact; 0 if not known [rad]
    real(dp) :: impulse(4) = 0     !! impulse of an impact, by contact [N s]
    real(dp) :: loss = 0           !! energy lost in an impact [J]
  end type event_type

  !> Times are `never` for what has not happened.
  type :: event_log
    integer :: n = 0
    type(event_type) :: list(kept*size(event_kinds) + kept_impacts)
    integer :: counts(size(event_kinds)) = 0
    logical :: away = .false.         !! the wheelset has left the centre since the last passage
    real(dp) :: touched(4) = never    !! first touch of each contact [s]
    real(dp) :: opened(4) = never     !! first opening of each contact [s]
    real(dp) :: passed = never        !! first passage of the centre after a flange has touched [s]
    real(dp) :: returned = never      !! first passage of the centre after both flanges have touched [s]
    real(dp) :: lifted(2) = never     !! last lift-off of the left and of the right wheel [s]
    type(event_type) :: derailed      !! the derailment
    type(event_type) :: unloaded      !! the last lift-off of the wheel that is off its rail at the derailment
    integer :: n_moments = 0
    real(dp) :: moments(most_moments) = 0   !! times of events and of changes of contacts in the last step [s]
  end type event_log

contains

  !> Compare the two ends of a step.
  subroutine watch(log, w, old, new, side)
    type(event_log), intent(inout) :: log
    type(wheelset_type), intent(in) :: w
    type(motion_type), intent(in) :: old, new
    type(side_type), intent(in) :: side(:)  !! left, right
    real(dp) :: dt
    logical :: was_closed(4), is_closed(4), met(4), wheel_was_on, wheel_met
    integer :: k

    log%n_moments = 0
    dt = new%t - old%t
    was_closed = closed(old%contact)
    is_closed = closed(new%contact)
    met = is_closed .or. new%contact%struck      ! contacts that have a force at the end of the step, or an impulse
    do k = 1, 2
      if (met(flanges(k)) .and. .not. was_closed(flanges(k))) &
        call record(log, w, event_type(flange_contact(k), closing(flanges(k)), angle=contact_angle(new, k)))
    end do
    if (any(was_closed .neqv. is_closed) .or. any(new%contact%struck)) then
      do k = 1, 2
        wheel_was_on = was_closed(treads(k)) .or. was_closed(flanges(k))
        wheel_met = met(treads(k)) .or. met(flanges(k))
        if (wheel_met .and. .not. wheel_was_on) &
          call record(log, w, event_type(landing(k), min(closing(treads(k)), closing(flanges(k)))))
        if ((wheel_met .or. wheel_was_on) .and. .not. (is_closed(treads(k)) .or. is_closed(flanges(k)))) &
          call note_lift_off(log, w, k, max(opening(treads(k)), opening(flanges(k))))
      end do
      do k = 1, 4
        if (is_closed(k) .and. .not. was_closed(k)) call add_moment(log, closing(k))
        if (was_closed(k) .and. .not. is_closed(k)) call add_moment(log, opening(k))
        if (met(k) .and. .not. was_closed(k)) log%touched(k) = min(log%touched(k), closing(k))
        if ((met(k) .or. was_closed(k)) .and. .not. is_closed(k)) log%opened(k) = min(log%opened(k), opening(k))
      end do
    end if
    log%away = log%away .or. abs(old%q(1)) > aside
    if (log%away .and. old%q(1)*new%q(1) <= 0) then
      log%away = .false.
      call note_passage(log, w, zero_between(old%q(1), new%q(1)))
    end if
    if (any(new%contact%pulls .and. .not. old%contact%pulls)) &
      call record(log, w, event_type(rail_pulls, new%t - dt*share_of_pull(old, new)))
    call watch_flange_tips()
    if (any(new%contact%struck)) &
      call record(log, w, event_type(impact, new%t, impulse=new%impulse - old%impulse, loss=new%loss - old%loss))

  contains

    !> Flanges over the rail: outside the gauge line and higher than the head's shoulders. Derailment: outside the crown.
    subroutine watch_flange_tips()
      real(dp), parameter :: shoulder = 3e-3_dp   ! the crown's fall to its shoulders, and elastic depth [m]
      real(dp) :: tip(2, 2), tip_before(2, 2), over(2), over_before(2), past(2), past_before(2)
      integer :: other                            ! side

      tip = flange_tips(new%q, side)
      over = min(tip(2, :) + shoulder, tip(1, :) - side%pair%gauge_face)
      if (all(over <= 0)) return
      tip_before = flange_tips(old%q, side)
      over_before = min(tip_before(2, :) + shoulder, tip_before(1, :) - side%pair%gauge_face)
      do k = 1, 2
        if (over(k) > 0 .and. over_before(k) <= 0) &
          call record(log, w, event_type(over_rail(k), zero_between(over_before(k), over(k))))
      end do
      if (log%derailed%t < never) return
      past = tip(1, :) - side%pair%crown
      past_before = min(tip_before(1, :) - side%pair%crown, 0.0_dp)
      do k = 1, 2
        if (past(k) <= 0 .or. outwards(k)*new%v(1) <= 0 .or. outwards(k)*lateral_force(w, new%t) < 0) cycle
        log%derailed = event_type(derailment, zero_between(past_before(k), past(k)))
        log%derailed%force = lateral_force(w, log%derailed%t)
        call record(log, w, log%derailed)
        other = merge(2, 1, k == 1)
        if (any(is_closed([treads(other), flanges(other)]))) cycle
        log%unloaded = event_type(lift_off(other), log%lifted(other))
        log%unloaded%force = lateral_force(w, log%unloaded%t)
      end do
    end subroutine watch_flange_tips

    !> Time at which a quantity that changes linearly in the step is zero.
    real(dp) function zero_between(before, after) result(t)
      real(dp), intent(in) :: before, after

      t = new%t - dt*after/(after - before)
    end function zero_between

    !> Time at which a contact closed that is closed at the end of the step.
    real(dp) function closing(contact) result(t)
      integer, intent(in) :: contact

      t = new%t
      if (is_closed(contact) .and. .not. new%contact%rigid(contact)) t = t - min(dt, lapse(new, contact))
    end function closing

    !> Time at which a contact opened that was closed at the start of the step.
    real(dp) function opening(contact) result(t)
      integer, intent(in) :: contact

      t = old%t
      if (old%contact%rigid(contact) .or. new%contact%struck(contact)) then
        t = new%t
      else if (was_closed(contact)) then
        t = t + min(dt, lapse(old, contact))
      end if
    end function opening

    !> Time in which the penetration changes by its own size [s].
    real(dp) function lapse(motion, contact)
      type(motion_type), intent(in) :: motion
      integer, intent(in) :: contact
      real(dp) :: rate

      rate = abs(dot_product(motion%contact%slope(:, contact), motion%v))
      lapse = 2.5_dp*motion%contact%energy(contact)/max(rate, motion%contact%energy(contact)/dt)
    end function lapse

  end subroutine watch

  subroutine note_lift_off(log, w, k, t)
    type(event_log), intent(inout) :: log
    type(wheelset_type), intent(in) :: w
    integer, intent(in) :: k               !! 1 left, 2 right
    real(dp), intent(in) :: t              !! [s]

    log%lifted(k) = t
    call record(log, w, event_type(lift_off(k), t))
  end subroutine note_lift_off

  !> The wheelset passes the centre.
  subroutine note_passage(log, w, t)
    type(event_log), intent(inout) :: log
    type(wheelset_type), intent(in) :: w
    real(dp), intent(in) :: t              !! [s]

    if (any(log%counts(flange_contact) > 0)) log%passed = min(log%passed, t)
    if (all(log%counts(flange_contact) > 0)) log%returned = min(log%returned, t)
    call record(log, w, event_type(centre_passage, t))
  end subroutine note_passage

  !> Contact angle of the flange on side k [rad]; 0 if the contact has no force.
  pure real(dp) function contact_angle(motion, k) result(angle)
    type(motion_type), intent(in) :: motion
    integer, intent(in) :: k

    angle = 0
    associate (slope => motion%contact%slope(:, flanges(k)))
      ! A rail that pulls has a force against the normal.
      if (norm2(slope(:2)) > 0) angle = max(0.0_dp, merge(atan2(-outwards(k)*slope(1), slope(2)), &
        atan2(outwards(k)*slope(1), -slope(2)), motion%contact%pulls(flanges(k))))
    end associate
  end function contact_angle

  !> The part of the step after a force has changed its sign.
  pure real(dp) function share_of_pull(old, new) result(share)
    type(motion_type), intent(in) :: old, new
    real(dp) :: before, after
    integer :: k

    share = 0
    if (any(new%contact%struck)) return
    do k = 1, 4
      if (.not. new%contact%pulls(k) .or. old%contact%pulls(k) .or. .not. old%contact%rigid(k)) cycle
      before = norm2(old%contact%slope(:2, k))
      after = norm2(new%contact%slope(:2, k))
      share = max(share, after/(before + after))
    end do
  end function share_of_pull

  !> Count an event, and keep it with the lateral force if it is among the first of its kind.
  subroutine record(log, w, event)
    type(event_log), intent(inout) :: log
    type(wheelset_type), intent(in) :: w
    type(event_type), intent(in) :: event

    call add_moment(log, event%t)
    log%counts(event%kind) = log%counts(event%kind) + 1
    if (log%counts(event%kind) > merge(kept_impacts, kept, event%kind == impact)) return
    log%n = log%n + 1
    log%list(log%n) = event
    log%list(log%n)%force = lateral_force(w, event%t)
  end subroutine record

  !> The external lateral force at a time t [s], [N].
  pure real(dp) function lateral_force(w, t)
    type(wheelset_type), intent(in) :: w
    real(dp), intent(in) :: t
    real(dp) :: force(3)

    force = external_force(w, t)
    lateral_force = force(1)
  end function lateral_force

  subroutine add_moment(log, time)
    type(event_log), intent(inout) :: log
    real(dp), intent(in) :: time            !! [s]

    if (log%n_moments == most_moments) return
    log%n_moments = log%n_moments + 1
    log%moments(log%n_moments) = time
  end subroutine add_moment

  !> Positions of the flanges' tips: outwards from the track's centre and upwards from top of rail [m], by side.
  pure function flange_tips(q, side) result(tip)
    real(dp), intent(in) :: q(3)
    type(side_type), intent(in) :: side(2)
    real(dp) :: tip(2, 2), r(2)
    integer :: k

    do k = 1, 2
      r = side(k)%pair%flange_tip
      tip(1, k) = outwards(k)*(q(1) - r(2)*sin(q(3))) + r(1)*cos(q(3))
      tip(2, k) = q(2) + outwards(k)*r(1)*sin(q(3)) + r(2)*cos(q(3))
    end do
  end function flange_tips

end module events