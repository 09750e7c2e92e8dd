!> Tread and flange of the left wheel as two half-space systems and in one.
!>
!> usage: tread_and_flange input.nml < poses
!> Reads lines `y z roll` (axle centre above top of rail) from standard input; writes the normal forces [N] of tread
!> and flange solved apart, and in one system; the largest depths [m] of tread and flange inside the rail; the
!> displacement [m] by the tread's pressures where the flange is deepest, and the distance [m] of that place from
!> the tread's centre of pressure along the wheel.
program tread_and_flange
  use case, only: case_type
  use station_scan, only: scan_depth
  use kinds, only: dp, pi
  use halfspace_patches, only: patches_type, press_patches
  use shared, only: direct_type, new_direct, read_prepared
  use run_setup, only: setup_type
  implicit none
  save
  type(case_type) :: c
  type(setup_type) :: setup
  type(direct_type) :: direct
  type(patches_type) :: tread, flange, whole
  real(dp) :: pose(3), apart(2), together(2), moved, distance
  integer :: stat, first, border, last

  call read_prepared(c, setup)
  direct = new_direct(c, setup)
  ! Stations rise from the flange to the tread.
  first = minval(setup%side(1)%zones%first)
  border = maxval(setup%side(1)%zones%last, setup%side(1)%zones%flange)
  last = maxval(setup%side(1)%zones%last)
  do
    read (*, *, iostat=stat) pose
    if (stat /= 0) exit
    direct%work%fresh = .true.
    call scan_depth(setup%side(1)%pair, pose(:2), pose(3), first, last, direct%work)
    call press(first, border, flange)
    call press(border, last, tread)
    call press(first, last, whole)
    apart = normal_forces(tread) + normal_forces(flange)
    together = normal_forces(whole)
    call far_field(tread, setup%side(1)%pair%s(first - 1 + maxloc(direct%work%depth(first:border), 1)), moved, distance)
    write (*, '(8es24.16)') apart, together, maxval(direct%work%depth(border:last)), &
      maxval(direct%work%depth(first:border)), moved, distance
  end do

contains

  subroutine press(from, to, patches)
    integer, intent(in) :: from, to
    type(patches_type), intent(out) :: patches
    real(dp) :: energy
    logical :: ok

    call press_patches(setup%side(1)%pair, direct%elements, from, to, pose(:2), pose(3), direct%work, patches, &
      energy, ok)
    if (.not. ok) error stop 'the half-space solution failed'
  end subroutine press

  !> Normal forces [N] of tread and flange, by the pressures on either side of the border.
  function normal_forces(patches) result(force)
    type(patches_type), intent(in) :: patches
    real(dp) :: force(2), s
    integer :: g, j, branch

    force = 0
    do g = 1, patches%n
      associate (mesh => patches%mesh(g))
        do j = 1, size(patches%p, 2)
          s = mesh%low + (j - 0.5_dp)*mesh%ds
          branch = merge(2, 1, s < setup%side(1)%pair%s(border))
          force(branch) = force(branch) + 2*sum(patches%p(:, j, g))*mesh%dx*mesh%ds
        end do
      end associate
    end do
  end function normal_forces

  !> Displacement [m] at station s and x = 0 by pressures that lie elsewhere (J. Boussinesq), and the distance of the
  !> pressures' centre.
  subroutine far_field(patches, s, moved, distance)
    type(patches_type), intent(in) :: patches
    real(dp), intent(in) :: s
    real(dp), intent(out) :: moved, distance
    real(dp) :: load, total, way
    integer :: g, i, j

    moved = 0
    total = 0
    distance = 0
    do g = 1, patches%n
      associate (mesh => patches%mesh(g))
        do j = 1, size(patches%p, 2)
          way = mesh%low + (j - 0.5_dp)*mesh%ds - s
          do i = 1, size(patches%p, 1)
            load = 2*patches%p(i, j, g)*mesh%dx*mesh%ds
            total = total + load
            distance = distance + load*way
            moved = moved + load/(pi*direct%e_star*hypot((i - 0.5_dp)*mesh%dx, way))
          end do
        end do
      end associate
    end do
    if (total > 0) distance = distance/total
  end subroutine far_field

end program tread_and_flange
