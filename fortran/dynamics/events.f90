!> Events of a run and their times: flange contacts, lift-off and landing of wheels, passages of the centre, flanges
!> over the rail and derailment. Rigid contacts also have impacts and rails that pull.
!>
!> Derailed means that there is no way back: the tip of a flange is outside the highest point of its rail, the
!> wheelset moves outwards, and the lateral force does not draw it inwards. From there the crown pushes the flange
!> outwards, and the tread of the other wheel rolls down its cone (tried by section `derailment` of `make validate`).
!> A flange whose tip is over the gauge corner, in flight or on the rail's head, has not derailed: it may come down
!> inside. This is a separate event, after which the run goes on. A wheelset may also overturn about a rail with its flange
!> beside it, and leave what the contact table covers before its flange is over the rail: then it has derailed there.
!>
!> A flange met its rail when a contact closes on it, or when a patch of the tread moves over the border onto it; the event says
!> which. The wheelset has turned back on a side when its lateral velocity changes from outwards to inwards there.
!>
!> Times of events lie within the steps. Between the ends of a step of elastic contacts the pose is that quintic in time whose
!> values, velocities and accelerations are those of both ends, which is as exact as the steps are. Contacts are evaluated there
!> until the time of a change is known to 0.02 ns. With rigid contacts a step ends where a contact opens or closes, and other
!> times are interpolated linearly.
module events
  use contact_zones, only: side_type
  use kinds, only: dp
  use motion_state, only: closed, contact_state, motion_type
  use root_bracket, only: bracket_type
  use step_times, only: find_change, pose_between
  use elastic_contacts, only: elastic_wheelset
  use wheelset, only: external_force, flanges, outwards, right_tread, treads
  implicit none
  private
  public :: event_log, event_type, row_time_type, watch, note_overturning, event_kinds, elastic_kinds, causes, impact, kept, never

  character(24), parameter :: event_kinds(12) = [character(24) :: 'left flange contact', &
    'right flange contact', 'left wheel lift-off', 'left wheel landing', 'right wheel lift-off', &
    'right wheel landing', 'centre passage', 'left flange over rail', 'right flange over rail', 'derailment', 'impact', &
    'rail pulls']
  ! Positions in `event_kinds`; two numbers are of the left and of the right side.
  integer, parameter :: flange_contact(2) = [1, 2], lift_off(2) = [3, 5], landing(2) = [4, 6], centre_passage = 7, &
    over_rail(2) = [8, 9], derailment = 10, impact = 11, rail_pulls = 12
  integer, parameter :: elastic_kinds = 10  !! number of kinds that elastic contacts have: the first ones

  !> Why a flange meets its rail: a contact closes, or a patch of the tread moves onto the flange.
  character(6), parameter :: causes(2) = [character(6) :: 'closes', 'moves']
  integer, parameter :: closes = 1, moves = 2

  integer, parameter :: kept = 5            !! events of a kind that are recorded; later ones are counted
  integer, parameter :: kept_impacts = 100  !! impacts that are recorded
  integer, parameter :: most_moments = 12   ! in a step: one event of a kind, four changes of contacts
  real(dp), parameter :: aside = 1e-6_dp    !! from the centre, before a passage counts [m]

  integer, parameter :: centre = 1, gauge = 2, crown = 3    ! measures of the pose

  real(dp), parameter :: never = huge(1.0_dp)

  type :: event_type
    integer :: kind = 0
    real(dp) :: t = never          !! [s]
    real(dp) :: force = 0          !! lateral force at the time of the event [N]
    real(dp) :: angle = 0          !! contact angle of a flange contact; 0 if not known [rad]
    integer :: cause = 0           !! of a flange contact, in `causes`; 0 of other events
    real(dp) :: impulse(4) = 0     !! impulse of an impact, by contact [N s]
    real(dp) :: loss = 0           !! energy lost in an impact [J]
  end type event_type

  !> A time of a step that has a row.
  type :: row_time_type
    real(dp) :: t = 0              !! [s]
    integer :: contact = 0         !! the contact that changes then; 0 without one
    logical :: closed = .false.    !! whether it is closed from then on
  end type row_time_type

  !> Times are `never` for what has not happened.
  type :: event_log
    integer :: n = 0
    type(event_type) :: list(kept*size(event_kinds) + kept_impacts)
    integer :: counts(size(event_kinds)) = 0
    logical :: away = .false.         !! the wheelset has left the centre since the last passage
    real(dp) :: touched(4) = never    !! first touch of each contact [s]
    real(dp) :: opened(4) = never     !! first opening of each contact [s]
    real(dp) :: passed = never        !! first passage of the centre after a flange has touched [s]
    logical :: turned(2) = .false.    !! the wheelset has turned back on the left and on the right side
    logical :: flanged(2) = .false.   !! the flange had touched when the wheelset last turned back on that side
    real(dp) :: returned = never      !! first passage of the centre after it has turned back on both sides [s]
    real(dp) :: lifted(2) = never     !! last lift-off of the left and of the right wheel [s]
    type(event_type) :: derailed      !! the derailment
    type(event_type) :: unloaded      !! the last lift-off of the wheel that is off its rail at the derailment
    integer :: n_moments = 0
    type(row_time_type) :: moments(most_moments)   !! times of events and of changes of contacts in the last step
  end type event_log

