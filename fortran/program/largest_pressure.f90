!> Pressures of a run by the model 'halfspace': the largest one of all contacts, and those at the first peak of each flange.
!>
!> A half-space solution costs as much as thousands of steps, so few poses are solved. Hertz's theory, with the curvatures where
!> the resultant of a contact acts, says which row of each contact presses hardest. Where curvatures change along the patch it may
!> choose wrongly, so the row with the largest force is solved too. (Section `pressure` of `make validate` solves the other rows.)
module largest_pressure
  use case, only: case_type
  use contact_pressure, only: flange_part, half_curvatures, most_patches, press_contact, pressed_patch
  use contact_zones, only: on_flange, side_type
  use curve, only: curve_point, near_interval
  use hertz, only: contact_modulus
  use kinds, only: dp
  use motion_state, only: motion_type
  use patch_grids, only: elements_type
  use wheel_rail_pair, only: mirror, rolled
  use wheelset, only: flanges, right_tread, treads
  implicit none
  private
  public :: hardest_rows, moment_type, pressure_type, has_pressures, find_pressures, grids

  integer, parameter :: coarse(2) = [6, 24], fine(2) = [12, 48]   !! elements over x > 0 and s of a patch

  !> A moment of a contact.
  type :: moment_type
    real(dp) :: rank = -1              !! among the moments of a contact; -1: there is none
    real(dp) :: t = 0                  !! [s]
    real(dp) :: q(3) = 0               !! pose [m, m, rad]
  end type moment_type

  !> The moment of each contact at which Hertz's pressure is largest, and that at which the force is.
  type :: hardest_rows
    type(moment_type) :: by_pressure(4), by_force(4)
  contains
    procedure :: note
  end type hardest_rows

  !> The largest pressure of a run.
  type :: pressure_type
    real(dp) :: largest = 0            !! [Pa]; 0 without one
    real(dp) :: t = 0                  !! [s]
    real(dp) :: place(2) = 0           !! y, z in the track frame [m]
    integer :: contact = 0             !! left tread to right flange
  end type pressure_type

contains

  !> Whether the pressures of a case are wanted, and its contacts have some.
  pure logical function has_pressures(c)
    type(case_type), intent(in) :: c

    has_pressures = c%formulation == 'elastic' .and. c%model == 'halfspace' .and. c%pressures == 'yes'
  end function has_pressures

  !> Take note of a row.
  pure subroutine note(this, side, motion, force, station)
    class(hardest_rows), intent(inout) :: this
    type(side_type), intent(in) :: side(2)     !! left, right
    type(motion_type), intent(in) :: motion
    real(dp), intent(in) :: force(4)           !! normal [N]
    real(dp), intent(in) :: station(4)         !! of the wheel where each resultant acts [m]
    real(dp) :: A, B
    integer :: k, wheel

    do k = 1, 4
      if (.not. force(k) > 0) cycle
      wheel = merge(1, 2, k < right_tread)
      call half_curvatures(side(wheel)%pair, station(k), merge(motion%q(3), -motion%q(3), wheel == 1), A, B)
      call keep(this%by_force(k), force(k))
      ! The pressure grows with N (A B (A + B))^(2/3), within some percent (J. A. Greenwood, Int. J. Mech. Sci. 39 (1997) 233-248).
      if (min(A, B) > 0) call keep(this%by_pressure(k), force(k)**3*(A*B*(A + B))**2)
    end do

  contains

    pure subroutine keep(moment, rank)
      type(moment_type), intent(inout) :: moment
      real(dp), intent(in) :: rank

      if (rank > moment%rank) moment = moment_type(rank, motion%t, motion%q)
    end subroutine keep

  end subroutine note

  !> The largest pressure of a run, and the pressures at the first peak of each flange.
  pure subroutine find_pressures(c, side, rows, first_peak, largest, flange)
    type(case_type), intent(in) :: c
    type(side_type), intent(in) :: side(2)     !! left, right
    type(hardest_rows), intent(in) :: rows
    type(moment_type), intent(in) :: first_peak(2)   !! of the left and of the right flange
    type(pressure_type), intent(out) :: largest
    type(flange_part), intent(out) :: flange(2)
    type(moment_type) :: moments(8), hardest
    type(pressure_type) :: one, here
    type(flange_part) :: unused
    integer :: wheels(8), wheel, k

    do k = 1, 2
      if (first_peak(k)%rank < 0) cycle
      call press(c, side(k), k, first_peak(k), fine, one, flange(k))
      if (one%largest > largest%largest) largest = one
    end do
    moments = [rows%by_pressure, rows%by_force]
    wheels = [1, 1, 2, 2, 1, 1, 2, 2]
    wheel = 0
    one = largest
    do k = 1, size(moments)
      ! The row of a first peak has been solved.
      if (moments(k)%rank < 0 .or. abs(moments(k)%t - first_peak(wheels(k))%t) <= 0) cycle
      call press(c, side(wheels(k)), wheels(k), moments(k), coarse, here, unused)
      if (here%largest <= one%largest) cycle
      one = here
      hardest = moments(k)
      wheel = wheels(k)
    end do
    if (wheel == 0) return
    call press(c, side(wheel), wheel, hardest, fine, one, unused)
    if (one%largest > largest%largest) largest = one
  end subroutine find_pressures

  !> The largest pressure of a wheel at a moment, and the pressures of its flange.
  pure subroutine press(c, side, wheel, moment, elements, largest, flange)
    type(case_type), intent(in) :: c
    type(side_type), intent(in) :: side        !! of the wheel
    integer, intent(in) :: wheel               !! 1 left, 2 right
    type(moment_type), intent(in) :: moment
    integer, intent(in) :: elements(2)
    type(pressure_type), intent(out) :: largest
    type(flange_part), intent(out) :: flange
    type(pressed_patch) :: patch(most_patches)
    real(dp) :: total(4), r(2), d1(2), d2(2)
    integer :: sign, n, g, i
    logical :: ok

    call press_contact(side, grids(c, elements), merge(moment%q, mirror*moment%q, wheel == 1), patch, n, ok, total)
    if (.not. ok .or. n == 0) return
    sign = merge(1, -1, wheel == 1)
    g = maxloc(patch(:n)%largest, 1)
    i = near_interval(side%pair%wheel, patch(g)%peak_s)
    call curve_point(side%pair%wheel, patch(g)%peak_s, i, r, d1, d2)
    r = rolled(r, sign*moment%q(3))
    largest = pressure_type(patch(g)%largest, moment%t, moment%q(:2) + [sign*r(1), r(2)], &
      merge(flanges(wheel), treads(wheel), on_flange(side, patch(g)%peak_s)))
    associate (part => patch(:n)%part)
      flange = flange_part(maxval(part%largest), sum(part%area), maxval(part%approach))
    end associate
  end subroutine press

  !> Grids of nx by ns elements for the bodies of a case.
  pure type(elements_type) function grids(c, elements)
    type(case_type), intent(in) :: c
    integer, intent(in) :: elements(2)
    real(dp), parameter :: tolerance = 1e-6_dp   ! of the depth under pressure

    grids = elements_type(elements(1), elements(2), tolerance, &
      c%stiffness_scale*contact_modulus(c%youngs_modulus, c%poisson), c%influence == 'flat')
  end function grids

end module largest_pressure
