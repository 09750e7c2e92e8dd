!> The motion of a wheelset with rigid contacts, bilateral or unilateral: how it starts, and how it steps.
!>
!> The mirror image of a case gives the mirror image of its results, to the last digit: runs that start to the right are
!> integrated as their mirror images, so that ties break alike.
module rigid_motion
  use both_rails, only: stand_at
  use constraint_forces, only: tangent
  use contact_zones, only: side_type
  use errors, only: error_type, refuse
  use gap_functions, only: new_contacts, search_stations
  use impacts, only: resolve_contacts, set_forces
  use kinds, only: dp
  use motion_state, only: motion_type
  use rigid_steps, only: advance_contacts, no_solution, path_ends, rigid_state, rule_type, step_ok
  use rival_points, only: search_rivals
  use text, only: str
  use wheel_rail_pair, only: mirror
  use wheelset, only: other_side, wheelset_type
  implicit none
  private
  public :: rigid_type, rule_type, start_motion, advance_rigid, step_ok, path_ends, no_solution, impacts_crowd

  !> State of a run with rigid contacts.
  type :: rigid_type
    type(wheelset_type) :: w
    type(rule_type) :: rule
    type(rigid_state) :: state             !! what is integrated, maybe the mirror image of the case
    type(motion_type) :: before            !! the case's motion just before the last impact
    logical :: mirrored = .false.          !! the mirror image of the case is integrated
    integer :: idle = 0                    !! events in a row without time between them
  end type rigid_type

  integer, parameter :: most_idle = 100
  integer, parameter :: impacts_crowd = 3   ! status of a step beside those of `rigid_steps`: no time between impacts

