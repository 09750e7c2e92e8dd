!> Steps of a run with elastic contacts.
module elastic_run
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use rigid_geometry, only: geometry_at
  use zone_tables, only: outside_depth, outside_lateral, outside_law, outside_roll
  use errors, only: error_type, fatal_error
  use kinds, only: dp
  use motion_state, only: motion_type
  use integrators, only: advance, energy_change, energy_rounding, integrator_type, evaluate_contacts, step_diverged, step_ok
  use row_sink, only: at_event
  use run_monitor, only: normal_forces, passed_peak, instant, run_monitor_type
  use text, only: str
  implicit none
  private
  public :: start_elastic, elastic_step

contains

  !> The initial motion of the case.
  subroutine start_elastic(monitor, motion, error)
    type(run_monitor_type), intent(in) :: monitor
    type(motion_type), intent(out) :: motion
    type(error_type), allocatable, intent(out) :: error
    real(dp) :: row(12, 1), slope(2)
    integer :: status

    associate (c => monitor%c, setup => monitor%setup)
      motion%q = setup%equilibrium + [c%y, c%z, c%roll]
      motion%v = [c%vy, c%vz, c%roll_rate]
      if (c%roll_link == 'rails') then
        ! Neither contact point of the rigid wheelset that stands on both rails moves along its normal.
        call geometry_at(setup%side, 0.0_dp, [c%y], row)
        slope = tan(row(4:5, 1))
        motion%v(3) = c%vy*sum(slope)/(row(9, 1) - row(11, 1) + sum(slope*(row([10, 12], 1) - row(3, 1))))
      end if
      if (ieee_is_nan(motion%v(3))) then
        call fatal_error(error, '&initial Y = '//str(c%y)//' m: expected a wheelset on both rails with roll_link = ''rails'', '// &
          'found none there')
        return
      end if
      call evaluate_contacts(setup%wheelset, motion, status)
      if (status /= step_ok) call report_failure(monitor, motion, c%dt, status, error)
    end associate
  end subroutine start_elastic

  !> Make one step. If the step fails, or if the total energy changes by more than the tolerance, two, four or more equal
  !> steps replace the step. The criterion is the same for the reversed step, so the integration stays reversible.
  recursive subroutine elastic_step(integrator, motion, monitor, dt, halvings, error)
    type(integrator_type), intent(in) :: integrator
    type(motion_type), intent(inout) :: motion
    type(run_monitor_type), intent(inout) :: monitor
    real(dp), intent(in) :: dt               !! [s]
    integer, intent(in) :: halvings          !! number of halvings that have led to this step
    type(error_type), allocatable, intent(out) :: error
    type(motion_type) :: new
    integer :: evaluations, more, i, status
    real(dp) :: change, allowed

    associate (c => monitor%c, w => monitor%setup%wheelset, run => monitor%run)
      call advance(w, integrator, motion, dt, new, evaluations, status)
      run%evaluations = run%evaluations + evaluations
      more = 0
      if (status /= step_ok) then
        more = 1
        if (halvings == c%max_halvings) then
          call report_failure(monitor, motion, run%step, status, error)
          return
        end if
      else if (c%energy_tolerance > 0) then
        change = energy_change(w, motion, new)
        allowed = c%energy_tolerance
        if (abs(change) > allowed) allowed = max(allowed, energy_rounding(w, motion), energy_rounding(w, new))
        if (abs(change) > allowed) then
          ! The change goes with dt^(order + 1).
          more = min(max(1, (exponent(change/allowed) + c%order)/(c%order + 1)), c%max_halvings - halvings)
          if (more == 0) run%missed = run%missed + 1
        end if
      end if
      if (more > 0) then
        run%cuts = run%cuts + 1
        do i = 1, 2**more
          call elastic_step(integrator, motion, monitor, dt/2**more, halvings + more, error)
          if (allocated(error)) return
        end do
        return
      end if
    end associate
    call monitor%note_step(motion, new)
    motion = new
    call note_between(integrator, motion, monitor)
    call monitor%queue%pass_rows(monitor%past(1)%t, error)
  end subroutine elastic_step

  !> Write rows between the ends of steps: at the events of the last step, and at the peak of a force that has passed.
  subroutine note_between(integrator, motion, monitor)
    type(integrator_type), intent(in) :: integrator
    type(motion_type), intent(in) :: motion
    type(run_monitor_type), intent(inout) :: monitor
    type(motion_type) :: there
    real(dp) :: force(4), t
    integer :: i, k
    logical :: found

    if (monitor%event_rows) then
      do i = 1, monitor%run%log%n_moments
        call side_step(integrator, monitor, monitor%past(1), monitor%run%log%moments(i), there, found)
        if (found) call monitor%put(there, at_event)
      end do
    end if
    do k = 1, 4
      if (.not. passed_peak(monitor, k)) cycle
      call find_peak(monitor%forces(k, :), [monitor%past(2)%t, monitor%past(1)%t, motion%t], t, found)
      if (.not. found) cycle
      call side_step(integrator, monitor, monitor%past(merge(2, 1, t < monitor%past(1)%t)), t, there, found)
      if (.not. found) cycle
      force = normal_forces(there)
      if (force(k) < monitor%forces(k, 2)) there = monitor%past(1)
      call monitor%note_forces(there)
      if (monitor%event_rows) call monitor%put(there, at_event)
    end do
  end subroutine note_between

  !> Time at which the parabola through the forces of three steps is largest.
  pure subroutine find_peak(force, time, t, found)
    real(dp), intent(in) :: force(3), time(3)    !! [N, s]
    real(dp), intent(out) :: t                   !! [s]
    logical, intent(out) :: found                !! the parabola has a maximum
    real(dp) :: rise, fall, bend

    rise = (force(2) - force(1))/(time(2) - time(1))
    fall = (force(3) - force(2))/(time(3) - time(2))
    bend = (fall - rise)/(time(3) - time(1))
    t = time(2)
    found = bend < 0
    if (found) t = time(2) - (rise + bend*(time(2) - time(1)))/(2*bend)
  end subroutine find_peak

  !> The motion at a time t near the end `old` of a step. A separate step leads there, in as many parts as the energy
  !> tolerance needs. The run does not continue from this motion.
  subroutine side_step(integrator, monitor, old, t, there, found)
    type(integrator_type), intent(in) :: integrator
    type(run_monitor_type), intent(inout) :: monitor
    type(motion_type), intent(in) :: old
    real(dp), intent(in) :: t                    !! [s]
    type(motion_type), intent(out) :: there
    logical, intent(out) :: found                !! the steps converged
    type(motion_type) :: from
    integer, parameter :: most_halvings = 6
    integer :: evaluations, halvings, i, status

    there = old
    found = .true.
    if (abs(t - old%t) <= 0) return
    associate (tolerance => monitor%c%energy_tolerance, w => monitor%setup%wheelset)
      do halvings = 0, most_halvings
        there = old
        do i = 1, 2**halvings
          from = there
          call advance(w, integrator, from, (t - old%t)/2**halvings, there, evaluations, status)
          monitor%run%evaluations = monitor%run%evaluations + evaluations
          if (status /= step_ok) exit
        end do
        if (status /= step_ok) cycle
        if (tolerance <= 0 .or. abs(energy_change(w, old, there)) <= tolerance) exit
      end do
    end associate
    found = status == step_ok
  end subroutine side_step

  subroutine report_failure(monitor, motion, step, status, error)
    type(run_monitor_type), intent(in) :: monitor
    type(motion_type), intent(in) :: motion
    real(dp), intent(in) :: step                 !! [s]
    integer, intent(in) :: status                !! of `newmark` or `contact_table`
    type(error_type), allocatable, intent(out) :: error
    character(:), allocatable :: reason

    select case (status)
    case (outside_lateral)
      reason = '&table lateral = '//str(monitor%c%extent%lateral)//' m: expected the wheels within it, found them outside'
    case (outside_roll)
      reason = '&table roll = '//str(monitor%c%extent%roll)//' rad: expected the wheelset within it, found it outside'
    case (outside_depth)
      reason = '&table depth = '//str(monitor%c%extent%depth)//' m: expected penetrations within it, found a deeper one'
    case (outside_law)
      reason = '&table: expected poses that the table was made for, found one in which the contact would pull'
    case (step_diverged)
      reason = '&integrator dt = '//str(step)//' s: expected Newton to converge within '// &
        str(monitor%c%max_iterations)//' iterations and '//str(monitor%c%max_halvings)//' halvings, found it does not'
    case default
      reason = 'the step failed'
    end select
    reason = reason//trim(instant(motion, monitor%setup%equilibrium))
    if (step > monitor%run%stable_step) reason = reason//'; &integrator dt must be less than '//str(monitor%run%stable_step)// &
      ' s to be stable'
    call fatal_error(error, reason)
  end subroutine report_failure

end module elastic_run
