!> The functions that a contact table interpolates, by direct evaluation: the height at which a zone touches, its elastic
!> energy by strips or by one Hertzian contact, and the ratio of half-space to strip energy.
module table_sampling
  use contact_zones, only: zone_type
  use strip_law, only: set_moduli, stiffest, zone_energy
  use station_scan, only: keep_feet, new_scan, scan_depth, scan_type, touch
  use wheel_rail_pair, only: pair_type, rail_point, rolled
  use kinds, only: dp
  use halfspace_patches, only: patches_type, press_patches
  use patch_grids, only: elements_type
  use contact_table, only: table_type
  use zone_tables, only: zone_pose, zone_table
  use service_poses, only: find_allowance, request_type
  implicit none
  private
  public :: sample_row, sample_ratios, press_zone, reference_shift

contains

  !> Compute h and S of a zone at all u of one roll angle. Beside the rail, where the zone cannot touch, h is extrapolated,
  !> far below any pose in reach, and S is constant.
  subroutine sample_row(request, z, frame, roll, u, q, known, h, s)
    type(request_type), intent(in) :: request
    integer, intent(in) :: z               !! the zone
    type(zone_table), intent(in) :: frame  !! with the pole and the origin
    real(dp), intent(in) :: roll, u(:)     !! [rad, m]
    real(dp), intent(in) :: q(:)           !! from 0 up [sqrt(m)]
    logical, intent(inout) :: known(:)     !! whether h and S at u were computed
    real(dp), intent(inout) :: h(:), s(:, :)   !! [m]; (q, u) [J/m^2.5]
    real(dp), parameter :: above = 0.02_dp ! height over the touching one in the reference pose, where searches begin [m]
    type(scan_type) :: touching, pressed   ! in the touching pose; pressed in
    real(dp) :: k(size(request%side%pair%s)), across(2), centre(2), shift, station
    integer :: i, start, way, last
    logical :: ok

    touching = new_scan(request%side%pair)
    pressed = new_scan(request%side%pair)
    across = [-frame%along(2), frame%along(1)]
    call set_moduli(request%side%pair, request%side%zones(z), request%e_star, roll, k)
    start = start_point()
    do way = 1, -1, -2
      ok = .true.
      last = 0
      do i = merge(start, start - 1, way == 1), merge(size(u), 1, way == 1), way
        if (ok .and. known(i)) cycle
        if (ok) then
          ! The search for feet starts from a neighbour's; those of a farther pose may lead it astray.
          touching%fresh = abs(i - last) /= 1
          last = i
          shift = above
          if (i == start) then
            if (i > 1) shift = merge(h(i - 1), shift, known(i - 1))
          else if (known(i - way)) then
            shift = h(i - way)
          end if
          call touch_at(u(i))
          known(i) = ok
          if (ok) h(i) = shift
          if (ok) call fill_depths(s(:, i))
        end if
        if (.not. ok) then
          known(i) = .false.
          if (i == start) then
            ! No pose was found in which the zone touches: it never does.
            h(i) = -1
            s(:, i) = 0
          else if (abs(i - start) == 1) then
            h(i) = h(start)
            s(:, i) = s(:, start)
          else
            h(i) = h(i - way) + (h(i - way) - h(i - 2*way))/(u(i - way) - u(i - 2*way))*(u(i) - u(i - way))
            s(:, i) = s(:, i - way)
          end if
        end if
      end do
    end do

  contains

    !> Return a point of u at which the zone touches: the middle, or where a station of the zone meets the rail's point of
    !> the same normal. Where the wheelset rolls over, a stretch of the tread passes beside the rail in the middle.
    integer function start_point() result(start)
      real(dp) :: pose(2), point(2), normal(2)
      integer, parameter :: tries = 9
      integer :: try, i
      logical :: usable
      start = minloc(abs(u), 1, known .or. .not. any(known))
      if (any(known)) return
      associate (pair => request%side%pair, zone => request%side%zones(z))
        do try = 0, tries
          if (try > 0) then
            i = zone%first + nint((try - 0.5_dp)/tries*(zone%last - zone%first))
            call rail_point(pair, pair%angle(i) + roll, point, normal, usable)
            if (.not. usable) cycle
            pose = point + rolled(frame%pole - pair%r(:, i), roll)
            start = minloc(abs(u - dot_product(pose, frame%along) + frame%origin(1)), 1)
          end if
          touching%fresh = .true.
          shift = above
          call touch_at(u(start))
          if (ok) return
        end do
      end associate
      start = minloc(abs(u), 1)
    end function start_point

    !> Find the height `shift` along w at which the zone touches.
    subroutine touch_at(u)
      real(dp), intent(in) :: u
      real(dp) :: move

      centre = (frame%origin(1) + u)*frame%along + (frame%origin(2) + shift)*across - rolled(frame%pole, roll)
      associate (zone => request%side%zones(z))
        call touch(request%side%pair, touching, zone%first, zone%last, centre, roll, zone%alpha, move, station, ok)
      end associate
      centre = centre + move*across
      shift = shift + move
    end subroutine touch_at

    !> Compute S from just touching to the largest depth, the deepest first: fewer and fewer stations are then inside the
    !> rail.
    subroutine fill_depths(s)
      real(dp), intent(out) :: s(:)
      type(zone_type) :: active
      integer :: m

      active = request%side%zones(z)
      call narrow(active%first, active%last, touching%depth + q(size(q))**2)
      call keep_feet(touching, active%first, active%last, pressed)
      do m = size(q), 2, -1
        call scan_depth(request%side%pair, centre - q(m)**2*across, roll, active%first, active%last, pressed)
        call narrow(active%first, active%last, pressed%depth)
        s(m) = zone_energy(request%side%pair, active, request%model, request%e_star, roll, pressed, k)/q(m)**5
      end do
      ! S(0) is extrapolated: smaller patches would show the rounding of the profile's points.
      s(1) = s(2)*q(3)*q(4)/((q(2) - q(3))*(q(2) - q(4))) + s(3)*q(2)*q(4)/((q(3) - q(2))*(q(3) - q(4))) &
        + s(4)*q(2)*q(3)/((q(4) - q(2))*(q(4) - q(3)))
    end subroutine fill_depths

  end subroutine sample_row

  !> Compute the ratio of half-space to strip energy of a zone that is pressed alone, at all u and q of one roll angle. Poses
  !> that no run reaches are skipped.
  subroutine sample_ratios(request, z, elements, table, roll, u, h, q, ratio, known, solutions)
    type(request_type), intent(in) :: request
    integer, intent(in) :: z                !! the zone
    type(elements_type), intent(in) :: elements
    type(table_type), intent(in) :: table   !! of model 'strip'
    real(dp), intent(in) :: roll, u(:), h(:)   !! [rad, m]; h(u, roll) [m]
    real(dp), intent(in) :: q(:)               !! from 0 up [sqrt(m)]
    real(dp), intent(inout) :: ratio(:, :)     !! (q, u)
    logical, intent(inout) :: known(:, :)      !! (q, u)
    integer, intent(inout) :: solutions(2)     !! poses solved so far, and those that did not converge
    type(scan_type) :: scan
    real(dp) :: pose(3), k(size(request%side%pair%s)), strip, energy, allowance, deepest_other
    integer :: i, m
    logical :: ok

    if (all(known(2:, :))) return
    scan = new_scan(request%side%pair)
    call set_moduli(request%side%pair, request%side%zones(z), elements%e_star, roll, k)
    do i = 1, size(u)
      scan%fresh = .true.
      do m = size(q), 2, -1
        if (known(m, i)) cycle
        pose = zone_pose(table%zones(z), u(i), h(i) - q(m)**2, roll)
        ! The point is needed if the cell below it is in reach.
        call find_allowance(request, table, z, q(max(1, m - 2))**2, pose, .true., allowance, deepest_other)
        if (allowance <= 0) cycle
        call press_zone(request, z, elements, pose, k, scan, strip, energy, ok)
        if (strip <= 0 .or. energy <= 0) cycle
        solutions = solutions + [1, merge(0, 1, ok)]
        ratio(m, i) = energy/strip
        known(m, i) = .true.
      end do
    end do
  end subroutine sample_ratios

  !> Energies [J] of a zone that is pressed alone in a pose: of strips, and of half-spaces, but at most `stiffest` times the former.
  subroutine press_zone(request, z, elements, pose, k, scan, strip, energy, ok)
    type(request_type), intent(in) :: request
    integer, intent(in) :: z                !! the zone
    type(elements_type), intent(in) :: elements
    real(dp), intent(in) :: pose(3), k(:)   !! k: moduli of the strips [Pa]
    type(scan_type), intent(inout) :: scan  !! workspace
    real(dp), intent(out) :: strip, energy
    logical, intent(out) :: ok              !! whether the half-spaces converged
    type(patches_type) :: patches

    ok = .true.
    energy = 0
    associate (pair => request%side%pair, zone => request%side%zones(z))
      call scan_depth(pair, pose(:2), pose(3), zone%first, zone%last, scan)
      scan%fresh = .false.
      strip = zone_energy(pair, zone, 'strip', elements%e_star, pose(3), scan, k)
      if (strip <= 0) return
      call press_patches(pair, elements, zone%first, zone%last, pose(:2), pose(3), scan, patches)
    end associate
    ok = patches%ok
    energy = min(patches%energy, stiffest*strip)
  end subroutine press_zone

  !> Drop the stations outside the rail at both ends of a stretch, but for two.
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

  !> Return the lateral shift of the wheelset at which a zone is expected to touch [m]: 0 for the tread; for a flange zone
  !> the shift at which the zone is as low as the tread in running.
  real(dp) function reference_shift(pair, zone) result(y)
    type(pair_type), intent(in) :: pair
    type(zone_type), intent(in) :: zone
    type(scan_type) :: scan
    real(dp) :: low, high, shift, station
    integer :: iter
    logical :: ok

    y = 0
    if (.not. zone%past_root) return
    scan = new_scan(pair)
    low = -0.02_dp
    high = 0.04_dp
    do iter = 1, 20
      y = (low + high)/2
      scan%fresh = .true.
      call touch(pair, scan, zone%first, zone%last, [y, pair%axle_height + 0.03_dp], 0.0_dp, 0.0_dp, &
        shift, station, ok)
      if (ok .and. shift > -0.03_dp) then
        high = y
      else
        low = y
      end if
    end do
  end function reference_shift

end module table_sampling