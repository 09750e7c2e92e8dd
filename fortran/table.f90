!> The contact table of a wheel/rail pair: one C2 potential, looked up.
!>
!> Per zone, in coordinates of the zone's pole (u along the rail's tangent at the
!> zone's mean contact angle, w along its normal, roll phi):
!>
!>     p = h(u, phi) - w                    penetration; h: where the zone touches
!>     U = S(u, phi, q) q^5,  q = sqrt(p+)
!>
!> For a Hertzian patch U goes with p^(5/2), for a patch cut by the end of its
!> zone with p^3, so S is smooth in q.  h and S are tensor cubic B-splines.  Forces are
!> the exact gradient of the interpolant and stiffnesses its exact Hessian, so
!> energy is conserved whatever the resolution.
module table
  use, intrinsic :: iso_fortran_env, only: int64
  use bspline, only: axis_basis, axis_holds, axis_point, axis_type, basis_type, fit_axis, &
    graded_axis, spline_2d, spline_2d_value, spline_3d, uniform_axis
  use contact, only: find_zones, set_moduli, zone_energy, zone_type
  use errors, only: error_type, fatal_error
  use geometry, only: new_scan, pair_type, rolled, scan_depth, scan_type, touch
  use kinds, only: dp
  use progress, only: monitor_type
  use system, only: replace_file, scratch_name
  implicit none
  private
  public :: grid_type, zone_table, contact_table, build_table, wheel_potential, save_table, load_table
  public :: inside, outside_lateral, outside_roll, outside_depth

  !> Extent and resolution of the table.
  type :: grid_type
    real(dp) :: lateral = 60e-3_dp      !! shift of the wheel to either side [m]
    real(dp) :: lift = 40e-3_dp         !! of the wheel; higher it cannot touch [m]
    real(dp) :: drop = 10e-3_dp         !! of the wheel below its running height [m]
    real(dp) :: roll = 0.35_dp          !! to either side [rad]
    real(dp) :: depth = 2.2e-3_dp       !! largest penetration [m]
    integer :: n_lateral = 300          !! points in u of a flange zone; half as many for the tread
    integer :: n_roll = 49, n_depth = 33
  end type grid_type

  type :: zone_table
    logical :: flange = .false.
    real(dp) :: along(2) = 0            !! direction of u, track frame
    real(dp) :: pole(2) = 0             !! wheelset frame [m]
    real(dp) :: origin(2) = 0           !! u, w of the pole in the reference pose [m]
    real(dp) :: ceiling = 0             !! Z of the pole above which nothing touches [m]
    type(axis_type) :: u, roll, q
    real(dp), allocatable :: h(:, :)    !! coefficients over (roll, u)
    real(dp), allocatable :: s(:, :, :) !! coefficients over (q, roll, u)
  end type zone_table

  type :: contact_table
    character(:), allocatable :: key    !! everything that the table depends on
    type(zone_table), allocatable :: zones(:)
  end type contact_table

  !> Whether a pose is on the table.
  enum, bind(c)
    enumerator :: inside = 0, outside_lateral, outside_roll, outside_depth
  end enum

  character(*), parameter :: magic = 'ldbench contact table 2'

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
    integer :: i

    table%key = key
    allocate (table%zones(size(zones)))
    do i = 1, size(zones)
      call build_zone(pair, zones(i), model, e_star, grid, table%zones(i), &
        (i - 1.0_dp)/size(zones), real(i, dp)/size(zones), watcher)
    end do
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
    ! Extent of the finely spaced part of the axes; on the throat a shift of 1 mm
    ! moves the patch by 10 mm, on the tread by about 1 mm.
    real(dp), parameter :: fine_flange = 3e-3_dp, fine_tread = 10e-3_dp   ! [m]
    real(dp), parameter :: fine_roll = 0.02_dp                            ! [rad]
    real(dp), allocatable :: h(:, :), s(:, :, :), k(:)
    type(scan_type) :: work
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
    middle = minloc([(abs(axis_point(t%u, i)), i=1, t%u%n)], 1)
    do j = 1, t%roll%n
      if (present(watcher)) then
        call watcher%report('table', from + (to - from)*(j - 1)/t%roll%n)
        if (watcher%stop) return
      end if
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
    call fit(h, s, t)

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
      do m = t%q%n, 2, -1
        q = axis_point(t%q, m)
        s(m) = energy_at(q, active)/q**5
      end do
      ! S(0) is a limit; patches that small would see the rounding of the profile's
      ! points, so it is extrapolated.
      s(1) = 3*(s(2) - s(3)) + s(4)
    end subroutine fill_depths

    real(dp) function energy_at(q, active) result(energy)
      real(dp), intent(in) :: q
      type(zone_type), intent(inout) :: active

      call scan_depth(pair, centre - q**2*across, roll, active%first, active%last, work)
      energy = zone_energy(pair, active, model, e_star, roll, work, k)
      do while (active%first < active%last - 3 .and. work%depth(active%first + 2) < 0)
        active%first = active%first + 1
      end do
      do while (active%last > active%first + 3 .and. work%depth(active%last - 2) < 0)
        active%last = active%last - 1
      end do
    end function energy_at

  end subroutine build_zone

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

  !> Spline coefficients of h(roll, u) and S(q, roll, u).
  subroutine fit(h, s, t)
    real(dp), intent(in) :: h(:, :), s(:, :, :)
    type(zone_table), intent(inout) :: t
    real(dp), allocatable :: a(:, :), b(:, :), c(:, :, :)
    integer :: nq, nr, nu

    nq = size(s, 1)
    nr = size(s, 2)
    nu = size(s, 3)
    allocate (a(nr + 2, nu), b(nu + 2, nr + 2))
    call fit_axis(h, a)
    call fit_axis(transpose(a), b)
    t%h = transpose(b)
    deallocate (a, b)

    allocate (a(nq + 2, nr*nu))
    call fit_axis(reshape(s, [nq, nr*nu]), a)
    c = reshape(a, [nr, nq + 2, nu], order=[2, 1, 3])
    deallocate (a)
    allocate (a(nr + 2, (nq + 2)*nu))
    call fit_axis(reshape(c, [nr, (nq + 2)*nu]), a)
    c = reshape(a, [nu, nr + 2, nq + 2], order=[2, 3, 1])
    deallocate (a)
    allocate (a(nu + 2, (nr + 2)*(nq + 2)))
    call fit_axis(reshape(c, [nu, (nr + 2)*(nq + 2)]), a)
    t%s = reshape(a, [nq + 2, nr + 2, nu + 2], order=[3, 2, 1])
  end subroutine fit

  !> Elastic energy [J] of the left wheel's tread and flange, their gradients with
  !> respect to the pose (y, z, roll), and the Hessian (yy, yz, y roll, zz, z roll,
  !> roll roll) of their sum.
  pure subroutine wheel_potential(t, pose, energy, gradient, hessian, status)
    type(contact_table), intent(in) :: t
    real(dp), intent(in) :: pose(3)        !! axle centre y, z [m], roll [rad]; track frame
    real(dp), intent(out) :: energy(2), gradient(3, 2), hessian(6)
    integer, intent(out) :: status
    type(basis_type) :: roll_basis
    real(dp) :: c, s, part, slope(3), bend(6)
    integer :: i, branch

    energy = 0
    gradient = 0
    hessian = 0
    status = inside
    c = cos(pose(3))
    s = sin(pose(3))
    if (t%zones(1)%roll%low <= pose(3) .and. pose(3) <= t%zones(1)%roll%high) then
      call axis_basis(t%zones(1)%roll, pose(3), roll_basis)
    else
      status = outside_roll
      return
    end if
    do i = 1, size(t%zones)
      call zone_potential(t%zones(i), pose, c, s, roll_basis, part, slope, bend, status)
      if (status /= inside) return
      if (part <= 0) cycle
      branch = merge(2, 1, t%zones(i)%flange)
      energy(branch) = energy(branch) + part
      gradient(:, branch) = gradient(:, branch) + slope
      hessian = hessian + bend
    end do
  end subroutine wheel_potential

  !> The same of one zone.  Where it does not touch, only the energy is set, to zero.
  pure subroutine zone_potential(t, pose, c, s, br, energy, gradient, hessian, status)
    type(zone_table), intent(in) :: t
    real(dp), intent(in) :: pose(3)
    real(dp), intent(in) :: c, s           !! cosine and sine of the roll angle
    type(basis_type), intent(in) :: br     !! of the roll axis
    real(dp), intent(out) :: energy
    real(dp), intent(inout) :: gradient(3), hessian(6)
    integer, intent(out) :: status
    type(basis_type) :: bu, bq
    real(dp) :: arm(2), x(2), u, w, ca, sa, p, q, h(6), v(10)
    real(dp) :: f, fu, fr, fp, fuu, fur, fup, frr, frp, fpp
    real(dp) :: eu, ew, er, euu, euw, eur, eww, ewr, err, ur, wr

    energy = 0
    status = inside
    arm = [t%pole(1)*c - t%pole(2)*s, t%pole(1)*s + t%pole(2)*c]
    x = pose(1:2) + arm
    if (x(2) > t%ceiling) return
    ca = t%along(1)
    sa = t%along(2)
    u = x(1)*ca + x(2)*sa - t%origin(1)
    w = x(2)*ca - x(1)*sa - t%origin(2)
    if (.not. axis_holds(t%u, u)) then
      status = outside_lateral
      return
    end if
    call axis_basis(t%u, u, bu)
    p = spline_2d_value(t%h, br, bu) - w
    if (p <= 0) return
    q = sqrt(p)
    if (.not. axis_holds(t%q, q)) then
      status = outside_depth
      return
    end if
    call axis_basis(t%q, q, bq)
    call spline_2d(t%h, br, bu, h)           ! h, h_r, h_u, h_rr, h_ru, h_uu
    call spline_3d(t%s, bq, br, bu, v)       ! S, S_q, S_r, S_u, S_qq, S_qr, S_qu, S_rr, S_ru, S_uu

    ! F(u, roll, p) = q^5 S(u, roll, q), q = sqrt(p).
    f = q**5*v(1)
    fu = q**5*v(4)
    fr = q**5*v(3)
    fp = q**3*(2.5_dp*v(1) + 0.5_dp*q*v(2))
    fuu = q**5*v(10)
    fur = q**5*v(9)
    frr = q**5*v(8)
    fup = q**3*(2.5_dp*v(4) + 0.5_dp*q*v(7))
    frp = q**3*(2.5_dp*v(3) + 0.5_dp*q*v(6))
    fpp = q*(3.75_dp*v(1) + 2.25_dp*q*v(2) + 0.25_dp*p*v(5))

    ! U(u, w, roll) = F(u, roll, h(u, roll) - w).
    eu = fu + fp*h(3)
    er = fr + fp*h(2)
    ew = -fp
    euu = fuu + 2*fup*h(3) + fpp*h(3)**2 + fp*h(6)
    eur = fur + fup*h(2) + frp*h(3) + fpp*h(2)*h(3) + fp*h(5)
    err = frr + 2*frp*h(2) + fpp*h(2)**2 + fp*h(4)
    euw = -fup - fpp*h(3)
    ewr = -frp - fpp*h(2)
    eww = fpp

    ! u and w of the pole as functions of the pose.
    ur = arm(1)*sa - arm(2)*ca
    wr = arm(1)*ca + arm(2)*sa
    energy = f
    gradient = [eu*ca - ew*sa, eu*sa + ew*ca, er + eu*ur + ew*wr]
    hessian(1) = euu*ca**2 - 2*euw*ca*sa + eww*sa**2
    hessian(2) = (euu - eww)*ca*sa + euw*(ca**2 - sa**2)
    hessian(3) = (eur + euu*ur + euw*wr)*ca - (ewr + euw*ur + eww*wr)*sa
    hessian(4) = euu*sa**2 + 2*euw*ca*sa + eww*ca**2
    hessian(5) = (eur + euu*ur + euw*wr)*sa + (ewr + euw*ur + eww*wr)*ca
    hessian(6) = err + 2*(eur*ur + ewr*wr) + euu*ur**2 + 2*euw*ur*wr + eww*wr**2 &
      - eu*wr + ew*ur
  end subroutine zone_potential

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
    write (unit, iostat=stat) magic, len(table%key), table%key, size(table%zones)
    do i = 1, size(table%zones)
      associate (t => table%zones(i))
        if (stat == 0) write (unit, iostat=stat) t%flange, t%along, t%pole, t%origin, t%ceiling, &
          t%u, t%roll, t%q, t%h, t%s
      end associate
    end do
    if (stat == 0) write (unit, iostat=stat) magic
    if (stat == 0) then
      close (unit, iostat=stat)
      if (stat == 0) call replace_file(scratch, file, stat)
    else
      close (unit, status='delete')
    end if
    if (stat /= 0) call fatal_error(error, '&table file = '//file//': cannot be written')
  end subroutine save_table

  !> Read a table that was made for `key`; `found` is false when the file is
  !> absent, foreign, damaged or made for something else.
  subroutine load_table(file, key, table, found)
    character(*), intent(in) :: file, key
    type(contact_table), intent(out) :: table
    logical, intent(out) :: found
    character(len(magic)) :: mark
    character(len(key)) :: stored
    integer :: unit, stat, length, n, i

    found = .false.
    open (newunit=unit, file=file, access='stream', form='unformatted', action='read', &
      status='old', iostat=stat)
    if (stat /= 0) return
    read (unit, iostat=stat) mark, length
    if (stat == 0) found = mark == magic .and. length == len(key)
    if (found) then
      read (unit, iostat=stat) stored, n
      found = stat == 0
      if (found) found = stored == key
    end if
    if (found) then
      table%key = key
      allocate (table%zones(n))
      do i = 1, n
        associate (t => table%zones(i))
          read (unit, iostat=stat) t%flange, t%along, t%pole, t%origin, t%ceiling, t%u, t%roll, t%q
          if (stat /= 0) exit
          allocate (t%h(t%roll%n + 2, t%u%n + 2), t%s(t%q%n + 2, t%roll%n + 2, t%u%n + 2))
          read (unit, iostat=stat) t%h, t%s
          if (stat /= 0) exit
        end associate
      end do
      if (stat == 0) read (unit, iostat=stat) mark
      found = stat == 0
      if (found) found = mark == magic
    end if
    close (unit)
  end subroutine load_table

end module table
