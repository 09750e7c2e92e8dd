!> Grids of elements on pressed patches: their place and size, first pressures, and whether they fit.
module patch_grids
  use body_influence, only: displacement_of_bodies
  use halfspace, only: mesh_type
  use kinds, only: dp, pi
  use station_scan, only: scan_type
  use wheel_rail_pair, only: pair_type
  implicit none
  private
  public :: elements_type, fit_mesh, guess_loads, fit_box, look_beyond, displacement

  !> How finely patches are solved.
  type :: elements_type
    integer :: nx = 0, ns = 0          !! elements of a grid over x > 0 and s
    real(dp) :: tolerance = 0          !! error of the depth under pressure, relative to its maximum
    real(dp) :: e_star = 0             !! [Pa]
    logical :: flat = .false.          !! all normals count as parallel
    logical :: doubled = .false.       !! twice as many elements over s where one grid has two pressed areas
  end type elements_type

contains

  !> The grid around a pressed area, within the overlap: one free element at every end of s, and half of one along x. So the
  !> ends of ellipses have the same place in their elements for any number of elements, and the grid the same error.
  pure subroutine fit_mesh(box, lap, elements, mesh)
    real(dp), intent(in) :: box(3)         !! pressed area: half of its length along x, first and last s [m]
    real(dp), intent(in) :: lap(2)         !! overlap: first and last s [m]
    type(elements_type), intent(in) :: elements
    type(mesh_type), intent(out) :: mesh
    real(dp) :: high

    mesh%ds = (box(3) - box(2))/(elements%ns - 2)
    mesh%low = max(box(2) - mesh%ds, lap(1))
    high = min(box(3) + mesh%ds, lap(2))
    mesh%ds = (high - mesh%low)/elements%ns
    mesh%dx = box(1)/(elements%nx - 0.5_dp)
  end subroutine fit_mesh

  !> Loads of Hertz's pressure, up to a factor, on an ellipse that fills the pressed area: proportional to
  !> sqrt(1 - x^2 - s^2), with x and s relative to the semi-axes.
  pure subroutine guess_loads(box, deepest, mesh, f)
    real(dp), intent(in) :: box(3)         !! pressed area: half of its length along x, first and last s [m]
    real(dp), intent(in) :: deepest        !! largest overlap [m]
    type(mesh_type), intent(in) :: mesh
    real(dp), intent(out) :: f(:, :)
    real(dp) :: s
    integer :: i, j

    do j = 1, size(f, 2)
      s = (2*(mesh%low + (j - 0.5_dp)*mesh%ds) - box(2) - box(3))/(box(3) - box(2))
      do i = 1, size(f, 1)
        f(i, j) = mesh%dx*mesh%ds*sqrt(deepest*max(1 - ((i - 0.5_dp)*mesh%dx/box(1))**2 - s**2, 0.0_dp))
      end do
    end do
  end subroutine guess_loads

  !> The pressed area from the last loads: the ellipse with the same second moments about its centre, along x, before and behind
  !> the centre along s, each half axis times `stretch`. Moments are smooth in the pose, which ends that are counted in elements
  !> are not.
  pure subroutine fit_box(elements, mesh, f, lap, box, stretch, cut, moved)
    type(elements_type), intent(in) :: elements
    type(mesh_type), intent(in) :: mesh
    real(dp), intent(in) :: f(:, :)                !! loads (nx, ns) [N]
    real(dp), intent(in) :: lap(2)                 !! overlap: first and last s [m]
    real(dp), intent(inout) :: box(3)              !! pressed area: half of its length along x, first and last s [m]
    real(dp), intent(inout) :: stretch(3)
    logical, intent(out) :: cut                    !! the area reaches the end of its grid, and has been stretched
    logical, intent(out) :: moved                  !! the area differs from the last one
    real(dp), parameter :: enlarge = 1.06_dp       ! factor for a grid that cuts its patch off
    real(dp), parameter :: slack = 0.02_dp         ! largest shift of an end, relative to the length of the area
    real(dp), dimension(elements%ns) :: s, row
    real(dp) :: centre, half(3), old(3), total
    logical :: at_end(3)
    integer :: i

    cut = .false.
    moved = .false.
    if (all(f <= 0)) return
    old = box
    s = mesh%low + ([(i, i=1, elements%ns)] - 0.5_dp)*mesh%ds
    row = sum(f, 1)
    total = sum(row)
    centre = sum(row*s)/total
    half(1) = sum(sum(f, 2)*([(i, i=1, elements%nx)] - 0.5_dp)**2)/total + 1/12.0_dp
    half(1) = sqrt(5*half(1))*mesh%dx
    half(2) = axis_of(max(0.0_dp, centre - s + mesh%ds/2), max(0.0_dp, centre - s - mesh%ds/2))
    half(3) = axis_of(max(0.0_dp, s - centre + mesh%ds/2), max(0.0_dp, s - centre - mesh%ds/2))
    at_end(1) = any(f(elements%nx, :) > 0)
    at_end(2) = any(f(:, 1) > 0) .and. mesh%low > lap(1) + 1e-3_dp*mesh%ds
    at_end(3) = any(f(:, elements%ns) > 0) .and. mesh%low + elements%ns*mesh%ds < lap(2) - 1e-3_dp*mesh%ds
    cut = any(at_end)
    where (at_end) stretch = enlarge*stretch
    half = stretch*half
    box = [half(1), max(lap(1), centre - half(2)), min(lap(2), centre + half(3))]
    moved = abs(box(1) - old(1)) > slack*box(1) .or. any(abs(box(2:) - old(2:)) > slack*(box(3) - box(2)))

  contains

    !> Semi-axis of the half ellipse with the second moment of rows that reach from `near` to `far`, seen from the centre.
    pure real(dp) function axis_of(far, near)
      real(dp), intent(in) :: far(:), near(:)    !! [m]

      axis_of = sqrt(5*sum(row*(far**3 - near**3))/(3*sum(row*(far - near))))
    end function axis_of

  end subroutine fit_box

  !> Look for a second pressed area of an overlap, beyond the grid: where the bodies still interpenetrate after the
  !> displacement by all loads. `fits` becomes false, and the area is stretched to there.
  pure subroutine look_beyond(pair, elements, scan, first, last, lap, overlap, mesh, angle, foot, f, g, box, stretch, fits)
    type(pair_type), intent(in) :: pair
    type(elements_type), intent(in) :: elements
    type(scan_type), intent(in) :: scan
    integer, intent(in) :: first, last             !! stations
    real(dp), intent(in) :: lap(2)                 !! overlap: first and last s [m]
    real(dp), intent(in) :: overlap                !! largest overlap [m]
    type(mesh_type), intent(in) :: mesh(:)         !! (patch)
    real(dp), intent(in) :: angle(:, :)            !! of the wheel's tangent (ns, patch) [rad]
    real(dp), intent(in) :: foot(:, :)             !! stations of the rail below the rows of elements (ns, patch) [m]
    real(dp), intent(in) :: f(:, :, :)             !! loads (nx, ns, patch) [N]
    integer, intent(in) :: g                       !! the patch
    real(dp), intent(inout) :: box(3)              !! pressed area: half of its length along x, first and last s [m]
    real(dp), intent(inout) :: stretch(3)          !! of the area, as in `fit_box`
    logical, intent(inout) :: fits
    integer, parameter :: looks = 12               ! stations that are looked at, about
    real(dp), parameter :: negligible = 1e-3_dp    ! interpenetration, relative to the overlap
    real(dp) :: s, low, high, middle
    integer :: k, step

    low = mesh(g)%low - mesh(g)%ds
    high = mesh(g)%low + (elements%ns + 1)*mesh(g)%ds
    if (low < lap(1) .and. high > lap(2)) return
    step = max(1, count(pair%s(first:last) > lap(1) .and. pair%s(first:last) < lap(2))/looks)
    do k = first, last, step
      s = pair%s(k)
      if (s < lap(1) .or. s > lap(2) .or. s > low .and. s < high) cycle
      if (scan%depth(k) <= negligible*overlap &
        + displacement(pair, elements, mesh, angle, foot, f, s, pair%angle(k), scan%foot(k))) cycle
      middle = (box(2) + box(3))/2
      if (s < low) then
        stretch(2) = stretch(2)*(middle - (s + lap(1))/2)/(middle - box(2))
        box(2) = (s + lap(1))/2
      else if (s > high) then
        stretch(3) = stretch(3)*((s + lap(2))/2 - middle)/(box(3) - middle)
        box(3) = (s + lap(2))/2
      end if
      fits = .false.
      return
    end do
  end subroutine look_beyond

  !> Displacement of both bodies together at x = 0 and s, off the grids [m]: every row of elements counts as a line.
  pure real(dp) function displacement(pair, elements, mesh, angle, foot, f, s, angle_s, foot_s)
    type(pair_type), intent(in) :: pair
    type(elements_type), intent(in) :: elements
    type(mesh_type), intent(in) :: mesh(:)         !! (patch)
    real(dp), intent(in) :: angle(:, :)            !! of the wheel's tangent (ns, patch) [rad]
    real(dp), intent(in) :: foot(:, :)             !! stations of the rail below the rows of elements (ns, patch) [m]
    real(dp), intent(in) :: f(:, :, :)             !! loads (nx, ns, patch) [N]
    real(dp), intent(in) :: s, angle_s             !! place [m] and the tangent's angle there [rad]
    real(dp), intent(in) :: foot_s                 !! station of the rail below it [m]
    real(dp) :: away, primitive(0:elements%nx), cosine
    integer :: i, j, g

    displacement = 0
    do g = 1, size(mesh)
      do j = 1, elements%ns
        if (all(f(:, j, g) <= 0)) cycle
        cosine = merge(1.0_dp, cos(angle(j, g) - angle_s), elements%flat)
        away = abs(mesh(g)%low + (j - 0.5_dp)*mesh(g)%ds - s)
        primitive = asinh([(i*mesh(g)%dx/away, i=0, elements%nx)])
        displacement = displacement + cosine*2/(pi*elements%e_star*mesh(g)%dx) &
          *sum(f(:, j, g)*(primitive(1:) - primitive(:elements%nx - 1)))
      end do
    end do
    if (allocated(pair%bodies)) displacement = displacement + displacement_of_bodies(pair%bodies, mesh, angle, foot, &
      elements%e_star, f, s, angle_s, foot_s)
  end function displacement

end module patch_grids
