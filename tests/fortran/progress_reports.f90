!> What a run tells the one who watches it.
!>
!> usage: progress_reports input.nml n
!> Writes stage and share of every report; the n-th one is answered by the wish to stop (0: none is).
!> Then `rows` and their number, or `none` 0 where the run was stopped before it.
module listener
  use errors, only: error_type, fatal_error
  use kinds, only: dp
  use progress, only: monitor_type
  use row_sink, only: row_writer
  implicit none
  private
  public :: counted_rows, listening_monitor

  type, extends(monitor_type) :: listening_monitor
    integer :: told = 0, stop_at = 0
  contains
    procedure :: report
  end type listening_monitor

  type, extends(row_writer) :: counted_rows
    integer :: n = 0
    real(dp) :: last = -1                  !! time of the last row [s]
  contains
    procedure :: write_row
  end type counted_rows

contains

  subroutine write_row(this, row, error)
    class(counted_rows), intent(inout) :: this
    real(dp), intent(in) :: row(:)
    type(error_type), allocatable, intent(out) :: error

    if (row(1) < this%last) call fatal_error(error, 'rows are not in the order of time')
    this%n = this%n + 1
    this%last = row(1)
  end subroutine write_row

  subroutine report(this, stage, share)
    class(listening_monitor), intent(inout) :: this
    character(*), intent(in) :: stage
    real(dp), intent(in) :: share

    write (*, '(2a,f12.9)') stage, ' ', share
    this%told = this%told + 1
    if (this%told == this%stop_at) this%stop = .true.
  end subroutine report

end module listener
program progress_reports
  use case, only: case_type
  use case_reader, only: read_case
  use errors, only: error_type
  use listener, only: counted_rows, listening_monitor
  use shared, only: integer_argument
  use run_monitor, only: run_type
  use run_setup, only: setup_type
  use simulation, only: prepare, simulate
  use text, only: line_type, read_lines
  implicit none
  save
  type(listening_monitor) :: watcher
  type(error_type), allocatable :: error
  type(line_type), allocatable :: lines(:)
  type(case_type) :: c
  type(setup_type) :: setup
  type(counted_rows) :: kept
  type(run_type) :: run
  character(256) :: file

  call get_command_argument(1, file)
  watcher%stop_at = integer_argument(2)
  call read_lines(trim(file), lines, error)
  if (.not. allocated(error)) call read_case(trim(file), lines, c, error)
  if (.not. allocated(error)) call prepare(c, setup, error, watcher)
  if (allocated(error) .and. watcher%stop) then
    write (*, '(a)') 'none 0'
    stop
  end if
  if (.not. allocated(error)) call simulate(c, setup, kept, run, error, watcher)
  if (allocated(error)) error stop error%message
  write (*, '(a,i0)') 'rows ', kept%n
end program progress_reports
