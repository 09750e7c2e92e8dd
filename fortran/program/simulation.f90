!> The story of a run.
!>
!> 1. `read_case` reads the namelist and `check_case` checks it, before this module is called.
!> 2. `prepare` places the wheels on the rails, loads the contact tables or builds them, and finds the pose of rest.
!> 3. `simulate` advances the motion from row to row. A step that changes the energy too much is cut (`cut_steps`,
!>    `rigid_steps`). After each step events are watched for, and rows, peaks and the energy balance are noted.
!> 4. `run_results` tells what the run came to, after this module has returned.
module simulation
  use case, only: case_type
  use elastic_run, only: elastic_step, start_elastic
  use errors, only: error_type
  use events, only: never
  use kinds, only: dp, pi
  use motion_state, only: motion_type
  use integrators, only: integrator_type, stability_limit
  use progress, only: monitor_type
  use rigid_run, only: rigid_step, rigid_type, start_rigid
  use row_sink, only: on_grid, row_writer
  use run_monitor, only: run_monitor_type, run_type
  use run_setup, only: place_sides, set_wheelset, setup_type
  use run_tables, only: open_tables
  implicit none
  private
  public :: prepare, simulate

contains

  !> Prepare a run up to the start of the integration. `free_tables` of run_tables frees the tables.
  subroutine prepare(c, setup, error)
    type(case_type), intent(in) :: c
    type(setup_type), intent(out) :: setup
    type(error_type), allocatable, intent(out) :: error
    real(dp) :: from, to

    call cpu_time(from)
    call place_sides(c, setup, error)
    if (allocated(error)) return
    setup%modes = merge(3, 1, c%formulation == 'elastic')
    if (c%formulation == 'elastic') call open_tables(c, setup)
    call set_wheelset(c, setup, error)
    call cpu_time(to)
    setup%seconds = to - from
  end subroutine prepare

  !> Integrate from the initial conditions to the stop condition.
  subroutine simulate(c, setup, writer, run, error, watcher)
    type(case_type), target, intent(in) :: c
    type(setup_type), target, intent(in) :: setup
    class(row_writer), target, intent(inout) :: writer   !! receives the rows
    type(run_type), intent(out) :: run
    type(error_type), allocatable, intent(out) :: error
    class(monitor_type), intent(inout), optional :: watcher
    type(integrator_type) :: integrator
    type(motion_type) :: motion
    type(rigid_type), allocatable :: rigid
    type(run_monitor_type), allocatable :: monitor
    real(dp) :: from, to
    real(dp) :: at, h                      ! time of the next row and the steps up to it [s]
    integer, parameter :: report_steps = 10000
    integer :: substeps                    ! steps between rows
    integer :: last_row, report_rows, row, i
    logical :: elastic

    call cpu_time(from)
    allocate (rigid, monitor)
    integrator = integrator_type(c%order, c%beta, c%gamma, c%tolerance, c%max_iterations)
    substeps = ceiling(c%interval/c%dt*(1 - 1e-9_dp))
    monitor%run%step = c%interval/substeps
    report_rows = max(1, min(100, report_steps/substeps))
    last_row = ceiling(c%t_end/c%interval*(1 - 1e-9_dp))
    elastic = c%formulation == 'elastic'

    monitor%c => c
    monitor%setup => setup
    monitor%run%changes = ''
    if (elastic) then
      monitor%run%stable_step = stability_limit(integrator)/(2*pi*maxval(setup%frequency))
      call start_elastic(monitor, motion, error)
    else
      call start_rigid(monitor, rigid, motion, error)
    end if
    if (allocated(error)) return
    call monitor%start(motion, writer)
    rows: do row = 1, last_row
      at = row*c%interval
      h = monitor%run%step
      if (at - c%t_end > 1e-9_dp*c%interval) then
        at = c%t_end
        h = (at - (row - 1)*c%interval)/substeps
      end if
      do i = 1, substeps
        motion%t = (row - 1)*c%interval + (i - 1)*h
        if (elastic) then
          call elastic_step(integrator, motion, monitor, h, error)
        else
          call rigid_step(rigid, motion, monitor, h, error)
        end if
        if (allocated(error)) return
        if (monitor%run%gone) exit rows
        if (mod(i, report_steps) == 0) call report_progress((row - 1 + real(i, dp)/substeps)/last_row)
        if (monitor%run%cancelled) exit rows
      end do
      motion%t = at
      call monitor%put(motion, on_grid)
      if (mod(row, report_rows) == 0) call report_progress(row/real(last_row, dp))
      if ((c%stop_at == 'derailment' .and. monitor%run%log%derailed%t < never) .or. &
        (c%stop_at == 'return_to_centre' .and. monitor%run%log%returned < never) .or. monitor%run%cancelled) exit
    end do rows
    call monitor%queue%pass_rows(huge(at), error)
    if (allocated(error)) return
    call monitor%press()
    call monitor%judge()
    run = monitor%run
    run%rows = monitor%queue%passed
    run%last = monitor%queue%last
    run%extreme(3:) = run%extreme(3:) - setup%equilibrium([2, 2, 3, 3])
    call cpu_time(to)
    run%seconds = to - from

  contains

    !> Tell the watcher how far the run is, and learn whether the run is to stop.
    subroutine report_progress(share)
      real(dp), intent(in) :: share

      if (.not. present(watcher)) return
      call watcher%report(share)
      monitor%run%cancelled = watcher%stop
    end subroutine report_progress

  end subroutine simulate

end module simulation
