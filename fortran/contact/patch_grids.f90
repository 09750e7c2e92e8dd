!> Grids of elements on pressed patches: their place and size, first pressures, and whether they fit.
module patch_grids
  use halfspace, only: mesh_type, unit_influence
  use kinds, only: dp, pi
  use station_scan, only: scan_type
  use wheel_rail_pair, only: pair_type
  implicit none
  private
  public :: elements_type, new_elements, fit_mesh, interpolate_influence, guess_pressures, carry_pressures, fit_box, &
    look_beyond

  ! The influence is kept for elements with these ratios ds/dx: powers of 2^(1/octave).  It is linear between them.
  integer, parameter :: octave = 32, flattest = -11*octave, steepest = 8*octave

  real(dp), parameter :: margin = 0.02_dp    ! free share of the area's length at every end of it

  !> What all solutions with one resolution share.
  type :: elements_type
    integer :: nx = 0, ns = 0          !! elements over x > 0 and s
    real(dp) :: tolerance = 0          !! error of the depth under pressure, relative to its maximum
    real(dp) :: e_star = 0             !! [Pa]
    real(dp), allocatable :: own(:, :, :)      !! influence from `unit_influence`, last index: ratio ds/dx
    real(dp), allocatable :: self(:)           !! displacement of an element alone from `unit_influence`, by ratio
    real(dp), allocatable :: inverse(:, :, :)  !! inverse among neighbours from `unit_influence`, last index: ratio
  end type elements_type

