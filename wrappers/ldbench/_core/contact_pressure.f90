!> Pressures between a wheel and its rail in one pose, by the model 'halfspace': what the contact table sums up to a force.
!>
!> With 48 elements along a patch, on Hertzian patches of axis ratios from 1:4 to 3.5:1, the largest pressure errs by at most
!> 0.05 %, the area by 0.4 % and the semi-axes by 0.8 %.
module contact_pressure
  use contact_zones, only: is_flange, side_type
  use curve, only: curve_point, near_interval
  use halfspace_patches, only: force_between, patches_type, press_patches
  use hertz, only: ellipse
  use kinds, only: dp, pi
  use patch_grids, only: elements_type
  use patch_overlaps, only: overlap_type
  use station_scan, only: deepest, new_scan, scan_depth, scan_type
  use wheel_rail_pair, only: mean_curvature, pair_type, rail_curvature
  implicit none
  private
  public :: press_contact

contains

  !> Press a left wheel into its rail. The wheel is pressed as a whole. Grids have nx by ns elements over x > 0 and s, the arc
  !> length along the wheel's profile.
  !>
  !> Facts of each patch are the length of an element along x and along s, s where the grid begins, largest undeformed
  !> interpenetration, and s where it is [m]; integral of the pressure [N]; semi-axes along x and along s [m] and largest
  !> pressure [Pa] of Hertz's ellipse with this force and the curvatures there, 0 where the surfaces conform; 1 for a contact
  !> of the flange, 0 for one of the tread.
  subroutine press_contact(side, elements, pose, n, ok, p, point, facts, total)
    type(side_type), intent(in) :: side
    type(elements_type), intent(in) :: elements
    real(dp), intent(in) :: pose(3)            !! axle centre y, z [m] and roll angle [rad], track frame
    integer, intent(out) :: n                  !! number of patches; the arrays have room for some of them
    logical, intent(out) :: ok                 !! whether the solution converged
    real(dp), intent(out) :: p(:, :, :)        !! pressure (nx, ns, patch) [Pa]
    real(dp), intent(out) :: point(:, :, :)    !! rows of elements on the wheel, wheelset frame (2, ns, patch) [m]
    real(dp), intent(out) :: facts(:, :)       !! (10, patch)
    real(dp), intent(out) :: total(4)          !! F_y, F_z of the rail on the wheel [N], M_x about the axle centre [N m], energy [J]
    type(patches_type) :: patches
    type(scan_type) :: scan
    real(dp) :: force(3), ends(2), A, B, s, d1(2), d2(2)
    integer :: first, last, g, i, j

    first = minval(side%zones%first)
    last = maxval(side%zones%last)
    scan = new_scan(side%pair)
    call scan_depth(side%pair, pose(:2), pose(3), first, last, scan)
    call press_patches(side%pair, elements, first, last, pose(:2), pose(3), scan, patches)
    ok = patches%ok
    n = patches%n
    p = 0
    point = 0
    facts = 0
    total = [0.0_dp, 0.0_dp, 0.0_dp, patches%energy]
    do g = 1, patches%n
      associate (mesh => patches%mesh(g))
        ends = mesh%low + [0, elements%ns]*mesh%ds
        force = force_between(patches, ends(1), ends(2))
        total(:3) = total(:3) + force
        if (g > size(p, 3)) cycle
        p(:, :, g) = patches%f(:, :, g)/(mesh%dx*mesh%ds)
        facts(:3, g) = [mesh%dx, mesh%ds, mesh%low]
        facts(6, g) = 2*sum(patches%f(:, :, g))
        call describe_overlap(side%pair, scan, first, last, pose(3), patches%overlaps%list(g), facts(4:5, g), A, B)
        call hertz_ellipse(facts(6, g), elements%e_star, A, B, facts(7:9, g))
        facts(10, g) = merge(1, 0, is_flange(side, force(:2), sum(patches%box(2:, g))/2))
        do j = 1, elements%ns
          s = mesh%low + (j - 0.5_dp)*mesh%ds
          i = near_interval(side%pair%wheel, s)
          call curve_point(side%pair%wheel, s, i, point(:, j, g), d1, d2)
        end do
      end associate
    end do
  end subroutine press_contact

  !> Largest interpenetration of an overlap and s where it is [m]; relative curvatures there along x and along s, halved, so
  !> that the gap is A x^2 + B s^2 [1/m].
  subroutine describe_overlap(pair, scan, first, last, roll, overlap, deepest_at, A, B)
    type(pair_type), intent(in) :: pair
    type(scan_type), intent(in) :: scan
    integer, intent(in) :: first, last         !! stations that are pressed
    real(dp), intent(in) :: roll               !! [rad]
    type(overlap_type), intent(in) :: overlap
    real(dp), intent(out) :: deepest_at(2), A, B
    real(dp) :: angle, r(2), d1(2), d2(2)
    integer :: node, low, high, i

    low = max(first, count(pair%s < overlap%ends(1)))
    high = min(last, count(pair%s <= overlap%ends(2)) + 1)
    call deepest(pair, scan, low, high, deepest_at(1), deepest_at(2), node)
    i = near_interval(pair%wheel, deepest_at(2))
    call curve_point(pair%wheel, deepest_at(2), i, r, d1, d2)
    angle = atan2(d1(2), d1(1)) + roll
    A = cos(angle)/(-2*r(2))
    B = (mean_curvature(pair%wheel, deepest_at(2)) + rail_curvature(pair, angle))/2
  end subroutine describe_overlap

  !> Hertz's ellipse (K. L. Johnson, Contact Mechanics, 4.25-4.32): semi-axes along x and along s [m], largest pressure [Pa].
  subroutine hertz_ellipse(force, e_star, A, B, facts)
    real(dp), intent(in) :: force              !! [N]
    real(dp), intent(in) :: e_star             !! [Pa]
    real(dp), intent(in) :: A, B               !! relative curvatures along x and along s, halved [1/m]
    real(dp), intent(out) :: facts(3)
    real(dp) :: ratio, k, D, long

    facts = 0
    if (min(A, B) <= 0 .or. force <= 0) return
    call ellipse(max(A, B)/min(A, B), ratio, k, D)
    long = (1.5_dp*force*D/(pi*e_star*min(A, B)))**(1/3.0_dp)
    facts = [merge(long, ratio*long, A <= B), merge(ratio*long, long, A <= B), 1.5_dp*force/(pi*ratio*long**2)]
  end subroutine hertz_ellipse

end module contact_pressure
