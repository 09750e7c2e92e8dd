!> Records of a run while it is integrated: rows, events, peaks, extremes, energy balance.
module run_monitor
  use case, only: case_type
  use columns, only: energies, energy_type, list_columns, most_columns
  use, intrinsic :: iso_fortran_env, only: int64
  use events, only: event_log, watch
  use kinds, only: dp
  use motion_state, only: motion_type
  use row_sink, only: on_grid, row_queue, row_writer
  use run_setup, only: setup_type
  use text, only: str
  implicit none
  private
  public :: run_type, run_monitor_type, passed_peak, normal_forces, instant

  !> The outcome of a run.
  type :: run_type
    integer :: rows = 0                    !! number of rows
    real(dp), allocatable :: last(:)       !! the last row
    real(dp) :: loss = 0                   !! energy lost in impacts [J]
    character(:), allocatable :: changes   !! initial conditions that were changed to meet rigid constraints, in words
    type(event_log) :: log
    real(dp) :: step = 0                   !! step in force, a whole fraction of the output interval [s]
    real(dp) :: stable_step = huge(1.0_dp) !! longest stable step, at the highest frequency at rest [s]
    real(dp) :: peak(4) = 0                !! largest normal force of each contact, also between rows [N]
    real(dp) :: peak_time(4) = 0           !! [s]
    real(dp) :: first_peak(4) = 0          !! largest normal force of each contact until it first opens [N]
    real(dp) :: first_peak_time(4) = 0     !! [s]
    logical :: has_opened(4) = .false.     !! whether a contact has been closed and has opened
    real(dp) :: extreme(3) = 0             !! farthest to the left, to the right, up from equilibrium, also between rows [m]
    real(dp) :: extreme_time(3) = 0        !! [s]
    real(dp) :: largest_impulse(4) = 0     !! largest impulse of each contact in one impact [N s]
    real(dp) :: impulse_time(4) = 0        !! [s]
    real(dp) :: drift = 0                  !! largest |total energy - work + losses - initial|, over all steps [J]
    real(dp) :: kinetic_energy = 0         !! initial energy of lateral, vertical and roll motion [J]
    real(dp) :: largest_energy = 0         !! largest energy of this motion [J]
    integer(int64) :: steps = 0
    integer(int64) :: cuts = 0             !! number of steps that were cut
    integer(int64) :: missed = 0           !! steps that change the total energy by more than allowed after all halvings
    integer(int64) :: evaluations = 0      !! evaluations of the contacts in steps
    logical :: cancelled = .false.         !! stopped by the watcher
    logical :: gone = .false.              !! the derailed wheelset has left the range of the table
    real(dp) :: seconds = 0                !! processor time of the integration
  end type run_type

  !> The state of the records between the steps of a run.
  type :: run_monitor_type
    type(case_type), pointer :: c => null()
    type(setup_type), pointer :: setup => null()
    type(run_type) :: run
    type(row_queue) :: queue
    logical :: event_rows = .true.         !! events and peaks have rows too
    type(motion_type) :: past(2)           !! the motion one and two steps ago
    real(dp) :: forces(4, 3) = 0           !! normal forces two steps ago, one step ago and now [N]
    real(dp) :: first_energy = 0           !! total energy at the start [J]
  contains
    procedure :: start
    procedure :: put
    procedure :: note_step
    procedure :: note_forces
    procedure :: note_energy
  end type run_monitor_type

