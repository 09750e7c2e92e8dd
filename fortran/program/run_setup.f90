!> The setup that all runs with one wheelset on one track share: placed profiles, tables, equilibrium.
module run_setup
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use body_file, only: read_bodies
  use both_rails, only: largest_force_on_rails, rest_on_rails
  use case, only: case_type, inclinations
  use contact_zones, only: border_station, find_zones, least_turn, side_type
  use errors, only: error_type, place_error, refuse
  use rigid_geometry, only: clearance, geometry_at, rigid_contact
  use kinds, only: dp
  use places, only: find_file
  use profile, only: is_rail, is_wheel, profile_type, read_profile
  use placement, only: place_profiles
  use static_limit, only: largest_force
  use text, only: str
  use wheel_rail_pair, only: same_pair
  use elastic_contacts, only: elastic_wheelset, find_rest, settle, small_oscillations
  implicit none
  private
  public :: setup_type, place_sides, set_wheelset, roll_rate_on_rails

  type :: setup_type
    type(profile_type) :: wheel(2), rail(2)   !! left, right
    type(side_type) :: side(2)         !! left, right
    real(dp) :: inclination(2) = 0     !! of the rails beyond their files, left, right [rad]
    character(8) :: bodies_sum = ''    !! CRC-32 of the file of bodies; '' where there is none
    logical :: symmetric = .true.      !! left and right have the same profiles
    type(elastic_wheelset) :: wheelset
    real(dp) :: centred(3) = 0         !! pose of the rigid wheelset on both rails at y = 0
    real(dp) :: equilibrium(3) = 0     !! static, held at y = 0: Z and roll are measured from it [m, m, rad]
    real(dp) :: rest(3) = 0            !! static equilibrium of the free wheelset [m, m, rad]
    !> Largest lateral force with an equilibrium, to the left and to the right [N]; NaN where the table ends before it.
    real(dp) :: limit(2) = 0
    integer :: modes = 3               !! number of eigenmodes: 1 with rigid contacts
    real(dp) :: frequency(3) = 0       !! eigenfrequencies at `rest`, ascending [Hz]
    real(dp) :: shapes(3, 3) = 0       !! modes y, z, roll in columns
    character(:), allocatable :: remark  !! a warning of who prepared it; not allocated: none
    real(dp) :: seconds = 0            !! processor time for the preparation
  end type setup_type

