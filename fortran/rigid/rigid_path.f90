!> The path of the poses in which both wheels stand on their rails, as in codes with a table of contact geometry.
!>
!> The constraints g_left(q) = g_right(q) = 0 leave one degree of freedom of q = (y, z, roll).  The coordinate of the
!> path is the arc length s in the kinetic metric, ds^2 = m dy^2 + m dz^2 + I droll^2.
!>
!> The path is followed from the centred wheelset by continuation: a step along the tangent, then back to both
!> rails across it.  The path need not be a function of y.  Where a wheel comes to touch at another point as well, the
!> path has a corner, and the contact goes over to that point.  Between its poses the path is the Hermite cubic.
module rigid_path
  use constraint_forces, only: close_gaps
  use contact_zones, only: side_type
  use gap_functions, only: contacts_type, find_gap, gap_type, new_contacts, tightest
  use kinds, only: dp
  use rival_points, only: search_rivals
  use root_bracket, only: bracket_type
  use text, only: str
  use wheel_rail_pair, only: mirror
  implicit none
  private
  public :: path_type, piece_type, follow_path, path_end, path_piece, evaluate_piece, tangent

  !> The path on the left of the centre.  The path on the right is that of the mirrored wheelset.
  type :: path_type
    integer :: n = 0                       !! number of poses; a corner is two of them
    real(dp), allocatable :: s(:)          !! arc length, (n) [m kg^1/2]
    real(dp), allocatable :: q(:, :)       !! poses, (3, n) y, z [m], roll [rad]
    real(dp), allocatable :: t(:, :)       !! tangents dq/ds, (3, n)
    integer, allocatable :: stretch(:)     !! number of the stretch between two corners that each pose belongs to, (n)
    type(gap_type), allocatable :: c(:, :) !! left and right contact at each pose, (2, n)
    real(dp) :: stuck = 0                  !! the step that failed at the end [m]; 0: the path goes all the way
  end type path_type

  !> The path between two poses: a polynomial of u = (s - s0)/length, 0 to 1.
  type :: piece_type
    real(dp) :: power(3, 0:3)              !! coefficients of y, z [m], roll [rad]
    real(dp) :: s0                         !! [m kg^1/2]
    real(dp) :: per_s                      !! 1/length, negative to the right of the centre
  end type piece_type

  !> A pose on the path; the components are those of path_type.
  type :: pose_type
    real(dp) :: s = 0, q(3) = 0, t(3) = 0
    integer :: stretch = 1
    type(gap_type) :: c(2)
  end type pose_type

  real(dp), parameter :: accuracy = 1e-12_dp   ! distance between cubic and path, at most [m]
  real(dp), parameter :: longest = 1e-4_dp     ! longest step [m]
  real(dp), parameter :: first_step = 1e-5_dp  ! step at the centre and after a corner [m]
  real(dp), parameter :: shortest = 1e-9_dp    ! shortest step; where it fails, the path ends [m]
  integer, parameter :: most_poses = 100000

