!> Half-spaces pressed together at a wheel and its rail, in one pose.
!>
!> The surface is developed into the plane (x rolling, s along the wheel).  The interpenetration is that of the real
!> profiles and of the wheel's circles: at x the wheel's point is r - sqrt(r^2 - x^2) higher, and its depth is measured
!> along the rail's normal there.  All patches of a stretch of the wheel act on each other.
!>
!> Every patch has a grid that fits its pressed area.  The pressed area is looked for where the undeformed bodies
!> overlap: Hertz's ellipse has the shares f_x, f_s of the semi-axes of the overlap with f_x^2 + f_s^2 = 1 (from
!> K. L. Johnson, Contact Mechanics, 4.25-4.32), and neighbouring poses have nearly the same shares.
module halfspace_patches
  use curve, only: curve_point
  use halfspace, only: mesh_type, new_system, set_influence, solve_pressure, system_type
  use kinds, only: dp
  use patch_grids, only: carry_pressures, elements_type, fit_box, fit_mesh, guess_pressures, interpolate_influence, &
    look_beyond
  use patch_overlaps, only: expected_area, find_overlaps, most_patches, near_overlaps, overlap_type, overlaps_type
  use station_scan, only: scan_type, set_depth
  use wheel_rail_pair, only: pair_type, rolled
  implicit none
  private
  public :: patches_type, press_patches, keep_patches, pressed_area

  !> The pressed patches of a pose.  They start the search in the next pose.
  type :: patches_type
    integer :: n = 0
    integer :: solutions = 0, iterations = 0   !! counted over all poses so far
    integer :: poses = 0, unsolved = 0         !! poses so far; poses whose pressures or grids did not converge
    type(overlaps_type) :: overlaps            !! one for every patch
    real(dp) :: box(3, most_patches) = 0       !! pressed area: half of its length along x, first and last s [m]
    type(mesh_type) :: mesh(most_patches)
    !> The area that the next pose is expected to press, in the shares of `pressed_area`; negative if it is not known.  A pose
    !> whose area is known, from poses around it, is likely to be solved in the first round.
    real(dp) :: expected(3) = -1
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
    real(dp), intent(in) :: centre(2), roll    !! position and roll angle of the axle [m, rad]
    type(scan_type), intent(in) :: scan        !! depths in this pose
    type(patches_type), intent(inout) :: patches   !! patches of a pose nearby, or new ones
    real(dp), intent(out) :: energy
    logical, intent(out) :: ok
    real(dp), intent(out), optional :: force(3)
    real(dp), parameter :: rough = 0.1_dp      ! tolerance while a patch is looked for
    integer, parameter :: most_rounds = 20
    ! Constant pressures on ns/4 by ns elements that fit half an ellipse overestimate energy and force by
    ! 0.8/ns^2 (found on Hertz's ellipses with axis ratios from 1/20 to 20).
    real(dp), parameter :: grid_error = 0.8_dp
    real(dp), dimension(elements%nx, elements%ns, most_patches) :: depth, p, r
    real(dp), dimension(2, elements%nx, elements%ns, most_patches) :: normal, point
    type(mesh_type) :: mesh(most_patches)
    type(overlaps_type) :: overlaps
    integer :: n, g, round, iterations
    real(dp) :: box(3), self(most_patches)
    logical :: warm, known, fits

    energy = 0
    ok = .true.
    if (present(force)) force = 0
    call find_overlaps(pair, first, last, scan, overlaps)
    call start_patches(elements, overlaps, patches, warm, known)
    n = patches%n
    if (n == 0) return
    fits = .false.
    do round = 1, most_rounds
      do g = 1, n
        call fit_mesh(patches%box(:, g), overlaps%list(g)%ends, elements, mesh(g))
        call interpolate_influence(elements, mesh(g), patches%system%own(:, :, g), self(g), &
          patches%system%inverse(:, :, g))
        call set_depths(pair, first, last, centre, roll, scan, mesh(g), depth(:, :, g), normal(:, :, :, g), &
          point(:, :, :, g))
        if (warm .or. round > 1) then
          call carry_pressures(patches%mesh(g), patches%p(:, :, g), mesh(g), p(:, :, g))
        else
          call guess_pressures(patches%box(:, g), overlaps%list(g)%depth, mesh(g), p(:, :, g))
        end if
      end do
      call set_influence(mesh(:n), self(:n), elements%e_star, patches%system)
      call solve_pressure(patches%system, depth, &
        merge(elements%tolerance, max(rough, elements%tolerance), known .or. round > 1), p, r, ok, iterations)
      patches%solutions = patches%solutions + 1
      patches%iterations = patches%iterations + iterations
      patches%mesh(:n) = mesh(:n)
      patches%p(:, :, :n) = p(:, :, :n)
      fits = .false.
      if (.not. ok) exit
      fits = known .or. round > 1
      do g = 1, n
        call fit_box(elements, mesh(g), p(:, :, g), overlaps%list(g)%ends, patches%box(:, g), round, box, fits)
        patches%box(:, g) = box
      end do
      if (fits) then
        do g = 1, n
          call look_beyond(pair, elements, scan, first, last, overlaps%list(g)%ends, overlaps%list(g)%depth, mesh(:n), &
            p(:, :, :n), g, patches%box(:, g), fits)
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

  !> Place the patches of the last pose, or new ones, in the overlaps of this pose.  `warm` says that the patches of
  !> the last pose have been moved, pressures included; `known`, that the pressed areas are near to the true ones.
  pure subroutine start_patches(elements, overlaps, patches, warm, known)
    type(elements_type), intent(in) :: elements
    type(overlaps_type), intent(in) :: overlaps
    type(patches_type), intent(inout) :: patches
    logical, intent(out) :: warm, known
    integer :: i

    warm = near_overlaps(patches%overlaps, overlaps)
    do i = 1, overlaps%n
      if (warm) then
        call move_patch(overlaps%list(i), i, patches)
      else
        patches%box(:, i) = expected_area(overlaps%list(i))
      end if
      ! An overlap with two maxima may be one patch or two.
      associate (new => overlaps%list(i))
        patches%box(2, i) = min(patches%box(2, i), (new%tops(1) + new%ends(1))/2)
        patches%box(3, i) = max(patches%box(3, i), (new%tops(2) + new%ends(2))/2)
      end associate
    end do
    patches%n = overlaps%n
    patches%overlaps = overlaps
    known = warm
    if (overlaps%n == 0) return
    if (overlaps%n == 1 .and. patches%expected(1) > 0) then
      known = .true.
      associate (new => overlaps%list(1))
        patches%box(:, 1) = [patches%expected(1)*new%half_x, &
          new%ends(1) + patches%expected(2:)*(new%ends(2) - new%ends(1))]
      end associate
    end if
    patches%expected = -1
    if (.not. allocated(patches%p)) then
      patches%system = new_system(elements%nx, elements%ns, most_patches)
      allocate (patches%p(elements%nx, elements%ns, most_patches))
    end if
  end subroutine start_patches

  !> Move patch i of the last pose with its overlap and stretch it to the size of this pose.
  pure subroutine move_patch(new, i, patches)
    type(overlap_type), intent(in) :: new            !! the overlap of this pose
    integer, intent(in) :: i
    type(patches_type), intent(inout) :: patches     !! patches and overlaps of the last pose
    real(dp) :: along_s, along_x

    associate (old => patches%overlaps%list(i), mesh => patches%mesh(i))
      along_s = (new%ends(2) - new%ends(1))/(old%ends(2) - old%ends(1))
      along_x = new%half_x/old%half_x
      patches%box(:, i) = [patches%box(1, i)*along_x, new%ends(1) + (patches%box(2:3, i) - old%ends(1))*along_s]
      mesh%low = new%ends(1) + (mesh%low - old%ends(1))*along_s
      mesh%ds = mesh%ds*along_s
      mesh%dx = mesh%dx*along_x
      patches%p(:, :, i) = patches%p(:, :, i)*sqrt(new%depth/old%depth)
    end associate
  end subroutine move_patch

  !> The area that a single patch pressed last, as shares of its overlap: half of its length along x, both ends along s.
  !> Negative where there are several patches.
  pure function pressed_area(patches) result(area)
    type(patches_type), intent(in) :: patches
    real(dp) :: area(3)

    area = -1
    associate (overlap => patches%overlaps%list(1))
      if (patches%n == 1) area = [patches%box(1, 1)/overlap%half_x, &
        (patches%box(2:, 1) - overlap%ends(1))/(overlap%ends(2) - overlap%ends(1))]
    end associate
  end function pressed_area

  !> Keep the patches of one pose as a start for other poses.
  pure subroutine keep_patches(source, target)
    type(patches_type), intent(in) :: source
    type(patches_type), intent(inout) :: target

    if (.not. allocated(source%p)) return
    if (.not. allocated(target%p)) then
      allocate (target%p, mold=source%p)
      target%system = new_system(size(source%p, 1), size(source%p, 2), most_patches)
    end if
    target%n = source%n
    target%overlaps = source%overlaps
    target%box(:, :target%n) = source%box(:, :target%n)
    target%mesh(:target%n) = source%mesh(:target%n)
    target%p(:, :, :target%n) = source%p(:, :, :target%n)
  end subroutine keep_patches

  !> At the elements of a grid: the undeformed interpenetration [m], the rail's normal, and the wheel's point relative
  !> to the axle centre, track frame [m].
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
