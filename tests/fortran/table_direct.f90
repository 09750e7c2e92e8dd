!> Left-wheel contact forces at given poses, from the table and by direct evaluation.
!>
!> usage: table_direct input.nml < poses
!> Reads lines `y z roll` (axle centre above top of rail) from standard input; writes
!> for tread and flange: F_y, F_z, M_x from the table, the same directly.
program table_direct
  use case, only: case_type, read_case
  use contact, only: set_moduli, zone_force
  use errors, only: error_type
  use geometry, only: new_scan, scan_depth, scan_type
  use hertz, only: contact_modulus
  use kinds, only: dp
  use simulation, only: prepare, setup_type
  use table, only: wheel_potential
  use text, only: line_type, read_lines
  implicit none
  type(case_type) :: c
  type(setup_type) :: setup
  type(error_type), allocatable :: error
  type(line_type), allocatable :: lines(:)
  type(scan_type) :: work
  real(dp), allocatable :: k(:)
  real(dp) :: pose(3), energy(2), gradient(3, 2), hessian(6), direct(3, 2), e_star
  character(256) :: file
  integer :: stat, status, i, branch

  call get_command_argument(1, file)
  call read_lines(trim(file), lines, error)
  if (.not. allocated(error)) call read_case(trim(file), lines, c, error)
  if (.not. allocated(error)) call prepare(c, setup, error)
  if (allocated(error)) error stop error%message
  e_star = c%stiffness_scale*contact_modulus(c%youngs_modulus, c%poisson)
  allocate (k(size(setup%pair%s)))
  do
    read (*, *, iostat=stat) pose
    if (stat /= 0) exit
    call wheel_potential(setup%wheelset%table, pose, energy, gradient, hessian, status)
    if (status /= 0) error stop 'a pose is not on the table'
    direct = 0
    do i = 1, size(setup%zones)
      work = new_scan(setup%pair)
      branch = merge(2, 1, setup%zones(i)%flange)
      call set_moduli(setup%pair, setup%zones(i), e_star, pose(3), k)
      call scan_depth(setup%pair, pose(1:2), pose(3), setup%zones(i)%first, setup%zones(i)%last, work)
      direct(:, branch) = direct(:, branch) + zone_force(setup%pair, setup%zones(i), pose(3), work, k)
    end do
    write (*, '(12es24.16)') (-gradient(:, branch), direct(:, branch), branch=1, 2)
  end do
end program table_direct
