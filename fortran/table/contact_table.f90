!> The tabulated contact potential of a wheel/rail pair: the energies of the zones (`zone_tables`), coupled by their
!> influence on each other (`zone_coupling`).
!>
!> Tread and flange are names for what lies on either side of the border on the wheel. A zone on both sides has two parts
!> (`zone_parts`).
module contact_table
  use bspline, only: axis_basis, axis_cell, axis_holds, axis_type
  use contact_law, only: law_type
  use contact_zones, only: max_zones
  use kinds, only: dp
  use zone_coupling, only: add_coupling, coupling_type, find_influence, pair_table, press_together
  use zone_tables, only: find_touching, gap_type, inside, outside_roll, roll_type, touching_type, zone_potential, zone_table
  use zone_parts, only: border_type, part_zone
  implicit none
  private
  public :: table_type, wheel_force, find_roll, wheel_potential

  type :: table_type
    character(:), allocatable :: key    !! everything that the table depends on
    type(axis_type) :: roll             !! roll angle of all zones [rad]
    type(zone_table), allocatable :: zones(:)
    type(pair_table), allocatable :: pairs(:)   !! not allocated if zones do not act on each other
    type(border_type) :: border         !! between tread and flange
    type(law_type) :: law               !! what the table tabulates
    integer :: solutions(2) = 0         !! half-space solutions in the table, and those that did not converge
    integer :: found = 0, kept = 0      !! of them, read from the file, and now in the file
  end type table_type

  !> Energy and force of a wheel in a pose, and its tread's and its flange's parts of them.
  type :: wheel_force
    real(dp) :: energy(2) = 0           !! of tread and flange [J]
    real(dp) :: gradient(3, 2) = 0      !! with respect to the pose (y, z, roll) [N, N, N m]
    real(dp) :: total(3) = 0            !! sum of the gradients, which does not depend on where the border is
    real(dp) :: hessian(6) = 0          !! of the sum of the energies: yy, yz, y roll, zz, z roll, roll roll; 0 if not wanted
    logical :: shared = .false.         !! a zone carries on both sides of the border
  end type wheel_force

contains

  !> Prepare a roll angle [rad] for the left wheel, and its opposite for the right wheel, which is solved as the mirror image
  !> of a left one. The status is `inside` or `outside_roll`.
  pure subroutine find_roll(t, angle, with_hessian, roll, opposite, status)
    type(table_type), intent(in) :: t
    real(dp), intent(in) :: angle
    logical, intent(in) :: with_hessian    !! whether a Hessian is wanted
    type(roll_type), intent(out) :: roll, opposite
    integer, intent(out) :: status

    status = outside_roll
    if (.not. (axis_holds(t%roll, angle) .and. axis_holds(t%roll, -angle))) return
    status = inside
    roll%angle = angle
    opposite%angle = -angle
    roll%cosine = cos(angle)
    roll%sine = sin(angle)
    opposite%cosine = roll%cosine
    opposite%sine = -roll%sine
    call axis_basis(t%roll, axis_cell(t%roll, angle), angle, roll%basis, with_hessian)
    call axis_basis(t%roll, axis_cell(t%roll, -angle), -angle, opposite%basis, with_hessian)
  end subroutine find_roll

  !> Compute the elastic energy of the left wheel and its derivatives with respect to the pose, the second ones if wanted.
  !> The status is `inside`, or says why the pose is not on the table; if it is `missing`, `gap` says what is to be solved first.
  pure subroutine wheel_potential(t, pose, roll, with_hessian, force, status, gap)
    type(table_type), intent(in) :: t
    real(dp), intent(in) :: pose(3)        !! axle centre y, z [m], roll [rad]; track frame
    type(roll_type), intent(in) :: roll    !! roll of the pose
    logical, intent(in) :: with_hessian    !! whether the Hessian is wanted
    type(wheel_force), intent(out) :: force
    integer, intent(out) :: status
    type(gap_type), intent(out) :: gap
    type(touching_type) :: zones(max_zones)
    type(coupling_type) :: coupling
    integer :: i, n

    call find_zones_touching(t, pose, roll, with_hessian, n, zones, status, gap)
    if (n == 0 .or. status /= inside) return
    coupling%n = 0
    if (n > 1 .and. allocated(t%pairs)) then
      call find_influence(t%zones, t%pairs, roll, with_hessian, n, zones, coupling, status, gap)
      if (status /= inside) return
    end if
    if (coupling%n > 0) call press_together(t%zones, roll, n, coupling%c, zones, status, gap)
    if (status /= inside) return
    do i = 1, n
      call zone_potential(t%zones(zones(i)%zone), roll, with_hessian, zones(i), status, gap)
      if (status /= inside) return
    end do
    if (coupling%n > 0) call add_coupling(n, with_hessian, coupling, zones, force%hessian)
    do i = 1, n
      associate (z => zones(i))
        if (z%energy <= 0) cycle
        force%total = force%total + z%gradient
        if (with_hessian) force%hessian = force%hessian + z%hessian
        call add_parts(t, pose, roll, z, force)
      end associate
    end do
  end subroutine wheel_potential

  !> Find the zones that touch in a pose. The search ends at a zone that is not on the table.
  pure subroutine find_zones_touching(t, pose, roll, with_hessian, n, zones, status, gap)
    type(table_type), intent(in) :: t
    real(dp), intent(in) :: pose(3)
    type(roll_type), intent(in) :: roll
    logical, intent(in) :: with_hessian    !! whether second derivatives are wanted
    integer, intent(out) :: n
    type(touching_type), intent(inout) :: zones(max_zones)
    integer, intent(out) :: status
    type(gap_type), intent(inout) :: gap
    integer :: i

    status = inside
    n = 0
    do i = 1, size(t%zones)
      zones(n + 1)%zone = i
      call find_touching(t%zones(i), pose, roll, with_hessian, zones(n + 1), status, gap)
      if (status /= inside) return
      if (zones(n + 1)%p <= 0) cycle
      n = n + 1
      if (n == max_zones) exit
    end do
  end subroutine find_zones_touching

  !> Add a zone to tread and flange.
  pure subroutine add_parts(t, pose, roll, z, force)
    type(table_type), intent(in) :: t
    real(dp), intent(in) :: pose(3)
    type(roll_type), intent(in) :: roll
    type(touching_type), intent(in) :: z
    type(wheel_force), intent(inout) :: force
    real(dp) :: share, parts(3, 2)

    parts = 0
    associate (zone => t%law%side%zones(z%zone), s => t%law%side%pair%s)
      if (s(zone%first) >= t%border%s) then
        share = 0
        parts(:, 1) = z%gradient
      else if (s(zone%last) <= t%border%s .or. z%u > t%zones(z%zone)%tip) then
        share = 1
        parts(:, 2) = z%gradient
      else
        call part_zone(t%law, t%border, zone%first, zone%last, pose(:2), roll, z%p - z%shift, z%shift, z%gradient, share, parts)
      end if
    end associate
    force%energy = force%energy + [1 - share, share]*z%energy
    force%gradient = force%gradient + parts
    force%shared = force%shared .or. (share > 0 .and. share < 1)
  end subroutine add_parts

end module contact_table
