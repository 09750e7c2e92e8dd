!> Records of a run while it is integrated: rows, events, peaks, extremes, energy balance.
module run_monitor
  use case, only: case_type
  use contact_pressure, only: flange_part
  use columns, only: energies, energy_type, list_columns, most_columns
  use, intrinsic :: iso_fortran_env, only: int64
  use events, only: event_log, never, watch
  use judged_poses, only: accuracy_type, pose_choice
  use kinds, only: dp
  use largest_pressure, only: find_pressures, hardest_rows, has_pressures, moment_type, pressure_type
  use motion_state, only: closed, motion_type
  use root_bracket, only: bracket_type
  use row_sink, only: at_event, on_grid, row_queue, row_writer
  use run_setup, only: setup_type
  use text, only: str
  use wheelset, only: flanges, outwards
  implicit none
  private
  public :: run_type, run_monitor_type, normal_forces, instant

  integer, parameter :: coordinate(6) = [1, 1, 2, 2, 3, 3], way(6) = [1, -1, 1, -1, 1, -1]   !! of the extremes

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
    real(dp) :: first_impulse(4) = 0       !! of each contact from its first touch until it first opens [N s]
    real(dp) :: turn_impulse(2) = -1       !! of each flange from its first touch until the wheelset moves back [N s]; -1 before
    !> Largest and smallest Y, Z and roll, also between rows; Z and roll from equilibrium [m, m, rad].
    real(dp) :: extreme(6) = 0
    real(dp) :: extreme_time(6) = 0        !! [s]
    type(pressure_type) :: pressure        !! largest pressure of all contacts
    type(flange_part) :: flange(2)     !! at the first peak of the left and of the right flange
    type(accuracy_type) :: accuracy        !! of the contact forces
    real(dp) :: largest_impulse(4) = 0     !! largest impulse of each contact in one impact [N s]
    real(dp) :: impulse_time(4) = 0        !! [s]
    real(dp) :: drift = 0                  !! largest |total energy - work + losses - initial|, over all steps [J]
    real(dp) :: drift_time = 0             !! [s]
    real(dp) :: kinetic_energy = 0         !! initial energy of lateral, vertical and roll motion [J]
    real(dp) :: largest_work = 0           !! largest |work of the lateral force| [J]
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
    logical :: contact_rows = .false.      !! rows are close in contacts
    real(dp) :: closing(4) = never         !! time at which each closed contact has closed [s]
    real(dp) :: newest = 0                 !! time of the newest row [s]
    real(dp) :: half_period = 0            !! of the highest frequency at rest: about the shortest time of a contact [s]
    type(motion_type) :: past(2)           !! the motion one and two steps ago
    real(dp) :: forces(4, 3) = 0           !! normal forces two steps ago, one step ago and now [N]
    real(dp) :: first_energy = 0           !! total energy at the start [J]
    real(dp) :: push_before(4) = 0         !! integral of each normal force until the contact first touches [N s]
    type(moment_type) :: first_peak(4)     !! of each contact
    type(hardest_rows) :: hardest
    type(pose_choice) :: judged
  contains
    procedure :: start
    procedure :: put
    procedure :: put_in_contact
    procedure :: note_step
    procedure, private :: note_turn
    procedure :: note_forces
    procedure :: note_energy
    procedure :: press
    procedure :: judge
  end type run_monitor_type

