! The interface that f2py reads: plain procedures with numbers, arrays and texts.
! Texts come back in buffers with their length; a message of length 0 means success. The fields of an error follow its message.
! numbers(n) and words (256 characters each) hold a case, in the order of describe_variables.

module flat
  use ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use case, only: case_title, case_type, list_variables, range_text, value_text, variable_type
  use case_check, only: check_case, check_path => check_writable
  use case_reader, only: read_case
  use columns, only: column_type, list_columns, most_columns
  use contact_pressure, only: most_patches, press_contact, pressed_patch
  use contact_table, only: table_type
  use curve, only: curve_frame, curve_type
  use direct_force, only: fine_elements, judge
  use curve_fit, only: interpolate, noise_of => point_noise
  use errors, only: error_type
  use events, only: event_kinds
  use column_files, only: column_file
  use rigid_geometry, only: geometry_at
  use handles
  use kinds, only: version
  use largest_pressure, only: grids
  use motion_state, only: contact_state, motion_type
  use places, only: find_path => find_file, folder_of_tables => kept_folder, places_type
  use profile, only: profile_type, read_profile
  use results, only: result_list
  use run_results, only: results_text => describe_results, setup_text => describe_setup, summary
  use run_setup, only: setup_type
  use station_scan, only: new_scan, scan_type
  use text, only: line_type, read_lines, split_lines
  use upright_rails, only: warn_of_upright
  use wheel_rail_pair, only: mirror
  use elastic_contacts, only: contacts
  implicit none
  public

