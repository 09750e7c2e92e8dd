!> The files of a run: columns and geometry functions.
module files
  use case, only: case_type
  use column_writer, only: column_file
  use columns, only: column_type, list_columns, most_columns
  use errors, only: error_type, fatal_error
  use geometry_functions, only: geometry_names, geometry_pitch, geometry_table, geometry_units
  use kinds, only: dp
  use motion_state, only: motion_type
  use results, only: newline
  use run_monitor, only: run_type
  use run_results, only: describe_results, describe_setup
  use run_setup, only: setup_type
  use system, only: default_folder, lacks_folder, scratch_file
  implicit none
  private
  public :: begin_columns, finish_files, write_geometry, check_writable

contains

  !> Check before the computation that a file can be written.
  subroutine check_writable(file, variable, path, error)
    character(*), intent(in) :: file, variable   !! for the message
    character(*), intent(in) :: path
    type(error_type), allocatable, intent(out) :: error
    character(:), allocatable :: first         ! that is written
    type(scratch_file) :: probe

    if (path == '') return
    first = path
    if (lacks_folder(path)) first = default_folder
    call probe%begin(first)
    call probe%abandon()
    if (.not. probe%ok) call fatal_error(error, file//', '//variable//': expected a path that can be written, found '//path)
  end subroutine check_writable

  !> Begin the column file that receives the rows of a run.
  subroutine begin_columns(c, setup, file, columns, error)
    type(case_type), intent(in) :: c
    type(setup_type), intent(in) :: setup
    character(*), intent(in) :: file
    type(column_file), intent(inout) :: columns
    type(error_type), allocatable, intent(out) :: error
    type(column_type) :: list(most_columns)
    type(motion_type) :: motion            ! any
    real(dp) :: values(most_columns)
    character(:), allocatable :: about
    integer :: n

    call list_columns(c, setup, motion, 0.0_dp, values, n, list)
    call describe_setup(c, setup, about)
    call columns%begin(file, about, list(:n)%name, list(:n)%unit, error)
  end subroutine begin_columns

  !> Complete the column file of a run, and write the geometry functions if the case names a file for them. No file gets its
  !> name before both files are complete.
  subroutine finish_files(c, setup, run, columns, geometry_file, error)
    type(case_type), intent(in) :: c
    type(setup_type), intent(in) :: setup
    type(run_type), intent(in) :: run
    type(column_file), intent(inout) :: columns
    character(*), intent(in) :: geometry_file    !! '' for none
    type(error_type), allocatable, intent(out) :: error
    type(column_file) :: geometry
    character(:), allocatable :: results

    call describe_results(c, run, results)
    call columns%complete(results, error)
    if (.not. allocated(error) .and. geometry_file /= '') call write_geometry(c, setup, geometry_file, geometry, error)
    if (.not. allocated(error)) call columns%publish(error)
    if (.not. allocated(error) .and. geometry_file /= '') call geometry%publish(error)
    call columns%file%abandon()
    call geometry%file%abandon()
  end subroutine finish_files

  !> Write the geometry functions over the lateral displacements at which the wheelset stands on both rails.
  !> `publish` gives the file its name later.
  subroutine write_geometry(c, setup, file, columns, error)
    type(case_type), intent(in) :: c
    type(setup_type), intent(in) :: setup
    character(*), intent(in) :: file
    type(column_file), intent(inout) :: columns
    type(error_type), allocatable, intent(out) :: error
    real(dp), allocatable :: rows(:, :)
    character(:), allocatable :: about
    integer :: n, last, i

    call describe_setup(c, setup, about)
    about = about//'conicity: equivalent, by harmonic linearisation, for the amplitude |Y|'
    if (.not. setup%symmetric) about = about//' about where the mean of delta_r is 0'
    n = max(2, int(1.2_dp*maxval(setup%side%clearance)/geometry_pitch))
    allocate (rows(size(geometry_names), -n:n))
    call geometry_table(setup%side, setup%centred(2), n, rows, last)
    if (last < 2) then
      call fatal_error(error, file//': the rigid wheelset does not stand on both rails')
      return
    end if
    call columns%begin(file, about//newline, geometry_names, geometry_units, error)
    do i = -last, last
      if (.not. allocated(error)) call columns%write_row(rows(:, i), error)
    end do
    if (.not. allocated(error)) call columns%complete('', error)
  end subroutine write_geometry

end module files
