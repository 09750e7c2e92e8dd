!> Texts about a run: the lines before and after the rows of a column file, and the summary on the terminal. The groups `&setup`
!> and `&results` of the file and the sentences of the summary are printed from one list of results.
module run_results
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use, intrinsic :: iso_fortran_env, only: int64
  use case, only: case_title, case_type, is_default, list_variables, output_path, value_text, variable_type
  use events, only: causes, elastic_kinds, event_kinds, event_log, event_type, impact, kept, never
  use kinds, only: degree, dp, version
  use profile, only: profile_type
  use results, only: newline, result_list, rounded
  use run_monitor, only: run_type
  use run_setup, only: roll_rate_on_rails, setup_type
  use table_results, only: list_accuracy, list_tables, list_work
  use text, only: joined, shortest, str
  use upright_rails, only: warn_of_upright
  use wheelset, only: contact_name, flanges
  implicit none
  private
  public :: describe_setup, describe_results, summary

  integer, parameter :: listed_impacts = 5
  character(*), parameter :: scientific = 'es9.2'
  real(dp), parameter :: upright(2) = 0     !! inclination of wheels beyond their files [rad]
  integer, parameter :: width = 100         !! longest line on the terminal [characters]
  real(dp), parameter :: milli = 1e3_dp, kilo = 1e-3_dp    ! units on the terminal over SI units