contains

  !> Compare the two ends of a step.
  subroutine watch(log, w, old, new, side)
    type(event_log), intent(inout) :: log
    type(elastic_wheelset), intent(in) :: w
    type(motion_type), intent(in) :: old, new
    type(side_type), intent(in) :: side(:)  !! left, right
    real(dp), parameter :: apart = 2e-9_dp  ! times closer than this are one [s]
    real(dp) :: dt
    real(dp) :: time(4)                     ! at which contacts changed [s]
    type(contact_state) :: state(2)         ! of each wheel when its flange's contact closed
    logical :: was_closed(4), is_closed(4), met(4), wheel_was_on, wheel_met, elastic, over_border
    integer :: k, pair(2)

    log%n_moments = 0
    dt = new%t - old%t
    elastic = associated(w%table)
    was_closed = closed(old%contact)
    is_closed = closed(new%contact)
    met = is_closed .or. new%contact%struck      ! contacts that have a force at the end of the step, or an impulse
    state = new%contact
    if (any(was_closed .neqv. is_closed) .or. any(new%contact%struck)) then
      call date_changes()
      do k = 1, 2
        if (.not. met(flanges(k)) .or. was_closed(flanges(k))) cycle
        ! A patch that moves is on the tread, too, when it comes onto the flange.
        over_border = merge(state(k)%shared(k), .not. any(new%contact%struck), elastic) .and. (was_closed(treads(k)) .or. &
          (is_closed(treads(k)) .and. time(treads(k)) < time(flanges(k)) - apart))
        call record(log, w, event_type(flange_contact(k), time(flanges(k)), angle=contact_angle(state(k), k), &
          cause=merge(moves, closes, over_border)))
      end do
      do k = 1, 2
        pair = [treads(k), flanges(k)]
        wheel_was_on = any(was_closed(pair))
        wheel_met = any(met(pair))
        if (wheel_met .and. .not. wheel_was_on) &
          call record(log, w, event_type(landing(k), minval(time(pair), met(pair))))
        if ((wheel_met .or. wheel_was_on) .and. .not. any(is_closed(pair))) &
          call note_lift_off(log, w, k, maxval(time(pair), met(pair) .or. was_closed(pair)))
      end do
      do k = 1, 4
        if (met(k) .or. was_closed(k)) then
          if (.not. (is_closed(k) .and. was_closed(k))) call add_moment(log, row_time_type(time(k), k, is_closed(k)))
        end if
        if (met(k) .and. .not. was_closed(k)) log%touched(k) = min(log%touched(k), time(k))
        if ((met(k) .or. was_closed(k)) .and. .not. is_closed(k)) log%opened(k) = min(log%opened(k), time(k))
      end do
    end if
    do k = 1, 2
      if (outwards(k)*old%v(1) <= 0 .or. outwards(k)*new%v(1) > 0 .or. outwards(k)*new%q(1) <= 0) cycle
      log%turned(k) = .true.
      log%flanged(k) = log%flanged(k) .or. log%counts(flange_contact(k)) > 0
    end do
    log%away = log%away .or. abs(old%q(1)) > aside
    if (log%away .and. old%q(1)*new%q(1) <= 0) then
      log%away = .false.
      call note_passage(log, w, when(centre, 1))
    end if
    if (any(new%contact%pulls .and. .not. old%contact%pulls)) &
      call record_with_row(log, w, event_type(rail_pulls, new%t - dt*share_of_pull(old, new)))
    call watch_flange_tips()
    if (any(new%contact%struck)) &
      call record_with_row(log, w, event_type(impact, new%t, impulse=new%impulse - old%impulse, loss=new%loss - old%loss))

  contains
    !> Flanges over the rail: outside the gauge line and higher than the head's shoulders. Derailment: outside the crown.
    subroutine watch_flange_tips()
      do k = 1, 2
        if (measure(gauge, k, new%q, side) > 0 .and. measure(gauge, k, old%q, side) <= 0) &
          call record_with_row(log, w, event_type(over_rail(k), when(gauge, k)))
      end do
      if (log%derailed%t < never) return
      do k = 1, 2
        if (measure(crown, k, new%q, side) <= 0 .or. outwards(k)*new%v(1) <= 0 .or. outwards(k)*lateral_force(w, new%t) < 0) cycle
        call note_derailment(log, w, k, when(crown, k), is_closed)
      end do
    end subroutine watch_flange_tips

    !> Date the changes of contacts. Those of rigid contacts are at the end of the step.
    subroutine date_changes()
      type(contact_state) :: just_closed
      integer :: contact

      time = new%t
      if (.not. elastic) return
      do contact = 1, 4
        if (is_closed(contact) .eqv. was_closed(contact)) cycle
        call find_change(w, old, new, contact, time(contact), just_closed)
        if (is_closed(contact) .and. any(flanges == contact)) state(merge(1, 2, contact < right_tread)) = just_closed
      end do
    end subroutine date_changes

    !> Time in the step at which a measure of the pose is zero that has different signs at its ends.
    real(dp) function when(what, k) result(t)
      integer, intent(in) :: what            !! centre, gauge or crown
      integer, intent(in) :: k               !! side
      real(dp), parameter :: close = 1e-12_dp   ! share of the step
      type(bracket_type) :: range
      real(dp) :: u, x
      integer :: iter

      range = bracket_type(0.0_dp, measure(what, k, old%q, side), 1.0_dp, measure(what, k, new%q, side))
      u = range%guess()
      if (range%fa*range%fb > 0) u = 0
      if (elastic .and. range%fa*range%fb < 0) then
        do iter = 1, 60
          u = range%guess()
          x = measure(what, k, pose_between(old, new, u), side)
          if (abs(x) <= 0 .or. abs(range%b - range%a) <= close) exit
          call range%narrow(u, x)
        end do
      end if
      t = old%t + u*dt
    end function when

  end subroutine watch

  !> Record the derailment of a wheelset that overturns, at the end of what the table covers. It overturns over one rail if the
  !> other wheel is off its rail with its flange's tip above the rail, the resultant of weight and lateral force passes outside
  !> the rail, and the wheelset moves and rolls outwards.
  subroutine note_overturning(log, w, motion, side)
    type(event_log), intent(inout) :: log
    type(elastic_wheelset), intent(in) :: w
    type(motion_type), intent(in) :: motion
    type(side_type), intent(in) :: side(2)
    real(dp) :: tip(2, 2), force(3)
    logical :: is_closed(4)
    integer :: k, other

    if (log%derailed%t < never) return
    tip = flange_tips(motion%q, side)
    force = external_force(w, motion%t)
    is_closed = closed(motion%contact)
    do k = 1, 2
      other = 3 - k
      if (any(is_closed([treads(other), flanges(other)])) .or. tip(2, other) <= 0) cycle
      if (min(outwards(k)*motion%v(1), -outwards(k)*motion%v(3)) <= 0) cycle
      if (outwards(k)*(motion%q(1) - motion%q(2)*force(1)/force(2)) <= side(k)%pair%gauge_face) cycle
      call note_derailment(log, w, k, motion%t, is_closed)
      return
    end do
  end subroutine note_overturning

  !> The wheelset derails over the rail of side k.
  subroutine note_derailment(log, w, k, t, is_closed)
    type(event_log), intent(inout) :: log
    type(elastic_wheelset), intent(in) :: w
    integer, intent(in) :: k                !! 1 left, 2 right
    real(dp), intent(in) :: t               !! [s]
    logical, intent(in) :: is_closed(4)     !! contacts at the end of the step
    integer :: other

    log%derailed = event_type(derailment, t)
    log%derailed%force = lateral_force(w, t)
    call record_with_row(log, w, log%derailed)
    other = 3 - k
    if (any(is_closed([treads(other), flanges(other)]))) return
    log%unloaded = event_type(lift_off(other), log%lifted(other))
    log%unloaded%force = lateral_force(w, log%unloaded%t)
  end subroutine note_derailment

  subroutine note_lift_off(log, w, k, t)
    type(event_log), intent(inout) :: log
    type(elastic_wheelset), intent(in) :: w
    integer, intent(in) :: k               !! 1 left, 2 right
    real(dp), intent(in) :: t              !! [s]

    log%lifted(k) = t
    call record(log, w, event_type(lift_off(k), t))
  end subroutine note_lift_off

  !> The wheelset passes the centre.
  subroutine note_passage(log, w, t)
    type(event_log), intent(inout) :: log
    type(elastic_wheelset), intent(in) :: w
    real(dp), intent(in) :: t              !! [s]

    if (any(log%counts(flange_contact) > 0)) log%passed = min(log%passed, t)
    if (all(log%turned)) log%returned = min(log%returned, t)
    call record_with_row(log, w, event_type(centre_passage, t))
  end subroutine note_passage

  !> Contact angle of the flange on side k [rad]; 0 if the contact has no force.
  pure real(dp) function contact_angle(state, k) result(angle)
    type(contact_state), intent(in) :: state
    integer, intent(in) :: k

    angle = 0
    associate (slope => state%slope(:, flanges(k)))
      ! A rail that pulls has a force against the normal.
      if (norm2(slope(:2)) > 0) angle = max(0.0_dp, merge(atan2(-outwards(k)*slope(1), slope(2)), &
        atan2(outwards(k)*slope(1), -slope(2)), state%pulls(flanges(k))))
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

  !> Record an event that has a row without a change of a contact.
  subroutine record_with_row(log, w, event)
    type(event_log), intent(inout) :: log
    type(elastic_wheelset), intent(in) :: w
    type(event_type), intent(in) :: event

    call add_moment(log, row_time_type(event%t))
    call record(log, w, event)
  end subroutine record_with_row

  !> Count an event, and keep it with the lateral force if it is among the first of its kind.
  subroutine record(log, w, event)
    type(event_log), intent(inout) :: log
    type(elastic_wheelset), intent(in) :: w
    type(event_type), intent(in) :: event

    log%counts(event%kind) = log%counts(event%kind) + 1
    if (log%counts(event%kind) > merge(kept_impacts, kept, event%kind == impact)) return
    log%n = log%n + 1
    log%list(log%n) = event
    log%list(log%n)%force = lateral_force(w, event%t)
  end subroutine record

  !> The external lateral force at a time t [s], [N].
  pure real(dp) function lateral_force(w, t)
    type(elastic_wheelset), intent(in) :: w
    real(dp), intent(in) :: t
    real(dp) :: force(3)

    force = external_force(w, t)
    lateral_force = force(1)
  end function lateral_force

  subroutine add_moment(log, moment)
    type(event_log), intent(inout) :: log
    type(row_time_type), intent(in) :: moment

    if (log%n_moments == most_moments) return
    log%n_moments = log%n_moments + 1
    log%moments(log%n_moments) = moment
  end subroutine add_moment

  !> How far the wheelset is to the left of the centre, the flange of side k over the rail, or its tip outside the crown [m].
  pure real(dp) function measure(what, k, q, side)
    integer, intent(in) :: what             !! centre, gauge or crown
    integer, intent(in) :: k                !! 1 left, 2 right
    real(dp), intent(in) :: q(3)
    type(side_type), intent(in) :: side(2)
    real(dp), parameter :: shoulder = 3e-3_dp   ! the crown's fall to its shoulders, and elastic depth [m]
    real(dp) :: tip(2, 2)

    measure = q(1)
    if (what == centre) return
    tip = flange_tips(q, side)
    measure = tip(1, k) - side(k)%pair%crown
    if (what == gauge) measure = min(tip(2, k) + shoulder, tip(1, k) - side(k)%pair%gauge_face)
  end function measure

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