!> Rigid contacts that push and never pull: 0 <= g(q) and 0 <= force, one of them zero, for every contact.
!>
!> The motion goes from event to event.  Between them some contacts, none to three, stay closed:
!>
!>     M q'' = f + J' force,   J q'' + q'.g_qq q' = 0,
!>
!> in flight exactly, else by the classical Runge-Kutta step of fourth order, after which pose and velocity are
!> projected onto the closed contacts in the kinetic metric.  A step ends where a gap closes or a force vanishes.
!>
!> Impact: Newton's law in the form of J. J. Moreau, "Unilateral contact and dry friction in finite freedom
!> dynamics" (1988), for all contacts that touch at that instant at once: impulses P >= 0 with
!>
!>     u+ + e u- >= 0,  P.(u+ + e u-) = 0,  u+ = u- + J M^-1 J' P,
!>
!> which conserves energy for e = 1 and, for e = 0, projects the velocity onto what the contacts admit.
!>
!> Accumulating impacts: an approach slower than `resting` ends in contact (e = 0).  Which of the contacts
!> at rest carry a force is the same complementarity problem for forces and accelerations.
module unilateral
  use root_bracket, only: bracket_type
  use contact_zones, only: side_type
  use gap_functions, only: bending, close_gaps, closing_forces, complement, contacts_type, couplings, find_gap, gap_type, &
    most_closed, part_rivals, search_rivals, set_state, stop_gaps
  use kinds, only: dp
  use motion_state, only: motion_type
  use wheelset, only: external_force, wheelset_type
  implicit none
  private
  public :: rule_type, start_contacts, advance_contacts, resting, contacts_ok, contacts_stuck, contacts_many

  type :: rule_type
    real(dp) :: restitution = 1
    real(dp) :: tolerance = 0          !! of the change of the total energy in a step [J]; 0: any
    integer :: halvings = 10           !! of a step, at most
  end type rule_type

  real(dp), parameter :: resting = 1e-7_dp     !! slowest approach that bounces [m/s]
  real(dp), parameter :: touching = 1e-12_dp   ! a gap that is closed at an event [m]
  real(dp), parameter :: still = 1e-8_dp       ! a gap that neither opens nor closes [m/s]
  real(dp), parameter :: pierced = 1e-14_dp    ! a gap that has closed within a step [m]
  real(dp), parameter :: reach = 1e-4_dp       ! of a step: farther, another point of a wheel may be nearest [m]

  integer, parameter :: contacts_ok = 0, contacts_stuck = 1, contacts_many = 2

