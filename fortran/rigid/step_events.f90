!> Events that end a step of rigid contacts: a gap closes, or a force that must not pull vanishes.
!>
!> Beside an edge of a profile the nearest point of a contact may jump, and points come up that were not known at the start of the
!> step. They are found inside the rail at its end, and followed back to where they close.
module step_events
  use smooth_motion, only: gap_rate, move, normal_forces, state_type
  use contact_zones, only: side_type
  use gap_functions, only: contacts_type, find_gap, gap_type
  use impacts, only: still
  use kinds, only: dp
  use rival_points, only: search_rivals
  use root_bracket, only: bracket_type
  use wheelset, only: wheelset_type
  implicit none
  private
  public :: find_event, find_newcomers, may_open

  real(dp), parameter :: pierced = 1e-14_dp    ! depth of a gap that has closed within a step [m]
  real(dp), parameter :: slight = 1e-8_dp      ! pull that is more than rounding, of the weight

contains

  !> Cut the step to its first event: contact `event` closes, or its force vanishes; 0: there is none.  The earliest
  !> event that shows is located, which shortens the step, and again the earliest event of the shortened step.
  subroutine find_event(side, w, from, dt, to, event, merged)
    type(side_type), intent(in) :: side(:)
    type(wheelset_type), intent(in) :: w
    type(state_type), intent(inout) :: from   !! start of the step
    real(dp), intent(in) :: dt             !! the longest step [s]
    type(state_type), intent(inout) :: to  !! end of the step
    integer, intent(out) :: event
    logical, intent(out) :: merged         !! a point has come together with a rival, which goes on from there
    real(dp) :: h, dip
    integer :: k, trials

    event = 0
    merged = .false.
    do trials = 1, 3*size(to%c)
      call first_broken(w, from, to, k, dip)
      if (k == 0) exit
      event = k
      if (dip < to%h) then
        h = to%h
        call move(side, w, from, dip, to)
        if (margin(w, to, k) > -1) then
          call move(side, w, from, h, to)
          event = 0
          exit
        end if
      end if
      call locate_event(side, w, from, dt, k, to, merged)
      if (to%h <= 0) exit
      if (merged) event = 0
    end do
  end subroutine find_event

  !> The contact that pierces the rail or whose force begins to pull, at the end of the step or within it: the one that does
  !> so first, as far as can be told; 0: none.
  subroutine first_broken(w, from, to, first, dip)
    type(wheelset_type), intent(in) :: w
    type(state_type), intent(in) :: from, to
    integer, intent(out) :: first
    real(dp), intent(out) :: dip           !! time at which its gap or force is least within the step, or the step's end [s]
    real(dp) :: when, least, earliest, force(size(to%c)), force_before(size(to%c)), fall, bend
    integer :: i

    first = 0
    dip = to%h
    if (to%h <= 0) return
    force = normal_forces(w, to)
    force_before = normal_forces(w, from)
    earliest = huge(earliest)
    do i = 1, size(to%c)
      when = huge(when)
      least = to%h
      if (.not. to%closed(i)) then
        if (to%c(i)%gap < -pierced) then
          when = to%h*from%c(i)%gap/(from%c(i)%gap - to%c(i)%gap)
        else if (gap_rate(from, i) < 0 .and. gap_rate(to, i) > 0) then
          if (lowest_gap(from, to, i) < -pierced) then
            least = dip_time(from, to, i)
            when = least
          end if
        end if
      else if (may_open(to, i) .or. w%weight() > 0 .and. force_before(i) > slight*w%weight()) then
        ! Pulls of a weightless wheelset, which only follows its path, do not matter.
        if (force(i) < -slight*w%weight()) then
          when = to%h*min(1.0_dp, 1/(1 - force(i)/max(force_before(i), 1.0_dp)))
        else if (to%bilateral) then
          ! The parabola through the forces at the start, half way and at the end.
          fall = 4*to%half_force(i) - 3*force_before(i) - force(i)
          bend = 4*(force_before(i) + force(i) - 2*to%half_force(i))
          if (fall < 0 .and. fall + bend > 0 .and. force_before(i) - fall**2/(2*bend) < -slight*w%weight()) then
            least = -to%h*fall/bend
            when = least
          end if
        end if
      end if
      if (when < earliest) then
        earliest = when
        first = i
        dip = least
      end if
    end do
  end subroutine first_broken

  !> Gap or force of contact k in units of the least that matters: below -1 it has pierced the rail, or the rail pulls.
  pure real(dp) function margin(w, state, k)
    type(wheelset_type), intent(in) :: w
    type(state_type), intent(in) :: state
    integer, intent(in) :: k
    real(dp) :: force(size(state%c))

    margin = state%c(k)%gap/pierced
    if (.not. state%closed(k)) return
    force = normal_forces(w, state)
    margin = force(k)/(slight*w%weight())
  end function margin

  !> Whether a closed contact opens rather than pulls: always, or bilateral beside another closed contact of the wheel.
  pure logical function may_open(state, i)
    type(state_type), intent(in) :: state
    integer, intent(in) :: i

    may_open = .not. state%bilateral .or. count(state%closed .and. state%c%wheel == state%c(i)%wheel) > 1
  end function may_open

  !> Cut the step to the instant at which contact k closes, if it is open, or at which its force vanishes.
  !>
  !> Beside an edge the nearest point may come up, apart from where it was, and close within a step.  It is then found when it is
  !> inside the rail, and followed back to where it closes.
  subroutine locate_event(side, w, from, dt, k, to, merged)
    type(side_type), intent(in) :: side(:)
    type(wheelset_type), intent(in) :: w
    type(state_type), intent(inout) :: from
    real(dp), intent(in) :: dt             !! the longest step [s]
    integer, intent(in) :: k
    type(state_type), intent(inout) :: to
    logical, intent(inout) :: merged       !! instead, the contact's point has come together with a rival
    integer, parameter :: most_trials = 4
    integer :: trial

    do trial = 1, most_trials
      call bracket_event(side, w, from, dt, k, to, merged)
      if (to%closed(k) .or. merged .or. to%h <= 0 .or. to%c(k)%gap > -to%c(k)%touching) exit
      call start_at(to%c(k), from%c(k))
    end do
  end subroutine locate_event

  !> Find the instant at which contact k closes or its force vanishes; where its gap jumps, the instant after the jump.
  subroutine bracket_event(side, w, from, dt, k, to, merged)
    type(side_type), intent(in) :: side(:)
    type(wheelset_type), intent(in) :: w
    type(state_type), intent(in) :: from
    real(dp), intent(in) :: dt             !! the longest step [s]
    integer, intent(in) :: k
    type(state_type), intent(inout) :: to
    logical, intent(inout) :: merged       !! instead, the contact's point has come together with a rival
    type(bracket_type) :: range
    real(dp) :: force(size(to%c)), h, x, f, first, last, low
    integer :: iter

    h = to%h
    low = 0
    if (to%closed(k)) then
      force = normal_forces(w, from)
      first = force(k)
      force = normal_forces(w, to)
      last = force(k)
    else
      ! The zero of gap/time is wanted: a gap that opens at the start has no zero there.
      first = gap_rate(from, k)
      if (from%c(k)%gap > from%c(k)%touching) first = max(first, from%c(k)%gap/h)
      last = to%c(k)%gap/h
      if (from%c(k)%gap <= from%c(k)%touching .and. abs(gap_rate(from, k)) <= still) then
        ! A contact that has just been released, at rest but for rounding, closes again only after it has opened.
        low = h
        do iter = 1, 50
          low = low/2
          call move(side, w, from, low, to)
          first = (to%c(k)%gap - 0.1_dp*pierced)/low
          if (first > 0) exit
        end do
      end if
    end if
    if (first <= 0) then
      ! The event is at the start.
      call move(side, w, from, 0.0_dp, to)
      return
    end if
    range = bracket_type(low, first, h, last)
    do iter = 1, 100
      x = range%guess()
      call move(side, w, from, x, to)
      merged = to%c(k)%absent
      if (merged .or. abs(range%b - range%a) <= 4*epsilon(x)*range%b) exit
      if (to%closed(k)) then
        force = normal_forces(w, to)
        f = force(k)
        if (abs(f) < 1e-9_dp*w%weight()) exit
      else
        ! If the instant is within rounding of the start, gap/time is the rate.
        f = first
        if (x > epsilon(x)*dt) f = to%c(k)%gap/x
        if (abs(to%c(k)%gap) < 1e-16_dp) exit
      end if
      call range%narrow(x, f)
    end do
    if (.not. (merged .or. to%closed(k)) .and. to%c(k)%gap > to%c(k)%touching) call move(side, w, from, range%b, to)
  end subroutine bracket_event

  !> The time from the start of a step at which the gap of contact i is least, where it falls and then grows [s].
  pure real(dp) function dip_time(from, to, i)
    type(state_type), intent(in) :: from, to
    integer, intent(in) :: i

    dip_time = to%h*gap_rate(from, i)/(gap_rate(from, i) - gap_rate(to, i))
  end function dip_time

  !> The gap of contact i at that time, on the cubic through both ends of the step [m].
  pure real(dp) function lowest_gap(from, to, i)
    type(state_type), intent(in) :: from, to
    integer, intent(in) :: i
    real(dp) :: u, a, b, da, db

    u = dip_time(from, to, i)/to%h
    a = from%c(i)%gap
    b = to%c(i)%gap
    da = to%h*gap_rate(from, i)
    db = to%h*gap_rate(to, i)
    lowest_gap = a + u*(da + u*(3*(b - a) - 2*da - db + u*(da + db - 2*(b - a))))
  end function lowest_gap

  !> Beside an edge a point may come up that was not known at the start of the step.  Where a search at the end of the step
  !> finds it inside the rail, the step is repeated with that point.
  subroutine find_newcomers(side, w, dt, from, contacts, to, event, merged)
    type(side_type), intent(in) :: side(:)
    type(wheelset_type), intent(in) :: w
    real(dp), intent(in) :: dt                     !! the longest step [s]
    type(state_type), intent(inout) :: from        !! start of the step
    type(contacts_type), intent(inout) :: contacts !! on return those of a search at the end of the step
    type(state_type), intent(inout) :: to          !! end of the step
    integer, intent(inout) :: event                !! of `find_event`
    logical, intent(inout) :: merged
    integer, parameter :: most_trials = 8
    integer :: trial, i, slot
    logical :: any_new

    do trial = 1, most_trials
      contacts%c = to%c
      call search_rivals(side, to%motion%q, to%closed, contacts)
      any_new = .false.
      do i = 1, size(contacts%c)
        associate (c => contacts%c(i))
          if (to%closed(i) .or. c%absent .or. c%gap > -c%touching) cycle
          if (any(same_point(c, to%c))) cycle
          slot = maxloc(from%c%gap, 1, mask=.not. from%closed .and. from%c%wheel == c%wheel .and. from%c%first == c%first)
          if (slot == 0) cycle
          from%c(slot) = c
          call find_gap(side, from%motion%q, from%c(slot))
          ! At the start it may be one with a known point.
          if (any(same_point(from%c(slot), from%c) .and. from%closed)) from%c(slot)%gap = 0
          call start_at(c, from%c(slot))
          any_new = .true.
        end associate
      end do
      if (.not. any_new .or. to%h <= 0) exit
      call move(side, w, from, to%h, to)
      call find_event(side, w, from, dt, to, event, merged)
    end do
  end subroutine find_newcomers

  !> Whether two points of a wheel are the same.
  elemental logical function same_point(a, b)
    type(gap_type), intent(in) :: a, b

    same_point = .not. (a%absent .or. b%absent) .and. a%wheel == b%wheel .and. abs(a%s - b%s) <= a%apart
  end function same_point

  !> Let the search for the nearest points of contact c begin at those of another contact.
  pure subroutine start_at(other, c)
    type(gap_type), intent(in) :: other
    type(gap_type), intent(inout) :: c

    c%s = other%s
    c%at_wheel = other%at_wheel
    c%foot = other%foot
    c%at_rail = other%at_rail
  end subroutine start_at

end module step_events
