!> Half-spaces pressed together at a wheel and its rail, in one pose.
!>
!> The surface is developed into the plane (x rolling, s along the wheel). The interpenetration is that of the real
!> profiles and of the wheel's circles: at x the wheel's point is r - sqrt(r^2 - x^2) higher, and its depth is measured
!> along the rail's normal there. All elements of a stretch of the wheel are one elastic system, and the wheel's own
!> normals enter its influence, which does not depend on the pose: so the force is the exact gradient of the energy.
!>
!> Every patch has a grid that fits its pressed area. The pressed area is looked for where the undeformed bodies
!> overlap: Hertz's ellipse has the shares f_x, f_s of the semi-axes of the overlap with f_x^2 + f_s^2 = 1 (from
!> K. L. Johnson, Contact Mechanics, 4.25-4.32).
module halfspace_patches
  use body_influence, only: add_bodies
  use curve, only: curve_point
  use halfspace, only: displace, mesh_type, set_influence, solve_loads
  use kinds, only: dp
  use patch_grids, only: displacement, elements_type, fit_box, fit_mesh, guess_loads, look_beyond
  use patch_overlaps, only: expected_area, find_overlaps, most_patches, moved_area, overlaps_type, same_overlap
  use station_scan, only: scan_type, set_depth
  use wheel_rail_pair, only: pair_type, rolled
  implicit none
  private
  public :: patches_type, press_patches, force_between, influence_between

  !> The pressed patches of a pose.
  type :: patches_type
    integer :: n = 0
    logical :: ok = .true.                     !! whether loads and grids converged
    real(dp) :: energy = 0                     !! [J]
    type(overlaps_type) :: overlaps            !! one for every patch
    real(dp) :: box(3, most_patches) = 0       !! pressed area: half of its length along x, first and last s [m]
    type(mesh_type) :: mesh(most_patches)
    real(dp), allocatable :: f(:, :, :)        !! loads of the elements at x > 0, (nx, ns, patch) [N]
    real(dp), allocatable :: r(:, :, :)        !! interpenetration that the loads leave, (nx, ns, patch) [m]
    real(dp), allocatable :: influence(:, :)   !! of the elements on each other, see `set_influence` [m/N]
    real(dp), allocatable :: angle(:, :)       !! of the wheel's tangent, wheelset frame, (ns, patch) [rad]
    real(dp), allocatable :: foot(:, :)        !! stations of the rail below the rows of elements, (ns, patch) [m]
    real(dp), allocatable :: normal(:, :, :, :), point(:, :, :, :)   !! of the rail, of the wheel; see `set_depths`
  end type patches_type

  ! Constant pressures on ns/4 by ns elements that fit half an ellipse overestimate energy and force by
  ! 1.12/ns^2 (found on Hertz's ellipses with axis ratios from 1/20 to 20).
  real(dp), parameter :: grid_error = 1.12_dp
  integer, parameter :: coarse_x = 3, coarse_s = 14, most_rounds = 20
  real(dp), parameter :: coarse_tolerance = 2e-2_dp
  ! Coarse grids find ellipses a little too long. The true semi-axes along x, before and behind the centre are these shares.
  real(dp), parameter :: coarse_axes(3) = [0.973_dp, 0.984_dp, 0.984_dp]

contains

  !> Press the stations first..last of a scan into the rail: the pressed areas are found on coarse grids, or have the same shares
  !> of their overlaps as in a pose nearby.
  pure subroutine press_patches(pair, elements, first, last, centre, roll, scan, patches, nearby)
    type(pair_type), intent(in) :: pair
    type(elements_type), intent(in) :: elements
    integer, intent(in) :: first, last
    real(dp), intent(in) :: centre(2), roll    !! position and roll angle of the axle [m, rad]
    type(scan_type), intent(in) :: scan        !! depths in this pose
    type(patches_type), intent(out) :: patches
    type(patches_type), intent(in), optional :: nearby
    type(elements_type) :: coarse, fine
    real(dp) :: stretch(3, most_patches), box(3)
    integer :: g, round
    logical :: cut, fits, moved

    call find_overlaps(pair, first, last, scan, patches%overlaps)
    patches%n = patches%overlaps%n
    if (patches%n == 0) return
    fine = elements
    if (present(nearby)) then
      if (allocated(nearby%f)) fine%ns = size(nearby%f, 2)
      call move_patches(nearby, patches)
      call press_grids(pair, fine, first, last, centre, roll, scan, patches)
      return
    end if
    do g = 1, patches%n
      patches%box(:, g) = expected_area(patches%overlaps%list(g))
    end do
    stretch = spread(coarse_axes, 2, most_patches)
    coarse = elements_type(coarse_x, coarse_s, coarse_tolerance, elements%e_star, elements%flat)
    do round = 1, most_rounds
      call press_grids(pair, coarse, first, last, centre, roll, scan, patches)
      fits = patches%ok
      do g = 1, patches%n
        call fit_box(coarse, patches%mesh(g), patches%f(:, :, g), patches%overlaps%list(g)%ends, patches%box(:, g), &
          stretch(:, g), cut, moved)
        fits = fits .and. .not. (cut .or. moved)
      end do
      if (.not. fits) cycle
      do g = 1, patches%n
        call look_beyond(pair, coarse, scan, first, last, patches%overlaps%list(g)%ends, patches%overlaps%list(g)%depth, &
          patches%mesh(:patches%n), patches%angle, patches%foot, patches%f, g, patches%box(:, g), stretch(:, g), fits)
      end do
      if (fits) exit
    end do
    if (elements%doubled .and. any([(has_gap(any(patches%f(:, :, g) > 0, 1)), g=1, patches%n)])) fine%ns = 2*elements%ns
    do round = 1, most_rounds
      call press_grids(pair, fine, first, last, centre, roll, scan, patches)
      fits = .true.
      do g = 1, patches%n
        box = patches%box(:, g)
        call fit_box(fine, patches%mesh(g), patches%f(:, :, g), patches%overlaps%list(g)%ends, box, &
          stretch(:, g), cut, moved)
        if (cut) patches%box(:, g) = box
        fits = fits .and. .not. cut
      end do
      if (fits) exit
    end do
    patches%ok = patches%ok .and. fits
  end subroutine press_patches

  !> Whether there are rows without loads between loaded ones.
  pure logical function has_gap(loaded)
    logical, intent(in) :: loaded(:)

    has_gap = findloc(loaded, .true., 1, back=.true.) - findloc(loaded, .true., 1) >= max(1, count(loaded))
  end function has_gap

  !> Take the patches of a pose nearby, with the same shares of their overlaps, or in the same place if overlaps have met or parted.
  pure subroutine move_patches(nearby, patches)
    type(patches_type), intent(in) :: nearby
    type(patches_type), intent(inout) :: patches   !! with the overlaps of the new pose
    type(overlaps_type) :: new
    integer :: g, k

    new = patches%overlaps
    patches%n = nearby%n
    patches%overlaps = nearby%overlaps
    patches%box = nearby%box
    do g = 1, nearby%n
      do k = 1, new%n
        if (.not. same_overlap(nearby%overlaps%list(g), new%list(k))) cycle
        patches%box(:, g) = moved_area(nearby%box(:, g), nearby%overlaps%list(g), new%list(k))
        patches%overlaps%list(g) = new%list(k)
      end do
    end do
  end subroutine move_patches

  !> Press the wheel with one grid on each pressed area.
  pure subroutine press_grids(pair, elements, first, last, centre, roll, scan, patches)
    type(pair_type), intent(in) :: pair
    type(elements_type), intent(in) :: elements
    integer, intent(in) :: first, last
    real(dp), intent(in) :: centre(2), roll
    type(scan_type), intent(in) :: scan
    type(patches_type), intent(inout) :: patches
    real(dp) :: depth(elements%nx, elements%ns, patches%n), share
    integer :: g

    if (allocated(patches%f)) then
      if (size(patches%f) /= size(depth)) then
        deallocate (patches%f, patches%r, patches%influence, patches%angle, patches%foot, patches%normal, patches%point)
      end if
    end if
    if (.not. allocated(patches%f)) then
      allocate (patches%f, patches%r, mold=depth)
      allocate (patches%influence(size(depth), size(depth)), patches%angle(elements%ns, patches%n), &
        patches%foot(elements%ns, patches%n))
      allocate (patches%normal(2, elements%nx, elements%ns, patches%n), patches%point(2, elements%nx, elements%ns, patches%n))
    end if
    do g = 1, patches%n
      call fit_mesh(patches%box(:, g), patches%overlaps%list(g)%ends, elements, patches%mesh(g))
      call set_depths(pair, first, last, centre, roll, scan, patches%mesh(g), depth(:, :, g), patches%normal(:, :, :, g), &
        patches%point(:, :, :, g), patches%angle(:, g), patches%foot(:, g))
      call guess_loads(patches%box(:, g), patches%overlaps%list(g)%depth, patches%mesh(g), patches%f(:, :, g))
    end do
    call set_influence(elements%nx, elements%ns, patches%mesh(:patches%n), merge(0.0_dp, patches%angle, elements%flat), &
      elements%e_star, patches%influence)
    if (allocated(pair%bodies)) call add_bodies(pair%bodies, elements%nx, elements%ns, patches%mesh(:patches%n), patches%angle, &
      patches%foot, elements%e_star, patches%influence)
    call solve_flat(patches%influence, depth, elements%tolerance, patches%f, patches%r, patches%ok)
    share = 1/(1 + grid_error/elements%ns**2)
    patches%energy = sum(patches%f*(depth + patches%r))*share
    patches%f = patches%f*share
  end subroutine press_grids

  !> `solve_loads` for loads by grid.
  pure subroutine solve_flat(A, depth, tolerance, f, r, ok)
    real(dp), intent(in), contiguous :: A(:, :)
    real(dp), intent(in) :: depth(size(A, 1)), tolerance
    real(dp), intent(inout) :: f(size(A, 1))
    real(dp), intent(out) :: r(size(A, 1))
    logical, intent(out) :: ok
    integer :: iterations

    call solve_loads(A, depth, tolerance, f, r, ok, iterations)
  end subroutine solve_flat

  !> Force of the rail on the wheel by the loads between two s, and its moment about the axle centre (F_y [N], F_z [N],
  !> M_x [N m]).
  pure function force_between(patches, low, high) result(force)
    type(patches_type), intent(in) :: patches
    real(dp), intent(in) :: low, high          !! [m]
    real(dp) :: force(3), s
    integer :: g, j

    force = 0
    do g = 1, patches%n
      do j = 1, size(patches%f, 2)
        s = patches%mesh(g)%low + (j - 0.5_dp)*patches%mesh(g)%ds
        if (s < low .or. s >= high) cycle
        associate (f => patches%f(:, j, g), n => patches%normal(:, :, j, g), x => patches%point(:, :, j, g))
          force = force + 2*[sum(f*n(1, :)), sum(f*n(2, :)), sum(f*(x(1, :)*n(2, :) - x(2, :)*n(1, :)))]
        end associate
      end do
    end do
  end function force_between

  !> Mean influence of the loads of two stretches on each other [m/N]: the displacement of one by the other, weighted with its
  !> own loads. If one stretch has no loads, it is that on the point that is nearest to touching. It is 0 if neither has
  !> loads.
  pure subroutine influence_between(pair, elements, scan, patches, first, last, influence, load, angle)
    type(pair_type), intent(in) :: pair
    type(elements_type), intent(in) :: elements
    type(scan_type), intent(in) :: scan        !! depths in this pose
    type(patches_type), intent(in) :: patches
    integer, intent(in) :: first(2), last(2)   !! stations of both stretches
    real(dp), intent(out) :: influence, load(2)   !! [m/N]; sums of the loads [N]
    real(dp), intent(out) :: angle             !! of the wheel's tangent at the nearest point [rad]
    logical :: inside(size(patches%influence, 1), 2)
    real(dp), dimension(size(patches%influence, 1)) :: f, r, displaced
    type(elements_type) :: own                 ! with the rows of these grids
    integer :: k, loaded, free

    own = elements
    own%ns = size(patches%f, 2)
    f = reshape(patches%f, [size(f)])
    r = reshape(patches%r, [size(f)])
    do k = 1, 2
      inside(:, k) = elements_between(own, patches, pair%s(first(k)), pair%s(last(k)))
      load(k) = 2*sum(f, inside(:, k))
    end do
    influence = 0
    angle = 0
    if (all(load <= 0)) return
    if (all(load > 0)) then
      call displace(patches%influence, merge(f, 0.0_dp, inside(:, 2)), displaced)
      influence = 2*dot_product(merge(f, 0.0_dp, inside(:, 1)), displaced)/product(load)
      return
    end if
    loaded = maxloc(load, 1)
    free = 3 - loaded
    call nearest_point(pair, own, scan, patches, first(free), last(free), inside(:, free), &
      merge(f, 0.0_dp, inside(:, loaded)), r, influence, angle)
    influence = influence/load(loaded)
  end subroutine influence_between

  !> Displacement [m] by the loads f, of those of all patches, at the point of a stretch without loads that is nearest to
  !> touching, and the angle of the wheel's tangent there.
  pure subroutine nearest_point(pair, elements, scan, patches, first, last, inside, f, r, displaced, angle)
    type(pair_type), intent(in) :: pair
    type(elements_type), intent(in) :: elements
    type(scan_type), intent(in) :: scan
    type(patches_type), intent(in) :: patches
    integer, intent(in) :: first, last
    logical, intent(in) :: inside(:)           !! elements of the stretch
    real(dp), intent(in) :: f(:), r(:)
    real(dp), intent(out) :: displaced, angle
    real(dp), parameter :: shallower = 0.5_dp  ! candidates are at most so much less deep, relative to all loads' largest overlap
    integer, parameter :: looks = 24           ! stations that are looked at, about
    real(dp) :: gap, least_gap, overlap, low, high
    integer :: i, g, j, step
    logical :: wanted(last - first + 1)

    displaced = 0
    angle = 0
    least_gap = huge(gap)
    if (any(inside)) then
      i = maxloc(r, 1, inside)
      least_gap = -r(i)
      displaced = dot_product(patches%influence(:, i), f)
      j = (i - 1)/elements%nx
      angle = patches%angle(1 + mod(j, elements%ns), 1 + j/elements%ns)
    end if
    overlap = maxval(patches%overlaps%list(:patches%n)%depth)
    wanted = scan%depth(first:last) > maxval(scan%depth(first:last)) - shallower*overlap
    step = max(1, count(wanted)/looks)
    do i = first + step/2, last, step
      if (.not. wanted(i - first + 1)) cycle
      do g = 1, patches%n
        low = patches%mesh(g)%low
        high = low + elements%ns*patches%mesh(g)%ds
        if (pair%s(i) > low .and. pair%s(i) < high) exit
      end do
      ! A station on a grid is one of its elements.
      if (g <= patches%n) cycle
      gap = displacement(pair, elements, patches%mesh(:patches%n), patches%angle, patches%foot, patches%f, pair%s(i), &
        pair%angle(i), scan%foot(i)) - scan%depth(i)
      if (gap >= least_gap) cycle
      least_gap = gap
      angle = pair%angle(i)
      displaced = displacement(pair, elements, patches%mesh(:patches%n), patches%angle, patches%foot, &
        reshape(f, shape(patches%f)), pair%s(i), pair%angle(i), scan%foot(i))
    end do
  end subroutine nearest_point

  !> Which elements lie between two s, as a list.
  pure function elements_between(elements, patches, low, high) result(inside)
    type(elements_type), intent(in) :: elements
    type(patches_type), intent(in) :: patches
    real(dp), intent(in) :: low, high          !! [m]
    logical :: inside(elements%nx*elements%ns*patches%n)
    real(dp) :: s
    integer :: g, j, k

    do g = 1, patches%n
      do j = 1, elements%ns
        s = patches%mesh(g)%low + (j - 0.5_dp)*patches%mesh(g)%ds
        k = elements%nx*(j - 1 + elements%ns*(g - 1))
        inside(k + 1:k + elements%nx) = s >= low .and. s < high
      end do
    end do
  end function elements_between

  !> At the elements of a grid: the undeformed interpenetration [m], the rail's normal, the wheel's point relative
  !> to the axle centre, track frame [m]; of the rows: the angle of the wheel's tangent, wheelset frame [rad], and the station of
  !> the rail below [m].
  pure subroutine set_depths(pair, first, last, centre, roll, scan, mesh, depth, normal, point, angle, rail_station)
    type(pair_type), intent(in) :: pair
    integer, intent(in) :: first, last
    real(dp), intent(in) :: centre(2), roll
    type(scan_type), intent(in) :: scan
    type(mesh_type), intent(in) :: mesh
    real(dp), intent(out) :: depth(:, :), normal(:, :, :), point(:, :, :), angle(:), rail_station(:)
    real(dp), dimension(size(depth, 1)) :: foot, rate, step
    real(dp) :: s, x, r(2), d1(2), d2(2), base(2)
    integer :: interval(size(depth, 1)), i, j, k, node

    k = 1
    node = first
    do j = 1, size(depth, 2)
      s = mesh%low + (j - 0.5_dp)*mesh%ds
      call curve_point(pair%wheel, s, k, r, d1, d2)
      angle(j) = atan2(d1(2), d1(1))
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
      rail_station(j) = foot(1)
    end do
  end subroutine set_depths

end module halfspace_patches
