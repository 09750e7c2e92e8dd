!> The comments of a column file, as namelist groups: the setup and every variable in force before the rows, the results
!> after them. Any reader of namelists reads the groups. Numbers have all digits.
module run_results
  use case, only: case_title, case_type, list_variables, value_text, variable_type
  use contact_table, only: table_type
  use events, only: elastic_kinds, event_kinds
  use kinds, only: dp, version
  use report_lines, only: add_formulation, add_profiles, add_run_warnings, add_warnings, newline, table_points, zone_places
  use run_monitor, only: run_type
  use run_setup, only: setup_type
  use text, only: shortest, str
  use wheelset, only: contact_name
  implicit none
  private
  public :: describe_setup, describe_results, ending

contains

  !> Lines before the rows: the case, the profiles, `&setup`, the groups of the namelist.
  subroutine describe_setup(c, setup, lines)
    type(case_type), intent(in) :: c
    type(setup_type), intent(in) :: setup
    character(:), allocatable, intent(out) :: lines
    type(case_type), target :: copy
    type(variable_type), allocatable :: list(:)
    character(:), allocatable :: group
    integer :: k

    lines = 'ldbench '//version//newline//'case '//trim(c%name)//': '//trim(case_title(c))//newline// &
      'frame: X forward, Y left, Z up; Z and roll from static equilibrium at Y = 0; SI units, radians'//newline// &
      'contacts: LT left tread, LF left flange, RT right tread, RF right flange; '// &
      'forces of the rail on the wheel, track frame'//newline
    call add_profiles(lines, 'wheel', setup%wheel)
    call add_profiles(lines, 'rail', setup%rail)
    call add_formulation(lines, c)
    call add_setup(lines, c, setup)
    copy = c
    call list_variables(copy, list)
    group = ''
    do k = 1, size(list)
      if (list(k)%group /= group .and. k > 1) lines = lines//'/'//newline
      if (list(k)%group /= group) lines = lines//'&'//list(k)%group//newline
      group = list(k)%group
      lines = lines//'  '//list(k)%name//' = '//trim(value_text(list(k)))
      if (list(k)%unit /= '' .and. list(k)%unit /= '1') lines = lines//'  ! '//list(k)%unit
      lines = lines//newline
    end do
    lines = lines//'/'//newline
  end subroutine describe_setup

  !> The group `&setup`: results that follow from the case before the run.
  subroutine add_setup(lines, c, setup)
    character(:), allocatable, intent(inout) :: lines
    type(case_type), intent(in) :: c
    type(setup_type), intent(in) :: setup
    character(:), allocatable :: warnings

    lines = lines//'&setup'//newline
    call add_numbers(lines, 'clearance_left', [setup%side(1)%clearance], 'm')
    call add_numbers(lines, 'clearance_right', [setup%side(2)%clearance], 'm')
    call add_numbers(lines, 'axle_height', [setup%equilibrium(2)], 'm, at static equilibrium; Z is measured from it')
    call add_numbers(lines, 'axle_roll', [setup%equilibrium(3)], 'rad, at static equilibrium; roll is measured from it')
    if (.not. setup%symmetric) then
      associate (q => setup%rest - setup%equilibrium)
        call add_numbers(lines, 'rest_Y', [q(1)], 'm, where nothing holds the wheelset')
        call add_numbers(lines, 'rest_Z', [q(2)], 'm')
        call add_numbers(lines, 'rest_roll', [q(3)], 'rad')
      end associate
    end if
    call add_numbers(lines, 'eigenfrequencies', setup%frequency(:setup%modes), 'Hz')
    if (c%formulation == 'elastic') then
      call add_table(lines, '', setup%wheelset%table)
      if (.not. setup%symmetric) call add_table(lines, '_right', setup%wheelset%right_table)
    end if
    lines = lines//'/'//newline
    if (c%formulation /= 'elastic') return
    warnings = ''
    call add_warnings(warnings, c, 'contact table', setup%wheelset%table)
    if (.not. setup%symmetric) call add_warnings(warnings, c, 'right contact table', setup%wheelset%right_table)
    lines = lines//warnings
  end subroutine add_setup

  subroutine add_table(lines, side, table)
    character(:), allocatable, intent(inout) :: lines
    character(*), intent(in) :: side             !! '' or '_right'
    type(table_type), intent(in) :: table
    character(:), allocatable :: place
    integer :: k

    call add_value(lines, 'table_points'//side, ''''//trim(table_points(table))//'''')
    do k = 1, size(zone_places)
      if (table%accuracy%poses(k) == 0) cycle
      place = trim(zone_places(k))
      if (index(place, ' ') > 0) place(index(place, ' '):index(place, ' ')) = '_'
      call add_numbers(lines, 'table_error_'//place//side, [table%accuracy%rms(k), table%accuracy%largest(k)], &
        'rms and largest, of max(|F|, 5 kN)')
    end do
  end subroutine add_table

  !> Lines after the rows: the group `&results`.
  subroutine describe_results(c, run, lines)
    type(case_type), intent(in) :: c
    type(run_type), intent(in) :: run
    character(:), allocatable, intent(out) :: lines
    character(5), parameter :: way(3) = [character(5) :: 'left', 'right', 'up']
    logical :: rigid
    integer :: k

    rigid = c%formulation /= 'elastic'
    lines = '&results'//newline
    call add_value(lines, 'end', ''''//trim(ending(c, run))//'''')
    call add_numbers(lines, 't', [run%last(1)], 's, at the end')
    call add_value(lines, 'rows', str(run%rows))
    if (run%changes /= '') call add_value(lines, 'changes', ''''//run%changes//'''')
    do k = 1, 3
      call add_numbers(lines, 'farthest_'//trim(way(k)), [run%extreme(k)], 'm')
      call add_numbers(lines, 't_farthest_'//trim(way(k)), [run%extreme_time(k)], 's')
    end do
    do k = 1, 4
      call add_numbers(lines, 'peak_N_'//contact_name(k), [run%peak(k)], 'N')
      call add_numbers(lines, 't_peak_'//contact_name(k), [run%peak_time(k)], 's')
    end do
    if (rigid) then
      do k = 1, 4
        call add_numbers(lines, 'peak_P_'//contact_name(k), [run%largest_impulse(k)], 'N s, in one impact')
        call add_numbers(lines, 't_peak_P_'//contact_name(k), [run%impulse_time(k)], 's')
      end do
      call add_numbers(lines, 'lost', [run%loss], 'J, in impacts')
    end if
    call add_numbers(lines, 'drift', [run%drift], 'J, largest energy drift')
    call add_numbers(lines, 'kinetic_energy', [run%kinetic_energy], 'J, initial, of lateral, vertical and roll motion')
    call add_value(lines, 'steps', str(run%steps))
    call add_numbers(lines, 'step', [run%step], 's, at most')
    call add_value(lines, 'cuts', str(run%cuts))
    call add_value(lines, 'missed', str(run%missed))
    call add_value(lines, 'evaluations', str(run%evaluations))
    do k = 1, merge(size(event_kinds), elastic_kinds, rigid)
      call add_value(lines, 'n_'//joined(event_kinds(k)), str(run%log%counts(k)))
    end do
    call add_events(lines, run, abs(c%lateral_ramp) > 0 .or. abs(c%lateral_force) > 0)
    lines = lines//'/'//newline
    call add_run_warnings(lines, run)
  end subroutine describe_results

  !> A line per event that was kept: the first of each kind.
  subroutine add_events(lines, run, loaded)
    character(:), allocatable, intent(inout) :: lines
    type(run_type), intent(in) :: run
    logical, intent(in) :: loaded                !! there is a lateral force
    character(:), allocatable :: name
    integer :: k, i

    do k = 1, run%log%n
      associate (event => run%log%list(k))
        name = 'event('//str(k)//')%'
        lines = lines//'  '//name//'t = '//trim(shortest(event%t))//', '//name//'kind = '''//trim(event_kinds(event%kind))//''''
        if (event%angle > 0) lines = lines//', '//name//'angle = '//trim(shortest(event%angle))
        if (loaded) lines = lines//', '//name//'force = '//trim(shortest(event%force))
        do i = 1, 4
          if (abs(event%impulse(i)) > 0) lines = lines//', '//name//'P_'//contact_name(i)//' = '//trim(shortest(event%impulse(i)))
        end do
        if (abs(event%loss) > 0) lines = lines//', '//name//'loss = '//trim(shortest(event%loss))
        lines = lines//newline
      end associate
    end do
  end subroutine add_events

  !> Why a run ended.
  function ending(c, run) result(words)
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
  end function ending

  !> A kind of event as a name.
  pure function joined(words) result(name)
    character(*), intent(in) :: words
    character(len_trim(words)) :: name
    integer :: k

    name = words
    do k = 1, len(name)
      if (scan(name(k:k), ' -') > 0) name(k:k) = '_'
    end do
  end function joined

  subroutine add_numbers(lines, name, x, about)
    character(:), allocatable, intent(inout) :: lines
    character(*), intent(in) :: name, about
    real(dp), intent(in) :: x(:)
    integer :: k

    lines = lines//'  '//name//' = '//trim(shortest(x(1)))
    do k = 2, size(x)
      lines = lines//', '//trim(shortest(x(k)))
    end do
    lines = lines//'  ! '//about//newline
  end subroutine add_numbers

  subroutine add_value(lines, name, word)
    character(:), allocatable, intent(inout) :: lines
    character(*), intent(in) :: name, word

    lines = lines//'  '//name//' = '//word//newline
  end subroutine add_value

end module run_results
