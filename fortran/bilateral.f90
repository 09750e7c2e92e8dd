!> Both wheels stay on their rails, as in codes with a table of contact geometry: g_left(q) = g_right(q) = 0.
!>
!> What is left of q = (y, z, roll) is a path.  Its coordinate is the arc length in the kinetic metric,
!> ds^2 = m dy^2 + m dz^2 + I droll^2, in which the motion is that of a point of unit mass:
!>
!>     s'' = -dV/ds,   V = W z - F y.
!>
!> The path is followed from the centred wheelset by continuation: a step along the tangent, then back to both
!> rails across it.  It need not be a function of y.  Where a wheel comes to touch at another point as well, the
!> path has a corner: contact goes over to that point, and the velocity turns and keeps its size, which is the
!> limit of ever finer rounding.  What turns it is an impulse of the contacts.
!>
!> Between its poses the path is the Hermite cubic, so V is known with its derivative and energy is kept as the
!> step keeps it: explicit, fourth order (see `newmark`), and no longer than from one pose to the next, which
!> resolves the path.  The normal forces are the multipliers of the two
!> constraints; a negative one is a rail that pulls.
module bilateral
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use bracket, only: bracket_type
  use contact, only: side_type
  use gaps, only: close_gaps, closing_forces, contacts_type, eliminate, find_gap, gap_type, new_contacts, &
    search_rivals, set_state, tightest
  use kinds, only: dp, pi
  use newmark, only: drift, kick
  use text, only: str
  use wheelset, only: contact_state, external_force, wheelset_type
  implicit none
  private
  public :: path_type, point_type, follow_path, path_end, path_state, start_at, advance_along, between_poses, &
    turn_corner, lowest_point, small_motion, tangent

  !> The path on the left of the centre; that on the right is the same of the mirrored wheelset.
  type :: path_type
    integer :: n = 0                       !! poses; a corner is two of them
    real(dp), allocatable :: s(:)          !! [m kg^1/2]
    real(dp), allocatable :: q(:, :)       !! (3, n) y, z [m], roll [rad]
    real(dp), allocatable :: t(:, :)       !! dq/ds, (3, n)
    integer, allocatable :: stretch(:)     !! between corners, of each pose
    integer, allocatable :: last(:)        !! pose of each stretch, (0:)
    type(gap_type), allocatable :: c(:, :) !! the contacts, left and right, at each pose, (2, n)
    real(dp) :: stuck = 0                  !! the step that failed at its end [m]; 0: it goes all the way
  end type path_type

  !> Where on the path, and how fast; s < 0 is on the right of the centre.
  type :: point_type
    real(dp) :: s = 0, v = 0               !! [m kg^1/2, and per s]
    integer :: stretch = 1                 !! |s| is on this stretch
    integer :: at = 1                      !! the pose before |s|
  end type point_type

  real(dp), parameter :: accuracy = 1e-12_dp     ! of the interpolated path [m]
  real(dp), parameter :: longest = 1e-4_dp       ! between two poses [m]
  real(dp), parameter :: mirror(3) = [-1, 1, -1]

