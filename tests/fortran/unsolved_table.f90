!> Half-space solutions that do not converge, and a table that counts some, and points where the contact would pull.
!>
!> usage: unsolved_table case.nml
!> Prints how many poses were solved, once as for tables and once to no error at all, and how many of them did not
!> converge; writes into the case's table file that 3 of its 1000 solutions did not, and 2 of those of its error,
!> and that the contact would pull at 7 points in service.
program unsolved_table
  use case, only: case_type
  use errors, only: error_type
  use station_scan, only: new_scan, scan_depth, scan_type
  use hertz, only: contact_modulus
  use kinds, only: dp
  use halfspace_patches, only: patches_type, press_patches
  use patch_grids, only: elements_type
  use shared, only: read_prepared
  use run_setup, only: setup_type
  use table_file, only: save_table
  implicit none
  save
  type(case_type) :: c
  type(setup_type) :: setup
  type(scan_type) :: work
  type(patches_type) :: patches
  type(error_type), allocatable :: error
  real(dp) :: centre(2)
  integer :: k, unsolved

  call read_prepared(c, setup)
  associate (pair => setup%side(1)%pair)
    work = new_scan(pair)
    centre = [0.0_dp, pair%axle_height - 1e-4_dp]
    call scan_depth(pair, centre, 0.0_dp, 1, size(pair%s), work)
    unsolved = 0
    do k = 1, 2
      call press_patches(pair, elements_type(5, 20, merge(5e-4_dp, 0.0_dp, k == 1), &
        contact_modulus(c%youngs_modulus, c%poisson), .false.), &
        1, size(pair%s), centre, 0.0_dp, work, patches)
      if (.not. patches%ok) unsolved = unsolved + 1
    end do
  end associate
  print '(2i4)', 2, unsolved
  setup%wheelset%table%solutions = [1000, 3]
  setup%wheelset%table%accuracy%unsolved = 2
  setup%wheelset%table%accuracy%pulling = 7
  call save_table(trim(c%table_file), setup%wheelset%table, error)
  if (allocated(error)) error stop error%message
end program unsolved_table
