!> A smoothing curve through points.
!>
!> usage: curve_points < input
!> Reads `n smoothing`, n lines `y z`, then stations; writes y, z, tangent angle and
!> curvature at each station.
program curve_points
  use curve, only: curve_frame, curve_type
  use curve_fit, only: fit_curve
  use errors, only: error_type
  use kinds, only: dp
  implicit none
  save
  type(curve_type) :: c
  type(error_type), allocatable :: error
  real(dp), allocatable :: points(:, :)
  real(dp) :: smoothing, s, r(2), angle, curvature
  integer :: n, stat

  read (*, *) n, smoothing
  allocate (points(2, n))
  read (*, *) points
  call fit_curve(points(1, :), points(2, :), smoothing, c, error)
  if (allocated(error)) error stop error%message
  do
    read (*, *, iostat=stat) s
    if (stat /= 0) exit
    call curve_frame(c, s, r, angle, curvature)
    write (*, '(4es24.16)') r, angle, curvature
  end do
end program curve_points