contains

  !> Read the profiles and place the wheels on the rails: zones of the wheels, flange clearance, centred pose.
  subroutine place_sides(c, setup, error)
    type(case_type), intent(in) :: c
    type(setup_type), intent(out) :: setup
    type(error_type), allocatable, intent(out) :: error
    character(len(c%wheel_profile)) :: files(2, 2)   ! wheel and rail of left and right side
    character(19) :: names(2, 2)           ! of their variables
    real(dp) :: station(2)
    integer :: k
    logical :: ok

    files = reshape([c%wheel_profile, c%rail_profile, c%wheel_profile_right, c%rail_profile_right], [2, 2])
    names(:, 1) = [character(19) :: 'wheel_profile', 'rail_profile']
    names(:, 2) = merge(names(:, 1), [character(19) :: 'wheel_profile_right', 'rail_profile_right'], files(:, 2) == '')
    setup%inclination = inclinations(c)
    call place_side(1)
    if (allocated(error)) return
    if (all(files(:, 2) == '') .and. c%rail_inclination_right == '') then
      setup%wheel(2) = setup%wheel(1)
      setup%rail(2) = setup%rail(1)
      setup%side(2) = setup%side(1)
    else
      where (files(:, 2) == '') files(:, 2) = files(:, 1)
      call place_side(2)
      if (allocated(error)) return
    end if
    setup%symmetric = same_pair(setup%side(1)%pair, setup%side(2)%pair)
    do k = 1, merge(1, 2, setup%symmetric)
      ! The right side is the left one of the mirror image.
      if (k == 1) call clearance(setup%side, setup%side(k)%clearance, ok)
      if (k == 2) call clearance(setup%side(2:1:-1), setup%side(k)%clearance, ok)
      if (ok) cycle
      call refuse(error, 'a flange clearance between 0 and 0.05 m', 'no flange contact there', group='track', variable='gauge', &
        detail=' = '//str(c%gauge)//' m with &wheelset back_to_back = '//str(c%back_to_back)//' m', &
        rest='; correct gauge, back_to_back or the profiles')
      return
    end do
    setup%centred = [0.0_dp, setup%side(1)%pair%axle_height, 0.0_dp]
    if (setup%symmetric) then
      setup%side(2)%clearance = setup%side(1)%clearance
    else
      call rigid_contact(setup%side, 0.0_dp, setup%centred(3), setup%centred(2), station, ok)
      if (.not. ok) call refuse(error, 'profiles on which the centred wheelset stands on both rails', 'that it cannot', &
        group='profiles', variable='wheel_profile_right', detail=', rail_profile_right')
    end if

  contains

    !> Read wheel and rail of a side and place the wheel on the rail.
    subroutine place_side(k)
      integer, intent(in) :: k               !! 1 left, 2 right
      character(:), allocatable :: faulty    ! the variables that an error is about
      character(:), allocatable :: path

      associate (wheel => setup%wheel(k), rail => setup%rail(k), side => setup%side(k))
        faulty = trim(names(1, k))
        call find_profile(files(1, k), is_wheel, wheel)
        if (.not. allocated(error)) then
          faulty = trim(names(2, k))
          call find_profile(files(2, k), is_rail, rail)
        end if
        if (.not. allocated(error)) then
          faulty = ''
          if (k == 2 .and. any(files(:, 2) /= files(:, 1))) faulty = trim(names(1, 2))//', '//trim(names(2, 2))
          call place_profiles(wheel%curve, rail%curve, wheel%file, rail%file, c%gauge, c%gauge_depth, rail%hidden, &
            setup%inclination(k), c%back_to_back, c%rolling_radius, side%pair, error)
        end if
        if (.not. allocated(error) .and. c%formulation == 'elastic' .and. c%influence == 'bodies') then
          faulty = ''
          call find_file(c%places, trim(c%bodies), path, error)
          if (.not. allocated(error)) call read_bodies(path, [wheel%curve, rail%curve], files(:, k), c%poisson, side%pair%bodies, &
            setup%bodies_sum, error)
          if (allocated(error)) call place_error(error, group='contact', variable='bodies')
        end if
        if (allocated(error) .and. faulty /= '') call place_error(error, group='profiles', variable=faulty)
        if (allocated(error)) return
        ! A rigid wheel touches at a point on either side of any arc.
        call find_zones(side%pair, merge(least_turn, 0.0_dp, c%formulation == 'elastic'), side%zones)
        side%border = border_station(side%pair, c%flange_angle)
      end associate
    end subroutine place_side

    !> Read a profile where it is found. It keeps the name that the case gives it.
    subroutine find_profile(name, kind, found)
      character(*), intent(in) :: name
      integer, intent(in) :: kind
      type(profile_type), intent(inout) :: found
      character(:), allocatable :: path

      call find_file(c%places, trim(name), path, error)
      if (.not. allocated(error)) call read_profile(path, kind, found, error)
      found%file = trim(name)
    end subroutine find_profile

  end subroutine place_sides

  !> The roll rate [rad/s] of a wheelset that moves along its rails with the initial lateral velocity: neither contact point of the
  !> rigid wheelset that stands on both rails moves along its normal. NaN where it cannot stand there.
  function roll_rate_on_rails(c, setup) result(rate)
    type(case_type), intent(in) :: c
    type(setup_type), intent(in) :: setup
    real(dp) :: rate, row(12, 1), slope(2)

    call geometry_at(setup%side, 0.0_dp, [c%y], row)
    slope = tan(row(4:5, 1))
    rate = c%vy*sum(slope)/(row(9, 1) - row(11, 1) + sum(slope*(row([10, 12], 1) - row(3, 1))))
  end function roll_rate_on_rails

  !> Set inertia and loads of the case; find equilibrium, eigenfrequencies and the static limit on the tables of `setup` or on rigid
  !> contacts.
  subroutine set_wheelset(c, setup, error)
    type(case_type), intent(in) :: c
    type(setup_type), intent(inout) :: setup
    type(error_type), allocatable, intent(out) :: error
    integer, parameter :: way(2) = [1, -1]
    integer :: k
    logical :: ok

    associate (w => setup%wheelset)
      w%mass = c%mass
      w%roll_inertia = c%roll_inertia
      w%pitch_inertia = c%pitch_inertia
      w%vertical_load = c%vertical_load
      w%lateral_force = c%lateral_force
      w%lateral_ramp = c%lateral_ramp
    end associate
    if (c%formulation == 'elastic') then
      setup%equilibrium = setup%centred
      call settle(setup%wheelset, setup%equilibrium, ok)
      if (.not. ok) then
        call refuse(error, 'an equilibrium with penetrations up to &table depth = '//str(c%extent%depth)//' m', 'none', &
          group='wheelset', variable='vertical_load', detail=' = '//str(c%vertical_load)//' N', &
          rest='; lower the load or raise the depth')
        return
      end if
      setup%rest = setup%equilibrium
      if (.not. setup%symmetric) call find_rest(setup%wheelset, setup%equilibrium, setup%rest, ok)
      if (ok) call small_oscillations(setup%wheelset, setup%rest, setup%frequency, setup%shapes)
    else
      setup%frequency = ieee_value(1.0_dp, ieee_quiet_nan)
      call rest_on_rails(setup%side, setup%wheelset%wheelset_type, setup%centred, setup%symmetric, c%extent%lateral, &
        setup%equilibrium, setup%rest, setup%frequency(1), setup%shapes(:, 1), ok)
    end if
    if (.not. ok) then
      call refuse(error, 'profiles on which the wheelset rests between its flanges', 'no equilibrium there', &
        group='profiles', variable='wheel_profile_right', detail=', rail_profile_right')
      return
    end if
    do k = 1, merge(1, 2, setup%symmetric)
      if (c%formulation == 'elastic') then
        call largest_force(setup%wheelset, setup%equilibrium, setup%side(k)%clearance, way(k), setup%limit(k), ok)
      else
        call largest_force_on_rails(setup%side, setup%wheelset%wheelset_type, setup%centred, c%extent%lateral, way(k), &
          setup%limit(k), ok)
      end if
      if (.not. ok) setup%limit(k) = ieee_value(1.0_dp, ieee_quiet_nan)
    end do
    if (setup%symmetric) setup%limit(2) = setup%limit(1)
  end subroutine set_wheelset

end module run_setup