contains

  !> Contacts at a pose and velocity that are given: what touches and does not open is closed, with an impact if it
  !> approaches.
  subroutine start_contacts(side, w, rule, all, closed, motion, status)
    type(side_type), intent(in) :: side(:)
    type(wheelset_type), intent(in) :: w
    type(rule_type), intent(in) :: rule
    type(contacts_type), intent(inout) :: all
    logical, intent(out) :: closed(:)      !! (contacts)
    type(motion_type), intent(inout) :: motion
    integer, intent(out) :: status

    closed = .false.
    call search_rivals(side, motion%q, closed, all)
    call meet(w, rule, all%c, closed, motion, released=0, status=status)
  end subroutine start_contacts

  !> One step of at most dt, or up to the next event.
  subroutine advance_contacts(side, w, rule, all, closed, motion, before, dt, evaluations, status)
    type(side_type), intent(in) :: side(:)
    type(wheelset_type), intent(in) :: w
    type(rule_type), intent(in) :: rule
    type(contacts_type), intent(inout) :: all
    logical, intent(inout) :: closed(:)
    type(motion_type), intent(inout) :: motion
    type(motion_type), intent(inout) :: before   !! just before the event that ends the step, if one does
    real(dp), intent(inout) :: dt          !! at most; on return what was taken [s]
    integer, intent(out) :: evaluations, status
    type(motion_type) :: new
    type(gap_type) :: c(size(all%c))
    type(bracket_type) :: range
    real(dp) :: h, rate(size(all%c)), base(size(all%c)), least, x, f, low
    integer :: k, event, trials, iter, halved
    logical :: opens, lost

    status = contacts_ok
    evaluations = 0
    lost = .false.
    if (all%stale .or. norm2(motion%q(:2) - all%searched(:2)) + abs(motion%q(3) - all%searched(3)) > reach) &
      call search_rivals(side, motion%q, closed, all)
    do k = 1, size(all%c)
      rate(k) = dot_product(all%c(k)%slope, motion%v)
      base(k) = min(all%c(k)%gap, 0.0_dp)      ! what an event left of it
    end do
    h = dt
    do halved = 0, rule%halvings
      call step(h, new, c)
      if (halved == rule%halvings .or. rule%tolerance <= 0) exit
      if (abs(change()) <= rule%tolerance) exit
      h = h/2
    end do

    ! The first event of the step: what it finds broken earlier than that is looked for in turn.
    event = 0
    do trials = 1, 3*size(closed)
      k = broken(c, new, h)
      if (k == 0) exit
      event = k
      opens = closed(k)
      if (.not. opens .and. c(k)%gap - base(k) > -pierced) then
        ! It dips below zero within the step and comes back.
        x = lowest(k, h)
        call step(x, new, c)
        if (c(k)%gap - base(k) > -pierced) then
          call step(h, new, c)
          event = 0
          exit
        end if
        h = x
      end if
      if (opens) then
        least = force_of(k, motion, all%c)
        f = force_of(k, new, c)
      else
        ! Over time: a gap that opens at the start has no zero there.
        least = rate(k)
        if (all%c(k)%gap > touching) least = max(least, all%c(k)%gap/h)
        f = (c(k)%gap - base(k))/h
      end if
      low = 0
      if (.not. opens .and. all%c(k)%gap <= touching .and. abs(rate(k)) <= still) then
        ! A contact that has just been released, at rest but for rounding, closes again only after it has opened.
        low = h
        do iter = 1, 50
          low = low/2
          call step(low, new, c)
          least = (c(k)%gap - base(k) - 0.1_dp*pierced)/low
          if (least > 0) exit
        end do
      end if
      if (least <= 0) then
        ! At once.
        h = 0
        call step(h, new, c)
        exit
      end if
      range = bracket_type(low, least, h, f)
      do iter = 1, 100
        x = range%guess()
        call step(x, new, c)
        lost = c(k)%idle
        if (lost) exit
        f = force_of(k, new, c)
        ! At the start, as close as an instant can be told, the mean rate is the rate.
        if (.not. opens) f = least
        if (.not. opens .and. x > epsilon(x)*dt) f = (c(k)%gap - base(k))/x
        if (abs(range%b - range%a) <= 4*epsilon(x)*range%b) exit
        if (.not. opens .and. abs(c(k)%gap - base(k)) < 1e-16_dp) exit
        if (opens .and. abs(f) < 1e-9_dp*w%weight()) exit
        call range%narrow(x, f)
      end do
      h = x
      ! It has come to its rival's point, which goes on from here.
      if (lost) event = 0
    end do

    dt = h
    motion = new
    all%c = c
    ! What made the energy jump may be another point of a wheel.
    all%stale = halved > 0 .or. lost
    motion%contact%struck = .false.
    if (event > 0) then
      before = motion
      call set_forces(w, all%c, closed, before)
      if (opens) closed(event) = .false.
      call meet(w, rule, all%c, closed, motion, released=merge(event, 0, opens), status=status)
    else
      call set_forces(w, all%c, closed, motion)
    end if

  contains

    !> The motion after h with the same contacts closed, and all gaps there.
    subroutine step(h, new, c)
      real(dp), intent(in) :: h
      type(motion_type), intent(out) :: new
      type(gap_type), intent(out) :: c(:)
      integer :: i, on(count(closed))

      new = motion
      c = all%c
      if (count(closed) == 0) then
        call fly(w, h, new)
      else
        ! Two halves: their error in energy is a sixteenth, below that of an impact.
        on = pack([(i, i=1, size(c))], closed)
        call slide(side, w, h/2, on, c, new)
        call slide(side, w, h/2, on, c, new)
        evaluations = evaluations + 8
      end if
      do i = 1, size(c)
        if (.not. closed(i)) call find_gap(side, new%q, c(i))
      end do
      call part_rivals(closed, c)
      evaluations = evaluations + 1
    end subroutine step

    real(dp) function change()
      change = 0.5_dp*sum(w%inertia()*(new%v - motion%v)*(new%v + motion%v)) &
        + w%weight()*(new%q(2) - motion%q(2)) - (new%work - motion%work)
    end function change

    !> A contact that pierces or pulls at the end of the step, or has pierced within it; the one that is
    !> likely to be the first.
    integer function broken(c, new, h) result(first)
      type(gap_type), intent(in) :: c(:)
      type(motion_type), intent(in) :: new
      real(dp), intent(in) :: h
      real(dp) :: when, earliest, force
      integer :: i

      first = 0
      if (h <= 0) return
      earliest = huge(h)
      do i = 1, size(c)
        when = huge(h)
        if (closed(i)) then
          force = force_of(i, new, c)
          if (force < -1e-8_dp*w%weight()) when = h*min(1.0_dp, 1/(1 - force/max(force_of(i, motion, all%c), 1.0_dp)))
        else if (c(i)%gap - base(i) < -pierced) then
          when = h*(all%c(i)%gap - base(i))/(all%c(i)%gap - c(i)%gap)
        else if (rate(i) < 0 .and. dot_product(c(i)%slope, new%v) > 0) then
          if (dip(i, lowest(i, h), h, c(i), new) - base(i) < -pierced) when = lowest(i, h)
        end if
        if (when < earliest) then
          earliest = when
          first = i
        end if
      end do
    end function broken

    !> When the gap's cubic is lowest.
    real(dp) function lowest(i, h) result(x)
      integer, intent(in) :: i
      real(dp), intent(in) :: h
      real(dp) :: after

      after = dot_product(c(i)%slope, new%v)
      x = h*rate(i)/(rate(i) - after)
    end function lowest

    real(dp) function dip(i, x, h, c, new)
      integer, intent(in) :: i
      real(dp), intent(in) :: x, h
      type(gap_type), intent(in) :: c
      type(motion_type), intent(in) :: new
      real(dp) :: u, a, b, da, db

      u = x/h
      a = all%c(i)%gap
      b = c%gap
      da = h*rate(i)
      db = h*dot_product(c%slope, new%v)
      dip = a + u*(da + u*(3*(b - a) - 2*da - db + u*(da + db - 2*(b - a))))
    end function dip

    !> Of a closed contact [N].
    real(dp) function force_of(i, m, c) result(force)
      integer, intent(in) :: i
      type(motion_type), intent(in) :: m
      type(gap_type), intent(in) :: c(:)
      real(dp) :: forces(size(c))
      logical :: ok

      force = 0
      if (.not. closed(i)) return
      forces = 0
      call closing_forces(w%inertia(), external_force(w, m%t), m%v, pack(c, closed), forces(:count(closed)), ok)
      force = forces(count(closed(:i)))
    end function force_of

  end subroutine advance_contacts

  !> Free flight, with a lateral force that grows linearly: exact.
  pure subroutine fly(w, h, motion)
    type(wheelset_type), intent(in) :: w
    real(dp), intent(in) :: h
    type(motion_type), intent(inout) :: motion
    real(dp) :: a(3), growth(3), v_y, move(3), q(3)

    a = external_force(w, motion%t)/w%inertia()
    growth = [w%lateral_ramp/w%mass, 0.0_dp, 0.0_dp]
    v_y = motion%v(1)
    move = h*(motion%v + h*(a/2 + h*growth/6)) + motion%rest
    q = motion%q + move
    motion%rest = (motion%q - q) + move
    motion%q = q
    motion%v = motion%v + h*(a + h*growth/2)
    motion%t = motion%t + h
    motion%work = motion%work + 0.5_dp*w%mass*(motion%v(1) - v_y)*(motion%v(1) + v_y)
  end subroutine fly

  !> A Runge-Kutta step with the contacts `on` closed, projected onto them.
  pure subroutine slide(side, w, h, on, c, motion)
    type(side_type), intent(in) :: side(:)
    type(wheelset_type), intent(in) :: w
    real(dp), intent(in) :: h
    integer, intent(in) :: on(:)
    type(gap_type), intent(inout) :: c(:)
    type(motion_type), intent(inout) :: motion
    real(dp), parameter :: node(4) = [0.0_dp, 0.5_dp, 0.5_dp, 1.0_dp]
    real(dp), parameter :: weight(4) = [1.0_dp, 2.0_dp, 2.0_dp, 1.0_dp]/6
    type(gap_type) :: part(size(on))
    real(dp) :: q(3), v(3), a(3), f(3), inertia(3), dq(3), dv(3), work, force(size(on))
    integer :: stage, i
    logical :: ok

    inertia = w%inertia()
    part = c(on)
    q = motion%q
    v = motion%v
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
      call closing_forces(inertia, f, v, part, force, ok)
      a = f
      do i = 1, size(on)
        a = a + force(i)*part(i)%slope
      end do
      a = a/inertia
      dq = dq + weight(stage)*v
      dv = dv + weight(stage)*a
      work = work + weight(stage)*f(1)*v(1)
    end do
    motion%q = motion%q + h*dq
    motion%rest = 0
    motion%v = motion%v + h*dv
    motion%t = motion%t + h
    motion%work = motion%work + h*work
    call close_gaps(side, inertia, part, motion%q, ok)
    call stop_gaps(inertia, part, motion%v)
    c(on) = part
  end subroutine slide

  !> What happens where contacts touch: an impact if one approaches, then the forces that set in.  `released` is a
  !> contact whose force has just vanished.
  subroutine meet(w, rule, c, closed, motion, released, status)
    type(wheelset_type), intent(in) :: w
    type(rule_type), intent(in) :: rule
    type(gap_type), intent(in) :: c(:)
    logical, intent(inout) :: closed(:)
    type(motion_type), intent(inout) :: motion
    integer, intent(in) :: released
    integer, intent(out) :: status
    integer, allocatable :: on(:)
    real(dp), allocatable :: u(:), back(:), x(:), g(:, :)
    real(dp) :: inertia(3), v(3)
    integer :: i
    logical :: ok

    status = contacts_ok
    inertia = w%inertia()
    on = pack([(i, i=1, size(c))], c%gap <= touching)
    u = [(dot_product(c(on(i))%slope, motion%v), i=1, size(on))]
    if (any(u < -still)) then
      back = merge(rule%restitution, 0.0_dp, u <= -resting)*u
      g = couplings(inertia, c(on))
      allocate (x(size(on)))
      call complement(g, u + back, x, ok)
      if (.not. ok) status = contacts_stuck
      if (.not. ok) return
      v = motion%v
      do i = 1, size(on)
        motion%v = motion%v + x(i)*c(on(i))%slope/inertia
        associate (k => c(on(i))%contact)
          motion%impulse(k) = motion%impulse(k) + x(i)
          if (x(i) > 0 .and. any(u <= -resting)) motion%contact%struck(k) = .true.
        end associate
      end do
      motion%loss = motion%loss - 0.5_dp*sum(inertia*(motion%v - v)*(motion%v + v))
      deallocate (x)
    end if
    ! Those at rest carry a force or open.
    on = pack(on, [(abs(dot_product(c(on(i))%slope, motion%v)) <= still .and. on(i) /= released, i=1, size(on))])
    u = [(sum(c(on(i))%slope*external_force(w, motion%t)/inertia) + bending(c(on(i)), motion%v), i=1, size(on))]
    allocate (x(size(on)))
    call complement(couplings(inertia, c(on)), u, x, ok)
    if (.not. ok) status = contacts_stuck
    closed = .false.
    do i = 1, size(on)
      closed(on(i)) = x(i) > 0
    end do
    if (count(closed) > most_closed) status = contacts_many
    if (status == contacts_ok) call set_forces(w, c, closed, motion)
  end subroutine meet

  subroutine set_forces(w, c, closed, motion)
    type(wheelset_type), intent(in) :: w
    type(gap_type), intent(in) :: c(:)
    logical, intent(in) :: closed(:)
    type(motion_type), intent(inout) :: motion
    real(dp) :: force(count(closed))
    logical :: struck(4), ok

    struck = motion%contact%struck
    call closing_forces(w%inertia(), external_force(w, motion%t), motion%v, pack(c, closed), force, ok)
    call set_state(pack(c, closed), force, motion%contact)
    motion%contact%struck = struck
  end subroutine set_forces

end module unilateral