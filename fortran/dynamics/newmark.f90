!> Time integration of M q'' = f(t) - dU/dq.
!>
!> Two one-step schemes are available.  Both are of second order, symmetric and without numerical
!> damping at their defaults.
!>
!> 'newmark'  N. M. Newmark, J. Eng. Mech. Div. ASCE 85 (1959) 67-94, with beta and gamma;
!>            beta = 0 is explicit.
!> 'energy'   the average-acceleration rule (beta = 1/4, gamma = 1/2) with the force
!>            replaced by the discrete gradient of U: O. Gonzalez, J. Nonlinear Sci. 6
!>            (1996) 449-467.  Total energy is then kept exactly, at any step.
!>
!> Symmetric composition raises the order and conserves what the second-order step conserves.  Five
!> steps make one of fourth order (M. Suzuki, Phys. Lett. A 146 (1990) 319-323).  The explicit scheme
!> consists of kicks (force) and drifts (motion).  The coefficients of S. Blanes and P. C. Moan,
!> J. Comput. Appl. Math. 142 (2002) 313-330, for second-order equations raise its order to four and
!> six, with six and eleven forces per step.
!>
!> The implicit equations are solved by Newton's method on the exact tangent.
module newmark
  use kinds, only: dp
  use motion_state, only: motion_type
  use zone_tables, only: inside
  use wheelset, only: contact_state, contacts, external_force, symmetric, total, wheelset_type
  implicit none
  private
  public :: scheme_type, stability_limit, evaluate_contacts, advance, energy_change, energy_rounding, step_ok, step_diverged, &
    kick_4, drift_4

  type :: scheme_type
    character(16) :: name = 'newmark'  !! or 'energy'
    integer :: order = 2               !! or 4, or 6 if explicit
    real(dp) :: beta = 0.25_dp, gamma = 0.5_dp
    real(dp) :: tolerance = 1e-10_dp   !! largest Newton correction at convergence [m, rad]: Newton's
                                       !! method squares it, so that the next one would be tolerance^2/(1 m)
    integer :: max_iterations = 12
  end type scheme_type

  ! In steps below about 3e-8 m the change of U is mostly rounding (1e-11 J), and divided by
  ! the step it would act as a force; there the midpoint's gradient is used alone.
  real(dp), parameter :: least_square = 1e-12_dp   ! d.M d [kg m2]

  ! The schemes SRKN 6b (fourth order) and 11b (sixth) of Blanes and Moan: shares of a step.
  real(dp), parameter :: b4(3) = [0.0829844064174052_dp, 0.396309801498368_dp, -0.0390563049223486_dp]
  real(dp), parameter :: a4(2) = [0.245298957184271_dp, 0.604872665711080_dp]
  real(dp), parameter :: kick_4(7) = [b4, 1 - 2*sum(b4), b4(3:1:-1)]
  real(dp), parameter :: drift_4(6) = [a4, 0.5_dp - sum(a4), 0.5_dp - sum(a4), a4(2:1:-1)]
  real(dp), parameter :: b6(5) = [0.0414649985182624_dp, 0.198128671918067_dp, -0.0400061921041533_dp, &
    0.0752539843015807_dp, -0.0115113874206879_dp]
  real(dp), parameter :: a6(5) = [0.123229775946271_dp, 0.290553797799558_dp, -0.127049212625417_dp, &
    -0.246331761062075_dp, 0.357208872795928_dp]
  real(dp), parameter :: kick_6(12) = [b6, 0.5_dp - sum(b6), 0.5_dp - sum(b6), b6(5:1:-1)]
  real(dp), parameter :: drift_6(11) = [a6, 1 - 2*sum(a6), a6(5:1:-1)]

  real(dp), parameter :: p = 1/(4 - 4**(1/3.0_dp))
  real(dp), parameter :: suzuki(5) = [p, p, 1 - 4*p, p, p]

  integer, parameter :: step_ok = 0, step_diverged = -1   ! otherwise a status of `zone_tables`

