!> The motion of a case at full precision, without stop conditions.
!>
!> usage: trajectory input.nml steps every [reverse] [weightless]
!> Takes `steps` steps dt from the initial conditions and writes time, y, z (axle centre
!> above top of rail), roll, their rates and the total energy less the work done, at the
!> start, after every `every` steps and after the last.
!> `reverse`: then reverses all velocities and takes as many steps again.
!> `weightless`: without gravity and vertical load; the equilibrium is still that with them.
program trajectory
  use case, only: case_type
  use shared, only: integer_argument, read_prepared
  use kinds, only: dp, gravity
  use motion_state, only: motion_type
  use newmark, only: advance, scheme_type, evaluate_contacts, step_ok
  use run_setup, only: setup_type
  use text, only: str
  implicit none
  save
  type(case_type) :: c
  type(setup_type) :: setup
  type(scheme_type) :: scheme
  type(motion_type) :: motion, new
  character(16) :: word
  integer :: steps, every, i, leg, evaluations, status
  logical :: reverse, weightless

  steps = integer_argument(2)
  every = integer_argument(3)
  reverse = .false.
  weightless = .false.
  do i = 4, command_argument_count()
    call get_command_argument(i, word)
    reverse = reverse .or. word == 'reverse'
    weightless = weightless .or. word == 'weightless'
  end do
  call read_prepared(c, setup)
  if (weightless) setup%wheelset%vertical_load = -setup%wheelset%mass*gravity

  scheme = scheme_type(c%scheme(:16), c%order, c%beta, c%gamma, c%tolerance, c%max_iterations)
  motion%q = setup%equilibrium + [c%y, c%z, c%roll]
  motion%v = [c%vy, c%vz, c%roll_rate]
  do leg = 1, merge(2, 1, reverse)
    if (leg == 2) motion = motion_type(t=motion%t, q=motion%q, v=-motion%v, contact=motion%contact)
    call evaluate_contacts(setup%wheelset, motion, status)
    if (status /= step_ok) error stop 'the start is not on the table: status '//str(status)
    call write_state()
    do i = 1, steps
      call advance(setup%wheelset, scheme, motion, c%dt, new, evaluations, status)
      if (status /= step_ok) error stop 'a step failed: status '//str(status)//' at t = '//str(motion%t)
      motion = new
      if (mod(i, every) == 0 .or. i == steps) call write_state()
    end do
  end do

contains

  subroutine write_state()
    associate (w => setup%wheelset)
      ! Left and right first: the mirrored motion has the same energy bit by bit.
      write (*, '(8es24.16)') motion%t, motion%q, motion%v, 0.5_dp*sum(w%inertia()*motion%v**2) &
        + (sum(motion%contact%energy(:2)) + sum(motion%contact%energy(3:))) &
        + w%weight()*(motion%q(2) - setup%equilibrium(2)) - motion%work
    end associate
  end subroutine write_state

end program trajectory
