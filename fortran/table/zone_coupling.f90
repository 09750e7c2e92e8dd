!> Zones of a wheel that carry together lower the surface of each other. With the influences c_ij of two zones and the energies
!> F_i of zones whose surfaces are lowered by s_i,
!>
!>     U = sum F_i(q, s_i) + 1/2 sum c_ij f_i f_j,  s_i = sum c_ij f_j,  f_i = -dF_i/ds_i.
!>
!> U is stationary in the forces f, so that f_i is its derivative with respect to the penetration of zone i, and a zone begins to
!> carry where its lowered surface touches.
module zone_coupling
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use bspline, only: axis_basis, axis_cell, axis_type, basis_type, spline_3d
  use contact_zones, only: max_zones
  use kinds, only: dp
  use zone_tables, only: gap_of_influence, gap_type, inside, line_type, missing, press_line, roll_type, to_pose, &
    touching_type, unsettled, zone_table
  implicit none
  private
  public :: pair_table, coupling_type, find_influence, press_together, add_coupling

  !> Influence c of two zones on each other: a force on one lowers the surface of the other by c times the force.
  type :: pair_table
    integer :: zone(2) = 0
    type(axis_type) :: u, roll, p       !! of the second zone
    real(dp), allocatable :: c(:, :, :), c_at(:, :, :)   !! coefficients and values over (p, roll, u) [m/N]
  end type pair_table

  !> An influence and its derivatives with respect to the pose; the zones that touch are counted.
  type :: influence_type
    integer :: first, second
    real(dp) :: gradient(3), hessian(6)
  end type influence_type

  !> Influences of the zones that touch on each other [m/N].
  type :: coupling_type
    integer :: n
    type(influence_type) :: list(max_zones*(max_zones - 1)/2)
    real(dp) :: c(max_zones, max_zones)
  end type coupling_type