contains

  !> Elements of nx by ns to a grid.
  pure function new_elements(nx, ns, tolerance, e_star) result(elements)
    integer, intent(in) :: nx, ns
    real(dp), intent(in) :: tolerance, e_star   !! error of the depth, relative to its maximum; [Pa]
    type(elements_type) :: elements
    integer :: k

    elements%nx = nx
    elements%ns = ns
    elements%tolerance = tolerance
    elements%e_star = e_star
    allocate (elements%own(nx*(2*ns - 1), nx, flattest:steepest), elements%self(flattest:steepest))
    allocate (elements%inverse(0:1, 0:1, flattest:steepest))
    do k = flattest, steepest
      call unit_influence(nx, ns, 2.0_dp**(k/real(octave, dp)), elements%own(:, :, k), elements%self(k), &
        elements%inverse(:, :, k))
    end do
  end function new_elements

  !> The grid around a pressed area, within the overlap.
  pure subroutine fit_mesh(box, lap, elements, mesh)
    real(dp), intent(in) :: box(3)         !! pressed area: half of its length along x, first and last s [m]
    real(dp), intent(in) :: lap(2)         !! overlap: first and last s [m]
    type(elements_type), intent(in) :: elements
    type(mesh_type), intent(out) :: mesh
    real(dp) :: high

    mesh%low = max(box(2) - margin*(box(3) - box(2)), lap(1))
    high = min(box(3) + margin*(box(3) - box(2)), lap(2))
    mesh%ds = (high - mesh%low)/elements%ns
    mesh%dx = (1 + 2*margin)*box(1)/elements%nx
  end subroutine fit_mesh

  !> Influence of the elements of a grid on each other, as from `unit_influence`.
  pure subroutine interpolate_influence(elements, mesh, own, self, inverse)
    type(elements_type), intent(in) :: elements
    type(mesh_type), intent(in) :: mesh
    real(dp), intent(out) :: own(:, :), self, inverse(:, :)
    real(dp) :: t
    integer :: k

    t = octave*log(mesh%ds/mesh%dx)/log(2.0_dp)
    k = max(flattest, min(floor(t), steepest - 1))
    t = max(0.0_dp, min(t - k, 1.0_dp))
    own = (1 - t)*elements%own(:, :, k) + t*elements%own(:, :, k + 1)
    self = (1 - t)*elements%self(k) + t*elements%self(k + 1)
    inverse = (1 - t)*elements%inverse(:, :, k) + t*elements%inverse(:, :, k + 1)
  end subroutine interpolate_influence

  !> Hertz's pressure, up to a factor, on an ellipse that fills the pressed area: proportional to sqrt(1 - x^2 - s^2),
  !> with x and s relative to the semi-axes.
  pure subroutine guess_pressures(box, deepest, mesh, p)
    real(dp), intent(in) :: box(3)         !! pressed area: half of its length along x, first and last s [m]
    real(dp), intent(in) :: deepest        !! largest overlap [m]
    type(mesh_type), intent(in) :: mesh
    real(dp), intent(out) :: p(:, :)
    real(dp) :: s
    integer :: i, j

    do j = 1, size(p, 2)
      s = (2*(mesh%low + (j - 0.5_dp)*mesh%ds) - box(2) - box(3))/(box(3) - box(2))
      do i = 1, size(p, 1)
        p(i, j) = sqrt(deepest*max(1 - ((i - 0.5_dp)*mesh%dx/box(1))**2 - s**2, 0.0_dp))
      end do
    end do
  end subroutine guess_pressures

  !> Pressures q of the old grid, interpolated linearly to the elements of the new one.
  pure subroutine carry_pressures(old, q, new, p)
    type(mesh_type), intent(in) :: old, new
    real(dp), intent(in) :: q(:, :)
    real(dp), intent(out) :: p(:, :)
    real(dp) :: x, s
    integer :: i, j, k, l

    do j = 1, size(p, 2)
      s = (new%low + (j - 0.5_dp)*new%ds - old%low)/old%ds + 0.5_dp
      l = floor(s)
      s = s - l
      do i = 1, size(p, 1)
        x = (i - 0.5_dp)*new%dx/old%dx + 0.5_dp
        k = floor(x)
        x = x - k
        p(i, j) = (1 - s)*((1 - x)*pressure(k, l) + x*pressure(k + 1, l)) &
          + s*((1 - x)*pressure(k, l + 1) + x*pressure(k + 1, l + 1))
      end do
    end do

  contains

    !> Pressure of the old grid at element (k, l): symmetric about x = 0, and 0 beyond the other ends.
    pure real(dp) function pressure(k, l)
      integer, intent(in) :: k, l

      pressure = 0
      if (k <= size(q, 1) .and. l >= 1 .and. l <= size(q, 2)) pressure = q(max(k, 1), l)
    end function pressure

  end subroutine carry_pressures

  !> The pressed area from the last pressures: p^2 falls linearly to the edge of the area.  `fits` becomes false where
  !> the patch reaches the end of its grid or leaves much of the grid free: it then needs another grid.
  pure subroutine fit_box(elements, mesh, p, lap, old, round, box, fits)
    type(elements_type), intent(in) :: elements
    type(mesh_type), intent(in) :: mesh
    real(dp), intent(in) :: p(:, :)                !! pressures (nx, ns) [Pa]
    real(dp), intent(in) :: lap(2)                 !! overlap: first and last s [m]
    real(dp), intent(in) :: old(3)                 !! pressed area so far: half of its length along x, first and last s [m]
    integer, intent(in) :: round                   !! number of this round of the search
    real(dp), intent(out) :: box(3)                !! pressed area, as `old`
    logical, intent(inout) :: fits
    real(dp), parameter :: enlarge = 1.3_dp        ! factor for a grid that cuts its patch off
    real(dp), parameter :: least_fill = 0.8_dp     ! least share of the grid that the patch fills
    ! Patches of neighbouring poses must have the same place in their grids, or the grid's error jumps between them.
    integer, parameter :: tight_rounds = 5, free_rounds = 8
    real(dp), parameter :: slack = 0.03_dp         ! largest shift of the patch in its grid, relative to the length of the grid
    real(dp) :: ends(2), far, length
    integer :: i, j
    logical :: cut(3)

    box = old
    if (all(p <= 0)) return
    ends = [real(elements%ns, dp), 0.0_dp]
    far = 0
    do i = 1, elements%nx
      j = findloc(p(i, :) > 0, .true., 1)
      if (j == 0) cycle
      if (j < elements%ns) ends(1) = min(ends(1), j - 0.5_dp - to_edge(p(i, j), p(i, j + 1)))
      j = findloc(p(i, :) > 0, .true., 1, back=.true.)
      if (j > 1) ends(2) = max(ends(2), j - 0.5_dp + to_edge(p(i, j), p(i, j - 1)))
    end do
    do j = 1, elements%ns
      i = findloc(p(:, j) > 0, .true., 1, back=.true.)
      if (i > 1) far = max(far, i - 0.5_dp + to_edge(p(i, j), p(i - 1, j)))
      if (i == 1) far = max(far, 1.0_dp)
    end do
    if (ends(2) <= ends(1)) ends = [0.0_dp, real(elements%ns, dp)]
    box = [far*mesh%dx, mesh%low + ends*mesh%ds]
    length = elements%ns*mesh%ds
    cut(1) = far > elements%nx + 0.3_dp
    cut(2) = any(p(:, 1) > 0) .and. ends(1) < 0.1_dp .and. mesh%low > lap(1) + 1e-3_dp*length
    cut(3) = any(p(:, elements%ns) > 0) .and. ends(2) > elements%ns - 0.1_dp &
      .and. mesh%low + length < lap(2) - 1e-3_dp*length
    if (cut(1)) box(1) = enlarge*elements%nx*mesh%dx
    if (cut(2)) box(2) = mesh%low - (enlarge - 1)*length
    if (cut(3)) box(3) = mesh%low + enlarge*length
    box(2) = max(box(2), lap(1))
    box(3) = min(box(3), lap(2))
    fits = fits .and. .not. any(cut) .and. far < elements%nx
    if (round > free_rounds) then
      ! Two grids may ask for each other in turn: from here on the pressed area only grows.
      box = [max(box(1), merge(enlarge, 1.0_dp, far >= elements%nx)*old(1)), min(box(2), old(2)), &
        max(box(3), old(3))]
    else
      fits = fits .and. far > least_fill*elements%nx .and. box(3) - box(2) > least_fill*length
    end if
    if (fits .and. round < tight_rounds) fits = abs(far*(1 + 2*margin) - elements%nx) < slack*elements%nx .and. &
      abs(box(2) - max(mesh%low + margin*length, lap(1))) < slack*length .and. &
      abs(mesh%low + length - min(box(3) + margin*length, lap(2))) < slack*length
  end subroutine fit_box

  !> Look for a second pressed area of an overlap, beyond the grid: where the bodies still interpenetrate after the
  !> displacement by all pressures.  It enlarges `box`, and `fits` becomes false.
  pure subroutine look_beyond(pair, elements, scan, first, last, lap, overlap, mesh, p, g, box, fits)
    type(pair_type), intent(in) :: pair
    type(elements_type), intent(in) :: elements
    type(scan_type), intent(in) :: scan
    integer, intent(in) :: first, last             !! stations
    real(dp), intent(in) :: lap(2)                 !! overlap: first and last s [m]
    real(dp), intent(in) :: overlap                !! largest overlap [m]
    type(mesh_type), intent(in) :: mesh(:)         !! (patch)
    real(dp), intent(in) :: p(:, :, :)             !! pressures (nx, ns, patch) [Pa]
    integer, intent(in) :: g                       !! the patch
    real(dp), intent(inout) :: box(3)              !! pressed area: half of its length along x, first and last s [m]
    logical, intent(inout) :: fits
    integer, parameter :: looks = 12               ! stations that are looked at, about
    real(dp), parameter :: negligible = 1e-3_dp    ! interpenetration, relative to the overlap
    real(dp) :: s, low, high, total, middle, spread, away
    integer :: i, j, k, step

    low = mesh(g)%low - mesh(g)%ds
    high = mesh(g)%low + (elements%ns + 1)*mesh(g)%ds
    if (low < lap(1) .and. high > lap(2)) return
    total = max(sum(p(:, :, g)), tiny(total))
    middle = mesh(g)%low + sum([(sum(p(:, j, g))*(j - 0.5_dp), j=1, elements%ns)])/total*mesh(g)%ds
    spread = (sum([(sum(p(:, j, g))*(mesh(g)%low + (j - 0.5_dp)*mesh(g)%ds - middle)**2, j=1, elements%ns)]) &
      + sum([(sum(p(i, :, g))*((i - 0.5_dp)*mesh(g)%dx)**2, i=1, elements%nx)]))/total
    total = 2*total*mesh(g)%dx*mesh(g)%ds
    step = max(1, count(pair%s(first:last) > lap(1) .and. pair%s(first:last) < lap(2))/looks)
    do k = first, last, step
      s = pair%s(k)
      if (s < lap(1) .or. s > lap(2) .or. s > low .and. s < high) cycle
      ! The mean of 1/r is at least one over the root of the mean of r^2.
      away = sqrt((s - middle)**2 + spread)
      if (scan%depth(k) <= negligible*overlap + total/(pi*elements%e_star*away)) cycle
      if (scan%depth(k) <= negligible*overlap + displacement(elements, mesh, p, s)) cycle
      if (s < low) box(2) = min(box(2), (s + lap(1))/2)
      if (s > high) box(3) = max(box(3), (s + lap(2))/2)
      fits = .false.
    end do
  end subroutine look_beyond

  !> Displacement of both bodies together at x = 0 and s, off the grids [m]: every row of elements counts as a line.
  pure real(dp) function displacement(elements, mesh, p, s)
    type(elements_type), intent(in) :: elements
    type(mesh_type), intent(in) :: mesh(:)         !! (patch)
    real(dp), intent(in) :: p(:, :, :)             !! pressures (nx, ns, patch) [Pa]
    real(dp), intent(in) :: s                      !! [m]
    real(dp) :: away, primitive(0:elements%nx)
    integer :: i, j, g

    displacement = 0
    do g = 1, size(mesh)
      do j = 1, elements%ns
        away = abs(mesh(g)%low + (j - 0.5_dp)*mesh(g)%ds - s)
        primitive = asinh([(i*mesh(g)%dx/away, i=0, elements%nx)])
        displacement = displacement + 2*mesh(g)%ds/(pi*elements%e_star) &
          *sum(p(:, j, g)*(primitive(1:) - primitive(:elements%nx - 1)))
      end do
    end do
  end function displacement

  !> Way from the centre of the last pressed element to the edge of the patch, in elements, from the pressures of this
  !> element and of the inner neighbour.
  pure real(dp) function to_edge(last_p, inner) result(way)
    real(dp), intent(in) :: last_p, inner

    way = 0.5_dp
    if (inner > last_p) way = min(last_p**2/(inner**2 - last_p**2), 0.9_dp)
  end function to_edge

end module patch_grids