contains

  !> Start a run: the first pose and velocity.  On the rails lateral position and velocity are the case's, and the
  !> constraints give the other components.  With unilateral contacts a wheelset in the air starts as the case says.
  subroutine start_motion(rule, offset, given_rate, w, side, equilibrium, farthest, r, motion, changes, error)
    type(rule_type), intent(in) :: rule
    real(dp), intent(in) :: offset(3)             !! initial pose relative to `equilibrium`: y, z [m], roll [rad]
    real(dp), intent(in) :: given_rate(3)         !! initial velocity [m/s, m/s, rad/s]
    type(wheelset_type), intent(in) :: w
    type(side_type), intent(in) :: side(:)        !! left, right
    real(dp), intent(in) :: equilibrium(3)        !! at y = 0: y, z [m], roll [rad]
    real(dp), intent(in) :: farthest              !! lateral displacement at which both wheels may be on their rails [m]
    type(rigid_type), intent(out) :: r
    type(motion_type), intent(out) :: motion
    character(:), allocatable, intent(out) :: changes   !! in words, what differs from the case
    type(error_type), allocatable, intent(out) :: error
    real(dp) :: given(3), centred(3), rate(3), first
    integer :: k
    logical :: ok

    given = equilibrium + offset
    rate = given_rate
    ! The case is mirrored if the first of these that is not zero is negative.
    associate (order => [rate(1), offset(1), offset(3), rate(3), w%lateral_force, w%lateral_ramp, equilibrium(3), &
      side(1)%clearance - side(2)%clearance])
      first = 0
      k = findloc(abs(order) > 0, .true., 1)
      if (k > 0) first = order(k)
    end associate
    r%mirrored = first < 0
    r%rule = rule
    r%w = w
    centred = equilibrium
    if (r%mirrored) then
      r%w%lateral_force = -w%lateral_force
      r%w%lateral_ramp = -w%lateral_ramp
      given = mirror*given
      centred = mirror*centred
      rate = mirror*rate
      call start_own(side(2:1:-1), centred, farthest, given, rate, r, ok)
    else
      call start_own(side, centred, farthest, given, rate, r, ok)
    end if
    if (.not. ok) then
      call refuse(error, 'a wheelset that can stand on both rails, for formulation = '''// &
        trim(merge('bilateral ', 'unilateral', rule%bilateral))//'''', 'that it cannot', &
        group='initial', variable='Y', detail=' = '//str(offset(1))//' m', rest='; choose a Y nearer to 0')
      return
    end if
    motion = to_case(r%state%motion, r%mirrored)
    if (r%mirrored) given = mirror*given
    changes = ''
    call compare('Z', given(2) - equilibrium(2), motion%q(2) - equilibrium(2), 'm')
    call compare('roll', given(3) - equilibrium(3), motion%q(3) - equilibrium(3), 'rad')
    call compare('vZ', given_rate(2), motion%v(2), 'm/s')
    call compare('roll_rate', given_rate(3), motion%v(3), 'rad/s')

  contains

    subroutine compare(name, was, is, unit)
      character(*), intent(in) :: name, unit
      real(dp), intent(in) :: was, is

      if (abs(is - was) <= 1e-12_dp) return
      if (changes /= '') changes = changes//', '
      changes = changes//name//' = '//str(is)//' '//unit//' instead of '//str(was)
    end subroutine compare

  end subroutine start_motion

  !> Put the wheelset that is integrated on its rails, unless it is unilateral and in the air.
  subroutine start_own(side, centred, farthest, given, rate, r, ok)
    type(side_type), intent(in) :: side(:)        !! left, right
    real(dp), intent(in) :: centred(3)            !! pose on both rails at y = 0: y, z [m], roll [rad]
    real(dp), intent(in) :: farthest              !! as of `start_motion` [m]
    real(dp), intent(in) :: given(3), rate(3)     !! pose and velocity
    type(rigid_type), intent(inout) :: r
    logical, intent(out) :: ok
    real(dp), parameter :: air = 1e-9_dp          ! gap of a wheelset that is not on the rails [m]
    real(dp) :: t(3)

    r%state%motion%q = given
    r%state%motion%v = rate
    r%state%contacts = new_contacts(side)
    r%state%closed = spread(.false., 1, size(r%state%contacts%c))
    call search_stations(side, given, r%state%contacts)
    ok = .true.
    if (r%rule%bilateral .or. any(r%state%contacts%c%gap < air)) then
      call stand_at(side, r%w, centred, farthest, given(1), given(2), r%state, ok)
      if (.not. ok) return
      associate (state => r%state)
        t = tangent(r%w%inertia(), pack(state%contacts%c, state%closed), [1.0_dp, 0.0_dp, 0.0_dp])
        ok = abs(t(1)) > 1e-6_dp*norm2(t)
        if (.not. ok) return
        state%motion%v = t*rate(1)/t(1)
        ! At rest in a corner of the path both contacts of a wheel carry.
        if (abs(rate(1)) <= 0) state%closed = state%contacts%c%gap <= state%contacts%c%touching
      end associate
    end if
    if (r%rule%bilateral) then
      call set_forces(r%w, r%state%contacts%c, r%state%closed, r%state%motion)
    else
      ! A contact that touches and does not open is closed, after an impact if it approaches.
      r%state%closed = .false.
      call search_rivals(side, r%state%motion%q, r%state%closed, r%state%contacts)
      call resolve_contacts(r%w, r%rule%restitution, r%state%contacts%c, r%state%closed, r%state%motion, released=0, ok=ok)
    end if
  end subroutine start_own

  !> A step of at most dt, or up to the next event.
  subroutine advance_rigid(side, r, motion, dt, evaluations, status)
    type(side_type), intent(in) :: side(:)     !! left, right
    type(rigid_type), intent(inout) :: r
    type(motion_type), intent(out) :: motion   !! at the end of the step
    real(dp), intent(inout) :: dt              !! at most; on return the step that was made [s]
    integer, intent(out) :: evaluations        !! number of evaluations of the contacts
    integer, intent(out) :: status             !! step_ok, path_ends, no_solution or impacts_crowd
    real(dp) :: asked

    asked = dt
    if (r%mirrored) then
      call advance_contacts(side(2:1:-1), r%w, r%rule, r%state, r%before, dt, evaluations, status)
    else
      call advance_contacts(side, r%w, r%rule, r%state, r%before, dt, evaluations, status)
    end if
    r%idle = merge(r%idle + 1, 0, dt <= epsilon(dt)*asked)
    if (r%idle > most_idle) status = impacts_crowd
    motion = to_case(r%state%motion, r%mirrored)
    if (any(motion%contact%struck)) r%before = to_case(r%before, r%mirrored)
  end subroutine advance_rigid

  !> The motion of the case, from the motion that is integrated.
  pure function to_case(integrated, mirrored) result(motion)
    type(motion_type), intent(in) :: integrated
    logical, intent(in) :: mirrored
    type(motion_type) :: motion
    integer :: k

    motion = integrated
    if (.not. mirrored) return
    motion%q = mirror*integrated%q
    motion%v = mirror*integrated%v
    motion%impulse = integrated%impulse(other_side)
    associate (c => motion%contact, image => integrated%contact)
      do k = 1, 4
        c%slope(:, k) = mirror*image%slope(:, other_side(k))
      end do
      c%gradient = mirror*image%gradient
      c%rigid = image%rigid(other_side)
      c%struck = image%struck(other_side)
      c%pulls = image%pulls(other_side)
    end associate
  end function to_case

end module rigid_motion