contains

  !> Influences of the zones on each other [m/N], 0 on the diagonal, and their derivatives. The status is `inside` or `missing`.
  pure subroutine find_influence(tables, pairs, roll, with_hessian, n, zones, coupling, status, gap)
    type(zone_table), intent(in) :: tables(:)
    type(pair_table), intent(in) :: pairs(:)
    type(roll_type), intent(in) :: roll
    logical, intent(in) :: with_hessian
    integer, intent(in) :: n
    type(touching_type), intent(in) :: zones(:)
    type(coupling_type), intent(inout) :: coupling
    integer, intent(out) :: status
    type(gap_type), intent(inout) :: gap
    real(dp) :: v(10)
    integer :: place(max_zones), cell(3), i, j, m

    status = inside
    coupling%c(:n, :n) = 0
    place = 0
    do i = 1, n
      place(zones(i)%zone) = i
    end do
    do m = 1, size(pairs)
      associate (pair => pairs(m))
        i = place(pair%zone(1))
        j = place(pair%zone(2))
        if (i == 0 .or. j == 0) cycle
        call evaluate(pair, zones(j), roll, with_hessian, v, cell)
        if (ieee_is_nan(v(1))) then
          status = missing
          gap = gap_type(gap_of_influence, m, cell)
          return
        end if
        if (v(1) <= 0) cycle
        coupling%n = coupling%n + 1
        associate (one => coupling%list(coupling%n))
          one%first = i
          one%second = j
          one%hessian = 0
          call to_pose(tables(pair%zone(2)), zones(j)%arm, zones(j)%h, v, with_hessian, one%gradient, one%hessian)
        end associate
        coupling%c(i, j) = v(1)
        coupling%c(j, i) = v(1)
      end associate
    end do
  end subroutine find_influence

  !> Find how far the zones lower the surface of each other: shift_i = sum c_ij f_j, with the force f_j of zone j on its
  !> lowered surface, by Newton's method. The status is `inside`, `missing`, or `unsettled` if it does not converge.
  pure subroutine press_together(tables, roll, n, c, zones, status, gap)
    type(zone_table), intent(in) :: tables(:)
    type(roll_type), intent(in) :: roll
    integer, intent(in) :: n
    real(dp), intent(in) :: c(max_zones, max_zones)   !! influences, 0 on the diagonal [m/N]
    type(touching_type), intent(inout) :: zones(:)
    integer, intent(out) :: status
    type(gap_type), intent(inout) :: gap
    real(dp), parameter :: close = 1e-10_dp     ! last step [m]: Newton's method squares the error once more
    integer, parameter :: patience = 12, most = 60
    type(line_type) :: line(max_zones)
    real(dp), dimension(max_zones) :: f, k, step
    real(dp) :: a(max_zones, max_zones)
    logical :: open(max_zones), ok
    integer :: i, j, deepest, iter

    status = inside
    line%cell = 0
    f = 0
    open = .true.
    ! The deepest zone first, each after those before it have lowered its surface.
    do j = 1, n
      deepest = 0
      do i = 1, n
        if (.not. open(i)) cycle
        if (deepest == 0) deepest = i
        if (zones(i)%p > zones(deepest)%p) deepest = i
      end do
      open(deepest) = .false.
      zones(deepest)%shift = dot_product(c(:n, deepest), f(:n))
      call press_line(tables(zones(deepest)%zone), roll, zones(deepest), line(deepest), f(deepest), k(deepest), status, gap)
      if (status /= inside) return
    end do
    do iter = 1, most
      do j = 1, n
        step(j) = dot_product(c(:n, j), f(:n)) - zones(j)%shift
        a(:n, j) = c(:n, j)*k(j)
        a(j, j) = a(j, j) + 1
      end do
      call solve_small(n, a, step)
      ok = .true.
      do i = 1, n
        if (iter > patience) step(i) = step(i)/2
        zones(i)%shift = max(0.0_dp, zones(i)%shift + step(i))
        ok = ok .and. abs(step(i)) < close
      end do
      if (ok) return
      do i = 1, n
        call press_line(tables(zones(i)%zone), roll, zones(i), line(i), f(i), k(i), status, gap)
        if (status /= inside) return
      end do
    end do
    status = unsettled
  end subroutine press_together

  !> Add the energy of the coupling, and to every zone its half of the gradient; the coupling's Hessian is that of the sum.
  !>
  !> The energy is sum F_i(q, s_i) + 1/2 sum c_ij f_i f_j with f_i = -dF_i/ds_i and s = C f, its gradient
  !> sum grad F_i - 1/2 sum grad c_ij f_i f_j. The Hessian follows from (I + K C) df = (M - K V) dq and ds = C df + V dq,
  !> where K has the stiffnesses, the rows of M are the gradients of f_i, and V_i = sum f_j grad c_ij.
  pure subroutine add_coupling(n, with_hessian, coupling, zones, hessian)
    integer, intent(in) :: n
    logical, intent(in) :: with_hessian
    type(coupling_type), intent(in) :: coupling
    type(touching_type), intent(inout) :: zones(:)
    real(dp), intent(inout) :: hessian(6)
    real(dp) :: f(max_zones), v(3, max_zones), a(max_zones, max_zones), df(max_zones, 3), ds(max_zones, 3), full(3, 3)
    integer :: i, j, k, m

    do i = 1, n
      f(i) = merge(zones(i)%force, 0.0_dp, zones(i)%energy > 0)
    end do
    v(:, :n) = 0
    do m = 1, coupling%n
      associate (one => coupling%list(m))
        v(:, one%first) = v(:, one%first) + f(one%second)*one%gradient
        v(:, one%second) = v(:, one%second) + f(one%first)*one%gradient
        ! The zone that carries more has the energy of the pair. So that of a zone that begins to carry tells when it began.
        k = merge(one%first, one%second, f(one%first) > f(one%second))
        zones(k)%energy = zones(k)%energy + coupling%c(one%first, one%second)*f(one%first)*f(one%second)
        if (with_hessian) hessian = hessian - f(one%first)*f(one%second)*one%hessian
      end associate
    end do
    do i = 1, n
      if (f(i) <= 0) cycle
      zones(i)%gradient = zones(i)%gradient - f(i)/2*v(:, i)
    end do
    if (.not. with_hessian) return
    associate (c => coupling%c)
      do i = 1, n
        a(i, :n) = 0
        df(i, :) = 0
        a(i, i) = 1
        if (f(i) <= 0) cycle
        do j = 1, n
          a(i, j) = a(i, j) + zones(i)%stiffness*c(i, j)
        end do
        df(i, :) = zones(i)%of_force - zones(i)%stiffness*v(:, i)
      end do
      do j = 1, 3
        call solve_small(n, a, df(:, j))
        do i = 1, n
          ds(i, j) = dot_product(c(:n, i), df(:n, j)) + v(j, i)
        end do
      end do
    end associate
    full = 0
    do i = 1, n
      if (f(i) <= 0) cycle
      do j = 1, 3
        full(:, j) = full(:, j) - zones(i)%of_force*ds(i, j) - v(:, i)*df(i, j)
      end do
    end do
    hessian = hessian + [full(1, 1), (full(1, 2) + full(2, 1))/2, (full(1, 3) + full(3, 1))/2, full(2, 2), &
      (full(2, 3) + full(3, 2))/2, full(3, 3)]
  end subroutine add_coupling

  !> Value and derivatives of the influence of a pair, whose second zone is z (see `spline_3d`), and the cell that they are in.
  pure subroutine evaluate(pair, z, roll, with_hessian, v, cell)
    type(pair_table), intent(in) :: pair
    type(touching_type), intent(in) :: z
    type(roll_type), intent(in) :: roll
    logical, intent(in) :: with_hessian
    real(dp), intent(out) :: v(10)
    integer, intent(out) :: cell(3)
    type(basis_type) :: bp, br, bu

    cell = [axis_cell(pair%p, z%p), axis_cell(pair%roll, roll%angle), axis_cell(pair%u, z%u)]
    call axis_basis(pair%p, cell(1), z%p, bp, with_hessian)
    call axis_basis(pair%roll, cell(2), roll%angle, br, with_hessian)
    call axis_basis(pair%u, cell(3), z%u, bu, with_hessian)
    call spline_3d(pair%c, bp, br, bu, with_hessian, v)
  end subroutine evaluate

  !> Solve a x = b, with b on entry and x on return in `x`; the diagonal of a is larger than the rest.
  pure subroutine solve_small(n, a, x)
    integer, intent(in) :: n
    real(dp), intent(in) :: a(max_zones, max_zones)
    real(dp), intent(inout) :: x(max_zones)
    real(dp) :: b(max_zones, max_zones)
    integer :: i, j

    b(:n, :n) = a(:n, :n)
    do i = 1, n
      do j = i + 1, n
        x(j) = x(j) - b(j, i)/b(i, i)*x(i)
        b(j, i + 1:n) = b(j, i + 1:n) - b(j, i)/b(i, i)*b(i, i + 1:n)
      end do
    end do
    do i = n, 1, -1
      x(i) = (x(i) - dot_product(b(i, i + 1:n), x(i + 1:n)))/b(i, i)
    end do
  end subroutine solve_small

end module zone_coupling
