!> The generator of the contact table of a wheel/rail pair: it tabulates h and S of
!> `potential` for every zone, and the correction of the half-space model, on axes
!> that are finest where wheelsets run; and keeps tables in files.
module table
  use, intrinsic :: iso_fortran_env, only: int64
  use bspline, only: axis_basis, axis_point, axis_type, basis_type, fit_2d, fit_3d, graded_axis, spline_2d_value, &
    uniform_axis
  use contact, only: branch_energy, max_zones, set_moduli, zone_energy, zone_type
  use errors, only: error_type, fatal_error
  use geometry, only: keep_feet, new_scan, pair_type, rolled, scan_depth, scan_type, touch
  use kinds, only: dp
  use potential, only: bound_heights, contact_table, correction_table, zone_table
  use progress, only: monitor_type
  use system, only: finish_file, scratch_name
  implicit none
  private
  public :: grid_type, build_table, save_table, load_table

  !> Extent and resolution of the table.
  type :: grid_type
    real(dp) :: lateral = 60e-3_dp      !! shift of the wheel to either side [m]
    real(dp) :: lift = 40e-3_dp         !! of the wheel; higher it cannot touch [m]
    real(dp) :: drop = 10e-3_dp         !! of the wheel below its running height [m]
    real(dp) :: roll = 0.5_dp           !! to either side [rad]
    real(dp) :: depth = 2.2e-3_dp       !! largest penetration [m]
    integer :: n_lateral = 240          !! points in u of a flange zone; half as many for the tread
    integer :: n_roll = 53, n_depth = 33
  end type grid_type

  ! Extent of the finely spaced part of the axes; on the throat a shift of 1 mm
  ! moves the patch by 10 mm, on the tread by about 1 mm.
  real(dp), parameter :: fine_flange = 3e-3_dp, fine_tread = 10e-3_dp   ! [m]
  real(dp), parameter :: fine_roll = 0.02_dp                            ! [rad]

  ! The same of the half-space correction of tread and flange, and points.
  real(dp), parameter :: fine_u(2) = [10e-3_dp, 1e-3_dp], fine_p = 0.1e-3_dp   ! [m]
  integer, parameter :: n_u(2) = [24, 104], n_roll = 13, n_p = 28
  ! Outside these the pose presses the end of a zone into the rail, where another zone
  ! would have touched long before.
  real(dp), parameter :: bounds(2) = [0.6_dp, 2.5_dp]
  ! Beyond these the correction stays what it is: the wheelset lies on its side, or beside the rail.
  real(dp), parameter :: reach_roll = 0.15_dp, reach_u = 32e-3_dp
  real(dp), parameter :: far = 20e-3_dp   ! the zone's distance at which another one may still touch [m]

  !> What a table depends on besides its key; it begins the file.
  real(dp), parameter :: constants(*) = [fine_flange, fine_tread, fine_roll, fine_u, fine_p, real(n_u, dp), &
    real(n_roll, dp), real(n_p, dp), bounds, reach_roll, reach_u, far]
  character(*), parameter :: kind = 'ldbench contact table', magic = kind//' 9'

