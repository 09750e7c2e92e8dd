!> Conditions that a case from a file or from Python must satisfy before it is run.
module case_check
  use, intrinsic :: iso_fortran_env, only: input_unit
  use case, only: admissible, case_type, list_variables, output_path, range_text, text_length, value_text, variable_type
  use errors, only: error_type, refuse
  use kinds, only: dp
  use links_and_modes, only: follow_links
  use places, only: find_file, folder_of
  use system, only: default_folder, lacks_folder, last_slash, scratch_file
  use text, only: lower, str
  implicit none
  private
  public :: check_case, check_writable

contains

  !> Check every range, because a case need not come from a file, and the conditions that several variables must satisfy
  !> together.
  subroutine check_case(file, c, error)
    character(*), intent(in) :: file
    type(case_type), target, intent(inout) :: c
    type(error_type), allocatable, intent(out) :: error
    type(variable_type), allocatable :: list(:)
    integer :: k

    call list_variables(c, list)
    do k = 1, size(list)
      if (admissible(list(k))) cycle
      call refuse(error, trim(range_text(list(k))), value_text(list(k)), file, group=list(k)%group, variable=list(k)%name)
      return
    end do
    call demand(len_trim(c%name) > 0 .and. scan(trim(c%name), '/\ ') == 0, 'case', 'name', 'a word that can name a file', &
      "'"//trim(c%name)//"'")
    call demand(any(c%order == [2, 4]), 'integrator', 'order', '2 or 4', str(c%order))
    call demand(c%order == 2 .or. c%beta <= 0, 'integrator', 'beta', '0 with order = '//str(c%order), str(c%beta))
    call demand(c%order == 2 .or. c%gamma <= 0.5_dp, 'integrator', 'gamma', '0.5 with order = '//str(c%order), str(c%gamma))
    call demand(c%formulation == 'unilateral' .or. c%restitution >= 1, 'contact', 'restitution', '1, for only formulation = '// &
      '''unilateral'' has impacts', str(c%restitution)//' with '''//trim(c%formulation)//'''')
    call demand(c%formulation == 'elastic' .or. abs(c%stiffness_scale - 1) <= 0, 'contact', 'stiffness_scale', &
      '1, for contacts are rigid with formulation = '''//trim(c%formulation)//'''', str(c%stiffness_scale))
    call demand(c%influence /= 'bodies' .or. c%bodies /= '', 'contact', 'bodies', &
      'a file made by python -m ldbench bodies, with influence = ''bodies''', 'none')
    call demand(c%influence /= 'bodies' .or. c%model == 'halfspace', 'contact', 'influence', &
      'model = ''halfspace'' with influence = ''bodies''', ''''//trim(c%model)//'''')
    call demand(c%interval >= c%dt, 'output', 'interval', 'at least the step &integrator dt = '//str(c%dt)//' s', str(c%interval))
    call demand(c%interval/c%dt <= 1e9_dp, 'integrator', 'dt', 'at most 1e9 steps between rows', str(c%interval/c%dt))
    call demand(c%interval <= c%t_end, 'output', 'interval', 'at most &integrator t_end = '//str(c%t_end)//' s', str(c%interval))
    call demand(c%t_end/c%interval <= 1e7_dp, 'output', 'interval', 'at most 1e7 rows up to t_end', str(c%t_end/c%interval))
    if (.not. allocated(error)) call check_files(file, c, error)

  contains

    !> Refuse a variable that does not fit the others, unless one before it was refused.
    subroutine demand(ok, group, variable, expected, found)
      logical, intent(in) :: ok
      character(*), intent(in) :: group, variable, expected, found

      if (ok .or. allocated(error)) return
      call refuse(error, expected, found, file, group=group, variable=variable)
    end subroutine demand

  end subroutine check_case

  !> The column file must not be another file of the case.
  subroutine check_files(file, c, error)
    character(*), intent(in) :: file
    type(case_type), intent(in) :: c
    type(error_type), allocatable, intent(out) :: error
    character(29), parameter :: names(6) = [character(29) :: 'the namelist itself', '&profiles wheel_profile', &
      '&profiles rail_profile', '&profiles wheel_profile_right', '&profiles rail_profile_right', '&contact bodies']
    character(max(len(file), text_length)) :: paths(size(names))
    character(:), allocatable :: found
    type(error_type), allocatable :: missing
    integer :: i

    paths = [character(len(paths)) :: file, c%wheel_profile, c%rail_profile, c%wheel_profile_right, c%rail_profile_right, c%bodies]
    if (c%influence /= 'bodies') paths(6) = ''
    if (file == 'standard input') paths(1) = '-'
    do i = 1, size(names)
      if (paths(i) == '') cycle
      found = trim(paths(i))
      if (i > 1 .and. same_name(trim(output_path(c)), found)) call find_file(c%places, trim(paths(i)), found, missing)
      if (.not. same_file(trim(output_path(c)), found)) cycle
      call refuse(error, 'a file of its own', trim(output_path(c))//', which is '//trim(names(i)), file, group='output', &
        variable='file')
      return
    end do
  end subroutine check_files

  !> Whether a file that is written has the path of another file, which need not be there yet. `other` may be '-', standard
  !> input. Two paths of one name lead to the same folder if a new file beside one of them is beside the other, too.
  logical function same_file(written, other)
    character(*), intent(in) :: written, other
    type(scratch_file) :: probe
    character(:), allocatable :: a, b          ! where links lead to
    integer :: unit

    if (other == '-') then
      inquire (file=written, number=unit)
      same_file = unit == input_unit
      return
    end if
    call follow_links(written, a)
    call follow_links(other, b)
    same_file = a == b
    if (same_file .or. .not. same_name(a, b)) return
    if (.not. lacks_folder(a)) call probe%begin(a)
    if (probe%ok) inquire (file=b//probe%ending, exist=same_file)
    call probe%abandon()
  end function same_file

  !> Whether two paths end with the same name of a file, but for capitals.
  pure logical function same_name(one, other)
    character(*), intent(in) :: one, other

    same_name = lower(one(last_slash(one) + 1:)) == lower(other(last_slash(other) + 1:))
  end function same_name

  !> Check before the computation that the column file can be written.
  subroutine check_writable(file, path, error)
    character(*), intent(in) :: file             !! for the message
    character(*), intent(in) :: path             !! of the column file
    type(error_type), allocatable, intent(out) :: error
    character(:), allocatable :: first         ! that is written
    character(:), allocatable :: folder, advice
    type(scratch_file) :: probe
    logical :: there

    first = path
    if (lacks_folder(path)) first = default_folder
    call probe%begin(first)
    call probe%abandon()
    if (probe%ok) return
    call folder_of(path, folder)
    inquire (file=folder//'/.', exist=there)
    advice = '; go to a folder where you may write, or name a file in one'
    if (.not. (there .or. folder == default_folder)) advice = '; make the folder '//folder//', or name a file in another one'
    call refuse(error, 'a path that can be written', path, file, group='output', variable='file', rest=advice)
  end subroutine check_writable

end module case_check
