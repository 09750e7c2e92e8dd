!> Integrates the motion of the wheelset with forces of half-spaces that are pressed together in every pose, without a table.
!>
!> usage: direct_motion input.nml t_end nx ns [influence]
!> A patch has nx by ns elements. The influence is that of the input unless it is given: local, flat or apart.
!> Writes a line for every step: t [s]; y, z - equilibrium [m], roll [rad]; normal forces of left tread, left flange, right
!> tread, right flange [N].
!>
!> The steps are those of Dormand and Prince, J. Comput. Appl. Math. 6 (1980) 19-26: order 5, error estimate of order 4.
program direct_motion
  use case, only: case_type
  use case_reader, only: read_case
  use contact_zones, only: is_flange, side_type
  use errors, only: error_type
  use halfspace_patches, only: force_between, patches_type, press_patches
  use hertz, only: contact_modulus
  use kinds, only: dp, gravity
  use patch_grids, only: elements_type
  use run_setup, only: place_sides, setup_type
  use shared, only: integer_argument
  use station_scan, only: new_scan, scan_depth, scan_type
  use text, only: line_type, read_lines
  use wheel_rail_pair, only: mirror
  implicit none
  save

  ! A step may err by 0.1 nm in y and z, and by as much at a rail for roll. A run takes some hundred steps, so positions are
  ! known to 10 nm. Velocities belong to vibrations of some 1000 rad/s.
  real(dp), parameter :: rail = 0.75_dp                  ! about half the distance between the rails [m]
  real(dp), parameter :: tolerance(3) = [1e-10_dp, 1e-10_dp, 1e-10_dp/rail]
  real(dp), parameter :: frequency = 1e3_dp              ! [rad/s]
  real(dp), parameter :: longest = 2e-4_dp               ! step [s]
  real(dp), parameter :: longest_in_flange = 2e-5_dp     ! step while a flange carries, so that rows show the peak [s]
  ! The grids that are fitted to the patches let the force jump by some 0.01 %, which no shorter step can resolve.
  real(dp), parameter :: shortest = 1e-6_dp              ! step [s]
  real(dp), parameter :: deepest_tread = 1e-3_dp         ! by which the wheels sink in at most [m]

  ! Coefficients of Dormand and Prince: a step's stages, and the difference of orders 5 and 4.
  real(dp), parameter :: a(6, 7) = reshape([real(dp) :: 0, 0, 0, 0, 0, 0, &
    1/5.0_dp, 0, 0, 0, 0, 0, &
    3/40.0_dp, 9/40.0_dp, 0, 0, 0, 0, &
    44/45.0_dp, -56/15.0_dp, 32/9.0_dp, 0, 0, 0, &
    19372/6561.0_dp, -25360/2187.0_dp, 64448/6561.0_dp, -212/729.0_dp, 0, 0, &
    9017/3168.0_dp, -355/33.0_dp, 46732/5247.0_dp, 49/176.0_dp, -5103/18656.0_dp, 0, &
    35/384.0_dp, 0, 500/1113.0_dp, 125/192.0_dp, -2187/6784.0_dp, 11/84.0_dp], [6, 7])
  real(dp), parameter :: at(7) = [real(dp) :: 0, 1/5.0_dp, 3/10.0_dp, 4/5.0_dp, 8/9.0_dp, 1, 1]
  real(dp), parameter :: e(7) = [71/57600.0_dp, 0.0_dp, -71/16695.0_dp, 71/1920.0_dp, -17253/339200.0_dp, 22/525.0_dp, &
    -1/40.0_dp]

  type(case_type) :: c
  type(setup_type) :: setup
  type(elements_type) :: elements
  type(scan_type) :: scan
  logical :: apart
  real(dp) :: reach(2) = 0, last_pose(3, 2) = 0   ! largest depth [m] of a wheel in a pose, by wheel
  real(dp) :: radius                              ! largest distance of a station from the axle's centre [m]
  real(dp) :: equilibrium(3), x(6), new(6), k(6, 7), branch(4), new_branch(4), t, t_end, h, error
  integer :: i

  call read_arguments
  call find_equilibrium
  x = [equilibrium + [c%y, c%z, c%roll], c%vy, c%vz, c%roll_rate]
  t = 0
  h = shortest
  call evaluate(t, x, k(:, 1), branch)
  call write_row
  do while (t < t_end)
    h = min(h, t_end - t, merge(longest_in_flange, longest, any(branch([2, 4]) > 0)))
    do i = 2, 7
      new = x + h*matmul(k(:, :i - 1), a(:i - 1, i))
      call evaluate(t + at(i)*h, new, k(:, i), new_branch)
    end do
    if (any(new_branch([2, 4]) > 0) .and. h > longest_in_flange) then
      ! The flange has closed in this step, which is too long to show when.
      h = longest_in_flange
      cycle
    end if
    error = maxval(abs(h*matmul(k, e))/[tolerance, frequency*tolerance])
    if (error <= 1 .or. h <= shortest) then
      t = merge(t_end, t + h, t_end - t <= h*(1 + 1e-9_dp))
      x = new
      branch = new_branch
      k(:, 1) = k(:, 7)
      call write_row
    end if
    h = max(shortest, h*min(5.0_dp, max(0.2_dp, 0.9_dp*max(error, 1e-10_dp)**(-0.2_dp))))
  end do