contains

  !> Record the initial motion.
  subroutine start(this, motion, writer)
    class(run_monitor_type), intent(inout) :: this
    type(motion_type), intent(in) :: motion
    class(row_writer), target, intent(inout) :: writer   !! receives the rows
    type(energy_type) :: e

    this%event_rows = this%c%rows /= 'interval'
    this%contact_rows = this%c%rows == 'contacts'
    this%half_period = 0.5_dp/maxval(this%setup%frequency)
    this%forces = spread(normal_forces(motion), 2, 3)
    this%past = motion
    call this%note_forces(motion)
    this%run%extreme = motion%q(coordinate)
    where (closed(motion%contact)) this%run%log%touched = motion%t
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
    real(dp) :: values(most_columns), stations(4)
    integer :: n

    call list_columns(this%c, this%setup, motion, this%first_energy, values, n, stations=stations)
    if (has_pressures(this%c)) call this%hardest%note(this%setup%side, motion, normal_forces(motion), stations)
    if (is_judged(this%c)) call this%judged%note(motion)
    call this%queue%put(values(:n), kind)
    this%newest = max(this%newest, motion%t)
    call this%note_energy(motion)
  end subroutine put

  !> Pass on the row of a motion if a contact has closed not long ago: rows are farther from each other the longer it lasts, so
  !> that a contact of any duration has a dozen rows or more.
  subroutine put_in_contact(this, motion)
    class(run_monitor_type), intent(inout) :: this
    type(motion_type), intent(in) :: motion
    real(dp), parameter :: first = 12     ! rows in the shortest contact
    real(dp), parameter :: later = 6      ! the time of a contact so far over that between rows, at most
    real(dp) :: apart

    if (.not. this%contact_rows) return
    apart = minval(max(this%half_period/first, (motion%t - this%closing)/later), this%closing < never)
    if (motion%t - this%newest >= apart*(1 - 1e-9_dp)) call this%put(motion, at_event)
  end subroutine put_in_contact

  !> Record a step from `old` to `new`: events, farthest displacements, impulses, forces of the last three steps, energy.
  subroutine note_step(this, old, new)
    class(run_monitor_type), intent(inout) :: this
    type(motion_type), intent(in) :: old, new
    logical :: in_first(4)                 ! contacts that have not opened before this step

    this%run%steps = this%run%steps + 1
    in_first = this%run%log%opened >= never
    where (this%run%log%touched >= never) this%push_before = old%push
    call watch(this%run%log, this%setup%wheelset, old, new, this%setup%side)
    where (in_first) this%run%first_impulse = new%push - this%push_before
    where (.not. closed(new%contact))
      this%closing = never
    elsewhere (.not. closed(old%contact))
      this%closing = old%t
    end where
    call this%note_turn(old, new)
    call note_extremes(this%run, old, new)
    where (new%impulse - old%impulse > this%run%largest_impulse) this%run%impulse_time = new%t
    this%run%largest_impulse = max(this%run%largest_impulse, new%impulse - old%impulse)
    this%past(2) = this%past(1)
    this%past(1) = old
    this%forces(:, 1) = this%forces(:, 2)
    this%forces(:, 2) = this%forces(:, 3)
    this%forces(:, 3) = normal_forces(new)
    call this%note_forces(new)
    call this%note_energy(new)
  end subroutine note_step

  !> Largest normal forces, of the whole run and of the first time in which each contact is closed.
  subroutine note_forces(this, motion)
    class(run_monitor_type), intent(inout) :: this
    type(motion_type), intent(in) :: motion
    real(dp) :: force(4)
    integer :: k

    force = normal_forces(motion)
    where (force > this%run%peak) this%run%peak_time = motion%t
    this%run%peak = max(this%run%peak, force)
    do k = 1, 4
      if (force(k) <= this%run%first_peak(k) .or. motion%t > this%run%log%opened(k)) cycle
      this%run%first_peak(k) = force(k)
      this%run%first_peak_time(k) = motion%t
      this%first_peak(k) = moment_type(force(k), motion%t, motion%q)
    end do
  end subroutine note_forces

  !> The impulse of a flange that has turned the wheelset back: where the lateral velocity vanishes in a step, on cubics through
  !> the velocities and impulses at its ends. In an impact without duration it is that after the impact.
  subroutine note_turn(this, old, new)
    class(run_monitor_type), intent(inout) :: this
    type(motion_type), intent(in) :: old, new
    real(dp) :: dt, u, force(4, 2)
    integer :: k

    do k = 1, 2
      if (this%run%turn_impulse(k) >= 0 .or. this%run%log%touched(flanges(k)) >= never .or. outwards(k)*new%v(1) > 0) cycle
      dt = new%t - old%t
      u = 1
      if (outwards(k)*old%v(1) > 0 .and. .not. any(new%contact%struck)) &
        u = turning_share(old%v(1), new%v(1), dt*old%a(1), dt*new%a(1))
      force = reshape([normal_forces(old), normal_forces(new)], [4, 2])
      associate (j => flanges(k))
        this%run%turn_impulse(k) = cubic(old%push(j), new%push(j), dt*force(j, 1), dt*force(j, 2), u) - this%push_before(j)
      end associate
    end do
  end subroutine note_turn

  !> The share u of a step at which a cubic vanishes that has values of different sign at both ends.
  pure real(dp) function turning_share(before, after, rate_before, rate_after) result(u)
    real(dp), intent(in) :: before, after            !! values at u = 0 and 1
    real(dp), intent(in) :: rate_before, rate_after  !! derivatives with respect to u there
    type(bracket_type) :: range
    real(dp) :: x
    integer :: iter

    range = bracket_type(0.0_dp, before, 1.0_dp, after)
    u = before/(before - after)
    do iter = 1, 50
      u = range%guess()
      x = cubic(before, after, rate_before, rate_after, u)
      if (abs(x) <= epsilon(x)*abs(before - after) .or. abs(range%b - range%a) <= epsilon(x)) exit
      call range%narrow(u, x)
    end do
  end function turning_share

  !> The cubic with values and derivatives as given at u = 0 and u = 1.
  pure real(dp) function cubic(before, after, rate_before, rate_after, u) result(x)
    real(dp), intent(in) :: before, after, rate_before, rate_after, u
    real(dp) :: rise

    rise = after - before
    x = before + u*(rate_before + u*(3*rise - 2*rate_before - rate_after + u*(rate_before + rate_after - 2*rise)))
  end function cubic

  !> Pressures of the run that has ended.
  subroutine press(this)
    class(run_monitor_type), intent(inout) :: this

    if (has_pressures(this%c)) call find_pressures(this%c, this%setup%side, this%hardest, &
      this%first_peak(flanges), this%run%pressure, this%run%flange)
  end subroutine press

  !> Accuracy of the contact forces of the run that has ended.
  subroutine judge(this)
    class(run_monitor_type), intent(inout) :: this

    if (is_judged(this%c)) call this%judged%measure(this%setup%wheelset, this%run%accuracy)
  end subroutine judge

  pure logical function is_judged(c)
    type(case_type), intent(in) :: c

    is_judged = c%formulation == 'elastic' .and. c%judged == 'yes'
  end function is_judged

  !> The largest drift of the energy balance.
  subroutine note_energy(this, motion)
    class(run_monitor_type), intent(inout) :: this
    type(motion_type), intent(in) :: motion
    type(energy_type) :: e
    real(dp) :: drift

    e = energies(this%c, this%setup, motion)
    this%run%loss = motion%loss
    this%run%largest_energy = max(this%run%largest_energy, sum(e%kinetic(2:4)))
    this%run%largest_work = max(this%run%largest_work, abs(motion%work))
    drift = abs(e%total - motion%work - this%first_energy + motion%loss)
    if (drift <= this%run%drift) return
    this%run%drift = drift
    this%run%drift_time = motion%t
  end subroutine note_energy

  !> Farthest displacements: at the end of a step or, where the velocity turns within it, on the cubic through both ends.
  pure subroutine note_extremes(run, old, new)
    type(run_type), intent(inout) :: run
    type(motion_type), intent(in) :: old, new
    real(dp) :: u, before, after, x
    integer :: k

    do k = 1, 6
      associate (j => coordinate(k))
        u = 1
        x = new%q(j)
        if (way(k)*old%v(j) > 0 .and. way(k)*new%v(j) < 0) then
          before = (new%t - old%t)*old%v(j)
          after = (new%t - old%t)*new%v(j)
          u = before/(before - after)
          x = cubic(old%q(j), new%q(j), before, after, u)
        end if
      end associate
      if (way(k)*(x - run%extreme(k)) <= 0) cycle
      run%extreme(k) = x
      run%extreme_time(k) = old%t + u*(new%t - old%t)
    end do
  end subroutine note_extremes

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
