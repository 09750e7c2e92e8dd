!> Motion along the path on which both wheels stand on their rails (see `rigid_path`).
!>
!> In the arc length s of the path the wheelset moves as a point of unit mass:
!>
!>     s'' = -dV/ds,   V = W z - F y.
!>
!> V is known with its derivative, so the explicit step of fourth order (see `newmark`) conserves energy to its own error.
!> V'' jumps at the poses of the path, and a step over a pose would lose its order.  Each step is therefore made on one
!> cubic and ends at the latest where the cubic ends.
!>
!> In a corner of the path the velocity turns and keeps its size, which is the limit of ever finer rounding.  An
!> impulse of the contacts turns it.
module path_motion
  use complementarity, only: solve_linear
  use gap_functions, only: gap_type
  use kinds, only: dp
  use newmark, only: drift => drift_4, kick => kick_4
  use path_points, only: corner_contacts, outwards, piece_at, point_type
  use rigid_path, only: evaluate_piece, path_type, piece_type
  use wheelset, only: external_force, other_side, wheelset_type
  implicit none
  private
  public :: advance_along, turn_corner

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

  !> The end of the cubic at which a point leaves the cubic at once: the end towards the centre (-1), the end away from
  !> the centre (1), or none (0).
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

  !> Let a point pass the pose at which it is, in no time. A point that is pushed back from the pose stays for the time dt.
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

  !> Continue on the cubic beyond a pose, unless the pose is a corner or the end of the path.
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
    if (p%half == 2) c%contact = other_side(c%contact)
    do i = 1, 3
      impulse(c(i)%contact) = impulse(c(i)%contact) + change(i)
    end do
  end subroutine turn_corner

end module path_motion
