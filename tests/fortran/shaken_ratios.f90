!> Ratios of half-space to strip energy, from a table of strips and from that table with its last digits changed.
!>
!> usage: shaken_ratios case.nml
!> Prints for every zone: points along u, roll and the root of the depth of both, and the largest difference of their
!> ratios, 1 where the points differ.
program shaken_ratios
  use case, only: case_type
  use kinds, only: dp
  use grid_refinement, only: grid_type
  use halfspace_correction, only: solve_ratios
  use patch_grids, only: elements_type
  use run_tables, only: table_request
  use service_poses, only: request_type
  use shared, only: read_prepared
  use run_setup, only: setup_type
  implicit none
  save
  type(case_type) :: c
  type(setup_type), target :: setup
  type(request_type) :: request
  type(grid_type), allocatable :: ratio(:, :), found(:)
  real(dp), allocatable :: noise(:, :)
  real(dp) :: differ
  integer :: k, z, solutions(2)
  logical :: stopped

  call read_prepared(c, setup)
  associate (table => setup%wheelset%table)
    allocate (ratio(size(table%zones), 2))
    do k = 1, 2
      request = table_request(c, setup%side(1))
      call solve_ratios(request, c%accuracy, elements_type(5, 20, 2e-3_dp, request%e_star, .false.), table, found, &
        solutions, [0.0_dp, 1.0_dp], stopped)
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
end program shaken_ratios
