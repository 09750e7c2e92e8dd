!> A case: everything that a namelist file says.
!>
!> `list_variables` lists all namelist variables with group, name, admissible range, unit and meaning. Reading, checking, the
!> header of the column files and `--help` use this list. Defaults are the values of the call or, where it has none, plain ones.
!> They stand in the declaration of `case_type`; the default extent of the contact table stands in `contact_law`.
module case
  use contact_zones, only: usual_flange_angle
  use kinds, only: dp
  use contact_law, only: extent_type, floored_force
  use places, only: places_type
  use system, only: default_folder, last_slash
  use text, only: shortest, str, to_real
  implicit none
  private
  public :: case_type, variable_type, list_variables, admissible, case_title, output_path, value_text, range_text, text_length
  public :: inclinations, is_default, to_angle

  integer, parameter :: text_length = 256
  real(dp), parameter :: most_inclined = 0.12_dp     !! of a rail, beyond its file: twice that of any track [rad]

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
    real(dp) :: rail_inclination = 0
    character(text_length) :: rail_inclination_right = ''
    ! &material
    real(dp) :: youngs_modulus = 210e9_dp
    real(dp) :: poisson = 0.28_dp
    real(dp) :: shear_modulus = 82e9_dp
    ! &profiles
    character(text_length) :: wheel_profile = 'profiles/awprof.yz'
    character(text_length) :: rail_profile = 'profiles/arprof.yz'
    character(text_length) :: wheel_profile_right = '', rail_profile_right = ''
    ! &initial
    real(dp) :: y = 0, z = 0, roll = 0, pitch = 0
    real(dp) :: vx = 1, vy = 0, vz = 0, roll_rate = 0, pitch_rate = 2.19_dp
    character(text_length) :: roll_link = 'none'
    ! &loading
    real(dp) :: lateral_force = 0
    real(dp) :: lateral_ramp = 0
    ! &contact
    character(text_length) :: formulation = 'elastic'
    real(dp) :: restitution = 1
    character(text_length) :: model = 'halfspace'
    real(dp) :: flange_angle = usual_flange_angle
    character(text_length) :: influence = 'local'
    character(text_length) :: bodies = ''
    real(dp) :: stiffness_scale = 1
    ! &table
    character(text_length) :: table_folder = ''
    type(extent_type) :: extent
    real(dp) :: accuracy = 2e-3_dp
    ! &integrator
    integer :: order = 4
    real(dp) :: beta = 0, gamma = 0.5_dp
    real(dp) :: dt = 1e-4_dp
    real(dp) :: t_end = 1
    character(text_length) :: stop_at = 't_end'
    real(dp) :: error_tolerance = 1e-10_dp
    real(dp) :: energy_tolerance = 1e-9_dp
    real(dp) :: tolerance = 1e-10_dp
    integer :: max_iterations = 12
    integer :: max_halvings = 20
    ! &output
    character(text_length) :: output_file = ''
    real(dp) :: interval = 1e-4_dp
    character(text_length) :: rows = 'interval_and_events'
    character(text_length) :: pressures = 'yes', judged = 'yes'
    ! No variables: where the files of the case are looked for.
    type(places_type) :: places
  end type case_type

  !> One namelist variable; exactly one of the pointers is set.
  type :: variable_type
    character(:), allocatable :: group, name
    real(dp), pointer :: x => null()
    integer, pointer :: i => null()
    character(text_length), pointer :: text => null()
    real(dp) :: least = 0, largest = 0     !! admissible range of a number
    character(:), allocatable :: words     !! admissible words, separated by blanks; empty: any text
    !> The value may be 1:n in words, and a header has it only where it is not the default. A text may be a number.
    logical :: slope = .false.
    character(:), allocatable :: unit, meaning
  end type variable_type

  type :: variable_list
    integer :: n = 0
    type(variable_type) :: list(80)        !! the variables; the first n are set
  contains
    procedure, private :: add_real, add_integer, add_text
    procedure, private :: mark_slope
    generic :: add => add_real, add_integer, add_text
  end type variable_list

