!> Poses in which both wheels stand on their rails: at the centre, at a lateral displacement, at rest.
!>
!> The constraints g_left(q) = g_right(q) = 0 leave one degree of freedom of q = (y, z, roll), a path.  A wheelset without
!> loads that is held on both rails moves along this path and keeps its kinetic energy, so that the steps of `rigid_steps`
!> follow it around its corners.  The path need not be a function of y.
module both_rails
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use constraint_forces, only: close_gaps, closing_forces, tangent
  use contact_zones, only: side_type
  use gap_functions, only: gap_type, new_contacts, tightest
  use kinds, only: dp, gravity, pi
  use motion_state, only: motion_type
  use rigid_steps, only: advance_contacts, rigid_state, rule_type, step_ok
  use rival_points, only: search_rivals
  use root_bracket, only: bracket_type
  use wheelset, only: wheelset_type
  implicit none
  private
  public :: rest_on_rails, stand_at, largest_force_on_rails

contains

  !> Find the static equilibrium of a wheelset with rigid contacts, the lowest pose on both rails, and how the wheelset
  !> oscillates from there along such poses.
  subroutine rest_on_rails(side, w, centred, symmetric, farthest, equilibrium, rest, frequency, shape, ok)
    type(side_type), intent(in) :: side(:)      !! left, right
    type(wheelset_type), intent(in) :: w
    real(dp), intent(in) :: centred(3)          !! pose on both rails at y = 0, nearly: y, z [m], roll [rad]
    logical, intent(in) :: symmetric            !! left and right are the same
    real(dp), intent(in) :: farthest            !! farthest lateral displacement [m]
    real(dp), intent(out) :: equilibrium(3)     !! held at y = 0 [m, m, rad]
    real(dp), intent(out) :: rest(3)            !! of the free wheelset [m, m, rad]
    real(dp), intent(out) :: frequency          !! [Hz], as of `small_motion`
    real(dp), intent(out) :: shape(3)
    logical, intent(out) :: ok
    type(rigid_state) :: state
    logical :: corner

    corner = .false.
    rest = 0
    frequency = 0
    shape = 0
    call stand(side, w, centred, state, ok)
    equilibrium = [0.0_dp, state%motion%q(2), merge(0.0_dp, state%motion%q(3), symmetric)]
    if (ok .and. .not. symmetric) call find_rest(side, w, farthest, state, corner, ok)
    if (.not. ok) return
    rest = merge(equilibrium, state%motion%q, symmetric)
    call small_motion(w, state, corner, frequency, shape)
  end subroutine rest_on_rails

  !> Put the wheelset on both rails, near a pose from which they are not far.
  subroutine stand(side, w, q, state, ok)
    type(side_type), intent(in) :: side(:)      !! left, right
    type(wheelset_type), intent(in) :: w
    real(dp), intent(in) :: q(3)                !! y, z [m], roll [rad]
    type(rigid_state), intent(out) :: state     !! at rest
    logical, intent(out) :: ok
    type(gap_type) :: c(2)
    integer :: k(2)

    state%motion%q = q
    state%contacts = new_contacts(side)
    state%closed = spread(.false., 1, size(state%contacts%c))
    call search_rivals(side, q, state%closed, state%contacts)
    k = [tightest(state%contacts, 1), tightest(state%contacts, 2)]
    state%closed(k) = .true.
    c = state%contacts%c(k)
    call close_gaps(side, w%inertia(), c, state%motion%q, ok)
    state%contacts%c(k) = c
    state%contacts%stale = .true.
  end subroutine stand

  !> Put the wheelset on both rails at the lateral displacement y, as reached from the centre.  Where a flange climbs there
  !> are several such poses, of which the one nearest in height counts.
  subroutine stand_at(side, w, centred, farthest, y, z, state, ok)
    type(side_type), intent(in) :: side(:)      !! left, right
    type(wheelset_type), intent(in) :: w
    real(dp), intent(in) :: centred(3)          !! pose on both rails at y = 0: y, z [m], roll [rad]
    real(dp), intent(in) :: farthest, y, z      !! the farthest lateral displacement of the path; displacement and height [m]
    type(rigid_state), intent(out) :: state     !! at rest
    logical, intent(out) :: ok                  !! there is such a pose
    type(rigid_state) :: here, there
    logical :: corner

    call stand(side, w, centred, here, ok)
    if (abs(y) <= 0 .or. .not. ok) then
      state = here
      return
    end if
    here%motion%v = tangent_of(w, here, [sign(1.0_dp, y), 0.0_dp, 0.0_dp])
    do
      call follow(side, w, farthest, 'y', y, here, there, corner, ok)
      if (.not. ok) exit
      if (.not. allocated(state%closed)) then
        state = there
      else if (abs(there%motion%q(2) - z) < abs(state%motion%q(2) - z)) then
        state = there
      end if
      if (here%motion%q(2) >= z) exit
    end do
    ok = allocated(state%closed)
    state%motion = motion_type(q=state%motion%q)
  end subroutine stand_at

  !> Lowest pose downhill from a pose on both rails: there the wheelset is in static equilibrium.
  subroutine find_rest(side, w, farthest, state, corner, ok)
    type(side_type), intent(in) :: side(:)      !! left, right
    type(wheelset_type), intent(in) :: w
    real(dp), intent(in) :: farthest            !! farthest lateral displacement of the path [m]
    type(rigid_state), intent(inout) :: state   !! from `stand`; on return at rest
    logical, intent(out) :: corner              !! the wheelset rests on two contacts of a wheel
    logical, intent(out) :: ok                  !! the path does not fall as far as it goes
    type(rigid_state) :: here

    corner = .false.
    here = state
    here%motion%v = tangent_of(w, state, [0.0_dp, -1.0_dp, 0.0_dp])
    call follow(side, w, farthest, 'slope', 0.0_dp, here, state, corner, ok)
  end subroutine find_rest

  !> The static limit, see module `static_limit`, to the left (`way` = 1) or to the right (-1): the normal of the contact on this
  !> side passes through the centre of gravity, so that the other wheel carries nothing.
  subroutine largest_force_on_rails(side, w, centred, farthest, way, force, ok)
    type(side_type), intent(in) :: side(:)      !! left, right
    type(wheelset_type), intent(in) :: w
    real(dp), intent(in) :: centred(3)          !! pose on both rails at y = 0: y, z [m], roll [rad]
    real(dp), intent(in) :: farthest            !! farthest lateral displacement of the path [m]
    integer, intent(in) :: way
    real(dp), intent(out) :: force              !! [N]
    logical, intent(out) :: ok
    real(dp), parameter :: strides(2) = [1e-4_dp, 1e-6_dp]   ! step [s]; the speed is about 1 m/s
    integer, parameter :: most_steps = 5000
    type(rule_type), parameter :: rule = rule_type(bilateral=.true.)
    type(rigid_state) :: here, from
    type(motion_type) :: before
    real(dp) :: g(3), g_before(3), h
    integer :: i, steps, evaluations, status

    force = 0
    call stand(side, w, centred, here, ok)
    if (.not. ok) return
    here%motion%v = tangent_of(w, here, [real(way, dp), 0.0_dp, 0.0_dp])
    g = outer_gradient(here, way)
    do i = 1, size(strides)
      do steps = 1, most_steps
        from = here
        g_before = g
        h = strides(i)
        call advance_contacts(side, unloaded(w), rule, here, before, h, evaluations, status)
        ok = status == step_ok .and. abs(here%motion%q(1)) <= farthest
        if (.not. ok) return
        g = outer_gradient(here, way)
        ok = g_before(3)*g(3) <= 0
        if (ok) exit
      end do
      if (.not. ok) return
      if (i < size(strides)) then
        here = from
        g = g_before
      end if
    end do
    ! Between both poses, and in a corner, where two contacts of the wheel share the weight, the moments balance.
    g = (g_before*g(3) - g*g_before(3))/(g(3) - g_before(3))
    force = -way*w%weight()*g(1)/g(2)
  end subroutine largest_force_on_rails

  !> Gradient of the gap of the contact on the left (`way` = 1) or on the right (-1): its force is along it.
  pure function outer_gradient(state, way) result(g)
    type(rigid_state), intent(in) :: state
    integer, intent(in) :: way
    real(dp) :: g(3)

    g = state%contacts%c(findloc(state%closed .and. state%contacts%c%wheel == merge(1, 2, way == 1), .true., 1))%gradient
  end function outer_gradient

  !> The wheelset without loads, which moves along the path with constant kinetic energy.
  type(wheelset_type) function unloaded(w) result(free)
    type(wheelset_type), intent(in) :: w

    free = w
    free%vertical_load = -w%mass*gravity
    free%lateral_force = 0
    free%lateral_ramp = 0
  end function unloaded

  !> Follow the path from `here`, which moves on, to the next pose at which y is as given or the path is level.
  subroutine follow(side, w, farthest, which, level, here, there, corner, ok)
    type(side_type), intent(in) :: side(:)
    type(wheelset_type), intent(in) :: w
    real(dp), intent(in) :: farthest            !! farthest lateral displacement of the path [m]
    character(*), intent(in) :: which           !! 'y' or 'slope'
    real(dp), intent(in) :: level               !! of y [m] or of dz/dt [m/s]
    type(rigid_state), intent(inout) :: here    !! on return at the end of the step that passes the pose
    type(rigid_state), intent(out) :: there     !! at the pose
    logical, intent(out) :: corner              !! the slope changes its sign in a corner
    logical, intent(out) :: ok                  !! the path has such a pose before its end
    real(dp), parameter :: stride = 1e-4_dp     ! step [s]; the speed is about 1 m/s
    integer, parameter :: most_steps = 5000
    type(wheelset_type) :: free
    type(rule_type) :: rule
    type(rigid_state) :: from
    type(motion_type) :: before
    type(bracket_type) :: range
    real(dp) :: h, f
    integer :: steps, evaluations, status

    free = unloaded(w)
    rule = rule_type(bilateral=.true.)
    corner = .false.
    ok = .false.
    do steps = 1, most_steps
      from = here
      h = stride
      call advance_contacts(side, free, rule, here, before, h, evaluations, status)
      if (status /= step_ok .or. abs(here%motion%q(1)) > farthest) return
      if (any(here%motion%contact%struck)) then
        corner = beyond(before)*beyond(here%motion) <= 0 .and. beyond(from%motion)*beyond(before) > 0
        f = beyond(before)
      else
        f = beyond(here%motion)
      end if
      ok = corner .or. beyond(from%motion)*f <= 0
      if (ok) exit
    end do
    there = here
    if (corner .or. .not. ok) return
    range = bracket_type(0.0_dp, beyond(from%motion), h, f)
    do steps = 1, 100
      h = range%guess()
      there = from
      call advance_contacts(side, free, rule, there, before, h, evaluations, status)
      ok = status == step_ok
      if (.not. ok) return
      f = beyond(there%motion)
      if (abs(f) <= 1e-17_dp .or. abs(range%b - range%a) <= 1e-16_dp*stride) exit
      call range%narrow(h, f)
    end do

  contains

    pure real(dp) function beyond(motion)
      type(motion_type), intent(in) :: motion

      beyond = merge(motion%q(1), motion%v(2), which == 'y') - level
    end function beyond

  end subroutine follow

  !> Direction in which a wheelset on both rails can move, on the side of `ahead`, with about 1 m/s.
  pure function tangent_of(w, state, ahead) result(t)
    type(wheelset_type), intent(in) :: w
    type(rigid_state), intent(in) :: state
    real(dp), intent(in) :: ahead(3)
    real(dp) :: t(3)

    t = sqrt(w%mass)*tangent(w%inertia(), pack(state%contacts%c, state%closed), ahead)
  end function tangent_of

  !> Frequency [Hz] and shape dq/ds of small oscillations about a pose of rest, from V'' = W z'' over the arc length s in the
  !> kinetic metric.  For an unstable pose the frequency is minus its growth rate/2 pi, and NaN at a corner.
  pure subroutine small_motion(w, state, corner, frequency, shape)
    type(wheelset_type), intent(in) :: w
    type(rigid_state), intent(in) :: state
    logical, intent(in) :: corner
    real(dp), intent(out) :: frequency, shape(3)
    type(gap_type) :: c(2)
    real(dp) :: force(2), curvature

    ! At unit speed and without load the acceleration is the path's curvature.
    c = pack(state%contacts%c, state%closed)
    shape = tangent(w%inertia(), c, [1.0_dp, 0.0_dp, 0.0_dp])
    call closing_forces(w%inertia(), [0.0_dp, 0.0_dp, 0.0_dp], shape, c, force)
    curvature = w%weight()*sum(force*c%gradient(2))/w%mass
    frequency = sign(sqrt(abs(curvature)), curvature)/(2*pi)
    if (corner) frequency = ieee_value(1.0_dp, ieee_quiet_nan)
  end subroutine small_motion

end module both_rails
