!> Steps of M q'' = f(t) - dU/dq in time, of two orders. Both are symmetric and have no numerical damping at their defaults.
!>
!> Order 2  N. M. Newmark, J. Eng. Mech. Div. ASCE 85 (1959) 67-94, with beta and gamma; beta = 0 is explicit. The implicit
!>          equations are solved by Newton's method on the exact tangent.
!> Order 4  explicit: kicks (force) and drifts (motion) in turn, with six forces per step, S. Blanes, P. C. Moan, J. Comput. Appl.
!>          Math. 142 (2002) 313-330, SRKN 6b for second-order equations.
!>
!> Each step estimates its error of the position from its accelerations. The reversed step has the same estimate, so that runs
!> which cut steps by it can be reversed. Lengths are those of the kinetic metric: roll counts with the radius of gyration.
module integrators
  use kinds, only: dp
  use linear_solver, only: solve_linear
  use motion_state, only: contact_state, motion_type
  use zone_tables, only: inside
  use elastic_contacts, only: contacts, elastic_wheelset, symmetric
  use wheelset, only: external_force
  implicit none
  private
  public :: integrator_type, stability_limit, evaluate_contacts, advance, step_ok, step_diverged

  type :: integrator_type
    integer :: order = 4               !! or 2
    real(dp) :: beta = 0, gamma = 0.5_dp   !! of order 2
    real(dp) :: tolerance = 1e-10_dp   !! largest Newton correction at convergence [m, rad]: Newton's
                                       !! method squares it, so that the next one would be tolerance^2/(1 m)
    integer :: max_iterations = 12
  end type integrator_type

  ! Shares of a step of order 4.
  real(dp), parameter :: b(3) = [0.0829844064174052_dp, 0.396309801498368_dp, -0.0390563049223486_dp]
  real(dp), parameter :: a(2) = [0.245298957184271_dp, 0.604872665711080_dp]
  real(dp), parameter :: kick(7) = [b, 1 - 2*sum(b), b(3:1:-1)]
  real(dp), parameter :: drift(6) = [a, 0.5_dp - sum(a), 0.5_dp - sum(a), a(2:1:-1)]
  ! Sums of the seven accelerations of a step with these weights vanish for accelerations that are linear in time, though the step
  ! evaluates them aside from the motion, the even one also for quadratic ones. So they grow with dt^4 and dt^3.
  real(dp), parameter :: e(4) = [-0.010530208702421_dp, 0.538794856070439_dp, -0.263582113970305_dp, -0.529365066795426_dp]
  real(dp), parameter :: o(3) = [-0.269611711219005_dp, 0.647963191074604_dp, 0.086332080862079_dp]
  real(dp), parameter :: even(7) = [e, e(3:1:-1)], odd(7) = [o, 0.0_dp, -o(3:1:-1)]

  integer, parameter :: step_ok = 0, step_diverged = -1   ! otherwise a status of `zone_tables`