contains

  !> Follow the path to the left, until the flange's tip is past `beyond` and above the rail, or to an end of the path.
  subroutine follow_path(side, start, inertia, beyond, path)
    type(side_type), intent(in) :: side(:)      !! left, right
    real(dp), intent(in) :: start(3)            !! pose at the centre: y, z [m], roll [rad]
    real(dp), intent(in) :: inertia(3)          !! diagonal of the mass matrix
    real(dp), intent(in) :: beyond              !! lateral displacement at which the path may end [m]
    type(path_type), intent(out) :: path
    type(contacts_type) :: contacts
    type(pose_type), allocatable :: list(:)
    type(pose_type) :: here, next
    type(gap_type) :: left_behind
    real(dp) :: h, scale, error
    integer :: k(2), wheel, n, i
    logical :: ok

    scale = sqrt(inertia(1))
    contacts = new_contacts(side)
    here%q = start
    call search_rivals(side, here%q, spread(.false., 1, size(contacts%c)), contacts)
    k = [tightest(contacts, 1), tightest(contacts, 2)]
    here%c = contacts%c(k)
    call close_gaps(side, inertia, here%c, here%q, ok)
    here%t = tangent(inertia, here%c, [1.0_dp, 0.0_dp, 0.0_dp])
    allocate (list(1024))
    n = 0
    call append(list, n, here)
    h = first_step*scale
    do while (ok .and. here%q(1) < beyond .and. abs(here%q(3)) < 1.0_dp)
      call smooth_step(side, inertia, here, h, next, error, ok)
      if (.not. ok) exit
      call find_corner(side, inertia, here, contacts, k, h, next, wheel, ok)
      if (.not. ok) exit
      here = next
      call append(list, n, here)
      if (wheel > 0) then
        left_behind = here%c(wheel)
        here%c(wheel) = contacts%c(k(wheel))
        call find_gap(side, here%q, here%c(wheel))
        ! The path goes on to where the point that touched so far opens.
        here%t = tangent(inertia, here%c, here%t)
        if (dot_product(here%t, left_behind%gradient) < 0) here%t = -here%t
        here%stretch = here%stretch + 1
        call append(list, n, here)
        h = first_step*scale
      else
        h = min(1.5_dp*h, longest*scale, h*max(0.5_dp, 0.8_dp*sqrt(sqrt(accuracy/max(error, 1e-16_dp)))))
      end if
      if (n > most_poses) ok = .false.
    end do
    if (.not. ok .or. here%q(1) < beyond) path%stuck = h/scale

    path%n = n
    path%s = list(:n)%s
    path%stretch = list(:n)%stretch
    allocate (path%q(3, n), path%t(3, n), path%c(2, n))
    do i = 1, n
      path%q(:, i) = list(i)%q
      path%t(:, i) = list(i)%t
      path%c(:, i) = list(i)%c
    end do
  end subroutine follow_path

  !> Add a pose to a list of n poses, which grows as needed.
  subroutine append(list, n, pose)
    type(pose_type), allocatable, intent(inout) :: list(:)
    integer, intent(inout) :: n
    type(pose_type), intent(in) :: pose

    if (n == size(list)) list = [list, list]
    n = n + 1
    list(n) = pose
  end subroutine append

  !> A step so short that the Hermite cubic follows the path; h is halved until it does.  `ok` is false if no step does.
  subroutine smooth_step(side, inertia, here, h, next, error, ok)
    type(side_type), intent(in) :: side(:)
    real(dp), intent(in) :: inertia(3)
    type(pose_type), intent(in) :: here
    real(dp), intent(inout) :: h                !! along the tangent [m kg^1/2]
    type(pose_type), intent(out) :: next
    real(dp), intent(out) :: error              !! distance between cubic and path at most [m]
    logical, intent(out) :: ok
    type(pose_type) :: middle
    real(dp) :: length

    error = huge(error)
    do
      call step(side, inertia, here, h, next, ok)
      if (ok) call step(side, inertia, here, h/2, middle, ok)
      if (ok) then
        next%t = tangent(inertia, next%c, here%t)
        length = arc_length(inertia, here%q, middle%q, next%q)
        error = max(miss(inertia, here, next, length, middle), miss_at(0.25_dp), miss_at(0.75_dp))
        next%s = here%s + length
        if (error < accuracy) return
      end if
      h = h/2
      ok = .false.
      if (h < shortest*sqrt(inertia(1))) return
    end do

  contains

    !> Distance between cubic and path at a share of the step [m].
    real(dp) function miss_at(share)
      real(dp), intent(in) :: share
      type(pose_type) :: there
      logical :: found

      call step(side, inertia, here, share*h, there, found)
      miss_at = huge(share)
      if (found) miss_at = miss(inertia, here, next, length, there)
    end function miss_at

  end subroutine smooth_step

  !> Cut the step to `next` to where another point of a wheel comes to touch the rail, if one does: the path has a corner
  !> there, and k becomes the index of that point.
  subroutine find_corner(side, inertia, here, contacts, k, h, next, wheel, ok)
    type(side_type), intent(in) :: side(:)
    real(dp), intent(in) :: inertia(3)
    type(pose_type), intent(in) :: here
    type(contacts_type), intent(inout) :: contacts
    integer, intent(inout) :: k(2)              !! indices of the left and right contact
    real(dp), intent(inout) :: h                !! the step [m kg^1/2]
    type(pose_type), intent(inout) :: next
    integer, intent(out) :: wheel               !! the wheel that has the corner, 0: none
    logical, intent(out) :: ok                  !! it is false where a step to the corner fails
    logical :: closed(size(contacts%c))
    type(bracket_type) :: range
    type(pose_type) :: middle
    real(dp) :: gap
    integer :: other, iter

    ok = .true.
    contacts%c(k) = next%c
    closed = .false.
    closed(k) = .true.
    call search_rivals(side, next%q, closed, contacts)
    do wheel = 1, 2
      other = tightest(contacts, wheel)
      if (other == k(wheel) .or. contacts%c(other)%gap > 0) cycle
      gap = gap_at(here%q)
      if (gap >= 1e-13_dp) exit
    end do
    if (wheel > 2) then
      wheel = 0
      return
    end if
    range = bracket_type(0.0_dp, gap, h, contacts%c(other)%gap)
    do iter = 1, 100
      h = range%guess()
      call step(side, inertia, here, h, next, ok)
      if (.not. ok) return
      gap = gap_at(next%q)
      if (abs(gap) < 1e-15_dp .or. abs(range%b - range%a) < 1e-15_dp*sqrt(inertia(1))) exit
      call range%narrow(h, gap)
    end do
    k(wheel) = other
    call step(side, inertia, here, h/2, middle, ok)
    next%t = tangent(inertia, next%c, here%t)
    next%s = here%s + arc_length(inertia, here%q, middle%q, next%q)

  contains

    !> Gap of the other point at the pose x [m].
    real(dp) function gap_at(x) result(gap)
      real(dp), intent(in) :: x(3)
      type(gap_type) :: point

      point = contacts%c(other)
      call find_gap(side, x, point)
      gap = point%gap
    end function gap_at

  end subroutine find_corner

  !> Go from `here` along the tangent by h, then back to both rails across it.  This sets the pose and the contacts of `there`.
  subroutine step(side, inertia, here, h, there, ok)
    type(side_type), intent(in) :: side(:)
    real(dp), intent(in) :: inertia(3)
    type(pose_type), intent(in) :: here
    real(dp), intent(in) :: h                   !! [m kg^1/2]
    type(pose_type), intent(out) :: there
    logical, intent(out) :: ok                  !! it is false where no pose on both rails is near or a zone ends

    there = here
    there%q = here%q + h*here%t
    call close_gaps(side, inertia, there%c, there%q, ok)
    if (ok) ok = kinetic_norm(inertia, there%q - here%q - h*here%t) < 0.3_dp*abs(h) &
      .and. .not. any(there%c%edge .and. .not. there%c%rim)
  end subroutine step

  !> Distance at which the cubic from `here` to `next` passes a pose of the path [m].
  pure real(dp) function miss(inertia, here, next, length, pose)
    real(dp), intent(in) :: inertia(3)
    type(pose_type), intent(in) :: here, next, pose
    real(dp), intent(in) :: length              !! arc length from `here` to `next` [m kg^1/2]
    type(piece_type) :: piece
    real(dp) :: ahead(3), d(3), at(3), slope(3), s
    integer :: i

    ahead = tangent(inertia, pose%c, here%t)
    piece = hermite(here%q, here%t, next%q, next%t, 0.0_dp, length)
    s = length*sum(inertia*here%t*(pose%q - here%q))/sum(inertia*here%t*(next%q - here%q))
    do i = 1, 4
      call evaluate_piece(piece, s, at, slope)
      d = pose%q - at
      s = s + sum(inertia*ahead*d)
    end do
    miss = kinetic_norm(inertia, d - ahead*sum(inertia*ahead*d))/sqrt(inertia(1))
  end function miss

  !> Length of a vector in the kinetic metric.
  pure real(dp) function kinetic_norm(inertia, x)
    real(dp), intent(in) :: inertia(3), x(3)

    kinetic_norm = sqrt(sum(inertia*x**2))
  end function kinetic_norm

  !> Arc length through three poses, the middle one half way: chords, extrapolated.
  pure real(dp) function arc_length(inertia, a, b, c)
    real(dp), intent(in) :: inertia(3), a(3), b(3), c(3)
    real(dp) :: chords

    chords = kinetic_norm(inertia, b - a) + kinetic_norm(inertia, c - b)
    arc_length = chords + (chords - kinetic_norm(inertia, c - a))/3
  end function arc_length

  !> Unit tangent dq/ds of the path at two contacts, on the side of `ahead`.
  pure function tangent(inertia, c, ahead) result(t)
    real(dp), intent(in) :: inertia(3)          !! diagonal of the mass matrix
    type(gap_type), intent(in) :: c(2)
    real(dp), intent(in) :: ahead(3)
    real(dp) :: t(3)

    associate (a => c(1)%gradient, b => c(2)%gradient)
      t = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
    end associate
    t = t/sqrt(sum(inertia*t**2))
    if (sum(inertia*t*ahead) < 0) t = -t
  end function tangent

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

  !> The cubic between the poses i and i + 1.
  pure function path_piece(path, i) result(piece)
    type(path_type), intent(in) :: path
    integer, intent(in) :: i
    type(piece_type) :: piece

    piece = hermite(path%q(:, i), path%t(:, i), path%q(:, i + 1), path%t(:, i + 1), path%s(i), path%s(i + 1) - path%s(i))
  end function path_piece

  !> Pose q (y, z [m], roll [rad]) and tangent t = dq/ds of a piece at the arc length s.
  pure subroutine evaluate_piece(piece, s, q, t)
    type(piece_type), intent(in) :: piece
    real(dp), intent(in) :: s                   !! [m kg^1/2]
    real(dp), intent(out) :: q(3), t(3)
    real(dp) :: u

    u = (s - piece%s0)*piece%per_s
    associate (a => piece%power(:, 0), b => piece%power(:, 1), c => piece%power(:, 2), d => piece%power(:, 3))
      q = a + u*(b + u*(c + u*d))
      t = (b + u*(2*c + u*(3*d)))*piece%per_s
    end associate
  end subroutine evaluate_piece

  !> Say in words where the path ends on one side of the centre, and why.
  function path_end(path, left, equilibrium) result(words)
    type(path_type), intent(in) :: path(:)      !! to the left, to the right
    logical, intent(in) :: left
    real(dp), intent(in) :: equilibrium(3)      !! the pose that Z and roll are relative to: y, z [m], roll [rad]
    character(200) :: words
    real(dp) :: q(3)

    associate (p => path(merge(1, 2, left)))
      q = merge(p%q(:, p%n), mirror*p%q(:, p%n), left) - equilibrium
      words = 'Y = '//str(q(1))//' m, Z = '//str(q(2))//' m, roll = '//str(q(3))//' rad, where no step of '// &
        str(p%stuck)//' m keeps both wheels on their rails'
    end associate
  end function path_end

end module rigid_path
