!> Time of evaluating the wheelset's contact forces at many poses.
!>
!> usage: force_loop input.nml poses [tangent]
!> Writes the seconds of the best of five loops over the poses of the binary file (`read_poses` has
!> its format) and the sum of the forces.  With `tangent` the tangent stiffness is evaluated too.
program force_loop
  use, intrinsic :: iso_fortran_env, only: int64
  use case, only: case_type
  use shared, only: read_poses, read_prepared
  use kinds, only: dp
  use run_setup, only: setup_type
  use wheelset, only: contact_state, contacts
  implicit none
  save
  type(case_type) :: c
  type(setup_type) :: setup
  type(contact_state) :: state
  real(dp), allocatable :: pose(:, :), force(:, :)
  real(dp) :: best
  integer(int64) :: from, to, rate
  integer :: i, round
  character(7) :: word

  call read_prepared(c, setup)
  call read_poses(pose)
  call get_command_argument(3, word)
  allocate (force, mold=pose)
  best = huge(best)
  do round = 1, 5
    call system_clock(from, rate)
    do i = 1, size(pose, 2)
      call contacts(setup%wheelset, pose(:, i), state, tangent=word == 'tangent')
      if (state%status /= 0) error stop 'a pose is not on the table'
      force(:, i) = -state%gradient
    end do
    call system_clock(to)
    best = min(best, real(to - from, dp)/rate)
  end do
  write (*, '(f0.6, es24.16)') best, sum(force)
end program force_loop
