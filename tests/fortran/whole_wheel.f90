!> A whole wheel pressed on its rail in some poses, without a table.
!>
!> usage: whole_wheel case.nml < poses
!> Reads poses (y, z, roll) of the left wheel [m, rad], one a line. Answers for each pose, one a line: number of patches; 1 if the
!> solution converged, else 0; energy [J]; F_y, F_z by the loads along the rail's normals [N]; the least pivot of Cholesky's
!> decomposition of the influence matrix over the element's diagonal, which is above 0 if the matrix is positive definite; the
!> largest difference of the matrix from its transpose over its largest element.
program whole_wheel
  use case, only: case_type
  use direct_force, only: fine_elements
  use halfspace_patches, only: force_between, patches_type, press_patches
  use kinds, only: dp
  use run_setup, only: setup_type
  use shared, only: read_prepared
  use station_scan, only: new_scan, scan_depth, scan_type
  implicit none
  save
  type(case_type) :: c
  type(setup_type) :: setup
  real(dp) :: pose(3)
  integer :: status

  call read_prepared(c, setup)
  do
    read (*, *, iostat=status) pose
    if (status /= 0) exit
    call answer()
  end do

contains

  subroutine answer()
    type(patches_type) :: patches
    type(scan_type) :: scan
    real(dp) :: force(3), pivot, skew
    integer :: first, last

    pivot = 1
    skew = 0
    associate (law => setup%wheelset%table%law)
      first = minval(law%side%zones%first)
      last = maxval(law%side%zones%last)
      scan = new_scan(law%side%pair)
      call scan_depth(law%side%pair, pose(:2), pose(3), first, last, scan)
      call press_patches(law%side%pair, fine_elements(law), first, last, pose(:2), pose(3), scan, patches)
      force = force_between(patches, law%side%pair%s(first), law%side%pair%s(last))
    end associate
    if (patches%n > 0) then
      skew = maxval(abs(patches%influence - transpose(patches%influence)))/maxval(abs(patches%influence))
      pivot = least_pivot(patches%influence)
    end if
    print '(i0, 1x, i0, *(es24.15))', patches%n, merge(1, 0, patches%ok), patches%energy, force(:2), pivot, skew
  end subroutine answer

  !> The least pivot of a symmetric matrix over the diagonal. It ends at the first one that is not above 0.
  real(dp) function least_pivot(matrix) result(least)
    real(dp), intent(in) :: matrix(:, :)
    real(dp) :: a(size(matrix, 1), size(matrix, 1)), diagonal(size(matrix, 1))
    integer :: i, j

    a = matrix
    diagonal = [(a(i, i), i=1, size(diagonal))]
    least = 1
    do i = 1, size(diagonal)
      least = min(least, a(i, i)/diagonal(i))
      if (.not. a(i, i) > 0) return
      do j = i + 1, size(diagonal)
        a(i + 1:, j) = a(i + 1:, j) - a(i + 1:, i)*(a(i, j)/a(i, i))
      end do
    end do
  end function least_pivot

end program whole_wheel
