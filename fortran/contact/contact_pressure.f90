!> Pressures between a wheel and its rail in one pose, by the model 'halfspace': what the contact table sums up to a force.
!>
!> With 48 elements along a patch, on Hertzian patches of axis ratios from 1:4 to 3.5:1, the largest pressure errs by at most
!> 0.05 %, the area by 0.4 % and the semi-axes by 0.8 %.
module contact_pressure
  use contact_zones, only: side_type
  use curve, only: curve_point, near_interval
  use halfspace_patches, only: force_between, patches_type, press_patches
  use hertz, only: ellipse
  use kinds, only: dp, pi
  use patch_grids, only: elements_type
  use patch_overlaps, only: most_patches, overlap_type
  use station_scan, only: deepest, new_scan, scan_depth, scan_type
  use wheel_rail_pair, only: mean_curvature, pair_type, rail_curvature
  implicit none
  private
  public :: pressed_patch, flange_part, press_contact, half_curvatures, most_patches

  !> What a patch has on the flange's side of the border; 0 where it does not reach it.
  type :: flange_part
    real(dp) :: largest = 0            !! largest pressure [Pa]
    real(dp) :: area = 0               !! under pressure [m^2]
    real(dp) :: approach = 0           !! largest interpenetration of the undeformed surfaces [m]
  end type flange_part

  !> A pressed patch on the surface developed into the plane: x in rolling direction, s the arc length along the wheel's profile.
  type :: pressed_patch
    logical :: flange = .false.        !! most of its load acts on the flange, not on the tread
    real(dp) :: dx = 0, ds = 0         !! lengths of an element [m]
    real(dp) :: low = 0                !! s where the grid begins [m]
    real(dp) :: half_x = 0             !! half of the length along x [m]
    real(dp) :: ends(2) = 0            !! ends along s [m]
    real(dp) :: approach = 0           !! largest interpenetration of the undeformed surfaces, along their normal [m]
    real(dp) :: deepest = 0            !! s where it is [m]
    real(dp) :: integral = 0           !! of the pressure [N]
    real(dp) :: largest = 0            !! largest pressure [Pa]
    real(dp) :: peak_s = 0             !! s of the largest pressure [m]
    real(dp) :: area = 0               !! under pressure [m^2]
    real(dp) :: hertz(3) = 0           !! semi-axes along x and s [m], largest pressure [Pa] of Hertz's ellipse with this force
                                       !! and the curvatures at `deepest`; 0 where the surfaces conform
    type(flange_part) :: part          !! on the flange
    real(dp), allocatable :: p(:, :)   !! pressures of the elements at x > 0, (nx, ns) [Pa]
    real(dp), allocatable :: width(:)  !! half of the pressed length along x of each row of elements, (ns) [m]
    real(dp), allocatable :: point(:, :)   !! rows of elements on the wheel, wheelset frame, (2, ns) [m]
  end type pressed_patch

  !> The contact table does not tell so small a patch from an open contact; share of the wheel's force.
  real(dp), parameter :: negligible = 1e-4_dp

