!> Motion along the path on which both wheels stand on their rails (see `rigid_path`).
!>
!> In the arc length s of the path the wheelset moves as a point of unit mass:
!>
!>     s'' = -dV/ds,   V = W z - F y.
!>
!> V is known with its derivative, so energy is kept as the step keeps it: explicit, fourth order (see `newmark`).
!> V'' jumps at the poses of the path, where a step over a pose would lose its order: each step is made on one cubic and
!> ends at the latest where the cubic does.  The normal forces are the multipliers of the two constraints; a negative
!> one is a rail that pulls.
!>
!> In a corner of the path the velocity turns and keeps its size, which is the limit of ever finer rounding.  An
!> impulse of the contacts turns it.
module path_motion
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use complementarity, only: solve_linear
  use constraint_forces, only: closing_forces, set_state
  use contact_zones, only: side_type
  use gap_functions, only: find_gap, gap_type, mirror
  use kinds, only: dp, pi
  use newmark, only: drift => drift_4, kick => kick_4
  use rigid_path, only: evaluate_piece, path_piece, path_type, piece_type, tangent
  use root_bracket, only: bracket_type
  use wheelset, only: contact_state, external_force, wheelset_type
  implicit none
  private
  public :: point_type, start_at, lowest_point, small_motion, advance_along, turn_corner, path_state

  !> Position and speed on the path.
  type :: point_type
    real(dp) :: s = 0                      !! arc length, positive to the left [m kg^1/2]
    real(dp) :: v = 0                      !! ds/dt [m kg^1/2/s]
    integer :: half = 1                    !! of the path: 1 to the left of the centre, 2 to the right
    integer :: at = 1                      !! the pose of that half before |s|; at a pose it may be the one after it
  end type point_type

  !> Start of a step, and the cubic on which the step is made.
  type :: start_type
    type(piece_type) :: piece
    real(dp) :: ends(2)                    !! |s| at both ends of the cubic [m kg^1/2]
    type(point_type) :: point
    real(dp) :: time                       !! [s]
  end type start_type

  !> A step on one cubic of the path.
  type :: step_type
    real(dp) :: h = 0                      !! [s]
    type(point_type) :: point              !! at the end
    real(dp) :: work = 0                   !! done by the lateral force [J]
    real(dp) :: acceleration = 0           !! of s, at the end [m kg^1/2/s^2]
  end type step_type

