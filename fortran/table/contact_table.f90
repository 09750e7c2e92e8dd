!> The tabulated contact potential of a wheel/rail pair: the energies of the zones (`zone_tables`), coupled by their
!> influence on each other (`zone_coupling`).
!>
!> Tread and flange are names for the zones that carry: a contact is the flange's if its contact angle is at least the
!> threshold of the case, or if it is on the flange's tip.
module contact_table
  use bspline, only: axis_basis, axis_cell, axis_holds, axis_type
  use contact_law, only: law_type
  use contact_zones, only: is_steep, max_zones, usual_flange_angle
  use kinds, only: dp
  use zone_coupling, only: add_coupling, coupling_type, find_influence, pair_table, press_together
  use zone_tables, only: find_touching, gap_type, inside, outside_roll, roll_type, touching_type, zone_potential, zone_table
  implicit none
  private
  public :: table_type, find_roll, wheel_potential

  type :: table_type
    character(:), allocatable :: key    !! everything that the table depends on
    type(axis_type) :: roll             !! roll angle of all zones [rad]
    type(zone_table), allocatable :: zones(:)
    type(pair_table), allocatable :: pairs(:)   !! not allocated if zones do not act on each other
    real(dp) :: threshold(2) = [cos(usual_flange_angle), sin(usual_flange_angle)]   !! of `is_steep`, as of the side
    type(law_type) :: law               !! what the table tabulates
    integer :: solutions(2) = 0         !! half-space solutions in the table, and those that did not converge
    integer :: found = 0, kept = 0      !! of them, read from the file, and now in the file
  end type table_type

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

  !> Compute the elastic energy [J] of the left wheel's tread and flange, its gradients with respect to the pose
  !> (y, z, roll) [N, N, N m], and, if wanted, the Hessian (yy, yz, y roll, zz, z roll, roll roll) of the sum, else 0.
  !> The status is `inside`, or says why the pose is not on the table; if it is `missing`, `gap` says what is to be solved first.
  pure subroutine wheel_potential(t, pose, roll, with_hessian, energy, gradient, hessian, status, gap)
    type(table_type), intent(in) :: t
    real(dp), intent(in) :: pose(3)        !! axle centre y, z [m], roll [rad]; track frame
    type(roll_type), intent(in) :: roll    !! roll of the pose
    logical, intent(in) :: with_hessian    !! whether the Hessian is wanted
    real(dp), intent(out) :: energy(2), gradient(3, 2), hessian(6)
    integer, intent(out) :: status
    type(gap_type), intent(out) :: gap
    type(touching_type) :: zones(max_zones)
    type(coupling_type) :: coupling
    integer :: i, n, branch

    energy = 0
    gradient = 0
    hessian = 0
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
    if (coupling%n > 0) call add_coupling(n, with_hessian, coupling, zones, hessian)
    do i = 1, n
      associate (z => zones(i))
        if (z%energy <= 0) cycle
        branch = merge(2, 1, on_flange(t, z))
        energy(branch) = energy(branch) + z%energy
        gradient(:, branch) = gradient(:, branch) + z%gradient
        if (with_hessian) hessian = hessian + z%hessian
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

  !> Whether a zone's contact is the flange's, as `is_flange` says.
  pure logical function on_flange(t, z)
    type(table_type), intent(in) :: t
    type(touching_type), intent(in) :: z

    on_flange = is_steep(t%threshold, -z%gradient(:2)) .or. z%u > t%zones(z%zone)%tip
  end function on_flange

end module contact_table
