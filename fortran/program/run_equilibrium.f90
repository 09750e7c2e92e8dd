!> Static equilibrium of the wheelset of a case, and small oscillations about it.
module run_equilibrium
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use both_rails, only: small_motion, stand, to_rest => find_rest
  use case, only: case_type
  use errors, only: error_type, fatal_error
  use kinds, only: dp
  use run_setup, only: setup_type
  use rigid_steps, only: rigid_state
  use text, only: str
  use wheelset, only: find_rest, settle, small_oscillations
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

  !> With rigid contacts the wheelset is in equilibrium at the lowest pose on both rails, and oscillates from there along
  !> such poses.
  subroutine set_rigid(c, setup, error)
    type(case_type), intent(in) :: c
    type(setup_type), intent(inout) :: setup
    type(error_type), allocatable, intent(out) :: error
    type(rigid_state) :: state
    logical :: corner, ok

    corner = .false.
    call stand(setup%side, setup%wheelset, setup%centred, state, ok)
    setup%equilibrium = [0.0_dp, state%motion%q(2), merge(0.0_dp, state%motion%q(3), setup%symmetric)]
    if (ok .and. .not. setup%symmetric) call to_rest(setup%side, setup%wheelset, c%extent%lateral, state, corner, ok)
    if (.not. ok) then
      call no_rest(error)
      return
    end if
    setup%rest = merge(setup%equilibrium, state%motion%q, setup%symmetric)
    setup%frequency = ieee_value(1.0_dp, ieee_quiet_nan)
    call small_motion(setup%wheelset, state, corner, setup%frequency(1), setup%shapes(:, 1))
  end subroutine set_rigid

end module run_equilibrium
