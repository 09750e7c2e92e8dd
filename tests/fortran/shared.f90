!> What the programs beside it share: the case that they are given.
module shared
  use case, only: case_type
  use case_reader, only: read_case
  use errors, only: error_type
  use run_setup, only: setup_type
  use simulation, only: prepare
  use text, only: line_type, read_lines
  implicit none
  private
  public :: read_prepared

contains

  !> The case of the namelist file that is the first argument, ready to be integrated.
  subroutine read_prepared(c, setup)
    type(case_type), intent(out) :: c
    type(setup_type), intent(out) :: setup
    type(error_type), allocatable :: error
    type(line_type), allocatable :: lines(:)
    character(256) :: file

    call get_command_argument(1, file)
    call read_lines(trim(file), lines, error)
    if (.not. allocated(error)) call read_case(trim(file), lines, c, error)
    if (.not. allocated(error)) call prepare(c, setup, error)
    if (allocated(error)) error stop error%message
  end subroutine read_prepared

end module shared
