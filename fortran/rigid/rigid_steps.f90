!> Steps of a wheelset with rigid contacts, from event to event.
!>
!> Unilateral contacts push and never pull: 0 <= g(q) and 0 <= force, one of them zero, for every contact.  Bilateral ones
!> hold both wheels on their rails: one contact of each wheel is closed and may pull, and all other gaps are 0 <= g(q).
!>
!> Between events some contacts, none to three, stay closed:
!>
!>     M q'' = f + J' force,   J q'' + q'.g_qq q' = 0.
!>
!> Free flight is exact.  Else the step is the classical Runge-Kutta step of fourth order, after which pose and velocity
!> are projected onto the closed contacts in the kinetic metric.  A wheelset held on both rails has one degree of freedom,
!> whose speed is then projected onto the energy, too (E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration,
!> IV.4).  A step ends where a gap closes or a force that must not pull vanishes.  `impacts` resolves a unilateral event,
!> `turn_corner` a bilateral one.
module rigid_steps
  use constraint_forces, only: close_gaps, closing_forces, couplings, most_closed, solve_independent, stop_gaps, tangent
  use contact_zones, only: side_type
  use gap_functions, only: accept_depth, contacts_type, find_gap, gap_type
  use impacts, only: resolve_contacts, set_forces, still
  use kinds, only: dp
  use motion_state, only: motion_type
  use integrators, only: energy_change, energy_rounding
  use rival_points, only: drop_merged_rivals, search_rivals
  use root_bracket, only: bracket_type
  use wheelset, only: external_force, wheelset_type
  implicit none
  private
  public :: rule_type, rigid_state, advance_contacts, step_ok, path_ends, no_solution

  !> What happens at events, and how exact a step is.
  type :: rule_type
    logical :: bilateral = .false.     !! both wheels are held on their rails
    real(dp) :: restitution = 1        !! coefficient of restitution, 0 to 1
    real(dp) :: tolerance = 0          !! change of the total energy that a step may make [J]; 0: any
    integer :: halvings = 10           !! how often a step may be halved
  end type rule_type

  !> The state of a wheelset between steps.
  type :: rigid_state
    type(motion_type) :: motion
    type(contacts_type) :: contacts
    logical, allocatable :: closed(:)  !! which of contacts%c
    real(dp) :: error = 0              !! change of the total energy in the last step, before the speed was corrected [J]
    real(dp) :: excess = 0             !! energy that the speed has still to be corrected for (bilateral) [J]
  end type rigid_state

  !> Motion and contacts at the start or the end of a step.
  type :: state_type
    real(dp) :: h = 0                  !! time from the start of the step [s]
    type(motion_type) :: motion
    type(gap_type), allocatable :: c(:)
    logical, allocatable :: closed(:)  !! which of them
    logical :: bilateral = .false.
    integer :: zones = 0               !! number of zones of both wheels
    integer :: evaluations = 0         !! number of evaluations of the contacts so far
    real(dp) :: error = 0, excess = 0  !! as in `rigid_state` [J]
    real(dp), allocatable :: half_force(:)   !! forces half way (bilateral) [N]
    logical :: ended = .false.         !! no pose nearby is on both rails, or a contact is at the end of its zone
  end type state_type

  real(dp), parameter :: pierced = 1e-14_dp    ! depth of a gap that has closed within a step [m]
  real(dp), parameter :: uncorrected = 1e-3_dp ! energy that a slow wheelset may have in excess, of the tolerance
  real(dp), parameter :: slight = 1e-8_dp      ! pull that is more than rounding, of the weight
  real(dp), parameter :: search_distance = 1e-4_dp   ! move after which another point of a wheel may be nearest: a search is due [m]

  ! Status of a step: success; the path on both rails ends; the impact or the forces have no solution.
  integer, parameter :: step_ok = 0, path_ends = 1, no_solution = 2

