!> Steps of a wheelset with rigid contacts, from event to event.
!>
!> Unilateral contacts push and never pull: 0 <= g(q) and 0 <= force, one of them zero, for every contact.  Bilateral ones
!> hold both wheels on their rails: one contact of each wheel is closed and may pull, and all other gaps are 0 <= g(q).
!>
!> Between events the motion is that of `smooth_motion`.  A step ends where a gap closes or a force that must not pull vanishes.
!> `impacts` resolves a unilateral event, `turn_corner` a bilateral one.
module rigid_steps
  use smooth_motion, only: move, state_type
  use constraint_forces, only: couplings, solve_independent, tangent
  use contact_zones, only: side_type
  use gap_functions, only: accept_depth, contacts_type, gap_type
  use impacts, only: resolve_contacts, set_forces
  use kinds, only: dp
  use motion_state, only: energy_rounding, motion_type
  use rival_points, only: search_rivals
  use step_events, only: find_event, find_newcomers, may_open
  use wheelset, only: wheelset_type
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

  real(dp), parameter :: uncorrected = 1e-3_dp ! energy that a slow wheelset may have in excess, of the tolerance
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

end module rigid_steps
