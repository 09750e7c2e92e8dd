!> What the programs beside it share: the case they are given, and contact of the left wheel
!> by direct evaluation.
module shared
  use, intrinsic :: iso_fortran_env, only: int64
  use case, only: case_type
  use case_reader, only: read_case
  use strip_law, only: set_moduli, zone_energy, zone_force
  use errors, only: error_type
  use station_scan, only: new_scan, scan_depth, scan_type
  use hertz, only: contact_modulus
  use kinds, only: dp
  use halfspace_patches, only: patches_type, press_patches
  use patch_grids, only: elements_type, new_elements
  use run_setup, only: setup_type
  use simulation, only: prepare
  use text, only: line_type, read_lines
  implicit none
  private
  public :: read_prepared, read_poses, integer_argument, direct_type, new_direct, zone_contact, branch_contact

  !> For direct evaluation.
  type :: direct_type
    character(:), allocatable :: model
    real(dp) :: e_star = 0             !! [Pa]
    real(dp), allocatable :: k(:)      !! moduli of the strips
    type(scan_type) :: work
    type(elements_type) :: elements    ! of half-spaces
  end type direct_type

contains

  !> The case of the namelist file that is the first argument, ready to be integrated.
  subroutine read_prepared(c, setup)
    type(case_type), intent(out) :: c
    type(setup_type), intent(out) :: setup
    type(error_type), allocatable :: error
    type(line_type), allocatable :: lines(:)
    character(256) :: file

    call get_command_argument(1, file)
    call read_lines(trim(file), lines, error)
    if (.not. allocated(error)) call read_case(trim(file), lines, c, error)
    if (.not. allocated(error)) call prepare(c, setup, error)
    if (allocated(error)) error stop error%message
  end subroutine read_prepared

  !> Poses (y z roll, pose) of the binary file that is the second argument: n, then the n of `y`, `z`,
  !> `roll` (8-byte reals, one array after the other).
  subroutine read_poses(pose)
    real(dp), allocatable, intent(out) :: pose(:, :)
    real(dp), allocatable :: columns(:, :)
    integer(int64) :: n
    integer :: unit
    character(256) :: file

    call get_command_argument(2, file)
    open (newunit=unit, file=trim(file), access='stream', form='unformatted', status='old', action='read')
    read (unit) n
    allocate (columns(n, 3))
    read (unit) columns
    close (unit)
    pose = transpose(columns)
  end subroutine read_poses

  integer function integer_argument(position)
    integer, intent(in) :: position
    character(16) :: word

    call get_command_argument(position, word)
    read (word, *) integer_argument
  end function integer_argument

  function new_direct(c, setup) result(direct)
    type(case_type), intent(in) :: c
    type(setup_type), intent(in) :: setup
    type(direct_type) :: direct

    direct%model = trim(c%model)
    direct%e_star = c%stiffness_scale*contact_modulus(c%youngs_modulus, c%poisson)
    allocate (direct%k(size(setup%side(1)%pair%s)))
    direct%work = new_scan(setup%side(1)%pair)
    direct%elements = new_elements(12, 48, 1e-6_dp, direct%e_star)
  end function new_direct

  !> One zone in a pose: the force of its strips, its energy.
  subroutine zone_contact(direct, setup, z, q, energy, force)
    type(direct_type), intent(inout) :: direct
    type(setup_type), intent(in) :: setup
    integer, intent(in) :: z
    real(dp), intent(in) :: q(3)
    real(dp), intent(out) :: energy, force(3)

    associate (zone => setup%side(1)%zones(z))
      direct%work%fresh = .true.
      call set_moduli(setup%side(1)%pair, zone, direct%e_star, q(3), direct%k)
      call scan_depth(setup%side(1)%pair, q(1:2), q(3), zone%first, zone%last, direct%work)
      force = zone_force(setup%side(1)%pair, zone, q(3), direct%work, direct%k)
      energy = zone_energy(setup%side(1)%pair, zone, direct%model, direct%e_star, q(3), direct%work, direct%k)
    end associate
  end subroutine zone_contact

  !> Tread (1) or flange (2) in a pose by a half-space solution.
  subroutine branch_contact(direct, setup, branch, q, energy, force)
    type(direct_type), intent(inout) :: direct
    type(setup_type), intent(in) :: setup
    integer, intent(in) :: branch
    real(dp), intent(in) :: q(3)
    real(dp), intent(out) :: energy, force(3)
    type(patches_type) :: patches
    integer :: first, last
    logical :: ok

    first = minval(setup%side(1)%zones%first, setup%side(1)%zones%flange .eqv. branch == 2)
    last = maxval(setup%side(1)%zones%last, setup%side(1)%zones%flange .eqv. branch == 2)
    direct%work%fresh = .true.
    call scan_depth(setup%side(1)%pair, q(1:2), q(3), first, last, direct%work)
    call press_patches(setup%side(1)%pair, direct%elements, first, last, q(1:2), q(3), direct%work, patches, energy, ok, force)
    if (.not. ok) error stop 'the half-space solution failed'
  end subroutine branch_contact

end module shared