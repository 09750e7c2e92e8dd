!> The summary of a run on the terminal.
module summary_text
  use case, only: case_title, case_type, output_path
  use events, only: elastic_kinds, event_kinds, kept
  use kinds, only: degree, dp
  use profile, only: profile_type
  use report_lines, only: add_formulation, add_profiles, add_run_warnings, add_tables, fixed, newline, plural, scientific
  use run_monitor, only: run_type
  use run_results, only: ending
  use run_setup, only: setup_type
  use text, only: str
  use wheelset, only: contact_name
  implicit none
  private
  public :: summary

  integer, parameter :: listed_impacts = 5
  integer, parameter :: width = 100         !! longest line [characters]

contains

  !> The text for the terminal.
  subroutine summary(c, setup, run, lines)
    type(case_type), intent(in) :: c
    type(setup_type), intent(in) :: setup
    type(run_type), intent(in) :: run
    character(:), allocatable, intent(out) :: lines

    lines = trim(c%name)//': '//trim(case_title(c))//newline
    call add_formulation(lines, c)
    if (remarkable(setup%wheel)) call add_profiles(lines, 'wheel', setup%wheel)
    if (remarkable(setup%rail)) call add_profiles(lines, 'rail', setup%rail)
    call add_clearances(lines, setup)
    lines = lines//'equilibrium: axle '//fixed(setup%equilibrium(2), 6)// &
      ' m above the rails, approach '//fixed(1e3_dp*(setup%centred(2) - setup%equilibrium(2)), 4)//' mm, '// &
      fixed(0.5e-3_dp*setup%wheelset%weight(), 3)//' kN per wheel'// &
      trim(merge('           ', ' on average', setup%symmetric))//newline
    call add_rest(lines, setup)
    call add_frequencies(lines, setup)
    call add_tables(lines, c, setup)
    call add_outcome(lines, c, run)
    lines = lines//'processor time [s]: table '//fixed(setup%table_seconds, 2)// &
      merge(' (found)', ' (built)', setup%table_found)//', integration '//fixed(run%seconds, 2)//newline
    call wrap(lines)
    lines = lines//'columns: '//trim(output_path(c))//', '//str(run%rows)//' row'//plural(run%rows == 1)//newline
  end subroutine summary

  !> Break lines that are longer than `width` at blanks. What follows is indented by two more blanks than the line.
  subroutine wrap(lines)
    character(:), allocatable, intent(inout) :: lines
    integer :: start, length, cut, indent

    start = 1
    do while (start <= len(lines))
      length = index(lines(start:), newline) - 1
      indent = max(0, verify(lines(start:start + length - 1), ' ') - 1)
      if (length > width) then
        cut = index(lines(start + indent:start + width), ' ', back=.true.) + indent
        if (cut == indent) cut = index(lines(start + indent:start + length - 1), ' ') + indent      ! a long word
        if (cut > indent) then
          lines = lines(:start + cut - 2)//newline//repeat(' ', indent + 2)//lines(start + cut:)
          length = cut - 1
        end if
      end if
      start = start + length + 1
    end do
  end subroutine wrap

  !> Flange clearance, in one number if both sides are equal.
  subroutine add_clearances(lines, setup)
    character(:), allocatable, intent(inout) :: lines
    type(setup_type), intent(in) :: setup

    if (setup%symmetric) then
      lines = lines//'rigid-axle clearance [mm]: 2 x '//fixed(1e3_dp*setup%side(1)%clearance, 3)//newline
    else
      lines = lines//'rigid-axle clearance [mm]: left '//fixed(1e3_dp*setup%side(1)%clearance, 3)//', right '// &
        fixed(1e3_dp*setup%side(2)%clearance, 3)//newline
    end if
  end subroutine add_clearances

  !> Pose of rest of a wheelset with different sides, in the coordinates of the columns.
  subroutine add_rest(lines, setup)
    character(:), allocatable, intent(inout) :: lines
    type(setup_type), intent(in) :: setup

    if (setup%symmetric) return
    associate (q => setup%rest - setup%equilibrium)
      lines = lines//'at rest off the centre: Y = '//str(q(1))//' m, Z = '//str(q(2))//' m, roll = '//str(q(3))//' rad'//newline
    end associate
  end subroutine add_rest

  !> Eigenfrequencies at equilibrium. A mode is named after the coordinate with most of the kinetic energy.
  subroutine add_frequencies(lines, setup)
    character(:), allocatable, intent(inout) :: lines
    type(setup_type), intent(in) :: setup
    character(8), parameter :: motion(3) = [character(8) :: 'lateral', 'vertical', 'roll']
    integer :: k

    lines = lines//'eigenfrequencies at equilibrium [Hz]:'
    do k = 1, setup%modes
      lines = lines//' '//trim(motion(maxloc(setup%wheelset%inertia()*setup%shapes(:, k)**2, 1)))//' '//fixed(setup%frequency(k), 4)
      if (k < setup%modes) lines = lines//','
    end do
    lines = lines//newline
  end subroutine add_frequencies

  !> Whether the summary describes a profile: its file says how it was made, or the sides have different files.
  pure logical function remarkable(p)
    type(profile_type), intent(in) :: p(2)

    remarkable = p(1)%taken//p(2)%taken /= '' .or. p(1)%file /= p(2)%file
  end function remarkable

  !> Lines on events, extremes, peaks, energy drift and steps.
  subroutine add_outcome(lines, c, run)
    character(:), allocatable, intent(inout) :: lines
    type(case_type), intent(in) :: c
    type(run_type), intent(in) :: run
    character(5), parameter :: way(3) = [character(5) :: 'left', 'right', 'up']
    integer :: k, kinds, struck

    struck = 0
    if (run%changes /= '') lines = lines//'initial conditions follow the constraints: '//run%changes//newline
    lines = lines//'events:'//newline
    do k = 1, run%log%n
      associate (event => run%log%list(k))
        if (event_kinds(event%kind) == 'impact') struck = struck + 1
        if (event_kinds(event%kind) == 'impact' .and. struck > listed_impacts) cycle
        lines = lines//'  t = '//fixed(event%t, 6)//' s  '//trim(event_kinds(event%kind))
        if (event%angle > 0) lines = lines//' at '//fixed(event%angle/degree, 1)//' degrees'
        if (abs(c%lateral_ramp) > 0 .or. abs(c%lateral_force) > 0) &
          lines = lines//', lateral force '//fixed(1e-3_dp*event%force, 3)//' kN'
        if (any(abs(event%impulse) > 0)) lines = lines//trim(impact(event%impulse, event%loss))
        lines = lines//newline
      end associate
    end do
    if (sum(run%log%counts) > run%log%n - max(0, struck - listed_impacts)) then
      lines = lines//'  (the list has the first '//str(kept)//' events of each kind'
      if (struck > 0) lines = lines//', '//str(listed_impacts)//' impacts'
      lines = lines//')'//newline
    end if
    lines = lines//'number of events:'//newline
    kinds = merge(elastic_kinds, size(event_kinds), c%formulation == 'elastic')
    do k = 1, kinds
      if (run%log%counts(k) > 0) lines = lines//'  '//trim(event_kinds(k))//' '//str(run%log%counts(k))//newline
    end do
    lines = lines//'farthest [mm]:'
    do k = 1, 3
      lines = lines//' '//trim(way(k))//' '//fixed(1e3_dp*run%extreme(k), 3)//' at '//fixed(run%extreme_time(k), 6)//' s'
      if (k < 3) lines = lines//','
    end do
    lines = lines//newline
    call add_peaks(lines, 'peak normal forces [kN]:', 1e-3_dp*run%peak, run%peak_time)
    if (c%formulation /= 'elastic') then
      call add_peaks(lines, 'largest impulses [N s]:', run%largest_impulse, run%impulse_time)
      lines = lines//'energy lost in impacts [J]: '//fixed(run%loss, 6)//newline
    end if
    lines = lines//'largest energy drift [J]: '//scientific(run%drift)
    if (run%kinetic_energy > 0) lines = lines//', relative to the initial kinetic energy: '// &
      scientific(run%drift/run%kinetic_energy)
    lines = lines//newline
    call add_run_warnings(lines, run)
    lines = lines//'steps: '//str(run%steps)//' of at most '//str(run%step)//' s, of which '//str(run%cuts)// &
      trim(merge(' was cut ', ' were cut', run%cuts == 1))
    if (run%missed > 0) lines = lines//', '//str(run%missed)//' over energy_tolerance after '// &
      str(c%max_halvings)//' halving'//plural(c%max_halvings == 1)
    lines = lines//'; contact evaluations: '//str(run%evaluations)//newline
    lines = lines//'ended at t = '//fixed(run%last(1), 6)//' s: '//trim(ending(c, run))//newline
  end subroutine add_outcome

  !> A line per contact that closes, with the largest value and its time.
  subroutine add_peaks(lines, title, peak, time)
    character(:), allocatable, intent(inout) :: lines
    character(*), intent(in) :: title
    real(dp), intent(in) :: peak(4), time(4)         !! by contact; time [s]
    integer :: k

    lines = lines//title//newline
    do k = 1, 4
      if (peak(k) > 0) lines = lines//'  '//contact_name(k)//' '//fixed(peak(k), 3)//' at '//fixed(time(k), 6)//' s'//newline
    end do
  end subroutine add_peaks

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

end module summary_text
