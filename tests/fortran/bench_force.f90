!> Time of the wheelset's contact forces at the poses of a run: looked up, with and without the tangent,
!> by direct evaluation of the strips and by half-space solutions.
!>
!> usage: bench_force input.nml poses rounds repeats stride
!> Writes, per round, the processor time per pose [s] of force and tangent from the table, force from the table, direct,
!> half-spaces; the table loops `repeats` times over the poses of the binary file (`read_poses` has its format), the half-spaces
!> take every `stride`-th pose. The last line has the mean number of touching zones of both wheels and a sum that keeps the loops
!> alive.
program bench_force
  use case, only: case_type
  use shared, only: direct_type, integer_argument, new_direct, read_poses, read_prepared, wheel_contact, zone_contact
  use kinds, only: dp
  use run_setup, only: setup_type
  use wheel_rail_pair, only: mirror
  use wheelset, only: contact_state, contacts
  implicit none
  save
  type(case_type) :: c
  type(setup_type) :: setup
  type(direct_type) :: direct
  type(contact_state) :: state
  real(dp), allocatable :: pose(:, :)
  integer, allocatable :: touching(:)
  real(dp) :: total, from, to, seconds(4)
  integer :: n, i, round, rounds, repeat, repeats, stride

  call read_prepared(c, setup)
  call read_poses(pose)
  n = size(pose, 2)
  rounds = integer_argument(3)
  repeats = integer_argument(4)
  stride = integer_argument(5)
  allocate (touching(n))
  direct = new_direct(c, setup)
  total = 0
  do round = 1, rounds
    seconds(1) = looked_up(with_hessian=.true.)
    seconds(2) = looked_up(with_hessian=.false.)

    call cpu_time(from)
    touching = 0
    do i = 1, n
      call evaluate_strips(pose(:, i), touching(i))
      call evaluate_strips(mirror*pose(:, i), touching(i))
    end do
    call cpu_time(to)
    seconds(3) = (to - from)/n

    call cpu_time(from)
    do i = 1, n, stride
      call solve_halfspace(pose(:, i))
      call solve_halfspace(mirror*pose(:, i))
    end do
    call cpu_time(to)
    seconds(4) = (to - from)/((n - 1)/stride + 1)
    write (*, '(4es12.4)') seconds
  end do
  write (*, '(f0.4, es12.4)') sum(touching)/real(n, dp), total

contains

  !> Time of an evaluation from the table [s].
  real(dp) function looked_up(with_hessian) result(seconds)
    logical, intent(in) :: with_hessian

    call cpu_time(from)
    do repeat = 1, repeats
      do i = 1, n
        call contacts(setup%wheelset, pose(:, i), state, with_hessian)
        if (state%status /= 0) error stop 'a pose is not on the table'
        total = total + state%gradient(2) + state%hessian(4)
      end do
    end do
    call cpu_time(to)
    seconds = (to - from)/(real(n, dp)*repeats)
  end function looked_up

  !> Force and energy of the left wheel by its strips; counts the zones that touch.
  subroutine evaluate_strips(q, touching)
    real(dp), intent(in) :: q(3)
    integer, intent(inout) :: touching
    real(dp) :: energy, force(3)
    integer :: z

    do z = 1, size(setup%side(1)%zones)
      call zone_contact(direct, setup, z, q, energy, force)
      if (energy > 0) touching = touching + 1
      total = total + energy + force(2)
    end do
  end subroutine evaluate_strips

  !> Force and energy of the left wheel by the half-space.
  subroutine solve_halfspace(q)
    real(dp), intent(in) :: q(3)
    real(dp) :: energy, force(3, 2)

    call wheel_contact(direct, setup, q, energy, force)
    total = total + energy + sum(force(2, :))
  end subroutine solve_halfspace

end program bench_force