contains

  !> Read the case, place the profiles, and choose the elements.
  subroutine read_arguments
    type(error_type), allocatable :: fault
    type(line_type), allocatable :: lines(:)
    character(256) :: word
    character(:), allocatable :: influence

    call get_command_argument(1, word)
    call read_lines(trim(word), lines, fault)
    if (.not. allocated(fault)) call read_case(trim(word), lines, c, fault)
    if (.not. allocated(fault)) call place_sides(c, setup, fault)
    if (allocated(fault)) error stop fault%message
    if (.not. setup%symmetric) error stop 'direct_motion: expected the same profiles on both sides'
    call get_command_argument(2, word)
    read (word, *) t_end
    influence = trim(c%influence)
    if (command_argument_count() > 4) then
      call get_command_argument(5, word)
      influence = trim(word)
    end if
    apart = influence == 'apart'
    elements = elements_type(integer_argument(3), integer_argument(4), 1e-4_dp, &
      c%stiffness_scale*contact_modulus(c%youngs_modulus, c%poisson), influence == 'flat')
    scan = new_scan(setup%side(1)%pair)
    radius = maxval(norm2(setup%side(1)%pair%r, 1))
    reach = huge(reach)
  end subroutine read_arguments

  !> Find the height at which the centred wheelset is at rest, by bisection.
  subroutine find_equilibrium
    real(dp) :: low, high, force(3), parts(2)

    low = setup%centred(2) - deepest_tread
    high = setup%centred(2)
    do while (high - low > 1e-13_dp)
      equilibrium = [0.0_dp, (low + high)/2, 0.0_dp]
      call wheel_force(1, equilibrium, force, parts)
      if (force(2) > weight()/2) then
        low = equilibrium(2)
      else
        high = equilibrium(2)
      end if
    end do
  end subroutine find_equilibrium

  !> Weight of the wheelset and vertical load [N].
  real(dp) function weight()
    weight = c%mass*gravity + c%vertical_load
  end function weight

  !> Compute velocities and accelerations, and the normal forces [N] of left tread, left flange, right tread, right flange.
  subroutine evaluate(time, state, rate, normal)
    real(dp), intent(in) :: time, state(6)
    real(dp), intent(out) :: rate(6), normal(4)
    real(dp) :: left(3), right(3)

    call wheel_force(1, state(:3), left, normal(:2))
    call wheel_force(2, mirror*state(:3), right, normal(3:))
    rate(:3) = state(4:)
    rate(4:) = ([c%lateral_force + c%lateral_ramp*time, -weight(), 0.0_dp] + left + mirror*right) &
      /[c%mass, c%mass, c%roll_inertia]
  end subroutine evaluate

  !> Press one wheel: F_y [N], F_z [N], M_x [N m] of the rail on it, and the normal forces [N] of tread and flange. The right
  !> wheel is given and treated as its mirror image.
  subroutine wheel_force(wheel, pose, force, normal)
    integer, intent(in) :: wheel
    real(dp), intent(in) :: pose(3)          ! [m, m, rad]
    real(dp), intent(out) :: force(3), normal(2)
    real(dp) :: parts(3, 2)                  ! of tread and flange
    integer :: first, last, z

    parts = 0
    ! No depth grows by more than the wheel's stations move, so a wheel far from its rail needs no scan.
    if (.not. far(wheel, pose)) then
      associate (side => setup%side(1))
        first = minval(side%zones%first)
        last = maxval(side%zones%last)
        scan%fresh = .true.
        call scan_depth(side%pair, pose(:2), pose(3), first, last, scan)
        reach(wheel) = maxval(scan%depth(first:last))
        last_pose(:, wheel) = pose
        if (reach(wheel) > 0) then
          if (apart) then
            do z = 1, size(side%zones)
              call add_patches(side, pose, side%zones(z)%first, side%zones(z)%last, parts)
            end do
          else
            call add_patches(side, pose, first, last, parts)
          end if
        end if
      end associate
    end if
    force = sum(parts, 2)
    normal = norm2(parts(:2, :), 1)
  end subroutine wheel_force

  !> Whether a wheel cannot touch in a pose, as its last scan shows.
  pure logical function far(wheel, pose)
    integer, intent(in) :: wheel
    real(dp), intent(in) :: pose(3)

    far = reach(wheel) + norm2(pose(:2) - last_pose(:2, wheel)) + radius*abs(pose(3) - last_pose(3, wheel)) < 0
  end function far

  !> Press the stations first..last as one elastic system, and add the forces to those of tread and flange.
  subroutine add_patches(side, pose, first, last, parts)
    type(side_type), intent(in) :: side
    real(dp), intent(in) :: pose(3)
    integer, intent(in) :: first, last
    real(dp), intent(inout) :: parts(3, 2)
    type(patches_type) :: patches
    real(dp) :: part(3), low, high
    integer :: z, called

    call press_patches(side%pair, elements, first, last, pose(:2), pose(3), scan, patches)
    if (.not. patches%ok) error stop 'direct_motion: a half-space solution did not converge'
    do z = 1, size(side%zones)
      if (side%zones(z)%last <= first .or. side%zones(z)%first >= last) cycle
      low = side%pair%s(side%zones(z)%first)
      high = side%pair%s(side%zones(z)%last)
      part = force_between(patches, low, high)
      if (.not. any(abs(part) > 0)) cycle
      called = merge(2, 1, is_flange(side, part(:2), mean_station(patches, low, high)))
      parts(:, called) = parts(:, called) + part
    end do
  end subroutine add_patches

  !> Mean s [m] of the loads between two s.
  pure real(dp) function mean_station(patches, low, high)
    type(patches_type), intent(in) :: patches
    real(dp), intent(in) :: low, high
    real(dp) :: s, load, moment
    integer :: g, j

    load = 0
    moment = 0
    do g = 1, patches%n
      do j = 1, size(patches%f, 2)
        s = patches%mesh(g)%low + (j - 0.5_dp)*patches%mesh(g)%ds
        if (s < low .or. s >= high) cycle
        load = load + sum(patches%f(:, j, g))
        moment = moment + s*sum(patches%f(:, j, g))
      end do
    end do
    mean_station = moment/load
  end function mean_station

  subroutine write_row
    write (*, '(es24.16, 7es20.12)') t, x(:3) - [0.0_dp, equilibrium(2), 0.0_dp], branch
  end subroutine write_row

end program direct_motion
