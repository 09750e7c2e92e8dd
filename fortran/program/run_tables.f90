!> The contact tables of a run.
module run_tables
  use case, only: case_type, right_table_path, text_length
  use contact_law, only: law_type
  use contact_table, only: table_type
  use contact_zones, only: side_type
  use errors, only: error_type
  use fingerprint, only: table_sources
  use hertz, only: contact_modulus
  use kinds, only: dp
  use profile, only: profile_type
  use run_setup, only: setup_type
  use table_file, only: load_values, save_values
  use table_layout, only: lay_out
  use text, only: str
  implicit none
  private
  public :: open_tables, keep_tables, free_tables

contains

  !> Make the contact tables of both sides, with what their files keep. Sides with the same profiles share one.
  subroutine open_tables(c, setup, error)
    type(case_type), intent(in) :: c
    type(setup_type), intent(inout) :: setup
    type(error_type), allocatable, intent(out) :: error

    allocate (setup%wheelset%table)
    setup%wheelset%right_table => setup%wheelset%table
    if (.not. setup%symmetric) allocate (setup%wheelset%right_table)
    call open_table(c, setup, 1, setup%wheelset%table, error)
    if (.not. (setup%symmetric .or. allocated(error))) call open_table(c, setup, 2, setup%wheelset%right_table, error)
  end subroutine open_tables

  subroutine open_table(c, setup, side, table, error)
    type(case_type), intent(in) :: c
    type(setup_type), intent(in) :: setup
    integer, intent(in) :: side            !! 1 left, 2 right
    type(table_type), intent(inout) :: table
    type(error_type), allocatable, intent(out) :: error
    logical :: found

    call lay_out(law_of(c, setup%side(side)), table_key(c, setup%wheel(side), setup%rail(side)), table)
    table%threshold = setup%side(side)%threshold
    if (path_of(c, side) /= '') call load_values(path_of(c, side), table, found, error)
  end subroutine open_table

  !> Write what the tables have learnt to their files. A file that cannot be written is no error, for it only saves time; then
  !> `warning` says so.
  subroutine keep_tables(c, setup, warning)
    type(case_type), intent(in) :: c
    type(setup_type), intent(in) :: setup
    type(error_type), allocatable, intent(out) :: warning

    call keep_table(path_of(c, 1), setup%wheelset%table, warning)
    if (.not. (setup%symmetric .or. allocated(warning))) call keep_table(path_of(c, 2), setup%wheelset%right_table, warning)
  end subroutine keep_tables

  subroutine keep_table(path, table, warning)
    character(*), intent(in) :: path
    type(table_type), intent(inout) :: table
    type(error_type), allocatable, intent(out) :: warning

    if (path /= '' .and. table%solutions(1) > table%kept) call save_values(path, table, warning)
  end subroutine keep_table

  !> The file of a side's table.
  function path_of(c, side) result(path)
    type(case_type), intent(in) :: c
    integer, intent(in) :: side            !! 1 left, 2 right
    character(:), allocatable :: path

    if (side == 1) path = trim(c%table_file)
    if (side == 2) path = trim(right_table_path(c))
  end function path_of

  !> The law of a side. It does not depend on the other side.
  type(law_type) function law_of(c, side)
    type(case_type), intent(in) :: c
    type(side_type), intent(in) :: side

    law_of = law_type(side, c%model(:9), c%influence(:5), c%stiffness_scale*contact_modulus(c%youngs_modulus, c%poisson), &
      c%extent, c%accuracy)
  end function law_of

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
  function table_key(c, wheel, rail) result(key)
    type(case_type), intent(in) :: c
    type(profile_type), intent(in) :: wheel, rail
    character(:), allocatable :: key

    key = 'ldbench '//table_sources//' model '//trim(c%model)//' profiles '//wheel%checksum//' '//rail%checksum// &
      ' gauge '//str(c%gauge)//' '//str(c%gauge_depth)// &
      ' back_to_back '//str(c%back_to_back)//' radius '//str(c%rolling_radius)//' E '//str(c%youngs_modulus)// &
      ' nu '//str(c%poisson)//' scale '//str(c%stiffness_scale)//' influence '//trim(c%influence)// &
      ' extent '//str(c%extent%lateral)//' '//str(c%extent%lift)//' '//str(c%extent%drop)//' '//str(c%extent%roll)// &
      ' '//str(c%extent%depth)//' accuracy '//str(c%accuracy)
  end function table_key

end module run_tables
