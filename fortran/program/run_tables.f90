!> The contact tables of a run.
module run_tables
  use case, only: case_type, inclinations
  use contact_law, only: law_type
  use contact_table, only: table_type
  use contact_zones, only: side_type
  use errors, only: error_type, place_error
  use hertz, only: contact_modulus
  use kinds, only: dp
  use places, only: kept_folder
  use run_setup, only: setup_type
  use table_file, only: find_table_path, load_values, save_values
  use table_layout, only: lay_out
  use text, only: shortest, str
  implicit none
  private
  public :: open_tables, keep_tables, free_tables

contains

  !> Make the contact tables of both sides, with what the folder keeps, and the user's cache where the folder may not be
  !> written. Sides with the same profiles share one.
  subroutine open_tables(c, setup)
    type(case_type), intent(in) :: c
    type(setup_type), intent(inout) :: setup

    allocate (setup%wheelset%table)
    setup%wheelset%right_table => setup%wheelset%table
    if (.not. setup%symmetric) allocate (setup%wheelset%right_table)
    call open_table(c, setup, 1, setup%wheelset%table)
    if (.not. setup%symmetric) call open_table(c, setup, 2, setup%wheelset%right_table)
  end subroutine open_tables

  subroutine open_table(c, setup, side, table)
    type(case_type), intent(in) :: c
    type(setup_type), intent(in) :: setup
    integer, intent(in) :: side            !! 1 left, 2 right
    type(table_type), intent(inout) :: table
    character(:), allocatable :: key, folder, path
    logical :: found

    call write_key(c, setup, side, key)
    call lay_out(law_of(c, setup%side(side)), key, table)
    if (c%table_folder == '') return
    call find_table_path(trim(c%table_folder), table, path)
    call load_values(path, table, found)
    call kept_folder(trim(c%table_folder), folder)
    if (folder == '' .or. folder == c%table_folder) return
    call find_table_path(folder, table, path)
    call load_values(path, table, found)
  end subroutine open_table

  !> Write what the tables have learnt to the folder, or to the cache. A file that cannot be written is no error, for it only saves
  !> time; then `warning` says so.
  subroutine keep_tables(c, setup, warning)
    type(case_type), intent(in) :: c
    type(setup_type), intent(in) :: setup
    type(error_type), allocatable, intent(out) :: warning
    character(:), allocatable :: folder

    if (c%table_folder == '') return
    call kept_folder(trim(c%table_folder), folder)
    if (folder == '') folder = trim(c%table_folder)      ! the warning names it
    call keep_table(setup%wheelset%table)
    if (.not. (setup%symmetric .or. allocated(warning))) call keep_table(setup%wheelset%right_table)

  contains

    subroutine keep_table(table)
      type(table_type), intent(inout) :: table
      character(:), allocatable :: path

      call find_table_path(folder, table, path)
      if (table%solutions(1) > table%kept) call save_values(path, table, warning)
      if (allocated(warning)) call place_error(warning, group='table', variable='folder')
    end subroutine keep_table

  end subroutine keep_tables

  !> The law of a side. It does not depend on the other side.
  type(law_type) function law_of(c, side)
    type(case_type), intent(in) :: c
    type(side_type), intent(in) :: side

    law_of = law_type(side, c%model(:9), c%influence(:6), c%stiffness_scale*contact_modulus(c%youngs_modulus, c%poisson), &
      c%extent, c%accuracy)
  end function law_of

  !> Free the tables that `open_tables` made.
  subroutine free_tables(setup)
    type(setup_type), intent(inout) :: setup

    associate (w => setup%wheelset)
      if (associated(w%right_table) .and. .not. associated(w%right_table, w%table)) deallocate (w%right_table)
      if (associated(w%table)) deallocate (w%table)
      nullify (w%right_table)
    end associate
  end subroutine free_tables

  !> Write all that the table of a side depends on beside the program, in words.
  subroutine write_key(c, setup, side, key)
    type(case_type), intent(in) :: c
    type(setup_type), intent(in) :: setup
    integer, intent(in) :: side            !! 1 left, 2 right
    character(:), allocatable, intent(out) :: key
    real(dp) :: inclination(2)

    key = 'model '//trim(c%model)//' profiles '//setup%wheel(side)%checksum//' '//setup%rail(side)%checksum// &
      ' gauge '//str(c%gauge)//' '//str(c%gauge_depth)// &
      ' back_to_back '//str(c%back_to_back)//' radius '//str(c%rolling_radius)//' E '//str(c%youngs_modulus)// &
      ' nu '//str(c%poisson)//' scale '//str(c%stiffness_scale)//' influence '//trim(c%influence)//' '//setup%bodies_sum// &
      ' extent '//str(c%extent%lateral)//' '//str(c%extent%lift)//' '//str(c%extent%drop)//' '//str(c%extent%roll)// &
      ' '//str(c%extent%depth)//' accuracy '//str(c%accuracy)
    inclination = inclinations(c)
    if (abs(inclination(side)) > 0) key = key//' inclination '//trim(shortest(inclination(side)))
  end subroutine write_key

end module run_tables
