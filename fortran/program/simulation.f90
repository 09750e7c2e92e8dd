!> A run from case to columns: read the profiles, place them, build or find the
!> table, settle the wheelset, integrate, note what happens.
module simulation
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use, intrinsic :: iso_fortran_env, only: int64
  use table_error, only: measure
  use path_points, only: lowest_point, point_type, small_motion
  use rigid_path, only: follow_path, path_end, path_type
  use case, only: case_type, right_table_path, text_length
  use columns, only: elastic_columns, fill_row, n_columns, n_rigid_columns
  use contact_zones, only: find_zones, side_type
  use errors, only: error_type, fatal_error
  use events, only: event_log, note_impact, watch
  use fingerprint, only: law
  use wheel_rail_pair, only: place_profiles, same_pair
  use hertz, only: contact_modulus
  use kinds, only: dp
  use eigenmodes, only: small_oscillations
  use motion_state, only: motion_type
  use newmark, only: advance, energy_change, energy_rounding, scheme_type, start_motion, step_diverged, step_ok
  use contact_table, only: table_type, outside_depth, outside_lateral, outside_law, outside_roll
  use profile_orientation, only: is_rail, is_wheel
  use profile, only: profile_type, read_profile
  use progress, only: monitor_type
  use geometry_functions, only: clearance, rigid_contact
  use rigid_motion, only: advance_rigid, rigid_end, rigid_ok, rigid_stuck, rigid_type, start_rigid
  use row_sink, only: at_event, at_impact, on_grid, row_queue, row_taker
  use service_poses, only: extent_type
  use system, only: has_memory
  use table_builder, only: build_memory, build_table
  use table_file, only: load_table, save_table
  use text, only: str
  use unilateral, only: rule_type
  use wheelset, only: find_rest, hold, settle, wheelset_type
  implicit none
  private
  public :: setup_type, run_type, prepare_geometry, prepare, set_wheelset, free_tables, simulate

  !> What is the same for every run with one table.
  type :: setup_type
    type(profile_type) :: wheel(2), rail(2)   !! left, right
    type(side_type) :: side(2)         !! left, right
    logical :: symmetric = .true.      !! both sides are the same
    type(wheelset_type) :: wheelset
    type(path_type) :: path(2)         !! of formulation 'bilateral', to the left and to the right
    real(dp) :: centred(3) = 0         !! pose of the rigid wheelset on both rails at y = 0
    real(dp) :: equilibrium(3) = 0     !! static, held at y = 0: Z and roll are measured from it [m, m, rad]
    real(dp) :: rest(3) = 0            !! static, by itself [m, m, rad]
    integer :: modes = 3               !! that the formulation leaves: 1 with rigid contacts
    real(dp) :: frequency(3) = 0       !! eigenfrequencies there, ascending [Hz]
    real(dp) :: shapes(3, 3) = 0       !! their modes y, z, roll in columns
    logical :: table_found = .false.   !! read from files, or built
    real(dp) :: table_seconds = 0      !! processor time for the tables
  end type setup_type

  !> The outcome of a run.
  type :: run_type
    integer :: rows = 0                    !! their number
    real(dp), allocatable :: last(:)       !! of them, (n_columns or n_rigid_columns)
    character(:), allocatable :: changes   !! of the initial conditions, which follow rigid constraints
    type(event_log) :: log
    real(dp) :: step = 0                   !! in force, a whole fraction of the output interval [s]
    real(dp) :: peak(4) = 0                !! largest normal force of each contact, also between steps [N]
    real(dp) :: peak_time(4) = 0           !! [s]
    real(dp) :: extreme(3) = 0             !! farthest to the left, to the right, up from equilibrium, between steps, too [m]
    real(dp) :: extreme_time(3) = 0        !! [s]
    real(dp) :: blow(4) = 0                !! largest impulse of each contact in an impact [N s]
    real(dp) :: blow_time(4) = 0           !! [s]
    real(dp) :: drift = 0                  !! largest |total energy - work + losses - initial|, over all steps [J]
    real(dp) :: kinetic_energy = 0         !! of lateral, vertical and roll motion at the start [J]
    integer(int64) :: steps = 0
    integer(int64) :: cuts = 0             !! steps that were cut
    integer(int64) :: missed = 0           !! steps that change the total energy by more than allowed, all halvings used up
    integer(int64) :: evaluations = 0      !! of the contacts, in steps
    logical :: cancelled = .false.         !! by the monitor
    logical :: gone = .false.              !! derailed, and then farther than the table goes
    real(dp) :: seconds = 0                !! processor time of the integration
  end type run_type