contains

  !> Record the initial motion.
  subroutine start(this, motion, writer)
    class(run_monitor_type), intent(inout) :: this
    type(motion_type), intent(in) :: motion
    class(row_writer), target, intent(inout) :: writer   !! receives the rows
    type(energy_type) :: e

    this%event_rows = this%c%rows == 'interval_and_events'
    this%forces = spread(normal_forces(motion), 2, 3)
    this%past = motion
    this%run%peak = this%forces(:, 3)
    this%run%first_peak = this%run%peak
    this%run%extreme = motion%q([1, 1, 2])
    e = energies(this%c, this%setup, motion)
    this%run%kinetic_energy = sum(e%kinetic(2:4))
    this%first_energy = e%total
    call this%queue%begin(1e-6_dp*this%c%interval, writer)
    call this%put(motion, on_grid)
  end subroutine start

  !> Pass on the row of a motion, in the order of time.
  subroutine put(this, motion, kind)
    class(run_monitor_type), intent(inout) :: this
    type(motion_type), intent(in) :: motion
    integer, intent(in) :: kind            !! on_grid, at_event, at_impact
    real(dp) :: values(most_columns)
    integer :: n

    call list_columns(this%c, this%setup, motion, this%first_energy, values, n)
    call this%queue%put(values(:n), kind)
    call this%note_energy(motion)
  end subroutine put

  !> Record a step from `old` to `new`: events, farthest displacements, impulses, forces of the last three steps, energy.
  subroutine note_step(this, old, new)
    class(run_monitor_type), intent(inout) :: this
    type(motion_type), intent(in) :: old, new

    this%run%steps = this%run%steps + 1
    call watch(this%run%log, this%setup%wheelset, old, new, this%setup%side)
    call note_extremes(this%run, old, new)
    where (new%impulse - old%impulse > this%run%largest_impulse) this%run%impulse_time = new%t
    this%run%largest_impulse = max(this%run%largest_impulse, new%impulse - old%impulse)
    this%past(2) = this%past(1)
    this%past(1) = old
    this%forces(:, 1) = this%forces(:, 2)
    this%forces(:, 2) = this%forces(:, 3)
    this%forces(:, 3) = normal_forces(new)
    ! One step late, because a peak between the last two steps is noted after this step.
    this%run%has_opened = this%run%has_opened .or. (this%forces(:, 1) > 0 .and. .not. this%forces(:, 2) > 0)
    call this%note_forces(new)
    call this%note_energy(new)
  end subroutine note_step

  !> Largest normal forces, of the whole run and of the first time in which each contact is closed.
  subroutine note_forces(this, motion)
    class(run_monitor_type), intent(inout) :: this
    type(motion_type), intent(in) :: motion
    real(dp) :: force(4)

    force = normal_forces(motion)
    where (force > this%run%peak) this%run%peak_time = motion%t
    this%run%peak = max(this%run%peak, force)
    where (force > this%run%first_peak .and. .not. this%run%has_opened)
      this%run%first_peak = force
      this%run%first_peak_time = motion%t
    end where
  end subroutine note_forces

  !> The largest drift of the energy balance.
  subroutine note_energy(this, motion)
    class(run_monitor_type), intent(inout) :: this
    type(motion_type), intent(in) :: motion
    type(energy_type) :: e

    e = energies(this%c, this%setup, motion)
    this%run%loss = motion%loss
    this%run%largest_energy = max(this%run%largest_energy, sum(e%kinetic(2:4)))
    this%run%drift = max(this%run%drift, abs(e%total - motion%work - this%first_energy + motion%loss))
  end subroutine note_energy

  !> Farthest displacements: at the end of a step or, where the velocity turns within it, on the cubic through both ends.
  pure subroutine note_extremes(run, old, new)
    type(run_type), intent(inout) :: run
    type(motion_type), intent(in) :: old, new
    integer, parameter :: coordinate(3) = [1, 1, 2], way(3) = [1, -1, 1]
    real(dp) :: u, rise, before, after, x
    integer :: k

    do k = 1, 3
      associate (j => coordinate(k))
        u = 1
        rise = new%q(j) - old%q(j)
        x = new%q(j)
        if (way(k)*old%v(j) > 0 .and. way(k)*new%v(j) < 0) then
          before = (new%t - old%t)*old%v(j)
          after = (new%t - old%t)*new%v(j)
          u = before/(before - after)
          x = old%q(j) + u*(before + u*(3*rise - 2*before - after + u*(before + after - 2*rise)))
        end if
      end associate
      if (way(k)*(x - run%extreme(k)) <= 0) cycle
      run%extreme(k) = x
      run%extreme_time(k) = old%t + u*(new%t - old%t)
    end do
  end subroutine note_extremes

  !> Whether the normal force of contact k was largest about one step ago: a peak is known one step after it has passed.
  pure logical function passed_peak(this, k)
    class(run_monitor_type), intent(in) :: this
    integer, intent(in) :: k

    passed_peak = this%forces(k, 2) > this%forces(k, 1) .and. this%forces(k, 2) >= this%forces(k, 3)
  end function passed_peak

  !> Normal forces of the four contacts [N].
  pure function normal_forces(motion) result(force)
    type(motion_type), intent(in) :: motion
    real(dp) :: force(4)

    force = hypot(motion%contact%slope(1, :), motion%contact%slope(2, :))
  end function normal_forces

  !> The time that a run has reached, for messages.
  function instant(motion, equilibrium)
    type(motion_type), intent(in) :: motion
    real(dp), intent(in) :: equilibrium(3)
    character(160) :: instant

    instant = ' at t = '//str(motion%t)//' s, Y = '//str(motion%q(1))//' m, Z = '// &
      str(motion%q(2) - equilibrium(2))//' m, roll = '//str(motion%q(3) - equilibrium(3))//' rad'
  end function instant

end module run_monitor