contains

  !> Contacts and accelerations of a motion.
  pure subroutine evaluate_contacts(w, motion, status)
    type(wheelset_type), intent(in) :: w
    type(motion_type), intent(inout) :: motion
    integer, intent(out) :: status

    call contacts(w, motion%q, motion%contact, with_hessian=.false.)
    status = motion%contact%status
    motion%a = (external_force(w, motion%t) - motion%contact%gradient)/w%inertia()
  end subroutine evaluate_contacts

  !> Largest stable omega*dt of a linear oscillation with the angular frequency omega. Beyond it the trace of the step's matrix is
  !> beyond +-2. Compositions have narrow unstable bands between 3.14 and this limit, too: there the amplitude grows by at most
  !> 0.2 % a step.
  elemental real(dp) function stability_limit(scheme) result(limit)
    type(scheme_type), intent(in) :: scheme

    limit = huge(limit)
    if (scheme%name == 'energy' .or. 2*scheme%beta >= scheme%gamma) return
    limit = 1/sqrt(scheme%gamma/2 - scheme%beta)
    if (scheme%order == 2) return
    limit = limit/maxval(abs(suzuki))
    if (scheme%beta <= 0) limit = merge(5.027_dp, 9.074_dp, scheme%order == 4)
  end function stability_limit

  !> One step dt from `old` to `new`.  `status`: step_ok, step_diverged, or why
  !> the pose left the table.
  pure subroutine advance(w, scheme, old, dt, new, evaluations, status)
    type(wheelset_type), intent(in) :: w
    type(scheme_type), intent(in) :: scheme
    type(motion_type), intent(in) :: old
    real(dp), intent(in) :: dt
    type(motion_type), intent(out) :: new
    integer, intent(out) :: evaluations    !! number of evaluations of the contacts
    integer, intent(out) :: status
    type(motion_type) :: from
    integer :: i, n

    if (scheme%order == 2) then
      call second_order_step(w, scheme, old, dt, new, evaluations, status)
    else if (scheme%order == 6) then
      call kick_and_drift(w, kick_6, drift_6, old, dt, new, evaluations, status)
    else if (scheme%name == 'newmark' .and. scheme%beta <= 0) then
      call kick_and_drift(w, kick_4, drift_4, old, dt, new, evaluations, status)
    else
      evaluations = 0
      new = old
      do i = 1, size(suzuki)
        from = new
        call second_order_step(w, scheme, from, suzuki(i)*dt, new, n, status)
        evaluations = evaluations + n
        if (status /= step_ok) return
      end do
      new%t = old%t + dt
    end if
  end subroutine advance

  !> Change of the total energy in a step, less the work of the lateral force [J].
  !> The exact motion has zero.  Left and right are summed separately, so that the mirrored run
  !> rounds in the same way.
  pure real(dp) function energy_change(w, old, new) result(change)
    type(wheelset_type), intent(in) :: w
    type(motion_type), intent(in) :: old, new

    change = 0.5_dp*sum(w%inertia()*(new%v - old%v)*(new%v + old%v)) + w%weight()*(new%q(2) - old%q(2)) &
      + elastic_change(old%contact, new%contact) - (new%work - old%work)
  end function energy_change

  !> Change of the contacts' elastic energy [J].
  pure real(dp) function elastic_change(old, new) result(change)
    type(contact_state), intent(in) :: old, new

    change = sum(new%energy(:2) - old%energy(:2)) + sum(new%energy(3:) - old%energy(3:))
  end function elastic_change

  !> Change of the total energy that rounding of the pose can cause [J].
  pure real(dp) function energy_rounding(w, motion)
    type(wheelset_type), intent(in) :: w
    type(motion_type), intent(in) :: motion
    real(dp) :: forces(3)

    forces = total(abs(motion%contact%slope)) + abs(external_force(w, motion%t))
    energy_rounding = 4*epsilon(1.0_dp)*dot_product(forces, abs(motion%q))
  end function energy_rounding

  !> The explicit step of a higher order.
  pure subroutine kick_and_drift(w, kick, drift, old, dt, new, evaluations, status)
    type(wheelset_type), intent(in) :: w
    real(dp), intent(in) :: kick(:), drift(:)      !! shares of the step; one kick more than drifts
    type(motion_type), intent(in) :: old
    real(dp), intent(in) :: dt
    type(motion_type), intent(inout) :: new
    integer, intent(out) :: evaluations, status
    real(dp) :: move(3), force(3)
    integer :: i

    new = old
    evaluations = 0
    do i = 1, size(drift)
      new%v = new%v + kick(i)*dt*new%a
      new%push = new%push + kick(i)*dt*push_of(new)
      move = drift(i)*dt*new%v
      force = external_force(w, new%t + 0.5_dp*drift(i)*dt)
      new%work = new%work + force(1)*move(1)
      new%q = new%q + move
      new%t = new%t + drift(i)*dt
      call evaluate_contacts(w, new, status)
      evaluations = evaluations + 1
      if (status /= inside) return
    end do
    new%v = new%v + kick(size(kick))*dt*new%a
    new%push = new%push + kick(size(kick))*dt*push_of(new)
    new%t = old%t + dt
  end subroutine kick_and_drift

  pure subroutine second_order_step(w, scheme, old, dt, new, evaluations, status)
    type(wheelset_type), intent(in) :: w
    type(scheme_type), intent(in) :: scheme
    type(motion_type), intent(in) :: old
    real(dp), intent(in) :: dt
    type(motion_type), intent(inout) :: new
    integer, intent(out) :: evaluations, status
    real(dp) :: force(3)

    new%t = old%t + dt
    if (scheme%name == 'energy') then
      call advance_energy(w, scheme, old, dt, new, evaluations, status)
    else if (scheme%beta > 0) then
      call advance_newmark(w, scheme, old, dt, new, evaluations, status)
    else
      new%q = old%q + dt*old%v + 0.5_dp*dt**2*old%a
      call evaluate_contacts(w, new, status)
      new%v = old%v + dt*((1 - scheme%gamma)*old%a + scheme%gamma*new%a)
      evaluations = 1
    end if
    new%dt = dt
    force = external_force(w, old%t + dt/2)
    new%work = old%work + force(1)*(new%q(1) - old%q(1))
    new%push = old%push + dt*((1 - scheme%gamma)*push_of(old) + scheme%gamma*push_of(new))
  end subroutine second_order_step

  !> Normal forces of the contacts [N].
  pure function push_of(motion) result(force)
    type(motion_type), intent(in) :: motion
    real(dp) :: force(4)

    force = sqrt(motion%contact%slope(1, :)**2 + motion%contact%slope(2, :)**2)
  end function push_of

  pure subroutine advance_newmark(w, scheme, old, dt, new, evaluations, status)
    type(wheelset_type), intent(in) :: w
    type(scheme_type), intent(in) :: scheme
    type(motion_type), intent(in) :: old
    real(dp), intent(in) :: dt
    type(motion_type), intent(inout) :: new
    integer, intent(out) :: evaluations, status
    real(dp) :: m(3), f(3), predicted(3), residual(3), tangent(3, 3), move(3)

    m = w%inertia()
    f = external_force(w, new%t)
    predicted = old%q + dt*old%v + dt**2*(0.5_dp - scheme%beta)*old%a
    new%q = predicted + dt**2*scheme%beta*(old%a + dt*old%jerk)
    status = step_diverged
    do evaluations = 1, scheme%max_iterations
      call contacts(w, new%q, new%contact)
      if (new%contact%status /= inside) exit
      residual = m*(new%q - predicted)/(scheme%beta*dt**2) + new%contact%gradient - f
      tangent = symmetric(new%contact%hessian) + diagonal(m/(scheme%beta*dt**2))
      move = solve(tangent, residual)
      new%q = new%q - move
      if (maxval(abs(move)) <= scheme%tolerance) status = step_ok
      if (status == step_ok) exit
    end do
    evaluations = min(evaluations, scheme%max_iterations)
    if (status == step_ok) call extrapolate(new%contact, -move)
    ! The acceleration follows from the balance of forces, because (q - predicted)/(beta dt^2) would magnify round-off.
    new%a = (f - new%contact%gradient)/m
    new%v = old%v + dt*((1 - scheme%gamma)*old%a + scheme%gamma*new%a)
    new%jerk = (new%a - old%a)/dt
    if (new%contact%status /= inside) status = new%contact%status
  end subroutine advance_newmark

  pure subroutine advance_energy(w, scheme, old, dt, new, evaluations, status)
    type(wheelset_type), intent(in) :: w
    type(scheme_type), intent(in) :: scheme
    type(motion_type), intent(in) :: old
    real(dp), intent(in) :: dt
    type(motion_type), intent(inout) :: new
    integer, intent(out) :: evaluations, status
    type(contact_state) :: middle
    real(dp) :: m(3), f(3), d(3), md(3), square, excess, residual(3), tangent(3, 3), move(3), excess_slope(3), h(3, 3)

    m = w%inertia()
    f = external_force(w, old%t + dt/2)
    d = dt*old%v + 0.5_dp*dt**2*(old%a + 0.5_dp*(old%dt + dt)*old%jerk)
    status = step_diverged
    do evaluations = 2, 2*scheme%max_iterations, 2
      new%q = old%q + d
      call contacts(w, old%q + 0.5_dp*d, middle)
      call contacts(w, new%q, new%contact)
      if (middle%status /= inside .or. new%contact%status /= inside) exit
      h = symmetric(middle%hessian)
      ! The discrete gradient is dU/dq at the middle, with a correction along M d that makes
      ! d.gradient equal to the change of U.
      md = m*d
      square = dot_product(d, md)
      excess = 0
      excess_slope = 0
      if (square > least_square) then
        excess = (elastic_change(old%contact, new%contact) - dot_product(middle%gradient, d))/square
        excess_slope = (new%contact%gradient - middle%gradient - 0.5_dp*matmul(h, d) - 2*excess*md)/square
      end if
      residual = 2*m*(d - dt*old%v)/dt**2 + middle%gradient + excess*md - f
      tangent = diagonal((2/dt**2 + excess)*m) + 0.5_dp*h + spread(md, 2, 3)*spread(excess_slope, 1, 3)
      move = solve(tangent, residual)
      d = d - move
      if (maxval(abs(move)) <= scheme%tolerance) status = step_ok
      if (status == step_ok) exit
    end do
    evaluations = min(evaluations, 2*scheme%max_iterations)
    if (status == step_ok) then
      new%q = old%q + d
      new%v = 2*d/dt - old%v
      new%a = (new%v - old%v)/dt
      new%jerk = 2*(new%a - old%a)/(old%dt + dt)
      call extrapolate(new%contact, -move)
    end if
    if (middle%status /= inside) status = middle%status
    if (new%contact%status /= inside) status = new%contact%status
  end subroutine advance_energy

  !> Update a contact state to first order by the last Newton correction, which is smaller than the
  !> tolerance.
  pure subroutine extrapolate(contact, move)
    type(contact_state), intent(inout) :: contact
    real(dp), intent(in) :: move(3)
    real(dp) :: h(3, 3)

    h = symmetric(contact%hessian)
    contact%energy = contact%energy + matmul(move, contact%slope)
    contact%gradient = contact%gradient + matmul(h, move)
  end subroutine extrapolate

  pure function diagonal(d) result(a)
    real(dp), intent(in) :: d(3)
    real(dp) :: a(3, 3)

    a = 0
    a(1, 1) = d(1)
    a(2, 2) = d(2)
    a(3, 3) = d(3)
  end function diagonal

  !> x = A^-1 b by cofactors.
  pure function solve(a, b) result(x)
    real(dp), intent(in) :: a(3, 3), b(3)
    real(dp) :: x(3), c(3, 3)
    integer :: i, j, k

    do i = 1, 3
      j = mod(i, 3) + 1
      k = mod(j, 3) + 1
      c(1, i) = a(j, 2)*a(k, 3) - a(j, 3)*a(k, 2)
      c(2, i) = a(j, 3)*a(k, 1) - a(j, 1)*a(k, 3)
      c(3, i) = a(j, 1)*a(k, 2) - a(j, 2)*a(k, 1)
    end do
    x = (c(:, 1)*b(1) + c(:, 2)*b(2) + c(:, 3)*b(3))/(a(1, 1)*c(1, 1) + a(1, 2)*c(2, 1) + a(1, 3)*c(3, 1))
  end function solve

end module newmark