contains

  !> Profiles, put in their places: their zones, the clearance.
  subroutine prepare_geometry(c, setup, error)
    type(case_type), intent(in) :: c
    type(setup_type), intent(out) :: setup
    type(error_type), allocatable, intent(out) :: error
    real(dp) :: station(2)
    integer :: k
    logical :: ok

    call read_side('', '', setup%wheel(1), setup%rail(1), setup%side(1))
    if (allocated(error)) return
    if (c%wheel_profile_right == '' .and. c%rail_profile_right == '') then
      setup%wheel(2) = setup%wheel(1)
      setup%rail(2) = setup%rail(1)
      setup%side(2) = setup%side(1)
    else
      call read_side(trim(merge('_right', '      ', c%wheel_profile_right /= '')), &
        trim(merge('_right', '      ', c%rail_profile_right /= '')), setup%wheel(2), setup%rail(2), setup%side(2))
      if (allocated(error)) return
    end if
    setup%symmetric = same_pair(setup%side(1)%pair, setup%side(2)%pair)
    do k = 1, merge(1, 2, setup%symmetric)
      ! Of the right side: to the left in the mirror. (Of an array by a list of places, gfortran never frees the copy.)
      call clearance(setup%side(k:3 - k:3 - 2*k), setup%side(k)%clearance, ok)
      if (ok) cycle
      call fatal_error(error, '&track gauge = '//str(c%gauge)//' m with &wheelset back_to_back = '// &
        str(c%back_to_back)//' m: expected a flange clearance between 0 and 0.05 m, found none')
      return
    end do
    setup%centred = [0.0_dp, setup%side(1)%pair%axle_height, 0.0_dp]
    if (setup%symmetric) then
      setup%side(2)%clearance = setup%side(1)%clearance
    else
      call rigid_contact(setup%side, [1, 1], 0.0_dp, setup%centred(3), setup%centred(2), station, ok)
      if (.not. ok) call fatal_error(error, '&profiles wheel_profile_right, rail_profile_right: expected a centred '// &
        'wheelset on both rails, found none')
    end if

  contains

    !> A pair of profiles, from the variables wheel_profile and rail_profile, or those of the right side.
    subroutine read_side(of_wheel, of_rail, wheel, rail, side)
      character(*), intent(in) :: of_wheel, of_rail     !! ends of their names: '' or '_right'
      type(profile_type), intent(out) :: wheel, rail
      type(side_type), intent(out) :: side
      character(len(c%wheel_profile)) :: file

      file = c%wheel_profile
      if (of_wheel /= '') file = c%wheel_profile_right
      call read_profile(trim(file), is_wheel, c%smoothing_mm, trim(c%wheel_flip), trim(c%wheel_unit), wheel, error)
      if (failed('wheel_profile'//of_wheel)) return
      file = c%rail_profile
      if (of_rail /= '') file = c%rail_profile_right
      call read_profile(trim(file), is_rail, c%smoothing_mm, trim(c%rail_flip), trim(c%rail_unit), rail, error)
      if (failed('rail_profile'//of_rail)) return
      call place_profiles(wheel, rail, c%gauge, c%gauge_depth, c%back_to_back, c%rolling_radius, side%pair, error)
      if (.not. allocated(error)) call find_zones(side%pair, c%split_angle, side%zones, error)
      if (of_wheel//of_rail == '') return
      if (failed('wheel_profile'//of_wheel//', rail_profile'//of_rail)) return
    end subroutine read_side

    !> An error says which variables it is about.
    logical function failed(names)
      character(*), intent(in) :: names

      failed = allocated(error)
      if (failed) error%message = '&profiles '//names//': '//error%message
    end function failed

  end subroutine prepare_geometry

  !> Everything up to the start of the integration.
  subroutine prepare(c, setup, error, watcher)
    type(case_type), intent(in) :: c
    type(setup_type), intent(out) :: setup
    type(error_type), allocatable, intent(out) :: error
    class(monitor_type), intent(inout), optional :: watcher
    real(dp) :: from, to
    logical :: found(2)
    integer :: k, n

    call prepare_geometry(c, setup, error)
    if (allocated(error)) return
    if (c%formulation /= 'elastic') then
      setup%modes = 1
      call set_wheelset(c, setup, error)
      return
    end if
    call cpu_time(from)
    n = merge(1, 2, setup%symmetric)
    allocate (setup%wheelset%table)
    setup%wheelset%right_table => setup%wheelset%table
    if (n == 2) allocate (setup%wheelset%right_table)
    ! A file that is no table is found out before any is built.
    do k = 1, n
      call load_side(k, error)
      if (allocated(error)) return
    end do
    do k = 1, n
      if (present(watcher)) watcher%from = (k - 1.0_dp)/n
      if (present(watcher)) watcher%to = real(k, dp)/n
      if (.not. found(k)) call build_side(k, error)
      if (allocated(error)) return
    end do
    setup%table_found = all(found(:n))
    call cpu_time(to)
    setup%table_seconds = to - from

    call set_wheelset(c, setup, error)

  contains

    function table_of(k) result(table)
      integer, intent(in) :: k             !! 1 left, 2 right
      type(table_type), pointer :: table

      table => setup%wheelset%table
      if (k == 2) table => setup%wheelset%right_table
    end function table_of

    function file_of(k) result(file)
      integer, intent(in) :: k
      character(text_length + 6) :: file

      file = c%table_file
      if (k == 2) file = right_table_path(c)
    end function file_of

    subroutine load_side(k, error)
      integer, intent(in) :: k
      type(error_type), allocatable, intent(out) :: error
      type(table_type), pointer :: table
      character(:), allocatable :: key

      table => table_of(k)
      found(k) = .false.
      call table_key(c, setup%wheel(k), setup%rail(k), key)
      if (file_of(k) /= '') call load_table(trim(file_of(k)), key, table, found(k), error)
    end subroutine load_side

    subroutine build_side(k, error)
      integer, intent(in) :: k
      type(error_type), allocatable, intent(out) :: error
      type(table_type), pointer :: table
      type(extent_type) :: extent
      type(side_type) :: both(2)
      character(:), allocatable :: key
      real(dp) :: e_star, own
      logical :: ok

      if (.not. has_memory(build_memory(c%accuracy))) then
        call fatal_error(error, '&table accuracy = '//str(c%accuracy)//': expected memory to build the table, '// &
          str(build_memory(c%accuracy)/10**6)//' MB, found less')
        return
      end if
      table => table_of(k)
      ! Whatever is on the other side, a pair has one table: that of a wheelset which has it on both.
      both(1) = setup%side(k)
      both(2) = setup%side(k)
      call clearance(both, own, ok)
      extent = extent_type(c%lateral, c%lift, c%drop, c%roll_range, c%depth)
      if (ok) extent%clearance = own
      e_star = c%stiffness_scale*contact_modulus(c%youngs_modulus, c%poisson)
      call table_key(c, setup%wheel(k), setup%rail(k), key)
      associate (side => setup%side(k))
        call build_table(side%pair, side%zones, trim(c%model), e_star, extent, c%accuracy, &
          [c%n_lateral, c%n_roll, c%n_depth], key, table, watcher)
      end associate
      if (present(watcher)) then
        if (watcher%stop) then
          call fatal_error(error, 'stopped by the user')
          return
        end if
      end if
      call measure(setup%side(k)%pair, setup%side(k)%zones, trim(c%model), e_star, extent, table)
      if (file_of(k) /= '') call save_table(trim(file_of(k)), table, error)
    end subroutine build_side

  end subroutine prepare

  !> Free the tables that `prepare` made.
  subroutine free_tables(setup)
    type(setup_type), intent(inout) :: setup

    associate (w => setup%wheelset)
      if (associated(w%right_table) .and. .not. associated(w%right_table, w%table)) deallocate (w%right_table)
      if (associated(w%table)) deallocate (w%table)
      nullify (w%right_table)
    end associate
  end subroutine free_tables

  !> Inertia and loads of the case on a table that is there, or on rigid contacts: equilibrium and
  !> eigenfrequencies.
  subroutine set_wheelset(c, setup, error)
    type(case_type), intent(in) :: c
    type(setup_type), intent(inout) :: setup
    type(error_type), allocatable, intent(out) :: error
    real(dp) :: force
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
    call settle(setup%wheelset, setup%centred(2), setup%centred(3), setup%equilibrium(2), ok)
    if (.not. setup%symmetric .and. ok) call hold(setup%wheelset, setup%equilibrium, force, ok)
    if (.not. ok) then
      call fatal_error(error, '&wheelset vertical_load = '//str(c%vertical_load)// &
        ' N: expected an equilibrium within &table depth = '//str(c%depth)//' m, found none')
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

  !> Rigid contacts: the path on both rails, at whose lowest point the wheelset is in equilibrium, and oscillates
  !> along it.
  subroutine set_rigid(c, setup, error)
    type(case_type), intent(in) :: c
    type(setup_type), intent(inout) :: setup
    type(error_type), allocatable, intent(out) :: error
    real(dp), parameter :: mirror(3) = [-1, 1, -1]
    type(point_type) :: lowest
    logical :: ok

    call follow_path(setup%side, setup%centred, setup%wheelset%inertia(), c%lateral, setup%path(1))
    if (setup%symmetric) then
      setup%path(2) = setup%path(1)
    else
      call follow_path(setup%side(2:1:-1), mirror*setup%centred, setup%wheelset%inertia(), c%lateral, setup%path(2))
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

  !> Everything that the table of a side depends on, in words: the law is the checksum of its sources.
  subroutine table_key(c, wheel, rail, key)
    type(case_type), intent(in) :: c
    type(profile_type), intent(in) :: wheel, rail
    character(:), allocatable, intent(out) :: key

    key = 'ldbench '//law//' model '//trim(c%model)//' profiles '//wheel%checksum//' '// &
      rail%checksum//' '//trim(c%wheel_flip)//' '//trim(c%wheel_unit)//' '//trim(c%rail_flip)//' '// &
      trim(c%rail_unit)//' smoothing '//str(c%smoothing_mm)//' gauge '//str(c%gauge)//' '// &
      str(c%gauge_depth)//' back_to_back '//str(c%back_to_back)//' radius '//str(c%rolling_radius)// &
      ' E '//str(c%youngs_modulus)//' nu '//str(c%poisson)//' scale '//str(c%stiffness_scale)// &
      ' split '//str(c%split_angle)//' extent '//str(c%lateral)//' '//str(c%lift)//' '//str(c%drop)//' '// &
      str(c%roll_range)//' '//str(c%depth)//' accuracy '//str(c%accuracy)//' points '//str(c%n_lateral)//' '//str(c%n_roll)//' '// &
      str(c%n_depth)
  end subroutine table_key

  !> Integrate from the initial conditions to the stop condition.
  subroutine simulate(c, setup, taker, run, error, watcher)
    type(case_type), intent(in) :: c
    type(setup_type), intent(in) :: setup
    class(row_taker), intent(inout) :: taker   !! of the rows
    type(run_type), intent(out) :: run
    type(error_type), allocatable, intent(out) :: error
    class(monitor_type), intent(inout), optional :: watcher
    type(scheme_type) :: scheme
    type(motion_type) :: motion
    type(rigid_type) :: rigid, rigid_before  ! now, and at the start of the step
    type(motion_type) :: past(2)           ! the motion one and two steps ago
    type(row_queue) :: queue
    real(dp) :: first_row(n_rigid_columns), first_energy, from, to
    real(dp) :: at, h                      ! time of the next row and the steps up to it [s]
    real(dp) :: seen(4, 3)                 ! normal forces two steps ago, one step ago and now [N]
    integer, parameter :: report_steps = 10000, most_halvings = 6
    integer :: substeps                    ! steps between rows
    integer :: last_row, report_rows, row, i, status, width
    logical :: elastic, event_rows, until_return, until_derailment

    call cpu_time(from)
    scheme = scheme_type(c%scheme(:16), c%order, c%beta, c%gamma, c%tolerance, c%max_iterations)
    substeps = ceiling(c%interval/c%dt*(1 - 1e-9_dp))
    run%step = c%interval/substeps
    report_rows = max(1, min(100, report_steps/substeps))
    last_row = ceiling(c%t_end/c%interval*(1 - 1e-9_dp))
    elastic = c%formulation == 'elastic'
    event_rows = c%rows == 'interval_and_events'
    until_return = c%stop_at == 'return_to_centre'
    until_derailment = c%stop_at == 'derailment'
    width = merge(n_columns, n_rigid_columns, elastic)

    run%changes = ''
    if (elastic) then
      motion%q = setup%equilibrium + [c%y, c%z, c%roll]
      motion%v = [c%vy, c%vz, c%roll_rate]
      call start_motion(setup%wheelset, motion, status)
      if (status /= step_ok) call report_failure()
    else
      call start_rigid(c%formulation == 'bilateral', rule_type(c%restitution, c%energy_tolerance, c%max_halvings), &
        [c%y, c%z, c%roll], [c%vy, c%vz, c%roll_rate], setup%wheelset, setup%side, setup%path, &
        setup%equilibrium, rigid, motion, run%changes, error)
    end if
    if (allocated(error)) return
    seen = spread(normal_forces(motion), 2, 3)
    past = motion
    run%peak = seen(:, 3)
    run%extreme = motion%q([1, 1, 2])
    run%kinetic_energy = 0.5_dp*sum(setup%wheelset%inertia()*motion%v**2)
    call queue%begin(width, 1e-6_dp*c%interval)
    first_energy = 0
    call fill(motion, first_row(:width))
    first_energy = first_row(n_columns)
    call put(motion, on_grid)
    do row = 1, last_row
      at = row*c%interval
      h = run%step
      if (at - c%t_end > 1e-9_dp*c%interval) then
        at = c%t_end
        h = (at - (row - 1)*c%interval)/substeps
      end if
      do i = 1, substeps
        motion%t = (row - 1)*c%interval + (i - 1)*h
        if (elastic) then
          call step(h, 0)
        else
          call rigid_step(h)
        end if
        if (allocated(error)) exit
        if (mod(i, report_steps) == 0) call look_up((row - 1 + real(i, dp)/substeps)/last_row)
        if (run%cancelled) exit
      end do
      if (run%cancelled) exit
      if (allocated(error)) then
        ! A wheelset that has derailed leaves the table, or the rails on which both wheels are held.
        if (.not. run%log%derailed) return
        deallocate (error)
        run%gone = .true.
      end if
      if (run%gone) exit
      motion%t = at
      call put(motion, on_grid)
      if (mod(row, report_rows) == 0) call look_up(row/real(last_row, dp))
      if ((until_derailment .and. run%log%derailed) .or. (until_return .and. run%log%returned) .or. run%cancelled) exit
    end do
    call queue%give(huge(at), taker, error)
    if (allocated(error)) return
    run%rows = queue%given
    run%last = queue%last
    run%extreme(3) = run%extreme(3) - setup%equilibrium(2)
    call cpu_time(to)
    run%seconds = to - from

  contains

    !> Tell how far the run is, and whether it shall stop.
    subroutine look_up(share)
      real(dp), intent(in) :: share

      if (.not. present(watcher)) return
      call watcher%report('integration', share)
      run%cancelled = watcher%stop
    end subroutine look_up

    !> One step; where it fails or the total energy changes by more than the tolerance it is
    !> cut into two, four, ... and they are tried instead.  What decides is the same for the
    !> reversed step: the integration stays reversible.
    recursive subroutine step(dt, halvings)
      real(dp), intent(in) :: dt
      integer, intent(in) :: halvings
      type(motion_type) :: new, there
      integer :: evaluations, more, i
      real(dp) :: change, allowed

      call advance(setup%wheelset, scheme, motion, dt, new, evaluations, status)
      run%evaluations = run%evaluations + evaluations
      more = 0
      if (status /= step_ok) then
        more = 1
        if (halvings == c%max_halvings) then
          call report_failure()
          return
        end if
      else if (c%energy_tolerance > 0) then
        change = energy_change(setup%wheelset, motion, new)
        if (abs(change) > c%energy_tolerance) then
          allowed = max(c%energy_tolerance, energy_rounding(setup%wheelset, motion), energy_rounding(setup%wheelset, new))
          more = min(halvings_for(change, allowed), c%max_halvings - halvings)
          if (more == 0 .and. abs(change) > allowed) run%missed = run%missed + 1
        end if
      end if
      if (more > 0) then
        run%cuts = run%cuts + 1
        do i = 1, 2**more
          call step(dt/2**more, halvings + more)
          if (allocated(error)) return
        end do
        return
      end if
      run%steps = run%steps + 1
      call watch(run%log, setup%wheelset, motion, new, setup%side)
      if (event_rows) then
        do i = 1, run%log%n_moments
          call side_step(motion, run%log%moments(i), there)
          if (status == step_ok) call put(there, at_event)
        end do
      end if
      call note_extremes(motion, new)
      past = [motion, past(1)]
      motion = new
      call note_peaks()
      call note_drift(motion)
      call queue%give(past(1)%t, taker, error)
    end subroutine step

    !> The motion at a time t near a step's end `old`: a step of its own, which the run does not go on from, in as many
    !> parts as its energy needs.
    subroutine side_step(old, t, there)
      type(motion_type), intent(in) :: old
      real(dp), intent(in) :: t            !! [s]
      type(motion_type), intent(out) :: there
      type(motion_type) :: from
      integer :: evaluations, halvings, i

      do halvings = 0, most_halvings
        there = old
        do i = 1, 2**halvings
          from = there
          call advance(setup%wheelset, scheme, from, (t - old%t)/2**halvings, there, evaluations, status)
          run%evaluations = run%evaluations + evaluations
          if (status /= step_ok) exit
        end do
        if (status /= step_ok) cycle
        if (c%energy_tolerance <= 0 .or. abs(energy_change(setup%wheelset, old, there)) <= c%energy_tolerance) exit
      end do
    end subroutine side_step

    subroutine put(at, kind)
      type(motion_type), intent(in) :: at
      integer, intent(in) :: kind          !! of `row_sink`
      real(dp) :: values(n_rigid_columns)

      call fill(at, values(:width))
      call queue%put(values(:width), kind)
      call note_drift(at)
    end subroutine put

    !> A step of rigid contacts, in pieces from event to event; energy decides as above about each.
    subroutine rigid_step(dt)
      real(dp), intent(in) :: dt
      type(motion_type) :: old
      real(dp) :: h, left
      integer :: evaluations, k

      left = dt
      do while (left > 1e-12_dp*dt)
        old = motion
        if (event_rows) rigid_before = rigid
        h = left
        call advance_rigid(setup%side, setup%path, rigid, motion, h, evaluations, status)
        run%evaluations = run%evaluations + evaluations
        run%steps = run%steps + 1
        left = left - h
        call watch(run%log, setup%wheelset, old, motion, setup%side)
        call note_extremes(old, motion)
        call note_impact(run%log, setup%wheelset, old, motion)
        if (c%energy_tolerance > 0 .and. abs(energy_change(setup%wheelset, old, motion) + motion%loss - old%loss) > &
          max(c%energy_tolerance, energy_rounding(setup%wheelset, old))) run%missed = run%missed + 1
        do k = 1, 4
          if (motion%impulse(k) - old%impulse(k) <= run%blow(k)) cycle
          run%blow(k) = motion%impulse(k) - old%impulse(k)
          run%blow_time(k) = motion%t
        end do
        past = [old, past(1)]
        call note_peaks()
        if (any(motion%contact%struck)) call note_largest(rigid%before)
        call note_drift(motion)
        if (event_rows) then
          if (any(motion%contact%struck)) then
            call put(rigid%before, at_impact)
            call put(motion, at_impact)
          end if
          do k = 1, run%log%n_moments
            call rigid_row(run%log%moments(k))
          end do
        end if
        ! The peak of a force is known one step later: rows up to then wait.
        call queue%give(past(1)%t, taker, error)
        if (allocated(error)) return
        if (status /= rigid_ok) then
          call report_rigid_failure()
          return
        end if
      end do
      run%gone = run%log%derailed .and. beyond_table(motion%q)
    end subroutine rigid_step

    !> A row at a time t within the last step, or at its end.
    subroutine rigid_row(t)
      real(dp), intent(in) :: t            !! [s]
      type(motion_type) :: there
      real(dp) :: h
      integer :: evaluations, ignored

      there = motion
      if (t < motion%t) then
        there = past(1)
        do while (t - there%t > epsilon(t)*t)
          h = t - there%t
          call advance_rigid(setup%side, setup%path, rigid_before, there, h, evaluations, ignored)
          run%evaluations = run%evaluations + evaluations
        end do
      end if
      call put(there, at_event)
    end subroutine rigid_row

    !> Whether a pose is outside what a contact table would cover: there the run of a derailed rigid wheelset ends.
    pure logical function beyond_table(q)
      real(dp), intent(in) :: q(3)

      beyond_table = abs(q(1) + setup%equilibrium(2)*sin(q(3))) > c%lateral .or. abs(q(3)) > c%roll_range &
        .or. q(2) < setup%equilibrium(2) - c%drop
    end function beyond_table

    subroutine note_drift(at)
      type(motion_type), intent(in) :: at
      real(dp) :: kinetic, potential

      kinetic = 0.5_dp*sum(setup%wheelset%inertia()*at%v**2)
      potential = (sum(at%contact%energy(:2)) + sum(at%contact%energy(3:))) &
        + setup%wheelset%weight()*(at%q(2) - setup%equilibrium(2))
      run%drift = max(run%drift, abs(kinetic + potential - at%work + at%loss - (first_energy - constant())))
    end subroutine note_drift

    !> Halvings of the step after which the energy's change, which goes with dt^(order + 1), is
    !> within the tolerance.
    integer function halvings_for(change, tolerance) result(halvings)
      real(dp), intent(in) :: change, tolerance

      halvings = 0
      if (abs(change) > tolerance) halvings = max(1, (exponent(change/tolerance) + c%order)/(c%order + 1))
    end function halvings_for

    !> Kinetic energy of the motions at constant speed [J].
    real(dp) function constant()
      constant = 0.5_dp*(c%mass*c%vx**2 + c%pitch_inertia*c%pitch_rate**2)
    end function constant

    !> Peaks of the normal forces, which are known one step after they have passed. Between steps an elastic force is on
    !> the parabola through three of them, which tells when it is largest.
    subroutine note_peaks()
      type(motion_type) :: there
      real(dp) :: rise, fall, bend, t, force(4)
      integer :: k

      seen = cshift(seen, 1, 2)
      seen(:, 3) = normal_forces(motion)
      call note_largest(motion)
      do k = 1, 4
        if (seen(k, 2) <= seen(k, 1) .or. seen(k, 2) < seen(k, 3)) cycle
        there = past(1)
        if (elastic) then
          rise = (seen(k, 2) - seen(k, 1))/(past(1)%t - past(2)%t)
          fall = (seen(k, 3) - seen(k, 2))/(motion%t - past(1)%t)
          bend = (fall - rise)/(motion%t - past(2)%t)
          if (bend >= 0) cycle
          t = past(1)%t - (rise + bend*(past(1)%t - past(2)%t))/(2*bend)
          call side_step(past(merge(2, 1, t < past(1)%t)), t, there)
          if (status /= step_ok) cycle
          force = normal_forces(there)
          if (force(k) < seen(k, 2)) there = past(1)
        end if
        call note_largest(there)
        if (event_rows) call put(there, at_event)
      end do
    end subroutine note_peaks

    subroutine note_largest(at)
      type(motion_type), intent(in) :: at
      real(dp) :: force(4)

      force = normal_forces(at)
      where (force > run%peak) run%peak_time = at%t
      run%peak = max(run%peak, force)
    end subroutine note_largest

    !> Normal forces of the four contacts [N].
    pure function normal_forces(at) result(force)
      type(motion_type), intent(in) :: at
      real(dp) :: force(4)

      force = hypot(at%contact%slope(1, :), at%contact%slope(2, :))
    end function normal_forces

    !> Farthest displacements: at the end of a step or, where the velocity turns within it, on the cubic through both ends.
    subroutine note_extremes(old, new)
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

    subroutine fill(at, to)
      type(motion_type), intent(in) :: at
      real(dp), intent(out) :: to(:)

      call fill_row(setup%wheelset, setup%side, at, c%vx, c%pitch, c%pitch_rate, setup%equilibrium, first_energy, to)
    end subroutine fill

    subroutine report_rigid_failure()
      character(:), allocatable :: reason

      select case (status)
      case (rigid_end)
        reason = 'formulation = ''bilateral'': expected a path on which both wheels stay on their rails, found its end at '// &
          trim(path_end(setup%path, motion%q(1) >= 0, setup%equilibrium))//', reached'
      case (rigid_stuck)
        reason = 'formulation = ''unilateral'': expected at most three contacts to close at once, found more or none that can,'
      case default
        reason = 'formulation = ''unilateral'': expected time between impacts, found none'
      end select
      call fatal_error(error, reason//place())
    end subroutine report_rigid_failure

    function place()
      character(160) :: place

      place = ' at t = '//str(motion%t)//' s, Y = '//str(motion%q(1))//' m, Z = '// &
        str(motion%q(2) - setup%equilibrium(2))//' m, roll = '//str(motion%q(3) - setup%equilibrium(3))//' rad'
    end function place

    subroutine report_failure()
      character(:), allocatable :: reason

      select case (status)
      case (outside_lateral)
        reason = '&table lateral = '//str(c%lateral)//' m: expected the wheels within it, found them outside'
      case (outside_roll)
        reason = '&table roll = '//str(c%roll_range)//' rad: expected the wheelset within it, found it outside'
      case (outside_depth)
        reason = '&table depth = '//str(c%depth)//' m: expected penetrations within it, found a deeper one'
      case (outside_law)
        reason = '&table: expected poses that the table was made for, found one in which the contact would pull'
      case (step_diverged)
        reason = '&integrator dt = '//str(run%step)//' s: expected Newton to converge within '// &
          str(c%max_iterations)//' iterations and '//str(c%max_halvings)//' halvings, found it does not'
      case default
        reason = 'the step failed'
      end select
      call fatal_error(error, reason//place())
    end subroutine report_failure

  end subroutine simulate

end module simulation