!> Numbers of an open case that change without another contact table.
module changed_numbers
  use case, only: case_type, list_variables, variable_type
  use case_check, only: check_case
  use errors, only: error_type, fatal_error
  use kinds, only: dp
  use prepared_cases, only: prepared_type
  use run_setup, only: set_wheelset
  use text, only: lower
  implicit none
  private
  public :: get_number, set_number

contains

  !> A number of a case.
  subroutine get_number(p, name, value, error)
    type(prepared_type), intent(in) :: p
    character(*), intent(in) :: name
    real(dp), intent(out) :: value
    type(error_type), allocatable, intent(out) :: error
    type(case_type), allocatable, target :: c
    type(variable_type) :: variable

    value = 0
    allocate (c, source=p%c)
    call find_number(c, name, variable, error)
    if (.not. allocated(error)) value = variable%x
  end subroutine get_number

  !> Change a number of a case on which its table does not depend.
  subroutine set_number(p, name, value, error)
    type(prepared_type), intent(inout) :: p
    character(*), intent(in) :: name
    real(dp), intent(in) :: value
    type(error_type), allocatable, intent(out) :: error
    type(case_type), allocatable, target :: c
    type(variable_type) :: variable

    allocate (c, source=p%c)
    call find_number(c, name, variable, error)
    if (allocated(error)) return
    variable%x = value
    call check_case(trim(c%name), c, error)
    if (allocated(error)) return
    call set_wheelset(c, p%setup, error)
    if (.not. allocated(error)) p%c = c
  end subroutine set_number

  !> The variable of a number on which the contact table does not depend.
  subroutine find_number(c, name, variable, error)
    type(case_type), target, intent(inout) :: c
    character(*), intent(in) :: name
    type(variable_type), intent(out) :: variable     !! points into c
    type(error_type), allocatable, intent(out) :: error
    character(*), parameter :: groups = ' wheelset initial loading ', fixed = ' rolling_radius back_to_back '
    type(variable_type), allocatable :: list(:)
    integer :: k

    call list_variables(c, list)
    do k = 1, ubound(list, 1)
      if (lower(list(k)%name) /= lower(name) .or. .not. associated(list(k)%x)) cycle
      if (index(groups, ' '//list(k)%group//' ') == 0 .or. index(fixed, ' '//list(k)%name//' ') > 0) cycle
      variable = list(k)
      return
    end do
    call fatal_error(error, 'name: expected a number of &wheelset, &initial or &loading on which the contact table does not '// &
      'depend, found '//name)
  end subroutine find_number

end module changed_numbers
