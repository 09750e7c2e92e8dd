!> The contact tables of a run.
module run_tables
  use case, only: case_type, right_table_path, text_length
  use contact_table, only: table_type
  use contact_zones, only: side_type
  use errors, only: error_type, fatal_error
  use fingerprint, only: law
  use geometry_functions, only: clearance
  use hertz, only: contact_modulus
  use kinds, only: dp
  use profile, only: profile_type
  use progress, only: monitor_type
  use run_setup, only: setup_type
  use service_poses, only: extent_type
  use table_builder, only: build_table
  use table_error, only: measure
  use table_file, only: load_table, save_table
  use text, only: str
  implicit none
  private
  public :: prepare_tables, free_tables

contains

  !> Find the contact tables of both sides in their files, or build them. Sides with the same profiles share one.
  subroutine prepare_tables(c, setup, error, watcher)
    type(case_type), intent(in) :: c
    type(setup_type), intent(inout) :: setup
    type(error_type), allocatable, intent(out) :: error
    class(monitor_type), intent(inout), optional :: watcher
    real(dp) :: from, to
    logical :: found(2)
    integer :: k, n

    call cpu_time(from)
    n = merge(1, 2, setup%symmetric)
    allocate (setup%wheelset%table)
    setup%wheelset%right_table => setup%wheelset%table
    if (n == 2) allocate (setup%wheelset%right_table)
    ! All files are read before any table is built: one that is no table is an error at once.
    do k = 1, n
      call load_side(k, error)
      if (allocated(error)) return
    end do
    do k = 1, n
      if (present(watcher)) watcher%from = (k - 1.0_dp)/n
      if (present(watcher)) watcher%to = real(k, dp)/n
      if (.not. found(k)) call build_side(k, error)
      if (allocated(error)) return
    end do
    setup%table_found = all(found(:n))
    call cpu_time(to)
    setup%table_seconds = to - from

  contains

    function table_of(k) result(table)
      integer, intent(in) :: k             !! 1 left, 2 right
      type(table_type), pointer :: table

      table => setup%wheelset%table
      if (k == 2) table => setup%wheelset%right_table
    end function table_of

    function file_of(k) result(file)
      integer, intent(in) :: k
      character(text_length + 6) :: file

      file = c%table_file
      if (k == 2) file = right_table_path(c)
    end function file_of

    subroutine load_side(k, error)
      integer, intent(in) :: k
      type(error_type), allocatable, intent(out) :: error
      type(table_type), pointer :: table
      character(:), allocatable :: key

      table => table_of(k)
      found(k) = .false.
      call table_key(c, setup%wheel(k), setup%rail(k), key)
      if (file_of(k) /= '') call load_table(trim(file_of(k)), key, table, found(k), error)
    end subroutine load_side

    subroutine build_side(k, error)
      integer, intent(in) :: k
      type(error_type), allocatable, intent(out) :: error
      type(table_type), pointer :: table
      type(extent_type) :: extent
      type(side_type) :: both(2)
      character(:), allocatable :: key
      real(dp) :: e_star, own
      logical :: ok

      table => table_of(k)
      ! The table of a pair does not depend on the other side: it is made for a wheelset with this pair on both sides.
      both(1) = setup%side(k)
      both(2) = setup%side(k)
      call clearance(both, own, ok)
      extent = extent_type(c%lateral, c%lift, c%drop, c%roll_range, c%depth)
      if (ok) extent%clearance = own
      e_star = c%stiffness_scale*contact_modulus(c%youngs_modulus, c%poisson)
      call table_key(c, setup%wheel(k), setup%rail(k), key)
      associate (side => setup%side(k))
        call build_table(side%pair, side%zones, trim(c%model), e_star, extent, c%accuracy, &
          [c%n_lateral, c%n_roll, c%n_depth], key, table, watcher)
      end associate
      if (present(watcher)) then
        if (watcher%stop) then
          call fatal_error(error, 'stopped by the user')
          return
        end if
      end if
      call measure(setup%side(k)%pair, setup%side(k)%zones, trim(c%model), e_star, extent, table)
      if (file_of(k) /= '') call save_table(trim(file_of(k)), table, error)
    end subroutine build_side

  end subroutine prepare_tables

  !> Free the tables that `prepare_tables` made.
  subroutine free_tables(setup)
    type(setup_type), intent(inout) :: setup

    associate (w => setup%wheelset)
      if (associated(w%right_table) .and. .not. associated(w%right_table, w%table)) deallocate (w%right_table)
      if (associated(w%table)) deallocate (w%table)
      nullify (w%right_table)
    end associate
  end subroutine free_tables

  !> All that the table of a side depends on, in words; `law` is the checksum of the sources that make tables.
  subroutine table_key(c, wheel, rail, key)
    type(case_type), intent(in) :: c
    type(profile_type), intent(in) :: wheel, rail
    character(:), allocatable, intent(out) :: key

    key = 'ldbench '//law//' model '//trim(c%model)//' profiles '//wheel%checksum//' '// &
      rail%checksum//' '//trim(c%wheel_flip)//' '//trim(c%wheel_unit)//' '//trim(c%rail_flip)//' '// &
      trim(c%rail_unit)//' smoothing '//str(c%smoothing_mm)//' gauge '//str(c%gauge)//' '// &
      str(c%gauge_depth)//' back_to_back '//str(c%back_to_back)//' radius '//str(c%rolling_radius)// &
      ' E '//str(c%youngs_modulus)//' nu '//str(c%poisson)//' scale '//str(c%stiffness_scale)// &
      ' split '//str(c%split_angle)//' extent '//str(c%lateral)//' '//str(c%lift)//' '//str(c%drop)//' '// &
      str(c%roll_range)//' '//str(c%depth)//' accuracy '//str(c%accuracy)//' points '//str(c%n_lateral)//' '//str(c%n_roll)//' '// &
      str(c%n_depth)
  end subroutine table_key

end module run_tables
