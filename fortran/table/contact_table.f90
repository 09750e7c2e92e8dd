!> The contact potential of a wheel/rail pair, looked up: one C2 function of the pose.
!>
!> Per zone, in coordinates of the zone's pole (u along the rail's tangent at the
!> zone's mean contact angle, w along its normal, roll phi):
!>
!>     p = h(u, phi) - w                    penetration; h: where the zone touches
!>     U = S(u, phi, q) q^5,  q = sqrt(p+)
!>
!> For a Hertzian patch U goes with p^(5/2), for a patch cut by the end of its
!> zone with p^3, so S is smooth in q.  h and S are tensor cubic B-splines.  Forces are
!> the exact gradient of the interpolant and stiffnesses its exact Hessian, so
!> energy is conserved whatever the resolution.
module contact_table
  use bspline, only: axis_basis, axis_holds, axis_type, basis_type, spline_2d, spline_2d_value, spline_3d
  use kinds, only: dp
  implicit none
  private
  public :: zone_table, table_type, accuracy_type, roll_type, bound_heights, find_roll, wheel_potential, &
    height_over, zone_pose
  public :: inside, outside_lateral, outside_roll, outside_depth, outside_law

  type :: zone_table
    logical :: flange = .false.
    real(dp) :: along(2) = 0            !! direction of u, track frame
    real(dp) :: pole(2) = 0             !! wheelset frame [m]
    real(dp) :: origin(2) = 0           !! u, w of the pole in the reference pose [m]
    real(dp) :: ceiling = 0             !! Z of the pole above which nothing touches [m]
    type(axis_type) :: u, roll, q
    real(dp), allocatable :: h(:, :)    !! coefficients over (roll, u)
    real(dp), allocatable :: s(:, :, :) !! coefficients over (q, roll, u)
    real(dp), allocatable :: highest(:, :)   !! bound of h over (equal steps of u, cell of roll)
    real(dp) :: steps = 0               !! of u per metre
  end type zone_table

  !> Error of the force against direct evaluation, of max(|F|, 5 kN), F the wheel's: on the tread, on the
  !> flange, on both at once, and of wheelsets that go over a rail.  Not known where there are no poses.
  type :: accuracy_type
    integer :: unsolved = 0             !! further poses, whose direct evaluation did not converge
    integer :: poses(4) = 0
    real(dp) :: rms(4) = 0, largest(4) = 0
  end type accuracy_type

  type :: table_type
    character(:), allocatable :: key    !! everything that the table depends on
    type(zone_table), allocatable :: zones(:)
    type(accuracy_type) :: accuracy
    integer :: solutions(2) = 0         !! of half-spaces in it, and those that did not converge
  end type table_type

  !> A roll angle as the zones of a wheel see it.
  type :: roll_type
    real(dp) :: cosine, sine
    type(basis_type) :: basis
  end type roll_type

  !> Whether a pose is on the table.
  enum, bind(c)
    enumerator :: inside = 0, outside_lateral, outside_roll, outside_depth
    enumerator :: outside_law        ! S is negative: beyond what runs reach, splines oscillate
  end enum

  !> Just below S = 0 a zone is taken for open. What is dropped then is no more than accuracies are measured by [N].
  real(dp), parameter :: largest_pull = 5e3_dp

