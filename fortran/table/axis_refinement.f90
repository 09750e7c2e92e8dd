!> Axes that are halved where the spline on them errs.
!>
!> A cubic spline through values of f misses f by at most d^4 f''''/384 in a cell of
!> length d and its slope by d^3 f'''' sqrt(3)/216 (those of Hermite's interpolation;
!> C. A. Hall, J. Approx. Theory 1 (1968) 209-218); f'''' is the jump of the spline's
!> third derivative at a point over the distance of the neighbouring cells' middles.
module axis_refinement
  use bspline, only: axis_type, new_axis, third_jumps
  use kinds, only: dp
  implicit none
  private
  public :: fine_flange, fine_tread, fine_roll, grading, least_u, least_roll, least_q
  public :: cell_errors, halve_cells, united, spread_u, spread_roll

  ! Extent of the finely spaced part of the first axes; on the throat a shift of 1 mm
  ! moves the patch by 10 mm, on the tread by about 1 mm.
  real(dp), parameter :: fine_flange = 3e-3_dp, fine_tread = 10e-3_dp   ! [m]
  real(dp), parameter :: fine_roll = 0.02_dp                            ! [rad]
  real(dp), parameter :: grading = 1.25_dp                              ! of q towards 0
  ! Cells that are not halved any more: patches are larger.
  real(dp), parameter :: least_u = 0.02e-3_dp, least_roll = 0.5e-3_dp, least_q = 0.5e-3_dp   ! [m, rad, sqrt(m)]

contains

  !> What the spline through lines f(n, m) misses in every cell of each, weighted.
  function cell_errors(axis, f, of_value, of_slope) result(error)
    type(axis_type), intent(in) :: axis
    real(dp), intent(in) :: f(:, :)
    real(dp), intent(in) :: of_value(:, :), of_slope(:, :)   !! weights at the points, like f
    real(dp) :: error(size(f, 1) - 1, size(f, 2))
    real(dp) :: jump(size(f, 1), size(f, 2)), fourth, d
    integer :: i, j, k

    error = 0
    call third_jumps(axis, f, jump)
    do j = 1, size(f, 2)
      do i = 2, axis%n - 1
        if (of_value(i, j) <= 0 .and. of_slope(i, j) <= 0) cycle
        ! "Not a knot": no jump at the outermost interior points.
        k = min(max(i, 3), axis%n - 2)
        fourth = abs(jump(k, j))*2/(axis%x(k + 1) - axis%x(k - 1))
        do k = i - 1, i
          d = axis%x(k + 1) - axis%x(k)
          error(k, j) = max(error(k, j), fourth*d**3*(of_value(i, j)*d/384 + of_slope(i, j)*(sqrt(3.0_dp)/216)))
        end do
      end do
    end do
  end function cell_errors

  !> Halve the cells whose error exceeds 1, the worst first, while they are longer than `least` and there are
  !> at most `most` points.  A handful of cells of many is left unless one errs grossly: kinks of the
  !> profiles have no end.
  subroutine halve_cells(axis, error, least, most, finer)
    type(axis_type), intent(inout) :: axis
    real(dp), intent(in) :: error(:)
    real(dp), intent(in) :: least
    integer, intent(in) :: most
    logical, intent(out) :: finer
    real(dp), parameter :: handful = 0.03_dp, gross = 10
    real(dp) :: points(2*axis%n)
    logical :: halve(axis%n - 1)
    integer :: i, n

    halve = error > 1 .and. axis%x(2:) - axis%x(:axis%n - 1) >= 2*least
    finer = (count(halve) > handful*axis%n .or. any(halve .and. error > gross)) .and. axis%n < most
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

  !> An axis with the points of two, where they are not nearer than `least`/2, at most `most`.
  pure function united(a, b, least, most) result(axis)
    type(axis_type), intent(in) :: a, b
    real(dp), intent(in) :: least
    integer, intent(in) :: most
    type(axis_type) :: axis
    real(dp) :: x(a%n + b%n)
    integer :: i, j, n

    n = 0
    j = 1
    do i = 1, a%n
      do while (j <= b%n)
        if (b%x(j) >= a%x(i)) exit
        if (b%x(j) > a%x(max(i - 1, 1)) + least/2 .and. b%x(j) < a%x(i) - least/2 .and. n + a%n - i + 1 < most) then
          n = n + 1
          x(n) = b%x(j)
        end if
        j = j + 1
      end do
      n = n + 1
      x(n) = a%x(i)
    end do
    axis = new_axis(x(:n))
  end function united

  !> (q, u, roll) as lines along u.
  pure function spread_u(f) result(lines)
    real(dp), intent(in) :: f(:, :, :)
    real(dp) :: lines(size(f, 2), size(f, 1)*size(f, 3))

    lines = reshape(reshape(f, [size(f, 2), size(f, 1), size(f, 3)], order=[2, 1, 3]), shape(lines))
  end function spread_u

  !> (q, u, roll) as lines along roll.
  pure function spread_roll(f) result(lines)
    real(dp), intent(in) :: f(:, :, :)
    real(dp) :: lines(size(f, 3), size(f, 1)*size(f, 2))

    lines = transpose(reshape(f, [size(f, 1)*size(f, 2), size(f, 3)]))
  end function spread_roll

end module axis_refinement