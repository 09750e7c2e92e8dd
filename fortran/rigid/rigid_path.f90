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
!> step keeps it: explicit, fourth order (see `newmark`).  V'' jumps at the poses, where a step over one would lose its
!> order: each is made on one cubic and ends at the latest where that does.  The normal forces are the multipliers of
!> the two constraints; a negative one is a rail that pulls.
module rigid_path
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use root_bracket, only: bracket_type
  use contact_zones, only: side_type
  use gap_functions, only: close_gaps, closing_forces, contacts_type, eliminate, find_gap, gap_type, new_contacts, &
    search_rivals, set_state, tightest
  use kinds, only: dp, pi
  use newmark, only: drift => drift_4, kick => kick_4
  use text, only: str
  use wheelset, only: contact_state, external_force, wheelset_type
  implicit none
  private
  public :: path_type, point_type, follow_path, path_end, path_state, start_at, advance_along, turn_corner, &
    lowest_point, small_motion, tangent

  !> The path on the left of the centre; that on the right is the same of the mirrored wheelset.
  type :: path_type
    integer :: n = 0                       !! poses; a corner is two of them
    real(dp), allocatable :: s(:)          !! [m kg^1/2]
    real(dp), allocatable :: q(:, :)       !! (3, n) y, z [m], roll [rad]
    real(dp), allocatable :: t(:, :)       !! dq/ds, (3, n)
    integer, allocatable :: stretch(:)     !! between corners, of each pose
    type(gap_type), allocatable :: c(:, :) !! the contacts, left and right, at each pose, (2, n)
    real(dp) :: stuck = 0                  !! the step that failed at its end [m]; 0: it goes all the way
  end type path_type

  !> Where on the path, and how fast.
  type :: point_type
    real(dp) :: s = 0, v = 0               !! positive to the left [m kg^1/2, and per s]
    integer :: half = 1                    !! of the path: 1 to the left of the centre, 2 to the right
    integer :: at = 1                      !! the pose of that half before |s|; at a pose it may be the one after it
  end type point_type

  !> The path between two poses: a polynomial of u = (s - s0)/length, 0 to 1.
  type :: piece_type
    real(dp) :: power(3, 0:3)              !! coefficients of y, z [m], roll [rad]
    real(dp) :: s0                         !! [m kg^1/2]
    real(dp) :: per_s                      !! 1/length, negative to the right of the centre
  end type piece_type

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
    integer :: k(2), wheel, other, iter
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
      if (ok) ok = size_of(q_end - q - h*t) < 0.3_dp*abs(h) .and. .not. any(c_end%edge .and. .not. c_end%rim)
    end subroutine step

    !> How far the cubic passes beside a pose of the path [m].
    real(dp) function miss(c, x)
      type(gap_type), intent(in) :: c(2)
      real(dp), intent(in) :: x(3)
      type(piece_type) :: piece
      real(dp) :: ahead(3), d(3), at(3), dat(3), s
      integer :: i

      ahead = tangent(inertia, c, t)
      piece = hermite(q, t, q_new, t_new, 0.0_dp, length)
      s = length*sum(inertia*t*(x - q))/sum(inertia*t*(q_new - q))
      do i = 1, 4
        call pose_at(piece, s, at, dat)
        d = x - at
        s = s + sum(inertia*ahead*d)
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

    !> By value: they may be those of the pose before, in arrays that are replaced here.
    subroutine keep(s, stretch)
      real(dp), value :: s
      integer, value :: stretch
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
    character(200) :: words
    real(dp) :: q(3)

    associate (p => path(merge(1, 2, left)))
      q = merge(p%q(:, p%n), mirror*p%q(:, p%n), left) - equilibrium
      words = 'Y = '//str(q(1))//' m, Z = '//str(q(2))//' m, roll = '//str(q(3))//' rad, where no step of '// &
        str(p%stuck)//' m keeps both wheels on their rails'
    end associate
  end function path_end

  !> The Hermite cubic through a at s0 and b with the tangents da and db, `length` apart.
  pure function hermite(a, da, b, db, s0, length) result(piece)
    real(dp), intent(in) :: a(3), da(3), b(3), db(3), s0, length
    type(piece_type) :: piece

    piece%power(:, 0) = a
    piece%power(:, 1) = length*da
    piece%power(:, 2) = 3*(b - a) - length*(2*da + db)
    piece%power(:, 3) = length*(da + db) - 2*(b - a)
    piece%s0 = s0
    piece%per_s = 1/length
  end function hermite

  !> The path about a point.
  pure function piece_at(path, p) result(piece)
    type(path_type), intent(in) :: path(:)      !! to the left, to the right
    type(point_type), intent(in) :: p
    type(piece_type) :: piece

    associate (i => p%at, own => path(p%half))
      piece = hermite(own%q(:, i), own%t(:, i), own%q(:, i + 1), own%t(:, i + 1), own%s(i), own%s(i + 1) - own%s(i))
    end associate
    if (p%half == 1) return
    piece%power = spread(mirror, 2, 4)*piece%power
    piece%s0 = -piece%s0
    piece%per_s = -piece%per_s
  end function piece_at

  !> Pose and dq/ds at s.
  pure subroutine pose_at(piece, s, q, t)
    type(piece_type), intent(in) :: piece
    real(dp), intent(in) :: s
    real(dp), intent(out) :: q(3), t(3)
    real(dp) :: u

    u = (s - piece%s0)*piece%per_s
    associate (a => piece%power(:, 0), b => piece%power(:, 1), c => piece%power(:, 2), d => piece%power(:, 3))
      q = a + u*(b + u*(c + u*d))
      t = (b + u*(2*c + u*(3*d)))*piece%per_s
    end associate
  end subroutine pose_at

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

  !> The sign of s where a point is.
  pure integer function outwards(p)
    type(point_type), intent(in) :: p

    outwards = merge(1, -1, p%half == 1)
  end function outwards

  !> The point nearest to the centre with the lateral displacement y, at a pose if that is within rounding of it; ok:
  !> the path goes so far.
  pure subroutine start_at(path, y, p, ok)
    type(path_type), intent(in) :: path(:)      !! to the left, to the right
    real(dp), intent(in) :: y
    type(point_type), intent(out) :: p
    logical, intent(out) :: ok
    real(dp) :: low, high, q(3), t(3)
    integer :: i, near, iter

    p%half = merge(2, 1, y < 0)
    associate (own => path(p%half))
      i = findloc(own%q(1, 2:own%n) >= abs(y), .true., 1)
      ok = i > 0
      if (.not. ok) return
      p%at = i
      low = own%s(i)
      high = own%s(i + 1)
    end associate
    do iter = 1, 60
      p%s = outwards(p)*(low + high)/2
      call pose_at(piece_at(path, p), p%s, q, t)
      if (abs(q(1)) < abs(y)) then
        low = abs(p%s)
      else
        high = abs(p%s)
      end if
    end do
    associate (ends => path(p%half)%s(i:i + 1))
      near = minloc(abs(ends - abs(p%s)), 1)
      if (abs(ends(near) - abs(p%s)) < 1e-12_dp) p%s = outwards(p)*ends(near)
    end associate
  end subroutine start_at

  !> One step dt, or less: up to the next pose of the path, beyond which V is another polynomial.  `corner`: that pose
  !> is a corner (-1, 1: towards, away from the centre) or, 2, the path's end.  `work` grows by that of the lateral
  !> force.
  pure subroutine advance_along(path, w, p, time, dt, work, corner)
    type(path_type), intent(in) :: path(:)      !! to the left, to the right
    type(wheelset_type), intent(in) :: w
    type(point_type), intent(inout) :: p
    real(dp), intent(inout) :: time, dt, work
    integer, intent(out) :: corner
    type(piece_type) :: piece
    type(point_type) :: new, beyond, turning
    real(dp) :: ends(2), done, rate, turn
    integer :: out

    corner = 0
    out = way_out(p)
    if (out /= 0) then
      new = p
      call pass(new, out, corner)
      beyond = new
      beyond%at = beyond%at + 2*mod(corner, 2)
      if (abs(p%v) <= 0 .and. corner < 2 .and. way_out(beyond) /= 0) then
        ! Pushed back from the other side as well: it stays.
        corner = 0
        time = time + dt
      else
        p = new
        dt = 0
      end if
      return
    end if
    piece = piece_at(path, p)
    ends = path(p%half)%s(p%at:p%at + 1)
    dt = time_to_end()
    call step(dt, new, done, rate)
    out = side_of(new)
    turn = 0
    if (p%v*new%v < 0) then
      turning = new
      turn = dt
      call find(0.0_dp, turn, turning, done, rate)
      if (side_of(turning) /= 0) then
        new = turning
        out = side_of(turning)
        dt = turn
        turn = 0
      else
        call step(dt, new, done, rate)
      end if
    end if
    if (out /= 0) then
      call find(turn, dt, new, done, rate, ends(merge(2, 1, out > 0)))
      new%s = outwards(p)*ends(merge(2, 1, out > 0))
      call pass(new, out, corner)
    end if
    p = new
    time = time + dt
    work = work + done

  contains

    !> A step h on the polynomial where p is; `rate`: the acceleration at its end.
    pure subroutine step(h, new, done, rate)
      real(dp), intent(in) :: h
      type(point_type), intent(out) :: new
      real(dp), intent(out) :: done, rate
      real(dp) :: q(3), t(3), y, f(3), now
      integer :: i

      new = p
      now = time
      done = 0
      call pose_at(piece, new%s, q, t)
      y = q(1)
      do i = 1, size(drift)
        f = external_force(w, now)
        new%v = new%v + kick(i)*h*sum(f*t)
        new%s = new%s + drift(i)*h*new%v
        call pose_at(piece, new%s, q, t)
        ! Time is a coordinate of the step like s: its momentum, the energy, grows by kicks.
        f = external_force(w, time + sum(kick(:i))*h)
        done = done + f(1)*(q(1) - y)
        y = q(1)
        now = now + drift(i)*h
      end do
      f = external_force(w, time + h)
      rate = sum(f*t)
      new%v = new%v + kick(size(kick))*h*rate
    end subroutine step

    !> Where a point is: before (-1), between (0) or after (1) the two poses.
    pure integer function side_of(x)
      type(point_type), intent(in) :: x

      side_of = merge(1, 0, outwards(x)*x%s > ends(2)) - merge(1, 0, outwards(x)*x%s < ends(1))
    end function side_of

    !> At which pose a point leaves at once: towards the centre (-1), away from it (1), none (0).
    pure integer function way_out(x)
      type(point_type), intent(in) :: x
      real(dp) :: q(3), t(3), along, r

      way_out = 0
      associate (s => path(x%half)%s)
        r = outwards(x)*x%s
        if (r > s(x%at) .and. r < s(x%at + 1)) return
        along = x%v
        if (abs(along) <= 0) then
          call pose_at(piece_at(path, x), x%s, q, t)
          along = sum(external_force(w, time)*t)
        end if
        along = outwards(x)*along
        if (r <= s(x%at) .and. along < 0) way_out = -1
        if (r >= s(x%at + 1) .and. along > 0) way_out = 1
      end associate
    end function way_out

    !> Over a pose: to the next polynomial, unless it is a corner or the end.
    pure subroutine pass(x, out, corner)
      type(point_type), intent(inout) :: x
      integer, intent(in) :: out                 !! -1 towards, 1 away from the centre
      integer, intent(out) :: corner

      corner = 0
      if (out < 0 .and. x%at == 1) then
        x%half = 3 - x%half
        return
      end if
      associate (own => path(x%half))
        if (out > 0 .and. x%at + 1 == own%n) then
          corner = 2
        else if (own%stretch(x%at + merge(2, -1, out > 0)) /= own%stretch(x%at)) then
          corner = out
        else
          x%at = x%at + out
        end if
      end associate
    end subroutine pass

    !> The time to the next pose by Taylor's formula, and a little, at most dt [s].
    pure real(dp) function time_to_end() result(h)
      real(dp) :: q(3), t(3), bend(3), f(3), r, v, a, growth, ahead, root, move

      call pose_at(piece, p%s, q, t)
      bend = (2*piece%power(:, 2) + 6*piece%power(:, 3)*(p%s - piece%s0)*piece%per_s)*piece%per_s**2
      f = external_force(w, time)
      r = outwards(p)*p%s
      v = outwards(p)*p%v
      a = outwards(p)*sum(f*t)
      growth = v*sum(f*bend)
      ahead = ends(2) - r
      if (v < 0 .or. v <= 0 .and. a < 0) then
        v = -v
        a = -a
        growth = -growth
        ahead = r - ends(1)
      end if
      root = v**2 + 2*a*ahead
      h = dt
      if (root < 0) then
        ! It turns before, and comes to the other one.
        ahead = ends(2) - ends(1) - ahead
        h = 1.02_dp*(v + sqrt(v**2 - 2*a*ahead))/(-a)
      else if (ahead < dt*(v + sqrt(root))) then
        h = 2*ahead/(v + sqrt(root))
        move = growth*h**3/6
        if (abs(move) < 0.3_dp*h*sqrt(root)) h = h - move/sqrt(root)
        h = 1.002_dp*h
      end if
      h = min(h, dt)
    end function time_to_end

    !> Cut the step h, at whose end `new`, `done` and `rate` are known, to where |s| passes `level` or, without it, the
    !> velocity turns, but not before `low`: Newton's method with second derivatives, bisection where that leaves.
    pure subroutine find(low, h, new, done, rate, level)
      real(dp), intent(in) :: low
      real(dp), intent(inout) :: h
      type(point_type), intent(inout) :: new
      real(dp), intent(inout) :: done, rate
      real(dp), intent(in), optional :: level
      real(dp) :: a, b, f, slope, beyond, small, move
      integer :: iter

      a = low
      b = h
      small = 1e-9_dp*max(abs(p%v), abs(new%v))
      if (present(level)) small = 4*epsilon(level)*ends(2)
      beyond = 0
      do iter = 1, 100
        f = new%v
        slope = rate
        if (present(level)) f = outwards(new)*new%s - level
        if (present(level)) slope = outwards(new)*new%v
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
          if (present(level)) move = -f/(slope + outwards(new)*rate*move/2)
          if (h + move <= a .or. h + move >= b) move = (a + b)/2 - h
        end if
        h = h + move
        call step(h, new, done, rate)
      end do
    end subroutine find

  end subroutine advance_along

  !> Over a corner: the contacts' impulses [N s], (contact), that turn the velocity.
  pure subroutine turn_corner(path, inertia, corner, p, impulse)
    type(path_type), intent(in) :: path(:)    !! to the left, to the right
    real(dp), intent(in) :: inertia(3)
    integer, intent(in) :: corner             !! of advance_along
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
      a(:, i) = c(i)%slope
    end do
    call eliminate(a, change, ok)
    if (p%half == 2) c%contact = mod(c%contact + 1, 4) + 1
    do i = 1, 3
      impulse(c(i)%contact) = impulse(c(i)%contact) + change(i)
    end do
  end subroutine turn_corner

  !> The three contacts of a corner whose first pose is i, in its half's own frame.
  pure function corner_contacts(own, i) result(c)
    type(path_type), intent(in) :: own
    integer, intent(in) :: i
    type(gap_type) :: c(3)
    integer :: wheel

    wheel = merge(1, 2, abs(own%c(1, i)%s - own%c(1, i + 1)%s) > 0)
    c = [own%c(wheel, i), own%c(wheel, i + 1), own%c(3 - wheel, i)]
  end function corner_contacts

  !> The first pose of the corner in which a point rests, pushed into it from both sides; 0: in none.
  pure integer function rests_in(path, w, p, time) result(i)
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
  end function rests_in

  !> Pose, velocity and contacts of a point, with the normal forces that keep both wheels on their rails; at rest in a
  !> corner all three contacts carry.
  pure subroutine path_state(path, side, w, p, time, q, v, state)
    type(path_type), intent(in) :: path(:)      !! to the left, to the right
    type(side_type), intent(in) :: side(:)      !! left, right
    type(wheelset_type), intent(in) :: w
    type(point_type), intent(inout) :: p
    real(dp), intent(in) :: time
    real(dp), intent(out) :: q(3), v(3)
    type(contact_state), intent(out) :: state
    type(gap_type) :: c(3)
    real(dp) :: t(3), force(3)
    integer :: k, n, corner
    logical :: ok

    call pose_at(piece_at(path, p), p%s, q, t)
    corner = rests_in(path, w, p, time)
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

  !> The lowest pose of the path that is downhill from the centre: there the wheelset stays.
  pure subroutine lowest_point(path, p, ok)
    type(path_type), intent(in) :: path(:)      !! to the left, to the right
    type(point_type), intent(out) :: p
    logical, intent(out) :: ok
    real(dp) :: low, high, q(3), t(3)
    integer :: i, iter

    p%half = merge(1, 2, path(1)%t(2, 1) < 0)
    associate (own => path(p%half))
      i = findloc(own%t(2, :own%n) >= 0, .true., 1)
      ok = i > 0
      if (i <= 1) return
      ! At a corner, or between poses.
      low = own%s(i - 1)
      high = own%s(i)
      p%at = merge(i - 1, i - 2, own%stretch(i - 1) == own%stretch(i))
    end associate
    do iter = 1, 60
      p%s = outwards(p)*(low + high)/2
      call pose_at(piece_at(path, p), p%s, q, t)
      ! In the half's own direction.
      if (outwards(p)*t(2) < 0) then
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
    call pose_at(piece_at(path, p), p%s, q, shape)
    c = path(p%half)%c(:, p%at)
    if (p%half == 2) c%wheel = 3 - c%wheel
    if (abs(p%s) > 0) then
      do k = 1, 2
        call find_gap(side, q, c(k))
      end do
    end if
    call closing_forces(w%inertia(), [0.0_dp, 0.0_dp, 0.0_dp], shape, c, force, ok)
    bend = w%weight()*sum(force*c%slope(2))/w%mass
    frequency = sign(sqrt(abs(bend)), bend)/(2*pi)
    associate (own => path(p%half))
      if (p%at + 1 < own%n .and. abs(p%s) >= own%s(p%at + 1)) then
        if (own%stretch(p%at + 2) /= own%stretch(p%at)) frequency = ieee_value(1.0_dp, ieee_quiet_nan)
      end if
    end associate
  end subroutine small_motion

end module rigid_path