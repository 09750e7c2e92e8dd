!> The motion of a wheelset with rigid contacts, bilateral or unilateral: how it starts, and how it steps.
!>
!> The mirror image of a case gives the mirror image of its results, to the last digit: contacts have an order, left and
!> right do not.  So a case is mirrored before it is integrated if it starts to the right, and the results are mirrored
!> back.
module rigid_motion
  use constraint_forces, only: close_gaps
  use contact_zones, only: side_type
  use errors, only: error_type, fatal_error
  use gap_functions, only: contacts_type, gap_type, new_contacts, search_stations, tightest
  use geometry_functions, only: rigid_contact
  use kinds, only: dp
  use motion_state, only: motion_type
  use path_motion, only: advance_along, turn_corner
  use path_points, only: path_state, point_type, start_at
  use rigid_path, only: path_type, tangent
  use text, only: str
  use unilateral, only: advance_contacts, rule_type, start_contacts
  use wheel_rail_pair, only: mirror
  use wheelset, only: other_side, wheelset_type
  implicit none
  private
  public :: rigid_type, start_rigid, advance_rigid, rigid_ok, rigid_end, rigid_stuck

  !> State of a run with rigid contacts.
  type :: rigid_type
    logical :: bilateral = .false.
    type(wheelset_type) :: w
    type(rule_type) :: rule
    type(point_type) :: point              !! on the path (bilateral)
    type(contacts_type) :: contacts        !! (unilateral)
    logical, allocatable :: closed(:)      !! which of contacts%c are closed (unilateral)
    type(motion_type) :: own               !! the motion that is integrated, maybe the mirror image of the case's
    type(motion_type) :: before            !! the case's motion just before the last impact
    logical :: mirrored = .false.          !! the mirror image of the case is integrated
    integer :: idle = 0                    !! events in a row without time between them
  end type rigid_type

  integer, parameter :: most_idle = 100
  ! Status of a step: success; the path ends; the contact problem has no solution; impacts accumulate.
  integer, parameter :: rigid_ok = 0, rigid_end = 1, rigid_stuck = 2, rigid_crowded = 3

