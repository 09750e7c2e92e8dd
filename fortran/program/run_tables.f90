!> The contact tables of a run.
module run_tables
  use case, only: case_type, right_table_path, text_length
  use contact_table, only: table_type
  use contact_zones, only: side_type, threshold_at, usual_flange_angle
  use errors, only: error_type, fatal_error
  use fingerprint, only: table_sources
  use rigid_geometry, only: clearance
  use hertz, only: contact_modulus
  use kinds, only: dp
  use profile, only: profile_type
  use progress, only: monitor_type, table_reached
  use run_setup, only: setup_type
  use service_poses, only: fit_extent, request_type
  use table_builder, only: build_table
  use table_error, only: measure
  use table_file, only: load_table, save_table
  use text, only: str
  implicit none
  private
  public :: load_or_build_tables, free_tables, table_request

  !> A table and where it is kept.
  type :: wanted_type
    type(table_type), pointer :: table => null()
    character(text_length + 6) :: file = ''
    character(:), allocatable :: key       !! all that the table depends on
    logical :: found = .false.
  end type wanted_type

contains

  !> Load the contact tables of both sides from their files, or build them. Sides with the same profiles share one.
  subroutine load_or_build_tables(c, setup, error, watcher)
    type(case_type), intent(in) :: c
    type(setup_type), target, intent(inout) :: setup
    type(error_type), allocatable, intent(out) :: error
    class(monitor_type), intent(inout), optional :: watcher
    type(wanted_type) :: wanted(2)         ! left, right
    type(request_type) :: request
    real(dp) :: from, to
    integer :: k, n
    logical :: stopped

    call cpu_time(from)
    n = merge(1, 2, setup%symmetric)
    allocate (setup%wheelset%table)
    setup%wheelset%right_table => setup%wheelset%table
    if (n == 2) allocate (setup%wheelset%right_table)
    wanted(1)%table => setup%wheelset%table
    wanted(2)%table => setup%wheelset%right_table
    wanted%file = [character(text_length + 6) :: c%table_file, right_table_path(c)]
    ! All files are read before any table is built, so that a file that is no table is an error at once.
    do k = 1, n
      call table_key(c, setup%wheel(k), setup%rail(k), wanted(k)%key)
      if (wanted(k)%file /= '') call load_table(trim(wanted(k)%file), wanted(k)%key, wanted(k)%table, wanted(k)%found, error)
      if (allocated(error)) return
    end do
    do k = 1, n
      if (.not. wanted(k)%found) then
        request = table_request(c, setup%side(k))
        call build_table(request, wanted(k)%key, wanted(k)%table, stopped, watcher)
        if (.not. stopped) call measure(request, wanted(k)%table, stopped, watcher)
        if (stopped) then
          call fatal_error(error, 'stopped by the user')
          return
        end if
        call table_reached(1.0_dp, watcher)
        if (wanted(k)%file /= '') call save_table(trim(wanted(k)%file), wanted(k)%table, error)
        if (allocated(error)) return
      end if
      wanted(k)%table%threshold = setup%side(k)%threshold
    end do
    setup%table_found = all(wanted(:n)%found)
    call cpu_time(to)
    setup%table_seconds = to - from
  end subroutine load_or_build_tables

  !> Requirements of the case on the table of a side. The table does not depend on the other side, because it is made for a
  !> wheelset with the same pair on both sides.
  function table_request(c, side) result(request)
    type(case_type), intent(in) :: c
    type(side_type), target, intent(in) :: side
    type(request_type) :: request
    type(side_type) :: both(2)
    real(dp) :: clearance_here
    logical :: ok

    request = request_type(side, c%model(:9), c%influence(:5), c%stiffness_scale*contact_modulus(c%youngs_modulus, c%poisson), &
      c%extent, c%accuracy, [c%n_lateral, c%n_roll, c%n_depth])
    both(1) = side
    both(2) = side
    ! The table is the same whatever contacts a case calls the flange's.
    both(1)%threshold = threshold_at(usual_flange_angle)
    call clearance(both, clearance_here, ok)
    if (ok) call fit_extent(clearance_here, c%gauge, request%extent)
  end function table_request

  !> Free the tables that `load_or_build_tables` made.
  subroutine free_tables(setup)
    type(setup_type), intent(inout) :: setup

    associate (w => setup%wheelset)
      if (associated(w%right_table) .and. .not. associated(w%right_table, w%table)) deallocate (w%right_table)
      if (associated(w%table)) deallocate (w%table)
      nullify (w%right_table)
    end associate
  end subroutine free_tables

  !> All that the table of a side depends on, in words; `table_sources` is the checksum of the sources that make tables.
  subroutine table_key(c, wheel, rail, key)
    type(case_type), intent(in) :: c
    type(profile_type), intent(in) :: wheel, rail
    character(:), allocatable, intent(out) :: key

    key = 'ldbench '//table_sources//' model '//trim(c%model)//' profiles '//wheel%checksum//' '//rail%checksum// &
      ' gauge '//str(c%gauge)//' '//str(c%gauge_depth)// &
      ' back_to_back '//str(c%back_to_back)//' radius '//str(c%rolling_radius)//' E '//str(c%youngs_modulus)// &
      ' nu '//str(c%poisson)//' scale '//str(c%stiffness_scale)//' influence '//trim(c%influence)// &
      ' extent '//str(c%extent%lateral)//' '//str(c%extent%lift)//' '//str(c%extent%drop)//' '//str(c%extent%roll)// &
      ' '//str(c%extent%depth)//' accuracy '//str(c%accuracy)//' points '//str(c%n_lateral)//' '//str(c%n_roll)//' '//str(c%n_depth)
  end subroutine table_key

end module run_tables
