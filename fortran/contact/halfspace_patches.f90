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
  use wheel_rail_pair, only: pair_type, rolled, scan_type, set_depth
  use halfspace, only: mesh_type, new_system, set_influence, solve_pressure, system_type, unit_influence
  use kinds, only: dp, pi
  implicit none
  private
  public :: elements_type, patches_type, new_elements, press_patches, keep_patches, expect_area, pressed_area

  integer, parameter :: most_patches = 4
  real(dp), parameter :: least_cosine = 0.05_dp      ! of the normal in the overlap's length

  ! Aspects ds/dx of elements for which the influence is kept: powers of 2^(1/octave); it is linear between them.
  integer, parameter :: octave = 32, flattest = -11*octave, steepest = 8*octave

  real(dp), parameter :: margin = 0.02_dp    ! of a grid around the pressed area, of its length, at every end

  !> What solutions for one resolution share.
  type :: elements_type
    integer :: nx = 0, ns = 0          !! elements over x > 0 and s
    real(dp) :: tolerance = 0          !! in the depth, of its maximum
    real(dp) :: e_star = 0             !! [Pa]
    real(dp), allocatable :: within(:, :, :)   !! of unit_influence for every aspect
    real(dp), allocatable :: self(:)
  end type elements_type

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

  pure function new_elements(nx, ns, tolerance, e_star) result(elements)
    integer, intent(in) :: nx, ns
    real(dp), intent(in) :: tolerance, e_star
    type(elements_type) :: elements
    integer :: k

    elements%nx = nx
    elements%ns = ns
    elements%tolerance = tolerance
    elements%e_star = e_star
    allocate (elements%within(nx*(2*ns - 1), nx, flattest:steepest), elements%self(flattest:steepest))
    do k = flattest, steepest
      call unit_influence(nx, ns, 2.0_dp**(k/real(octave, dp)), elements%within(:, :, k), elements%self(k))
    end do
  end function new_elements

  !> Elastic energy [J] of the stations first..last of a scan and, if asked, the force of the rail on the
  !> wheel and its moment about the axle centre (F_y [N], F_z [N], M_x [N m]).  `ok` is false when the
  !> solution fails.
  pure subroutine press_patches(pair, elements, first, last, centre, roll, work, patches, energy, ok, force)
    type(pair_type), intent(in) :: pair
    type(elements_type), intent(in) :: elements
    integer, intent(in) :: first, last
    real(dp), intent(in) :: centre(2), roll    !! of the axle [m, rad]
    type(scan_type), intent(in) :: work        !! in this pose
    type(patches_type), intent(inout) :: patches   !! of a pose nearby, or new
    real(dp), intent(out) :: energy
    logical, intent(out) :: ok
    real(dp), intent(out), optional :: force(3)
    real(dp), parameter :: enlarge = 1.3_dp    ! of a grid that cuts its patch off
    real(dp), parameter :: least_fill = 0.8_dp ! of the grid by the patch
    real(dp), parameter :: rough = 0.1_dp      ! tolerance while a patch is looked for
    integer, parameter :: most_rounds = 20
    ! Neighbouring poses want their patches in the same place of their grids, or the grid's error jumps.
    integer, parameter :: tight_rounds = 5, free_rounds = 8
    real(dp), parameter :: slack = 0.03_dp     ! of the grid's length
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
    call find_overlaps(pair, first, last, work, patches, warm)
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
        call set_depths(pair, first, last, centre, roll, work, mesh(g), depth(:, :, g), normal(:, :, :, g), &
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
        call fit_box(g, box, fits)
        patches%box(:, g) = box
      end do
      if (fits) then
        do g = 1, n
          call look_beyond(g, patches%box(:, g), fits)
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

  contains

    !> The pressed area from the last pressures: p^2 falls linearly to its edge.  A patch that reaches the
    !> end of its grid, or leaves much of it free, gets another one.
    pure subroutine fit_box(g, box, fits)
      integer, intent(in) :: g
      real(dp), intent(out) :: box(3)
      logical, intent(inout) :: fits
      real(dp) :: ends(2), far, length
      integer :: i, j
      logical :: cut(3)

      box = patches%box(:, g)
      if (all(p(:, :, g) <= 0)) return
      ends = [real(elements%ns, dp), 0.0_dp]
      far = 0
      do i = 1, elements%nx
        j = findloc(p(i, :, g) > 0, .true., 1)
        if (j == 0) cycle
        if (j < elements%ns) ends(1) = min(ends(1), j - 0.5_dp - to_edge(p(i, j, g), p(i, j + 1, g)))
        j = findloc(p(i, :, g) > 0, .true., 1, back=.true.)
        if (j > 1) ends(2) = max(ends(2), j - 0.5_dp + to_edge(p(i, j, g), p(i, j - 1, g)))
      end do
      do j = 1, elements%ns
        i = findloc(p(:, j, g) > 0, .true., 1, back=.true.)
        if (i > 1) far = max(far, i - 0.5_dp + to_edge(p(i, j, g), p(i - 1, j, g)))
        if (i == 1) far = max(far, 1.0_dp)
      end do
      if (ends(2) <= ends(1)) ends = [0.0_dp, real(elements%ns, dp)]
      box = [far*mesh(g)%dx, mesh(g)%low + ends*mesh(g)%ds]
      length = elements%ns*mesh(g)%ds
      cut(1) = far > elements%nx + 0.3_dp
      cut(2) = any(p(:, 1, g) > 0) .and. ends(1) < 0.1_dp .and. mesh(g)%low > patches%lap(1, g) + 1e-3_dp*length
      cut(3) = any(p(:, elements%ns, g) > 0) .and. ends(2) > elements%ns - 0.1_dp &
        .and. mesh(g)%low + length < patches%lap(2, g) - 1e-3_dp*length
      if (cut(1)) box(1) = enlarge*elements%nx*mesh(g)%dx
      if (cut(2)) box(2) = mesh(g)%low - (enlarge - 1)*length
      if (cut(3)) box(3) = mesh(g)%low + enlarge*length
      box(2) = max(box(2), patches%lap(1, g))
      box(3) = min(box(3), patches%lap(2, g))
      fits = fits .and. .not. any(cut) .and. far < elements%nx
      if (round > free_rounds) then
        ! Two grids may ask for each other: from here on they only grow.
        box = [max(box(1), merge(enlarge, 1.0_dp, far >= elements%nx)*patches%box(1, g)), min(box(2), patches%box(2, g)), &
          max(box(3), patches%box(3, g))]
      else
        fits = fits .and. far > least_fill*elements%nx .and. box(3) - box(2) > least_fill*length
      end if
      if (fits .and. round < tight_rounds) fits = abs(far*(1 + 2*margin) - elements%nx) < slack*elements%nx .and. &
        abs(box(2) - max(mesh(g)%low + margin*length, patches%lap(1, g))) < slack*length .and. &
        abs(mesh(g)%low + length - min(box(3) + margin*length, patches%lap(2, g))) < slack*length
    end subroutine fit_box

    !> A second pressed area of an overlap, beyond the grid: bodies that are displaced by all pressures would
    !> still interpenetrate there.
    pure subroutine look_beyond(g, box, fits)
      integer, intent(in) :: g
      real(dp), intent(inout) :: box(3)      !! to be pressed
      logical, intent(inout) :: fits
      integer, parameter :: looks = 12
      real(dp), parameter :: negligible = 1e-3_dp    ! of the overlap
      real(dp) :: s, low, high, total, middle, spread, away
      integer :: i, j, k, step

      low = mesh(g)%low - mesh(g)%ds
      high = mesh(g)%low + (elements%ns + 1)*mesh(g)%ds
      if (low < patches%lap(1, g) .and. high > patches%lap(2, g)) return
      total = max(sum(p(:, :, g)), tiny(total))
      middle = mesh(g)%low + sum([(sum(p(:, j, g))*(j - 0.5_dp), j=1, elements%ns)])/total*mesh(g)%ds
      spread = (sum([(sum(p(:, j, g))*(mesh(g)%low + (j - 0.5_dp)*mesh(g)%ds - middle)**2, j=1, elements%ns)]) &
        + sum([(sum(p(i, :, g))*((i - 0.5_dp)*mesh(g)%dx)**2, i=1, elements%nx)]))/total
      total = 2*total*mesh(g)%dx*mesh(g)%ds
      step = max(1, count(pair%s(first:last) > patches%lap(1, g) .and. pair%s(first:last) < patches%lap(2, g))/looks)
      do k = first, last, step
        s = pair%s(k)
        if (s < patches%lap(1, g) .or. s > patches%lap(2, g) .or. s > low .and. s < high) cycle
        ! The mean of 1/r is at least one over the root of the mean of r^2.
        away = sqrt((s - middle)**2 + spread)
        if (work%depth(k) <= negligible*patches%deepest(g) + total/(pi*elements%e_star*away)) cycle
        if (work%depth(k) <= negligible*patches%deepest(g) + displacement(s)) cycle
        if (s < low) box(2) = min(box(2), (s + patches%lap(1, g))/2)
        if (s > high) box(3) = max(box(3), (s + patches%lap(2, g))/2)
        fits = .false.
      end do
    end subroutine look_beyond

    !> Of both bodies at x = 0 and s [m], off the grids: every row of elements as a line.
    pure real(dp) function displacement(s)
      real(dp), intent(in) :: s
      real(dp) :: away, to(0:elements%nx)
      integer :: i, j, g

      displacement = 0
      do g = 1, n
        do j = 1, elements%ns
          away = abs(mesh(g)%low + (j - 0.5_dp)*mesh(g)%ds - s)
          to = asinh([(i*mesh(g)%dx/away, i=0, elements%nx)])
          displacement = displacement + 2*mesh(g)%ds/(pi*elements%e_star)*sum(p(:, j, g)*(to(1:) - to(:elements%nx - 1)))
        end do
      end do
    end function displacement

    !> From the centre of the last pressed element, with p, to the edge, in elements; `inner` is its neighbour's.
    pure real(dp) function to_edge(last_p, inner) result(way)
      real(dp), intent(in) :: last_p, inner

      way = 0.5_dp
      if (inner > last_p) way = min(last_p**2/(inner**2 - last_p**2), 0.9_dp)
    end function to_edge

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
  pure subroutine find_overlaps(pair, first, last, work, patches, warm)
    type(pair_type), intent(in) :: pair
    integer, intent(in) :: first, last
    type(scan_type), intent(in) :: work
    type(patches_type), intent(inout) :: patches
    logical, intent(out) :: warm
    real(dp) :: lap(2, most_patches), lap_x(most_patches), deepest(most_patches), station(most_patches), &
      tops(2, most_patches), stretch, bend(2), share(2), way
    integer :: i, n, from, least, node

    n = 0
    from = 0
    do i = first, last + 1
      if (i <= last) then
        if (work%depth(i) > 0) then
          if (from == 0) from = i
          cycle
        end if
      end if
      if (from == 0) cycle
      if (n == most_patches) then
        ! The shallowest gives way.
        least = minloc(deepest, 1)
        if (maxval(work%depth(from:i - 1)) <= deepest(least)) then
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
      node = from - 1 + maxloc(work%depth(from:i - 1), 1)
      deepest(n) = work%depth(node)
      station(n) = pair%s(node)
      ! Where the depth only grows, the station before the lap stands for the first top.
      tops(:, n) = pair%s([max(1, from - 1 + findloc(work%depth(from:i - 2) > work%depth(from + 1:i - 1), .true., 1)), &
        from + findloc(work%depth(from:i - 2) < work%depth(from + 1:i - 1), .true., 1, back=.true.)])
      if (i - from < 3) tops(:, n) = station(n)
      lap_x(n) = min(sqrt(2*deepest(n)*(-pair%r(2, node))/max(work%normal(2, node), least_cosine)), -pair%r(2, node)/2)
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

      way = abs(pair%s(beyond) - pair%s(inside))*work%depth(inside)/(work%depth(inside) - work%depth(beyond))
    end function crossing

  end subroutine find_overlaps

  !> A grid around a pressed area, within the overlap's stretch.
  pure subroutine fit_mesh(box, lap, elements, mesh)
    real(dp), intent(in) :: box(3), lap(2)
    type(elements_type), intent(in) :: elements
    type(mesh_type), intent(out) :: mesh
    real(dp) :: high

    mesh%low = max(box(2) - margin*(box(3) - box(2)), lap(1))
    high = min(box(3) + margin*(box(3) - box(2)), lap(2))
    mesh%ds = (high - mesh%low)/elements%ns
    mesh%dx = (1 + 2*margin)*box(1)/elements%nx
  end subroutine fit_mesh

  !> Influence of the elements of a grid.
  pure subroutine interpolate(elements, mesh, within, self)
    type(elements_type), intent(in) :: elements
    type(mesh_type), intent(in) :: mesh
    real(dp), intent(out) :: within(:, :), self
    real(dp) :: t
    integer :: k

    t = octave*log(mesh%ds/mesh%dx)/log(2.0_dp)
    k = max(flattest, min(floor(t), steepest - 1))
    t = max(0.0_dp, min(t - k, 1.0_dp))
    within = (1 - t)*elements%within(:, :, k) + t*elements%within(:, :, k + 1)
    self = (1 - t)*elements%self(k) + t*elements%self(k + 1)
  end subroutine interpolate

  !> Undeformed interpenetration at the elements [m], the rail's normal there and the wheel's point from the
  !> axle centre, track frame.
  pure subroutine set_depths(pair, first, last, centre, roll, work, mesh, depth, normal, point)
    type(pair_type), intent(in) :: pair
    integer, intent(in) :: first, last
    real(dp), intent(in) :: centre(2), roll
    type(scan_type), intent(in) :: work
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
        foot(i) = work%foot(node) + ((point(1, i, j) - base(1))*work%normal(2, node) &
          - (point(2, i, j) - base(2))*work%normal(1, node))*work%rate(node)
      end do
      interval = work%interval(node)
      call set_depth(pair%rail, size(foot), spread(centre, 2, size(foot)) + point(:, :, j), foot, interval, &
        depth(:, j), normal(:, :, j), rate, step)
    end do
  end subroutine set_depths

  !> Hertz's pressure over a box: where x and s are the shares of its semi-axes, sqrt(1 - x^2 - s^2).
  pure subroutine guess(box, deepest, mesh, p)
    real(dp), intent(in) :: box(3), deepest
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
  end subroutine guess

  !> Pressures of one grid at the elements of another, linearly between its elements.
  pure subroutine carry(old, q, new, p)
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
        p(i, j) = (1 - s)*((1 - x)*at(k, l) + x*at(k + 1, l)) + s*((1 - x)*at(k, l + 1) + x*at(k + 1, l + 1))
      end do
    end do

  contains

    pure real(dp) function at(k, l)
      integer, intent(in) :: k, l

      at = 0
      if (k <= size(q, 1) .and. l >= 1 .and. l <= size(q, 2)) at = q(max(k, 1), l)
    end function at

  end subroutine carry

end module halfspace_patches