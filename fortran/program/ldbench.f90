!> The command `ldbench`: one namelist file in, one column file out.
program ldbench
  use, intrinsic :: iso_c_binding, only: c_int
  use, intrinsic :: iso_fortran_env, only: error_unit
  use case, only: case_type, list_variables, output_path, range_text, value_text, variable_type
  use case_check, only: check_case, check_writable
  use case_reader, only: read_case
  use errors, only: error_type, fatal_error, place_error
  use kinds, only: version
  use places, only: find_file, find_share, folder_of, places_type
  use column_files, only: begin_columns, column_file, finish_columns
  use progress, only: terminal_monitor
  use run_monitor, only: run_type
  use run_results, only: summary
  use run_setup, only: setup_type
  use run_tables, only: free_tables, keep_tables
  use simulation, only: prepare, simulate
  use system, only: c_exit, survive_long_files, write_output
  use text, only: line_type, read_lines
  implicit none
  type(error_type), allocatable :: error
  character(:), allocatable :: argument, text
  integer :: length
  type(terminal_monitor) :: watcher
  character, parameter :: nl = new_line('a')

  call survive_long_files()
  call watcher%begin()
  call get_command_argument(1, length=length)
  allocate (character(length) :: argument)
  if (length > 0) call get_command_argument(1, argument)
  if (argument == '--help' .or. argument == '-h') then
    call help(text)
    call answer(text)
  else if (argument == '--version') then
    call answer('ldbench '//version//nl)
  else if (command_argument_count() > 1) then
    call fatal_error(error, 'expected at most one argument, a namelist file; see ldbench --help')
  else if (len(argument) > 1 .and. index(argument, '-') == 1) then
    call fatal_error(error, 'unknown option '//argument//'; see ldbench --help')
  else
    if (argument == '') argument = '-'
    call run(argument)
  end if
  if (allocated(text)) deallocate (text)
  deallocate (argument)
  if (allocated(error)) then
    write (error_unit, '(a)') 'ldbench: error: '//error%message
    call c_exit(1_c_int)
  end if

contains

  !> Read, check and run a case, and write the files.
  subroutine run(path)
    character(*), intent(in) :: path           !! '-' for standard input
    type(line_type), allocatable :: lines(:)
    type(case_type), allocatable :: c
    type(setup_type), allocatable :: setup
    type(error_type), allocatable :: warning
    type(column_file) :: columns
    type(run_type) :: result
    type(places_type) :: places
    character(:), allocatable :: file

    allocate (c, setup)   ! on the heap: stacks may be small
    call find_share(places%share)
    call find_file(places, path, file, error)
    if (.not. allocated(error)) call read_lines(file, lines, error)
    if (allocated(error)) return
    if (file == '-') then
      file = 'standard input'
    else
      call folder_of(file, places%folder)
    end if
    c%places = places
    call read_case(file, lines, c, error)
    if (.not. allocated(error)) call check_case(file, c, error)
    if (.not. allocated(error)) call check_writable(file, trim(output_path(c)), error)
    if (allocated(error)) return
    call prepare(c, setup, error)
    if (.not. allocated(error)) call begin_columns(c, setup, trim(output_path(c)), columns, error)
    if (.not. allocated(error)) call simulate(c, setup, columns, result, error, watcher)
    if (.not. allocated(error)) call finish_columns(c, result, columns, error)
    if (.not. allocated(error) .and. c%formulation == 'elastic') call keep_tables(c, setup, warning)
    call columns%file%abandon()
    call watcher%clear()
    if (allocated(warning)) write (error_unit, '(a)') 'ldbench: warning: '//warning%message
    if (.not. allocated(error)) then
      call summary(c, setup, result, text)
      if (allocated(columns%kept)) text = text//'kept: '//columns%kept//', the earlier columns, of another case'//nl
      call answer(text)
    end if
    call free_tables(setup)
    if (allocated(error)) call place_error(error, file)
  end subroutine run

  !> Write a text to standard output.
  subroutine answer(text)
    character(*), intent(in) :: text
    logical :: ok

    call write_output(text, ok)
    if (.not. ok) call fatal_error(error, 'cannot be written completely', 'standard output')
  end subroutine answer

  subroutine help(lines)
    character(:), allocatable, intent(out) :: lines
    type(case_type), target :: c
    type(variable_type), allocatable :: list(:)
    character(:), allocatable :: group
    integer :: k

    lines = 'ldbench '//version//': simulates a frictionless railway wheelset on two rails'//nl//nl// &
      'usage: ldbench < input.nml'//nl// &
      '       ldbench input.nml'//nl// &
      '       ldbench --help | --version'//nl//nl// &
      'Reads one namelist file, writes one column file and a summary.'//nl// &
      'Exit status: 0, or 1 with one line on standard error.'//nl//nl// &
      'Files that the namelist names, and the namelist, are looked for in the working folder, then beside the namelist'//nl// &
      'and in the folder above it, then in the installed share/ldbench. Results go to the working folder.'//nl//nl// &
      'Variables, all optional, in SI units, with default, admissible values and meaning:'//nl
    call list_variables(c, list)
    group = ''
    do k = 1, size(list)
      if (list(k)%group /= group) lines = lines//'&'//list(k)%group//nl
      group = list(k)%group
      lines = lines//'  '//trim(list(k)%name)//' = '//trim(value_text(list(k)))//'   '//trim(range_text(list(k)))//nl// &
        '      '//list(k)%meaning//nl
    end do
  end subroutine help

end program ldbench
