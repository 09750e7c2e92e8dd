!> Runs with rigid contacts, in a program that is made without them (`make RIGID=no`): they are refused.
module rigid_run
  use errors, only: error_type, fatal_error
  use kinds, only: dp
  use motion_state, only: motion_type
  use run_monitor, only: run_monitor_type
  implicit none
  private
  public :: rigid_type, start_rigid, rigid_step

  type :: rigid_type
  end type rigid_type

contains

  !> Refuse the run.
  subroutine start_rigid(monitor, rigid, motion, error)
    type(run_monitor_type), intent(inout) :: monitor
    type(rigid_type), intent(out) :: rigid
    type(motion_type), intent(out) :: motion
    type(error_type), allocatable, intent(out) :: error

    call fatal_error(error, '&contact formulation = '''//trim(monitor%c%formulation)//''': expected ''elastic'', for this '// &
      'program is made without rigid contacts')
  end subroutine start_rigid

  !> No run comes so far.
  subroutine rigid_step(rigid, motion, monitor, dt, error)
    type(rigid_type), intent(inout) :: rigid
    type(motion_type), intent(inout) :: motion
    type(run_monitor_type), intent(inout) :: monitor
    real(dp), intent(in) :: dt
    type(error_type), allocatable, intent(out) :: error
  end subroutine rigid_step

end module rigid_run