contains

  !> group, name, kind, default, range, unit, meaning of every namelist variable, one per line, by tabs; then whether headers have
  !> it always or only where it is not the default.
  subroutine describe_variables(listing, length)
    character(32768), intent(out) :: listing
    integer, intent(out) :: length
    character, parameter :: tab = achar(9)
    type(case_type), target :: c
    type(variable_type), allocatable :: list(:)
    character(:), allocatable :: lines, kind
    integer :: k

    call list_variables(c, list)
    lines = ''
    do k = 1, size(list)
      kind = 'text'
      if (associated(list(k)%x)) kind = 'real'
      if (associated(list(k)%i)) kind = 'integer'
      lines = lines//list(k)%group//tab//list(k)%name//tab//kind//tab//trim(value_text(list(k)))//tab// &
        trim(range_text(list(k)))//tab//list(k)%unit//tab//list(k)%meaning// &
        tab//trim(merge('if set', 'always', list(k)%slope))//new_line('a')
    end do
    call give(lines, listing, length)
  end subroutine describe_variables

  !> Names and units of the columns; then the kinds of events, one per line; then the program's version.
  subroutine describe_results(listing, length)
    character(8192), intent(out) :: listing
    integer, intent(out) :: length
    type(case_type) :: c
    type(setup_type) :: setup
    type(motion_type) :: motion
    type(column_type) :: columns(most_columns)
    real(8) :: values(most_columns)
    character(:), allocatable :: lines
    integer :: k, n

    lines = ''
    c%formulation = 'unilateral'         ! which has all columns
    setup%wheelset%mass = c%mass
    setup%wheelset%roll_inertia = c%roll_inertia
    call list_columns(c, setup, motion, 0d0, values, n, columns)
    call add(columns(:n)%name)
    call add(columns(:n)%unit)
    do k = 1, size(event_kinds)
      lines = lines//trim(event_kinds(k))//new_line('a')
    end do
    call give(lines//version, listing, length)

  contains

    subroutine add(words)
      character(*), intent(in) :: words(:)
      integer :: i

      do i = 1, size(words)
        lines = lines//trim(words(i))//' '
      end do
      lines = trim(lines)//new_line('a')
    end subroutine add

  end subroutine describe_results

  !> A namelist file, or (is_text = 1) the text of one that is called `file`, as a case. places: where files are looked for.
  subroutine read_namelist(file, is_text, source, places, n, numbers, words, message, length)
    character(*), intent(in) :: file, source, places
    integer, intent(in) :: is_text
    integer, intent(in) :: n
    real(8), intent(out) :: numbers(n)
    character(32768), intent(out) :: words
    character(16384), intent(out) :: message
    integer, intent(out) :: length
    type(line_type), allocatable :: lines(:)
    type(case_type) :: c
    type(error_type), allocatable :: error

    call import_places(places, c%places)
    if (is_text == 1) then
      call split_lines(source, lines)
    else
      call read_lines(file, lines, error)
    end if
    if (.not. allocated(error)) call read_case(file, lines, c, error)
    if (.not. allocated(error)) call check_case(file, c, error)
    call export_case(c, numbers, words)
    call give_error(error, message, length)
  end subroutine read_namelist

  !> The path of a file that is called `name`.
  subroutine find_file(name, places, path, path_length, message, length)
    character(*), intent(in) :: name, places
    character(16384), intent(out) :: path, message
    integer, intent(out) :: path_length, length
    type(places_type) :: here
    type(error_type), allocatable :: error
    character(:), allocatable :: found

    call import_places(places, here)
    call find_path(here, name, found, error)
    call give(found, path, path_length)
    call give_error(error, message, length)
  end subroutine find_file

  !> The folder that keeps contact tables where a case names this one.
  subroutine kept_folder(named, folder, length)
    character(*), intent(in) :: named
    character(16384), intent(out) :: folder
    integer, intent(out) :: length
    character(:), allocatable :: found

    call folder_of_tables(named, found)
    call give(found, folder, length)
  end subroutine kept_folder

  !> Check the values of a case; `file` is for messages.
  subroutine check_values(file, n, numbers, words, message, length)
    character(*), intent(in) :: file, words
    integer, intent(in) :: n
    real(8), intent(in) :: numbers(n)
    character(16384), intent(out) :: message
    integer, intent(out) :: length
    type(case_type) :: c
    type(error_type), allocatable :: error

    call import_case(numbers, words, c)
    call check_case(file, c, error)
    call give_error(error, message, length)
  end subroutine check_values

  !> The title of a case, the user's or one made from the values.
  subroutine describe_case(n, numbers, words, title, length)
    integer, intent(in) :: n
    real(8), intent(in) :: numbers(n)
    character(*), intent(in) :: words
    character(2048), intent(out) :: title
    integer, intent(out) :: length
    type(case_type) :: c

    call import_case(numbers, words, c)
    call give(trim(case_title(c)), title, length)
  end subroutine describe_case

  !> Profiles, contact table and equilibrium of a case.  paths: those of its wheel_profile, rail_profile,
  !> wheel_profile_right and rail_profile_right, of 256 characters each.
  subroutine prepare_case(n, numbers, words, paths, handle, message, length)
    integer, intent(in) :: n
    real(8), intent(in) :: numbers(n)
    character(*), intent(in) :: words, paths
    integer(8), intent(out) :: handle
    character(16384), intent(out) :: message
    integer, intent(out) :: length
    !f2py threadsafe
    type(prepared_type), pointer :: p
    type(case_type) :: c
    type(error_type), allocatable :: error

    call import_case(numbers, words, c)
    call new_prepared(p, handle)
    call prepare_located(p, c, paths, error)
    if (allocated(error)) call free_prepared_at(handle)
    call give_error(error, message, length)
  end subroutine prepare_case

  !> A case with the contact table of an earlier one.
  subroutine adapt_case(earlier, n, numbers, words, paths, handle, message, length)
    integer(8), intent(in) :: earlier
    integer, intent(in) :: n
    real(8), intent(in) :: numbers(n)
    character(*), intent(in) :: words, paths
    integer(8), intent(out) :: handle
    character(16384), intent(out) :: message
    integer, intent(out) :: length
    !f2py threadsafe
    type(prepared_type), pointer :: p
    type(case_type) :: c
    type(error_type), allocatable :: error

    call import_case(numbers, words, c)
    call new_prepared(p, handle)
    call adapt(p, prepared_at(earlier), c, paths, error)
    if (allocated(error)) call free_prepared_at(handle)
    call give_error(error, message, length)
  end subroutine adapt_case

  subroutine free_prepared(handle)
    integer(8), intent(in) :: handle

    call free_prepared_at(handle)
  end subroutine free_prepared

  !> clearance to the left and to the right, height and roll of the wheelset that is held at the centre, height
  !> of the rigid one [m, rad], y, z, roll in which it rests [m, rad], weight [N], processor time for the preparation
  !> [s]; three eigenfrequencies [Hz], as many as the formulation leaves, then NaN.
  subroutine prepared_numbers(handle, numbers)
    integer(8), intent(in) :: handle
    real(8), intent(out) :: numbers(13)
    type(prepared_type), pointer :: p

    p => prepared_at(handle)
    numbers = [p%setup%side%clearance, p%setup%equilibrium(2:), p%setup%centred(2), p%setup%rest, &
               p%setup%wheelset%weight(), p%setup%seconds, p%setup%frequency]
  end subroutine prepared_numbers

  !> Solutions in the contact table of a side (1 left, 2 right; 0 where the right side shares that of the left), those of them that a file kept, and those that did not converge.
  subroutine table_solutions(handle, side, solutions)
    integer(8), intent(in) :: handle
    integer, intent(in) :: side
    integer, intent(out) :: solutions(3)
    type(prepared_type), pointer :: p
    type(table_type), pointer :: table

    p => prepared_at(handle)
    solutions = 0
    table => p%setup%wheelset%table
    if (side == 2) table => p%setup%wheelset%right_table
    if (side == 2 .and. associated(table, p%setup%wheelset%table)) return
    if (associated(table)) solutions = [table%solutions(1), table%found, table%solutions(2)]
  end subroutine table_solutions

  !> Error of the force on a wheel (1 left, 2 right) at n poses, of max(|F|, 5 kN), and the force without the table [N]; NaN where
  !> its direct solution does not converge.
  subroutine force_errors(handle, side, n, y, z, roll, errors, forces)
    integer(8), intent(in) :: handle
    integer, intent(in) :: side, n
    real(8), intent(in) :: y(n), z(n), roll(n)
    real(8), intent(out) :: errors(n), forces(n)
    !f2py threadsafe
    type(prepared_type), pointer :: p
    type(table_type), pointer :: table
    real(8) :: pose(3)
    logical :: ok, touching(2)
    integer :: i

    p => prepared_at(handle)
    table => p%setup%wheelset%table
    if (side == 2) table => p%setup%wheelset%right_table
    do i = 1, n
      pose = [y(i), z(i), roll(i)]
      if (side == 2) pose = mirror*pose
      call judge(table, fine_elements(table%law), pose, errors(i), forces(i), touching, ok)
      if (.not. ok) errors(i) = ieee_value(1d0, ieee_quiet_nan)
    end do
  end subroutine force_errors

  !> Integrate a prepared case.
  subroutine simulate_case(prepared, progress, stop_asked, handle, message, length)
    integer(8), intent(in) :: prepared
    real(8), intent(inout) :: progress(2)
    integer, intent(inout) :: stop_asked(1)
    integer(8), intent(out) :: handle
    character(16384), intent(out) :: message
    integer, intent(out) :: length
    !f2py threadsafe
    type(finished_type), pointer :: run
    type(error_type), allocatable :: error

    call new_run(run, handle)
    call simulate_watched(prepared_at(prepared), run, progress, stop_asked, error)
    if (allocated(error)) call free_run_at(handle)
    call give_error(error, message, length)
  end subroutine simulate_case

  subroutine free_run(handle)
    integer(8), intent(in) :: handle

    call free_run_at(handle)
  end subroutine free_run

  !> Numbers of columns and rows.
  subroutine run_size(handle, n_columns, n_rows)
    integer(8), intent(in) :: handle
    integer, intent(out) :: n_columns, n_rows
    type(finished_type), pointer :: run

    run => run_at(handle)
    n_columns = size(run%last)
    n_rows = run%rows
  end subroutine run_size

  !> The columns, (column, row).
  subroutine run_columns(handle, n_columns, n_rows, rows)
    integer(8), intent(in) :: handle
    integer, intent(in) :: n_columns, n_rows
    real(8), intent(out) :: rows(n_columns, n_rows)
    !f2py threadsafe
    type(finished_type), pointer :: run

    run => run_at(handle)
    rows = run%kept%values(:, :n_rows)
  end subroutine run_columns

  !> What the comments of a column file say of a run: the lines before the rows, a line with the character FS (28), the
  !> lines after the rows. seconds: processor time of the integration [s].
  subroutine run_comments(prepared, handle, listing, length, seconds)
    integer(8), intent(in) :: prepared, handle
    character(131072), intent(out) :: listing
    integer, intent(out) :: length
    real(8), intent(out) :: seconds
    type(prepared_type), pointer :: p
    type(finished_type), pointer :: run
    character(:), allocatable :: before, after

    p => prepared_at(prepared)
    run => run_at(handle)
    call setup_text(p%c, p%setup, before)
    call results_text(p%c, run%run_type, after)
    call give(before//achar(28)//new_line('a')//after, listing, length)
    seconds = run%seconds
  end subroutine run_comments

  !> The text for the terminal.
  subroutine run_summary(prepared, handle, listing, length)
    integer(8), intent(in) :: prepared, handle
    character(32768), intent(out) :: listing
    integer, intent(out) :: length
    type(prepared_type), pointer :: p
    type(finished_type), pointer :: run
    character(:), allocatable :: lines

    p => prepared_at(prepared)
    run => run_at(handle)
    call summary(p%c, p%setup, run%run_type, lines)
    call give(lines, listing, length)
  end subroutine run_summary

  !> A warning where the contact tables of a run could not be kept.
  subroutine run_unkept(handle, message, length)
    integer(8), intent(in) :: handle
    character(16384), intent(out) :: message
    integer, intent(out) :: length
    type(finished_type), pointer :: run

    run => run_at(handle)
    call give_error(run%warning, message, length)
  end subroutine run_unkept

  !> Write the column file.
  subroutine write_run(prepared, handle, path, kept, kept_length, message, length)
    integer(8), intent(in) :: prepared, handle
    character(*), intent(in) :: path
    character(16384), intent(out) :: kept, message
    integer, intent(out) :: kept_length, length
    !f2py threadsafe
    type(error_type), allocatable :: error
    character(:), allocatable :: name

    call write_finished(prepared_at(prepared), run_at(handle), path, name, error)
    kept = name
    kept_length = len(name)
    call give_error(error, message, length)
  end subroutine write_run

  !> Contact at n poses: axle centre y, z [m], roll [rad], track frame; wheel: 0 both, 1 left, 2 right. m says what: 1 the elastic
  !> energy [J]; 3 the force of the rails on the wheels F_y, F_z [N] and M_x about the axle centre [N m]; 12 this force in each
  !> contact, left tread, left flange, right tread, right flange; 6 the tangent stiffness, the Hessian of the energy: yy, yz,
  !> y roll, zz, z roll, roll roll. status: 0, or how the pose is outside the table.
  subroutine contact_values(handle, wheel, m, n, y, z, roll, values, status)
    integer(8), intent(in) :: handle
    integer, intent(in) :: wheel, m, n
    real(8), intent(in) :: y(n), z(n), roll(n)
    real(8), intent(out) :: values(m, n)
    integer, intent(out) :: status(n)
    !f2py threadsafe
    type(prepared_type), pointer :: p
    type(contact_state) :: state
    integer :: i

    p => prepared_at(handle)
    do i = 1, n
      call contacts(p%setup%wheelset, [y(i), z(i), roll(i)], state, with_hessian=m == 6, wheel=wheel)
      select case (m)
      case (1)
        values(:, i) = (state%energy(1) + state%energy(2)) + (state%energy(3) + state%energy(4))
      case (3)
        values(:, i) = -state%gradient
      case (6)
        values(:, i) = state%hessian
      case (12)
        values(:, i) = reshape(-state%slope, [12])
      end select
      status(i) = state%status
    end do
  end subroutine contact_values

  !> Pressures of the wheel of a side (1 left, 2 right) in a pose: axle centre y, z [m], roll [rad]. The right side is given as
  !> its mirror image. Grids have nx by ns elements to a patch; n patches are filled. point and width: rows of elements on the
  !> wheel, wheelset frame, and half of the pressed length of each row [m]. facts: the numbers of `pressed_patch` in their
  !> order, with 1 for a flange. total: F_y, F_z [N], M_x about the axle centre [N m], energy [J].
  subroutine pressures(handle, side, pose, nx, ns, n, ok, p, point, width, facts, total)
    integer(8), intent(in) :: handle
    integer, intent(in) :: side, nx, ns
    real(8), intent(in) :: pose(3)
    integer, intent(out) :: n, ok
    real(8), intent(out) :: p(nx, ns, 4), point(2, ns, 4), width(ns, 4), facts(16, 4), total(4)
    !f2py threadsafe
    type(prepared_type), pointer :: prepared
    type(pressed_patch) :: patch(most_patches)
    logical :: converged
    integer :: k

    prepared => prepared_at(handle)
    associate (c => prepared%c)
      call press_contact(prepared%setup%side(side), grids(c, [nx, ns]), merge(pose, mirror*pose, side == 1), patch, n, converged, &
        total)
    end associate
    p = 0
    point = 0
    width = 0
    facts = 0
    do k = 1, n
      associate (one => patch(k))
        p(:, :, k) = one%p
        point(:, :, k) = one%point
        width(:, k) = one%width
        facts(:, k) = [merge(1d0, 0d0, one%flange), one%dx, one%ds, one%low, one%half_x, one%ends, one%approach, one%deepest, &
                       one%integral, one%largest, one%peak_s, one%area, one%hertz]
      end associate
    end do
    ok = merge(1, 0, converged)
  end subroutine pressures

  !> Geometry functions, without the conicity, at lateral displacements y [m]; NaN where the rigid wheelset does not stand
  !> on both rails.
  subroutine geometry_rows(handle, n, y, rows)
    integer(8), intent(in) :: handle
    integer, intent(in) :: n
    real(8), intent(in) :: y(n)
    real(8), intent(out) :: rows(12, n)
    !f2py threadsafe
    type(prepared_type), pointer :: p

    p => prepared_at(handle)
    call geometry_at(p%setup%side, p%setup%centred(2), y, rows)
  end subroutine geometry_rows

  !> Where one wheel alone (side 1 left, 2 right) touches its rail, the axle at lateral positions y [m] towards that side and
  !> at roll angles that lift that wheel [rad]: height of the axle [m]; of the contact, its angle to the track [rad], its place
  !> on the wheel in the frame of the wheelset, outward and up [m], and in the track, outward and up [m]. NaN where it passes
  !> beside the rail.
  subroutine wheel_contacts(handle, side, n, y, roll, rows)
    integer(8), intent(in) :: handle
    integer, intent(in) :: side, n
    real(8), intent(in) :: y(n), roll(n)
    real(8), intent(out) :: rows(6, n)
    !f2py threadsafe
    type(prepared_type), pointer :: p
    type(scan_type) :: scan
    integer :: i

    p => prepared_at(handle)
    scan = new_scan(p%setup%side(side)%pair)
    do i = 1, n
      call wheel_contact(p%setup%side(side)%pair, y(i), roll(i), scan, rows(:, i))
    end do
  end subroutine wheel_contacts

  !> Read a profile of a kind (1 wheel, 2 rail) as a run would.
  subroutine check_profile(path, kind, message, length)
    character(*), intent(in) :: path
    integer, intent(in) :: kind
    character(16384), intent(out) :: message
    integer, intent(out) :: length
    type(profile_type) :: p
    type(error_type), allocatable :: error

    call read_profile(path, kind, p, error)
    call give_error(error, message, length)
  end subroutine check_profile

  !> Noise of the points y, z [m] of a profile, across its curve, rms [m].
  subroutine point_noise(n, y, z, noise)
    integer, intent(in) :: n
    real(8), intent(in) :: y(n), z(n)
    real(8), intent(out) :: noise

    noise = noise_of(y, z)
  end subroutine point_noise

  !> The curve that a run lays through the points y, z [mm] of a profile: length [m]; at stations s [m] y, z [m], angle of the
  !> tangent [rad], curvature [1/m]. NaN where points repeat.
  subroutine curve_frames(n, points, m, s, length, frames)
    integer, intent(in) :: n, m
    real(8), intent(in) :: points(2, n), s(m)
    real(8), intent(out) :: length, frames(4, m)
    type(curve_type) :: c
    type(error_type), allocatable :: error
    integer :: i

    call interpolate(1d-3*points(1, :), 1d-3*points(2, :), c, error)
    length = ieee_value(1d0, ieee_quiet_nan)
    frames = length
    if (allocated(error)) return
    length = c%last()
    do i = 1, m
      if (s(i) < huge(s)) call curve_frame(c, s(i), frames(:2, i), frames(3, i), frames(4, i))
    end do
  end subroutine curve_frames

  !> Profiles in their places, zones and clearance of a case, without a contact table.
  subroutine prepare_rigid_case(n, numbers, words, paths, handle, message, length)
    integer, intent(in) :: n
    real(8), intent(in) :: numbers(n)
    character(*), intent(in) :: words, paths
    integer(8), intent(out) :: handle
    character(16384), intent(out) :: message
    integer, intent(out) :: length
    !f2py threadsafe
    type(prepared_type), pointer :: p
    type(case_type) :: c
    type(error_type), allocatable :: error

    call import_case(numbers, words, c)
    call new_prepared(p, handle)
    call prepare_rigid(p, c, paths, error)
    if (allocated(error)) call free_prepared_at(handle)
    call give_error(error, message, length)
  end subroutine prepare_rigid_case

  !> Numbers of points in the outlines of a prepared case: wheel and rail (first index) of left and right side. axle:
  !> height [m] and roll [rad] of the rigid wheelset that stands on both rails at the centre.
  subroutine outline_sizes(handle, n, axle)
    integer(8), intent(in) :: handle
    integer, intent(out) :: n(2, 2)
    real(8), intent(out) :: axle(2)
    type(prepared_type), pointer :: p
    integer :: side

    p => prepared_at(handle)
    do side = 1, 2
      n(:, side) = [size(p%setup%wheel(side)%points, 2), size(p%setup%rail(side)%points, 2)]
    end do
    axle = p%setup%centred(2:)
  end subroutine outline_sizes

  !> The points of a wheel (what = 1) in the frame of the wheelset, or of a rail (2) in the frame of the track, where the
  !> core has placed them [m]. The right side (side = 2) is given as its mirror image.
  subroutine outline_points(handle, what, side, n, points)
    integer(8), intent(in) :: handle
    integer, intent(in) :: what, side, n
    real(8), intent(out) :: points(2, n)

    call outline(prepared_at(handle), what, side, points)
  end subroutine outline_points

  !> Facts of a side (1 left, 2 right) of such a case: clearance to it [m], number of zones; of each of at most six zones:
  !> first and last y on the wheel from its back [m], 1 for the flange, contact angle [rad].
  subroutine rigid_numbers(handle, side, numbers, zones)
    integer(8), intent(in) :: handle
    integer, intent(in) :: side
    real(8), intent(out) :: numbers(2), zones(4, 6)
    type(prepared_type), pointer :: p
    integer :: k

    p => prepared_at(handle)
    zones = 0
    associate (s => p%setup%side(side))
      numbers = [s%clearance, dble(size(s%zones))]
      do k = 1, size(s%zones)
        zones(:, k) = [s%pair%r(1, s%zones(k)%first) - p%c%back_to_back/2, &
                       s%pair%r(1, s%zones(k)%last) - p%c%back_to_back/2, &
                       merge(1d0, 0d0, s%zones(k)%past_root), s%zones(k)%alpha]
      end do
    end associate
  end subroutine rigid_numbers

  !> A warning about a prepared case that its header and summary tell.
  subroutine tell_setup(handle, words)
    integer(8), intent(in) :: handle
    character(*), intent(in) :: words
    type(prepared_type), pointer :: p

    p => prepared_at(handle)
    p%setup%remark = words
  end subroutine tell_setup

  !> Angles by which the left and the right rail of such a case lean to the track's centre beyond their files [rad].
  subroutine rail_inclinations(handle, angles)
    integer(8), intent(in) :: handle
    real(8), intent(out) :: angles(2)
    type(prepared_type), pointer :: p

    p => prepared_at(handle)
    angles = p%setup%inclination
  end subroutine rail_inclinations

  !> What is doubtful about the profiles of such a case in their places, a line each.
  subroutine placement_warnings(handle, listing, length)
    integer(8), intent(in) :: handle
    character(8192), intent(out) :: listing
    integer, intent(out) :: length
    type(prepared_type), pointer :: p
    character(:), allocatable :: words

    p => prepared_at(handle)
    call warn_of_upright(p%setup, words)
    call give(words, listing, length)
  end subroutine placement_warnings

  !> Find out before the work, not after it, that a column file cannot be written.
  subroutine check_writable(file, path, message, length)
    character(*), intent(in) :: file, path
    character(16384), intent(out) :: message
    integer, intent(out) :: length
    type(error_type), allocatable :: error

    call check_path(file, path, error)
    call give_error(error, message, length)
  end subroutine check_writable

end module flat