contains

  !> One step of at most dt, or up to the next event.
  subroutine advance_contacts(side, w, rule, state, before, dt, evaluations, status)
    type(side_type), intent(in) :: side(:) !! left, right
    type(wheelset_type), intent(in) :: w
    type(rule_type), intent(in) :: rule
    type(rigid_state), intent(inout) :: state
    type(motion_type), intent(inout) :: before   !! just before the event that ends the step, if one does
    real(dp), intent(inout) :: dt          !! at most; on return the step that was made [s]
    integer, intent(out) :: evaluations    !! number of evaluations of the contacts
    integer, intent(out) :: status         !! step_ok, path_ends or no_solution
    type(state_type) :: from, to
    real(dp) :: h, moved(3)
    integer :: event, halved, released
    logical :: merged, ok

    status = step_ok
    associate (motion => state%motion, contacts => state%contacts, closed => state%closed)
      moved = abs(motion%q - contacts%searched)
      if (contacts%stale .or. norm2(moved(:2)) + moved(3) > search_distance) call search_rivals(side, motion%q, closed, contacts)
      call accept_depth(contacts%c, closed)
      from = state_type(0.0_dp, motion, contacts%c, closed, rule%bilateral, contacts%n, excess=state%excess)
      to = from
      h = dt
      do halved = 0, rule%halvings
        call move(side, w, from, h, to)
        if (halved == rule%halvings) exit
        if (.not. to%ended .and. (rule%tolerance <= 0 .or. abs(to%error) <= rule%tolerance .and. &
          abs(to%excess) <= max(uncorrected*rule%tolerance, energy_rounding(w, from%motion)))) exit
        h = h/2
      end do
      if (to%ended) then
        ! No step is made: what the last step struck is not struck again.
        motion%contact%struck = .false.
        dt = 0
        evaluations = to%evaluations
        status = path_ends
        return
      end if
      call find_event(side, w, from, dt, to, event, merged)
      if (contacts%points > 2) call find_newcomers(side, w, dt, from, contacts, to, event, merged)

      dt = to%h
      evaluations = to%evaluations
      motion = to%motion
      ! A jump of the energy may come from another point of a wheel.
      contacts%stale = halved > 0 .or. merged .or. contacts%points > 2
      contacts%c = to%c
      state%error = to%error
      state%excess = to%excess
      motion%contact%struck = .false.
      if (event == 0) then
        call set_forces(w, contacts%c, closed, motion)
        return
      end if
      before = motion
      call set_forces(w, contacts%c, closed, before)
      released = merge(event, 0, closed(event))
      if (may_open(to, event)) closed(event) = .false.
      call accept_depth(contacts%c, closed)
      if (.not. rule%bilateral) then
        call resolve_contacts(w, rule%restitution, contacts%c, closed, motion, released, ok)
        if (.not. ok) status = no_solution
      else
        if (released == 0) call turn_corner(w, contacts%c, event, closed, motion)
        call set_forces(w, contacts%c, closed, motion)
      end if
    end associate
  end subroutine advance_contacts

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

  !> Let contact k of a wheel, whose gap has just closed, take the place of the wheel's closed contact.  In this corner of the
  !> path on both rails the velocity turns to where the old contact opens and keeps its length in the kinetic metric, which is
  !> the limit of ever finer rounding.  The impulses of the three contacts turn it.
  subroutine turn_corner(w, c, k, closed, motion)
    type(wheelset_type), intent(in) :: w
    type(gap_type), intent(in) :: c(:)
    integer, intent(in) :: k
    logical, intent(inout) :: closed(:)
    type(motion_type), intent(inout) :: motion
    real(dp) :: inertia(3), turn(3), impulse(3)
    integer :: on(3), i

    inertia = w%inertia()
    on = [findloc(closed .and. c%wheel == c(k)%wheel, .true., 1), findloc(closed .and. c%wheel /= c(k)%wheel, .true., 1), k]
    closed(on(1)) = .false.
    closed(k) = .true.
    turn = tangent(inertia, c(on(2:)), c(on(1))%gradient/inertia)*sqrt(sum(inertia*motion%v**2)) - motion%v
    impulse = [(dot_product(c(on(i))%gradient, turn), i=1, 3)]
    call solve_independent(couplings(inertia, c(on)), impulse)
    motion%v = motion%v + turn
    do i = 1, 3
      associate (contact => c(on(i))%contact)
        motion%impulse(contact) = motion%impulse(contact) + impulse(i)
        motion%contact%struck(contact) = .true.
      end associate
    end do
  end subroutine turn_corner

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

  !> The state after the time h with the same contacts closed, and all gaps there.  `to` starts as a copy of `from`.
  subroutine move(side, w, from, h, to)
    type(side_type), intent(in) :: side(:)
    type(wheelset_type), intent(in) :: w
    type(state_type), intent(in) :: from
    real(dp), intent(in) :: h              !! [s]
    type(state_type), intent(inout) :: to
    integer :: i, on(count(from%closed))
    logical :: ok

    to%h = h
    to%ended = .false.
    to%motion = from%motion
    to%c = from%c
    if (size(on) == 0) then
      call fly(w, h, to%motion)
    else if (size(on) == most_closed) then
      ! No motion is left.
      to%motion%t = to%motion%t + h
      to%motion%v = 0
      to%half_force = normal_forces(w, to)
    else
      ! Two half steps have a sixteenth of the energy error, which is less than the error of an impact.
      on = pack([(i, i=1, size(to%c))], to%closed)
      do i = 1, 2
        call slide(side, w, h/2, on, to%c, to%motion, ok)
        ok = ok .and. .not. any(to%c(on)%edge .and. .not. to%c(on)%rim)
        to%ended = to%ended .or. from%bilateral .and. .not. ok
        if (i == 1 .and. from%bilateral) to%half_force = normal_forces(w, to)
      end do
      to%evaluations = to%evaluations + 8
    end if
    to%error = energy_change(w, from%motion, to%motion)
    if (from%bilateral) call correct_speed(w, from%excess + to%error, to)
    do i = 1, size(to%c)
      if (.not. to%closed(i)) call find_gap(side, to%motion%q, to%c(i))
    end do
    call drop_merged_rivals(to%zones, to%closed, to%c)
    to%evaluations = to%evaluations + 1
  end subroutine move

  !> Take energy that the wheelset has in excess out of its speed, or leave it to a later step where the wheelset is too slow.
  pure subroutine correct_speed(w, excess, state)
    type(wheelset_type), intent(in) :: w
    real(dp), intent(in) :: excess         !! [J]
    type(state_type), intent(inout) :: state
    real(dp), parameter :: slow = 100         ! least kinetic energy, relative to the excess
    real(dp) :: kinetic

    kinetic = sum(w%inertia()*state%motion%v**2)/2
    state%excess = excess
    if (kinetic <= slow*abs(excess) .or. abs(excess) <= energy_rounding(w, state%motion)/4) return
    state%motion%v = state%motion%v*sqrt(1 - excess/kinetic)
    state%excess = 0
  end subroutine correct_speed

  !> Rate of the gap of contact i [m/s].
  pure real(dp) function gap_rate(state, i)
    type(state_type), intent(in) :: state
    integer, intent(in) :: i

    gap_rate = dot_product(state%c(i)%gradient, state%motion%v)
  end function gap_rate

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

  !> Normal force of every contact, 0 for open ones [N].
  pure function normal_forces(w, state) result(force)
    type(wheelset_type), intent(in) :: w
    type(state_type), intent(in) :: state
    real(dp) :: force(size(state%c)), part(count(state%closed))

    call closing_forces(w%inertia(), external_force(w, state%motion%t), state%motion%v, pack(state%c, state%closed), part)
    force = unpack(part, state%closed, 0.0_dp)
  end function normal_forces

  !> Free flight over the time h under a lateral force that grows linearly: exact.
  pure subroutine fly(w, h, motion)
    type(wheelset_type), intent(in) :: w
    real(dp), intent(in) :: h
    type(motion_type), intent(inout) :: motion
    real(dp) :: a(3), growth(3), v_y, move(3), q(3)

    a = external_force(w, motion%t)/w%inertia()
    growth = [w%lateral_ramp/w%mass, 0.0_dp, 0.0_dp]
    v_y = motion%v(1)
    move = h*(motion%v + h*(a/2 + h*growth/6)) + motion%remainder
    q = motion%q + move
    motion%remainder = (motion%q - q) + move
    motion%q = q
    motion%v = motion%v + h*(a + h*growth/2)
    motion%t = motion%t + h
    motion%work = motion%work + 0.5_dp*w%mass*(motion%v(1) - v_y)*(motion%v(1) + v_y)
  end subroutine fly

  !> A Runge-Kutta step h with the contacts `on` closed, projected onto them.
  pure subroutine slide(side, w, h, on, c, motion, ok)
    type(side_type), intent(in) :: side(:)
    type(wheelset_type), intent(in) :: w
    real(dp), intent(in) :: h
    integer, intent(in) :: on(:)
    type(gap_type), intent(inout) :: c(:)
    type(motion_type), intent(inout) :: motion
    logical, intent(out) :: ok             !! the contacts are closed, by a move that is short beside the step
    real(dp), parameter :: node(4) = [0.0_dp, 0.5_dp, 0.5_dp, 1.0_dp]
    real(dp), parameter :: weight(4) = [1.0_dp, 2.0_dp, 2.0_dp, 1.0_dp]/6
    type(gap_type) :: part(size(on))
    real(dp) :: q(3), v(3), a(3), f(3), inertia(3), dq(3), dv(3), work, force(size(on))
    integer :: stage, i

    inertia = w%inertia()
    part = c(on)
    q = motion%q
    v = motion%v
    a = 0
    dq = 0
    dv = 0
    work = 0
    do stage = 1, 4
      if (stage > 1) then
        q = motion%q + node(stage)*h*v
        v = motion%v + node(stage)*h*a
      end if
      do i = 1, size(on)
        call find_gap(side, q, part(i))
      end do
      f = external_force(w, motion%t + node(stage)*h)
      call closing_forces(inertia, f, v, part, force)
      a = f
      do i = 1, size(on)
        a = a + force(i)*part(i)%gradient
      end do
      a = a/inertia
      dq = dq + weight(stage)*v
      dv = dv + weight(stage)*a
      work = work + weight(stage)*f(1)*v(1)
    end do
    motion%q = motion%q + h*dq
    q = motion%q
    motion%remainder = 0
    motion%v = motion%v + h*dv
    motion%t = motion%t + h
    motion%work = motion%work + h*work
    call close_gaps(side, inertia, part, motion%q, ok)
    ok = ok .and. norm2(motion%q - q) < 0.3_dp*norm2(h*dq) + 1e-9_dp
    call stop_gaps(inertia, part, motion%v)
    c(on) = part
  end subroutine slide

end module rigid_steps
