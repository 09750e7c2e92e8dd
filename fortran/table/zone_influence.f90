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

  !> Influences of the zones before zone j on zone j [m/N], 0 for the others. `ok` is false if a solution did not converge.
  subroutine find_influences(law, elements, j, pose, influence, ok)
    type(law_type), intent(in) :: law
    type(elements_type), intent(in) :: elements
    integer, intent(in) :: j
    real(dp), intent(in) :: pose(3)            !! [m, rad]
    real(dp), intent(out) :: influence(:)      !! (zone)
    logical, intent(out) :: ok
    type(scan_type) :: scan
    type(patches_type) :: patches
    real(dp) :: mean, load(2), angle, part(2), force(size(influence))
    integer :: i, order(2)

    influence = 0
    associate (pair => law%side%pair, zones => law%side%zones)
      scan = new_scan(pair)
      call scan_depth(pair, pose(:2), pose(3), minval(zones%first), maxval(zones%last), scan)
      call press_patches(pair, elements, minval(zones%first), maxval(zones%last), pose(:2), pose(3), scan, patches)
      ok = patches%ok
      if (patches%n == 0) return
      force = [(along_zone(law, patches, i), i=1, size(zones))]
      do i = 1, j - 1
        order = [i, j]
        call influence_between(pair, elements, scan, patches, zones(order)%first, zones(order)%last, mean, load, angle)
        if (all(load <= 0)) cycle
        ! Along the normals w of the zones' coordinates.
        part = cos(angle + pose(3) - zones(order)%alpha)
        where (load > 0) part = force(order)/load
        if (all(part > 0)) influence(i) = mean/product(part)
        if (count(force > 0) == 2 .and. all(force(order) > 0) .and. influence(i) > 0) &
          call match_energy(law, elements, order, pose, patches%energy, force(order), influence(i), ok)
      end do
    end associate
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

  !> Change the influence c of two zones so that coupled they have the energy of the whole wheel. It stays where one of them carries
  !> so little that the energy does not tell: c minimises (error of the energy/noise)^2 + (c/mean influence - 1)^2.
  subroutine match_energy(law, elements, z, pose, whole, carried, c, ok)
    type(law_type), intent(in) :: law
    type(elements_type), intent(in) :: elements
    integer, intent(in) :: z(2)                !! the zones
    real(dp), intent(in) :: pose(3)
    real(dp), intent(in) :: whole              !! energy of the whole wheel [J]
    real(dp), intent(in) :: carried(2)         !! forces of the zones in the whole wheel [N]
    real(dp), intent(inout) :: c               !! [m/N]
    logical, intent(inout) :: ok
    real(dp), parameter :: noise = 1e-3_dp     ! of the energies, relative
    real(dp), parameter :: least = 0.2_dp      ! of the mean influence
    real(dp), parameter :: close = 0.02_dp     ! changes of shifts after which the zones are not pressed again, of their reach
    integer, parameter :: most_pressed = 4, most_steps = 20
    type(law_about) :: alone(2)
    real(dp) :: mean, shift(2), force(2), error, step, weight
    integer :: k, pressed, iter

    mean = c
    shift = c*carried([2, 1])
    do pressed = 1, most_pressed
      do k = 1, 2
        call press_lowered(law, elements, z(k), pose, shift(k), alone(k), ok)
        if (alone(k)%energy <= 0) return
      end do
      do iter = 1, most_steps
        call share_load(alone, c, shift, force)
        error = sum(energy_of(alone, shift)) + c*product(force) - whole
        ! The energy of the coupled zones falls by the product of the forces times a change of c.
        weight = (noise*whole/mean)**2
        step = (product(force)*error + weight*(mean - c))/(product(force)**2 + weight)
        c = max(least*mean, min(c + step, 2*c))
        if (abs(step) < 1e-3_dp*c) exit
      end do
      call share_load(alone, c, shift, force)
      if (all(abs(shift - alone%here) < close*alone%reach)) exit
    end do
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

  !> Shifts and forces of two zones that lower the surface of each other: shift = c*force of the other, by Newton's method.
  pure subroutine share_load(alone, c, shift, force)
    type(law_about), intent(in) :: alone(2)
    real(dp), intent(in) :: c
    real(dp), intent(inout) :: shift(2)
    real(dp), intent(out) :: force(2)
    real(dp) :: stiffness(2), rest(2), step(2), det
    integer :: iter

    do iter = 1, 60
      force = force_of(alone, shift)
      stiffness = 3.75_dp*alone%energy/alone%reach**2*sqrt(max(0.0_dp, 1 - (shift - alone%here)/alone%reach))
      rest = c*force([2, 1]) - shift
      ! d(shift) + c*stiffness of the other*d(shift of the other) = rest.
      det = 1 - c**2*product(stiffness)
      if (abs(det) < 0.1_dp) det = sign(0.1_dp, det)
      step = (rest - c*stiffness([2, 1])*rest([2, 1]))/det
      if (iter > 12) step = step/2
      shift = shift + step
      if (all(abs(step) < 1e-6_dp*alone%reach)) exit
    end do
    force = force_of(alone, shift)
  end subroutine share_load

end module zone_influence