contains

  !> Tabulate all zones of a pair for a normal model.
  subroutine build_table(pair, zones, model, e_star, grid, key, table, watcher)
    type(pair_type), intent(in) :: pair
    type(zone_type), intent(in) :: zones(:)
    character(*), intent(in) :: model      !! of `contact`
    real(dp), intent(in) :: e_star         !! [Pa]
    type(grid_type), intent(in) :: grid
    character(*), intent(in) :: key
    type(contact_table), intent(out) :: table
    class(monitor_type), intent(inout), optional :: watcher
    character(:), allocatable :: law
    real(dp) :: share                      ! of the zones in the work
    integer :: i

    law = model
    share = 1
    if (model == 'halfspace') then
      law = 'strip'
      share = 0.3_dp
    end if
    table%key = key
    allocate (table%zones(size(zones)))
    do i = 1, size(zones)
      call build_zone(pair, zones(i), law, e_star, grid, table%zones(i), &
        share*(i - 1)/size(zones), share*i/size(zones), watcher)
    end do
    if (model == 'halfspace') then
      call build_correction(pair, zones, .false., e_star, table, table%correction(1), share, 0.4_dp, watcher)
      call build_correction(pair, zones, .true., e_star, table, table%correction(2), 0.4_dp, 1.0_dp, watcher)
    end if
  end subroutine build_table

  subroutine build_zone(pair, zone, model, e_star, grid, t, from, to, watcher)
    type(pair_type), intent(in) :: pair
    type(zone_type), intent(in) :: zone
    character(*), intent(in) :: model
    real(dp), intent(in) :: e_star
    type(grid_type), intent(in) :: grid
    type(zone_table), intent(out) :: t
    real(dp), intent(in) :: from, to       !! its share of the whole work
    class(monitor_type), intent(inout), optional :: watcher
    real(dp), allocatable :: h(:, :), s(:, :, :), k(:)
    type(scan_type) :: work, pressed       ! touching; pressed in
    real(dp) :: station, roll, centre(2), along(2), across(2), shift, corners(2)
    integer :: i, j, middle, way
    logical :: ok

    t%flange = zone%flange
    t%pole = zone%pole
    along = [cos(zone%alpha), sin(zone%alpha)]
    t%along = along
    across = [-along(2), along(1)]

    ! Reference pose: the zone just touches, where the wheelset is likely to be
    ! when it does.
    work = new_scan(pair)
    pressed = new_scan(pair)
    allocate (k(size(pair%s)))
    centre = [reference_shift(pair, zone), pair%axle_height]
    t%origin = [dot_product(centre + t%pole, along), dot_product(centre + t%pole, across)]
    t%ceiling = pair%axle_height + t%pole(2) + grid%lift

    corners = [-grid%lateral - centre(1), grid%lateral - centre(1)]*along(1) &
      + [-grid%drop, grid%lift]*along(2)
    if (zone%flange) then
      t%u = graded_axis(corners(1), corners(2), 0.0_dp, fine_flange, grid%n_lateral)
    else
      t%u = graded_axis(corners(1), corners(2), 0.0_dp, fine_tread, grid%n_lateral/2)
    end if
    t%roll = graded_axis(-grid%roll, grid%roll, 0.0_dp, fine_roll, grid%n_roll)
    t%q = uniform_axis(0.0_dp, sqrt(grid%depth), grid%n_depth)

    allocate (h(t%roll%n, t%u%n), s(t%q%n, t%roll%n, t%u%n))
    ! Where no pose is found that touches, none does.
    h = -1
    s = 0
    middle = minloc([(abs(axis_point(t%u, i)), i=1, t%u%n)], 1)
    do j = 1, t%roll%n
      if (stopped(from + (to - from)*(j - 1)/t%roll%n, watcher)) return
      roll = axis_point(t%roll, j)
      call set_moduli(pair, zone, e_star, roll, k)
      do way = 1, -1, -2
        work%fresh = .true.
        shift = 0.02_dp
        ok = .true.
        do i = merge(middle, middle - 1, way == 1), merge(t%u%n, 1, way == 1), way
          if (ok) then
            call touch_at(axis_point(t%u, i))
            if (ok) h(j, i) = shift
            if (ok) call fill_depths(s(:, j, i))
          end if
          if (.not. ok) then
            ! Beside the rail: continue smoothly, far below any pose in reach.
            h(j, i) = h(j, i - way) + (h(j, i - way) - h(j, i - 2*way)) &
              /(axis_point(t%u, i - way) - axis_point(t%u, i - 2*way)) &
              *(axis_point(t%u, i) - axis_point(t%u, i - way))
            s(:, j, i) = s(:, j, i - way)
          end if
        end do
      end do
    end do
    call fit_2d(h, t%h)
    call fit_3d(s, t%s)
    call bound_heights(t)

  contains

    !> Height `shift` along w at which the zone touches.
    subroutine touch_at(u)
      real(dp), intent(in) :: u
      real(dp) :: move

      centre = (t%origin(1) + u)*along + (t%origin(2) + shift)*across - rolled(t%pole, roll)
      call touch(pair, work, zone%first, zone%last, centre, roll, zone%alpha, move, station, ok)
      centre = centre + move*across
      shift = shift + move
    end subroutine touch_at

    !> S from just touching to the largest depth, deepest first: the stations
    !> inside the rail only become fewer.
    subroutine fill_depths(s)
      real(dp), intent(out) :: s(:)
      type(zone_type) :: active
      real(dp) :: q
      integer :: m

      active = zone
      call narrow(active, work%depth + t%q%high**2)
      call keep_feet(work, active%first, active%last, pressed)
      do m = t%q%n, 2, -1
        q = axis_point(t%q, m)
        call scan_depth(pair, centre - q**2*across, roll, active%first, active%last, pressed)
        call narrow(active, pressed%depth)
        s(m) = zone_energy(pair, active, model, e_star, roll, pressed, k)/q**5
      end do
      ! S(0) is a limit; patches that small would see the rounding of the profile's
      ! points, so it is extrapolated.
      s(1) = 3*(s(2) - s(3)) + s(4)
    end subroutine fill_depths

    !> Drop stations at both ends that are outside the rail.
    subroutine narrow(active, depth)
      type(zone_type), intent(inout) :: active
      real(dp), intent(in) :: depth(:)

      do while (active%first < active%last - 3 .and. all(depth(active%first:active%first + 2) < 0))
        active%first = active%first + 1
      end do
      do while (active%last > active%first + 3 .and. all(depth(active%last - 2:active%last) < 0))
        active%last = active%last - 1
      end do
    end subroutine narrow

  end subroutine build_zone

  !> Ratio of half-space to strip energy of the tread or the flange.
  subroutine build_correction(pair, zones, flange, e_star, table, t, from, to, watcher)
    type(pair_type), intent(in) :: pair
    type(zone_type), intent(in) :: zones(:)
    logical, intent(in) :: flange
    real(dp), intent(in) :: e_star         !! [Pa]
    type(contact_table), intent(in) :: table   !! of strips
    type(correction_table), intent(out) :: t
    real(dp), intent(in) :: from, to       !! its share of the whole work
    class(monitor_type), intent(inout), optional :: watcher
    real(dp), allocatable :: ratio(:, :, :), k(:)
    type(scan_type) :: work
    type(basis_type) :: bu, br
    real(dp) :: u, roll, w, centre(2), strip, exact
    integer :: branch, zone, first, last, i, j, m, n
    logical :: ok

    branch = merge(2, 1, flange)
    ! The tread's running zone is the first, the flange face is in the last.
    zone = merge(size(zones), 1, flange)
    t%zone = zone
    first = minval(zones%first, zones%flange .eqv. flange)
    last = maxval(zones%last, zones%flange .eqv. flange)
    associate (z => table%zones(zone))
      t%u = graded_axis(z%u%low, z%u%high, 0.0_dp, fine_u(branch), n_u(branch))
      t%roll = graded_axis(z%roll%low, z%roll%high, 0.0_dp, fine_roll, n_roll)
      t%p = graded_axis(-far, z%q%high**2, 0.0_dp, fine_p, n_p)
      allocate (ratio(n_p, t%roll%n, t%u%n), k(size(pair%s)))
      work = new_scan(pair)
      do j = 1, t%roll%n
        if (stopped(from + (to - from)*(j - 1)/t%roll%n, watcher)) return
        roll = axis_point(t%roll, j)
        if (abs(roll) > reach_roll) cycle
        call axis_basis(z%roll, roll, br)
        do n = 1, size(zones)
          call set_moduli(pair, zones(n), e_star, roll, k)
        end do
        do i = 1, t%u%n
          u = axis_point(t%u, i)
          if (abs(u) > reach_u) cycle
          call axis_basis(z%u, u, bu)
          work%fresh = .true.
          ratio(:, j, i) = 1
          do m = n_p, 1, -1
            w = spline_2d_value(z%h, br, bu) - axis_point(t%p, m)
            centre = (z%origin(1) + u)*z%along + (z%origin(2) + w)*[-z%along(2), z%along(1)] &
              - rolled(z%pole, roll)
            call scan_depth(pair, centre, roll, first, last, work)
            work%fresh = .false.
            if (m < n_p) ratio(m, j, i) = ratio(m + 1, j, i)
            ! Poses far inside the rail are beyond the table; those without overlap have no ratio.
            if (maxval(work%depth(first:last)) > 2*z%q%high**2) cycle
            strip = 0
            do n = 1, size(zones)
              if (zones(n)%flange .eqv. flange) &
                strip = strip + zone_energy(pair, zones(n), 'strip', e_star, roll, work, k)
            end do
            if (strip <= 0) exit
            call branch_energy(pair, first, last, e_star, centre, roll, work, exact, ok)
            if (ok) ratio(m, j, i) = max(bounds(1), min(exact/strip, bounds(2)))
          end do
          if (m > 0) ratio(:m, j, i) = ratio(min(m + 1, n_p), j, i)
        end do
      end do
    end associate
    do i = 1, n_p
      call hold(t%u, reach_u, 2, ratio(i, :, :))
      call hold(t%roll, reach_roll, 1, ratio(i, :, :))
    end do
    call fit_3d(ratio, t%c)
  end subroutine build_correction

  !> Continue values by the last one within `reach` along one dimension of a plane.
  subroutine hold(axis, reach, along, plane)
    type(axis_type), intent(in) :: axis
    real(dp), intent(in) :: reach
    integer, intent(in) :: along
    real(dp), intent(inout) :: plane(:, :)
    integer :: i, first, last
    logical :: within(axis%n)

    within = [(abs(axis_point(axis, i)) <= reach, i=1, axis%n)]
    first = findloc(within, .true., 1)
    last = findloc(within, .true., 1, back=.true.)
    do i = 1, axis%n
      if (within(i)) cycle
      if (along == 1) plane(i, :) = plane(max(first, min(i, last)), :)
      if (along == 2) plane(:, i) = plane(:, max(first, min(i, last)))
    end do
  end subroutine hold

  !> Tell the watcher the share of the work done; whether it wants no more.
  logical function stopped(share, watcher)
    real(dp), intent(in) :: share
    class(monitor_type), intent(inout), optional :: watcher

    stopped = .false.
    if (.not. present(watcher)) return
    call watcher%tell('table', share)
    stopped = watcher%stop
  end function stopped

  !> Lateral shift of the wheelset at which a zone is expected to touch: 0 for
  !> the tread; for a flange zone where it is as low as the running tread.
  real(dp) function reference_shift(pair, zone) result(y)
    type(pair_type), intent(in) :: pair
    type(zone_type), intent(in) :: zone
    type(scan_type) :: work
    real(dp) :: low, high, shift, station
    integer :: iter
    logical :: ok

    y = 0
    if (.not. zone%flange) return
    work = new_scan(pair)
    low = -0.02_dp
    high = 0.04_dp
    do iter = 1, 20
      y = (low + high)/2
      work%fresh = .true.
      call touch(pair, work, zone%first, zone%last, [y, pair%axle_height + 0.03_dp], 0.0_dp, 0.0_dp, &
        shift, station, ok)
      if (ok .and. shift > -0.03_dp) then
        high = y
      else
        low = y
      end if
    end do
  end function reference_shift

  !> Write a table to a file, complete or not at all.
  subroutine save_table(file, table, error)
    character(*), intent(in) :: file
    type(contact_table), intent(in) :: table
    type(error_type), allocatable, intent(out) :: error
    character(:), allocatable :: scratch
    integer :: unit, stat, i

    scratch = scratch_name(file)
    open (newunit=unit, file=scratch, access='stream', form='unformatted', action='write', &
      status='replace', iostat=stat)
    if (stat /= 0) then
      call fatal_error(error, '&table file = '//file//': cannot be written')
      return
    end if
    write (unit, iostat=stat) magic, constants, len(table%key), table%key, size(table%zones)
    do i = 1, size(table%zones)
      associate (t => table%zones(i))
        if (stat == 0) write (unit, iostat=stat) t%flange, t%along, t%pole, t%origin, t%ceiling, &
          t%u, t%roll, t%q, t%h, t%s
      end associate
    end do
    do i = 1, size(table%correction)
      associate (t => table%correction(i))
        if (stat == 0) write (unit, iostat=stat) t%zone, t%u, t%roll, t%p
        if (stat == 0 .and. t%zone > 0) write (unit, iostat=stat) t%c
      end associate
    end do
    if (stat == 0) write (unit, iostat=stat) fingerprint(table), magic
    call finish_file(unit, scratch, file, stat)
    if (stat /= 0) call fatal_error(error, '&table file = '//file//': cannot be written')
  end subroutine save_table

  !> Read a table that was made for `key`; `found` is false when the file is absent, damaged or
  !> made for something else.  An error when it is no table: it would be lost.
  subroutine load_table(file, key, table, found, error)
    character(*), intent(in) :: file, key
    type(contact_table), intent(out) :: table
    logical, intent(out) :: found
    type(error_type), allocatable, intent(out) :: error
    character(len(magic)) :: mark
    character(len(key)) :: stored
    real(dp) :: made_with(size(constants))
    integer :: unit, stat, length, n, i
    integer(int64) :: sum_stored, bytes

    found = .false.
    open (newunit=unit, file=file, access='stream', form='unformatted', action='read', &
      status='old', iostat=stat)
    if (stat /= 0) return
    inquire (unit=unit, size=bytes)
    n = int(min(bytes, len(kind, int64)))
    read (unit, iostat=stat) mark(:n)
    if (stat /= 0 .or. mark(:n) /= kind(:n)) then
      call fatal_error(error, '&table file = '//file//': expected a contact table or no file, found another one')
      close (unit)
      return
    end if
    read (unit, pos=1, iostat=stat) mark, made_with, length
    ! Bits, for a damaged file may hold what is not a number.
    if (stat == 0) found = mark == magic .and. length == len(key) .and. &
      all(transfer(made_with, [0_int64]) == transfer(constants, [0_int64]))
    if (found) then
      read (unit, iostat=stat) stored, n
      found = stat == 0
      if (found) found = stored == key .and. n >= 1 .and. n <= max_zones
    end if
    if (found) then
      table%key = key
      allocate (table%zones(n))
      do i = 1, n
        associate (t => table%zones(i))
          read (unit, iostat=stat) t%flange, t%along, t%pole, t%origin, t%ceiling, t%u, t%roll, t%q
          if (stat /= 0) exit
          allocate (t%h(t%roll%n + 2, t%u%n + 2), t%s(t%q%n + 2, t%roll%n + 2, t%u%n + 2), stat=stat)
          if (stat == 0) read (unit, iostat=stat) t%h, t%s
          if (stat /= 0) exit
        end associate
      end do
      do i = 1, size(table%correction)
        associate (t => table%correction(i))
          if (stat == 0) read (unit, iostat=stat) t%zone, t%u, t%roll, t%p
          if (stat /= 0 .or. t%zone == 0) cycle
          allocate (t%c(t%p%n + 2, t%roll%n + 2, t%u%n + 2), stat=stat)
          if (stat == 0) read (unit, iostat=stat) t%c
        end associate
      end do
      if (stat == 0) read (unit, iostat=stat) sum_stored, mark
      found = stat == 0
      if (found) found = mark == magic
      if (found) found = sum_stored == fingerprint(table)
      if (found) then
        do i = 1, n
          call bound_heights(table%zones(i))
        end do
      end if
    end if
    close (unit)
  end subroutine load_table

  !> A number that changes with every bit of the table.
  integer(int64) function fingerprint(table) result(mix)
    type(contact_table), intent(in) :: table
    integer :: i, k

    mix = 0
    do i = 1, size(table%zones)
      associate (t => table%zones(i))
        call stir([merge(1.0_dp, 0.0_dp, t%flange), t%along, t%pole, t%origin, t%ceiling])
        call stir(axis_numbers(t%u))
        call stir(axis_numbers(t%roll))
        call stir(axis_numbers(t%q))
        do k = 1, size(t%h, 2)
          call stir(t%h(:, k))
        end do
        do k = 1, size(t%s, 3)
          call stir(reshape(t%s(:, :, k), [size(t%s, 1)*size(t%s, 2)]))
        end do
      end associate
    end do
    do i = 1, size(table%correction)
      associate (t => table%correction(i))
        call stir([real(t%zone, dp)])
        if (t%zone == 0) cycle
        call stir(axis_numbers(t%u))
        call stir(axis_numbers(t%roll))
        call stir(axis_numbers(t%p))
        call stir(reshape(t%c, [size(t%c)]))
      end associate
    end do

  contains

    pure function axis_numbers(axis) result(numbers)
      type(axis_type), intent(in) :: axis
      real(dp) :: numbers(9)

      numbers = [real(axis%n, dp), axis%centre, axis%scale, axis%first, axis%step, axis%per_step, axis%per_scale, &
        axis%low, axis%high]
    end function axis_numbers

    subroutine stir(numbers)
      real(dp), intent(in) :: numbers(:)
      integer :: j

      do j = 1, size(numbers)
        mix = ieor(ishftc(mix, 5), transfer(numbers(j), mix))
      end do
    end subroutine stir

  end function fingerprint

end module table
