!> Forces of the rail on a wheel without a table, by which tables are judged: the central difference of the elastic energy, with the
!> whole wheel pressed as one system, unless its zones do not act on each other. The error of a table's force F is
!>
!>     |F_table - F_direct|/max(|F_direct|, 5 kN).
module direct_force
  use contact_law, only: force_floor, law_type
  use contact_table, only: find_roll, table_type, wheel_force
  use halfspace_patches, only: force_between, patches_type, press_patches
  use kinds, only: dp
  use patch_grids, only: elements_type
  use station_scan, only: new_scan, scan_depth, scan_type
  use strip_law, only: zone_energy
  use table_growth, only: grown_potential
  use zone_tables, only: inside, roll_type
  implicit none
  private
  public :: judge, fine_elements

  ! Grids over half a patch, finer than those of tables, and the solver's tolerance.
  integer, parameter :: elements_x = 6, elements_s = 24
  real(dp), parameter :: tolerance = 1e-3_dp

contains

  pure type(elements_type) function fine_elements(law)
    type(law_type), intent(in) :: law

    fine_elements = elements_type(elements_x, elements_s, tolerance, law%e_star, law%influence == 'flat', .true.)
  end function fine_elements

  !> Error of a table's force on the left wheel in a pose.
  subroutine judge(table, elements, pose, error, force, touching, ok)
    type(table_type), intent(inout) :: table
    type(elements_type), intent(in) :: elements
    real(dp), intent(in) :: pose(3)        !! [m, rad]
    real(dp), intent(out) :: error         !! relative to max(|F|, force_floor)
    real(dp), intent(out) :: force         !! without the table [N]
    logical, intent(out) :: touching(2)    !! tread and flange, by the direct evaluation
    logical, intent(out) :: ok             !! whether the direct evaluation converged
    type(roll_type) :: roll, opposite
    type(wheel_force) :: tabulated
    real(dp) :: exact(2)
    logical :: carrying(size(table%zones))
    integer :: status

    call find_roll(table, pose(3), .false., roll, opposite, status)
    if (status == inside) call grown_potential(table, pose, roll, .false., tabulated, status)
    if (status /= inside) tabulated = wheel_force()
    call press_directly(table%law, elements, pose, exact, carrying, ok)
    touching = [any(carrying .and. .not. table%zones%past_root), any(carrying .and. table%zones%past_root)]
    force = norm2(exact)
    error = norm2(-tabulated%total(:2) - exact)/max(force, force_floor)
  end subroutine judge

  !> Compute the force [N] (y, z) of the rail on the left wheel in a pose, without a table, and which zones carry. `ok` is false
  !> if a half-space solution did not converge.
  subroutine press_directly(law, elements, pose, force, carrying, ok)
    type(law_type), intent(in) :: law
    type(elements_type), intent(in) :: elements   !! of half-spaces
    real(dp), intent(in) :: pose(3)        !! [m, rad]
    real(dp), intent(out) :: force(2)
    logical, intent(out) :: carrying(:)    !! (zone)
    logical, intent(out) :: ok
    ! Step of the central difference of the energy, relative to the largest overlap. The energy on a grid is far more exact
    ! than the sum of the loads.
    real(dp), parameter :: share_halfspace = 0.02_dp, share = 1e-3_dp
    real(dp) :: energy(2), step, way(2), depth
    type(patches_type), dimension(merge(size(law%side%zones), 1, law%influence == 'apart')) :: middle, beside
    type(scan_type) :: scan
    logical :: solved, touching(size(carrying)), halfspace
    integer :: i, k

    force = 0
    ok = .true.
    halfspace = law%model == 'halfspace'
    if (halfspace) then
      call press_wheel(law, elements, pose, middle, energy(1), carrying, ok)
      step = share_halfspace*maxval([(maxval(middle(i)%overlaps%list%depth), i=1, size(middle))])
    else
      scan = new_scan(law%side%pair)
      call press_springs(law, pose, scan, energy(1), carrying, depth)
      step = share*depth
    end if
    if (.not. any(carrying)) return
    do i = 1, 2
      do k = 1, 2
        way = merge(sign(step, k - 1.5_dp), 0.0_dp, [1, 2] == i)
        if (halfspace) then
          call press_wheel(law, elements, [pose(:2) + way, pose(3)], beside, energy(k), touching, solved, middle)
          ok = ok .and. solved
        else
          call press_springs(law, [pose(:2) + way, pose(3)], scan, energy(k), touching, depth)
        end if
      end do
      force(i) = (energy(1) - energy(2))/(2*step)
    end do
  end subroutine press_directly

  !> Compute the energy [J] of strips or of Hertz's springs at the left wheel in a pose, which zones carry, and the largest
  !> depth [m].
  subroutine press_springs(law, pose, scan, energy, carrying, depth)
    type(law_type), intent(in) :: law      !! of model 'strip' or 'hertz'
    real(dp), intent(in) :: pose(3)        !! [m, rad]
    type(scan_type), intent(inout) :: scan !! fresh, or of a pose nearby
    real(dp), intent(out) :: energy, depth
    logical, intent(out) :: carrying(:)    !! (zone)
    integer :: z

    energy = 0
    depth = 0
    associate (pair => law%side%pair, zones => law%side%zones)
      call scan_depth(pair, pose(:2), pose(3), minval(zones%first), maxval(zones%last), scan)
      scan%fresh = .false.
      do z = 1, size(zones)
        carrying(z) = any(scan%depth(zones(z)%first:zones(z)%last) > 0)
        if (.not. carrying(z)) cycle
        depth = max(depth, maxval(scan%depth(zones(z)%first:zones(z)%last)))
        energy = energy + zone_energy(pair, zones(z), law%model, law%e_star, pose(3), scan)
      end do
    end associate
  end subroutine press_springs

  !> Compute the energy [J] of half-spaces at the left wheel in a pose, and which zones carry.
  subroutine press_wheel(law, elements, pose, patches, energy, carrying, ok, nearby)
    type(law_type), intent(in) :: law
    type(elements_type), intent(in) :: elements
    real(dp), intent(in) :: pose(3)        !! [m, rad]
    type(patches_type), intent(inout) :: patches(:)  !! of the wheel, or of every zone if zones are apart
    real(dp), intent(out) :: energy
    logical, intent(out) :: carrying(:)    !! (zone)
    logical, intent(out) :: ok
    type(patches_type), intent(in), optional :: nearby(:)   !! patches of a pose nearby
    type(scan_type) :: scan
    real(dp) :: part(3)
    integer :: i, z, first, last

    energy = 0
    ok = .true.
    associate (pair => law%side%pair, zones => law%side%zones)
      scan = new_scan(pair)
      call scan_depth(pair, pose(:2), pose(3), minval(zones%first), maxval(zones%last), scan)
      do i = 1, size(patches)
        first = merge(zones(i)%first, minval(zones%first), size(patches) > 1)
        last = merge(zones(i)%last, maxval(zones%last), size(patches) > 1)
        if (present(nearby)) then
          call press_patches(pair, elements, first, last, pose(:2), pose(3), scan, patches(i), nearby(i))
        else
          call press_patches(pair, elements, first, last, pose(:2), pose(3), scan, patches(i))
        end if
        energy = energy + patches(i)%energy
        ok = ok .and. patches(i)%ok
      end do
      do z = 1, size(zones)
        part = force_between(patches(min(z, size(patches))), pair%s(zones(z)%first), pair%s(zones(z)%last))
        carrying(z) = any(abs(part) > 0)
      end do
    end associate
  end subroutine press_wheel

end module direct_force
