!> Steps of a run with elastic contacts.
module elastic_run
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use case, only: case_type
  use zone_tables, only: outside_depth, outside_lateral, outside_law, outside_roll, unsettled
  use errors, only: append_advice, error_type, refuse
  use events, only: never, note_overturning, row_time_type
  use kinds, only: dp
  use motion_state, only: closed, motion_type
  use cut_steps, only: cut_step, cutting_type, short_step, step_watcher
  use force_peaks, only: find_peak, passed_peak
  use integrators, only: evaluate_contacts, integrator_type, step_diverged, step_ok
  use row_sink, only: at_event
  use run_monitor, only: normal_forces, instant, run_monitor_type
  use run_setup, only: roll_rate_on_rails, setup_type
  use text, only: str
  implicit none
  private
  public :: start_elastic, initial_motion, elastic_step

  !> Writes rows while steps are made.
  type, extends(step_watcher) :: row_watcher
    type(integrator_type) :: integrator
    type(cutting_type) :: cutting
    type(run_monitor_type), pointer :: monitor => null()
  contains
    procedure :: after_step
    procedure, private :: note_between, note_moment, step_aside
  end type row_watcher

contains

  !> The initial motion of a case, with its contacts.
  subroutine start_elastic(monitor, motion, error)
    type(run_monitor_type), intent(in) :: monitor
    type(motion_type), intent(out) :: motion
    type(error_type), allocatable, intent(out) :: error
    integer :: status

    call initial_motion(monitor%c, monitor%setup, motion, error)
    if (allocated(error)) return
    call evaluate_contacts(monitor%setup%wheelset, motion, status)
    if (status /= step_ok) call report_failure(monitor, motion, monitor%c%dt, status, error)
  end subroutine start_elastic

  !> Pose and velocity at the start of a case.
  subroutine initial_motion(c, setup, motion, error)
    type(case_type), intent(in) :: c
    type(setup_type), intent(in) :: setup
    type(motion_type), intent(out) :: motion
    type(error_type), allocatable, intent(out) :: error

    motion%q = setup%equilibrium + [c%y, c%z, c%roll]
    motion%v = [c%vy, c%vz, c%roll_rate]
    if (c%roll_link == 'rails') motion%v(3) = roll_rate_on_rails(c, setup)
    if (ieee_is_nan(motion%v(3))) call refuse(error, 'a wheelset that can stand on both rails, for roll_link = ''rails''', &
      'that it cannot', group='initial', variable='Y', detail=' = '//str(c%y)//' m', rest='; choose a Y nearer to 0')
  end subroutine initial_motion

  !> Make one step, in parts where it is cut.
  subroutine elastic_step(integrator, motion, monitor, dt, error)
    type(integrator_type), intent(in) :: integrator
    type(motion_type), intent(inout) :: motion
    type(run_monitor_type), target, intent(inout) :: monitor
    real(dp), intent(in) :: dt               !! [s]
    type(error_type), allocatable, intent(out) :: error
    type(row_watcher) :: watcher
    integer :: status

    watcher%integrator = integrator
    watcher%cutting = cutting_type(monitor%c%error_tolerance, monitor%c%energy_tolerance, monitor%c%max_halvings)
    watcher%monitor => monitor
    call cut_step(monitor%setup%wheelset, integrator, watcher%cutting, motion, dt, 0, watcher, status, error)
    associate (run => monitor%run)
      run%cuts = run%cuts + watcher%cuts
      run%missed = run%missed + watcher%missed
      run%evaluations = run%evaluations + watcher%evaluations
      if (status == step_ok .or. allocated(error)) return
      ! A wheelset that has derailed, or that overturns, leaves the table, which ends the run.
      if (any(status == [outside_lateral, outside_roll, outside_depth])) then
        call note_overturning(run%log, monitor%setup%wheelset, motion, monitor%setup%side)
        run%gone = run%log%derailed%t < never
      end if
      if (.not. run%gone) call report_failure(monitor, motion, run%step, status, error)
    end associate
  end subroutine elastic_step

  !> Record a step, and write the rows that are due.
  subroutine after_step(this, old, new, error)
    class(row_watcher), intent(inout) :: this
    type(motion_type), intent(in) :: old, new
    type(error_type), allocatable, intent(out) :: error

    call this%monitor%note_step(old, new)
    call this%note_between(new)
    call this%monitor%put_in_contact(new)
    call this%monitor%queue%pass_rows(this%monitor%past(1)%t, error)
  end subroutine after_step

  !> Write rows between the ends of steps: at the events of the last step, and at the peak of a force that has passed.
  subroutine note_between(this, motion)
    class(row_watcher), intent(inout) :: this
    type(motion_type), intent(in) :: motion
    type(motion_type) :: there
    real(dp) :: force(4), t
    integer :: i, k
    logical :: found

    associate (monitor => this%monitor)
      if (monitor%event_rows) then
        do i = 1, monitor%run%log%n_moments
          call this%note_moment(monitor%run%log%moments(i))
        end do
      end if
      do k = 1, 4
        if (.not. passed_peak(monitor%forces(k, :))) cycle
        call find_peak(monitor%forces(k, :), [monitor%past(2)%t, monitor%past(1)%t, motion%t], t, found)
        if (.not. found) cycle
        call this%step_aside(monitor%past(merge(2, 1, t < monitor%past(1)%t)), t, there, found)
        if (.not. found) cycle
        force = normal_forces(there)
        if (force(k) < monitor%forces(k, 2)) there = monitor%past(1)
        call monitor%note_forces(there)
        if (monitor%event_rows) call monitor%put(there, at_event)
      end do
    end associate
  end subroutine note_between

  !> Write the row of a moment. The time of a contact's change is that of an interpolated pose, so the contact of the row may
  !> change some nanoseconds later: the row is the first one that shows the change.
  subroutine note_moment(this, moment)
    class(row_watcher), intent(inout) :: this
    type(row_time_type), intent(in) :: moment
    real(dp), parameter :: first = 1e-9_dp       ! [s]
    integer, parameter :: most = 8               ! trials, each twice as late
    type(motion_type) :: there
    logical :: found, is_closed(4)
    integer :: i

    do i = 0, most
      call this%step_aside(this%monitor%past(1), moment%t + merge(0.0_dp, first*2**(i - 1), i == 0), there, found)
      if (.not. found) return
      is_closed = closed(there%contact)
      if (moment%contact == 0) exit
      if (is_closed(moment%contact) .eqv. moment%closed) exit
    end do
    call this%monitor%put(there, at_event)
  end subroutine note_moment

  !> The motion at a time t near the end `old` of a step, from which the run does not continue.
  subroutine step_aside(this, old, t, there, found)
    class(row_watcher), intent(inout) :: this
    type(motion_type), intent(in) :: old
    real(dp), intent(in) :: t                    !! [s]
    type(motion_type), intent(out) :: there
    logical, intent(out) :: found                !! the steps converged

    call short_step(this%monitor%setup%wheelset, this%integrator, this%cutting, old, t, there, found, this%evaluations)
  end subroutine step_aside

  subroutine report_failure(monitor, motion, step, status, error)
    type(run_monitor_type), intent(in) :: monitor
    type(motion_type), intent(in) :: motion
    real(dp), intent(in) :: step                 !! [s]
    integer, intent(in) :: status                !! of `integrators` or `contact_table`
    type(error_type), allocatable, intent(out) :: error
    character(:), allocatable :: there

    there = trim(instant(motion, monitor%setup%equilibrium))
    associate (c => monitor%c)
      select case (status)
      case (outside_lateral)
        call refuse(error, 'wheels that the contact table covers', 'one farther away'//there, &
          group='table', variable='lateral', detail=' = '//str(c%extent%lateral)//' m')
      case (outside_roll)
        call refuse(error, 'roll angles that the contact table covers', 'a larger one'//there, &
          group='table', variable='roll', detail=' = '//str(c%extent%roll)//' rad')
      case (outside_depth)
        call refuse(error, 'penetrations that the contact table covers', 'a deeper one'//there, &
          group='table', variable='depth', detail=' = '//str(c%extent%depth)//' m')
      case (outside_law)
        call refuse(error, 'a contact table whose forces push', 'a pose in which its force pulls'//there, group='table')
      case (unsettled)
        call refuse(error, 'places of a wheel whose influences on each other settle', 'that they do not'//there, &
          group='contact', variable='influence', detail=' = '//trim(c%influence), rest='; lower table accuracy')
      case (step_diverged)
        call refuse(error, 'Newton''s method to solve a step within '//str(c%max_iterations)//' iterations and '// &
          str(c%max_halvings)//' halvings of the step', 'that it does not'//there, &
          group='integrator', variable='dt', detail=' = '//str(step)//' s')
      case default
        call refuse(error, 'a step that the integrator can make', 'none'//there)
      end select
    end associate
    if (step > monitor%run%stable_step) &
      call append_advice(error, '&integrator dt must be less than '//str(monitor%run%stable_step)//' s to be stable')
  end subroutine report_failure

end module elastic_run
