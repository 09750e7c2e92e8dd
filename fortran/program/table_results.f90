!> Texts about the contact tables of a run.
module table_results
  use case, only: case_type
  use contact_table, only: table_type
  use results, only: newline, result_list, rounded
  use run_setup, only: setup_type
  use service_poses, only: floored_force, rollover_allowance
  use text, only: joined, str
  implicit none
  private
  public :: list_tables

  character(*), parameter :: scientific = 'es9.2'

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
    character(10), parameter :: group(4) = [character(10) :: 'tread', 'flange', 'both', 'going over']   ! of poses
    character(:), allocatable :: points
    integer :: k

    points = ''
    do k = 1, size(table%zones)
      if (k > 1) points = points//' + '
      points = points//str(table%zones(k)%u%n)//' x '//str(table%roll%n)//' x '//str(table%zones(k)%q%n)
    end do
    call items%add('table_points'//side, points, what//': model '//trim(c%model)//', # points'//newline)
    associate (poses => table%accuracy%poses, rms => table%accuracy%rms, unsolved => table%accuracy%unsolved)
      if (any(poses > 0)) call items%append('error of the contact force, rms (largest), relative to '//floored_force//':'//newline)
      do k = 1, size(group)
        if (poses(k) > 0) call items%add('table_error_'//joined(group(k))//side, [rms(k), table%accuracy%largest(k)], &
          'rms and largest, of '//floored_force, '  '//trim(group(k))//' # (#)'//newline, scientific)
      end do
      if (table%solutions(2) > 0) call items%warn(what//': '//str(table%solutions(2))//' of '//str(table%solutions(1))// &
        ' half-space solutions did not converge; its stated error shows whether that matters')
      if (unsolved > 0) call items%warn(what//': '//str(unsolved)//' of '//str(sum(poses) + unsolved)// &
        ' poses for its error did not converge; the stated error leaves them out')
      if (any(poses > 0) .and. .not. all(rms(:3) <= c%accuracy)) call items%warn(what//': expected an rms error of at most '// &
        '&table accuracy = '//str(c%accuracy)//' of a wheel''s force on the tread, on the flange and on both at once, reached '// &
        trim(rounded(maxval(rms(:3)), scientific))//'; raise &table n_lateral, n_roll or n_depth, or accept this error')
      if (poses(4) > 0 .and. .not. rms(4) <= rollover_allowance*c%accuracy) call items%warn(what//': expected an rms error '// &
        'of at most '//str(nint(rollover_allowance))//' x &table accuracy while the wheelset rolls over a rail, reached '// &
        trim(rounded(rms(4), scientific))//'; do not trust the end of a run that derails')
    end associate
  end subroutine list_table

end module table_results