contains

  !> The list of all variables, pointing into `c`.
  subroutine list_variables(c, list)
    type(case_type), target, intent(inout) :: c
    type(variable_type), allocatable, intent(out) :: list(:)
    type(variable_list) :: all

    call all%add('case', 'name', c%name, '', 'name of the case and, by default, of the column file')
    call all%add('case', 'title', c%title, '', 'one line that header and plots repeat; made from the values if empty')
    call all%add('wheelset', 'mass', c%mass, 1.0_dp, 1e6_dp, 'kg', 'mass of the wheelset')
    call all%add('wheelset', 'roll_inertia', c%roll_inertia, 1e-4_dp, 1e6_dp, 'kg m2', &
      'moment of inertia about the longitudinal axis')
    call all%add('wheelset', 'pitch_inertia', c%pitch_inertia, 0.0_dp, 1e6_dp, 'kg m2', &
      'moment of inertia about the axle; it enters the gyroscopic moment only')
    call all%add('wheelset', 'rolling_radius', c%rolling_radius, 0.03_dp, 2.0_dp, 'm', &
      'rolling radius at the contact point of the centred wheelset')
    call all%add('wheelset', 'back_to_back', c%back_to_back, 0.1_dp, 3.0_dp, 'm', 'distance between the backs of the wheels')
    call all%add('wheelset', 'vertical_load', c%vertical_load, 0.0_dp, 1e7_dp, 'N', &
      'constant vertical load at the centre of gravity, without inertia')
    call all%add('track', 'gauge', c%gauge, 0.1_dp, 3.0_dp, 'm', 'track gauge')
    call all%add('track', 'gauge_depth', c%gauge_depth, 1e-3_dp, 0.05_dp, 'm', &
      'depth below the top of the rails at which the gauge is measured')
    call all%add('track', 'friction', c%friction, 0.0_dp, 1e-7_dp, '1', 'friction coefficient; it is taken as exactly zero')
    call all%add('track', 'rail_inclination', c%rail_inclination, -most_inclined, most_inclined, 'rad', &
      'angle by which the rails lean to the track''s centre beyond their files; a slope such as 1:40 may stand for it')
    call all%mark_slope()
    call all%add('track', 'rail_inclination_right', c%rail_inclination_right, '', &
      'this angle of the right rail alone; the empty text means as on the left')
    call all%mark_slope(most_inclined)
    call all%add('material', 'youngs_modulus', c%youngs_modulus, 1e6_dp, 1e13_dp, 'Pa', 'Young''s modulus of wheels and rails')
    call all%add('material', 'poisson', c%poisson, 0.0_dp, 0.499_dp, '1', 'Poisson''s ratio of wheels and rails')
    call all%add('material', 'shear_modulus', c%shear_modulus, 1e6_dp, 1e13_dp, 'Pa', &
      'shear modulus; it is recorded but not used, normal contact needs E and nu')
    call all%add('profiles', 'wheel_profile', c%wheel_profile, '', &
      'wheel profile: a file of y z points in mm; Python takes other formats, too')
    call all%add('profiles', 'rail_profile', c%rail_profile, '', &
      'rail profile: a file of y z points in mm; Python takes other formats, too')
    call all%add('profiles', 'wheel_profile_right', c%wheel_profile_right, '', &
      'wheel profile on the right; the empty name means as on the left')
    call all%add('profiles', 'rail_profile_right', c%rail_profile_right, '', &
      'rail profile on the right; the empty name means as on the left')
    call all%add('initial', 'Y', c%y, -0.05_dp, 0.05_dp, 'm', 'initial lateral displacement, positive to the left')
    call all%add('initial', 'Z', c%z, -0.05_dp, 0.05_dp, 'm', &
      'initial vertical displacement from static equilibrium, positive upwards')
    call all%add('initial', 'roll', c%roll, -0.3_dp, 0.3_dp, 'rad', 'initial roll angle; a positive one lifts the left wheel')
    call all%add('initial', 'pitch', c%pitch, -1e3_dp, 1e3_dp, 'rad', 'initial pitch angle')
    call all%add('initial', 'vX', c%vx, -100.0_dp, 100.0_dp, 'm/s', 'forward velocity, constant')
    call all%add('initial', 'vY', c%vy, -20.0_dp, 20.0_dp, 'm/s', 'initial lateral velocity')
    call all%add('initial', 'vZ', c%vz, -20.0_dp, 20.0_dp, 'm/s', 'initial vertical velocity')
    call all%add('initial', 'roll_rate', c%roll_rate, -20.0_dp, 20.0_dp, 'rad/s', 'initial roll rate')
    call all%add('initial', 'roll_link', c%roll_link, 'none rails', &
      'what sets the initial roll rate: roll_rate (none), or vY, so that both wheels move along their rails (rails)')
    call all%add('initial', 'pitch_rate', c%pitch_rate, -1e3_dp, 1e3_dp, 'rad/s', 'pitch rate, constant')
    call all%add('loading', 'lateral_force', c%lateral_force, -1e7_dp, 1e7_dp, 'N', &
      'lateral force at the centre of gravity at t = 0, in the track frame')
    call all%add('loading', 'lateral_ramp', c%lateral_ramp, -1e9_dp, 1e9_dp, 'N/s', 'growth rate of the lateral force')
    call all%add('contact', 'formulation', c%formulation, 'elastic bilateral unilateral', &
      'elastic contact, or rigid: wheels held on the rails (bilateral) or contacts that only push (unilateral)')
    call all%add('contact', 'restitution', c%restitution, 0.0_dp, 1.0_dp, '1', &
      'coefficient of restitution of impacts with formulation = ''unilateral''')
    call all%add('contact', 'model', c%model, 'halfspace strip hertz', 'law of the elastic normal force')
    call all%add('contact', 'influence', c%influence, 'local flat apart bodies', &
      'loads (halfspace) act along their normals (local), as on a plane (flat), in their zone (apart), or on bodies (bodies)')
    call all%add('contact', 'bodies', c%bodies, '', &
      'file that says what wheel and rail differ by from half-spaces, with influence = ''bodies''')
    call all%add('contact', 'flange_angle', c%flange_angle, 0.1_dp, 1.2_dp, 'rad', &
      'angle from which points of the wheel belong to the flange; less steep ones belong to the tread')
    call all%add('contact', 'stiffness_scale', c%stiffness_scale, 1e-4_dp, 1e8_dp, '1', 'factor on the elastic modulus')
    call all%add('table', 'folder', c%table_folder, '', &
      'folder that keeps what was solved of contact tables for later runs; the empty name keeps nothing')
    call all%add('table', 'lateral', c%extent%lateral, 0.02_dp, 0.1_dp, 'm', &
      'the table covers this shift of a wheel to either side')
    call all%add('table', 'lift', c%extent%lift, 0.03_dp, 0.1_dp, 'm', &
      'the table covers this lift of a wheel; higher it cannot touch')
    call all%add('table', 'drop', c%extent%drop, 1e-3_dp, 0.03_dp, 'm', &
      'the table covers this drop of a wheel below its running height')
    call all%add('table', 'roll', c%extent%roll, 0.01_dp, 0.6_dp, 'rad', 'the table covers this roll to either side')
    call all%add('table', 'depth', c%extent%depth, 1e-6_dp, 1e-2_dp, 'm', 'the table covers this penetration')
    call all%add('table', 'accuracy', c%accuracy, 1e-6_dp, 1.0_dp, '', &
      'rms error asked for of a wheel''s force on the tread, on the flange and on both at once, relative to '//floored_force)
    call all%add('integrator', 'order', c%order, 2, 4, &
      'order of the steps: 2 (Newmark) or 4 (explicit)')
    call all%add('integrator', 'beta', c%beta, 0.0_dp, 0.5_dp, '1', &
      'beta of Newmark''s method; 0 is explicit, as order = 4 is')
    call all%add('integrator', 'gamma', c%gamma, 0.5_dp, 1.0_dp, '1', 'gamma of Newmark''s method')
    call all%add('integrator', 'dt', c%dt, 1e-9_dp, 1e-2_dp, 's', &
      'longest step; the interval between rows is a whole number of steps')
    call all%add('integrator', 't_end', c%t_end, 1e-9_dp, 1e5_dp, 's', 'end of the run, at the latest')
    call all%add('integrator', 'stop_at', c%stop_at, 't_end return_to_centre derailment', &
      'what ends the run; a derailed wheelset that leaves &table ends it too')
    call all%add('integrator', 'error_tolerance', c%error_tolerance, 0.0_dp, 1.0_dp, 'm', &
      'a step whose estimated error of the position is larger is cut; 0 cuts no step')
    call all%add('integrator', 'energy_tolerance', c%energy_tolerance, 0.0_dp, 1e9_dp, 'J', &
      'a step that changes the total energy by more is cut; 0 cuts no step')
    call all%add('integrator', 'tolerance', c%tolerance, 1e-16_dp, 1e-6_dp, 'm, rad', 'largest Newton correction at convergence')
    call all%add('integrator', 'max_iterations', c%max_iterations, 1, 1000, 'most Newton iterations per step')
    call all%add('integrator', 'max_halvings', c%max_halvings, 0, 30, 'most halvings of a step that is cut')
    call all%add('output', 'file', c%output_file, '', 'column file; outputs/NAME.txt if empty')
    call all%add('output', 'interval', c%interval, 1e-9_dp, 1e3_dp, 's', 'time between rows')
    call all%add('output', 'rows', c%rows, 'interval_and_events contacts interval', &
      'rows at equal intervals, also at events and peaks of force, and also close to each other in every contact')
    call all%add('output', 'pressures', c%pressures, 'yes no', &
      'whether the results have the largest pressure and the pressures of flanges, of the model halfspace')
    call all%add('output', 'judged', c%judged, 'yes no', &
      'whether the results have the error of the contact forces, against direct solutions in poses of the run')
    list = all%list(:all%n)
  end subroutine list_variables

  subroutine add_real(this, group, name, x, least, largest, unit, meaning)
    class(variable_list), intent(inout) :: this
    character(*), intent(in) :: group, name, unit, meaning
    real(dp), target, intent(inout) :: x
    real(dp), intent(in) :: least, largest

    this%n = this%n + 1
    this%list(this%n) = variable_type(group, name, x=x, least=least, largest=largest, words='', unit=unit, meaning=meaning)
  end subroutine add_real

  subroutine add_integer(this, group, name, i, least, largest, meaning)
    class(variable_list), intent(inout) :: this
    character(*), intent(in) :: group, name, meaning
    integer, target, intent(inout) :: i
    integer, intent(in) :: least, largest

    this%n = this%n + 1
    this%list(this%n) = variable_type(group, name, i=i, least=least, largest=largest, words='', unit='1', meaning=meaning)
  end subroutine add_integer

  subroutine add_text(this, group, name, word, words, meaning)
    class(variable_list), intent(inout) :: this
    character(*), intent(in) :: group, name, words, meaning
    character(text_length), target, intent(inout) :: word

    this%n = this%n + 1
    this%list(this%n) = variable_type(group, name, text=word, words=words, unit='', meaning=meaning)
  end subroutine add_text

  !> Let the last variable be an angle that may be given as a slope, up to `largest` [rad] where it is a text.
  subroutine mark_slope(this, largest)
    class(variable_list), intent(inout) :: this
    real(dp), intent(in), optional :: largest

    this%list(this%n)%slope = .true.
    if (.not. present(largest)) return
    this%list(this%n)%least = -largest
    this%list(this%n)%largest = largest
    this%list(this%n)%unit = 'rad'
  end subroutine mark_slope

  !> The angle of a word [rad]: a number, or a slope 1:n with a sign before it.
  pure subroutine to_angle(word, angle, ok)
    character(*), intent(in) :: word
    real(dp), intent(out) :: angle
    logical, intent(out) :: ok
    real(dp) :: n
    integer :: from

    from = merge(2, 1, scan(word, '+-') == 1)
    if (index(word(from:), '1:') /= 1) then
      call to_real(word, angle, ok)
      return
    end if
    angle = 0
    call to_real(word(from + 2:), n, ok)
    if (ok) ok = n > 0 .and. scan(word(from + 2:), '+-') /= 1
    if (ok) angle = atan(1/n)
    if (word(1:1) == '-') angle = -angle
  end subroutine to_angle

  !> The angles by which the left and the right rail are turned beyond their files [rad], of a case that was checked.
  pure function inclinations(c) result(angles)
    type(case_type), intent(in) :: c
    real(dp) :: angles(2)
    logical :: ok

    angles = c%rail_inclination
    if (c%rail_inclination_right /= '') call to_angle(trim(c%rail_inclination_right), angles(2), ok)
  end function inclinations

  !> Whether a variable has the value of another one, its default.
  pure logical function is_default(variable, default)
    type(variable_type), intent(in) :: variable, default

    if (associated(variable%x)) then
      is_default = abs(variable%x - default%x) <= 0
    else if (associated(variable%i)) then
      is_default = variable%i == default%i
    else
      is_default = variable%text == default%text
    end if
  end function is_default

  !> The value of a variable as it would stand in a namelist.
  function value_text(variable) result(word)
    type(variable_type), intent(in) :: variable
    character(2*text_length + 2) :: word
    integer :: i, n

    if (associated(variable%x)) then
      word = shortest(variable%x)
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

  !> The admissible values of a variable, in words.
  function range_text(variable) result(words)
    type(variable_type), intent(in) :: variable
    character(text_length) :: words

    if (associated(variable%x)) then
      words = 'a number from '//str(variable%least)//' to '//str(variable%largest)
      if (variable%unit /= '1') words = trim(words)//' '//variable%unit
      if (variable%slope) words = trim(words)//', or 1:n'
    else if (associated(variable%i)) then
      words = 'a whole number from '//str(nint(variable%least))//' to '//str(nint(variable%largest))
    else if (len(variable%words) > 0) then
      words = 'one of '//variable%words
    else if (variable%slope) then
      words = 'a number from '//str(variable%least)//' to '//str(variable%largest)//' '//variable%unit//', 1:n, or the empty text'
    else
      words = 'a text in quotes of at most '//str(text_length)//' printable bytes'
    end if
  end function range_text

  !> Whether the value of a variable is admissible.
  pure logical function admissible(variable)
    type(variable_type), intent(in) :: variable
    real(dp) :: angle
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
      if (admissible .and. variable%slope .and. variable%text /= '') then
        call to_angle(trim(variable%text), angle, admissible)
        if (admissible) admissible = angle >= variable%least .and. angle <= variable%largest
      end if
    end if
  end function admissible

  !> The title of the user, or one made of the quantities that move the wheelset and of the names of the profiles.
  function case_title(c) result(title)
    type(case_type), intent(in) :: c
    character(6*text_length) :: title
    character(2*text_length + 4) :: left, right

    title = c%title
    if (title /= '') return
    call add('initial lateral displacement', c%y, 'm')
    call add('initial vertical displacement', c%z, 'm')
    call add('initial roll angle', c%roll, 'rad')
    call add('initial lateral velocity', c%vy, 'm/s')
    call add('initial vertical velocity', c%vz, 'm/s')
    if (abs(c%vy) <= 0 .and. c%roll_link == 'none') call add('initial roll rate', c%roll_rate, 'rad/s')
    call add('lateral force', c%lateral_force/1e3_dp, 'kN')
    call add('lateral force growing by', c%lateral_ramp/1e3_dp, 'kN/s')
    if (abs(c%lateral_ramp) > 0 .and. c%stop_at == 'derailment') title = trim(title)//' up to derailment'
    if (title == '') title = ', at rest'
    left = pair_words(c%wheel_profile, c%rail_profile)
    right = pair_words(merge(c%wheel_profile_right, c%wheel_profile, c%wheel_profile_right /= ''), &
      merge(c%rail_profile_right, c%rail_profile, c%rail_profile_right /= ''))
    title = trim(title(3:))//', '//left
    if (right /= left) title = trim(title)//' (left), '//trim(right)//' (right)'

  contains

    !> A quantity that is not 0.
    subroutine add(what, x, unit)
      character(*), intent(in) :: what, unit
      real(dp), intent(in) :: x
      character(40) :: number

      number = str(x)
      if (index(number, '.0 ') > 0) number(index(number, '.0 '):) = ''
      if (abs(x) > 0) title = trim(title)//', '//what//' '//trim(number)//' '//unit
    end subroutine add

  end function case_title

  !> The profiles of a side in words, by the names of their files.
  pure function pair_words(wheel, rail) result(words)
    character(*), intent(in) :: wheel, rail
    character(len(wheel) + len(rail) + 4) :: words

    words = trim(wheel(last_slash(wheel) + 1:))//' on '//rail(last_slash(rail) + 1:)
    if (words == 'awprof.yz on arprof.yz') words = 'actual profiles'
    if (words == 'swprof.yz on srprof.yz') words = 'simplified profiles'
  end function pair_words

  !> Path of the column file, padded with blanks.
  function output_path(c) result(path)
    type(case_type), intent(in) :: c
    character(text_length + 12) :: path

    path = c%output_file
    if (path == '') path = default_folder//'/'//trim(c%name)//'.txt'
  end function output_path

end module case