!> Axes that are halved where the spline on them errs.
!>
!> A cubic spline through values of f misses f by at most d^4 f''''/384 in a cell of
!> length d and its slope by d^3 f'''' sqrt(3)/216 (those of Hermite's interpolation;
!> C. A. Hall, J. Approx. Theory 1 (1968) 209-218); f'''' is the jump of the spline's
!> third derivative at a point over the distance of the neighbouring cells' middles.
module refine
  use bspline, only: axis_type, new_axis, third_jumps
  use kinds, only: dp
  implicit none
  private
  public :: judge_cells, halve_cells

contains

  !> Raise `error` of every cell to what the spline through lines f(n, m) misses there, weighted.
  subroutine judge_cells(axis, f, of_value, of_slope, error)
    type(axis_type), intent(in) :: axis
    real(dp), intent(in) :: f(:, :)
    real(dp), intent(in) :: of_value(:, :), of_slope(:, :)   !! weights at the points, like f
    real(dp), intent(inout) :: error(:)                      !! (n - 1)
    real(dp) :: jump(size(f, 1), size(f, 2)), fourth, d
    integer :: i, j, k

    call third_jumps(axis, f, jump)
    do j = 1, size(f, 2)
      do i = 2, axis%n - 1
        if (of_value(i, j) <= 0 .and. of_slope(i, j) <= 0) cycle
        fourth = abs(jump(i, j))*2/(axis%x(i + 1) - axis%x(i - 1))
        do k = i - 1, i
          d = axis%x(k + 1) - axis%x(k)
          error(k) = max(error(k), fourth*d**3*(of_value(i, j)*d/384 + of_slope(i, j)*(sqrt(3.0_dp)/216)))
        end do
      end do
    end do
  end subroutine judge_cells

  !> Halve the cells whose error exceeds 1, the worst first, while they are longer than `least` and there are
  !> at most `most` points.  A handful of cells of many is left: kinks of the profiles have no end.
  subroutine halve_cells(axis, error, least, most, finer)
    type(axis_type), intent(inout) :: axis
    real(dp), intent(in) :: error(:)
    real(dp), intent(in) :: least
    integer, intent(in) :: most
    logical, intent(out) :: finer
    real(dp), parameter :: handful = 0.03_dp
    real(dp) :: points(2*axis%n)
    logical :: halve(axis%n - 1)
    integer :: i, n

    halve = error > 1 .and. axis%x(2:) - axis%x(:axis%n - 1) >= 2*least
    finer = count(halve) > handful*axis%n .and. axis%n < most
    if (.not. finer) return
    do while (axis%n + count(halve) > most)
      halve(minloc(error, 1, halve)) = .false.
    end do
    n = 0
    do i = 1, axis%n
      n = n + 1
      points(n) = axis%x(i)
      if (i == axis%n) exit
      if (.not. halve(i)) cycle
      n = n + 1
      points(n) = (axis%x(i) + axis%x(i + 1))/2
    end do
    axis = new_axis(points(:n))
  end subroutine halve_cells

end module refine
