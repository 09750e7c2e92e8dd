!> What a run says about itself: the header of its files and the summary for the
!> terminal.
module report
  use case, only: case_type, list_variables, output_path, value_text, variable_type
  use columns, only: column_file, column_names, column_units, n_columns, n_rigid_columns
  use errors, only: error_type, fatal_error
  use events, only: elastic_kinds, event_kinds, kept, kept_impacts
  use kinds, only: dp, version
  use contact_table, only: table_type
  use profile, only: profile_type
  use geometry_functions, only: geometry_names, geometry_pitch, geometry_table, geometry_units
  use simulation, only: run_type, setup_type
  use system, only: default_folder, lacks_folder, scratch_file
  use text, only: str, with_zero
  use wheelset, only: contact_name
  implicit none
  private
  public :: summary, begin_columns, finish_files, write_geometry, check_writable

  character, parameter :: nl = new_line('a')

contains

  !> Find out before the work, not after it, that a file cannot be written.
  subroutine check_writable(file, variable, path, error)
    character(*), intent(in) :: file, variable   !! for the message
    character(*), intent(in) :: path
    type(error_type), allocatable, intent(out) :: error
    character(:), allocatable :: first         ! that is written
    type(scratch_file) :: probe

    if (path == '') return
    first = path
    if (lacks_folder(path)) first = default_folder
    call probe%begin(first)
    call probe%abandon()
    if (.not. probe%ok) call fatal_error(error, file//', '//variable// &
      ': expected a path that can be written, found '//path)
  end subroutine check_writable

  !> Lines about the case before the run: geometry, equilibrium, every variable in force.
  subroutine header(c, setup, lines)
    type(case_type), target, intent(in) :: c
    type(setup_type), intent(in) :: setup
    character(:), allocatable, intent(out) :: lines
    type(case_type), target :: copy
    type(variable_type), allocatable :: list(:)
    character(:), allocatable :: group
    integer :: k

    lines = 'ldbench '//version//nl//'case '//trim(c%name)//': '//trim(c%title)//nl// &
      'frame: X forward, Y left, Z up; Z and roll from static equilibrium at Y = 0; SI units, radians'//nl// &
      'contacts: LT left tread, LF left flange, RT right tread, RF right flange; '// &
      'forces of the rail on the wheel, track frame'//nl
    call add_profiles(lines, 'wheel', setup%wheel)
    call add_profiles(lines, 'rail', setup%rail)
    call add_clearances(lines, setup)
    lines = lines//'axle height at equilibrium [m]: '//str(setup%equilibrium(2))//nl
    if (.not. setup%symmetric) lines = lines//'roll at equilibrium [rad]: '//str(setup%equilibrium(3))//nl
    call add_rest(lines, setup)
    call add_frequencies(lines, setup)
    call add_formulation(lines, c)
    call add_tables(lines, c, setup)
    copy = c
    call list_variables(copy, list)
    group = ''
    do k = 1, size(list)
      if (list(k)%group /= group) lines = lines//'&'//list(k)%group//nl
      group = list(k)%group
      lines = lines//'  '//list(k)%name//' = '//trim(value_text(list(k)))
      if (list(k)%unit /= '' .and. list(k)%unit /= '1') lines = lines//'  ! '//list(k)%unit
      lines = lines//nl
    end do
  end subroutine header

  !> What a rigid formulation means for the case.
  subroutine add_formulation(lines, c)
    character(:), allocatable, intent(inout) :: lines
    type(case_type), intent(in) :: c

    select case (c%formulation)
    case ('bilateral')
      lines = lines//'formulation bilateral: rigid contacts, both wheels are held on their rails; a negative N is a rail that '// &
        'pulls; P: impulses where contact jumps along the wheel'//nl
    case ('unilateral')
      lines = lines//'formulation unilateral: rigid contacts that only push, restitution '//str(c%restitution)// &
        '; N: of contact that lasts, P: impulses of impacts so far'//nl
    case default
      return
    end select
    lines = lines//'not used with it: &material, &table but lateral, roll and drop (where a derailed run ends), &contact '// &
      'model, &integrator scheme, order, beta, gamma, tolerance, max_iterations'//nl
  end subroutine add_formulation

  !> Eigenfrequencies at equilibrium, named by what moves most (in kinetic energy).
  subroutine add_frequencies(lines, setup)
    character(:), allocatable, intent(inout) :: lines
    type(setup_type), intent(in) :: setup
    character(8), parameter :: motion(3) = [character(8) :: 'lateral', 'vertical', 'roll']
    integer :: k

    lines = lines//'eigenfrequencies at equilibrium [Hz]:'
    do k = 1, setup%modes
      lines = lines//' '//trim(motion(maxloc(setup%wheelset%inertia()*setup%shapes(:, k)**2, 1)))//' '// &
        fixed(setup%frequency(k), 4)
      if (k < setup%modes) lines = lines//','
    end do
    lines = lines//nl
  end subroutine add_frequencies

  !> How exact the contact tables are, and a warning where that is not what was asked for.
  subroutine add_tables(lines, c, setup)
    character(:), allocatable, intent(inout) :: lines
    type(case_type), intent(in) :: c
    type(setup_type), intent(in) :: setup

    if (c%formulation /= 'elastic') return
    if (setup%symmetric) then
      call add_table(lines, c, 'contact table', setup%wheelset%table)
    else
      call add_table(lines, c, 'left contact table', setup%wheelset%table)
      call add_table(lines, c, 'right contact table', setup%wheelset%right_table)
    end if
  end subroutine add_tables

  subroutine add_table(lines, c, what, table)
    character(:), allocatable, intent(inout) :: lines
    type(case_type), intent(in) :: c
    character(*), intent(in) :: what
    type(table_type), intent(in) :: table
    character(10), parameter :: place(4) = [character(10) :: 'tread', 'flange', 'both', 'going over']
    integer :: k, z

    lines = lines//what//': model '//trim(c%model)//', '
    do z = 1, size(table%zones)
      associate (t => table%zones(z))
        lines = lines//str(t%u%n)//' x '//str(t%roll%n)//' x '//str(t%q%n)
        if (z < size(table%zones)) lines = lines//' + '
      end associate
    end do
    lines = lines//' points'//nl
    if (table%solutions(2) > 0) lines = lines//'warning: '//what//': '//str(table%solutions(2))//' of '// &
      str(table%solutions(1))//' half-space solutions did not converge; see whether the error is larger than '// &
      '&table accuracy'//nl
    if (table%accuracy%unsolved > 0) lines = lines//'warning: '//what//': '//str(table%accuracy%unsolved)//' of '// &
      str(sum(table%accuracy%poses) + table%accuracy%unsolved)//' half-space solutions that its error is measured by '// &
      'did not converge; they are not in it'//nl
    if (table%accuracy%pulling > 0) lines = lines//'warning: '//what//': expected contacts that push in '// &
      'service, found '//str(table%accuracy%pulling)//' points at which the contact would pull, where a run stops; lower '// &
      '&table accuracy or raise n_lateral, n_roll, n_depth'//nl
    if (all(table%accuracy%poses == 0)) return
    lines = lines//'its error, rms (largest), of max(|F|, 5 kN):'
    do k = 1, 4
      if (table%accuracy%poses(k) == 0) cycle
      lines = lines//' '//trim(place(k))//' '//scientific(table%accuracy%rms(k))//' ('// &
        scientific(table%accuracy%largest(k))//'),'
    end do
    lines = lines(:len(lines) - 1)//nl
    if (any(table%accuracy%rms(:3) > c%accuracy)) lines = lines//'warning: '//what//': expected an rms error of at most '// &
      '&table accuracy = '//str(c%accuracy)//' in service, reached '//scientific(maxval(table%accuracy%rms(:3)))//nl
  end subroutine add_table

  !> Clearance, to either side where they differ.
  subroutine add_clearances(lines, setup)
    character(:), allocatable, intent(inout) :: lines
    type(setup_type), intent(in) :: setup

    if (setup%symmetric) then
      lines = lines//'rigid-axle clearance [mm]: 2 x '//fixed(1e3_dp*setup%side(1)%clearance, 3)//nl
    else
      lines = lines//'rigid-axle clearance [mm]: left '//fixed(1e3_dp*setup%side(1)%clearance, 3)//', right '// &
        fixed(1e3_dp*setup%side(2)%clearance, 3)//nl
    end if
  end subroutine add_clearances

  !> Where a wheelset of two different sides stays by itself, as the columns tell it.
  subroutine add_rest(lines, setup)
    character(:), allocatable, intent(inout) :: lines
    type(setup_type), intent(in) :: setup

    if (setup%symmetric) return
    associate (q => setup%rest - setup%equilibrium)
      lines = lines//'at rest off the centre: Y = '//str(q(1))//' m, Z = '//str(q(2))//' m, roll = '//str(q(3))//' rad'//nl
    end associate
  end subroutine add_rest

  !> Of the profile of both sides, or of either.
  subroutine add_profiles(lines, what, p)
    character(:), allocatable, intent(inout) :: lines
    character(*), intent(in) :: what
    type(profile_type), intent(in) :: p(2)

    if (p(1)%file == p(2)%file) then
      call add_profile(lines, what, p(1))
    else
      call add_profile(lines, 'left '//what, p(1))
      call add_profile(lines, 'right '//what, p(2))
    end if
  end subroutine add_profiles

  subroutine add_profile(lines, what, p)
    character(:), allocatable, intent(inout) :: lines
    character(*), intent(in) :: what
    type(profile_type), intent(in) :: p

    lines = lines//what//' profile: '//p%file//', CRC-32 '//p%checksum
    if (p%reconstruction) lines = lines//', RECONSTRUCTION (not the organisers'' file)'
    if (p%taken /= '') lines = lines//', '//p%taken
    if (p%mended /= '') lines = lines//'; '//p%mended
    lines = lines//nl
  end subroutine add_profile

  !> Lines about the outcome, with so many impacts.
  subroutine outcome(c, run, impacts, lines)
    type(case_type), intent(in) :: c
    type(run_type), intent(in) :: run
    integer, intent(in) :: impacts
    character(:), allocatable, intent(out) :: lines
    character(5), parameter :: way(3) = [character(5) :: 'left', 'right', 'up']
    integer :: k, kinds, struck

    struck = 0
    lines = ''
    if (run%changes /= '') lines = 'initial conditions follow the constraints: '//run%changes//nl
    lines = lines//'events:'//nl
    do k = 1, run%log%n
      associate (event => run%log%list(k))
        if (event_kinds(event%kind) == 'impact') struck = struck + 1
        if (event_kinds(event%kind) == 'impact' .and. struck > impacts) cycle
        lines = lines//'  t = '//fixed(event%t, 6)//' s  '//trim(event_kinds(event%kind))
        if (abs(c%lateral_ramp) > 0 .or. abs(c%lateral_force) > 0) &
          lines = lines//', lateral force '//fixed(1e-3_dp*event%force, 3)//' kN'
        if (any(abs(event%impulse) > 0)) lines = lines//trim(impact(event%impulse, event%loss))
        lines = lines//nl
      end associate
    end do
    if (sum(run%log%counts) > run%log%n - max(0, struck - impacts)) then
      lines = lines//'  (listed: the first '//str(kept)//' of each kind'
      if (struck > 0) lines = lines//', '//str(impacts)//' impacts'
      lines = lines//')'//nl
    end if
    lines = lines//'  in all:'
    kinds = merge(elastic_kinds, size(event_kinds), c%formulation == 'elastic')
    do k = 1, kinds
      lines = lines//' '//str(run%log%counts(k))//' '//trim(event_kinds(k))
      if (k < kinds) lines = lines//','
    end do
    lines = lines//nl//'farthest [mm]:'
    do k = 1, 3
      lines = lines//' '//trim(way(k))//' '//fixed(1e3_dp*run%extreme(k), 6)//' at '//fixed(run%extreme_time(k), 6)//' s'
      if (k < 3) lines = lines//','
    end do
    lines = lines//nl//'peak normal forces [kN]:'
    do k = 1, 4
      lines = lines//' '//contact_name(k)//' '//fixed(1e-3_dp*run%peak(k), 3)
      if (run%peak(k) > 0) lines = lines//' at '//fixed(run%peak_time(k), 6)//' s'
      if (k < 4) lines = lines//','
    end do
    if (c%formulation /= 'elastic') then
      lines = lines//nl//'largest impulses [N s]:'
      do k = 1, 4
        lines = lines//' '//contact_name(k)//' '//fixed(run%blow(k), 3)
        if (run%blow(k) > 0) lines = lines//' at '//fixed(run%blow_time(k), 6)//' s'
        if (k < 4) lines = lines//','
      end do
      lines = lines//nl//'energy lost in impacts [J]: '//fixed(run%last(size(run%last)), 6)
    end if
    lines = lines//nl//'energy drift, largest [J]: '//scientific(run%drift)
    if (run%kinetic_energy > 0) lines = lines//', of initial kinetic energy '// &
      scientific(run%drift/run%kinetic_energy)
    lines = lines//nl//'steps: '//str(run%steps)//' of at most '//str(run%step)//' s, '//str(run%cuts)//' cut'
    if (run%missed > 0) lines = lines//', '//str(run%missed)//' over energy_tolerance after '//str(c%max_halvings)//' halvings'
    lines = lines//'; contact evaluations: '//str(run%evaluations)//nl
    lines = lines//'ended at t = '//fixed(run%last(1), 6)//' s: '//trim(reason(c, run))//nl
  end subroutine outcome

  !> Impulses and loss of an impact.
  function impact(impulse, loss) result(words)
    real(dp), intent(in) :: impulse(4), loss
    character(240) :: words
    integer :: k

    words = ', impulses [N s]'
    do k = 1, 4
      if (abs(impulse(k)) > 0) words = trim(words)//' '//contact_name(k)//' '//fixed(impulse(k), 3)
    end do
    words = trim(words)//', energy lost [J] '//fixed(loss, 6)
  end function impact

  function reason(c, run) result(words)
    type(case_type), intent(in) :: c
    type(run_type), intent(in) :: run
    character(64) :: words

    if (run%cancelled) then
      words = 'stopped by the user'
    else if (run%log%derailed .and. c%stop_at == 'derailment') then
      words = 'derailment'
    else if (run%gone) then
      words = 'derailed, and then left what the contact table covers'
    else if (c%stop_at == 'return_to_centre' .and. run%log%returned) then
      words = 'return to the centre after both flanges'
    else
      words = 't_end'
      if (c%stop_at /= 't_end') words = 't_end, '//trim(c%stop_at)//' not reached'
    end if
  end function reason

  !> The text for the terminal.
  subroutine summary(c, setup, run, lines)
    type(case_type), intent(in) :: c
    type(setup_type), intent(in) :: setup
    type(run_type), intent(in) :: run
    character(:), allocatable, intent(out) :: lines
    character(:), allocatable :: events

    lines = trim(c%name)//': '//trim(c%title)//nl
    call add_formulation(lines, c)
    if (remarkable(setup%wheel)) call add_profiles(lines, 'wheel', setup%wheel)
    if (remarkable(setup%rail)) call add_profiles(lines, 'rail', setup%rail)
    call add_clearances(lines, setup)
    lines = lines//'equilibrium: axle '//fixed(setup%equilibrium(2), 6)// &
      ' m above the rails, approach '//fixed(1e3_dp*(setup%centred(2) - setup%equilibrium(2)), 4)//' mm, '// &
      fixed(0.5e-3_dp*setup%wheelset%weight(), 3)//' kN per wheel'//trim(merge('           ', ' on average', setup%symmetric))//nl
    call add_rest(lines, setup)
    call add_frequencies(lines, setup)
    call add_tables(lines, c, setup)
    call outcome(c, run, 5, events)
    lines = lines//events//'processor time [s]: table '//fixed(setup%table_seconds, 2)// &
      merge(' (found)', ' (built)', setup%table_found)//', integration '//fixed(run%seconds, 2)//nl// &
      'columns: '//trim(output_path(c))//', '//str(run%rows)//' rows'//nl
  end subroutine summary

  !> Whether something is to be said of a profile.
  pure logical function remarkable(p)
    type(profile_type), intent(in) :: p(2)

    remarkable = p(1)%taken//p(1)%mended//p(2)%taken//p(2)%mended /= '' .or. p(1)%file /= p(2)%file
  end function remarkable

  !> Begin the column file of a run, which is to take its rows.
  subroutine begin_columns(c, file, columns, error)
    type(case_type), intent(in) :: c
    character(*), intent(in) :: file
    type(column_file), intent(inout) :: columns
    type(error_type), allocatable, intent(out) :: error

    call columns%begin(file, merge(n_columns, n_rigid_columns, c%formulation == 'elastic'), error)
  end subroutine begin_columns

  !> Complete the columns of a run and write the geometry functions, if they have a file. No file gets its name before
  !> both are complete.
  subroutine finish_files(c, setup, run, columns, geometry_file, error)
    type(case_type), intent(in) :: c
    type(setup_type), intent(in) :: setup
    type(run_type), intent(in) :: run
    type(column_file), intent(inout) :: columns
    character(*), intent(in) :: geometry_file    !! '' for none
    type(error_type), allocatable, intent(out) :: error
    type(column_file) :: geometry
    character(16) :: names(n_rigid_columns), units(n_rigid_columns)
    character(:), allocatable :: about, events
    integer :: n

    n = size(run%last)
    names = column_names()
    units = column_units()
    call header(c, setup, about)
    call outcome(c, run, kept_impacts, events)
    call columns%finish(about//events, names(:n), units(:n), error)
    if (.not. allocated(error) .and. geometry_file /= '') call write_geometry(c, setup, geometry_file, geometry, error)
    if (.not. allocated(error)) call columns%place(error)
    if (.not. allocated(error) .and. geometry_file /= '') call geometry%place(error)
    call columns%abandon()
    call geometry%abandon()
  end subroutine finish_files

  !> Geometry functions over the lateral displacements at which the wheelset stands
  !> on both rails, in a file that `place` gives its name.
  subroutine write_geometry(c, setup, file, columns, error)
    type(case_type), intent(in) :: c
    type(setup_type), intent(in) :: setup
    character(*), intent(in) :: file
    type(column_file), intent(inout) :: columns
    type(error_type), allocatable, intent(out) :: error
    real(dp), allocatable :: rows(:, :)
    character(:), allocatable :: about
    integer :: n, last, i

    call header(c, setup, about)
    about = about//'conicity: equivalent, by harmonic linearisation, for the amplitude |Y|'
    if (.not. setup%symmetric) about = about//' about where the mean of delta_r is 0'
    n = max(2, int(1.2_dp*maxval(setup%side%clearance)/geometry_pitch))
    allocate (rows(size(geometry_names), -n:n))
    call geometry_table(setup%side, setup%centred(2), n, rows, last)
    if (last < 2) then
      call fatal_error(error, file//': the rigid wheelset does not stand on both rails')
      return
    end if
    call columns%begin(file, size(rows, 1), error)
    do i = -last, last
      if (.not. allocated(error)) call columns%take(rows(:, i), error)
    end do
    if (.not. allocated(error)) call columns%finish(about//nl, geometry_names, geometry_units, error)
  end subroutine write_geometry

  pure function written(form, x) result(word)
    character(*), intent(in) :: form
    real(dp), intent(in) :: x
    character(40) :: word

    write (word, form) x
    word = with_zero(adjustl(word))
  end function written

  pure function fixed(x, digits) result(word)
    real(dp), intent(in) :: x
    integer, intent(in) :: digits
    character(len_trim(written('(f0.'//str(digits)//')', x))) :: word

    word = written('(f0.'//str(digits)//')', x)
  end function fixed

  pure function scientific(x) result(word)
    real(dp), intent(in) :: x
    character(len_trim(written('(es9.2)', x))) :: word

    word = written('(es9.2)', x)
  end function scientific

end module report