contains

  !> Bounds of h, by which a zone that does not touch is passed over: a spline is nowhere
  !> larger than the coefficients of its cell.
  pure subroutine bound_heights(t)
    type(zone_table), intent(inout) :: t
    integer, parameter :: n_steps = 256
    type(basis_type) :: first, last
    integer :: i, j

    t%steps = n_steps*(1 - epsilon(1.0_dp))/(t%u%high - t%u%low)
    if (allocated(t%highest)) deallocate (t%highest)
    allocate (t%highest(n_steps, t%roll%n - 1))
    do j = 1, n_steps
      call axis_basis(t%u, t%u%low + (j - 1)/t%steps, first)
      call axis_basis(t%u, min(t%u%low + j/t%steps, t%u%high), last)
      ! One more to either side, for rounding.
      first%i = max(first%i - 1, 1)
      last%i = min(last%i + 1, t%u%n - 1)
      do i = 1, t%roll%n - 1
        t%highest(j, i) = maxval(t%h(i:i + 3, first%i:last%i + 3))
      end do
    end do
  end subroutine bound_heights

  !> A roll angle [rad] and its opposite, which the other wheel sees.
  pure subroutine find_roll(t, angle, tangent, roll, opposite, status)
    type(table_type), intent(in) :: t
    real(dp), intent(in) :: angle
    logical, intent(in) :: tangent         !! whether a Hessian is wanted
    type(roll_type), intent(out) :: roll, opposite
    integer, intent(out) :: status

    status = outside_roll
    if (.not. (axis_holds(t%zones(1)%roll, angle) .and. axis_holds(t%zones(1)%roll, -angle))) return
    status = inside
    roll%cosine = cos(angle)
    roll%sine = sin(angle)
    opposite%cosine = roll%cosine
    opposite%sine = -roll%sine
    call axis_basis(t%zones(1)%roll, angle, roll%basis, tangent)
    call axis_basis(t%zones(1)%roll, -angle, opposite%basis, tangent)
  end subroutine find_roll

  !> Elastic energy [J] of the left wheel's tread and flange, their gradients with
  !> respect to the pose (y, z, roll), and, if wanted, the Hessian (yy, yz, y roll,
  !> zz, z roll, roll roll) of their sum, else 0.
  pure subroutine wheel_potential(t, pose, roll, tangent, energy, gradient, hessian, status)
    type(table_type), intent(in) :: t
    real(dp), intent(in) :: pose(3)        !! axle centre y, z [m], roll [rad]; track frame
    type(roll_type), intent(in) :: roll    !! of the pose
    logical, intent(in) :: tangent         !! whether the Hessian is wanted
    real(dp), intent(out) :: energy(2), gradient(3, 2), hessian(6)
    integer, intent(out) :: status
    real(dp) :: part, slope(3), bend(6)
    integer :: i, branch

    energy = 0
    gradient = 0
    hessian = 0
    bend = 0
    status = inside
    do i = 1, size(t%zones)
      call zone_potential(t%zones(i), pose, roll, tangent, part, slope, bend, status)
      if (status /= inside) return
      if (part < 0) then
        if (norm2(slope(:2)) > largest_pull) status = outside_law
        if (status /= inside) return
      end if
      if (part <= 0) cycle
      branch = merge(2, 1, t%zones(i)%flange)
      energy(branch) = energy(branch) + part
      gradient(:, branch) = gradient(:, branch) + slope
      if (tangent) hessian = hessian + bend
    end do
  end subroutine wheel_potential

  !> The same of one zone.  Where it does not touch, only the energy is set, to zero.
  pure subroutine zone_potential(t, pose, roll, tangent, energy, gradient, hessian, status)
    type(zone_table), intent(in) :: t
    real(dp), intent(in) :: pose(3)
    type(roll_type), intent(in) :: roll
    logical, intent(in) :: tangent         !! whether the Hessian is wanted
    real(dp), intent(out) :: energy
    real(dp), intent(inout) :: gradient(3), hessian(6)
    integer, intent(out) :: status
    type(basis_type) :: bu, bq
    real(dp) :: arm(2), u, w, p, q, h(6), v(10), f(10)

    energy = 0
    status = inside
    arm = pole_arm(t, roll)
    call zone_coordinates(t, pose, arm, u, w)
    if (.not. axis_holds(t%u, u)) then
      ! What is no number is neither above nor below.
      if (.not. (pose(2) + arm(2) > t%ceiling .and. abs(pose(1)) <= huge(u))) status = outside_lateral
      return
    end if
    if (w >= t%highest(int((u - t%u%low)*t%steps) + 1, roll%basis%i)) return
    call axis_basis(t%u, u, bu, tangent)
    call spline_2d(t%h, roll%basis, bu, tangent, h)      ! h, h_r, h_u, h_rr, h_ru, h_uu
    p = h(1) - w
    if (p <= 0) return
    q = sqrt(p)
    if (.not. axis_holds(t%q, q)) then
      status = outside_depth
      return
    end if
    call axis_basis(t%q, q, bq, tangent)
    call spline_3d(t%s, bq, roll%basis, bu, tangent, v)  ! S, S_q, S_r, S_u, S_qq, S_qr, S_qu, S_rr, S_ru, S_uu

    ! F(u, roll, p) = q^5 S(u, roll, q), q = sqrt(p):
    ! F, F_p, F_r, F_u, F_pp, F_pr, F_pu, F_rr, F_ru, F_uu.
    energy = q**5*v(1)
    f(1) = energy
    f(2) = q**3*(2.5_dp*v(1) + 0.5_dp*q*v(2))
    f(3:4) = q**5*v(3:4)
    f(5:) = 0
    if (tangent) then
      f(5) = q*(3.75_dp*v(1) + 2.25_dp*q*v(2) + 0.25_dp*p*v(5))
      f(6:7) = q**3*(2.5_dp*v(3:4) + 0.5_dp*q*v(6:7))
      f(8:10) = q**5*v(8:10)
    end if
    call to_pose(t, arm, h, f, tangent, gradient, hessian)
  end subroutine zone_potential

  !> Penetration of a zone in a pose [m]; negative where it does not touch.
  pure real(dp) function height_over(t, pose, roll) result(p)
    type(zone_table), intent(in) :: t
    real(dp), intent(in) :: pose(3)
    type(roll_type), intent(in) :: roll    !! of the pose
    type(basis_type) :: bu
    real(dp) :: arm(2), u, w

    p = -1
    arm = pole_arm(t, roll)
    call zone_coordinates(t, pose, arm, u, w)
    if (pose(2) + arm(2) > t%ceiling .or. .not. axis_holds(t%u, u)) return
    call axis_basis(t%u, u, bu, .false.)
    p = spline_2d_value(t%h, roll%basis, bu) - w
  end function height_over

  !> The pose (y, z, roll) in which the pole of a zone is at u and w.
  pure function zone_pose(t, u, w, roll) result(pose)
    type(zone_table), intent(in) :: t
    real(dp), intent(in) :: u, w, roll     !! [m, rad]
    real(dp) :: pose(3)

    pose = [(t%origin(1) + u)*t%along + (t%origin(2) + w)*[-t%along(2), t%along(1)] &
      - [t%pole(1)*cos(roll) - t%pole(2)*sin(roll), t%pole(1)*sin(roll) + t%pole(2)*cos(roll)], roll]
  end function zone_pose

  !> The pole from the axle centre, track frame [m].
  pure function pole_arm(t, roll) result(arm)
    type(zone_table), intent(in) :: t
    type(roll_type), intent(in) :: roll
    real(dp) :: arm(2)

    arm = [t%pole(1)*roll%cosine - t%pole(2)*roll%sine, t%pole(1)*roll%sine + t%pole(2)*roll%cosine]
  end function pole_arm

  !> u and w of the pole in a pose; arm: the pole from the axle centre, track frame.
  pure subroutine zone_coordinates(t, pose, arm, u, w)
    type(zone_table), intent(in) :: t
    real(dp), intent(in) :: pose(3), arm(2)
    real(dp), intent(out) :: u, w
    real(dp) :: x(2)

    x = pose(1:2) + arm
    u = x(1)*t%along(1) + x(2)*t%along(2) - t%origin(1)
    w = x(2)*t%along(1) - x(1)*t%along(2) - t%origin(2)
  end subroutine zone_coordinates

  !> Gradient and Hessian with respect to the pose of F(u, roll, p), p = h(u, roll) - w.
  pure subroutine to_pose(t, arm, h, f, tangent, gradient, hessian)
    type(zone_table), intent(in) :: t
    real(dp), intent(in) :: arm(2)         !! the pole from the axle centre, track frame [m]
    real(dp), intent(in) :: h(6)           !! h, h_r, h_u, h_rr, h_ru, h_uu
    real(dp), intent(in) :: f(10)          !! F, F_p, F_r, F_u, F_pp, F_pr, F_pu, F_rr, F_ru, F_uu
    logical, intent(in) :: tangent         !! whether the Hessian is wanted
    real(dp), intent(inout) :: gradient(3), hessian(6)
    real(dp) :: ca, sa, eu, ew, er, euu, euw, eur, eww, ewr, err, ur, wr

    ! With respect to u, w, roll; u and w of the pole as functions of the pose.
    eu = f(4) + f(2)*h(3)
    er = f(3) + f(2)*h(2)
    ew = -f(2)
    ca = t%along(1)
    sa = t%along(2)
    ur = arm(1)*sa - arm(2)*ca
    wr = arm(1)*ca + arm(2)*sa
    gradient = [eu*ca - ew*sa, eu*sa + ew*ca, er + eu*ur + ew*wr]
    if (.not. tangent) return

    euu = f(10) + 2*f(7)*h(3) + f(5)*h(3)**2 + f(2)*h(6)
    eur = f(9) + f(7)*h(2) + f(6)*h(3) + f(5)*h(2)*h(3) + f(2)*h(5)
    err = f(8) + 2*f(6)*h(2) + f(5)*h(2)**2 + f(2)*h(4)
    euw = -f(7) - f(5)*h(3)
    ewr = -f(6) - f(5)*h(2)
    eww = f(5)
    hessian(1) = euu*ca**2 - 2*euw*ca*sa + eww*sa**2
    hessian(2) = (euu - eww)*ca*sa + euw*(ca**2 - sa**2)
    hessian(3) = (eur + euu*ur + euw*wr)*ca - (ewr + euw*ur + eww*wr)*sa
    hessian(4) = euu*sa**2 + 2*euw*ca*sa + eww*ca**2
    hessian(5) = (eur + euu*ur + euw*wr)*sa + (ewr + euw*ur + eww*wr)*ca
    hessian(6) = err + 2*(eur*ur + ewr*wr) + euu*ur**2 + 2*euw*ur*wr + eww*wr**2 &
      - eu*wr + ew*ur
  end subroutine to_pose

end module contact_table