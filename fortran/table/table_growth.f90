!> How a contact table grows: what a pose needs is solved, and kept for all poses that need it again.
!>
!> A value is a function of its point alone, whoever needs it first: every search begins anew. A coefficient depends on the values
!> of its point and of those around it. So neither depends on the poses that came before, on threads or on what a file kept, and a
!> value that is there never changes. Several threads may grow a table at once: where two need the same value both solve it, to
!> the same bits.
module table_growth
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use bspline, only: axis_basis, axis_cell, basis_type
  use contact_law, only: law_type
  use contact_table, only: table_type, wheel_force, wheel_potential
  use contact_zones, only: zone_type
  use halfspace_patches, only: patches_type, press_patches
  use kinds, only: dp
  use patch_grids, only: elements_type
  use station_scan, only: new_scan, scan_depth, scan_type, touch
  use strip_law, only: zone_energy
  use wheel_rail_pair, only: rolled
  use zone_influence, only: find_influences
  use zone_tables, only: gap_of_energy, gap_of_height, gap_of_influence, gap_type, height, missing, roll_type, &
    zone_pose
  implicit none
  private
  public :: grown_potential

  ! Grids over half a patch. The energy has the square of the solver's error.
  integer, parameter :: elements_x = 5, elements_s = 20
  real(dp), parameter :: solver_tolerance = 2e-3_dp