contains

  !> Press a left wheel into its rail. The wheel is pressed as a whole. Patches of negligible force are left out.
  pure subroutine press_contact(side, elements, pose, patch, n, ok, total)
    type(side_type), intent(in) :: side
    type(elements_type), intent(in) :: elements
    real(dp), intent(in) :: pose(3)            !! axle centre y, z [m] and roll angle [rad], track frame
    type(pressed_patch), intent(out) :: patch(most_patches)
    integer, intent(out) :: n                  !! number of patches
    logical, intent(out) :: ok                 !! whether the solution converged
    real(dp), intent(out) :: total(4)          !! F_y, F_z of the rail on the wheel [N], M_x about the axle centre [N m], energy [J]
    type(patches_type) :: patches
    type(scan_type) :: scan
    real(dp) :: force(3, most_patches), ends(2), A, B
    integer :: first, last, g

    first = minval(side%zones%first)
    last = maxval(side%zones%last)
    scan = new_scan(side%pair)
    call scan_depth(side%pair, pose(:2), pose(3), first, last, scan)
    call press_patches(side%pair, elements, first, last, pose(:2), pose(3), scan, patches)
    ok = patches%ok
    total = 0
    total(4) = patches%energy
    do g = 1, patches%n
      associate (mesh => patches%mesh(g))
        ends = mesh%low + [0, size(patches%f, 2)]*mesh%ds
        force(:, g) = force_between(patches, ends(1), ends(2))
        total(:3) = total(:3) + force(:, g)
      end associate
    end do
    n = 0
    do g = 1, patches%n
      if (.not. 2*sum(patches%f(:, :, g)) > negligible*hypot(total(1), total(2))) cycle
      n = n + 1
      associate (one => patch(n), mesh => patches%mesh(g))
        one%dx = mesh%dx
        one%ds = mesh%ds
        one%low = mesh%low
        one%p = patches%f(:, :, g)/(mesh%dx*mesh%ds)
        one%integral = 2*sum(patches%f(:, :, g))
        call describe_overlap(side%pair, scan, first, last, pose(3), patches%overlaps%list(g), one%approach, one%deepest, A, B)
        call hertz_ellipse(one%integral, elements%e_star, A, B, one%hertz)
        call measure_pressure(one)
        call place_rows(side%pair, one)
        call part_patch(side, scan, first, last, patches%overlaps%list(g), one)
      end associate
    end do
  end subroutine press_contact

  !> What a patch has on the flange. A patch on both sides of the border is cut between its rows of elements.
  pure subroutine part_patch(side, scan, first, last, overlap, one)
    type(side_type), intent(in) :: side
    type(scan_type), intent(in) :: scan
    integer, intent(in) :: first, last         !! stations that are pressed
    type(overlap_type), intent(in) :: overlap
    type(pressed_patch), intent(inout) :: one
    type(pressed_patch) :: cut
    real(dp) :: station
    integer :: rows, low, high, node

    rows = max(0, min(nint((side%border - one%low)/one%ds), size(one%p, 2)))
    one%flange = 2*sum(one%p(:, :rows)) > sum(one%p)
    if (.not. any(one%p(:, :rows) > 0)) return
    if (.not. any(one%p(:, rows + 1:) > 0)) then
      one%part = flange_part(one%largest, one%area, one%approach)
      return
    end if
    cut = one
    cut%p = one%p(:, :rows)
    call measure_pressure(cut)
    low = max(first, count(side%pair%s < overlap%ends(1)))
    high = min(last, count(side%pair%s < side%border) + 1)
    call deepest(side%pair, scan, low, high, one%part%approach, station, node)
    one%part%largest = cut%largest
    one%part%area = cut%area
  end subroutine part_patch

  !> Points of the wheel at the rows of elements of a patch.
  pure subroutine place_rows(pair, one)
    type(pair_type), intent(in) :: pair
    type(pressed_patch), intent(inout) :: one
    real(dp) :: s, d1(2), d2(2)
    integer :: i, j

    allocate (one%point(2, size(one%p, 2)))
    do j = 1, size(one%p, 2)
      s = one%low + (j - 0.5_dp)*one%ds
      i = near_interval(pair%wheel, s)
      call curve_point(pair%wheel, s, i, one%point(:, j), d1, d2)
    end do
  end subroutine place_rows

  !> Largest pressure, area and lengths of a patch. The squares of the pressures around the largest one make a parabola in x and
  !> one in s, as in an ellipse, and the square falls linearly to the edge of the patch.
  pure subroutine measure_pressure(one)
    type(pressed_patch), intent(inout) :: one
    real(dp) :: square(0:size(one%p, 1), size(one%p, 2)), top(2), shift(2)
    integer :: at(2), nx, ns, i, j

    nx = size(one%p, 1)
    ns = size(one%p, 2)
    square(1:, :) = one%p**2
    square(0, :) = square(1, :)          ! the patch is symmetric about x = 0
    at = maxloc(square(1:, :))
    call parabola(square(:, at(2)), at(1) + 1, top(1), shift(1))
    call parabola(square(at(1), :), at(2), top(2), shift(2))
    one%largest = sqrt(sum(top) - square(at(1), at(2)))
    one%peak_s = one%low + (at(2) - 0.5_dp + shift(2))*one%ds
    one%width = one%dx*[(reach(one%p(:, j)), j=1, ns)]
    one%area = 2*one%ds*sum(one%width)
    one%half_x = maxval(one%width)
    one%ends(1) = one%low + one%ds*(ns - maxval([(reach(one%p(i, ns:1:-1)), i=1, nx)]))
    one%ends(2) = one%low + one%ds*maxval([(reach(one%p(i, :)), i=1, nx)])
  end subroutine measure_pressure

  !> The top of the parabola through the value k and its neighbours, and its distance from k.
  pure subroutine parabola(x, k, top, shift)
    real(dp), intent(in) :: x(:)
    integer, intent(in) :: k
    real(dp), intent(out) :: top, shift
    real(dp) :: bend

    top = x(k)
    shift = 0
    if (k == 1 .or. k == size(x)) return
    bend = x(k - 1) - 2*x(k) + x(k + 1)
    if (bend >= 0) return
    shift = (x(k - 1) - x(k + 1))/(2*bend)
    top = x(k) - (x(k + 1) - x(k - 1))**2/(8*bend)
  end subroutine parabola

  !> How many elements of a line are pressed up to its last one, and a part of the next one.
  pure real(dp) function reach(line)
    real(dp), intent(in) :: line(:)            !! pressures [Pa]
    integer :: k

    reach = 0
    k = findloc(line > 0, .true., 1, back=.true.)
    if (k == 0) return
    reach = k
    if (k == 1) return
    if (line(k - 1) > line(k)) reach = k - 0.5_dp + min(line(k)**2/(line(k - 1)**2 - line(k)**2), 0.9_dp)
  end function reach

  !> Largest interpenetration of an overlap and s where it is [m]; relative curvatures there, as in `half_curvatures`.
  pure subroutine describe_overlap(pair, scan, first, last, roll, overlap, approach, s, A, B)
    type(pair_type), intent(in) :: pair
    type(scan_type), intent(in) :: scan
    integer, intent(in) :: first, last         !! stations that are pressed
    real(dp), intent(in) :: roll               !! [rad]
    type(overlap_type), intent(in) :: overlap
    real(dp), intent(out) :: approach, s, A, B
    integer :: node, low, high

    low = max(first, count(pair%s < overlap%ends(1)))
    high = min(last, count(pair%s <= overlap%ends(2)) + 1)
    call deepest(pair, scan, low, high, approach, s, node)
    call half_curvatures(pair, s, roll, A, B)
  end subroutine describe_overlap

  !> Relative curvatures along x and along s at station s of the wheel, halved, so that the gap is A x^2 + B s^2 [1/m].
  pure subroutine half_curvatures(pair, s, roll, A, B)
    type(pair_type), intent(in) :: pair
    real(dp), intent(in) :: s, roll            !! [m, rad]
    real(dp), intent(out) :: A, B
    real(dp) :: angle, r(2), d1(2), d2(2)
    integer :: i

    i = near_interval(pair%wheel, s)
    call curve_point(pair%wheel, s, i, r, d1, d2)
    angle = atan2(d1(2), d1(1)) + roll
    A = cos(angle)/(-2*r(2))
    B = (mean_curvature(pair%wheel, s) + rail_curvature(pair, angle))/2
  end subroutine half_curvatures

  !> Hertz's ellipse (K. L. Johnson, Contact Mechanics, 4.25-4.32): semi-axes along x and along s [m], largest pressure [Pa].
  pure subroutine hertz_ellipse(force, e_star, A, B, facts)
    real(dp), intent(in) :: force              !! [N]
    real(dp), intent(in) :: e_star             !! [Pa]
    real(dp), intent(in) :: A, B               !! relative curvatures along x and along s, halved [1/m]
    real(dp), intent(out) :: facts(3)
    real(dp) :: ratio, k, D, long, short

    facts = 0
    if (min(A, B) <= 0 .or. force <= 0) return
    call ellipse(max(A, B)/min(A, B), ratio, k, D)
    long = (1.5_dp*force*D/(pi*e_star*min(A, B)))**(1/3.0_dp)
    short = ratio*long
    facts(:2) = merge([long, short], [short, long], A <= B)
    facts(3) = 1.5_dp*force/(pi*ratio*long**2)
  end subroutine hertz_ellipse

end module contact_pressure
