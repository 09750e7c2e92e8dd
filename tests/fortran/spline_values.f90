!> The tensor-product spline of given values.
!>
!> usage: spline_values < input
!> Reads three axes, one per line, as `n` and n points, the n1*n2*n3 values (first index fastest),
!> then points `x y z`.  Writes for each point
!> f fx fy fz fxx fxy fxz fyy fyz fzz of the spline in space, f fx fy fxx fxy fyy of the
!> spline through the plane of the first z, that plane's value alone, and f fx fy fz and f fx fy again as
!> they come without second derivatives.
program spline_values
  use bspline, only: axis_basis, axis_cell, axis_type, basis_type, new_axis, spline_2d, spline_2d_value, spline_3d
  use kinds, only: dp
  implicit none
  save
  type(axis_type) :: axis(3)
  type(basis_type) :: b(3), b1(3)
  real(dp), allocatable :: f(:, :, :), space(:, :, :), plane(:, :, :)
  real(dp), allocatable :: points(:)
  real(dp) :: x(3), v(10), w(6), v1(10), w1(6)
  integer :: i, n, stat

  do i = 1, 3
    read (*, *) n
    allocate (points(n))
    read (*, *) points
    axis(i) = new_axis(points)
    deallocate (points)
  end do
  allocate (f(axis(1)%n, axis(2)%n, axis(3)%n))
  read (*, *) f
  ! Every sum turns the axes; after two the plane is one turn short of where it began.
  space = turned_sums(axis(3), turned_sums(axis(2), turned_sums(axis(1), f)))
  plane = turned_sums(axis(2), turned_sums(axis(1), f(:, :, :1)))
  plane = reshape(plane, [size(plane, 2), size(plane, 3), 1])
  do
    read (*, *, iostat=stat) x
    if (stat /= 0) exit
    do i = 1, 3
      call axis_basis(axis(i), axis_cell(axis(i), x(i)), x(i), b(i), .true.)
      call axis_basis(axis(i), axis_cell(axis(i), x(i)), x(i), b1(i), .false.)
    end do
    call spline_3d(space, b(1), b(2), b(3), .true., v)
    call spline_2d(plane(:, :, 1), b(1), b(2), .true., w)
    call spline_3d(space, b1(1), b1(2), b1(3), .false., v1)
    call spline_2d(plane(:, :, 1), b1(1), b1(2), .false., w1)
    write (*, '(24es24.16)') v, w, spline_2d_value(plane(:, :, 1), b(1), b(2)), v1(:4), w1(:3)
  end do

contains

  !> Coefficients along the first index, which then becomes the last one.
  function turned_sums(axis, f) result(c)
    type(axis_type), intent(in) :: axis
    real(dp), intent(in) :: f(:, :, :)
    real(dp), allocatable :: c(:, :, :)
    real(dp) :: flat(size(f, 1), size(f, 2)*size(f, 3)), sums(size(f, 1) + 2, size(f, 2)*size(f, 3))
    integer :: k

    flat = reshape(f, shape(flat))
    do k = 1, size(sums, 1)
      sums(k, :) = matmul(axis%weight(:, k), flat(axis%first(k):axis%first(k) + 2, :))
    end do
    c = reshape(transpose(sums), [size(f, 2), size(f, 3), size(f, 1) + 2])
  end function turned_sums

end program spline_values
