!> The command `ldbench`: one namelist file in, one column file out.
program ldbench
  use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
  use case, only: case_type, check_case, list_variables, output_path, range_text, read_case, right_table_path, value_text, &
    variable_type
  use errors, only: error_type, fatal_error
  use kinds, only: version
  use report, only: check_writable, summary, write_columns, write_geometry
  use simulation, only: prepare, run_type, setup_type, simulate
  use terminal, only: terminal_monitor
  use text, only: line_type, read_lines
  implicit none
  type(error_type), allocatable :: error
  character(:), allocatable :: argument
  type(terminal_monitor) :: watcher

  call watcher%begin()
  call get_argument(1, argument)
  select case (argument)
  case ('--help', '-h')
    call print_help()
  case ('--version')
    write (output_unit, '(a)') 'ldbench '//version
  case default
    if (command_argument_count() > 1) then
      call fatal_error(error, 'expected at most one argument, a namelist file; see ldbench --help')
    else if (len(argument) > 1 .and. argument(1:1) == '-') then
      call fatal_error(error, 'unknown option '//argument//'; see ldbench --help')
    else
      call run(argument)
    end if
  end select
  if (allocated(error)) then
    write (error_unit, '(a)') 'ldbench: error: '//error%message
    stop 1, quiet=.true.
  end if

contains

  subroutine run(argument)
    character(*), intent(in) :: argument
    type(line_type), allocatable :: lines(:)
    type(case_type) :: c
    type(setup_type) :: setup
    type(run_type) :: result
    character(:), allocatable :: file

    file = argument
    if (file == '') file = '-'
    call read_lines(file, lines, error)
    if (allocated(error)) return
    if (file == '-') file = 'standard input'
    call read_case(file, lines, c, error)
    if (allocated(error)) return
    call check_case(file, c, error)
    if (allocated(error)) return
    call check_writable(file, '&output file', output_path(c), error)
    if (.not. allocated(error)) call check_writable(file, '&output geometry_file', trim(c%geometry_file), error)
    if (.not. allocated(error)) call check_writable(file, '&table file', trim(c%table_file), error)
    if (.not. allocated(error)) call check_writable(file, '&table file', right_table_path(c), error)
    if (allocated(error)) return
    call prepare(c, setup, error, watcher)
    if (.not. allocated(error)) call simulate(c, setup, result, error, watcher)
    if (.not. allocated(error)) call write_columns(c, setup, result, output_path(c), error)
    if (.not. allocated(error) .and. c%geometry_file /= '') &
      call write_geometry(c, setup, trim(c%geometry_file), error)
    call watcher%clear()
    if (allocated(error)) then
      error%message = file//': '//error%message
      return
    end if
    write (output_unit, '(a)', advance='no') summary(c, setup, result)
  end subroutine run

  subroutine get_argument(i, value)
    integer, intent(in) :: i
    character(:), allocatable, intent(out) :: value
    integer :: length

    call get_command_argument(i, length=length)
    allocate (character(length) :: value)
    if (length > 0) call get_command_argument(i, value)
  end subroutine get_argument

  subroutine print_help()
    type(case_type), target :: c
    type(variable_type), allocatable :: list(:)
    character(:), allocatable :: group
    integer :: k

    write (output_unit, '(a)') &
      'ldbench '//version//': a railway wheelset without friction between its flanges', '', &
      'usage: ldbench < input.nml', &
      '       ldbench input.nml', &
      '       ldbench --help | --version', '', &
      'Reads one namelist file, writes one column file and a summary.', &
      'Exit status: 0, or 1 with one line on standard error.', '', &
      'Variables, all optional, SI units [range or words] (default):'
    call list_variables(c, list)
    group = ''
    do k = 1, size(list)
      if (list(k)%group /= group) write (output_unit, '(a)') '&'//list(k)%group
      group = list(k)%group
      write (output_unit, '(2x,a,t23,a)') list(k)%name, '('//value_text(list(k))//') '// &
        range_text(list(k))//about(list(k)%meaning)
    end do
  end subroutine print_help

  function about(meaning) result(words)
    character(*), intent(in) :: meaning
    character(:), allocatable :: words

    words = ''
    if (meaning /= '') words = '; '//meaning
  end function about

end program ldbench
