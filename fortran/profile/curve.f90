!> A plane curve: cubics y(s), z(s) between knots, continued as straight lines beyond both ends.
module curve
  use kinds, only: dp
  implicit none
  private
  public :: curve_type, extend, curve_point, curve_frame, find_interval, near_interval

  !> A curve of n knots.  The intervals 0 and n are the straight lines beyond its ends.
  type :: curve_type
    integer :: n = 0                     !! knots
    real(dp), allocatable :: s(:)        !! station of each knot [m], (0:n+1); s(0) = s(1) = 0, s(n+1) is never reached
    real(dp), allocatable :: a(:, :, :)  !! cubic coefficients of y and z in (s - s_i), (2, 4, 0:n)
  contains
    procedure :: last => last_station
  end type curve_type

contains

  !> Continue a curve as straight lines beyond both ends.
  pure subroutine extend(c)
    type(curve_type), intent(inout) :: c

    c%s(:1) = 0
    c%s(c%n + 1) = huge(c%s)
    c%a(:, :, [0, c%n]) = 0
    c%a(:, :2, 0) = c%a(:, :2, 1)
    associate (last => c%a(:, :, c%n - 1), t => c%s(c%n) - c%s(c%n - 1))
      c%a(:, 1, c%n) = last(:, 1) + t*(last(:, 2) + t*(last(:, 3) + t*last(:, 4)))
      c%a(:, 2, c%n) = last(:, 2) + t*(2*last(:, 3) + t*3*last(:, 4))
    end associate
  end subroutine extend

  !> Station of the last knot [m].
  pure real(dp) function last_station(c)
    class(curve_type), intent(in) :: c
    last_station = c%s(c%n)
  end function last_station

  !> Position r [m] and its first two derivatives at station s [m].  `i` is the knot interval: any guess on entry, the
  !> right one on return.
  pure subroutine curve_point(c, s, i, r, d1, d2)
    type(curve_type), intent(in) :: c
    real(dp), intent(in) :: s
    integer, intent(inout) :: i
    real(dp), intent(out) :: r(2), d1(2), d2(2)

    i = max(0, min(i, c%n))
    call find_interval(c%s, s, i)
    associate (a => c%a(:, :, i), t => s - c%s(i))
      r = a(:, 1) + t*(a(:, 2) + t*(a(:, 3) + t*a(:, 4)))
      d1 = a(:, 2) + t*(2*a(:, 3) + t*3*a(:, 4))
      d2 = 2*a(:, 3) + 6*t*a(:, 4)
    end associate
  end subroutine curve_point

  !> The knot interval i of station x [m] on a curve with the knots s.  On entry i is a guess from 0 to n.
  pure subroutine find_interval(s, x, i)
    real(dp), intent(in) :: s(0:*), x
    integer, intent(inout) :: i

    do while (x >= s(i + 1))
      i = i + 1
    end do
    do while (x < s(i))
      if (i == 0) exit
      i = i - 1
    end do
  end subroutine find_interval

  !> A guess of the knot interval of station s [m]: the right one if the knots were equally spaced.
  pure integer function near_interval(c, s) result(i)
    type(curve_type), intent(in) :: c
    real(dp), intent(in) :: s

    i = 1 + int((c%n - 1)*s/c%last())
  end function near_interval

  !> Position [m], tangent angle to the y axis [rad] and signed curvature d(angle)/ds [1/m] at station s [m].
  pure subroutine curve_frame(c, s, r, angle, curvature)
    type(curve_type), intent(in) :: c
    real(dp), intent(in) :: s
    real(dp), intent(out) :: r(2), angle, curvature
    real(dp) :: d1(2), d2(2)
    integer :: i

    i = near_interval(c, s)
    call curve_point(c, s, i, r, d1, d2)
    angle = atan2(d1(2), d1(1))
    curvature = (d1(1)*d2(2) - d1(2)*d2(1))/(d1(1)**2 + d1(2)**2)**1.5_dp
  end subroutine curve_frame

end module curve