contains

  !> The sign of s on the half of the path where a point is.
  pure integer function outwards(p)
    type(point_type), intent(in) :: p

    outwards = merge(1, -1, p%half == 1)
  end function outwards

  !> The cubic of the path at a point.
  pure function piece_at(path, p) result(piece)
    type(path_type), intent(in) :: path(:)      !! to the left, to the right
    type(point_type), intent(in) :: p
    type(piece_type) :: piece

    piece = path_piece(path(p%half), p%at)
    if (p%half == 1) return
    piece%power = spread(mirror, 2, 4)*piece%power
    piece%s0 = -piece%s0
    piece%per_s = -piece%per_s
  end function piece_at

  !> The point nearest to the centre with the lateral displacement y [m]; a pose of the path if that is within rounding.
  !> `ok` is false if the path does not go so far.
  pure subroutine start_at(path, y, p, ok)
    type(path_type), intent(in) :: path(:)      !! to the left, to the right
    real(dp), intent(in) :: y
    type(point_type), intent(out) :: p
    logical, intent(out) :: ok
    type(bracket_type) :: range
    real(dp) :: q(3), t(3)
    integer :: i, near, iter

    p%half = merge(2, 1, y < 0)
    associate (own => path(p%half))
      i = findloc(own%q(1, 2:own%n) >= abs(y), .true., 1)
      ok = i > 0
      if (.not. ok) return
      p%at = i
      range = bracket_type(own%s(i), -1.0_dp, own%s(i + 1), 1.0_dp)
      do iter = 1, 60
        p%s = outwards(p)*range%middle()
        call evaluate_piece(piece_at(path, p), p%s, q, t)
        call range%narrow(abs(p%s), abs(q(1)) - abs(y))
      end do
      near = i - 1 + minloc(abs(own%s(i:i + 1) - abs(p%s)), 1)
      if (abs(own%s(near) - abs(p%s)) < 1e-12_dp) p%s = outwards(p)*own%s(near)
    end associate
  end subroutine start_at

  !> The lowest pose of the path that is downhill from the centre: there the wheelset is at rest.  `ok` is false if the
  !> path falls up to its end.
  pure subroutine lowest_point(path, p, ok)
    type(path_type), intent(in) :: path(:)      !! to the left, to the right
    type(point_type), intent(out) :: p
    logical, intent(out) :: ok
    type(bracket_type) :: range
    real(dp) :: q(3), t(3)
    integer :: i, iter

    p%half = merge(1, 2, path(1)%t(2, 1) < 0)
    associate (own => path(p%half))
      i = findloc(own%t(2, :own%n) >= 0, .true., 1)
      ok = i > 0
      if (i <= 1) return
      ! It is at a corner, or between two poses.
      p%at = merge(i - 1, i - 2, own%stretch(i - 1) == own%stretch(i))
      range = bracket_type(own%s(i - 1), -1.0_dp, own%s(i), 1.0_dp)
      do iter = 1, 60
        p%s = outwards(p)*range%middle()
        call evaluate_piece(piece_at(path, p), p%s, q, t)
        call range%narrow(abs(p%s), outwards(p)*t(2))
      end do
    end associate
  end subroutine lowest_point

  !> Pose q, frequency [Hz] and shape dq/ds of small oscillations about a point at rest, from V'' = W z''.  For an
  !> unstable point the frequency is minus its growth rate/2 pi, and NaN at a corner.
  pure subroutine small_motion(path, side, w, p, q, frequency, shape)
    type(path_type), intent(in) :: path(:)      !! to the left, to the right
    type(side_type), intent(in) :: side(:)      !! left, right
    type(wheelset_type), intent(in) :: w
    type(point_type), intent(in) :: p
    real(dp), intent(out) :: q(3)               !! y, z [m], roll [rad]
    real(dp), intent(out) :: frequency, shape(3)
    type(gap_type) :: c(2)
    real(dp) :: force(2), curvature
    integer :: k
    logical :: ok

    ! At unit speed and without load the acceleration is the path's curvature.
    call evaluate_piece(piece_at(path, p), p%s, q, shape)
    c = path(p%half)%c(:, p%at)
    if (p%half == 2) c%wheel = 3 - c%wheel
    if (abs(p%s) > 0) then
      do k = 1, 2
        call find_gap(side, q, c(k))
      end do
    end if
    call closing_forces(w%inertia(), [0.0_dp, 0.0_dp, 0.0_dp], shape, c, force, ok)
    curvature = w%weight()*sum(force*c%gradient(2))/w%mass
    frequency = sign(sqrt(abs(curvature)), curvature)/(2*pi)
    associate (own => path(p%half))
      if (p%at + 1 < own%n .and. abs(p%s) >= own%s(p%at + 1)) then
        if (own%stretch(p%at + 2) /= own%stretch(p%at)) frequency = ieee_value(1.0_dp, ieee_quiet_nan)
      end if
    end associate
  end subroutine small_motion

  !> One step of at most dt, up to the next pose of the path, beyond which V is another polynomial.  `corner` says whether
  !> that pose is a corner (-1, 1: towards, away from the centre), the path's end (2) or neither (0).
  pure subroutine advance_along(path, w, p, time, dt, work, corner)
    type(path_type), intent(in) :: path(:)      !! to the left, to the right
    type(wheelset_type), intent(in) :: w
    type(point_type), intent(inout) :: p
    real(dp), intent(inout) :: time             !! [s]
    real(dp), intent(inout) :: dt               !! at most; on return the step that was made [s]
    real(dp), intent(inout) :: work             !! grows by the work of the lateral force [J]
    integer, intent(out) :: corner
    type(start_type) :: start
    type(step_type) :: step, turning
    real(dp) :: turn, level
    integer :: out

    out = way_out(path, w, p, time)
    if (out /= 0) then
      call leave_pose(path, w, p, time, dt, out, corner)
      return
    end if
    corner = 0
    start = start_type(piece_at(path, p), path(p%half)%s(p%at:p%at + 1), p, time)
    step = step_from(start, w, time_to_end(start, w, dt))
    turn = 0
    if (p%v*step%point%v < 0) then
      turning = step
      call cut_step(start, w, 0.0_dp, turning)
      if (side_of(start%ends, turning%point) /= 0) then
        step = turning
      else
        turn = turning%h
      end if
    end if
    out = side_of(start%ends, step%point)
    if (out /= 0) then
      level = start%ends(merge(2, 1, out > 0))
      call cut_step(start, w, turn, step, level)
      step%point%s = outwards(p)*level
      call pass_pose(path, step%point, out, corner)
    end if
    p = step%point
    dt = step%h
    time = time + dt
    work = work + step%work
  end subroutine advance_along

  !> The pose at which a point leaves the cubic at once: that towards the centre (-1), away from it (1), none (0).
  pure integer function way_out(path, w, p, time)
    type(path_type), intent(in) :: path(:)
    type(wheelset_type), intent(in) :: w
    type(point_type), intent(in) :: p
    real(dp), intent(in) :: time
    real(dp) :: q(3), t(3), along, r

    way_out = 0
    associate (s => path(p%half)%s)
      r = outwards(p)*p%s
      if (r > s(p%at) .and. r < s(p%at + 1)) return
      along = p%v
      if (abs(along) <= 0) then
        call evaluate_piece(piece_at(path, p), p%s, q, t)
        along = sum(external_force(w, time)*t)
      end if
      along = outwards(p)*along
      if (r <= s(p%at) .and. along < 0) way_out = -1
      if (r >= s(p%at + 1) .and. along > 0) way_out = 1
    end associate
  end function way_out

  !> Pass the pose at which a point is, in no time; a point that is pushed back from there stays for the time dt.
  pure subroutine leave_pose(path, w, p, time, dt, out, corner)
    type(path_type), intent(in) :: path(:)
    type(wheelset_type), intent(in) :: w
    type(point_type), intent(inout) :: p
    real(dp), intent(inout) :: time, dt
    integer, intent(in) :: out                  !! -1 towards, 1 away from the centre
    integer, intent(out) :: corner              !! as in advance_along
    type(point_type) :: new, beyond

    new = p
    call pass_pose(path, new, out, corner)
    beyond = new
    beyond%at = beyond%at + 2*mod(corner, 2)
    if (abs(p%v) <= 0 .and. corner < 2) then
      if (way_out(path, w, beyond, time) /= 0) then
        corner = 0
        time = time + dt
        return
      end if
    end if
    p = new
    dt = 0
  end subroutine leave_pose

  !> Go over to the cubic beyond a pose, unless the pose is a corner or the end of the path.
  pure subroutine pass_pose(path, p, out, corner)
    type(path_type), intent(in) :: path(:)
    type(point_type), intent(inout) :: p
    integer, intent(in) :: out                  !! -1 towards, 1 away from the centre
    integer, intent(out) :: corner              !! as in advance_along

    corner = 0
    if (out < 0 .and. p%at == 1) then
      p%half = 3 - p%half
      return
    end if
    associate (own => path(p%half))
      if (out > 0 .and. p%at + 1 == own%n) then
        corner = 2
      else if (own%stretch(p%at + merge(2, -1, out > 0)) /= own%stretch(p%at)) then
        corner = out
      else
        p%at = p%at + out
      end if
    end associate
  end subroutine pass_pose

  !> Where a point is: before (-1), between (0) or after (1) the two poses at `ends`.
  pure integer function side_of(ends, p)
    real(dp), intent(in) :: ends(2)             !! |s| [m kg^1/2]
    type(point_type), intent(in) :: p

    side_of = merge(1, 0, outwards(p)*p%s > ends(2)) - merge(1, 0, outwards(p)*p%s < ends(1))
  end function side_of

  !> A step h [s] on the cubic.
  pure function step_from(start, w, h) result(step)
    type(start_type), intent(in) :: start
    type(wheelset_type), intent(in) :: w
    real(dp), intent(in) :: h
    type(step_type) :: step
    real(dp) :: q(3), t(3), y, f(3), now
    integer :: i

    step%h = h
    step%point = start%point
    now = start%time
    call evaluate_piece(start%piece, step%point%s, q, t)
    y = q(1)
    do i = 1, size(drift)
      f = external_force(w, now)
      step%point%v = step%point%v + kick(i)*h*sum(f*t)
      step%point%s = step%point%s + drift(i)*h*step%point%v
      call evaluate_piece(start%piece, step%point%s, q, t)
      ! Time is a coordinate of the step like s: its momentum, the energy, grows by kicks.
      f = external_force(w, start%time + sum(kick(:i))*h)
      step%work = step%work + f(1)*(q(1) - y)
      y = q(1)
      now = now + drift(i)*h
    end do
    f = external_force(w, start%time + h)
    step%acceleration = sum(f*t)
    step%point%v = step%point%v + kick(size(kick))*h*step%acceleration
  end function step_from

  !> The time to the next pose by Taylor's formula, and a little more [s]; `dt` if that is longer.
  pure real(dp) function time_to_end(start, w, dt) result(h)
    type(start_type), intent(in) :: start
    type(wheelset_type), intent(in) :: w
    real(dp), intent(in) :: dt                  !! [s]
    real(dp) :: q(3), t(3), curvature(3), f(3), r, v, a, growth, ahead, root, move

    f = external_force(w, start%time)
    associate (piece => start%piece, p => start%point)
      call evaluate_piece(piece, p%s, q, t)
      curvature = (2*piece%power(:, 2) + 6*piece%power(:, 3)*(p%s - piece%s0)*piece%per_s)*piece%per_s**2
      r = outwards(p)*p%s
      v = outwards(p)*p%v
      a = outwards(p)*sum(f*t)
    end associate
    growth = v*sum(f*curvature)
    ahead = start%ends(2) - r
    if (v < 0 .or. v <= 0 .and. a < 0) then
      v = -v
      a = -a
      growth = -growth
      ahead = r - start%ends(1)
    end if
    root = v**2 + 2*a*ahead
    h = dt
    if (root < 0) then
      ! The point turns before that pose and comes to the other one.
      ahead = start%ends(2) - start%ends(1) - ahead
      h = 1.02_dp*(v + sqrt(v**2 - 2*a*ahead))/(-a)
    else if (ahead < dt*(v + sqrt(root))) then
      h = 2*ahead/(v + sqrt(root))
      move = growth*h**3/6
      if (abs(move) < 0.3_dp*h*sqrt(root)) h = h - move/sqrt(root)
      h = 1.002_dp*h
    end if
    h = min(h, dt)
  end function time_to_end

  !> Cut a step to where |s| passes `level` or, without it, the velocity turns, but not before the time
  !> `low`: Newton's method with second derivatives, bisection where that leaves the bracket.
  pure subroutine cut_step(start, w, low, step, level)
    type(start_type), intent(in) :: start
    type(wheelset_type), intent(in) :: w
    real(dp), intent(in) :: low                 !! [s]
    type(step_type), intent(inout) :: step
    real(dp), intent(in), optional :: level     !! [m kg^1/2]
    real(dp) :: a, b, h, f, slope, beyond, small, move
    integer :: iter, sign_of_s

    sign_of_s = outwards(start%point)
    a = low
    b = step%h
    small = 1e-9_dp*max(abs(start%point%v), abs(step%point%v))
    if (present(level)) small = 4*epsilon(level)*start%ends(2)
    beyond = 0
    do iter = 1, 100
      h = step%h
      f = step%point%v
      slope = step%acceleration
      if (present(level)) f = sign_of_s*step%point%s - level
      if (present(level)) slope = sign_of_s*step%point%v
      if (abs(f) <= small) exit
      if (iter == 1) beyond = f
      if (f*beyond > 0) then
        b = h
      else
        a = h
      end if
      if (b - a <= epsilon(h)*b) exit
      move = (a + b)/2 - h
      if (abs(slope)*(b - a) > abs(f)) then
        move = -f/slope
        if (present(level)) move = -f/(slope + sign_of_s*step%acceleration*move/2)
        if (h + move <= a .or. h + move >= b) move = (a + b)/2 - h
      end if
      step = step_from(start, w, h + move)
    end do
  end subroutine cut_step

  !> Turn the velocity in a corner; the result holds the contacts' impulses [N s], by contact.
  pure subroutine turn_corner(path, inertia, corner, p, impulse)
    type(path_type), intent(in) :: path(:)    !! to the left, to the right
    real(dp), intent(in) :: inertia(3)        !! diagonal of the mass matrix
    integer, intent(in) :: corner             !! as advance_along returned it, -1 or 1
    type(point_type), intent(inout) :: p
    real(dp), intent(out) :: impulse(4)
    type(gap_type) :: c(3)
    real(dp) :: change(3), a(3, 3)
    integer :: i
    logical :: ok

    impulse = 0
    associate (own => path(p%half))
      i = merge(p%at + 1, p%at - 1, corner > 0)     ! the first of the corner's two poses
      c = corner_contacts(own, i)
      p%at = p%at + 2*corner
      change = inertia*abs(p%v)*(own%t(:, i + 1) - own%t(:, i))
    end associate
    do i = 1, 3
      a(:, i) = c(i)%gradient
    end do
    call solve_linear(a, change, ok)
    if (p%half == 2) c%contact = mod(c%contact + 1, 4) + 1
    do i = 1, 3
      impulse(c(i)%contact) = impulse(c(i)%contact) + change(i)
    end do
  end subroutine turn_corner

  !> The three contacts of a corner whose first pose is i, not mirrored.
  pure function corner_contacts(own, i) result(c)
    type(path_type), intent(in) :: own
    integer, intent(in) :: i
    type(gap_type) :: c(3)
    integer :: wheel

    wheel = merge(1, 2, abs(own%c(1, i)%s - own%c(1, i + 1)%s) > 0)
    c = [own%c(wheel, i), own%c(wheel, i + 1), own%c(3 - wheel, i)]
  end function corner_contacts

  !> The first pose of the corner in which a point rests, pushed into it from both sides; 0 if it rests in none.
  pure integer function resting_corner(path, w, p, time) result(i)
    type(path_type), intent(in) :: path(:)      !! to the left, to the right
    type(wheelset_type), intent(in) :: w
    type(point_type), intent(in) :: p
    real(dp), intent(in) :: time
    real(dp) :: f(3)

    i = 0
    if (abs(p%v) > 0) return
    associate (own => path(p%half))
      if (abs(p%s) >= own%s(p%at + 1)) i = p%at + 1
      if (abs(p%s) <= own%s(p%at)) i = p%at - 1
      if (i < 1 .or. i >= own%n) then
        i = 0
      else if (own%stretch(i) == own%stretch(i + 1)) then
        i = 0
      else
        f = external_force(w, time)
        if (p%half == 2) f = mirror*f
        if (sum(f*own%t(:, i)) <= 0 .or. sum(f*own%t(:, i + 1)) >= 0) i = 0
      end if
    end associate
  end function resting_corner

  !> Pose, velocity and contacts of a point, with the normal forces that keep both wheels on their rails; at rest in a
  !> corner all three contacts carry.
  pure subroutine path_state(path, side, w, p, time, q, v, state)
    type(path_type), intent(in) :: path(:)      !! to the left, to the right
    type(side_type), intent(in) :: side(:)      !! left, right
    type(wheelset_type), intent(in) :: w
    type(point_type), intent(in) :: p
    real(dp), intent(in) :: time                !! [s]
    real(dp), intent(out) :: q(3), v(3)         !! y, z [m], roll [rad], and per s
    type(contact_state), intent(out) :: state
    type(gap_type) :: c(3)
    real(dp) :: t(3), force(3)
    integer :: k, n, corner
    logical :: ok

    call evaluate_piece(piece_at(path, p), p%s, q, t)
    corner = resting_corner(path, w, p, time)
    if (corner > 0) then
      n = 3
      c = corner_contacts(path(p%half), corner)
    else
      n = 2
      c(:n) = path(p%half)%c(:, p%at)
    end if
    if (p%half == 2) then
      c%wheel = 3 - c%wheel
      c%contact = mod(c%contact + 1, 4) + 1
    end if
    do k = 1, n
      call find_gap(side, q, c(k))
    end do
    v = p%v*tangent(w%inertia(), [c(1), c(n)], t)
    call closing_forces(w%inertia(), external_force(w, time), v, c(:n), force(:n), ok)
    call set_state(c(:n), force(:n), state)
  end subroutine path_state

end module path_motion
