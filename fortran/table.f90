!> The generator of the contact table of a wheel/rail pair: it tabulates h and S of
!> `potential` for every zone, on axes that it halves where the splines miss the accuracy that
!> is asked for, in the force of poses that a run can come to.
!>
!> Half-spaces: S of the strips times the ratio c(u, phi, q) of the energies of half-spaces and
!> strips, which is smooth because the strips already carry the geometry.  It is
!> sampled on axes of its own, coarser than those of S.
!>
!> Rows and columns are sampled in several threads; none depends on another, so that the table
!> is the same for any number of them.
module table
  use bspline, only: axis_basis, axis_type, basis_type, fit_2d, fit_3d, graded_points, new_axis, spline_2d_value, &
    spline_3d_value
  use contact, only: zone_type
  use geometry, only: pair_type
  use kinds, only: dp
  use patches, only: elements_type, new_elements
  use potential, only: bound_heights, contact_table, zone_pose, zone_table
  use progress, only: monitor_type
  use reach, only: extent_type, find_reach, strictness
  use refine, only: halve_cells, judge_cells
  use samples, only: reference_shift, sample_ratios, sample_row
  implicit none
  private
  public :: build_table

  !> Values of a zone at the points of its axes.
  type :: samples_type
    type(axis_type) :: u, q
    real(dp), allocatable :: h(:, :)       !! (u, roll) [m]
    real(dp), allocatable :: s(:, :, :)    !! (q, u, roll)
    logical, allocatable :: good(:, :)     !! (u, roll): sampled
    real(dp), allocatable :: other(:, :, :)  !! deepest of the other zones, (q, u, roll) [m]
    real(dp), allocatable :: strict(:, :, :) !! errors allowed, of the accuracy; 0: any
  end type samples_type

  !> Ratio of half-space to strip energy at the points of axes of its own.
  type :: ratio_type
    type(axis_type) :: u, roll, q
    real(dp), allocatable :: c(:, :, :)      !! (q, u, roll)
    logical, allocatable :: there(:, :, :)   !! solved
    logical, allocatable :: done(:, :)       !! (u, roll)
    real(dp), allocatable :: weight(:, :, :) !! force over what its error is compared with
  end type ratio_type

  ! Extent of the finely spaced part of the first axes; on the throat a shift of 1 mm
  ! moves the patch by 10 mm, on the tread by about 1 mm.
  real(dp), parameter :: fine_flange = 3e-3_dp, fine_tread = 10e-3_dp   ! [m]
  real(dp), parameter :: fine_roll = 0.02_dp                            ! [rad]
  integer, parameter :: first_u = 31, first_roll = 21, first_q = 15
  real(dp), parameter :: grading = 1.25_dp                              ! of q towards 0
  ! Cells that are not halved any more: patches are larger.
  real(dp), parameter :: least_u = 0.02e-3_dp, least_roll = 0.5e-3_dp, least_q = 0.5e-3_dp   ! [m, rad, sqrt(m)]
  integer, parameter :: most_rounds = 9, rounds_of_q = 4
  integer, parameter :: first_ratio(3) = [21, 21, 7], rounds_of_ratio = 6, rounds_of_its_q = 2
  real(dp), parameter :: least_force = 5e3_dp                           ! that errors are compared with [N]
  real(dp), parameter :: lever = 0.75_dp                                ! of a wheel's force about X [m]
  ! Where contact moves from one arc of the profiles to the next h bends sharply, and misses more than is estimated.
  real(dp), parameter :: of_kinks = 3
  ! Shares of the accuracy that the splines of strips and of the ratio may use up.
  real(dp), parameter :: share_strip = 0.7_dp, share_ratio = 0.3_dp

