!> What the programs beside it share: the case they are given, and contact of the left wheel
!> by direct evaluation.
module shared
  use, intrinsic :: iso_fortran_env, only: int64
  use case, only: case_type
  use case_reader, only: read_case
  use contact_zones, only: is_flange
  use strip_law, only: set_moduli, zone_energy
  use errors, only: error_type
  use station_scan, only: new_scan, scan_depth, scan_type
  use hertz, only: contact_modulus
  use kinds, only: dp
  use halfspace_patches, only: force_between, patches_type, press_patches
  use patch_grids, only: elements_type
  use run_setup, only: setup_type
  use simulation, only: prepare
  use text, only: line_type, read_lines
  implicit none
  private
  public :: read_prepared, read_poses, integer_argument, direct_type, new_direct, zone_contact, wheel_contact

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
    direct%elements = elements_type(12, 48, 1e-6_dp, direct%e_star, c%influence == 'flat')
  end function new_direct

  !> One zone in a pose: its energy, and the force and moment as the gradient of it, by central differences.
  subroutine zone_contact(direct, setup, z, q, energy, force)
    type(direct_type), intent(inout) :: direct
    type(setup_type), intent(in) :: setup
    integer, intent(in) :: z
    real(dp), intent(in) :: q(3)
    real(dp), intent(out) :: energy, force(3)

    real(dp), parameter :: step(3) = [2e-8_dp, 2e-8_dp, 2e-8_dp]   ! [m, m, rad]
    real(dp) :: way(3)
    integer :: i

    energy = energy_at(q)
    do i = 1, 3
      way = merge(step, 0.0_dp, [1, 2, 3] == i)
      force(i) = (energy_at(q - way) - energy_at(q + way))/(2*step(i))
    end do

  contains

    real(dp) function energy_at(q) result(energy)
      real(dp), intent(in) :: q(3)

      associate (zone => setup%side(1)%zones(z))
        direct%work%fresh = .true.
        call set_moduli(setup%side(1)%pair, zone, direct%e_star, q(3), direct%k)
        call scan_depth(setup%side(1)%pair, q(1:2), q(3), zone%first, zone%last, direct%work)
        energy = zone_energy(setup%side(1)%pair, zone, direct%model, direct%e_star, q(3), direct%work, direct%k)
      end associate
    end function energy_at

  end subroutine zone_contact

  !> The whole wheel in a pose by a half-space solution: energy [J], and F_y, F_z [N], M_x [N m] of the tread and of the flange.
  subroutine wheel_contact(direct, setup, q, energy, force)
    type(direct_type), intent(inout) :: direct
    type(setup_type), intent(in) :: setup
    real(dp), intent(in) :: q(3)
    real(dp), intent(out) :: energy, force(3, 2)
    type(patches_type) :: patches
    real(dp) :: part(3)
    integer :: first, last, z, branch

    force = 0
    associate (side => setup%side(1))
      first = minval(side%zones%first)
      last = maxval(side%zones%last)
      direct%work%fresh = .true.
      call scan_depth(side%pair, q(1:2), q(3), first, last, direct%work)
      call press_patches(side%pair, direct%elements, first, last, q(1:2), q(3), direct%work, patches)
      if (.not. patches%ok) error stop 'the half-space solution failed'
      energy = patches%energy
      do z = 1, size(side%zones)
        part = force_between(patches, side%pair%s(side%zones(z)%first), side%pair%s(side%zones(z)%last))
        branch = merge(2, 1, is_flange(side, part(:2), side%pair%s(side%zones(z)%last)))
        force(:, branch) = force(:, branch) + part
      end do
    end associate
  end subroutine wheel_contact

end module shared
