!> A case: everything that a namelist file says.
!>
!> One list, made by `list_variables`, holds for every namelist variable its group, name,
!> place, admissible range, unit and meaning.  Reading, checking, the header of the
!> column files and `--help` all go through it.  Defaults are the benchmark's
!> values, in the type's declaration.
module case
  use errors, only: error_type, fatal_error
  use kinds, only: dp
  use system, only: default_folder, same_file
  use text, only: clip, line_type, lower, str, to_real
  implicit none
  private
  public :: case_type, variable_type, list_variables, read_case, check_case, output_path, right_table_path, value_text, &
    range_text, text_length

  integer, parameter :: text_length = 256

  type :: case_type
    ! &case
    character(text_length) :: name = 'case'
    character(text_length) :: title = ''
    ! &wheelset
    real(dp) :: mass = 1568
    real(dp) :: roll_inertia = 656
    real(dp) :: pitch_inertia = 168
    real(dp) :: rolling_radius = 0.457_dp
    real(dp) :: back_to_back = 1.35214_dp
    real(dp) :: vertical_load = 164618
    ! &track
    real(dp) :: gauge = 1.4351_dp
    real(dp) :: gauge_depth = 0.014_dp
    real(dp) :: friction = 0
    ! &material
    real(dp) :: youngs_modulus = 210e9_dp
    real(dp) :: poisson = 0.28_dp
    real(dp) :: shear_modulus = 82e9_dp
    ! &profiles
    character(text_length) :: wheel_profile = 'profiles/awprof.yz'
    character(text_length) :: rail_profile = 'profiles/arprof.yz'
    character(text_length) :: wheel_profile_right = '', rail_profile_right = ''
    real(dp) :: smoothing_mm = 0
    character(text_length) :: wheel_flip = 'auto', wheel_unit = 'auto'
    character(text_length) :: rail_flip = 'auto', rail_unit = 'auto'
    ! &initial
    real(dp) :: y = 0, z = 0, roll = 0, pitch = 0
    real(dp) :: vx = 1, vy = 0, vz = 0, roll_rate = 0, pitch_rate = 2.19_dp
    ! &loading
    real(dp) :: lateral_force = 0
    real(dp) :: lateral_ramp = 0
    ! &contact
    character(text_length) :: formulation = 'elastic'
    real(dp) :: restitution = 1
    character(text_length) :: model = 'halfspace'
    real(dp) :: split_angle = 0.1745_dp
    real(dp) :: stiffness_scale = 1
    ! &table
    character(text_length) :: table_file = ''
    real(dp) :: lateral = 0.080_dp, lift = 0.040_dp, drop = 0.010_dp
    real(dp) :: roll_range = 0.5_dp, depth = 2.2e-3_dp
    real(dp) :: accuracy = 1e-3_dp
    integer :: n_lateral = 360, n_roll = 160, n_depth = 40
    ! &integrator
    character(text_length) :: scheme = 'newmark'
    integer :: order = 2
    real(dp) :: beta = 0.25_dp, gamma = 0.5_dp
    real(dp) :: dt = 2e-6_dp
    real(dp) :: t_end = 1
    character(text_length) :: stop_at = 't_end'
    real(dp) :: energy_tolerance = 0
    real(dp) :: tolerance = 1e-10_dp
    integer :: max_iterations = 12
    integer :: max_halvings = 20
    ! &output
    character(text_length) :: output_file = ''
    real(dp) :: interval = 1e-4_dp
    character(text_length) :: rows = 'interval_and_events'
    character(text_length) :: geometry_file = ''
  end type case_type

  !> One namelist variable; exactly one of the pointers is set.
  type :: variable_type
    character(:), allocatable :: group, name
    real(dp), pointer :: x => null()
    integer, pointer :: i => null()
    character(text_length), pointer :: text => null()
    real(dp) :: least = 0, largest = 0     !! admissible range of a number
    character(:), allocatable :: words     !! admissible words, separated by blanks; empty: any text
    character(:), allocatable :: unit, meaning
  end type variable_type

