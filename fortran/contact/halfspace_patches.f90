!> Half-spaces pressed together at a wheel and its rail, in one pose.
!>
!> The surface is developed into the plane (x rolling, s along the wheel).  The
!> interpenetration is that of the real profiles and of the wheel's circles: at x
!> the wheel's point is r - sqrt(r^2 - x^2) higher, and its depth is measured
!> along the rail's normal there.  All patches of a stretch of the wheel act on each other.
!>
!> Every patch has a grid that fits its pressed area.  It is looked for where the
!> undeformed bodies overlap: Hertz's ellipse has the shares f_x, f_s of the semi-axes of the
!> overlap with f_x^2 + f_s^2 = 1 (from K. L. Johnson, Contact Mechanics, 4.25-4.32), and
!> neighbouring poses nearly the same shares.
module halfspace_patches
  use curve, only: curve_point
  use station_scan, only: scan_type, set_depth
  use wheel_rail_pair, only: least_cosine, pair_type, rolled
  use halfspace, only: mesh_type, new_system, set_influence, solve_pressure, system_type
  use kinds, only: dp
  use patch_grids, only: carry, elements_type, fit_box, fit_mesh, guess, interpolate, look_beyond
  implicit none
  private
  public :: patches_type, press_patches, keep_patches, expect_area, pressed_area

  integer, parameter :: most_patches = 4

  !> The pressed patches of a pose; they start the search in the next one.
  type :: patches_type
    integer :: n = 0
    integer :: solutions = 0, iterations = 0   !! so far
    integer :: poses = 0, unsolved = 0         !! so far; poses whose pressures or grids did not converge
    real(dp) :: lap(2, most_patches) = 0       !! stretch of s in which the undeformed bodies overlap [m]
    real(dp) :: lap_x(most_patches) = 0        !! half its length along x [m]
    real(dp) :: deepest(most_patches) = 0      !! overlap [m]
    real(dp) :: box(3, most_patches) = 0       !! pressed: x, first and last s [m]
    type(mesh_type) :: mesh(most_patches)
    real(dp) :: expected(3) = -1               !! of a single patch, as `pressed_area`; or nothing is known
    real(dp), allocatable :: p(:, :, :)        !! pressures (nx, ns, patch) [Pa]
    type(system_type) :: system
  end type patches_type