contains

  !> Tabulate all zones of a pair for a normal model, to `accuracy` of max(force, 5 kN), with at most `most` points
  !> along u, roll and the root of the depth.
  subroutine build_table(pair, zones, model, e_star, extent, accuracy, most, key, table, watcher)
    type(pair_type), intent(in) :: pair
    type(zone_type), intent(in) :: zones(:)
    character(*), intent(in) :: model      !! 'strip', 'hertz' or 'halfspace'
    real(dp), intent(in) :: e_star         !! [Pa]
    type(extent_type), intent(in) :: extent
    real(dp), intent(in) :: accuracy
    integer, intent(in) :: most(3)
    character(*), intent(in) :: key
    type(contact_table), intent(out) :: table
    class(monitor_type), intent(inout), optional :: watcher
    type(samples_type) :: values(size(zones))
    type(ratio_type) :: ratio(size(zones))
    character(:), allocatable :: law
    type(axis_type) :: roll
    real(dp) :: work(2)                    ! its share of the whole work, from and to
    integer :: round, z
    logical :: finer, stopped

    law = model
    if (model == 'halfspace') law = 'strip'
    work = [0.0_dp, merge(0.4_dp, 1.0_dp, model == 'halfspace')]
    table%key = key
    allocate (table%zones(size(zones)))
    roll = new_axis(graded_points(-extent%roll, extent%roll, 0.0_dp, fine_roll, min(first_roll, most(2))))
    do z = 1, size(zones)
      call start_zone(pair, zones(z), extent, most, table%zones(z), values(z))
      call resize(values(z), values(z)%u, values(z)%q, roll, roll)
    end do
    stopped = .false.
    do round = 1, most_rounds
      call sample_rows(pair, zones, law, e_star, table, roll, values, part(work, round), stopped, watcher)
      if (stopped) return
      call fit(values, roll, table)
      if (round == most_rounds) exit
      call refine_axes(pair, extent, e_star, accuracy*share_strip, most, round <= rounds_of_q, table, values, &
        roll, finer)
      if (.not. finer) exit
    end do
    if (model /= 'halfspace') return

    call solve_ratios(pair, zones, e_star, extent, accuracy*share_ratio, most, values, table, ratio, &
      [work(2), 0.9_dp], stopped, watcher)
    if (stopped) return
    call unite(ratio, most, values, roll)
    call sample_rows(pair, zones, law, e_star, table, roll, values, [0.9_dp, 1.0_dp], stopped, watcher)
    if (stopped) return
    do z = 1, size(zones)
      call multiply(ratio(z), roll, values(z))
    end do
    call fit(values, roll, table)
  end subroutine build_table

  !> Share of the work done before and after a round, when each is expected to leave 0.6 of what is left.
  pure function part(work, round)
    real(dp), intent(in) :: work(2)
    integer, intent(in) :: round
    real(dp) :: part(2)

    part = work(1) + (work(2) - work(1))*[1 - 0.6_dp**(round - 1), 1 - 0.6_dp**round]
  end function part

  !> Where the zone's coordinates are, and its first axes.
  subroutine start_zone(pair, zone, extent, most, t, v)
    type(pair_type), intent(in) :: pair
    type(zone_type), intent(in) :: zone
    type(extent_type), intent(in) :: extent
    integer, intent(in) :: most(3)
    type(zone_table), intent(inout) :: t
    type(samples_type), intent(inout) :: v
    real(dp) :: centre(2), corners(2)
    integer :: i, n

    t%flange = zone%flange
    t%pole = zone%pole
    t%along = [cos(zone%alpha), sin(zone%alpha)]
    ! Reference pose: the zone just touches, where the wheelset is likely to be
    ! when it does.
    centre = [reference_shift(pair, zone), pair%axle_height]
    t%origin = [dot_product(centre + t%pole, t%along), dot_product(centre + t%pole, [-t%along(2), t%along(1)])]
    t%ceiling = pair%axle_height + t%pole(2) + extent%lift
    corners = [-extent%lateral - centre(1), extent%lateral - centre(1)]*t%along(1) &
      + [-extent%drop, extent%lift]*t%along(2)
    v%u = new_axis(graded_points(corners(1), corners(2), 0.0_dp, merge(fine_flange, fine_tread, zone%flange), &
      min(first_u, most(1))))
    n = min(first_q, most(3))
    v%q = new_axis([(((i - 1)/real(n - 1, dp))**grading*sqrt(extent%depth), i=1, n)])
  end subroutine start_zone

  !> Values on other axes: those at common points are kept, unless q has others.
  pure subroutine resize(v, u, q, roll, new_roll)
    type(samples_type), intent(inout) :: v
    type(axis_type), intent(in) :: u, q, roll, new_roll
    real(dp), allocatable :: h(:, :), s(:, :, :)
    logical, allocatable :: good(:, :)
    integer :: i, j, k, l

    allocate (h(u%n, new_roll%n), s(q%n, u%n, new_roll%n), good(u%n, new_roll%n))
    good = .false.
    h = -1
    s = 0
    if (allocated(v%h)) then
      l = 1
      do j = 1, new_roll%n
        if (new_roll%x(j) > roll%x(l)) l = l + 1
        if (new_roll%x(j) < roll%x(l)) cycle
        k = 1
        do i = 1, u%n
          if (u%x(i) > v%u%x(k)) k = k + 1
          if (u%x(i) < v%u%x(k)) cycle
          h(i, j) = v%h(k, l)
          if (q%n /= v%q%n) cycle
          s(:, i, j) = v%s(:, k, l)
          good(i, j) = v%good(k, l)
        end do
      end do
    end if
    v%u = u
    v%q = q
    call move_alloc(h, v%h)
    call move_alloc(s, v%s)
    call move_alloc(good, v%good)
  end subroutine resize

  !> Sample what is not there.
  subroutine sample_rows(pair, zones, law, e_star, table, roll, values, work, stopped, watcher)
    type(pair_type), intent(in) :: pair
    type(zone_type), intent(in) :: zones(:)
    character(*), intent(in) :: law
    real(dp), intent(in) :: e_star
    type(contact_table), intent(in) :: table
    type(axis_type), intent(in) :: roll
    type(samples_type), intent(inout) :: values(:)
    real(dp), intent(in) :: work(2)
    logical, intent(out) :: stopped
    class(monitor_type), intent(inout), optional :: watcher
    integer :: row, z, j, done

    stopped = .false.
    done = 0
    !$omp parallel do schedule(dynamic) private(z, j) shared(done, stopped)
    do row = 1, size(zones)*roll%n
      z = (row - 1)/roll%n + 1
      j = row - (z - 1)*roll%n
      call tell(work, done, size(zones)*roll%n, stopped, watcher)
      if (stopped) cycle
      call sample_row(pair, zones(z), law, e_star, table%zones(z), roll%x(j), values(z)%u%x, values(z)%q%x, &
        values(z)%good(:, j), values(z)%h(:, j), values(z)%s(:, :, j))
    end do
  end subroutine sample_rows

  !> Count a piece of the work; the thread that began it tells the watcher, who may want no more.
  subroutine tell(work, done, all, stopped, watcher)
    !$ use omp_lib, only: omp_get_thread_num
    real(dp), intent(in) :: work(2)
    integer, intent(inout) :: done
    integer, intent(in) :: all
    logical, intent(inout) :: stopped
    class(monitor_type), intent(inout), optional :: watcher
    integer :: before

    !$omp atomic capture
    before = done
    done = done + 1
    !$omp end atomic
    if (.not. present(watcher)) return
    !$ if (omp_get_thread_num() /= 0) return
    if (watcher%stop) return
    call watcher%tell('table', work(1) + (work(2) - work(1))*before/all)
    if (watcher%stop) stopped = .true.
  end subroutine tell

  !> The splines through the values.
  subroutine fit(values, roll, table)
    type(samples_type), intent(in) :: values(:)
    type(axis_type), intent(in) :: roll
    type(contact_table), intent(inout) :: table
    integer :: z

    !$omp parallel do
    do z = 1, size(values)
      associate (t => table%zones(z), v => values(z))
        t%u = v%u
        t%roll = roll
        t%q = v%q
        call fit_2d(roll, v%u, transpose(v%h), t%h)
        call fit_3d(v%q, roll, v%u, reshape(v%s, [v%q%n, roll%n, v%u%n], order=[1, 3, 2]), t%s)
        call bound_heights(t)
      end associate
    end do
  end subroutine fit

  !> Halve the cells of all axes in which the force errs by more than `aim`.
  subroutine refine_axes(pair, extent, e_star, aim, most, depths, table, values, roll, finer)
    type(pair_type), intent(in) :: pair
    type(extent_type), intent(in) :: extent
    real(dp), intent(in) :: e_star, aim
    integer, intent(in) :: most(3)
    logical, intent(in) :: depths          !! whether q may be halved, too
    type(contact_table), intent(in) :: table
    type(samples_type), intent(inout) :: values(:)
    type(axis_type), intent(inout) :: roll
    logical, intent(out) :: finer
    type(axis_type) :: u(size(values)), q(size(values)), old
    real(dp) :: of_roll(roll%n - 1, size(values))
    logical :: any_finer(3, size(values))
    integer :: z

    any_finer = .false.
    of_roll = 0
    !$omp parallel do schedule(dynamic)
    do z = 1, size(values)
      call refine_zone(z)
    end do
    old = roll
    call halve_cells(roll, maxval(of_roll, 2), least_roll, most(2), finer)
    finer = finer .or. any(any_finer)
    do z = 1, size(values)
      if (finer) call resize(values(z), u(z), q(z), old, roll)
    end do

  contains

    subroutine refine_zone(z)
      integer, intent(in) :: z
      real(dp), allocatable, dimension(:, :, :) :: by_value, by_slope, scale
      real(dp), allocatable :: of_u(:), of_q(:), flat(:, :), of_h(:, :), tilt_h(:, :)
      real(dp) :: depth, force, other, pose(3), strict
      integer :: i, j, m, nq, nu, nr
      logical :: within

      associate (v => values(z))
        nq = v%q%n
        nu = v%u%n
        nr = roll%n
        allocate (by_value(nq, nu, nr), by_slope(nq, nu, nr), scale(nq, nu, nr), of_h(nu, nr), tilt_h(nu, nr))
        allocate (of_u(nu - 1), of_q(nq - 1), source=0.0_dp)
        scale = 0
        of_h = 0
        tilt_h = 0
        do j = 1, nr
          do i = 1, nu
            if (.not. v%good(i, j)) cycle
            do m = 2, nq
              depth = v%q%x(m)**2
              pose = zone_pose(table%zones(z), v%u%x(i), v%h(i, j) - depth, roll%x(j))
              strict = strictness(pair, extent, pose, .false.)
              if (strict <= 0) cycle
              call find_reach(table, extent, z, depth, pose, .false., within, other)
              if (.not. within) cycle
              force = 2.5_dp*v%q%x(m)**3*v%s(m, i, j)
              ! The other's force as Hertz's on a radius of about 0.3 m.
              scale(m, i, j) = 1/(aim*strict*max(force, least_force, 0.7_dp*e_star*max(other, 0.0_dp)**1.5_dp))
              of_h(i, j) = max(of_h(i, j), of_kinks*3.75_dp*v%q%x(m)*v%s(m, i, j)*scale(m, i, j))
              tilt_h(i, j) = max(tilt_h(i, j), of_kinks*force*scale(m, i, j))
            end do
          end do
        end do
        do m = 1, nq
          by_value(m, :, :) = 2.5_dp*v%q%x(m)**3*scale(m, :, :)
          by_slope(m, :, :) = v%q%x(m)**5*scale(m, :, :)
        end do
        ! Along u: S with (u, q roll); h.
        call judge_cells(v%u, spread_u(v%s), spread_u(by_value), spread_u(by_slope), of_u)
        call judge_cells(v%u, v%h, of_h, tilt_h, of_u)
        call judge_cells(roll, spread_roll(v%s), spread_roll(by_value), spread_roll(by_slope)/lever, of_roll(:, z))
        call judge_cells(roll, transpose(v%h), transpose(of_h), transpose(tilt_h)/lever, of_roll(:, z))
        u(z) = v%u
        q(z) = v%q
        call halve_cells(u(z), of_u, least_u, most(1), any_finer(1, z))
        if (.not. depths) return
        do m = 1, nq
          by_slope(m, :, :) = 0.5_dp*v%q%x(m)**4*scale(m, :, :)
        end do
        flat = reshape(v%s, [nq, nu*nr])
        call judge_cells(v%q, flat, reshape(by_value, [nq, nu*nr]), reshape(by_slope, [nq, nu*nr]), of_q)
        call halve_cells(q(z), of_q, least_q, most(3), any_finer(3, z))
      end associate
    end subroutine refine_zone

  end subroutine refine_axes

  !> (q, u, roll) as lines along u.
  pure function spread_u(f) result(lines)
    real(dp), intent(in) :: f(:, :, :)
    real(dp) :: lines(size(f, 2), size(f, 1)*size(f, 3))

    lines = reshape(reshape(f, [size(f, 2), size(f, 1), size(f, 3)], order=[2, 1, 3]), shape(lines))
  end function spread_u

  !> (q, u, roll) as lines along roll.
  pure function spread_roll(f) result(lines)
    real(dp), intent(in) :: f(:, :, :)
    real(dp) :: lines(size(f, 3), size(f, 1)*size(f, 2))

    lines = transpose(reshape(f, [size(f, 1)*size(f, 2), size(f, 3)]))
  end function spread_roll

  !> Sample the ratios of all zones, on axes that are halved like those of S.
  subroutine solve_ratios(pair, zones, e_star, extent, aim, most, values, table, ratio, work, stopped, watcher)
    type(pair_type), intent(in) :: pair
    type(zone_type), intent(in) :: zones(:)
    real(dp), intent(in) :: e_star
    type(extent_type), intent(in) :: extent
    real(dp), intent(in) :: aim
    integer, intent(in) :: most(3)
    type(samples_type), intent(in) :: values(:)
    type(contact_table), intent(in) :: table
    type(ratio_type), intent(inout) :: ratio(:)
    real(dp), intent(in) :: work(2)
    logical, intent(out) :: stopped
    class(monitor_type), intent(inout), optional :: watcher
    type(elements_type) :: elements
    integer :: z, round
    logical :: finer(size(zones))

    elements = new_elements(6, 24, 1e-2_dp, e_star)
    do z = 1, size(zones)
      call start_ratio(ratio(z), graded_points(values(z)%u%low, values(z)%u%high, 0.0_dp, &
        merge(fine_flange, fine_tread, zones(z)%flange), min(first_ratio(1), most(1))), &
        graded_points(-extent%roll, extent%roll, 0.0_dp, fine_roll, min(first_ratio(2), most(2))), &
        first_depths(min(first_ratio(3), most(3)), values(z)%q%high))
    end do
    do round = 1, rounds_of_ratio
      call solve_rows()
      if (stopped) return
      !$omp parallel do schedule(dynamic)
      do z = 1, size(zones)
        call fill_gaps(ratio(z))
        call refine_ratio(z, finer(z))
      end do
      if (.not. any(finer)) exit
    end do
    ! The last halving has no values yet.
    if (any(finer)) call solve_rows()
    do z = 1, size(zones)
      call fill_gaps(ratio(z))
    end do

  contains

    subroutine solve_rows()
      integer :: row, z, j, done, n(0:size(zones))

      n(0) = 0
      do z = 1, size(zones)
        n(z) = n(z - 1) + ratio(z)%roll%n
      end do
      done = 0
      stopped = .false.
      !$omp parallel do schedule(dynamic) private(z, j)
      do row = 1, n(size(zones))
        call tell(part(work, round), done, n(size(zones)), stopped, watcher)
        if (stopped) cycle
        z = count(n(:size(zones) - 1) < row)
        j = row - n(z - 1)
        call sample_ratios(pair, zones, z, elements, table, extent, ratio(z)%roll%x(j), ratio(z)%u%x, &
          heights(table%zones(z), ratio(z)%u%x, ratio(z)%roll%x(j)), ratio(z)%q%x, ratio(z)%done(:, j), &
          ratio(z)%c(:, :, j), ratio(z)%there(:, :, j))
      end do
    end subroutine solve_rows

    !> Halve the axes where the force misses `aim`: an error of c changes the force like c itself, its slopes
    !> by the energy.
    subroutine refine_ratio(z, finer)
      integer, intent(in) :: z
      logical, intent(out) :: finer
      type(ratio_type) :: new
      real(dp), allocatable, dimension(:, :, :) :: by_value
      real(dp), allocatable :: of_u(:), of_roll(:), of_q(:)
      type(axis_type) :: u, a, q
      real(dp), allocatable :: h(:)
      real(dp) :: depth, other, pose(3), strict, force, c_h
      integer :: i, j, m
      logical :: more(3), within

      associate (r => ratio(z))
        allocate (by_value(r%q%n, r%u%n, r%roll%n), source=0.0_dp)
        do j = 1, r%roll%n
          h = heights(table%zones(z), r%u%x, r%roll%x(j))
          do i = 1, r%u%n
            do m = 2, r%q%n
              if (.not. r%there(m, i, j)) cycle
              depth = r%q%x(m)**2
              pose = zone_pose(table%zones(z), r%u%x(i), h(i) - depth, r%roll%x(j))
              strict = strictness(pair, extent, pose, .false.)
              if (strict <= 0) cycle
              call find_reach(table, extent, z, depth, pose, .false., within, other)
              if (.not. within) cycle
              c_h = 0.7_dp*e_star
              force = c_h*depth**1.5_dp
              by_value(m, i, j) = force/(aim*strict*max(force, least_force, c_h*max(other, 0.0_dp)**1.5_dp))
            end do
          end do
        end do
        allocate (of_u(r%u%n - 1), of_roll(r%roll%n - 1), of_q(r%q%n - 1), source=0.0_dp)
        call judge_cells(r%u, spread_u(r%c), spread_u(by_value), spread_u(scaled(by_value, 0.4_dp*r%q%x**2)), of_u)
        call judge_cells(r%roll, spread_roll(r%c), spread_roll(by_value), &
          spread_roll(scaled(by_value, 0.4_dp*r%q%x**2))/lever, of_roll)
        call judge_cells(r%q, reshape(r%c, [r%q%n, r%u%n*r%roll%n]), reshape(by_value, [r%q%n, r%u%n*r%roll%n]), &
          reshape(scaled(by_value, 0.2_dp*r%q%x), [r%q%n, r%u%n*r%roll%n]), of_q)
        u = r%u
        a = r%roll
        q = r%q
        call halve_cells(u, of_u, 4*least_u, most(1), more(1))
        call halve_cells(a, of_roll, 2*least_roll, most(2), more(2))
        more(3) = .false.
        if (round <= rounds_of_its_q) call halve_cells(q, of_q, 2*least_q, most(3), more(3))
        finer = any(more)
        if (.not. finer) return
        call start_ratio(new, u%x, a%x, q%x)
        call carry_over(r, new)
        r = new
      end associate
    end subroutine refine_ratio

  end subroutine solve_ratios

  !> h of a zone at many u.
  pure function heights(t, u, roll) result(h)
    type(zone_table), intent(in) :: t
    real(dp), intent(in) :: u(:), roll
    real(dp) :: h(size(u))
    type(basis_type) :: bu, br
    integer :: i

    call axis_basis(t%roll, roll, br, .false.)
    do i = 1, size(u)
      call axis_basis(t%u, u(i), bu, .false.)
      h(i) = spline_2d_value(t%h, br, bu)
    end do
  end function heights

  pure function scaled(f, factor)
    real(dp), intent(in) :: f(:, :, :), factor(:)
    real(dp) :: scaled(size(f, 1), size(f, 2), size(f, 3))
    integer :: m

    do m = 1, size(f, 1)
      scaled(m, :, :) = f(m, :, :)*factor(m)
    end do
  end function scaled

  pure subroutine start_ratio(r, u, roll, q)
    type(ratio_type), intent(out) :: r
    real(dp), intent(in) :: u(:), roll(:), q(:)

    r%u = new_axis(u)
    r%roll = new_axis(roll)
    r%q = new_axis(q)
    allocate (r%c(size(q), size(u), size(roll)), source=1.0_dp)
    allocate (r%there(size(q), size(u), size(roll)), source=.false.)
    allocate (r%done(size(u), size(roll)), source=.false.)
  end subroutine start_ratio

  !> Square roots of penetrations.  The strips' modulus is a mean over more than the smallest patches: the ratio
  !> varies down to 0.
  pure function first_depths(n, deepest) result(q)
    integer, intent(in) :: n
    real(dp), intent(in) :: deepest
    real(dp) :: q(n)
    integer :: i

    q = [0.0_dp, 0.06_dp*deepest, (((i - 2)/real(n - 2, dp))**grading*deepest, i=3, n)]
  end function first_depths

  !> Keep what was solved at points of the finer axes.
  pure subroutine carry_over(old, new)
    type(ratio_type), intent(in) :: old
    type(ratio_type), intent(inout) :: new
    integer :: i, j, m, k, l, n

    l = 1
    do j = 1, new%roll%n
      if (new%roll%x(j) > old%roll%x(l)) l = l + 1
      if (new%roll%x(j) < old%roll%x(l)) cycle
      k = 1
      do i = 1, new%u%n
        if (new%u%x(i) > old%u%x(k)) k = k + 1
        if (new%u%x(i) < old%u%x(k)) cycle
        n = 1
        do m = 1, new%q%n
          if (new%q%x(m) > old%q%x(n)) n = n + 1
          if (new%q%x(m) < old%q%x(n)) cycle
          new%c(m, i, j) = old%c(n, k, l)
          new%there(m, i, j) = old%there(n, k, l)
        end do
        new%done(i, j) = new%q%n == old%q%n .and. old%done(k, l)
      end do
    end do
  end subroutine carry_over

  !> Where no run comes the ratio goes on along roll, on which it hardly depends, else along u, else along q.
  pure subroutine fill_gaps(r)
    type(ratio_type), intent(inout) :: r
    logical :: known(size(r%c, 1), size(r%c, 2), size(r%c, 3))
    integer :: i, j, m

    known = r%there
    do m = 1, r%q%n
      do i = 1, r%u%n
        call continue_line(r%roll%x, r%c(m, i, :), known(m, i, :))
      end do
      do j = 1, r%roll%n
        call continue_line(r%u%x, r%c(m, :, j), known(m, :, j))
      end do
    end do
    do j = 1, r%roll%n
      do i = 1, r%u%n
        call continue_line(r%q%x, r%c(:, i, j), known(:, i, j))
      end do
    end do
    where (.not. known) r%c = 1
  end subroutine fill_gaps

  !> Straight between known values; beyond them for two cells, then constant.
  pure subroutine continue_line(x, f, known)
    real(dp), intent(in) :: x(:)
    real(dp), intent(inout) :: f(:)
    logical, intent(inout) :: known(:)
    integer :: i, low, high, n

    if (all(known) .or. .not. any(known)) return
    n = size(f)
    low = 0
    high = 0
    do i = 1, n
      if (known(i)) then
        low = i
        cycle
      end if
      if (high < i) high = i - 1 + findloc(known(i:), .true., 1)
      if (low > 0 .and. high >= i) then
        f(i) = f(low) + (f(high) - f(low))*(x(i) - x(low))/(x(high) - x(low))
      else if (low > 1) then
        f(i) = f(low)
        if (known(low - 1)) f(i) = f(low) + (f(low) - f(low - 1))*min((x(i) - x(low))/(x(low) - x(low - 1)), 2.0_dp)
      else if (low == 0) then
        f(i) = f(high)
        if (high < n) then
          if (known(high + 1)) f(i) = f(high) + (f(high) - f(high + 1)) &
            *min((x(high) - x(i))/(x(high + 1) - x(high)), 2.0_dp)
        end if
      else
        f(i) = f(low)
      end if
    end do
    known = .true.
  end subroutine continue_line

  !> Axes that have the points of the ratios', too.
  subroutine unite(ratio, most, values, roll)
    type(ratio_type), intent(in) :: ratio(:)
    integer, intent(in) :: most(3)
    type(samples_type), intent(inout) :: values(:)
    type(axis_type), intent(inout) :: roll
    type(axis_type) :: old
    integer :: z

    old = roll
    do z = 1, size(ratio)
      roll = united(roll, ratio(z)%roll, least_roll, most(2))
    end do
    do z = 1, size(ratio)
      call resize(values(z), united(values(z)%u, ratio(z)%u, least_u, most(1)), values(z)%q, old, roll)
    end do
  end subroutine unite

  pure function united(a, b, least, most) result(axis)
    type(axis_type), intent(in) :: a, b
    real(dp), intent(in) :: least
    integer, intent(in) :: most
    type(axis_type) :: axis
    real(dp) :: x(a%n + b%n)
    integer :: i, j, n

    n = 0
    j = 1
    do i = 1, a%n
      do while (j <= b%n)
        if (b%x(j) >= a%x(i)) exit
        if (b%x(j) > a%x(max(i - 1, 1)) + least/2 .and. b%x(j) < a%x(i) - least/2 .and. n + a%n - i + 1 < most) then
          n = n + 1
          x(n) = b%x(j)
        end if
        j = j + 1
      end do
      n = n + 1
      x(n) = a%x(i)
    end do
    axis = new_axis(x(:n))
  end function united

  !> S of half-spaces from S of strips.
  subroutine multiply(r, roll, v)
    type(ratio_type), intent(in) :: r
    type(axis_type), intent(in) :: roll
    type(samples_type), intent(inout) :: v
    real(dp), allocatable :: c(:, :, :)
    type(basis_type) :: bu, br, bq(v%q%n)
    integer :: i, j, m

    call fit_3d(r%q, r%roll, r%u, reshape(r%c, [r%q%n, r%roll%n, r%u%n], order=[1, 3, 2]), c)
    do m = 1, v%q%n
      call axis_basis(r%q, v%q%x(m), bq(m), .false.)
    end do
    do j = 1, roll%n
      call axis_basis(r%roll, roll%x(j), br, .false.)
      do i = 1, v%u%n
        call axis_basis(r%u, v%u%x(i), bu, .false.)
        do m = 1, v%q%n
          v%s(m, i, j) = v%s(m, i, j)*spline_3d_value(c, bq(m), br, bu)
        end do
      end do
    end do
  end subroutine multiply

end module table
