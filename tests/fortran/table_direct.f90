!> Left-wheel contact at given poses, from the table and by direct evaluation.
!>
!> usage: table_direct input.nml < poses
!> Reads lines `y z roll` (axle centre above top of rail) from standard input; writes for
!> tread, then flange: F_y, F_z, M_x and energy from the table, the same directly.  The
!> direct force is that of strips, whatever the model.
program table_direct
  use case, only: case_type, read_case
  use contact, only: set_moduli, zone_energy, zone_force
  use errors, only: error_type
  use geometry, only: new_scan, scan_depth, scan_type
  use hertz, only: contact_modulus
  use kinds, only: dp
  use simulation, only: prepare, setup_type
  use text, only: line_type, read_lines
  use wheelset, only: contact_state, contacts
  implicit none
  type(case_type) :: c
  type(setup_type) :: setup
  type(error_type), allocatable :: error
  type(line_type), allocatable :: lines(:)
  type(scan_type) :: work
  real(dp), allocatable :: k(:)
  type(contact_state) :: state
  real(dp) :: pose(3), direct(3, 2), direct_energy(2), e_star
  character(256) :: file
  integer :: stat, i, branch

  call get_command_argument(1, file)
  call read_lines(trim(file), lines, error)
  if (.not. allocated(error)) call read_case(trim(file), lines, c, error)
  if (.not. allocated(error)) call prepare(c, setup, error)
  if (allocated(error)) error stop error%message
  e_star = c%stiffness_scale*contact_modulus(c%youngs_modulus, c%poisson)
  allocate (k(size(setup%pair%s)))
  work = new_scan(setup%pair)
  do
    read (*, *, iostat=stat) pose
    if (stat /= 0) exit
    call contacts(setup%wheelset, pose, state)
    if (state%status /= 0) error stop 'a pose is not on the table'
    direct = 0
    direct_energy = 0
    do i = 1, size(setup%zones)
      associate (zone => setup%zones(i))
        work%fresh = .true.
        branch = merge(2, 1, zone%flange)
        call set_moduli(setup%pair, zone, e_star, pose(3), k)
        call scan_depth(setup%pair, pose(1:2), pose(3), zone%first, zone%last, work)
        direct(:, branch) = direct(:, branch) + zone_force(setup%pair, zone, pose(3), work, k)
        direct_energy(branch) = direct_energy(branch) &
          + zone_energy(setup%pair, zone, trim(c%model), e_star, pose(3), work, k)
      end associate
    end do
    write (*, '(16es24.16)') (-state%slope(:, branch), state%energy(branch), direct(:, branch), &
      direct_energy(branch), branch=1, 2)
  end do
end program table_direct
