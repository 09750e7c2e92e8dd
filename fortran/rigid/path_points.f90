!> Points of the path on which both wheels stand on their rails (see `rigid_path`): pose, equilibrium, and the normal forces
!> of a wheelset that moves through a point.
!>
!> The normal forces are the multipliers of the two constraints; a negative one is a rail that pulls.
module path_points
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use constraint_forces, only: closing_forces, set_state
  use contact_zones, only: side_type
  use gap_functions, only: find_gap, gap_type
  use kinds, only: dp, pi
  use rigid_path, only: evaluate_piece, path_piece, path_type, piece_type, tangent
  use root_bracket, only: bracket_type
  use wheel_rail_pair, only: mirror
  use wheelset, only: contact_state, external_force, other_side, wheelset_type
  implicit none
  private
  public :: point_type, outwards, piece_at, start_at, lowest_point, small_motion, path_state, corner_contacts

  !> Position and speed on the path.
  type :: point_type
    real(dp) :: s = 0                      !! arc length, positive to the left [m kg^1/2]
    real(dp) :: v = 0                      !! ds/dt [m kg^1/2/s]
    integer :: half = 1                    !! half of the path: 1 to the left of the centre, 2 to the right
    integer :: at = 1                      !! |s| lies between the poses `at` and `at` + 1 of that half
  end type point_type

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

  !> The point with the lateral displacement y; on a flange that has climbed there are several, of which the one nearest in
  !> height counts. It is a pose of the path if one is within rounding. `ok` is false if the path does not go so far.
  pure subroutine start_at(path, y, z, p, ok)
    type(path_type), intent(in) :: path(:)      !! to the left, to the right
    real(dp), intent(in) :: y, z                !! [m]
    type(point_type), intent(out) :: p
    logical, intent(out) :: ok
    integer, allocatable :: passes(:)           ! pieces of the path that pass y
    integer :: i, near, ends(2)

    p%half = merge(2, 1, y < 0)
    associate (own => path(p%half))
      passes = pack([(i, i=1, own%n - 1)], (own%q(1, :own%n - 1) >= abs(y)) .neqv. (own%q(1, 2:own%n) >= abs(y)))
      if (abs(y) <= 0) passes = [1]
      ok = size(passes) > 0
      if (.not. ok) return
      i = passes(minloc(abs(own%q(2, passes) - z), 1))
      p%at = i
      ends = merge([i, i + 1], [i + 1, i], own%q(1, i + 1) >= own%q(1, i))
      call bisect(path, own%s(ends), p, abs(y))
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
    integer :: i

    p%half = merge(1, 2, path(1)%t(2, 1) < 0)
    associate (own => path(p%half))
      i = findloc(own%t(2, :own%n) >= 0, .true., 1)
      ok = i > 0
      if (i <= 1) return
      ! The lowest point is at a corner, or between two poses.
      p%at = merge(i - 1, i - 2, own%stretch(i - 1) == own%stretch(i))
      call bisect(path, own%s(i - 1:i), p)
    end associate
  end subroutine lowest_point

  !> Set the position of a point between two poses by bisection: where |y| is as given or, without y, where the path is
  !> level.
  pure subroutine bisect(path, ends, p, y)
    type(path_type), intent(in) :: path(:)      !! to the left, to the right
    real(dp), intent(in) :: ends(2)             !! |s| of both poses [m kg^1/2]
    type(point_type), intent(inout) :: p
    real(dp), intent(in), optional :: y         !! [m]
    type(bracket_type) :: range
    real(dp) :: q(3), t(3), f
    integer :: iter

    range = bracket_type(ends(1), -1.0_dp, ends(2), 1.0_dp)
    do iter = 1, 60
      p%s = outwards(p)*range%middle()
      call evaluate_piece(piece_at(path, p), p%s, q, t)
      f = outwards(p)*t(2)
      if (present(y)) f = abs(q(1)) - y
      call range%narrow(abs(p%s), f)
    end do
  end subroutine bisect

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

    ! At unit speed and without load the acceleration is the path's curvature.
    call evaluate_piece(piece_at(path, p), p%s, q, shape)
    c = path(p%half)%c(:, p%at)
    if (p%half == 2) c%wheel = 3 - c%wheel
    if (abs(p%s) > 0) then
      do k = 1, 2
        call find_gap(side, q, c(k))
      end do
    end if
    call closing_forces(w%inertia(), [0.0_dp, 0.0_dp, 0.0_dp], shape, c, force)
    curvature = w%weight()*sum(force*c%gradient(2))/w%mass
    frequency = sign(sqrt(abs(curvature)), curvature)/(2*pi)
    associate (own => path(p%half))
      if (p%at + 1 < own%n .and. abs(p%s) >= own%s(p%at + 1)) then
        if (own%stretch(p%at + 2) /= own%stretch(p%at)) frequency = ieee_value(1.0_dp, ieee_quiet_nan)
      end if
    end associate
  end subroutine small_motion

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
      c%contact = other_side(c%contact)
    end if
    do k = 1, n
      call find_gap(side, q, c(k))
    end do
    v = p%v*tangent(w%inertia(), [c(1), c(n)], t)
    call closing_forces(w%inertia(), external_force(w, time), v, c(:n), force(:n))
    call set_state(c(:n), force(:n), state)
  end subroutine path_state

end module path_points
