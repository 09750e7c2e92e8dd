!> Time of evaluating the wheelset's contact forces at many poses.
!>
!> usage: force_loop input.nml poses
!> Reads n and the n poses `y`, `z`, `roll` (8-byte reals, one array after the other) from the
!> binary file; writes the seconds of the best of five loops and the sum of the forces.
program force_loop
  use, intrinsic :: iso_fortran_env, only: int64
  use case, only: case_type, read_case
  use errors, only: error_type
  use kinds, only: dp
  use simulation, only: prepare, setup_type
  use text, only: line_type, read_lines
  use wheelset, only: contact_state, contacts
  implicit none
  type(case_type) :: c
  type(setup_type) :: setup
  type(error_type), allocatable :: error
  type(line_type), allocatable :: lines(:)
  type(contact_state) :: state
  real(dp), allocatable :: pose(:, :), force(:, :)
  real(dp) :: best
  integer(int64) :: n, from, to, rate
  integer :: unit, i, round
  character(256) :: file

  call get_command_argument(1, file)
  call read_lines(trim(file), lines, error)
  if (.not. allocated(error)) call read_case(trim(file), lines, c, error)
  if (.not. allocated(error)) call prepare(c, setup, error)
  if (allocated(error)) error stop error%message
  call get_command_argument(2, file)
  open (newunit=unit, file=trim(file), access='stream', form='unformatted', status='old', action='read')
  read (unit) n
  allocate (pose(n, 3), force(3, n))
  read (unit) pose
  best = huge(best)
  do round = 1, 5
    call system_clock(from, rate)
    do i = 1, int(n)
      call contacts(setup%wheelset, [pose(i, 1), pose(i, 2), pose(i, 3)], state)
      if (state%status /= 0) error stop 'a pose is not on the table'
      force(:, i) = -state%gradient
    end do
    call system_clock(to)
    best = min(best, real(to - from, dp)/rate)
  end do
  write (*, '(f0.6, es24.16)') best, sum(force)
end program force_loop