contains

  !> Elastic energy [J] of the stations first..last of a scan and, if asked, the force of the rail on the
  !> wheel and its moment about the axle centre (F_y [N], F_z [N], M_x [N m]).  `ok` is false when the
  !> solution fails.
  pure subroutine press_patches(pair, elements, first, last, centre, roll, scan, patches, energy, ok, force)
    type(pair_type), intent(in) :: pair
    type(elements_type), intent(in) :: elements
    integer, intent(in) :: first, last
    real(dp), intent(in) :: centre(2), roll    !! of the axle [m, rad]
    type(scan_type), intent(in) :: scan        !! in this pose
    type(patches_type), intent(inout) :: patches   !! of a pose nearby, or new
    real(dp), intent(out) :: energy
    logical, intent(out) :: ok
    real(dp), intent(out), optional :: force(3)
    real(dp), parameter :: rough = 0.1_dp      ! tolerance while a patch is looked for
    integer, parameter :: most_rounds = 20
    ! Constant pressures on ns/4 by ns elements that fit half an ellipse overestimate energy and force by
    ! 0.8/ns^2, whatever its axis ratio from 1/20 to 20 (found on Hertz's).
    real(dp), parameter :: grid_error = 0.8_dp
    real(dp), dimension(elements%nx, elements%ns, most_patches) :: depth, p, r
    real(dp), dimension(2, elements%nx, elements%ns, most_patches) :: normal, point
    type(mesh_type) :: mesh(most_patches)
    integer :: n, g, round, iterations
    real(dp) :: box(3), self(most_patches)
    logical :: warm, known, fits

    energy = 0
    ok = .true.
    if (present(force)) force = 0
    call find_overlaps(pair, first, last, scan, patches, warm)
    n = patches%n
    if (n == 0) return
    if (n == 1 .and. patches%expected(1) > 0) then
      associate (lap => patches%lap(:, 1))
        patches%box(:, 1) = [patches%expected(1)*patches%lap_x(1), lap(1) + patches%expected(2:)*(lap(2) - lap(1))]
      end associate
    end if
    known = warm .or. (n == 1 .and. patches%expected(1) > 0)
    patches%expected = -1
    if (.not. allocated(patches%p)) then
      patches%system = new_system(elements%nx, elements%ns, most_patches)
      allocate (patches%p(elements%nx, elements%ns, most_patches))
    end if
    fits = .false.
    do round = 1, most_rounds
      do g = 1, n
        call fit_mesh(patches%box(:, g), patches%lap(:, g), elements, mesh(g))
        call interpolate(elements, mesh(g), patches%system%within(:, :, g), self(g))
        call set_depths(pair, first, last, centre, roll, scan, mesh(g), depth(:, :, g), normal(:, :, :, g), &
          point(:, :, :, g))
        if (warm .or. round > 1) then
          call carry(patches%mesh(g), patches%p(:, :, g), mesh(g), p(:, :, g))
        else
          call guess(patches%box(:, g), patches%deepest(g), mesh(g), p(:, :, g))
        end if
      end do
      call set_influence(mesh(:n), self(:n), elements%e_star, patches%system)
      associate (m => elements%nx*elements%ns)
        block
          real(dp) :: d2(m, n), p2(m, n), r2(m, n)
          d2 = reshape(depth(:, :, :n), [m, n])
          p2 = reshape(p(:, :, :n), [m, n])
          call solve_pressure(patches%system, d2, merge(elements%tolerance, max(rough, elements%tolerance), &
            known .or. round > 1), p2, r2, ok, iterations)
          p(:, :, :n) = reshape(p2, [elements%nx, elements%ns, n])
          r(:, :, :n) = reshape(r2, [elements%nx, elements%ns, n])
        end block
      end associate
      patches%solutions = patches%solutions + 1
      patches%iterations = patches%iterations + iterations
      patches%mesh(:n) = mesh(:n)
      patches%p(:, :, :n) = p(:, :, :n)
      fits = .false.
      if (.not. ok) exit
      fits = known .or. round > 1
      do g = 1, n
        call fit_box(elements, mesh(g), p(:, :, g), patches%lap(:, g), patches%box(:, g), round, box, fits)
        patches%box(:, g) = box
      end do
      if (fits) then
        do g = 1, n
          call look_beyond(pair, elements, scan, first, last, patches%lap(:, g), patches%deepest(g), mesh(:n), p(:, :, :n), g, &
            patches%box(:, g), fits)
        end do
      end if
      if (fits) exit
    end do
    patches%poses = patches%poses + 1
    if (.not. fits) patches%unsolved = patches%unsolved + 1
    do g = 1, n
      energy = energy + sum(p(:, :, g)*(depth(:, :, g) + r(:, :, g)))*mesh(g)%dx*mesh(g)%ds
      if (present(force)) force = force + 2*mesh(g)%dx*mesh(g)%ds*[sum(p(:, :, g)*normal(1, :, :, g)), &
        sum(p(:, :, g)*normal(2, :, :, g)), &
        sum(p(:, :, g)*(point(1, :, :, g)*normal(2, :, :, g) - point(2, :, :, g)*normal(1, :, :, g)))]
    end do
    energy = energy/(1 + grid_error/elements%ns**2)
    if (present(force)) force = force/(1 + grid_error/elements%ns**2)
  end subroutine press_patches

  !> The area that a single patch pressed last, as shares of its overlap: half its length along x, both ends along s;
  !> negative where there are several.
  pure function pressed_area(patches) result(area)
    type(patches_type), intent(in) :: patches
    real(dp) :: area(3)

    area = -1
    if (patches%n == 1) area = [patches%box(1, 1)/patches%lap_x(1), &
      (patches%box(2:, 1) - patches%lap(1, 1))/(patches%lap(2, 1) - patches%lap(1, 1))]
  end function pressed_area

  !> What the next pose is expected to press, found from poses around it: then it is likely to be solved at once.
  pure subroutine expect_area(patches, area)
    type(patches_type), intent(inout) :: patches
    real(dp), intent(in) :: area(3)        !! as `pressed_area`

    patches%expected = area
  end subroutine expect_area

  !> The patches of one pose as a start for others.
  pure subroutine keep_patches(from, to)
    type(patches_type), intent(in) :: from
    type(patches_type), intent(inout) :: to

    if (.not. allocated(from%p)) return
    if (.not. allocated(to%p)) then
      allocate (to%p, mold=from%p)
      to%system = new_system(size(from%p, 1), size(from%p, 2), most_patches)
    end if
    to%n = from%n
    to%lap(:, :to%n) = from%lap(:, :to%n)
    to%lap_x(:to%n) = from%lap_x(:to%n)
    to%deepest(:to%n) = from%deepest(:to%n)
    to%box(:, :to%n) = from%box(:, :to%n)
    to%mesh(:to%n) = from%mesh(:to%n)
    to%p(:, :, :to%n) = from%p(:, :, :to%n)
  end subroutine keep_patches

  !> Stretches in which the undeformed bodies overlap, and where they are expected to press each other;
  !> `warm`, when they are those of the last pose, moved.
  pure subroutine find_overlaps(pair, first, last, scan, patches, warm)
    type(pair_type), intent(in) :: pair
    integer, intent(in) :: first, last
    type(scan_type), intent(in) :: scan
    type(patches_type), intent(inout) :: patches
    logical, intent(out) :: warm
    real(dp) :: lap(2, most_patches), lap_x(most_patches), deepest(most_patches), station(most_patches), &
      tops(2, most_patches), stretch, bend(2), share(2), way
    integer :: i, n, from, least, node

    n = 0
    from = 0
    do i = first, last + 1
      if (i <= last) then
        if (scan%depth(i) > 0) then
          if (from == 0) from = i
          cycle
        end if
      end if
      if (from == 0) cycle
      if (n == most_patches) then
        ! The shallowest gives way.
        least = minloc(deepest, 1)
        if (maxval(scan%depth(from:i - 1)) <= deepest(least)) then
          from = 0
          cycle
        end if
        lap(:, least:n - 1) = lap(:, least + 1:n)
        lap_x(least:n - 1) = lap_x(least + 1:n)
        deepest(least:n - 1) = deepest(least + 1:n)
        station(least:n - 1) = station(least + 1:n)
        tops(:, least:n - 1) = tops(:, least + 1:n)
        n = n - 1
      end if
      n = n + 1
      node = from - 1 + maxloc(scan%depth(from:i - 1), 1)
      deepest(n) = scan%depth(node)
      station(n) = pair%s(node)
      ! Where the depth only grows, the station before the lap stands for the first top.
      tops(:, n) = pair%s([max(1, from - 1 + findloc(scan%depth(from:i - 2) > scan%depth(from + 1:i - 1), .true., 1)), &
        from + findloc(scan%depth(from:i - 2) < scan%depth(from + 1:i - 1), .true., 1, back=.true.)])
      if (i - from < 3) tops(:, n) = station(n)
      lap_x(n) = min(sqrt(2*deepest(n)*(-pair%r(2, node))/max(scan%normal(2, node), least_cosine)), -pair%r(2, node)/2)
      lap(:, n) = pair%s([from, i - 1])
      if (from > first) lap(1, n) = lap(1, n) - crossing(from, from - 1)
      if (i <= last) lap(2, n) = lap(2, n) + crossing(i - 1, i)
      from = 0
    end do
    warm = n > 0 .and. n == patches%n
    do i = 1, n
      if (.not. warm) exit
      ! The same patch overlaps its last place and is not of another size.
      warm = abs(sum(lap(:, i)) - sum(patches%lap(:, i))) < lap(2, i) - lap(1, i) &
        .and. deepest(i) < 4*patches%deepest(i) .and. patches%deepest(i) < 4*deepest(i)
    end do
    do i = 1, n
      if (warm) then
        stretch = (lap(2, i) - lap(1, i))/(patches%lap(2, i) - patches%lap(1, i))
        way = lap_x(i)/patches%lap_x(i)
        patches%box(:, i) = [patches%box(1, i)*way, lap(1, i) + (patches%box(2:3, i) - patches%lap(1, i))*stretch]
        patches%mesh(i)%low = lap(1, i) + (patches%mesh(i)%low - patches%lap(1, i))*stretch
        patches%mesh(i)%ds = patches%mesh(i)%ds*stretch
        patches%mesh(i)%dx = patches%mesh(i)%dx*way
        patches%p(:, :, i) = patches%p(:, :, i)*sqrt(deepest(i)/patches%deepest(i))
      else
        ! Of the overlap's ellipse; axis ratio of Hertz's as fitted by Brewe and Hamrock (1977).
        bend = [1/lap_x(i)**2, 4/(lap(2, i) - lap(1, i))**2]
        share = [bend(1)*(bend(2)/bend(1))**1.272_dp, bend(2)]
        share = sqrt(share/sum(share))
        patches%box(:, i) = [share(1)*lap_x(i), station(i) + share(2)*(lap(:, i) - station(i))]
        if (patches%box(2, i) >= patches%box(3, i)) patches%box(2:3, i) = lap(:, i)
      end if
      ! Two tops may be one patch or two.
      patches%box(2, i) = min(patches%box(2, i), (tops(1, i) + lap(1, i))/2)
      patches%box(3, i) = max(patches%box(3, i), (tops(2, i) + lap(2, i))/2)
    end do
    patches%n = n
    patches%lap = lap
    patches%lap_x = lap_x
    patches%deepest = deepest

  contains

    !> From an overlapping station to where the overlap ends before the next one.
    pure real(dp) function crossing(inside, beyond) result(way)
      integer, intent(in) :: inside, beyond

      way = abs(pair%s(beyond) - pair%s(inside))*scan%depth(inside)/(scan%depth(inside) - scan%depth(beyond))
    end function crossing

  end subroutine find_overlaps

  !> Undeformed interpenetration at the elements [m], the rail's normal there and the wheel's point from the
  !> axle centre, track frame.
  pure subroutine set_depths(pair, first, last, centre, roll, scan, mesh, depth, normal, point)
    type(pair_type), intent(in) :: pair
    integer, intent(in) :: first, last
    real(dp), intent(in) :: centre(2), roll
    type(scan_type), intent(in) :: scan
    type(mesh_type), intent(in) :: mesh
    real(dp), intent(out) :: depth(:, :), normal(:, :, :), point(:, :, :)
    real(dp), dimension(size(depth, 1)) :: foot, rate, step
    real(dp) :: s, x, r(2), d1(2), d2(2), base(2)
    integer :: interval(size(depth, 1)), i, j, k, node

    k = 1
    node = first
    do j = 1, size(depth, 2)
      s = mesh%low + (j - 0.5_dp)*mesh%ds
      call curve_point(pair%wheel, s, k, r, d1, d2)
      do while (node < last)
        if (pair%s(node + 1) > s) exit
        node = node + 1
      end do
      base = rolled(pair%r(:, node), roll)
      do i = 1, size(depth, 1)
        x = min((i - 0.5_dp)*mesh%dx, -r(2))
        point(:, i, j) = rolled([r(1), -sqrt(r(2)**2 - x**2)], roll)
        foot(i) = scan%foot(node) + ((point(1, i, j) - base(1))*scan%normal(2, node) &
          - (point(2, i, j) - base(2))*scan%normal(1, node))*scan%rate(node)
      end do
      interval = scan%interval(node)
      call set_depth(pair%rail, size(foot), spread(centre, 2, size(foot)) + point(:, :, j), foot, interval, &
        depth(:, j), normal(:, :, j), rate, step)
    end do
  end subroutine set_depths

end module halfspace_patches