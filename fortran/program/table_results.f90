!> Texts about the contact tables of a run.
module table_results
  use case, only: case_type
  use contact_table, only: table_type
  use kinds, only: dp
  use places, only: kept_folder
  use judged_poses, only: accuracy_type
  use contact_law, only: floored_force
  use results, only: newline, result_list, rounded
  use run_setup, only: setup_type
  use text, only: joined, str
  implicit none
  private
  public :: list_tables, list_accuracy, list_work

  character(*), parameter :: scientific = 'es9.2'
  real(dp), parameter :: going_over = 10     !! errors allowed there, relative to those on both rails

contains

  !> Points of the contact tables of a case with elastic contacts.
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

  !> Points of a contact table.
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
  end subroutine list_table

  !> Error of the contact forces in poses of the run, and warnings where it is larger than the case asks for.
  subroutine list_accuracy(c, accuracy, items)
    type(case_type), intent(in) :: c
    type(accuracy_type), intent(in) :: accuracy
    type(result_list), intent(inout) :: items
    character(10), parameter :: group(4) = [character(10) :: 'tread', 'flange', 'both', 'going over']   ! of poses
    integer :: k

    associate (poses => accuracy%poses, rms => accuracy%rms, unsolved => accuracy%unsolved)
      if (all(poses == 0)) return
      call items%append('error of the contact force in poses of the run, rms (largest), relative to '//floored_force//':'//newline)
      do k = 1, size(group)
        if (poses(k) > 0) call items%add('table_error_'//joined(group(k)), [rms(k), accuracy%largest(k)], &
          '', '  '//trim(group(k))//' # (#)'//newline, scientific)
      end do
      if (unsolved > 0) call items%warn(str(unsolved)//' of '//str(sum(poses) + unsolved)// &
        ' direct solutions of contacts did not converge; the error of the contact force leaves them out')
      if (.not. all(rms(:3) <= c%accuracy)) call items%warn('contact force: expected an rms error of at most '// &
        '&table accuracy = '//str(c%accuracy)//' on the tread, on the flange and on both at once, found '// &
        trim(rounded(maxval(rms(:3)), scientific)))
      if (.not. rms(4) <= going_over*c%accuracy) call items%warn('contact force: expected an rms error '// &
        'of at most '//str(nint(going_over))//' x &table accuracy while the wheelset goes over a rail, found '// &
        trim(rounded(rms(4), scientific))//'; do not trust the end of a run that derails')
    end associate
  end subroutine list_accuracy

  !> Half-space solutions, of which results do not depend on how many files found, and processor time.
  subroutine list_work(c, setup, seconds, items)
    type(case_type), intent(in) :: c
    type(setup_type), intent(in) :: setup
    real(dp), intent(in) :: seconds             !! for the integration
    type(result_list), intent(inout) :: items
    character(:), allocatable :: folder
    integer :: solved, found, failed

    if (c%formulation == 'elastic') then
      associate (left => setup%wheelset%table, right => setup%wheelset%right_table)
        solved = left%solutions(1)
        found = left%found
        failed = left%solutions(2)
        if (.not. setup%symmetric) then
          solved = solved + right%solutions(1)
          found = found + right%found
          failed = failed + right%solutions(2)
        end if
      end associate
      call items%append('contact table: '//str(solved - found)//' solutions, '//str(found)//' found')
      if (failed > 0) call items%append('; '//str(failed)//' did not converge')
      call kept_folder(trim(c%table_folder), folder)
      if (folder /= '' .and. folder /= c%table_folder) call items%append('; kept in '//folder)
      call items%append(newline)
    end if
    call items%add('', [setup%seconds, seconds], '', 'processor time [s]: preparation #, integration #'//newline, 'f0.2')
  end subroutine list_work

end module table_results