contains

  !> Start a run: the first pose and velocity.  On the rails lateral position and velocity are the case's, and the
  !> constraints give the other components.  With unilateral contacts a wheelset in the air starts as the case says.
  subroutine start_rigid(bilateral, rule, offset, given_rate, w, side, path, equilibrium, r, motion, changes, error)
    logical, intent(in) :: bilateral              !! both wheels are held on their rails
    type(rule_type), intent(in) :: rule
    real(dp), intent(in) :: offset(3)             !! initial pose relative to `equilibrium`: y, z [m], roll [rad]
    real(dp), intent(in) :: given_rate(3)         !! initial velocity [m/s, m/s, rad/s]
    type(wheelset_type), intent(in) :: w
    type(side_type), intent(in) :: side(:)        !! left, right
    type(path_type), intent(in) :: path(:)        !! to the left, to the right
    real(dp), intent(in) :: equilibrium(3)        !! y, z [m], roll [rad]
    type(rigid_type), intent(out) :: r
    type(motion_type), intent(out) :: motion
    character(:), allocatable, intent(out) :: changes   !! in words, what differs from the case
    type(error_type), allocatable, intent(out) :: error
    real(dp) :: given(3), rate(3), first
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
    r%bilateral = bilateral
    r%mirrored = first < 0
    r%rule = rule
    r%w = w
    if (r%mirrored) then
      r%w%lateral_force = -w%lateral_force
      r%w%lateral_ramp = -w%lateral_ramp
      given = mirror*given
      rate = mirror*rate
    end if
    r%own%q = given
    r%own%v = rate
    k = merge(2, 1, r%mirrored)
    call start_own(side(k:3 - k:3 - 2*k), path(k:3 - k:3 - 2*k), rate(1), r, ok)
    if (.not. ok) then
      call fatal_error(error, '&initial Y = '//str(offset(1))//' m: expected a wheelset on both rails with formulation = '''// &
        trim(merge('bilateral ', 'unilateral', bilateral))//''', found none there')
      return
    end if
    motion = to_case(r%own, r%mirrored)
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

  end subroutine start_rigid

  !> Put the wheelset that is integrated on its rails, from the pose and velocity in r%own.
  subroutine start_own(side, path, vy, r, ok)
    type(side_type), intent(in) :: side(:)        !! left, right
    type(path_type), intent(in) :: path(:)        !! to the left, to the right
    real(dp), intent(in) :: vy                    !! lateral velocity [m/s]
    type(rigid_type), intent(inout) :: r
    logical, intent(out) :: ok
    type(gap_type) :: touching(2)
    real(dp), parameter :: air = 1e-9_dp          ! gap of a wheelset that is not on the rails [m]
    real(dp) :: t(3), station(2), y

    y = r%own%q(1)
    if (r%bilateral) then
      call start_at(path, y, r%own%q(2), r%point, ok)
      if (ok) then
        r%point%v = 1
        call path_state(path, side, r%w, r%point, 0.0_dp, r%own%q, t, r%own%contact)
        ok = abs(t(1)) > 1e-6_dp*norm2(t)
        if (ok) r%point%v = vy/t(1)
        call path_state(path, side, r%w, r%point, 0.0_dp, r%own%q, r%own%v, r%own%contact)
      end if
    else
      r%contacts = new_contacts(side)
      allocate (r%closed(size(r%contacts%c)))
      call search_stations(side, r%own%q, r%contacts)
      ok = .true.
      if (any(r%contacts%c%gap < air)) then
        call rigid_contact(side, y, r%own%q(3), r%own%q(2), station, ok)
        if (ok) then
          call search_stations(side, r%own%q, r%contacts)
          touching = r%contacts%c([tightest(r%contacts, 1), tightest(r%contacts, 2)])
          call close_gaps(side, r%w%inertia(), touching, r%own%q, ok)
          t = tangent(r%w%inertia(), touching, [1.0_dp, 0.0_dp, 0.0_dp])
          r%own%v = t*vy/t(1)
        end if
      end if
      if (ok) call start_contacts(side, r%w, r%rule, r%contacts, r%closed, r%own, ok)
    end if
  end subroutine start_own

  !> A step of at most dt, or up to the next event.
  subroutine advance_rigid(side, path, r, motion, dt, evaluations, status)
    type(side_type), intent(in) :: side(:)     !! left, right
    type(path_type), intent(in) :: path(:)     !! to the left, to the right
    type(rigid_type), intent(inout) :: r
    type(motion_type), intent(out) :: motion   !! at the end of the step
    real(dp), intent(inout) :: dt              !! at most; on return the step that was made [s]
    integer, intent(out) :: evaluations        !! number of evaluations of the contacts
    integer, intent(out) :: status             !! rigid_ok, rigid_end, rigid_stuck or rigid_crowded
    real(dp) :: asked
    integer :: k
    logical :: ok

    asked = dt
    k = merge(2, 1, r%mirrored)
    if (r%bilateral) then
      call advance_bilateral(path(k:3 - k:3 - 2*k), side(k:3 - k:3 - 2*k), r, dt, evaluations, status)
    else
      call advance_contacts(side(k:3 - k:3 - 2*k), r%w, r%rule, r%contacts, r%closed, r%own, r%before, dt, evaluations, ok)
      status = merge(rigid_ok, rigid_stuck, ok)
    end if
    r%idle = merge(r%idle + 1, 0, dt <= epsilon(dt)*asked)
    if (r%idle > most_idle) status = rigid_crowded
    motion = to_case(r%own, r%mirrored)
    if (any(motion%contact%struck)) r%before = to_case(r%before, r%mirrored)
  end subroutine advance_rigid

  !> A step along the path on both rails, cut until it keeps the energy; it ends in a corner that it meets.
  subroutine advance_bilateral(path, side, r, dt, evaluations, status)
    type(path_type), intent(in) :: path(:)
    type(side_type), intent(in) :: side(:)
    type(rigid_type), intent(inout) :: r
    real(dp), intent(inout) :: dt
    integer, intent(out) :: evaluations, status
    type(point_type) :: p
    real(dp) :: h, time, work, q(3), impulse(4)
    integer :: corner, halved

    status = rigid_ok
    evaluations = 0
    q = r%own%q
    work = r%own%work
    h = dt
    do halved = 0, r%rule%halvings
      dt = h
      p = r%point
      time = r%own%t
      work = r%own%work
      call advance_along(path, r%w, p, time, dt, work, corner)
      evaluations = evaluations + 6
      call path_state(path, side, r%w, p, time, r%own%q, r%own%v, r%own%contact)
      if (r%rule%tolerance <= 0 .or. halved == r%rule%halvings) exit
      if (abs(0.5_dp*(p%v - r%point%v)*(p%v + r%point%v) + r%w%weight()*(r%own%q(2) - q(2)) &
        - (work - r%own%work)) <= r%rule%tolerance) exit
      h = h/2
    end do
    if (corner == 2) status = rigid_end
    r%own%contact%struck = .false.
    if (abs(corner) == 1) then
      r%before = r%own
      r%before%t = time
      r%before%work = work
      call turn_corner(path, r%w%inertia(), corner, p, impulse)
      call path_state(path, side, r%w, p, time, r%own%q, r%own%v, r%own%contact)
      r%own%impulse = r%own%impulse + impulse
      r%own%contact%struck = abs(impulse) > 0
    end if
    r%point = p
    r%own%t = time
    r%own%work = work
  end subroutine advance_bilateral

  !> The motion of the case, from the motion that is integrated.
  pure function to_case(own, mirrored) result(motion)
    type(motion_type), intent(in) :: own
    logical, intent(in) :: mirrored
    type(motion_type) :: motion
    integer :: k

    motion = own
    if (.not. mirrored) return
    motion%q = mirror*own%q
    motion%v = mirror*own%v
    motion%impulse = own%impulse(other_side)
    associate (c => motion%contact, mine => own%contact)
      do k = 1, 4
        c%slope(:, k) = mirror*mine%slope(:, other_side(k))
      end do
      c%gradient = mirror*mine%gradient
      c%rigid = mine%rigid(other_side)
      c%struck = mine%struck(other_side)
      c%pulls = mine%pulls(other_side)
    end associate
  end function to_case

end module rigid_motion
