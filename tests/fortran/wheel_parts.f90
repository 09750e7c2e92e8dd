!> The parts of the left wheel's force on its tread and its flange, by the table and by half-spaces or strips of many elements.
!>
!> Usage: wheel_parts CASE < poses. A pose is y, z [m], roll [rad]; a row of the answer is, by the table: Fy, Fz, Mx of the tread
!> and of the flange [N, N, N m]; by elements: the same; whether these converged.
program wheel_parts
  use case, only: case_type
  use contact_table, only: find_roll, wheel_force
  use halfspace_patches, only: patches_type, press_patches
  use kinds, only: dp
  use patch_grids, only: elements_type
  use run_setup, only: setup_type
  use shared, only: read_prepared
  use station_scan, only: new_scan, scan_depth, scan_type
  use strip_law, only: modulus_near
  use table_growth, only: grown_potential
  use zone_tables, only: roll_type
  implicit none
  type(case_type) :: c
  type(setup_type) :: setup
  type(wheel_force) :: force
  type(roll_type) :: roll, opposite
  real(dp) :: pose(3), direct(3, 2)
  integer :: io, status
  logical :: ok

  call read_prepared(c, setup)
  do
    read (*, *, iostat=io) pose
    if (io /= 0) exit
    call find_roll(setup%wheelset%table, pose(3), .false., roll, opposite, status)
    call grown_potential(setup%wheelset%table, pose, roll, .false., force, status)
    call press(setup, pose, direct, ok)
    print '(12es24.15, i2)', -force%gradient, direct, merge(1, 0, ok)
  end do

contains

  !> Forces and moments on either side of the border, by elements.
  subroutine press(setup, pose, parts, ok)
    type(setup_type), intent(in) :: setup
    real(dp), intent(in) :: pose(3)
    real(dp), intent(out) :: parts(3, 2)
    logical, intent(out) :: ok
    type(patches_type) :: patches
    type(scan_type) :: scan
    real(dp) :: ends(2), row(3), share
    integer :: first, last, g, j

    parts = 0
    ok = .true.
    associate (side => setup%side(1), law => setup%wheelset%table%law)
      first = minval(side%zones%first)
      last = maxval(side%zones%last)
      scan = new_scan(side%pair)
      call scan_depth(side%pair, pose(:2), pose(3), first, last, scan)
      if (law%model == 'strip') then
        do j = first, last - 1
          associate (s => side%pair%s, n => scan%normal(:, j), x => scan%point(:, j) - pose(:2))
            if (scan%depth(j) <= 0) cycle
            row = [n, x(1)*n(2) - x(2)*n(1)]*scan%depth(j)*modulus_near(side%pair, s(j), law%e_star, pose(3))*(s(j + 1) - s(j))
            parts(:, merge(2, 1, s(j) < side%border)) = parts(:, merge(2, 1, s(j) < side%border)) + row
          end associate
        end do
        return
      end if
      call press_patches(side%pair, elements_type(12, 48, 1e-4_dp, law%e_star, law%influence == 'flat', .true.), first, last, &
        pose(:2), pose(3), scan, patches)
      ok = patches%ok
      do g = 1, patches%n
        associate (mesh => patches%mesh(g))
          do j = 1, size(patches%f, 2)
            ends = mesh%low + [j - 1, j]*mesh%ds
            row = 2*row_force(patches, g, j)
            share = max(0.0_dp, min((side%border - ends(1))/mesh%ds, 1.0_dp))
            parts = parts + reshape([(1 - share)*row, share*row], [3, 2])
          end do
        end associate
      end do
    end associate
  end subroutine press

  !> Half of the force and moment of a row of elements.
  pure function row_force(patches, g, j) result(force)
    type(patches_type), intent(in) :: patches
    integer, intent(in) :: g, j
    real(dp) :: force(3)

    associate (f => patches%f(:, j, g), n => patches%normal(:, :, j, g), x => patches%point(:, :, j, g))
      force = [sum(f*n(1, :)), sum(f*n(2, :)), sum(f*(x(1, :)*n(2, :) - x(2, :)*n(1, :)))]
    end associate
  end function row_force

end program wheel_parts