contains

  !> Follow the path to the left, until the flange's tip is past `beyond` and above the rail, or to an end.
  subroutine follow_path(side, start, inertia, beyond, path)
    type(side_type), intent(in) :: side(:)      !! left, right
    real(dp), intent(in) :: start(3)            !! the pose at the centre
    real(dp), intent(in) :: inertia(3)
    real(dp), intent(in) :: beyond              !! lateral displacement at which the path may end [m]
    type(path_type), intent(out) :: path
    type(contacts_type) :: all
    type(gap_type) :: c(2), new(2), middle(2), last(2)
    real(dp) :: q(3), t(3), q_new(3), t_new(3), q_mid(3), q_end(3), h, scale, error, length, gap
    type(bracket_type) :: range
    integer :: k(2), wheel, other, iter, i
    logical, allocatable :: held(:)
    logical :: ok, corner

    scale = sqrt(inertia(1))
    all = new_contacts(side, rivals=.true.)
    allocate (held(size(all%c)))
    held = .false.
    q = start
    call search_rivals(side, q, held, all)
    k = [tightest(all, 1), tightest(all, 2)]
    c = all%c(k)
    call close_gaps(side, inertia, c, q, ok)
    t = tangent(inertia, c, [1.0_dp, 0.0_dp, 0.0_dp])
    path%n = 0
    call keep(0.0_dp, 1)
    h = 1e-5_dp*scale
    error = accuracy
    do while (ok .and. q(1) < beyond .and. abs(q(3)) < 1.0_dp)
      do
        call step(h, new, q_new, ok)
        if (ok) call step(h/2, middle, q_mid, ok)
        if (ok) then
          t_new = tangent(inertia, new, t)
          length = arc(q, q_mid, q_new)
          error = max(miss(middle, q_mid), miss_at(0.25_dp), miss_at(0.75_dp))
          if (error < accuracy) exit
        end if
        h = h/2
        if (h < 1e-9_dp*scale) exit
      end do
      if (h < 1e-9_dp*scale) then
        ok = .false.
        exit
      end if
      ! Another point of a wheel that has come into the rail: the step ends where it touches.
      all%c(k) = new
      held = .false.
      held(k) = .true.
      call search_rivals(side, q_new, held, all)
      corner = .false.
      do wheel = 1, 2
        other = tightest(all, wheel)
        if (other == k(wheel) .or. all%c(other)%gap > 0) cycle
        gap = gap_at(q)
        if (gap < 1e-13_dp) cycle
        range = bracket_type(0.0_dp, gap, h, all%c(other)%gap)
        do iter = 1, 100
          h = range%guess()
          call step(h, new, q_end, ok)
          if (.not. ok) exit
          gap = gap_at(q_end)
          if (abs(gap) < 1e-15_dp .or. abs(range%b - range%a) < 1e-15_dp*scale) exit
          call range%narrow(h, gap)
        end do
        if (.not. ok) exit
        corner = .true.
        k(wheel) = other
        q_new = q_end
        exit
      end do
      if (.not. ok) exit
      if (corner) then
        call step(h/2, middle, q_mid, ok)
        t_new = tangent(inertia, new, t)
        length = arc(q, q_mid, q_new)
      end if
      q = q_new
      t = t_new
      last = c
      c = new
      call keep(path%s(path%n) + length, path%stretch(path%n))
      if (corner) then
        last = c
        c(wheel) = all%c(k(wheel))
        call find_gap(side, q, c(wheel))
        ! On, to where the point that touched so far opens.
        t = tangent(inertia, c, t)
        if (dot_product(t, last(wheel)%slope) < 0) t = -t
        call keep(path%s(path%n), path%stretch(path%n) + 1)
        h = 1e-5_dp*scale
      else
        h = min(1.5_dp*h, longest*scale, h*max(0.5_dp, 0.8_dp*sqrt(sqrt(accuracy/max(error, 1e-16_dp)))))
      end if
      if (path%n > 100000) ok = .false.
    end do
    if (.not. ok .or. q(1) < beyond) path%stuck = h/scale
    allocate (path%last(0:path%stretch(path%n)))
    do i = 0, ubound(path%last, 1)
      path%last(i) = count(path%stretch(:path%n) <= i)
    end do

  contains

    !> From q along t by h, then back to both rails across it.
    subroutine step(h, c_end, q_end, ok)
      real(dp), intent(in) :: h
      type(gap_type), intent(out) :: c_end(2)
      real(dp), intent(out) :: q_end(3)
      logical, intent(out) :: ok

      c_end = c
      q_end = q + h*t
      call close_gaps(side, inertia, c_end, q_end, ok)
      if (ok) ok = size_of(q_end - q - h*t) < 0.3_dp*abs(h) .and. .not. any(c_end%edge)
    end subroutine step

    !> How far the cubic passes beside a pose of the path [m].
    real(dp) function miss(c, x)
      type(gap_type), intent(in) :: c(2)
      real(dp), intent(in) :: x(3)
      real(dp) :: ahead(3), d(3), u
      integer :: i

      ahead = tangent(inertia, c, t)
      u = length*sum(inertia*t*(x - q))/sum(inertia*t*(q_new - q))
      do i = 1, 4
        d = x - hermite(q, t, q_new, t_new, length, u)
        u = u + sum(inertia*ahead*d)
      end do
      miss = size_of(d - ahead*sum(inertia*ahead*d))/scale
    end function miss

    real(dp) function miss_at(share)
      real(dp), intent(in) :: share
      type(gap_type) :: c_at(2)
      real(dp) :: x(3)
      logical :: found

      call step(share*h, c_at, x, found)
      miss_at = huge(share)
      if (found) miss_at = miss(c_at, x)
    end function miss_at

    real(dp) function gap_at(x) result(gap)
      real(dp), intent(in) :: x(3)
      type(gap_type) :: g

      g = all%c(other)
      call find_gap(side, x, g)
      gap = g%gap
    end function gap_at

    real(dp) function size_of(x)
      real(dp), intent(in) :: x(3)
      size_of = sqrt(sum(inertia*x**2))
    end function size_of

    !> Arc length through three poses, the middle one half way: chords, extrapolated.
    real(dp) function arc(a, b, c)
      real(dp), intent(in) :: a(3), b(3), c(3)
      real(dp) :: chords

      chords = size_of(b - a) + size_of(c - b)
      arc = chords + (chords - size_of(c - a))/3
    end function arc

    subroutine keep(s, stretch)
      real(dp), intent(in) :: s
      integer, intent(in) :: stretch
      type(path_type) :: old
      integer :: room

      room = 0
      if (allocated(path%s)) room = size(path%s)
      if (path%n == room) then
        old = path
        room = max(1024, 2*room)
        if (allocated(path%s)) deallocate (path%s, path%q, path%t, path%stretch, path%c)
        allocate (path%s(room), path%q(3, room), path%t(3, room), path%stretch(room), path%c(2, room))
        if (path%n > 0) then
          path%s(:path%n) = old%s
          path%q(:, :path%n) = old%q
          path%t(:, :path%n) = old%t
          path%stretch(:path%n) = old%stretch
          path%c(:, :path%n) = old%c
        end if
      end if
      path%n = path%n + 1
      path%s(path%n) = s
      path%q(:, path%n) = q
      path%t(:, path%n) = t
      path%stretch(path%n) = stretch
      path%c(:, path%n) = c
    end subroutine keep

  end subroutine follow_path

  !> Where the path ends on that side of the centre, and why.
  function path_end(path, left, equilibrium) result(words)
    type(path_type), intent(in) :: path(:)      !! to the left, to the right
    logical, intent(in) :: left
    real(dp), intent(in) :: equilibrium(3)      !! from which Z and roll are measured
    character(:), allocatable :: words
    real(dp) :: q(3)

    associate (p => path(merge(1, 2, left)))
      q = merge(p%q(:, p%n), mirror*p%q(:, p%n), left) - equilibrium
      words = 'Y = '//str(q(1))//' m, Z = '//str(q(2))//' m, roll = '//str(q(3))//' rad, where no step of '// &
        str(p%stuck)//' m keeps both wheels on their rails'
    end associate
  end function path_end

  !> The Hermite cubic through a and b with the tangents da and db, `length` apart, at x from a.
  pure function hermite(a, da, b, db, length, x) result(q)
    real(dp), intent(in) :: a(3), da(3), b(3), db(3), length, x
    real(dp) :: q(3), u

    u = x/length
    q = a + u*(length*da + u*((3*(b - a) - length*(2*da + db)) + u*(length*(da + db) - 2*(b - a))))
  end function hermite

  !> Unit tangent dq/ds of the path at two contacts, on the side of `ahead`.
  pure function tangent(inertia, c, ahead) result(t)
    real(dp), intent(in) :: inertia(3)
    type(gap_type), intent(in) :: c(2)
    real(dp), intent(in) :: ahead(3)
    real(dp) :: t(3)

    t = [c(1)%slope(2)*c(2)%slope(3) - c(1)%slope(3)*c(2)%slope(2), &
         c(1)%slope(3)*c(2)%slope(1) - c(1)%slope(1)*c(2)%slope(3), &
         c(1)%slope(1)*c(2)%slope(2) - c(1)%slope(2)*c(2)%slope(1)]
    t = t/sqrt(sum(inertia*t**2))
    if (sum(inertia*t*ahead) < 0) t = -t
  end function tangent

  !> Which half of the path a point is on: 1 to the left, 2 to the right.
  pure integer function half(p)
    type(point_type), intent(in) :: p

    half = merge(2, 1, p%s < 0)
  end function half

  !> The pose before |s| on the point's stretch.
  pure subroutine locate(path, p)
    type(path_type), intent(in) :: path
    type(point_type), intent(inout) :: p
    integer :: first, last

    first = path%last(p%stretch - 1) + 1
    last = path%last(p%stretch) - 1
    p%at = max(first, min(p%at, last))
    do while (p%at < last .and. abs(p%s) >= path%s(p%at + 1))
      p%at = p%at + 1
    end do
    do while (p%at > first .and. abs(p%s) < path%s(p%at))
      p%at = p%at - 1
    end do
  end subroutine locate

  !> Between the poses on both sides of a point [m kg^1/2].
  pure real(dp) function between_poses(path, p) result(length)
    type(path_type), intent(in) :: path(:)      !! to the left, to the right
    type(point_type), intent(in) :: p
    type(point_type) :: x

    x = p
    associate (own => path(half(p)))
      call locate(own, x)
      length = own%s(x%at + 1) - own%s(x%at)
    end associate
  end function between_poses

  !> Pose of a point and dq/ds there, by the cubic of its stretch.
  pure subroutine path_pose(path, p, q, t)
    type(path_type), intent(in) :: path(:)      !! to the left, to the right
    type(point_type), intent(inout) :: p
    real(dp), intent(out) :: q(3), t(3)
    real(dp) :: h, u, d(3), e(3)

    call locate(path(half(p)), p)
    associate (i => p%at, own => path(half(p)))
      h = own%s(i + 1) - own%s(i)
      u = (abs(p%s) - own%s(i))/h
      d = 3*(own%q(:, i + 1) - own%q(:, i)) - h*(2*own%t(:, i) + own%t(:, i + 1))
      e = h*(own%t(:, i) + own%t(:, i + 1)) - 2*(own%q(:, i + 1) - own%q(:, i))
      q = own%q(:, i) + u*(h*own%t(:, i) + u*(d + u*e))
      t = own%t(:, i) + u*(2*d + u*3*e)/h
    end associate
    if (p%s < 0) then
      q = mirror*q
      t = -mirror*t
    end if
  end subroutine path_pose

  !> The point nearest to the centre with the lateral displacement y; ok: the path goes so far.
  pure subroutine start_at(path, y, p, ok)
    type(path_type), intent(in) :: path(:)      !! to the left, to the right
    real(dp), intent(in) :: y
    type(point_type), intent(out) :: p
    logical, intent(out) :: ok
    real(dp) :: low, high, q(3), t(3)
    integer :: i, iter

    associate (side => path(merge(2, 1, y < 0)))
      i = findloc(side%q(1, 2:side%n) >= abs(y), .true., 1)
      ok = i > 0
      if (.not. ok) return
      p%stretch = side%stretch(i)
      p%at = i
      low = side%s(i)
      high = side%s(i + 1)
    end associate
    do iter = 1, 60
      p%s = sign((low + high)/2, y)
      call path_pose(path, p, q, t)
      if (abs(q(1)) < abs(y)) then
        low = abs(p%s)
      else
        high = abs(p%s)
      end if
    end do
    if (abs(y) <= 0) p%s = 0
  end subroutine start_at

  !> One step dt, or less: up to a corner of the path (-1, 1: towards, away from the centre) or, `corner` = 2, its
  !> end.  `work` grows by that of the lateral force.
  pure subroutine advance_along(path, w, p, time, dt, work, corner)
    type(path_type), intent(in) :: path(:)      !! to the left, to the right
    type(wheelset_type), intent(in) :: w
    type(point_type), intent(inout) :: p
    real(dp), intent(inout) :: time, dt, work
    integer, intent(out) :: corner
    type(point_type) :: new, turning
    real(dp) :: done, turn, level

    call step(dt, new, done)
    call leave(new, corner, level)
    if (corner == 0 .and. p%v*new%v < 0) then
      ! It may have been beyond a corner and back.
      turn = root(dt, 0.0_dp)
      call step(turn, turning, done)
      call leave(turning, corner, level)
      if (corner /= 0) new = turning
      if (corner /= 0) dt = turn
      if (corner == 0) call step(dt, new, done)
    end if
    if (corner /= 0) then
      dt = root(dt, level)
      call step(dt, new, done)
      new%s = sign(level, new%s)
      if (corner == 1 .and. p%stretch == size(path(half(new))%last) - 1) corner = 2
    end if
    p = new
    time = time + dt
    work = work + done

  contains

    pure subroutine step(h, new, done)
      real(dp), intent(in) :: h
      type(point_type), intent(out) :: new
      real(dp), intent(out) :: done
      real(dp) :: q(3), t(3), y, f(3), now
      integer :: i

      new = p
      now = time
      done = 0
      call path_pose(path, new, q, t)
      y = q(1)
      do i = 1, size(drift)
        f = external_force(w, now)
        new%v = new%v + kick(i)*h*sum(f*t)
        new%s = new%s + drift(i)*h*new%v
        call path_pose(path, new, q, t)
        ! Time is a coordinate of the step like s: its momentum, the energy, grows by kicks.
        f = external_force(w, time + sum(kick(:i))*h)
        done = done + f(1)*(q(1) - y)
        y = q(1)
        now = now + drift(i)*h
      end do
      f = external_force(w, time + h)
      new%v = new%v + kick(size(kick))*h*sum(f*t)
    end subroutine step

    !> Over which corner a point is, and |s| there.
    pure subroutine leave(x, corner, level)
      type(point_type), intent(in) :: x
      integer, intent(out) :: corner
      real(dp), intent(out) :: level

      corner = 0
      associate (side => path(half(x)))
        level = side%s(side%last(p%stretch))
        if (abs(x%s) > level) corner = 1
      end associate
      if (p%stretch == 1) return
      associate (side => path(half(p)))
        if (abs(x%s) < side%s(side%last(p%stretch - 1) + 1) .or. x%s*p%s < 0) corner = -1
        if (corner == -1) level = side%s(side%last(p%stretch - 1) + 1)
      end associate
    end subroutine leave

    !> The step up to h at which |s| passes `level`, or, level 0, the velocity turns.
    pure real(dp) function root(h, level)
      real(dp), intent(in) :: h, level
      type(bracket_type) :: range
      real(dp) :: f
      integer :: iter

      root = h
      range = bracket_type(0.0_dp, value(0.0_dp, level), h, value(h, level))
      if (range%fa*range%fb >= 0) then
        if (range%fa*range%fb > 0) root = 0
        return
      end if
      do iter = 1, 100
        root = range%guess()
        f = value(root, level)
        if (abs(f) <= 4*epsilon(level)*level .or. abs(range%b - range%a) <= epsilon(h)*h) exit
        call range%narrow(root, f)
      end do
    end function root

    pure real(dp) function value(h, level)
      real(dp), intent(in) :: h, level
      type(point_type) :: x
      real(dp) :: done

      call step(h, x, done)
      value = x%v
      if (level > 0) value = sign(1.0_dp, merge(p%s, new%s, corner < 0))*x%s - level
    end function value

  end subroutine advance_along

  !> Over a corner: the contacts' impulses [N s], (contact), that turn the velocity.
  pure subroutine turn_corner(path, inertia, corner, p, impulse)
    type(path_type), intent(in) :: path(:)    !! to the left, to the right
    real(dp), intent(in) :: inertia(3)
    integer, intent(in) :: corner             !! of advance_along
    type(point_type), intent(inout) :: p
    real(dp), intent(out) :: impulse(4)
    type(gap_type) :: c(3), before(2), after(2)
    real(dp) :: change(3), a(3, 3)
    integer :: i, side
    logical :: ok

    impulse = 0
    associate (own => path(half(p)))
      i = own%last(merge(p%stretch, p%stretch - 1, corner > 0))
      before = own%c(:, merge(i, i + 1, corner > 0))
      after = own%c(:, merge(i + 1, i, corner > 0))
      p%stretch = p%stretch + corner
      change = inertia*abs(p%v)*(own%t(:, i + 1) - own%t(:, i))
    end associate
    side = merge(1, 2, abs(before(1)%s - after(1)%s) > 0)
    c = [before(side), after(side), before(3 - side)]
    do i = 1, 3
      a(:, i) = c(i)%slope
    end do
    call eliminate(a, change, ok)
    if (p%s < 0) c%contact = mod(c%contact + 1, 4) + 1
    do i = 1, 3
      impulse(c(i)%contact) = impulse(c(i)%contact) + change(i)
    end do
  end subroutine turn_corner

  !> Pose, velocity and contacts of a point, with the normal forces that keep both wheels on their rails.
  pure subroutine path_state(path, side, w, p, time, q, v, state)
    type(path_type), intent(in) :: path(:)      !! to the left, to the right
    type(side_type), intent(in) :: side(:)      !! left, right
    type(wheelset_type), intent(in) :: w
    type(point_type), intent(inout) :: p
    real(dp), intent(in) :: time
    real(dp), intent(out) :: q(3), v(3)
    type(contact_state), intent(out) :: state
    type(gap_type) :: c(2)
    real(dp) :: t(3), force(2)
    integer :: k
    logical :: ok

    call path_pose(path, p, q, t)
    c = path(half(p))%c(:, p%at)
    if (p%s < 0) then
      c%wheel = 3 - c%wheel
      c%contact = mod(c%contact + 1, 4) + 1
    end if
    do k = 1, 2
      call find_gap(side, q, c(k))
    end do
    v = p%v*tangent(w%inertia(), c, t)
    call closing_forces(w%inertia(), external_force(w, time), v, c, force, ok)
    call set_state(c, force, state)
  end subroutine path_state

  !> The lowest pose of the path that is downhill from the centre: there the wheelset stays.
  pure subroutine lowest_point(path, p, ok)
    type(path_type), intent(in) :: path(:)      !! to the left, to the right
    type(point_type), intent(out) :: p
    logical, intent(out) :: ok
    real(dp) :: low, high, q(3), t(3)
    integer :: i, side, iter

    side = merge(1, 2, path(1)%t(2, 1) < 0)
    associate (own => path(side))
      i = findloc(own%t(2, :own%n) >= 0, .true., 1)
      ok = i > 0
      p%stretch = own%stretch(max(1, i))
      if (i <= 1) return
      ! At a corner, or on a stretch.
      p%stretch = own%stretch(i - 1)
      low = own%s(i - 1)
      high = own%s(i)
    end associate
    do iter = 1, 60
      p%s = merge(1, -1, side == 1)*(low + high)/2
      call path_pose(path, p, q, t)
      ! In the half's own direction.
      if (merge(t(2), -t(2), side == 1) < 0) then
        low = abs(p%s)
      else
        high = abs(p%s)
      end if
    end do
  end subroutine lowest_point

  !> Frequency of small oscillations about a point at rest [Hz]: V'' = W z'', minus its growth rate/2 pi if unstable;
  !> NaN at a corner.
  pure subroutine small_motion(path, side, w, p, q, frequency, shape)
    type(path_type), intent(in) :: path(:)      !! to the left, to the right
    type(side_type), intent(in) :: side(:)      !! left, right
    type(wheelset_type), intent(in) :: w
    type(point_type), intent(inout) :: p
    real(dp), intent(out) :: q(3)
    real(dp), intent(out) :: frequency, shape(3)
    type(gap_type) :: c(2)
    real(dp) :: force(2), bend
    integer :: k
    logical :: ok

    ! At unit speed and without load the path's curvature is the acceleration.
    call path_pose(path, p, q, shape)
    c = path(half(p))%c(:, p%at)
    if (p%s < 0) c%wheel = 3 - c%wheel
    if (abs(p%s) > 0) then
      do k = 1, 2
        call find_gap(side, q, c(k))
      end do
    end if
    call closing_forces(w%inertia(), [0.0_dp, 0.0_dp, 0.0_dp], shape, c, force, ok)
    bend = w%weight()*sum(force*c%slope(2))/w%mass
    frequency = sign(sqrt(abs(bend)), bend)/(2*pi)
    associate (own => path(half(p)))
      if (abs(p%s) >= own%s(own%last(p%stretch))) frequency = ieee_value(1.0_dp, ieee_quiet_nan)
    end associate
  end subroutine small_motion

end module bilateral
