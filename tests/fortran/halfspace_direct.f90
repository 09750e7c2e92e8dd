!> Left-wheel contact forces at given poses, from the table of the case's model and
!> from direct half-space solutions.
!>
!> usage: halfspace_direct input.nml < poses
!> Reads lines `y z roll` (axle centre above top of rail) from standard input; writes
!> for tread and flange: F_y, F_z, M_x from the table, the same directly; then F_y, F_z, M_x of the wheel
!> pressed as a whole if a patch reaches over the border of tread and flange, else of both apart.
program halfspace_direct
  use case, only: case_type
  use station_scan, only: scan_depth
  use halfspace_patches, only: patches_type, press_patches
  use shared, only: branch_contact, direct_type, new_direct, read_prepared
  use kinds, only: dp
  use run_setup, only: setup_type
  use wheelset, only: contact_state, wheel_contacts
  implicit none
  save
  type(case_type) :: c
  type(setup_type) :: setup
  type(direct_type) :: direct
  type(contact_state) :: state
  type(patches_type), allocatable :: patches
  real(dp) :: pose(3), forces(3, 2), whole(3), exact
  integer :: stat, branch, first, border, last
  logical :: ok

  call read_prepared(c, setup)
  direct = new_direct(c, setup)
  ! Stations rise from the flange to the tread.
  first = minval(setup%side(1)%zones%first)
  border = maxval(setup%side(1)%zones%last, setup%side(1)%zones%flange)
  last = maxval(setup%side(1)%zones%last)
  do
    read (*, *, iostat=stat) pose
    if (stat /= 0) exit
    call wheel_contacts(setup%wheelset, 1, pose, state)
    if (state%status /= 0) error stop 'a pose is not on the table'
    do branch = 1, 2
      call branch_contact(direct, setup, branch, pose, exact, forces(:, branch))
    end do
    whole = sum(forces, 2)
    direct%work%fresh = .true.
    call scan_depth(setup%side(1)%pair, pose(:2), pose(3), first, last, direct%work)
    if (direct%work%depth(border) > 0) then
      if (allocated(patches)) deallocate (patches)
      allocate (patches)
      call press_patches(setup%side(1)%pair, direct%elements, first, last, pose(:2), pose(3), direct%work, patches, &
        exact, ok, whole)
      if (.not. ok) error stop 'the half-space solution failed'
    end if
    write (*, '(15es24.16, i3)') (-state%slope(:, branch), forces(:, branch), branch=1, 2), whole, &
      merge(1, 0, direct%work%depth(border) > 0)
  end do
end program halfspace_direct
