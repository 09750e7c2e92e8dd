!> Lines of words and numbers that the summary for the terminal and the comments of files have in common.
module report_lines
  use case, only: case_type
  use contact_table, only: table_type
  use kinds, only: dp
  use profile, only: profile_type
  use run_monitor, only: run_type
  use run_setup, only: setup_type
  use service_poses, only: rollover_allowance
  use text, only: str, with_zero
  implicit none
  private
  public :: add_formulation, add_profiles, add_tables, add_warnings, add_run_warnings, table_points, plural, fixed
  public :: scientific, newline, zone_places

  character, parameter :: newline = new_line('a')
  character(10), parameter :: zone_places(4) = [character(10) :: 'tread', 'flange', 'both', 'going over']

contains

  !> Say what a rigid formulation means for the case.
  subroutine add_formulation(lines, c)
    character(:), allocatable, intent(inout) :: lines
    type(case_type), intent(in) :: c

    select case (c%formulation)
    case ('bilateral')
      lines = lines//'formulation bilateral: contacts are rigid, and both wheels are held on their rails; a negative N is a '// &
        'rail that pulls; P is an impulse where contact jumps along the wheel'//newline
    case ('unilateral')
      lines = lines//'formulation unilateral: contacts are rigid and only push, restitution '//str(c%restitution)// &
        '; N is the force of a contact that lasts, P is the sum of the impulses of impacts'//newline
    case default
      return
    end select
    lines = lines//'this formulation does not use &material, &contact model, &integrator scheme, order, beta, gamma, '// &
      'tolerance and max_iterations, and &table except lateral, roll and drop, at which a derailed run ends'//newline
  end subroutine add_formulation

  !> State the errors of the contact tables, with a warning if an error is larger than the case asks for.
  subroutine add_tables(lines, c, setup)
    character(:), allocatable, intent(inout) :: lines
    type(case_type), intent(in) :: c
    type(setup_type), intent(in) :: setup

    if (c%formulation /= 'elastic') return
    if (setup%symmetric) then
      call add_table(lines, c, 'contact table', setup%wheelset%table)
    else
      call add_table(lines, c, 'left contact table', setup%wheelset%table)
      call add_table(lines, c, 'right contact table', setup%wheelset%right_table)
    end if
  end subroutine add_tables

  subroutine add_table(lines, c, what, table)
    character(:), allocatable, intent(inout) :: lines
    type(case_type), intent(in) :: c
    character(*), intent(in) :: what
    type(table_type), intent(in) :: table
    integer :: k

    lines = lines//what//': model '//trim(c%model)//', '//trim(table_points(table))//' points'//newline
    if (any(table%accuracy%poses > 0)) then
      lines = lines//'error of the contact force, rms (largest), relative to max(|F|, 5 kN):'//newline
      do k = 1, size(zone_places)
        if (table%accuracy%poses(k) > 0) lines = lines//'  '//trim(zone_places(k))//' '//scientific(table%accuracy%rms(k))//' ('// &
          scientific(table%accuracy%largest(k))//')'//newline
      end do
    end if
    call add_warnings(lines, c, what, table)
  end subroutine add_table

  !> Points of a table by zone: across, over roll, over depth.
  function table_points(table) result(words)
    type(table_type), intent(in) :: table
    character(256) :: words
    integer :: z

    words = ''
    do z = 1, size(table%zones)
      associate (t => table%zones(z))
        if (z > 1) words = trim(words)//' +'
        words = trim(words)//' '//str(t%u%n)//' x '//str(table%roll%n)//' x '//str(t%q%n)
      end associate
    end do
    words = adjustl(words)
  end function table_points

  !> Warn of what a table does not fulfil: convergence, contacts that push, accuracy.
  subroutine add_warnings(lines, c, what, table)
    character(:), allocatable, intent(inout) :: lines
    type(case_type), intent(in) :: c
    character(*), intent(in) :: what
    type(table_type), intent(in) :: table

    if (table%solutions(2) > 0) lines = lines//'warning: '//what//': '//str(table%solutions(2))//' of '// &
      str(table%solutions(1))//' half-space solutions did not converge; see whether the error is larger than '// &
      '&table accuracy'//newline
    if (table%accuracy%unsolved > 0) lines = lines//'warning: '//what//': '//str(table%accuracy%unsolved)//' of '// &
      str(sum(table%accuracy%poses) + table%accuracy%unsolved)//' half-space solutions that its error is measured by '// &
      'did not converge; the stated error leaves them out'//newline
    if (table%accuracy%pulling > 0) lines = lines//'warning: '//what//': expected contacts that push in '// &
      'service, found '//str(table%accuracy%pulling)//' point'// &
      plural(table%accuracy%pulling == 1)//' at which the contact would pull, where a run stops; lower '// &
      '&table accuracy or raise n_lateral, n_roll, n_depth'//newline
    if (any(table%accuracy%poses > 0) .and. .not. all(table%accuracy%rms(:3) <= c%accuracy)) lines = lines//'warning: '//what// &
      ': expected an rms error of at most &table accuracy = '//str(c%accuracy)//' in service, reached '// &
      scientific(maxval(table%accuracy%rms(:3)))//newline
    if (table%accuracy%poses(4) > 0 .and. .not. table%accuracy%rms(4) <= rollover_allowance*c%accuracy) lines = lines// &
      'warning: '//what//': expected an rms error of at most '//str(nint(rollover_allowance))//' x &table accuracy while the '// &
      'wheelset rolls over a rail, reached '//scientific(table%accuracy%rms(4))//'; do not trust the end of a run that '// &
      'derails'//newline
  end subroutine add_warnings

  !> Warn of steps that may be unstable, and of a drift of the energy that makes a run doubtful.
  subroutine add_run_warnings(lines, run)
    character(:), allocatable, intent(inout) :: lines
    type(run_type), intent(in) :: run
    real(dp), parameter :: largest_drift = 0.01_dp   ! over the largest kinetic energy
    real(dp), parameter :: rounding = 1e-6_dp        ! of the energy of a wheelset at rest, at most [J]

    if (run%step > run%stable_step) lines = lines//'warning: &integrator dt: expected steps of at most '// &
      scientific(run%stable_step)//' s, the limit of stability at the highest frequency at rest, found '//scientific(run%step)// &
      ' s; lower dt'//newline
    if (run%drift > max(largest_drift*run%largest_energy, rounding)) lines = lines// &
      'warning: expected an energy drift of at most '// &
      str(nint(100*largest_drift))//' % of the largest kinetic energy, '//scientific(run%largest_energy)//' J, found '// &
      scientific(run%drift)//' J; lower &integrator dt or energy_tolerance'//newline
  end subroutine add_run_warnings

  !> Describe a profile in one line, or in a line per side if the sides have different profiles.
  subroutine add_profiles(lines, what, p)
    character(:), allocatable, intent(inout) :: lines
    character(*), intent(in) :: what
    type(profile_type), intent(in) :: p(2)

    if (p(1)%file == p(2)%file) then
      call add_profile(lines, what, p(1))
    else
      call add_profile(lines, 'left '//what, p(1))
      call add_profile(lines, 'right '//what, p(2))
    end if
  end subroutine add_profiles

  subroutine add_profile(lines, what, p)
    character(:), allocatable, intent(inout) :: lines
    character(*), intent(in) :: what
    type(profile_type), intent(in) :: p

    lines = lines//what//' profile: '//p%file//', CRC-32 '//p%checksum
    if (p%reconstruction) lines = lines//', RECONSTRUCTION (not the organisers'' file)'
    if (p%taken /= '') lines = lines//', '//p%taken
    lines = lines//newline
  end subroutine add_profile

  !> The ending of a noun behind a number: none behind 1.
  pure function plural(one) result(ending)
    logical, intent(in) :: one            !! the number is 1
    character(count([.not. one])) :: ending

    ending = 's'
  end function plural

  pure function written(form, x) result(word)
    character(*), intent(in) :: form
    real(dp), intent(in) :: x
    character(40) :: word

    write (word, form) x
    word = with_zero(adjustl(word))
    if (word(1:1) == '-' .and. verify(word, '-0. ') == 0) word = word(2:)      ! a small negative number, rounded to zero
  end function written

  pure function fixed(x, digits) result(word)
    real(dp), intent(in) :: x
    integer, intent(in) :: digits
    character(len_trim(written('(f0.'//str(digits)//')', x))) :: word

    word = written('(f0.'//str(digits)//')', x)
  end function fixed

  pure function scientific(x) result(word)
    real(dp), intent(in) :: x
    character(len_trim(written('(es9.2)', x))) :: word

    word = written('(es9.2)', x)
  end function scientific

end module report_lines
