!> Steps of a run with rigid contacts.
module rigid_run
  use errors, only: error_type, refuse
  use events, only: never
  use force_peaks, only: passed_peak
  use kinds, only: dp
  use motion_state, only: energy_rounding, motion_type
  use rigid_motion, only: advance_rigid, no_solution, path_ends, rigid_type, rule_type, start_motion, step_ok
  use row_sink, only: at_event, at_impact
  use run_monitor, only: normal_forces, instant, run_monitor_type
  use run_setup, only: setup_type
  implicit none
  private
  public :: rigid_type, start_rigid, rigid_step

contains

  !> The initial motion of the case; `changes` of the run says what the constraints changed.
  subroutine start_rigid(monitor, rigid, motion, error)
    type(run_monitor_type), intent(inout) :: monitor
    type(rigid_type), intent(out) :: rigid
    type(motion_type), intent(out) :: motion
    type(error_type), allocatable, intent(out) :: error

    associate (c => monitor%c, setup => monitor%setup)
      call start_motion(rule_type(c%formulation == 'bilateral', c%restitution, c%energy_tolerance, c%max_halvings), &
        [c%y, c%z, c%roll], [c%vy, c%vz, c%roll_rate], setup%wheelset%wheelset_type, setup%side, &
        setup%equilibrium, c%extent%lateral, rigid, motion, monitor%run%changes, error)
    end associate
  end subroutine start_rigid

  !> Make a step in pieces from event to event. The formulation itself cuts pieces by their energy error. Pieces that still
  !> miss the tolerance are counted.
  subroutine rigid_step(rigid, motion, monitor, dt, error)
    type(rigid_type), intent(inout) :: rigid
    type(motion_type), intent(inout) :: motion
    type(run_monitor_type), intent(inout) :: monitor
    real(dp), intent(in) :: dt                   !! [s]
    type(error_type), allocatable, intent(out) :: error
    type(rigid_type) :: rigid_before
    type(motion_type) :: old
    real(dp) :: h, left
    integer :: evaluations, status

    left = dt
    do while (left > 1e-12_dp*dt)
      old = motion
      if (monitor%event_rows) rigid_before = rigid
      h = left
      associate (c => monitor%c, setup => monitor%setup, run => monitor%run)
        call advance_rigid(setup%side, rigid, motion, h, evaluations, status)
        left = left - h
        motion%push = old%push + (motion%impulse - old%impulse) + h/2*(force_of(old) + force_of(last_state(rigid, motion)))
        run%evaluations = run%evaluations + evaluations
        if (c%energy_tolerance > 0 .and. abs(rigid%state%error) > max(c%energy_tolerance, &
          energy_rounding(setup%wheelset, old))) run%missed = run%missed + 1
      end associate
      call monitor%note_step(old, motion)
      call note_rows(rigid, rigid_before, motion, monitor, error)
      if (.not. allocated(error)) call monitor%queue%pass_rows(monitor%past(1)%t, error)
      if (allocated(error)) return
      if (status == step_ok) cycle
      ! A wheelset that has derailed leaves the rails on which both wheels are held, which ends the run.
      monitor%run%gone = monitor%run%log%derailed%t < never .and. status == path_ends
      if (.not. monitor%run%gone) call report_failure(monitor%setup, motion, status, error)
      return
    end do
    ! The run of a derailed wheelset ends outside what a contact table would cover.
    associate (q => motion%q, extent => monitor%c%extent, height => monitor%setup%equilibrium(2))
      monitor%run%gone = monitor%run%log%derailed%t < never .and. (abs(q(1) + height*sin(q(3))) > extent%lateral &
        .or. abs(q(3)) > extent%roll .or. q(2) < height - extent%drop)
    end associate
  end subroutine rigid_step

  !> The motion at the end of a piece, before an impact.
  pure type(motion_type) function last_state(rigid, motion) result(last)
    type(rigid_type), intent(in) :: rigid
    type(motion_type), intent(in) :: motion

    last = motion
    if (any(motion%contact%struck)) last = rigid%before
  end function last_state

  !> Normal forces [N], negative where a rail pulls.
  pure function force_of(motion) result(force)
    type(motion_type), intent(in) :: motion
    real(dp) :: force(4)

    force = merge(-1, 1, motion%contact%pulls)*normal_forces(motion)
  end function force_of

  !> Write rows at the events of the last step and at peaks of forces. A peak is the force at the end of a step.
  subroutine note_rows(rigid, rigid_before, motion, monitor, error)
    type(rigid_type), intent(in) :: rigid           !! at the end of the step
    type(rigid_type), intent(inout) :: rigid_before !! at the start of the step
    type(motion_type), intent(in) :: motion
    type(run_monitor_type), intent(inout) :: monitor
    type(error_type), allocatable, intent(out) :: error
    type(motion_type) :: there
    real(dp) :: t, h
    integer :: i, k, evaluations, status
    logical :: struck

    struck = any(motion%contact%struck)
    if (struck) call monitor%note_forces(rigid%before)
    if (.not. monitor%event_rows) return
    do k = 1, 4
      if (passed_peak(monitor%forces(k, :))) call monitor%put(monitor%past(1), at_event)
    end do
    if (struck) then
      call monitor%put(rigid%before, at_impact)
      call monitor%put(motion, at_impact)
    end if
    do i = 1, monitor%run%log%n_moments
      t = monitor%run%log%moments(i)%t
      there = motion
      if (t < motion%t) there = monitor%past(1)
      do while (t - there%t > epsilon(t)*t)
        h = t - there%t
        call advance_rigid(monitor%setup%side, rigid_before, there, h, evaluations, status)
        monitor%run%evaluations = monitor%run%evaluations + evaluations
        if (status /= step_ok) call report_failure(monitor%setup, there, status, error)
        if (allocated(error)) return
      end do
      call monitor%put(there, at_event)
    end do
  end subroutine note_rows

  subroutine report_failure(setup, motion, status, error)
    type(setup_type), intent(in) :: setup
    type(motion_type), intent(in) :: motion
    integer, intent(in) :: status                !! of `rigid_motion`
    type(error_type), allocatable, intent(out) :: error
    character(:), allocatable :: detail, expected, found

    select case (status)
    case (path_ends)
      detail = 'formulation = ''bilateral'''
      expected = 'a path on which both wheels stay on their rails'
      found = 'its end'
    case (no_solution)
      detail = 'formulation = ''unilateral'''
      expected = 'impulses of at most three contacts that end an impact'
      found = 'none,'
    case default
      detail = 'formulation = ''unilateral'''
      expected = 'time between impacts'
      found = 'one impact after another at once,'
    end select
    call refuse(error, expected, found//instant(motion, setup%equilibrium), detail=detail)
  end subroutine report_failure

end module rigid_run
