!> Left-wheel contact forces at given poses, from the table of the case's model and
!> from direct half-space solutions.
!>
!> usage: halfspace_direct input.nml < poses
!> Reads lines `y z roll` (axle centre above top of rail) from standard input; writes
!> for tread and flange: F_y, F_z, M_x from the table, the same directly.
program halfspace_direct
  use case, only: case_type, read_case
  use contact, only: branch_energy
  use errors, only: error_type
  use geometry, only: new_scan, scan_depth, scan_type
  use hertz, only: contact_modulus
  use kinds, only: dp
  use potential, only: wheel_potential
  use simulation, only: prepare, setup_type
  use text, only: line_type, read_lines
  implicit none
  type(case_type) :: c
  type(setup_type) :: setup
  type(error_type), allocatable :: error
  type(line_type), allocatable :: lines(:)
  type(scan_type) :: work
  real(dp) :: pose(3), energy(2), gradient(3, 2), hessian(6), direct(3, 2), e_star, exact
  character(256) :: file
  integer :: stat, status, branch, first, last
  logical :: ok

  call get_command_argument(1, file)
  call read_lines(trim(file), lines, error)
  if (.not. allocated(error)) call read_case(trim(file), lines, c, error)
  if (.not. allocated(error)) call prepare(c, setup, error)
  if (allocated(error)) error stop error%message
  e_star = c%stiffness_scale*contact_modulus(c%youngs_modulus, c%poisson)
  do
    read (*, *, iostat=stat) pose
    if (stat /= 0) exit
    call wheel_potential(setup%wheelset%table, pose, energy, gradient, status, hessian)
    if (status /= 0) error stop 'a pose is not on the table'
    do branch = 1, 2
      first = minval(setup%zones%first, setup%zones%flange .eqv. branch == 2)
      last = maxval(setup%zones%last, setup%zones%flange .eqv. branch == 2)
      work = new_scan(setup%pair)
      call scan_depth(setup%pair, pose(1:2), pose(3), first, last, work)
      call branch_energy(setup%pair, first, last, e_star, pose(1:2), pose(3), work, exact, ok, &
        direct(:, branch))
      if (.not. ok) error stop 'the half-space solution failed'
    end do
    write (*, '(12es24.16)') (-gradient(:, branch), direct(:, branch), branch=1, 2)
  end do
end program halfspace_direct
