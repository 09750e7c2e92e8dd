!> Static equilibrium of the wheelset of a case, and small oscillations about it.
module run_equilibrium
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use case, only: case_type
  use eigenmodes, only: small_oscillations
  use errors, only: error_type, fatal_error
  use kinds, only: dp
  use path_points, only: lowest_point, point_type, small_motion
  use rigid_path, only: follow_path, path_type
  use run_setup, only: setup_type
  use text, only: str
  use wheel_rail_pair, only: mirror
  use wheelset, only: find_rest, settle
  implicit none
  private
  public :: set_wheelset

contains

  !> Set inertia and loads of the case; find equilibrium and eigenfrequencies on the tables of `setup` or on rigid contacts.
  subroutine set_wheelset(c, setup, error)
    type(case_type), intent(in) :: c
    type(setup_type), intent(inout) :: setup
    type(error_type), allocatable, intent(out) :: error
    logical :: ok

    setup%wheelset%mass = c%mass
    setup%wheelset%roll_inertia = c%roll_inertia
    setup%wheelset%pitch_inertia = c%pitch_inertia
    setup%wheelset%vertical_load = c%vertical_load
    setup%wheelset%lateral_force = c%lateral_force
    setup%wheelset%lateral_ramp = c%lateral_ramp
    if (c%formulation /= 'elastic') then
      call set_rigid(c, setup, error)
      return
    end if
    setup%equilibrium = setup%centred
    call settle(setup%wheelset, setup%equilibrium, ok)
    if (.not. ok) then
      call fatal_error(error, '&wheelset vertical_load = '//str(c%vertical_load)// &
        ' N: expected an equilibrium within &table depth = '//str(c%extent%depth)//' m, found none')
      return
    end if
    setup%rest = setup%equilibrium
    if (.not. setup%symmetric) call find_rest(setup%wheelset, setup%equilibrium, setup%rest, ok)
    if (.not. ok) then
      call no_rest(error)
      return
    end if
    call small_oscillations(setup%wheelset, setup%rest, setup%frequency, setup%shapes)
  end subroutine set_wheelset

  subroutine no_rest(error)
    type(error_type), allocatable, intent(out) :: error

    call fatal_error(error, '&profiles wheel_profile_right, rail_profile_right: expected an equilibrium between the '// &
      'flanges, found none')
  end subroutine no_rest

  !> With rigid contacts the wheelset is in equilibrium at the lowest point of the path on both rails, and oscillates along
  !> this path.
  subroutine set_rigid(c, setup, error)
    type(case_type), intent(in) :: c
    type(setup_type), intent(inout) :: setup
    type(error_type), allocatable, intent(out) :: error
    type(point_type) :: lowest
    logical :: ok

    call follow_path(setup%side, setup%centred, setup%wheelset%inertia(), c%extent%lateral, setup%path(1))
    if (setup%symmetric) then
      setup%path(2) = setup%path(1)
    else
      call follow_path(setup%side(2:1:-1), mirror*setup%centred, setup%wheelset%inertia(), c%extent%lateral, setup%path(2))
    end if
    setup%equilibrium = [0.0_dp, setup%path(1)%q(2, 1), merge(0.0_dp, setup%path(1)%q(3, 1), setup%symmetric)]
    call lowest_point(setup%path, lowest, ok)
    if (.not. ok) then
      call no_rest(error)
      return
    end if
    setup%frequency = ieee_value(1.0_dp, ieee_quiet_nan)
    call small_motion(setup%path, setup%side, setup%wheelset, lowest, setup%rest, setup%frequency(1), setup%shapes(:, 1))
    if (c%formulation /= 'bilateral') setup%path = path_type()
  end subroutine set_rigid

end module run_equilibrium