contains

  !> The list of all variables, pointing into `c`.
  subroutine list_variables(c, list)
    type(case_type), target, intent(inout) :: c
    type(variable_type), allocatable, intent(out) :: list(:)
    integer :: n

    allocate (list(72))
    n = 0
    call add_text('case', 'name', c%name, '', 'names the column file')
    call add_text('case', 'title', c%title, '', 'one line, copied to the header')
    call add_real('wheelset', 'mass', c%mass, 1.0_dp, 1e6_dp, 'kg', '')
    call add_real('wheelset', 'roll_inertia', c%roll_inertia, 1.0_dp, 1e6_dp, 'kg m2', '')
    call add_real('wheelset', 'pitch_inertia', c%pitch_inertia, 0.0_dp, 1e6_dp, 'kg m2', &
      'gyroscopic reaction only')
    call add_real('wheelset', 'rolling_radius', c%rolling_radius, 0.05_dp, 2.0_dp, 'm', &
      'at the contact point of the centred wheelset')
    call add_real('wheelset', 'back_to_back', c%back_to_back, 0.3_dp, 3.0_dp, 'm', '')
    call add_real('wheelset', 'vertical_load', c%vertical_load, 0.0_dp, 1e7_dp, 'N', &
      'constant, without inertia, at the centre of gravity')
    call add_real('track', 'gauge', c%gauge, 0.3_dp, 3.0_dp, 'm', '')
    call add_real('track', 'gauge_depth', c%gauge_depth, 1e-3_dp, 0.05_dp, 'm', &
      'below top of rail, where the gauge is measured')
    call add_real('track', 'friction', c%friction, 0.0_dp, 1e-7_dp, '1', 'is taken as exactly zero')
    call add_real('material', 'youngs_modulus', c%youngs_modulus, 1e6_dp, 1e13_dp, 'Pa', '')
    call add_real('material', 'poisson', c%poisson, 0.0_dp, 0.499_dp, '1', '')
    call add_real('material', 'shear_modulus', c%shear_modulus, 1e6_dp, 1e13_dp, 'Pa', &
      'recorded; normal contact needs E and nu')
    call add_text('profiles', 'wheel_profile', c%wheel_profile, '', 'file of y, z, MiniProf or SIMPACK')
    call add_text('profiles', 'rail_profile', c%rail_profile, '', 'file of y, z, MiniProf or SIMPACK')
    call add_text('profiles', 'wheel_profile_right', c%wheel_profile_right, '', 'of the right wheel; as the left one if not named')
    call add_text('profiles', 'rail_profile_right', c%rail_profile_right, '', 'the same of the right rail')
    call add_real('profiles', 'smoothing_mm', c%smoothing_mm, 0.0_dp, 1.0_dp, 'mm', &
      'rms distance of the smoothing spline, the points'' noise; 0 interpolates')
    call add_text('profiles', 'wheel_flip', c%wheel_flip, 'auto none y z yz', &
      'axes of the files to turn over, left and right; auto: by the shape')
    call add_text('profiles', 'wheel_unit', c%wheel_unit, 'auto mm m in', 'of the files, left and right; auto: by the width')
    call add_text('profiles', 'rail_flip', c%rail_flip, 'auto none y z yz', 'the same of the rails'' files')
    call add_text('profiles', 'rail_unit', c%rail_unit, 'auto mm m in', '')
    call add_real('initial', 'Y', c%y, -0.05_dp, 0.05_dp, 'm', 'lateral, left positive')
    call add_real('initial', 'Z', c%z, -0.05_dp, 0.05_dp, 'm', 'vertical, from static equilibrium')
    call add_real('initial', 'roll', c%roll, -0.3_dp, 0.3_dp, 'rad', 'positive lifts the left wheel')
    call add_real('initial', 'pitch', c%pitch, -1e3_dp, 1e3_dp, 'rad', '')
    call add_real('initial', 'vX', c%vx, -100.0_dp, 100.0_dp, 'm/s', 'constant')
    call add_real('initial', 'vY', c%vy, -20.0_dp, 20.0_dp, 'm/s', '')
    call add_real('initial', 'vZ', c%vz, -20.0_dp, 20.0_dp, 'm/s', '')
    call add_real('initial', 'roll_rate', c%roll_rate, -20.0_dp, 20.0_dp, 'rad/s', '')
    call add_real('initial', 'pitch_rate', c%pitch_rate, -1e3_dp, 1e3_dp, 'rad/s', '')
    call add_real('loading', 'lateral_force', c%lateral_force, -1e7_dp, 1e7_dp, 'N', &
      'at the centre of gravity, track frame, at t = 0')
    call add_real('loading', 'lateral_ramp', c%lateral_ramp, -1e9_dp, 1e9_dp, 'N/s', 'its growth')
    call add_text('contact', 'formulation', c%formulation, 'elastic bilateral unilateral', &
      'rigid: held on the rails, or only pushed')
    call add_real('contact', 'restitution', c%restitution, 0.0_dp, 1.0_dp, '1', &
      'of impacts, with formulation = ''unilateral''')
    call add_text('contact', 'model', c%model, 'halfspace strip hertz', 'elastic normal force')
    call add_real('contact', 'split_angle', c%split_angle, 0.03_dp, 1.2_dp, 'rad', &
      'tangent angle that parts tread and flange')
    call add_real('contact', 'stiffness_scale', c%stiffness_scale, 1e-4_dp, 1e8_dp, '1', &
      'multiplies the elastic modulus')
    call add_text('table', 'file', c%table_file, '', 'keep the contact table here and find it again')
    call add_real('table', 'lateral', c%lateral, 0.02_dp, 0.1_dp, 'm', 'shift of a wheel to either side')
    call add_real('table', 'lift', c%lift, 0.03_dp, 0.1_dp, 'm', 'of a wheel; higher it cannot touch')
    call add_real('table', 'drop', c%drop, 1e-3_dp, 0.03_dp, 'm', 'of a wheel below its running height')
    call add_real('table', 'roll', c%roll_range, 0.01_dp, 0.6_dp, 'rad', 'to either side')
    call add_real('table', 'depth', c%depth, 1e-6_dp, 1e-2_dp, 'm', 'largest penetration')
    call add_real('table', 'accuracy', c%accuracy, 1e-6_dp, 1.0_dp, '', 'error of a wheel''s force allowed, of max(|F|, 5 kN)')
    call add_integer('table', 'n_lateral', c%n_lateral, 20, 10000, 'points across, at most, per zone')
    call add_integer('table', 'n_roll', c%n_roll, 5, 1000, 'points over roll, at most')
    call add_integer('table', 'n_depth', c%n_depth, 5, 1000, 'points over the root of the penetration, at most')
    call add_text('integrator', 'scheme', c%scheme, 'newmark energy', '')
    call add_integer('integrator', 'order', c%order, 2, 6, '2; 4, or 6 if explicit, by composition')
    call add_real('integrator', 'beta', c%beta, 0.0_dp, 0.5_dp, '1', 'Newmark; 0 is explicit')
    call add_real('integrator', 'gamma', c%gamma, 0.5_dp, 1.0_dp, '1', 'Newmark')
    call add_real('integrator', 'dt', c%dt, 1e-9_dp, 1e-2_dp, 's', 'step, at most; rows are whole steps apart')
    call add_real('integrator', 't_end', c%t_end, 1e-9_dp, 1e5_dp, 's', '')
    call add_text('integrator', 'stop_at', c%stop_at, 't_end return_to_centre derailment', &
      'runs end, too, where the derailed leave &table')
    call add_real('integrator', 'energy_tolerance', c%energy_tolerance, 0.0_dp, 1e9_dp, 'J', &
      'a step that changes the total energy by more is cut; 0: none is')
    call add_real('integrator', 'tolerance', c%tolerance, 1e-16_dp, 1e-6_dp, 'm, rad', &
      'of the last Newton correction')
    call add_integer('integrator', 'max_iterations', c%max_iterations, 1, 1000, 'of Newton, per step')
    call add_integer('integrator', 'max_halvings', c%max_halvings, 0, 30, 'of a step that is cut')
    call add_text('output', 'file', c%output_file, '', 'columns; default outputs/<name>.txt')
    call add_real('output', 'interval', c%interval, 1e-9_dp, 1e3_dp, 's', 'between rows')
    call add_text('output', 'rows', c%rows, 'interval_and_events interval', &
      'equidistant; at events and peaks, too')
    call add_text('output', 'geometry_file', c%geometry_file, '', 'geometry functions, if named')
    list = list(:n)

  contains

    subroutine add(group, name, unit, meaning)
      character(*), intent(in) :: group, name, unit, meaning

      n = n + 1
      list(n)%group = group
      list(n)%name = name
      list(n)%unit = unit
      list(n)%meaning = meaning
      list(n)%words = ''
    end subroutine add

    subroutine add_real(group, name, x, least, largest, unit, meaning)
      character(*), intent(in) :: group, name, unit, meaning
      real(dp), target, intent(inout) :: x
      real(dp), intent(in) :: least, largest

      call add(group, name, unit, meaning)
      list(n)%x => x
      list(n)%least = least
      list(n)%largest = largest
    end subroutine add_real

    subroutine add_integer(group, name, i, least, largest, meaning)
      character(*), intent(in) :: group, name, meaning
      integer, target, intent(inout) :: i
      integer, intent(in) :: least, largest

      call add(group, name, '1', meaning)
      list(n)%i => i
      list(n)%least = least
      list(n)%largest = largest
    end subroutine add_integer

    subroutine add_text(group, name, word, words, meaning)
      character(*), intent(in) :: group, name, words, meaning
      character(text_length), target, intent(inout) :: word

      call add(group, name, '', meaning)
      list(n)%text => word
      list(n)%words = words
    end subroutine add_text

  end subroutine list_variables

  !> The value of a variable as it would stand in a namelist.
  function value_text(variable) result(word)
    type(variable_type), intent(in) :: variable
    character(2*text_length + 2) :: word
    integer :: i, n

    if (associated(variable%x)) then
      word = str(variable%x)
    else if (associated(variable%i)) then
      word = str(variable%i)
    else
      word = "'"
      n = 1
      do i = 1, len_trim(variable%text)
        n = n + 1
        word(n:n) = variable%text(i:i)
        if (variable%text(i:i) == "'") n = n + 1
        word(n:n) = variable%text(i:i)
      end do
      word(n + 1:) = "'"
    end if
  end function value_text

  !> What a variable admits, in words.
  function range_text(variable) result(words)
    type(variable_type), intent(in) :: variable
    character(text_length) :: words

    if (associated(variable%x)) then
      words = 'a number from '//str(variable%least)//' to '//str(variable%largest)//' '//variable%unit
    else if (associated(variable%i)) then
      words = 'a whole number from '//str(nint(variable%least))//' to '//str(nint(variable%largest))
    else if (len(variable%words) > 0) then
      words = 'one of '//variable%words
    else
      words = 'a text in quotes of at most '//str(text_length)//' printable bytes'
    end if
  end function range_text

  !> Set variables from the lines of a namelist file.  Groups in any order, each at
  !> most once; comments after `!`.  Anything that is not understood is an error
  !> that names file, line, group and variable and quotes the line.
  subroutine read_case(file, lines, c, error)
    character(*), intent(in) :: file               !! for messages
    type(line_type), intent(in) :: lines(:)
    type(case_type), target, intent(inout) :: c
    type(error_type), allocatable, intent(out) :: error
    type(variable_type), allocatable :: list(:)
    logical, allocatable :: seen(:)
    character(:), allocatable :: word, shown, group, name, names, groups_seen
    integer :: line, column, kind, k
    integer, parameter :: nothing = 0, plain = 1, quoted = 2, mark = 3   ! kinds of words

    call list_variables(c, list)
    allocate (seen(size(list)))
    seen = .false.
    groups_seen = ' '
    group = ''
    line = 1
    column = 1
    do
      call next()
      if (allocated(error)) return
      if (kind == nothing) exit
      if (group == '') then
        if (kind /= plain .or. index(word, '&') /= 1) then
          call fail('', 'expected a group such as &wheelset', shown)
          return
        end if
        group = lower(word(2:))
        if (.not. any([(list(k)%group == group, k=1, size(list))])) then
          call list_groups(names)
          call fail('', 'expected one of'//names, word)
          return
        end if
        if (index(groups_seen, ' '//group//' ') > 0) then
          call fail('', 'expected each group once', 'a second '//word)
          return
        end if
        groups_seen = groups_seen//group//' '
        cycle
      end if
      if (kind == mark .and. word == '/') then
        group = ''
        cycle
      end if
      if (kind == mark .and. word == ',') cycle

      name = word
      do k = size(list), 1, -1
        if (list(k)%group == group .and. lower(list(k)%name) == lower(name)) exit
      end do
      if (kind /= plain .or. k == 0) then
        call list_names(names)
        call fail('', 'expected one of'//names, name)
        return
      end if
      if (seen(k)) then
        call fail(name, 'expected once', 'a second time')
        return
      end if
      seen(k) = .true.
      call next()
      if (allocated(error)) return
      if (kind /= mark .or. word /= '=') then
        call fail(name, 'expected =', shown)
        return
      end if
      call next()
      if (allocated(error)) return
      call set_value(list(k))
      if (allocated(error)) return
    end do
    if (group /= '') then
      call fatal_error(error, file//', &'//group//': expected / at the end of the group, found the end of the file')
    else if (len_trim(groups_seen) == 0) then
      call fatal_error(error, file//': expected namelist groups such as &case, found nothing')
    end if

  contains

    !> The next word: plain text, a quoted text, or one of = , /.
    subroutine next()
      integer :: from, length

      kind = nothing
      word = ''
      shown = 'the end of the file'
      do
        if (line > size(lines)) return
        if (column > len(lines(line)%text)) then
          line = line + 1
          column = 1
        else if (lines(line)%text(column:column) == '!') then
          column = len(lines(line)%text) + 1
        else if (lines(line)%text(column:column) == ' ') then
          column = column + 1
        else
          exit
        end if
      end do
      associate (t => lines(line)%text)
        from = column
        if (scan(t(from:from), '=,/') == 1) then
          kind = mark
          word = t(from:from)
          column = from + 1
        else if (scan(t(from:from), '''"') == 1) then
          kind = quoted
          do
            length = index(t(column + 1:), t(from:from)) - 1
            if (length < 0) then
              call fail('', 'expected a closing quote', t(from:))
              return
            end if
            word = word//t(column + 1:column + length)
            column = column + length + 2
            ! Two quotes are one that belongs to the text.
            if (index(t(column:), t(from:from)) /= 1) exit
            word = word//t(from:from)
          end do
        else
          kind = plain
          column = scan(t(from:), ' =,/!''"')
          if (column == 0) column = len(t) - from + 2
          column = from + column - 1
          word = t(from:column - 1)
        end if
        shown = t(from:column - 1)
      end associate
    end subroutine next

    subroutine set_value(variable)
      type(variable_type), intent(inout) :: variable
      real(dp) :: x
      logical :: ok

      if (associated(variable%text)) then
        ok = kind == quoted .and. len(word) <= text_length
        if (ok) variable%text = word
      else
        ok = .false.
        if (kind == plain) call to_real(word, x, ok)
        if (ok .and. associated(variable%i)) ok = abs(x) < 1e9_dp .and. abs(x - anint(x)) <= 0
        if (ok .and. associated(variable%i)) variable%i = nint(x)
        if (ok .and. associated(variable%x)) variable%x = x
      end if
      if (ok) ok = admissible(variable)
      if (.not. ok) call fail(variable%name, 'expected '//trim(range_text(variable)), shown)
    end subroutine set_value

    subroutine fail(name, expected, found)
      character(*), intent(in) :: name, expected, found
      character(:), allocatable :: place, quote
      integer :: at

      at = min(line, size(lines))
      quote = trim(adjustl(lines(at)%text))
      place = file//', line '//str(at)
      if (group /= '') place = place//', &'//group
      if (name /= '') place = place//' '//name
      call fatal_error(error, place//': '//expected//', found '//clip(found)//'  ['//clip(quote)//']')
    end subroutine fail

    subroutine list_groups(names)
      character(:), allocatable, intent(out) :: names
      integer :: j

      names = ''
      do j = 1, size(list)
        if (index(names//' ', ' &'//list(j)%group//' ') == 0) names = names//' &'//list(j)%group
      end do
    end subroutine list_groups

    subroutine list_names(names)
      character(:), allocatable, intent(out) :: names
      integer :: j

      names = ''
      do j = 1, size(list)
        if (list(j)%group == group) names = names//' '//list(j)%name
      end do
    end subroutine list_names

  end subroutine read_case

  pure logical function admissible(variable)
    type(variable_type), intent(in) :: variable
    integer :: k

    if (associated(variable%x)) then
      admissible = variable%x >= variable%least .and. variable%x <= variable%largest
    else if (associated(variable%i)) then
      admissible = variable%i >= variable%least .and. variable%i <= variable%largest
    else
      ! Bytes beyond ASCII are letters of other alphabets.
      admissible = all([(iachar(variable%text(k:k)) >= 32 .and. iachar(variable%text(k:k)) /= 127, k=1, text_length)])
      if (admissible .and. len(variable%words) > 0) &
        admissible = index(' '//variable%words//' ', ' '//trim(variable%text)//' ') > 0 &
        .and. len_trim(variable%text) > 0 .and. index(trim(variable%text), ' ') == 0
    end if
  end function admissible

  !> Every range again (a case need not come from a file), and what several
  !> variables must satisfy together.
  subroutine check_case(file, c, error)
    character(*), intent(in) :: file
    type(case_type), target, intent(inout) :: c
    type(error_type), allocatable, intent(out) :: error
    type(variable_type), allocatable :: list(:)
    integer :: k

    call list_variables(c, list)
    do k = 1, size(list)
      if (admissible(list(k))) cycle
      call fatal_error(error, file//', &'//list(k)%group//' '//list(k)%name//': expected '// &
        trim(range_text(list(k)))//', found '//value_text(list(k)))
      return
    end do
    if (len_trim(c%name) == 0 .or. scan(trim(c%name), '/ ') > 0) then
      call fatal_error(error, file//", &case name: expected a word that can name a file, found '"// &
        trim(c%name)//"'")
    else if (all(c%order /= [2, 4, 6])) then
      call fatal_error(error, file//', &integrator order: expected 2, 4 or 6, found '//str(c%order))
    else if (c%order == 6 .and. .not. (c%scheme == 'newmark' .and. c%beta <= 0)) then
      call fatal_error(error, file//', &integrator order: expected 2 or 4 unless scheme = ''newmark'' with beta = 0, found 6')
    else if (c%scheme == 'newmark' .and. c%order > 2 .and. c%gamma > 0.5_dp) then
      call fatal_error(error, file//', &integrator gamma: expected 0.5 with order = '//str(c%order)//', found '//str(c%gamma))
    else if (c%formulation /= 'unilateral' .and. c%restitution < 1) then
      call fatal_error(error, file//', &contact restitution: expected 1, for only formulation = ''unilateral'''// &
        ' has impacts, found '//str(c%restitution)//' with '''//trim(c%formulation)//'''')
    else if (c%formulation /= 'elastic' .and. abs(c%stiffness_scale - 1) > 0) then
      call fatal_error(error, file//', &contact stiffness_scale: expected 1, for contacts are rigid with'// &
        ' formulation = '''//trim(c%formulation)//''', found '//str(c%stiffness_scale))
    else if (c%interval < c%dt) then
      call fatal_error(error, file//', &output interval: expected at least the step &integrator dt = '// &
        str(c%dt)//' s, found '//str(c%interval))
    else if (c%interval/c%dt > 1e9_dp) then
      call fatal_error(error, file//', &integrator dt: expected at most 1e9 steps between rows, found '// &
        str(c%interval/c%dt))
    else if (c%interval > c%t_end) then
      call fatal_error(error, file//', &output interval: expected at most &integrator t_end = '// &
        str(c%t_end)//' s, found '//str(c%interval))
    else if (c%t_end/c%interval > 1e7_dp) then
      call fatal_error(error, file//', &output interval: expected at most 1e7 rows up to t_end, found '// &
        str(c%t_end/c%interval))
    else
      call check_files(file, c, error)
    end if
  end subroutine check_case

  !> A file that is written must not be another file of the case.
  subroutine check_files(file, c, error)
    character(*), intent(in) :: file
    type(case_type), intent(in) :: c
    type(error_type), allocatable, intent(out) :: error
    character(48), parameter :: names(9) = [character(48) :: 'the namelist itself', '&profiles wheel_profile', &
      '&profiles rail_profile', '&profiles wheel_profile_right', '&profiles rail_profile_right', '&table file', &
      '&table file of the right side', '&output file', '&output geometry_file']
    integer, parameter :: first_written = 6
    character(max(len(file), text_length + 12)) :: paths(size(names))     ! the default output path adds 12 characters
    integer :: i, j

    paths = [character(len(paths)) :: file, c%wheel_profile, c%rail_profile, c%wheel_profile_right, &
      c%rail_profile_right, c%table_file, right_table_path(c), output_path(c), c%geometry_file]
    if (file == 'standard input') paths(1) = '-'
    do i = first_written, size(names)
      if (paths(i) == '') cycle
      do j = 1, i - 1
        if (paths(j) == '') cycle
        if (.not. same_file(trim(paths(i)), trim(paths(j)))) cycle
        call fatal_error(error, file//', '//trim(names(i))//': expected a file of its own, found '// &
          trim(paths(i))//', which is '//trim(names(j)))
        return
      end do
    end do
  end subroutine check_files

  !> Where the contact table of the right side is kept, if its profiles may differ from the left ones.
  function right_table_path(c) result(path)
    type(case_type), intent(in) :: c
    character(len_trim(c%table_file) + 6) :: path

    path = ''
    if (c%table_file /= '' .and. (c%wheel_profile_right /= '' .or. c%rail_profile_right /= '')) &
      path = trim(c%table_file)//'.right'
  end function right_table_path

  !> Where the columns go, padded with blanks.
  function output_path(c) result(path)
    type(case_type), intent(in) :: c
    character(text_length + 12) :: path

    path = c%output_file
    if (path == '') path = default_folder//'/'//trim(c%name)//'.txt'
  end function output_path

end module case