!> Influence of the zones of a wheel on each other in one pose: the mean influence of the loads of two zones, in half-spaces that
!> are pressed as a whole. It depends on where the loads are, and hardly on how large they are.
!>
!> Where only one of two zones carries, it is the influence on the point of the other zone that is nearest to touching: in
!> this way a zone begins to carry where it does in the whole wheel. Where both carry it is that influence with which the
!> coupled zones have the energy of the whole wheel. So patches of two zones that have merged have the energy of the one patch.
module zone_influence
  use contact_law, only: law_type
  use halfspace_patches, only: force_between, influence_between, patches_type, press_patches
  use kinds, only: dp
  use linear_solver, only: solve_linear
  use patch_grids, only: elements_type
  use station_scan, only: new_scan, scan_depth, scan_type
  implicit none
  private
  public :: find_influences

  !> Energy of a zone that is pressed alone, about some shift: energy*(1 - (shift - here)/reach)^(5/2), which has the energy and the
  !> force of the zone there.
  type :: law_about
    real(dp) :: energy = 0, here = 0, reach = 1   !! [J, m, m]
  end type law_about

contains

  !> Influences of the zones before zone j on zone j [m/N], 0 for the others, in a wheel that ends with zone j. So they are smooth
  !> where a zone behind it begins to carry. `ok` is false if a solution did not converge.
  recursive subroutine find_influences(law, elements, j, pose, influence, ok)
    type(law_type), intent(in) :: law
    type(elements_type), intent(in) :: elements
    integer, intent(in) :: j
    real(dp), intent(in) :: pose(3)            !! [m, rad]
    real(dp), intent(out) :: influence(:)      !! (zone)
    logical, intent(out) :: ok
    type(scan_type) :: scan
    type(patches_type) :: patches
    real(dp) :: mean, load(2), angle, part(2), force(j), known(j, j)
    integer :: i, order(2)
    logical :: converged

    influence = 0
    associate (pair => law%side%pair, zones => law%side%zones(:j))
      scan = new_scan(pair)
      call scan_depth(pair, pose(:2), pose(3), minval(zones%first), maxval(zones%last), scan)
      call press_patches(pair, elements, minval(zones%first), maxval(zones%last), pose(:2), pose(3), scan, patches)
      ok = patches%ok
      if (patches%n == 0) return
      force = [(along_zone(law, patches, i), i=1, j)]
      do i = 1, j - 1
        order = [i, j]
        call influence_between(pair, elements, scan, patches, zones(order)%first, zones(order)%last, mean, load, angle)
        if (all(load <= 0)) cycle
        ! Along the normals w of the zones' coordinates.
        part = cos(angle + pose(3) - zones(order)%alpha)
        where (load > 0) part = force(order)/load
        if (all(part > 0)) influence(i) = mean/product(part)
      end do
    end associate
    if (force(j) <= 0 .or. all(force(:j - 1) <= 0 .or. influence(:j - 1) <= 0)) return
    known = 0
    do i = 2, j - 1
      if (force(i) <= 0 .or. all(force(:i - 1) <= 0)) cycle
      call find_influences(law, elements, i, pose, known(:, i), converged)
      ok = ok .and. converged
      known(i, :) = known(:, i)
    end do
    call match_energy(law, elements, pack([(i, i=1, j)], force > 0), pose, patches%energy, pack(force, force > 0), known, &
      influence, ok)
  end subroutine find_influences

  !> Force [N] of the loads of a zone along w.
  pure real(dp) function along_zone(law, patches, z) result(force)
    type(law_type), intent(in) :: law
    type(patches_type), intent(in) :: patches
    integer, intent(in) :: z
    real(dp) :: sum(3)

    associate (zone => law%side%zones(z), s => law%side%pair%s)
      sum = force_between(patches, s(zone%first), s(zone%last))
      force = dot_product(sum(:2), across(law, z))
    end associate
  end function along_zone

  !> Direction of w of a zone, track frame.
  pure function across(law, z)
    type(law_type), intent(in) :: law
    integer, intent(in) :: z
    real(dp) :: across(2)

    across = [-sin(law%side%zones(z)%alpha), cos(law%side%zones(z)%alpha)]
  end function across

  !> Multiply the influences on the last of some zones by a factor, so that coupled they have the energy of the whole wheel. It is
  !> about 1 where one of them carries so little that the energy does not tell: it minimises
  !> (error of the energy/noise)^2 + (factor - 1)^2.
  subroutine match_energy(law, elements, z, pose, whole, carried, known, influence, ok)
    type(law_type), intent(in) :: law
    type(elements_type), intent(in) :: elements
    integer, intent(in) :: z(:)                !! the zones that carry
    real(dp), intent(in) :: pose(3)
    real(dp), intent(in) :: whole              !! energy of the whole wheel [J]
    real(dp), intent(in) :: carried(:)         !! forces of the zones in the whole wheel [N]
    real(dp), intent(in) :: known(:, :)        !! influences of the zones before the last one on each other, (zone, zone) [m/N]
    real(dp), intent(inout) :: influence(:)    !! on the last one, (zone) [m/N]
    logical, intent(inout) :: ok
    real(dp), parameter :: noise = 1e-3_dp     ! of the energies, relative
    real(dp), parameter :: least = 0.2_dp      ! factor
    real(dp), parameter :: close = 0.1_dp     ! changes of shifts after which the zones are not pressed again, of their reach
    integer, parameter :: most_pressed = 2, most_steps = 20
    type(law_about) :: alone(size(z))
    real(dp), dimension(size(z)) :: shift, force
    real(dp) :: c(size(z), size(z)), factor, error, step, weight, slope
    integer :: k, n, pressed, iter

    n = size(z)
    factor = 1
    c = known(z, z)
    call set_last()
    shift = matmul(c, carried)
    do pressed = 1, most_pressed
      do k = 1, n
        call press_lowered(law, elements, z(k), pose, shift(k), alone(k), ok)
        if (alone(k)%energy <= 0) return
      end do
      do iter = 1, most_steps
        call share_load(alone, c, shift, force)
        error = sum(energy_of(alone, shift)) + dot_product(force, matmul(c, force))/2 - whole
        ! The energy of the coupled zones falls by this slope times a change of the factor.
        slope = dot_product(force(:n - 1), influence(z(:n - 1)))*force(n)
        weight = (noise*whole)**2
        step = (slope*error + weight*(1 - factor))/(slope**2 + weight)
        factor = max(least, min(factor + step, 2*factor))
        call set_last()
        if (abs(step) < 1e-3_dp*factor) exit
      end do
      call share_load(alone, c, shift, force)
      if (all(abs(shift - alone%here) < close*alone%reach)) exit
    end do
    influence = factor*influence

  contains

    subroutine set_last()
      c(n, :n - 1) = factor*influence(z(:n - 1))
      c(:n - 1, n) = c(n, :n - 1)
    end subroutine set_last

  end subroutine match_energy

  !> Press a zone alone whose surface is lowered.
  subroutine press_lowered(law, elements, z, pose, shift, alone, ok)
    type(law_type), intent(in) :: law
    type(elements_type), intent(in) :: elements
    integer, intent(in) :: z
    real(dp), intent(in) :: pose(3), shift     !! [m, rad; m]
    type(law_about), intent(out) :: alone
    logical, intent(inout) :: ok
    type(scan_type) :: scan
    type(patches_type) :: patches
    real(dp) :: centre(2)

    associate (pair => law%side%pair, zone => law%side%zones(z))
      scan = new_scan(pair)
      centre = pose(:2) + shift*across(law, z)
      call scan_depth(pair, centre, pose(3), zone%first, zone%last, scan)
      call press_patches(pair, elements, zone%first, zone%last, centre, pose(3), scan, patches)
      ok = ok .and. patches%ok
      if (patches%n == 0) return
      alone = law_about(patches%energy, shift, 2.5_dp*patches%energy/max(along_zone(law, patches, z), tiny(shift)))
    end associate
  end subroutine press_lowered

  elemental real(dp) function energy_of(alone, shift)
    type(law_about), intent(in) :: alone
    real(dp), intent(in) :: shift

    energy_of = alone%energy*max(0.0_dp, 1 - (shift - alone%here)/alone%reach)**2.5_dp
  end function energy_of

  elemental real(dp) function force_of(alone, shift)
    type(law_about), intent(in) :: alone
    real(dp), intent(in) :: shift

    force_of = 2.5_dp*alone%energy/alone%reach*max(0.0_dp, 1 - (shift - alone%here)/alone%reach)**1.5_dp
  end function force_of

  !> Shifts and forces of zones that lower the surface of each other: shift_i = sum c_ij force_j, by Newton's method.
  pure subroutine share_load(alone, c, shift, force)
    type(law_about), intent(in) :: alone(:)
    real(dp), intent(in) :: c(:, :)            !! influences, 0 on the diagonal [m/N]
    real(dp), intent(inout) :: shift(:)
    real(dp), intent(out) :: force(:)
    integer, parameter :: patience = 12, most = 60
    real(dp) :: a(size(shift), size(shift)), step(size(shift)), stiffness
    integer :: iter, j
    logical :: ok

    do iter = 1, most
      force = force_of(alone, shift)
      step = matmul(c, force) - shift
      do j = 1, size(shift)
        stiffness = 3.75_dp*alone(j)%energy/alone(j)%reach**2*sqrt(max(0.0_dp, 1 - (shift(j) - alone(j)%here)/alone(j)%reach))
        a(:, j) = c(:, j)*stiffness
        a(j, j) = 1
      end do
      call solve_linear(a, step, ok)
      if (.not. ok) exit
      if (iter > patience) step = step/2
      shift = shift + step
      if (all(abs(step) < 1e-6_dp*alone%reach)) exit
    end do
    force = force_of(alone, shift)
  end subroutine share_load

end module zone_influence
