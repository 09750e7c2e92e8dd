!> Steps of a case's integrator for a program that keeps the motion itself.
module motion_steps
  use, intrinsic :: iso_fortran_env, only: int64
  use cut_steps, only: cut_step, cutting_type, step_watcher
  use errors, only: error_type, fatal_error, refuse
  use integrators, only: evaluate_contacts, integrator_type, step_diverged, step_ok
  use kinds, only: dp
  use motion_state, only: motion_type
  use prepared_cases, only: prepared_type
  use text, only: str
  implicit none
  private
  public :: advance_motion, refuse_pose

  real(dp), parameter :: most_steps = 1e15_dp    !! that are counted without rounding

  !> Remembers how short steps had to be.
  type, extends(step_watcher) :: shortest_step
    real(dp) :: dt = huge(1.0_dp)          !! [s]
  contains
    procedure :: after_step
  end type shortest_step

contains

  !> Steps of the case's integrator, no longer than its `dt`, from one time to another.
  subroutine advance_motion(p, t, q, v, t_next, left_table, error)
    type(prepared_type), intent(in) :: p
    real(dp), intent(in) :: t, t_next          !! [s]
    real(dp), intent(inout) :: q(3), v(3)      !! at t, then at t_next
    logical, intent(out) :: left_table         !! the motion leaves the extent of the contact table, of which the error tells
    type(error_type), allocatable, intent(out) :: error
    type(integrator_type) :: integrator
    type(cutting_type) :: cutting
    type(motion_type) :: motion
    type(shortest_step) :: watcher
    integer(int64) :: n, i
    integer :: ended

    associate (c => p%c)
      integrator = integrator_type(c%order, c%beta, c%gamma, c%tolerance, c%max_iterations)
      cutting = cutting_type(c%error_tolerance, c%energy_tolerance, c%max_halvings)
      left_table = .false.
      if (t_next - t > most_steps*c%dt) then
        call refuse(error, 'a time at most '//str(most_steps)//' steps of &integrator dt ahead', str(t_next - t)//' s')
        return
      end if
      n = max(1_int64, ceiling((t_next - t)/c%dt*(1 - 1e-9_dp), int64))
    end associate
    motion%t = t
    motion%q = q
    motion%v = v
    call evaluate_contacts(p%setup%wheelset, motion, ended)
    do i = 1, n
      if (ended /= step_ok) exit
      call cut_step(p%setup%wheelset, integrator, cutting, motion, (t_next - t)/n, 0, watcher, ended, error)
      if (allocated(error)) return
    end do
    left_table = .not. any(ended == [step_ok, step_diverged])
    if (ended == step_diverged) then
      call fatal_error(error, 'expected steps that converge, found one at t = '//str(motion%t)//' s that does not, '// &
        'after steps down to '//str(watcher%dt)//' s; shorten &integrator dt')
    else if (left_table) then
      call refuse_pose(motion%q, error)
    else
      q = motion%q
      v = motion%v
    end if
  end subroutine advance_motion

  !> Say that a pose is outside the contact table.
  subroutine refuse_pose(q, error)
    real(dp), intent(in) :: q(3)
    type(error_type), allocatable, intent(out) :: error

    call refuse(error, 'a pose within the extent of &table', 'y = '//str(q(1))//' m, z = '//str(q(2))//' m, roll = '// &
      str(q(3))//' rad')
  end subroutine refuse_pose

  subroutine after_step(this, old, new, error)
    class(shortest_step), intent(inout) :: this
    type(motion_type), intent(in) :: old, new
    type(error_type), allocatable, intent(out) :: error

    this%dt = min(this%dt, new%t - old%t)
  end subroutine after_step

end module motion_steps
