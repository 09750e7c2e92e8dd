!> Forces, impulses and moves that keep the gaps of rigid contacts closed.
!>
!> J holds the gradients of the closed gaps in rows and M is the diagonal mass matrix of q = (y, z, roll).  At most three
!> contacts can be closed, as many as q has components.
module constraint_forces
  use linear_solver, only: solve_linear
  use contact_zones, only: side_type
  use gap_functions, only: find_gap, gap_type
  use kinds, only: dp
  use motion_state, only: contact_state, total
  implicit none
  private
  public :: couplings, convective_acceleration, closing_forces, close_gaps, stop_gaps, set_state, solve_independent, &
    tangent, most_closed

  integer, parameter :: most_closed = 3   !! contacts that three degrees of freedom can keep closed

contains

  !> The part v.H v of a gap's acceleration that comes from the velocity v alone [m/s^2].
  pure real(dp) function convective_acceleration(c, v)
    type(gap_type), intent(in) :: c
    real(dp), intent(in) :: v(3)

    convective_acceleration = dot_product(v, matmul(c%hessian, v))
  end function convective_acceleration

  !> The matrix J M^-1 J': accelerations of the gaps (rows) under unit forces at the contacts (columns).
  pure function couplings(inertia, c) result(g)
    real(dp), intent(in) :: inertia(3)     !! diagonal of M
    type(gap_type), intent(in) :: c(:)
    real(dp) :: g(size(c), size(c))
    integer :: i, j

    do j = 1, size(c)
      do i = 1, size(c)
        g(i, j) = sum(c(i)%gradient*c(j)%gradient/inertia)
      end do
    end do
  end function couplings

  !> Normal forces [N] that keep the gaps of contacts closed, whatever their sign:
  !> d2g/dt2 = J M^-1 (f + J' force) + v.H v = 0.
  pure subroutine closing_forces(inertia, f, v, c, force)
    real(dp), intent(in) :: inertia(3)     !! diagonal of M
    real(dp), intent(in) :: f(3), v(3)     !! external force and velocity
    type(gap_type), intent(in) :: c(:)     !! closed contacts, at most three
    real(dp), intent(out) :: force(size(c))
    integer :: i

    do i = 1, size(c)
      force(i) = -sum(c(i)%gradient*f/inertia) - convective_acceleration(c(i), v)
    end do
    call solve_independent(couplings(inertia, c), force)
  end subroutine closing_forces

  !> Replace x by the solution of g y = x. Where the rows of g depend on each other the last contacts carry nothing.
  pure recursive subroutine solve_independent(g, x)
    real(dp), intent(in) :: g(:, :)
    real(dp), intent(inout) :: x(:)
    real(dp) :: a(size(x), size(x)), y(size(x))
    integer :: n
    logical :: ok

    a = g
    y = x
    call solve_linear(a, y, ok)
    if (ok) then
      x = y
      return
    end if
    n = size(x) - 1
    x(n + 1) = 0
    call solve_independent(g(:n, :n), x(:n))
  end subroutine solve_independent

  !> Change the velocity v by impulses at the contacts so that their gaps are at rest: J v = 0.
  pure subroutine stop_gaps(inertia, c, v)
    real(dp), intent(in) :: inertia(3)     !! diagonal of M
    type(gap_type), intent(in) :: c(:)     !! closed contacts, at most three
    real(dp), intent(inout) :: v(3)
    real(dp) :: x(size(c))
    integer :: i

    do i = 1, size(c)
      x(i) = -dot_product(c(i)%gradient, v)
    end do
    call solve_independent(couplings(inertia, c), x)
    do i = 1, size(c)
      v = v + x(i)*c(i)%gradient/inertia
    end do
  end subroutine stop_gaps

  !> Direction of the motion that keeps two contacts closed, on the side of `ahead`, of unit length in the kinetic metric.
  pure function tangent(inertia, c, ahead) result(t)
    real(dp), intent(in) :: inertia(3)     !! diagonal of M
    type(gap_type), intent(in) :: c(2)
    real(dp), intent(in) :: ahead(3)
    real(dp) :: t(3)

    associate (a => c(1)%gradient, b => c(2)%gradient)
      t = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
    end associate
    t = t/sqrt(sum(inertia*t**2))
    if (sum(inertia*t*ahead) < 0) t = -t
  end function tangent

  !> Move the pose q by the shortest way in the kinetic metric to where the contacts are closed, and find their points
  !> there.  `ok` is false if there is no such pose nearby.
  pure subroutine close_gaps(side, inertia, c, q, ok)
    type(side_type), intent(in) :: side(:) !! left, right
    real(dp), intent(in) :: inertia(3)     !! diagonal of M
    type(gap_type), intent(inout) :: c(:)  !! at most three
    real(dp), intent(inout) :: q(3)        !! y, z [m], roll [rad]
    logical, intent(out) :: ok
    real(dp) :: g(size(c), size(c)), x(size(c)), move(3)
    integer :: iter, i

    do iter = 1, 30
      do i = 1, size(c)
        call find_gap(side, q, c(i))
      end do
      g = couplings(inertia, c)
      x = -c%gap
      call solve_linear(g, x, ok)
      if (.not. ok) return
      move = 0
      do i = 1, size(c)
        move = move + x(i)*c(i)%gradient/inertia
      end do
      if (maxval(abs(c%gap)) < 1e-16_dp) exit
      q = q + move
      ok = all(abs(c%gap) < 1e-13_dp)
      if (ok .and. maxval(abs(move)) < 1e-13_dp) exit
    end do
  end subroutine close_gaps

  !> Describe closed contacts and their normal forces [N] as the columns and events need them.
  pure subroutine set_state(c, force, state)
    type(gap_type), intent(in) :: c(:)
    real(dp), intent(in) :: force(:)       !! at each contact [N]
    type(contact_state), intent(out) :: state
    integer :: i, k

    do i = 1, size(c)
      k = c(i)%contact
      state%rigid(k) = .true.
      state%slope(:, k) = state%slope(:, k) - force(i)*c(i)%gradient
      state%pulls(k) = dot_product(state%slope(:, k), c(i)%gradient) > 0
    end do
    state%gradient = total(state%slope)
  end subroutine set_state

end module constraint_forces