contains

  !> Contacts and accelerations of a motion.
  subroutine evaluate_contacts(w, motion, status)
    type(elastic_wheelset), intent(in) :: w
    type(motion_type), intent(inout) :: motion
    integer, intent(out) :: status

    call contacts(w, motion%q, motion%contact, with_hessian=.false.)
    status = motion%contact%status
    motion%a = (external_force(w, motion%t) - motion%contact%gradient)/w%inertia()
  end subroutine evaluate_contacts

  !> Largest stable omega*dt of a linear oscillation with the angular frequency omega. Beyond it the trace of the step's matrix is
  !> beyond +-2. Order 4 has narrow unstable bands between 3.14 and this limit, too: there the amplitude grows by at most 0.2 % a
  !> step.
  elemental real(dp) function stability_limit(integrator) result(limit)
    type(integrator_type), intent(in) :: integrator

    limit = huge(limit)
    if (integrator%order == 4) then
      limit = 5.027_dp
    else if (2*integrator%beta < integrator%gamma) then
      limit = 1/sqrt(integrator%gamma/2 - integrator%beta)
    end if
  end function stability_limit

  !> One step dt from `old` to `new`. `status`: step_ok, step_diverged, or why the pose left the table.
  subroutine advance(w, integrator, old, dt, new, evaluations, status)
    type(elastic_wheelset), intent(in) :: w
    type(integrator_type), intent(in) :: integrator
    type(motion_type), intent(in) :: old
    real(dp), intent(in) :: dt
    type(motion_type), intent(out) :: new
    integer, intent(out) :: evaluations    !! number of evaluations of the contacts
    integer, intent(out) :: status

    if (integrator%order == 4) then
      call kick_and_drift(w, old, dt, new, evaluations, status)
    else
      call advance_newmark(w, integrator, old, dt, new, evaluations, status)
    end if
  end subroutine advance

  !> The explicit step of order 4.
  subroutine kick_and_drift(w, old, dt, new, evaluations, status)
    type(elastic_wheelset), intent(in) :: w
    type(motion_type), intent(in) :: old
    real(dp), intent(in) :: dt
    type(motion_type), intent(inout) :: new
    integer, intent(out) :: evaluations, status
    real(dp) :: move(3), force(3), sums(3, 2)
    integer :: i

    new = old
    evaluations = 0
    sums = outer(new%a, 1)
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
      sums = sums + outer(new%a, i + 1)
    end do
    new%v = new%v + kick(size(kick))*dt*new%a
    new%push = new%push + kick(size(kick))*dt*push_of(new)
    new%t = old%t + dt
    new%error = dt**2*hypot(length(w, sums(:, 1)), length(w, sums(:, 2)))

  contains

    pure function outer(acceleration, k) result(share)
      real(dp), intent(in) :: acceleration(3)
      integer, intent(in) :: k
      real(dp) :: share(3, 2)

      share = reshape([even(k)*acceleration, odd(k)*acceleration], [3, 2])
    end function outer

  end subroutine kick_and_drift

  !> Length of a displacement, or size of an acceleration, in the kinetic metric.
  pure real(dp) function length(w, x)
    type(elastic_wheelset), intent(in) :: w
    real(dp), intent(in) :: x(3)               !! [m, m, rad]

    length = sqrt(sum(w%inertia()*x**2)/w%mass)
  end function length

  !> Newmark's step.
  subroutine advance_newmark(w, integrator, old, dt, new, evaluations, status)
    type(elastic_wheelset), intent(in) :: w
    type(integrator_type), intent(in) :: integrator
    type(motion_type), intent(in) :: old
    real(dp), intent(in) :: dt
    type(motion_type), intent(inout) :: new
    integer, intent(out) :: evaluations, status
    real(dp) :: force(3)

    new%t = old%t + dt
    if (integrator%beta > 0) then
      call solve_newmark(w, integrator, old, dt, new, evaluations, status)
    else
      new%q = old%q + dt*old%v + 0.5_dp*dt**2*old%a
      call evaluate_contacts(w, new, status)
      evaluations = 1
    end if
    new%v = old%v + dt*((1 - integrator%gamma)*old%a + integrator%gamma*new%a)
    new%push = old%push + dt*((1 - integrator%gamma)*push_of(old) + integrator%gamma*push_of(new))
    force = external_force(w, old%t + dt/2)
    new%work = old%work + force(1)*(new%q(1) - old%q(1))
    ! The step errs by (1/6 - beta) dt^3 times the rate of the acceleration.
    new%error = dt**2/6*length(w, new%a - old%a)
  end subroutine advance_newmark

  !> Normal forces of the contacts [N].
  pure function push_of(motion) result(force)
    type(motion_type), intent(in) :: motion
    real(dp) :: force(4)

    force = sqrt(motion%contact%slope(1, :)**2 + motion%contact%slope(2, :)**2)
  end function push_of

  !> Pose and acceleration at the end of Newmark's implicit step.
  subroutine solve_newmark(w, integrator, old, dt, new, evaluations, status)
    type(elastic_wheelset), intent(in) :: w
    type(integrator_type), intent(in) :: integrator
    type(motion_type), intent(in) :: old
    real(dp), intent(in) :: dt
    type(motion_type), intent(inout) :: new
    integer, intent(out) :: evaluations, status
    real(dp) :: m(3), f(3), predicted(3), residual(3), tangent(3, 3), move(3)
    logical :: ok

    m = w%inertia()
    f = external_force(w, new%t)
    predicted = old%q + dt*old%v + dt**2*(0.5_dp - integrator%beta)*old%a
    new%q = predicted + dt**2*integrator%beta*(old%a + dt*old%jerk)
    status = step_diverged
    do evaluations = 1, integrator%max_iterations
      call contacts(w, new%q, new%contact)
      if (new%contact%status /= inside) exit
      residual = m*(new%q - predicted)/(integrator%beta*dt**2) + new%contact%gradient - f
      tangent = symmetric(new%contact%hessian) + diagonal(m/(integrator%beta*dt**2))
      move = residual
      call solve_linear(tangent, move, ok)
      if (.not. ok) exit
      new%q = new%q - move
      if (maxval(abs(move)) <= integrator%tolerance) status = step_ok
      if (status == step_ok) exit
    end do
    evaluations = min(evaluations, integrator%max_iterations)
    if (status == step_ok) call extrapolate(new%contact, -move)
    ! The acceleration follows from the balance of forces, because (q - predicted)/(beta dt^2) would magnify round-off.
    new%a = (f - new%contact%gradient)/m
    new%jerk = (new%a - old%a)/dt
    if (new%contact%status /= inside) status = new%contact%status
  end subroutine solve_newmark

  !> Update a contact state to first order by the last Newton correction, which is smaller than the tolerance.
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

end module integrators