contains

  !> The potential of a wheel (see `wheel_potential`) on a table that grows where the pose needs it.
  subroutine grown_potential(table, pose, roll, with_hessian, force, status)
    type(table_type), intent(inout) :: table
    real(dp), intent(in) :: pose(3)
    type(roll_type), intent(in) :: roll
    logical, intent(in) :: with_hessian
    type(wheel_force), intent(out) :: force
    integer, intent(out) :: status
    type(gap_type) :: gap

    do
      call wheel_potential(table, pose, roll, with_hessian, force, status, gap)
      if (status /= missing) exit
      call fill(table, gap)
    end do
  end subroutine grown_potential

  !> Solve what a gap of a table needs.
  subroutine fill(table, gap)
    type(table_type), intent(inout) :: table
    type(gap_type), intent(in) :: gap
    integer :: i, j, k

    associate (c => gap%cell)
      if (gap%what == gap_of_height) then
        call fill_heights(table, gap%zone, c(1), c(2))
        return
      end if
      do k = c(3), c(3) + 3
        do j = c(2), c(2) + 3
          do i = c(1), c(1) + 3
            if (gap%what == gap_of_energy) call fill_energy(table, gap%zone, i, j, k)
            if (gap%what == gap_of_influence) call fill_influence(table, gap%zone, i, j, k)
          end do
        end do
      end do
    end associate
  end subroutine fill

  !> Fill the coefficients of h in a cell, and bound h there: a spline is at most its largest coefficient.
  subroutine fill_heights(table, z, i, j)
    type(table_type), intent(inout) :: table
    integer, intent(in) :: z, i, j         !! zone; cell of roll, of u
    integer :: k, l, m, n
    real(dp) :: c

    associate (t => table%zones(z), r => table%roll)
      do l = j, j + 3
        do k = i, i + 3
          if (.not. ieee_is_nan(t%h(k, l))) cycle
          c = 0
          do n = 1, 3
            do m = 1, 3
              c = c + r%weight(m, k)*t%u_h%weight(n, l)*height_at(table, z, r%first(k) + m - 1, t%u_h%first(l) + n - 1)
            end do
          end do
          call publish(c, t%h(k, l))
        end do
      end do
      call publish(maxval(t%h(i:i + 3, j:j + 3)), t%h_bound(i, j))
    end associate
  end subroutine fill_heights

  !> Fill a coefficient of S.
  subroutine fill_energy(table, z, i, j, k)
    type(table_type), intent(inout) :: table
    integer, intent(in) :: z, i, j, k      !! zone; coefficient over q, roll, u
    integer :: l, m, n
    real(dp) :: c

    associate (t => table%zones(z), r => table%roll)
      if (.not. ieee_is_nan(t%s(i, j, k))) return
      c = 0
      do n = 1, 3
        do m = 1, 3
          do l = 1, 3
            c = c + t%q%weight(l, i)*r%weight(m, j)*t%u%weight(n, k) &
              *energy_at(table, z, t%q%first(i) + l - 1, r%first(j) + m - 1, t%u%first(k) + n - 1)
          end do
        end do
      end do
      call publish(c, t%s(i, j, k))
    end associate
  end subroutine fill_energy

  !> Fill a coefficient of the influence of a pair.
  subroutine fill_influence(table, n, i, j, k)
    type(table_type), intent(inout) :: table
    integer, intent(in) :: n, i, j, k      !! pair; coefficient over p, roll, u
    integer :: l, m, v
    real(dp) :: c

    associate (pair => table%pairs(n))
      if (.not. ieee_is_nan(pair%c(i, j, k))) return
      c = 0
      do v = 1, 3
        do m = 1, 3
          do l = 1, 3
            c = c + pair%p%weight(l, i)*pair%roll%weight(m, j)*pair%u%weight(v, k) &
              *influence_at(table, n, pair%p%first(i) + l - 1, pair%roll%first(j) + m - 1, pair%u%first(k) + v - 1)
          end do
        end do
      end do
      call publish(c, pair%c(i, j, k))
    end associate
  end subroutine fill_influence

  !> h [m] at a point of a zone's axes. Beside the rail, where the zone cannot touch, h goes on in a straight line from the nearest
  !> points at which it does, towards u = 0.
  recursive real(dp) function height_at(table, z, i, j) result(h)
    type(table_type), intent(inout) :: table
    integer, intent(in) :: z, i, j         !! zone; point of roll, of u
    real(dp), parameter :: above = 0.02_dp ! height over the touching one in the reference pose, where searches begin [m]
    type(scan_type) :: scan
    real(dp) :: across(2), centre(2), move, station
    logical :: ok
    integer :: inward

    associate (t => table%zones(z), pair => table%law%side%pair, zone => table%law%side%zones(z), roll => table%roll%x(i))
      h = t%h_at(i, j)
      if (.not. ieee_is_nan(h)) return
      scan = new_scan(pair)
      across = [-t%along(2), t%along(1)]
      centre = (t%origin(1) + t%u_h%x(j))*t%along + (t%origin(2) + above)*across - rolled(t%pole, roll)
      call touch(pair, scan, zone%first, zone%last, centre, roll, zone%alpha, move, station, ok)
      if (ok) then
        h = above + move
      else
        inward = merge(1, -1, t%u_h%x(j) < 0)
        if (abs(t%u_h%x(j)) > abs(t%u_h%x(j + inward))) then
          associate (x => t%u_h%x([j, j + inward, j + 2*inward]))
            h = height_at(table, z, i, j + inward)
            h = h + (h - height_at(table, z, i, j + 2*inward))/(x(2) - x(3))*(x(1) - x(2))
          end associate
        else
          ! It touches nowhere at this roll angle.
          h = -1
        end if
      end if
      call publish(h, t%h_at(i, j))
    end associate
  end function height_at

  !> S [J/m^2.5] at a point of a zone's axes. S(0) is that of a parabola.
  recursive real(dp) function energy_at(table, z, i, j, k) result(s)
    type(table_type), intent(inout) :: table
    integer, intent(in) :: z, i, j, k      !! zone; point of q, of roll, of u
    real(dp) :: pose(3), energy, h
    logical :: ok, first

    associate (t => table%zones(z), q => table%zones(z)%q%x)
      s = t%s_at(i, j, k)
      if (.not. ieee_is_nan(s)) return
      ok = .true.
      if (i == 1) then
        s = energy_at(table, z, 2, j, k)*q(3)*q(4)/((q(2) - q(3))*(q(2) - q(4))) &
          + energy_at(table, z, 3, j, k)*q(2)*q(4)/((q(3) - q(2))*(q(3) - q(4))) &
          + energy_at(table, z, 4, j, k)*q(2)*q(3)/((q(4) - q(2))*(q(4) - q(3)))
      else
        h = height_of(table, z, table%roll%x(j), t%u%x(k))
        pose = zone_pose(t, t%u%x(k), h - q(i)**2, table%roll%x(j))
        call press_zone(table%law, table%law%side%zones(z), pose, energy, ok)
        s = energy/q(i)**5
      end if
      call publish(s, t%s_at(i, j, k), first)
      if (first .and. i > 1) call count_solution(table, ok)
    end associate
  end function energy_at

  !> Influence [m/N] of a pair at a point of its axes. All pairs with the same second zone have the same points, and their
  !> influences come from one solution.
  real(dp) function influence_at(table, n, i, j, k) result(c)
    type(table_type), intent(inout) :: table
    integer, intent(in) :: n, i, j, k      !! pair; point of p, of roll, of u
    real(dp), parameter :: least_depth = 0.2_dp   ! of the first point, at which nothing would carry, of the second one
    real(dp) :: pose(3), h, influence(size(table%zones))
    logical :: ok, first
    integer :: m

    associate (pair => table%pairs(n), second => table%pairs(n)%zone(2))
      c = pair%c_at(i, j, k)
      if (.not. ieee_is_nan(c)) return
      h = height_of(table, second, pair%roll%x(j), pair%u%x(k))
      pose = zone_pose(table%zones(second), pair%u%x(k), h - max(pair%p%x(i), least_depth*pair%p%x(2)), pair%roll%x(j))
      call find_influences(table%law, elements(table%law), second, pose, influence, ok)
      do m = 1, size(table%pairs)
        associate (other => table%pairs(m))
          if (other%zone(2) /= second) cycle
          call publish(influence(other%zone(1)), other%c_at(i, j, k), first)
          if (m == n .and. first) call count_solution(table, ok)
        end associate
      end do
      c = pair%c_at(i, j, k)
    end associate
  end function influence_at

  !> h [m] of a zone's spline.
  real(dp) function height_of(table, z, roll, u) result(h)
    type(table_type), intent(inout) :: table
    integer, intent(in) :: z
    real(dp), intent(in) :: roll, u
    type(basis_type) :: basis
    integer :: cell

    cell = axis_cell(table%roll, roll)
    call axis_basis(table%roll, cell, roll, basis, .false.)
    h = height(table%zones(z), u, basis)
    if (.not. ieee_is_nan(h)) return
    call fill_heights(table, z, cell, axis_cell(table%zones(z)%u_h, u))
    h = height(table%zones(z), u, basis)
  end function height_of

  !> Energy [J] of a zone that is pressed alone in a pose.
  subroutine press_zone(law, zone, pose, energy, ok)
    type(law_type), intent(in) :: law
    type(zone_type), intent(in) :: zone
    real(dp), intent(in) :: pose(3)
    real(dp), intent(out) :: energy
    logical, intent(out) :: ok             !! whether half-spaces converged
    type(patches_type) :: patches
    type(scan_type) :: scan

    ok = .true.
    scan = new_scan(law%side%pair)
    associate (pair => law%side%pair)
      call scan_depth(pair, pose(:2), pose(3), zone%first, zone%last, scan)
      energy = 0
      if (all(scan%depth(zone%first:zone%last) <= 0)) return
      if (law%model /= 'halfspace') then
        energy = zone_energy(pair, zone, law%model, law%e_star, pose(3), scan)
        return
      end if
      call press_patches(pair, elements(law), zone%first, zone%last, pose(:2), pose(3), scan, patches)
      ok = patches%ok
      energy = patches%energy
    end associate
  end subroutine press_zone

  pure type(elements_type) function elements(law)
    type(law_type), intent(in) :: law

    elements = elements_type(elements_x, elements_s, solver_tolerance, law%e_star, law%influence == 'flat', .true.)
  end function elements

  subroutine count_solution(table, ok)
    type(table_type), intent(inout) :: table
    logical, intent(in) :: ok

    !$omp atomic
    table%solutions(1) = table%solutions(1) + 1
    if (ok) return
    !$omp atomic
    table%solutions(2) = table%solutions(2) + 1
  end subroutine count_solution

  !> Show a number to other threads.
  subroutine publish(x, shared, first)
    real(dp), intent(in) :: x
    real(dp), intent(inout) :: shared
    logical, intent(out), optional :: first    !! no other thread has found it meanwhile
    real(dp) :: before

    !$omp atomic capture
    before = shared
    shared = x
    !$omp end atomic
    if (present(first)) first = ieee_is_nan(before)
  end subroutine publish

end module table_growth
