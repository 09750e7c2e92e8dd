!> Texts about the contact tables of a run.
module table_results
  use case, only: case_type
  use contact_table, only: table_type
  use results, only: newline, result_list
  use run_setup, only: setup_type
  use text, only: str
  implicit none
  private
  public :: list_tables

contains

  !> Points and errors of the contact tables of a case with elastic contacts.
  subroutine list_tables(c, setup, items)
    type(case_type), intent(in) :: c
    type(setup_type), intent(in) :: setup
    type(result_list), intent(inout) :: items

    if (c%formulation /= 'elastic') return
    if (setup%symmetric) then
      call list_table(c, 'contact table', '', setup%wheelset%table, items)
    else
      call list_table(c, 'left contact table', '', setup%wheelset%table, items)
      call list_table(c, 'right contact table', '_right', setup%wheelset%right_table, items)
    end if
  end subroutine list_tables

  !> Points and errors of a contact table, and warnings of what the table does not fulfil: convergence, contacts that push,
  !> accuracy.
  subroutine list_table(c, what, side, table, items)
    type(case_type), intent(in) :: c
    character(*), intent(in) :: what             !! on the terminal
    character(*), intent(in) :: side             !! '' or '_right'
    type(table_type), intent(in) :: table
    type(result_list), intent(inout) :: items
    character(:), allocatable :: points
    integer :: k

    points = ''
    do k = 1, size(table%zones)
      if (k > 1) points = points//' + '
      points = points//str(table%zones(k)%u%n)//' x '//str(table%roll%n)//' x '//str(table%zones(k)%q%n)
    end do
    call items%add('table_points'//side, points, what//': model '//trim(c%model)//', # points'//newline)
    if (table%solutions(2) > 0) call items%warn(what//': '//str(table%solutions(2))//' of '//str(table%solutions(1))// &
      ' half-space solutions did not converge; see whether the error is larger than &table accuracy')
  end subroutine list_table

end module table_results
