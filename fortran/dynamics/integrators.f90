!> Steps of M q'' = f(t) - dU/dq in time, of three orders. All are symmetric and have no numerical damping at their defaults.
!>
!> Order 2  N. M. Newmark, J. Eng. Mech. Div. ASCE 85 (1959) 67-94, with beta and gamma; beta = 0 is explicit. The implicit
!>          equations are solved by Newton's method on the exact tangent.
!> Order 4  explicit: kicks (force) and drifts (motion) in turn, with six forces per step, and
!> order 6  with eleven: S. Blanes, P. C. Moan, J. Comput. Appl. Math. 142 (2002) 313-330, for second-order equations.
module integrators
  use kinds, only: dp
  use linear_solver, only: solve_linear
  use motion_state, only: motion_type
  use zone_tables, only: inside
  use wheelset, only: contact_state, contacts, external_force, symmetric, total, wheelset_type
  implicit none
  private
  public :: integrator_type, stability_limit, evaluate_contacts, advance, energy_change, energy_rounding, step_ok, step_diverged, &
    kick_4, drift_4

  type :: integrator_type
    integer :: order = 2               !! or 4, or 6
    real(dp) :: beta = 0.25_dp, gamma = 0.5_dp   !! of order 2
    real(dp) :: tolerance = 1e-10_dp   !! largest Newton correction at convergence [m, rad]: Newton's
                                       !! method squares it, so that the next one would be tolerance^2/(1 m)
    integer :: max_iterations = 12
  end type integrator_type

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

  integer, parameter :: step_ok = 0, step_diverged = -1   ! otherwise a status of `zone_tables`

contains

  !> Contacts and accelerations of a motion.
  subroutine evaluate_contacts(w, motion, status)
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
  elemental real(dp) function stability_limit(integrator) result(limit)
    type(integrator_type), intent(in) :: integrator

    select case (integrator%order)
    case (4)
      limit = 5.027_dp
    case (6)
      limit = 9.074_dp
    case default
      limit = huge(limit)
      if (2*integrator%beta < integrator%gamma) limit = 1/sqrt(integrator%gamma/2 - integrator%beta)
    end select
  end function stability_limit

  !> One step dt from `old` to `new`. `status`: step_ok, step_diverged, or why the pose left the table.
  subroutine advance(w, integrator, old, dt, new, evaluations, status)
    type(wheelset_type), intent(in) :: w
    type(integrator_type), intent(in) :: integrator
    type(motion_type), intent(in) :: old
    real(dp), intent(in) :: dt
    type(motion_type), intent(out) :: new
    integer, intent(out) :: evaluations    !! number of evaluations of the contacts
    integer, intent(out) :: status

    select case (integrator%order)
    case (4)
      call kick_and_drift(w, kick_4, drift_4, old, dt, new, evaluations, status)
    case (6)
      call kick_and_drift(w, kick_6, drift_6, old, dt, new, evaluations, status)
    case default
      call advance_newmark(w, integrator, old, dt, new, evaluations, status)
    end select
  end subroutine advance

  !> Change of the total energy in a step, less the work of the lateral force [J]. The exact motion has zero. Left and right
  !> are summed separately, so that the mirrored run rounds in the same way.
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
  subroutine kick_and_drift(w, kick, drift, old, dt, new, evaluations, status)
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

  !> Newmark's step.
  subroutine advance_newmark(w, integrator, old, dt, new, evaluations, status)
    type(wheelset_type), intent(in) :: w
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
  end subroutine advance_newmark

  !> Normal forces of the contacts [N].
  pure function push_of(motion) result(force)
    type(motion_type), intent(in) :: motion
    real(dp) :: force(4)

    force = sqrt(motion%contact%slope(1, :)**2 + motion%contact%slope(2, :)**2)
  end function push_of

  !> Pose and acceleration at the end of Newmark's implicit step.
  subroutine solve_newmark(w, integrator, old, dt, new, evaluations, status)
    type(wheelset_type), intent(in) :: w
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