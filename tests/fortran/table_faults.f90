!> What faults make of the contact table of a case.
!>
!> usage: table_faults case.nml fault
!> missed: for the table as it is, without its flange, and with the opposite sign of S, the largest error that it states on the
!>   tread and on the flange, of max(|F|, 5 kN), the number of points in service at which the contact would pull, and the status
!>   of the pose at rest.
!> unsolved: how many poses were solved by half-spaces, once as for tables and once to no error at all, and how many of them did
!>   not converge. Writes into the case's table file that 3 of its 1000 solutions did not, and 2 of those of its error, and that
!>   the contact would pull at 7 points in service.
!> shaken: for every zone, points along u, roll and the root of the depth of the ratios of half-space to strip energy, from the
!>   table of strips and from that table with its last digits changed, and the largest difference of their ratios, 1 where the
!>   points differ.
program table_faults
  use case, only: case_type
  use errors, only: error_type
  use grid_refinement, only: grid_type
  use halfspace_correction, only: solve_ratios
  use halfspace_patches, only: patches_type, press_patches
  use kinds, only: dp
  use patch_grids, only: elements_type
  use run_setup, only: setup_type
  use run_tables, only: table_request
  use service_poses, only: request_type
  use shared, only: read_prepared
  use station_scan, only: new_scan, scan_depth, scan_type
  use table_error, only: measure
  use table_file, only: save_table
  use wheelset, only: contact_state, contacts
  use zone_tables, only: bound_heights
  implicit none
  save
  type(case_type) :: c
  type(setup_type), target :: setup
  type(request_type) :: request
  character(16) :: fault
  logical :: stopped

  call read_prepared(c, setup)
  call get_command_argument(2, fault)
  request = table_request(c, setup%side(1))
  select case (fault)
  case ('missed')
    call miss_contacts()
  case ('unsolved')
    call leave_unsolved()
  case ('shaken')
    call shake_strips()
  end select

contains

  subroutine miss_contacts()
    type(contact_state) :: state
    integer :: k, z

    associate (table => setup%wheelset%table)
      do k = 1, 3
        do z = 1, size(table%zones)
          if (k == 3) table%zones(z)%s = -table%zones(z)%s
          if (k /= 2 .or. .not. table%zones(z)%past_root) cycle
          table%zones(z)%h = table%zones(z)%h - 1.0_dp
          call bound_heights(table%zones(z))
        end do
        call measure(table_request(c, setup%side(1)), table, stopped)
        call contacts(setup%wheelset, setup%equilibrium, state)
        print '(2es12.4, i2)', table%accuracy%largest(:2), state%status
      end do
    end associate
  end subroutine miss_contacts

  subroutine leave_unsolved()
    type(scan_type) :: work
    type(patches_type) :: patches
    type(error_type), allocatable :: error
    real(dp) :: centre(2)
    integer :: k, unsolved

    unsolved = 0
    associate (pair => setup%side(1)%pair)
      work = new_scan(pair)
      centre = [0.0_dp, pair%axle_height - 1e-4_dp]
      call scan_depth(pair, centre, 0.0_dp, 1, size(pair%s), work)
      do k = 1, 2
        call press_patches(pair, elements_type(5, 20, merge(5e-4_dp, 0.0_dp, k == 1), request%e_star, .false.), 1, size(pair%s), &
          centre, 0.0_dp, work, patches)
        if (.not. patches%ok) unsolved = unsolved + 1
      end do
    end associate
    print '(2i4)', 2, unsolved
    setup%wheelset%table%solutions = [1000, 3]
    setup%wheelset%table%accuracy%unsolved = 2
    call save_table(trim(c%table_file), setup%wheelset%table, error)
    if (allocated(error)) error stop error%message
  end subroutine leave_unsolved

  subroutine shake_strips()
    type(grid_type), allocatable :: ratio(:, :), found(:)
    real(dp), allocatable :: noise(:, :)
    real(dp) :: differ
    integer :: k, z, solutions(2)

    associate (table => setup%wheelset%table)
      allocate (ratio(size(table%zones), 2))
      do k = 1, 2
        call solve_ratios(request, c%accuracy, elements_type(5, 20, 2e-3_dp, request%e_star, .false.), table, found, solutions, &
          stopped)
        ratio(:, k) = found
        do z = 1, size(table%zones)
          allocate (noise, mold=table%zones(z)%h)
          call random_number(noise)
          table%zones(z)%h = table%zones(z)%h*(1 + 1e-13_dp*(2*noise - 1))
          deallocate (noise)
        end do
      end do
    end associate
    do z = 1, size(ratio, 1)
      differ = 1
      if (all(shape(ratio(z, 1)%f) == shape(ratio(z, 2)%f))) differ = maxval(abs(ratio(z, 1)%f - ratio(z, 2)%f))
      print '(6i5, es10.2)', (ratio(z, k)%u%n, ratio(z, k)%roll%n, ratio(z, k)%q%n, k=1, 2), differ
    end do
  end subroutine shake_strips

end program table_faults