contains

  !> Lines before the rows: the case, the profiles, `&setup`, the groups of the namelist.
  subroutine describe_setup(c, setup, lines)
    type(case_type), intent(in) :: c
    type(setup_type), intent(in) :: setup
    character(:), allocatable, intent(out) :: lines
    type(case_type), target :: copy, usual
    type(variable_type), allocatable :: list(:), default(:)
    type(result_list) :: items
    character(:), allocatable :: group
    integer :: k

    lines = 'ldbench '//version//newline//'case '//trim(c%name)//': '//trim(case_title(c))//newline// &
      'frame: X forward, Y left, Z up; Z and roll from static equilibrium at Y = 0; SI units, radians'//newline// &
      'contacts: LT left tread, LF left flange, RT right tread, RF right flange; '// &
      'forces of the rail on the wheel, track frame'//newline
    call add_profiles(lines, 'wheel', setup%wheel, upright, only_remarkable=.false.)
    call add_profiles(lines, 'rail', setup%rail, setup%inclination, only_remarkable=.false.)
    call add_formulation(lines, c)
    items = result_list('', '', '')
    call list_setup(c, setup, items)
    lines = lines//'&setup'//newline//items%entries//'/'//newline//items%warnings
    copy = c
    call list_variables(copy, list)
    call list_variables(usual, default)
    group = ''
    do k = 1, size(list)
      if (list(k)%slope .and. is_default(list(k), default(k))) cycle
      if (list(k)%group /= group) then
        if (k > 1) lines = lines//'/'//newline
        group = list(k)%group
        lines = lines//'&'//group//newline
      end if
      lines = lines//'  '//list(k)%name//' = '//trim(value_text(list(k)))
      if (list(k)%unit /= '' .and. list(k)%unit /= '1') lines = lines//'  ! '//list(k)%unit
      lines = lines//newline
    end do
    lines = lines//'/'//newline
  end subroutine describe_setup

  !> Lines after the rows: the group `&results`.
  subroutine describe_results(c, run, lines)
    type(case_type), intent(in) :: c
    type(run_type), intent(in) :: run
    character(:), allocatable, intent(out) :: lines
    type(result_list) :: items

    items = result_list('', '', '')
    call list_outcome(c, run, items)
    lines = '&results'//newline//items%entries//'/'//newline//items%warnings
  end subroutine describe_results

  !> The text for the terminal.
  subroutine summary(c, setup, run, lines)
    type(case_type), intent(in) :: c
    type(setup_type), intent(in) :: setup
    type(run_type), intent(in) :: run
    character(:), allocatable, intent(out) :: lines
    type(result_list) :: items

    lines = trim(c%name)//': '//trim(case_title(c))//newline
    call add_formulation(lines, c)
    call add_profiles(lines, 'wheel', setup%wheel, upright, only_remarkable=.true.)
    call add_profiles(lines, 'rail', setup%rail, setup%inclination, only_remarkable=.true.)
    items = result_list('', '', '')
    call list_setup(c, setup, items)
    call list_outcome(c, run, items)
    call list_work(c, setup, run%seconds, items)
    lines = lines//items%sentences
    call wrap(lines)
    lines = lines//'columns: '//trim(output_path(c))//', '//str(run%rows)//' row'//trim(merge(' ', 's', run%rows == 1))//newline
  end subroutine summary

  !> Results that follow from the case before the run.
  subroutine list_setup(c, setup, items)
    type(case_type), intent(in) :: c
    type(setup_type), intent(in) :: setup
    type(result_list), intent(inout) :: items
    character(5), parameter :: side(2) = [character(5) :: 'left', 'right']
    character(8), parameter :: motion(3) = [character(8) :: 'lateral', 'vertical', 'roll']
    character(:), allocatable :: words
    integer :: k

    call warn_of_upright(setup, words)
    if (words /= '') call items%warn(words)
    associate (left => setup%side(1)%clearance, right => setup%side(2)%clearance)
      call items%add('clearance_left', [left], 'm', 'rigid-axle clearance [mm]: left #', 'f0.3', milli)
      call items%add('clearance_right', [right], 'm', ', right #'//newline, 'f0.3', milli)
    end associate
    call items%add('axle_height', [setup%equilibrium(2)], 'm, at static equilibrium; Z is measured from it', &
      'equilibrium: axle # m above the rails', 'f0.6')
    call items%add('axle_roll', [setup%equilibrium(3)], 'rad, at static equilibrium; roll is measured from it')
    call items%add('', [setup%centred(2) - setup%equilibrium(2)], '', ', # mm lower than with rigid contacts', 'f0.4', milli)
    call items%add('', [setup%wheelset%weight()/2], '', ', # kN per wheel'// &
      trim(merge('           ', ' on average', setup%symmetric))//newline, 'f0.3', kilo)
    if (.not. setup%symmetric) then
      associate (q => setup%rest - setup%equilibrium)
        call items%add('rest_Y', [q(1)], 'm, where nothing holds the wheelset', 'at rest off the centre: Y = # m')
        call items%add('rest_Z', [q(2)], 'm', ', Z = # m')
        call items%add('rest_roll', [q(3)], 'rad', ', roll = # rad'//newline)
      end associate
    end if
    call items%append('largest lateral force with an equilibrium [kN]:')
    do k = 1, 2
      if (ieee_is_nan(setup%limit(k))) then
        call items%append(' '//trim(side(k))//' beyond the contact table')
      else
        call items%add('F_limit_'//trim(side(k)), setup%limit(k:k), 'N, largest lateral force with an equilibrium', &
          ' '//trim(side(k))//' #', 'f0.3', kilo)
      end if
      call items%append(merge(',', newline, k == 1))
    end do
    words = 'eigenfrequencies at equilibrium [Hz]:'
    do k = 1, setup%modes
      ! A mode is named after the coordinate with most of the kinetic energy.
      if (k > 1) words = words//','
      words = words//' '//trim(motion(maxloc(setup%wheelset%inertia()*setup%shapes(:, k)**2, 1)))//' #'
    end do
    call items%add('eigenfrequencies', setup%frequency(:setup%modes), 'Hz', words//newline, 'f0.4')
    if (allocated(setup%remark)) call items%warn(setup%remark)
    call list_tables(c, setup, items)
    call warn_of_roll_rate()

  contains

    !> A wheelset at rest on its rails that gets a lateral velocity without the roll rate to it bounces from the start. That is
    !> doubtful, for vY alone may have been changed.
    subroutine warn_of_roll_rate()
      real(dp), parameter :: apart = 0.1_dp      ! of the roll rate on the rails
      real(dp) :: rate

      if (c%formulation /= 'elastic' .or. c%roll_link /= 'none') return
      if (abs(c%vy) <= 0 .or. max(abs(c%z), abs(c%roll), abs(c%vz)) > 0) return
      rate = roll_rate_on_rails(c, setup)
      if (.not. abs(c%roll_rate - rate) > apart*abs(rate)) return
      call items%warn('&initial roll_rate: expected about '//trim(rounded(rate, 'f0.5'))//' rad/s, with which a wheelset moves '// &
        'along its rails with vY = '//str(c%vy)//' m/s, found '//str(c%roll_rate)//'; roll_link = ''rails'' sets it')
    end subroutine warn_of_roll_rate

  end subroutine list_setup

  !> Events, extremes, peaks, energy balance and steps of a run.
  subroutine list_outcome(c, run, items)
    type(case_type), intent(in) :: c
    type(run_type), intent(in) :: run
    type(result_list), intent(inout) :: items
    character(14), parameter :: extreme(6) = [character(14) :: 'farthest_left', 'farthest_right', 'farthest_up', &
      'farthest_down', 'largest_roll', 'smallest_roll']
    character(25), parameter :: extreme_words(6) = [character(25) :: 'farthest [mm]: left #', ' right #', ' up #', ' down #', &
      'roll [mrad]: largest #', ' smallest #']
    real(dp), parameter :: largest_drift = 0.01_dp   ! over the largest kinetic energy
    real(dp), parameter :: rounding = 1e-6_dp        ! of the energy of a wheelset at rest, at most [J]
    character(:), allocatable :: words
    real(dp) :: reference
    logical :: rigid
    integer :: k

    rigid = c%formulation /= 'elastic'
    if (run%changes /= '') call items%add('changes', run%changes, 'initial conditions follow the constraints: #'//newline)
    call list_events(c, run%log, items)
    call items%append('number of events:'//newline)
    do k = 1, merge(size(event_kinds), elastic_kinds, rigid)
      items%silent = run%log%counts(k) == 0
      call items%add('n_'//joined(event_kinds(k)), int(run%log%counts(k), int64), '  '//trim(event_kinds(k))//' #'//newline)
    end do
    items%silent = .false.
    do k = 1, 6
      call items%add(trim(extreme(k)), [run%extreme(k)], merge('m  ', 'rad', k <= 4), trim(extreme_words(k)), 'f0.3', milli)
      call items%add('t_'//trim(extreme(k)), [run%extreme_time(k)], 's', ' at # s'//merge(newline, ',', k == 4 .or. k == 6), 'f0.6')
    end do
    call list_passages(c, run%log, items)
    call list_peaks('peak normal forces [kN]:', 'peak_N_', 't_peak_', run%peak, run%peak_time, 'N', kilo)
    call list_first_contacts(run, rigid, items)
    call list_pressures(run, items)
    call list_accuracy(c, run%accuracy, items)
    if (rigid) then
      call list_peaks('largest impulses [N s]:', 'peak_P_', 't_peak_P_', run%largest_impulse, run%impulse_time, &
        'N s, in one impact', 1.0_dp)
      call items%add('lost', [run%loss], 'J, in impacts', 'energy lost in impacts [J]: #'//newline, 'f0.6')
    end if
    call items%add('drift', [run%drift], 'J, largest energy drift', 'largest energy drift [J]: #', scientific)
    call items%add('t_drift', [run%drift_time], 's')
    call items%add('kinetic_energy', [run%kinetic_energy], 'J, initial, of lateral, vertical and roll motion')
    reference = run%kinetic_energy
    words = ', relative to the initial kinetic energy: #'
    if (run%kinetic_energy <= 0) then
      reference = run%largest_work
      words = ', relative to the largest work of the lateral force: #'
    end if
    if (reference > 0) then
      call items%add('drift_reference', [reference], 'J')
      call items%add('drift_relative', [run%drift/reference], '', words, scientific)
    end if
    call items%append(newline)
    if (run%step > run%stable_step) call items%warn('&integrator dt: expected steps of at most '// &
      trim(rounded(run%stable_step, scientific))//' s, the limit of stability at the highest frequency at rest, found '// &
      trim(rounded(run%step, scientific))//' s; lower dt')
    if (run%drift > max(largest_drift*run%largest_energy, rounding)) call items%warn('expected an energy drift of '// &
      'at most '//str(nint(100*largest_drift))//' % of the largest kinetic energy, '// &
      trim(rounded(run%largest_energy, scientific))//' J, found '//trim(rounded(run%drift, scientific))// &
      ' J; lower &integrator dt or energy_tolerance')
    call items%add('steps', run%steps, 'steps: #')
    call items%add('step', [run%step], 's, at most', ' of at most # s')
    call items%add('cuts', run%cuts, ', of which #'//trim(merge(' was cut ', ' were cut', run%cuts == 1)))
    items%silent = run%missed == 0
    call items%add('missed', run%missed, ', # over a tolerance after '//str(c%max_halvings)//' halving'// &
      trim(merge(' ', 's', c%max_halvings == 1)))
    items%silent = .false.
    call items%add('evaluations', run%evaluations, '; contact evaluations: #'//newline)
    call items%add('t', [run%last(1)], 's, at the end', 'ended at t = # s', 'f0.6')
    call items%add('end', trim(ending(c, run)), ': #'//newline)
    call items%add('rows', int(run%rows, int64), '')

  contains

    !> Largest values by contact, with their times; the terminal has only those of contacts that closed.
    subroutine list_peaks(title, name, time_name, x, time, unit, factor)
      character(*), intent(in) :: title, name, time_name, unit
      real(dp), intent(in) :: x(4), time(4)
      real(dp), intent(in) :: factor               !! unit on the terminal over SI unit

      call items%append(title//newline)
      do k = 1, 4
        items%silent = .not. x(k) > 0
        call items%add(name//contact_name(k), x(k:k), unit, '  '//contact_name(k)//' #', 'f0.3', factor)
        call items%add(time_name//contact_name(k), time(k:k), 's', ' at # s'//newline, 'f0.6')
      end do
      items%silent = .false.
    end subroutine list_peaks

  end subroutine list_outcome

  !> When the wheelset passes the centre, returns, lifts a wheel for good and derails.
  subroutine list_passages(c, log, items)
    type(case_type), intent(in) :: c
    type(event_log), intent(in) :: log
    type(result_list), intent(inout) :: items

    if (log%passed < never) call items%add('t_first_centre', [log%passed], 's, first passage of the centre after a flange contact')
    if (log%returned < never) call items%add('t_return', [log%returned], 's, back at the centre after turning back on both sides', &
      'back at the centre after turning back on both sides: # s'//newline, 'f0.6')
    call list_fall('_unloaded', 'a wheel lifts for good', log%unloaded)
    call list_fall('_derailment', 'derailment', log%derailed)

  contains

    subroutine list_fall(name, what, event)
      character(*), intent(in) :: name, what
      type(event_type), intent(in) :: event

      if (event%t >= never) return
      call items%add('t'//name, [event%t], 's, '//what, what//': # s', 'f0.6')
      if (is_loaded(c)) call items%add('F'//name, [event%force], 'N, lateral force then', ', lateral force # kN', 'f0.3', kilo)
      call items%append(newline)
    end subroutine list_fall

  end subroutine list_passages

  !> The first contact of every wheel's tread and flange, from its first touch until it first opens.
  subroutine list_first_contacts(run, rigid, items)
    type(run_type), intent(in) :: run
    logical, intent(in) :: rigid
    type(result_list), intent(inout) :: items
    integer :: k

    call items%append('first contacts, until they first open:'//newline)
    do k = 1, 4
      if (run%log%touched(k) >= never) cycle
      associate (name => contact_name(k))
        call items%add('t_first_'//name, run%log%touched(k:k), 's', '  '//name//' from # s', 'f0.6')
        ! Impacts of rigid contacts take no time, so their forces have no peak.
        if (.not. rigid) then
          call items%add('first_peak_N_'//name, run%first_peak(k:k), 'N', ', peak # kN', 'f0.3', kilo)
          call items%add('t_first_peak_'//name, run%first_peak_time(k:k), 's', ' at # s', 'f0.6')
        end if
        if (run%log%opened(k) < never) then
          call items%add('first_duration_'//name, [run%log%opened(k) - run%log%touched(k)], 's', ', lasts # ms', 'f0.3', milli)
          call items%add('first_impulse_'//name, run%first_impulse(k:k), 'N s', ', impulse # N s', 'f0.3')
        end if
        call items%append(newline)
      end associate
    end do
    do k = 1, 2
      if (run%turn_impulse(k) < 0) cycle
      call items%add('turn_impulse_'//contact_name(flanges(k)), run%turn_impulse(k:k), &
        'N s, of the flange until the wheelset moves back')
    end do
  end subroutine list_first_contacts

  !> The largest pressure, and the pressures at the first peaks of flanges.
  subroutine list_pressures(run, items)
    type(run_type), intent(in) :: run
    type(result_list), intent(inout) :: items
    integer :: k

    associate (p => run%pressure)
      if (p%contact > 0) then
        call items%add('pmax', [p%largest], 'Pa, largest pressure of all contacts', 'largest pressure [GPa]: #', 'f0.3', 1e-9_dp)
        call items%add('pmax_contact', contact_name(p%contact), ', #')
        call items%add('t_pmax', [p%t], 's', ' at # s', 'f0.6')
        call items%add('pmax_y', p%place(1:1), 'm, track frame', ', y = # m', 'f0.4')
        call items%add('pmax_z', p%place(2:2), 'm', ', z = # m'//newline, 'f0.4')
      end if
    end associate
    do k = 1, 2
      associate (flange => run%flange(k), name => contact_name(flanges(k)))
        if (.not. flange%largest > 0) cycle
        call items%add('pmax_'//name, [flange%largest], 'Pa, at the first peak')
        call items%add('patch_'//name, [flange%area], 'm2, area of all patches then')
        call items%add('approach_'//name, [flange%approach], 'm, then')
      end associate
    end do
  end subroutine list_pressures

  !> The first events of each kind; the terminal has fewer impacts than the file.
  subroutine list_events(c, log, items)
    type(case_type), intent(in) :: c
    type(event_log), intent(in) :: log
    type(result_list), intent(inout) :: items
    character(:), allocatable :: name
    integer :: k, i, impacts

    impacts = 0
    name = ''
    call items%append('events:'//newline)
    do k = 1, log%n
      associate (event => log%list(k))
        if (event%kind == impact) impacts = impacts + 1
        items%silent = event%kind == impact .and. impacts > listed_impacts
        name = 'event('//str(k)//')%'
        call items%add(name//'t', [event%t], '', '  t = # s', 'f0.6')
        call items%add(name//'kind', trim(event_kinds(event%kind)), '  #')
        if (event%angle > 0) call items%add(name//'angle', [event%angle], '', ' at # degrees', 'f0.1', 1/degree)
        if (event%cause > 0) then
          call items%add(name//'cause', trim(causes(event%cause)), '')
          if (causes(event%cause) == 'moves') call items%append(', moves from the tread')
        end if
        if (is_loaded(c)) call items%add(name//'force', [event%force], '', ', lateral force # kN', 'f0.3', kilo)
        if (any(abs(event%impulse) > 0)) then
          call items%append(', impulses [N s]')
          do i = 1, 4
            if (abs(event%impulse(i)) > 0) &
              call items%add(name//'P_'//contact_name(i), event%impulse(i:i), '', ' '//contact_name(i)//' #', 'f0.3')
          end do
          call items%add(name//'loss', [event%loss], '', ', energy lost [J] #', 'f0.6')
        end if
        call items%append(newline)
      end associate
    end do
    items%silent = .false.
    if (sum(log%counts) <= log%n - max(0, impacts - listed_impacts)) return
    call items%append('  (the list has the first '//str(kept)//' events of each kind')
    if (impacts > 0) call items%append(', '//str(listed_impacts)//' impacts')
    call items%append(')'//newline)
  end subroutine list_events

  !> Whether a case has a lateral force.
  pure logical function is_loaded(c)
    type(case_type), intent(in) :: c

    is_loaded = abs(c%lateral_ramp) > 0 .or. abs(c%lateral_force) > 0
  end function is_loaded

  !> Why a run ended.
  function ending(c, run) result(words)
    type(case_type), intent(in) :: c
    type(run_type), intent(in) :: run
    character(64) :: words

    if (run%cancelled) then
      words = 'stopped by the user'
    else if (run%log%derailed%t < never .and. c%stop_at == 'derailment') then
      words = 'derailment'
    else if (run%gone) then
      words = 'derailed, and then left what the contact table covers'
    else if (c%stop_at == 'return_to_centre' .and. run%log%returned < never) then
      words = 'return to the centre after both flanges'
      if (.not. all(run%log%flanged)) words = 'return to the centre, turned back below both flanges'
      if (run%log%flanged(1) .neqv. run%log%flanged(2)) &
        words(index(words, 'both'):) = merge('the right flange', 'the left flange ', run%log%flanged(1))
    else
      words = 't_end'
      if (c%stop_at /= 't_end') words = 't_end, '//trim(c%stop_at)//' not reached'
    end if
  end function ending

  !> What a rigid formulation means for the case.
  subroutine add_formulation(lines, c)
    character(:), allocatable, intent(inout) :: lines
    type(case_type), intent(in) :: c

    select case (c%formulation)
    case ('bilateral')
      lines = lines//'formulation bilateral: contacts are rigid, and both wheels are held on their rails; a negative N is a '// &
        'rail that pulls; P is an impulse where contact jumps along the wheel'//newline
    case ('unilateral')
      lines = lines//'formulation unilateral: contacts are rigid and only push, restitution '//str(c%restitution)// &
        '; N is the force of a contact that lasts, P is the sum of the impulses of impacts'//newline
    case default
      return
    end select
    lines = lines//'this formulation does not use &material, &contact model, &integrator order, beta, gamma, '// &
      'tolerance and max_iterations, and &table except lateral, roll and drop, at which a derailed run ends'//newline
  end subroutine add_formulation

  !> A line per profile, with one line for both sides if they have the same. A profile is remarkable if its file says how it
  !> was made, if it is turned, or if the sides have different files.
  subroutine add_profiles(lines, what, p, inclination, only_remarkable)
    character(:), allocatable, intent(inout) :: lines
    character(*), intent(in) :: what
    type(profile_type), intent(in) :: p(2)       !! left, right
    real(dp), intent(in) :: inclination(2)       !! beyond the file [rad]
    logical, intent(in) :: only_remarkable
    character(6), parameter :: side(2) = ['left  ', 'right ']
    logical :: same
    integer :: k

    same = p(1)%file == p(2)%file .and. abs(inclination(1) - inclination(2)) <= 0
    if (only_remarkable .and. p(1)%taken//p(2)%taken == '' .and. same .and. abs(inclination(1)) <= 0) return
    do k = 1, merge(1, 2, same)
      if (.not. same) lines = lines//trim(side(k))//' '
      lines = lines//what//' profile: '//p(k)%file//', CRC-32 '//p(k)%checksum
      if (p(k)%reconstruction) lines = lines//', RECONSTRUCTION (not the organisers'' file)'
      if (abs(inclination(k)) > 0) lines = lines//', inclined by '//trim(shortest(inclination(k)))//' rad beyond its file'
      if (p(k)%taken /= '') lines = lines//', '//p(k)%taken
      lines = lines//newline
    end do
  end subroutine add_profiles

  !> Break lines that are longer than `width` at blanks, and indent what follows by two more blanks than the line.
  subroutine wrap(lines)
    character(:), allocatable, intent(inout) :: lines
    integer :: start, length, cut, blanks, indent
    logical :: broken

    start = 1
    broken = .false.
    do while (start <= len(lines))
      length = index(lines(start:), newline) - 1
      blanks = verify(lines(start:start + length), ' ') - 1
      if (.not. broken) indent = blanks + 2
      broken = length > width
      if (broken) then
        cut = index(lines(start + blanks:start + width), ' ', back=.true.)
        if (cut == 0) cut = index(lines(start + blanks:start + length - 1), ' ')      ! a long word
        broken = cut > 0
        if (broken) then
          length = blanks + cut - 1
          lines = lines(:start + length - 1)//newline//repeat(' ', indent)//lines(start + length + 1:)
        end if
      end if
      start = start + length + 1
    end do
  end subroutine wrap

end module run_results
