!> Values that a contact table is made of, by direct evaluation: where a zone touches, its energy in
!> strips or as one Hertzian contact, and what half-spaces pressed together have instead.
module table_sampling
  use contact_zones, only: zone_type
  use strip_law, only: set_moduli, stiffest, zone_energy
  use station_scan, only: keep_feet, new_scan, scan_depth, scan_type, touch
  use wheel_rail_pair, only: pair_type, rolled
  use kinds, only: dp
  use halfspace_patches, only: expect_area, keep_patches, patches_type, press_patches, pressed_area
  use patch_grids, only: elements_type
  use contact_table, only: table_type, zone_pose, zone_table
  use service_poses, only: extent_type, find_reach, strictness
  implicit none
  private
  public :: sample_row, sample_ratios, reference_shift

contains

  !> h and S of a zone over u at one roll angle.  Beside the rail h goes on smoothly, far below any
  !> pose in reach, and S as it is.
  subroutine sample_row(pair, zone, model, e_star, frame, roll, u, q, good, h, s)
    type(pair_type), intent(in) :: pair
    type(zone_type), intent(in) :: zone
    character(*), intent(in) :: model      !! 'strip' or 'hertz'
    real(dp), intent(in) :: e_star         !! [Pa]
    type(zone_table), intent(in) :: frame  !! its pole and origin
    real(dp), intent(in) :: roll, u(:)     !! [rad, m]
    real(dp), intent(in) :: q(:)           !! from 0 up [sqrt(m)]
    logical, intent(inout) :: good(:)      !! whether h and S at u are there
    real(dp), intent(inout) :: h(:), s(:, :)
    type(scan_type) :: work, pressed       ! touching; pressed in
    real(dp) :: k(size(pair%s)), across(2), centre(2), shift, station
    integer :: i, middle, way, last
    logical :: ok

    work = new_scan(pair)
    pressed = new_scan(pair)
    across = [-frame%along(2), frame%along(1)]
    call set_moduli(pair, zone, e_star, roll, k)
    middle = minloc(abs(u), 1)
    do way = 1, -1, -2
      ok = .true.
      last = 0
      do i = merge(middle, middle - 1, way == 1), merge(size(u), 1, way == 1), way
        if (ok .and. good(i)) cycle
        if (ok) then
          ! Feet of a neighbour are a start, those of one further away may lead astray.
          work%fresh = abs(i - last) /= 1
          last = i
          shift = 0.02_dp
          if (i == middle) then
            if (i > 1) shift = merge(h(i - 1), shift, good(i - 1))
          else if (good(i - way)) then
            shift = h(i - way)
          end if
          call touch_at(u(i))
          good(i) = ok
          if (ok) h(i) = shift
          if (ok) call fill_depths(s(:, i))
        end if
        if (.not. ok) then
          good(i) = .false.
          if (i == middle) then
            ! Where no pose is found that touches, none does.
            h(i) = -1
            s(:, i) = 0
          else if (abs(i - middle) == 1) then
            h(i) = h(middle)
            s(:, i) = s(:, middle)
          else
            h(i) = h(i - way) + (h(i - way) - h(i - 2*way))/(u(i - way) - u(i - 2*way))*(u(i) - u(i - way))
            s(:, i) = s(:, i - way)
          end if
        end if
      end do
    end do

  contains

    !> Height `shift` along w at which the zone touches.
    subroutine touch_at(u)
      real(dp), intent(in) :: u
      real(dp) :: move

      centre = (frame%origin(1) + u)*frame%along + (frame%origin(2) + shift)*across - rolled(frame%pole, roll)
      call touch(pair, work, zone%first, zone%last, centre, roll, zone%alpha, move, station, ok)
      centre = centre + move*across
      shift = shift + move
    end subroutine touch_at

    !> S from just touching to the largest depth, deepest first: the stations
    !> inside the rail only become fewer.
    subroutine fill_depths(s)
      real(dp), intent(out) :: s(:)
      type(zone_type) :: active
      integer :: m

      active = zone
      call narrow(active%first, active%last, work%depth + q(size(q))**2)
      call keep_feet(work, active%first, active%last, pressed)
      do m = size(q), 2, -1
        call scan_depth(pair, centre - q(m)**2*across, roll, active%first, active%last, pressed)
        call narrow(active%first, active%last, pressed%depth)
        s(m) = zone_energy(pair, active, model, e_star, roll, pressed, k)/q(m)**5
      end do
      ! S(0) is a limit; patches that small would see the rounding of the profile's
      ! points, so it is extrapolated.
      s(1) = s(2)*q(3)*q(4)/((q(2) - q(3))*(q(2) - q(4))) + s(3)*q(2)*q(4)/((q(3) - q(2))*(q(3) - q(4))) &
        + s(4)*q(2)*q(3)/((q(4) - q(2))*(q(4) - q(3)))
    end subroutine fill_depths

  end subroutine sample_row

  !> Energy of half-spaces over that of strips, of all that the branch (tread or flange) of a zone presses in the
  !> poses at u, one roll angle and the penetrations q^2 of the zone; where no run comes it is left.
  subroutine sample_ratios(pair, zones, zone, elements, table, extent, roll, u, h, q, open, ratio, there, &
    area, solutions)
    type(pair_type), intent(in) :: pair
    type(zone_type), intent(in) :: zones(:)
    integer, intent(in) :: zone
    type(elements_type), intent(in) :: elements
    type(table_type), intent(in) :: table   !! of strips
    type(extent_type), intent(in) :: extent
    real(dp), intent(in) :: roll, u(:), h(:)   !! [rad, m]; h(u, roll) [m]
    real(dp), intent(in) :: q(:)               !! from 0 up [sqrt(m)]
    logical, intent(inout) :: open(:, :)       !! to be solved, (q, u)
    real(dp), intent(inout) :: ratio(:, :)     !! (q, u)
    logical, intent(inout) :: there(:, :)      !! (q, u)
    real(dp), intent(inout) :: area(:, :, :)   !! pressed, of a single patch; (3, q, u)
    integer, intent(inout) :: solutions(2)     !! poses solved so far, and those that did not converge
    type(scan_type) :: work
    type(patches_type) :: patches, deepest     ! of the deepest pose at the last u
    real(dp) :: pose(3), k(size(pair%s)), strip, exact, other
    type(zone_type) :: active
    integer :: first, last, i, m, n
    logical :: ok, within, begun

    if (.not. any(open)) return
    do i = 1, size(u)
      begun = .false.
      do m = size(q), 2, -1
        if (.not. open(m, i)) cycle
        open(m, i) = .false.
        pose = zone_pose(table%zones(zone), u(i), h(i) - q(m)**2, roll)
        if (strictness(pair, extent, pose, .true.) <= 0) cycle
        ! The cell below it may be within reach where the point itself is not.
        call find_reach(table, extent, zone, q(m - 1)**2, pose, .true., within, other)
        if (.not. within) cycle
        if (.not. allocated(work%depth)) then
          work = new_scan(pair)
          do n = 1, size(zones)
            if (zones(n)%flange .eqv. zones(zone)%flange) call set_moduli(pair, zones(n), elements%e_star, roll, k)
          end do
        end if
        if (.not. begun) then
          work%fresh = .true.
          first = minval(zones%first, zones%flange .eqv. zones(zone)%flange)
          last = maxval(zones%last, zones%flange .eqv. zones(zone)%flange)
          call keep_patches(deepest, patches)
        end if
        ! Deepest first: the stations inside the rail only become fewer.
        call scan_depth(pair, pose(:2), roll, first, last, work)
        work%fresh = .false.
        call narrow(first, last, work%depth)
        strip = 0
        do n = 1, size(zones)
          if (zones(n)%flange .neqv. zones(zone)%flange) cycle
          active = zones(n)
          active%first = max(active%first, first)
          active%last = min(active%last, last)
          if (active%first < active%last) strip = strip &
            + zone_energy(pair, active, 'strip', elements%e_star, roll, work, k)
        end do
        if (strip <= 0) cycle
        if (area(1, m, i) < 0) area(:, m, i) = between(m, i)
        call expect_area(patches, area(:, m, i))
        call press_patches(pair, elements, first, last, pose(:2), roll, work, patches, exact, ok)
        if (.not. begun) call keep_patches(patches, deepest)
        begun = .true.
        if (.not. ok) cycle
        ratio(m, i) = min(exact/strip, stiffest)
        there(m, i) = .true.
        area(:, m, i) = pressed_area(patches)
      end do
    end do
    solutions = solutions + [patches%poses, patches%unsolved]

  contains

    !> Of poses on both sides of one: next to it along u, or along q.
    pure function between(m, i) result(middle)
      integer, intent(in) :: m, i
      real(dp) :: middle(3)

      middle = -1
      if (i > 1 .and. i < size(u)) middle = weighted(area(:, m, i - 1), area(:, m, i + 1), &
        (u(i) - u(i - 1))/(u(i + 1) - u(i - 1)))
      if (middle(1) < 0 .and. m < size(q)) middle = weighted(area(:, m - 1, i), area(:, m + 1, i), &
        (q(m) - q(m - 1))/(q(m + 1) - q(m - 1)))
    end function between

    pure function weighted(low, high, share) result(middle)
      real(dp), intent(in) :: low(3), high(3), share
      real(dp) :: middle(3)

      middle = -1
      if (low(1) > 0 .and. high(1) > 0) middle = low + share*(high - low)
    end function weighted

  end subroutine sample_ratios

  !> Drop stations at both ends that are outside the rail.
  pure subroutine narrow(first, last, depth)
    integer, intent(inout) :: first, last
    real(dp), intent(in) :: depth(:)

    do while (first < last - 3 .and. all(depth(first:first + 2) < 0))
      first = first + 1
    end do
    do while (last > first + 3 .and. all(depth(last - 2:last) < 0))
      last = last - 1
    end do
  end subroutine narrow

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

end module table_sampling