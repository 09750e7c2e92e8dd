!> The tabulated contact potential of a wheel/rail pair: one C2 function of the pose.
!>
!> Every zone has coordinates of its pole: u along the rail's tangent at the zone's mean contact angle, w along the
!> normal, roll angle phi:
!>
!>     p = h(u, phi) - w                    penetration; the zone touches at w = h
!>     U = S(u, phi, q) q^5,  q = sqrt(p+)  elastic energy
!>
!> For a Hertzian patch U is proportional to p^(5/2), for a patch cut by the end of its zone to p^3, so S is smooth in q.
!> h and S are tensor cubic B-splines. Forces are the exact gradient of the interpolant and stiffnesses its exact
!> Hessian, so energy is conserved whatever the resolution.
module contact_table
  use bspline, only: axis_basis, axis_holds, axis_type, basis_type, spline_2d, spline_2d_value, spline_3d
  use kinds, only: dp
  use wheel_rail_pair, only: rolled
  implicit none
  private
  public :: zone_table, table_type, accuracy_type, roll_type, bound_heights, find_roll, wheel_potential, &
    zone_penetration, zone_pose
  public :: inside, outside_lateral, outside_roll, outside_depth, outside_law

  type :: zone_table
    logical :: flange = .false.
    real(dp) :: along(2) = 0            !! direction of u, track frame
    real(dp) :: pole(2) = 0             !! wheelset frame [m]
    real(dp) :: origin(2) = 0           !! u, w of the pole in the reference pose [m]
    real(dp) :: ceiling = 0             !! Z of the pole above which nothing touches [m]
    type(axis_type) :: u, q
    real(dp), allocatable :: h(:, :)    !! coefficients over (roll, u)
    real(dp), allocatable :: s(:, :, :) !! coefficients over (q, roll, u)
    real(dp), allocatable :: h_bound(:, :)   !! upper bound of h in (bin of u, cell of roll angle) [m]
    real(dp) :: bins_per_metre = 0      !! bins of `h_bound` per metre of u
  end type zone_table

  !> Error of a wheel's force F against direct evaluation, relative to max(|F|, 5 kN): on the tread, on the flange, on
  !> both at once, and in rolling over the rail. A place without poses has no known error.
  type :: accuracy_type
    integer :: unsolved = 0             !! poses left out, as their direct evaluation did not converge
    integer :: pulling = 0              !! points in service where the contact would pull: a run stops there
    integer :: poses(4) = 0             !! compared
    real(dp) :: rms(4) = 0, largest(4) = 0   !! errors
  end type accuracy_type

  type :: table_type
    character(:), allocatable :: key    !! everything that the table depends on
    type(axis_type) :: roll             !! roll angle of all zones [rad]
    type(zone_table), allocatable :: zones(:)
    type(accuracy_type) :: accuracy
    integer :: solutions(2) = 0         !! half-space solutions in the table, and those that did not converge
  end type table_type

  !> A roll angle, prepared for the zones of one wheel.
  type :: roll_type
    real(dp) :: cosine, sine
    type(basis_type) :: basis
  end type roll_type

  !> Whether a pose is on the table.
  enum, bind(c)
    enumerator :: inside = 0, outside_lateral, outside_roll, outside_depth
    enumerator :: outside_law        ! S is negative: splines may oscillate outside the poses that runs reach
  end enum

  !> A zone with S < 0 counts as open if its force is at most this one, to which errors are relative [N].
  real(dp), parameter :: largest_pull = 5e3_dp

contains

  !> Compute the bounds of h, with which a zone that does not touch is skipped: in a cell a spline is at most its largest
  !> coefficient there.
  pure subroutine bound_heights(t)
    type(zone_table), intent(inout) :: t
    integer, parameter :: n_bins = 256
    type(basis_type) :: first, last
    real(dp) :: highest(size(t%h, 1))
    integer :: i, j

    t%bins_per_metre = n_bins*(1 - epsilon(1.0_dp))/(t%u%high - t%u%low)
    if (allocated(t%h_bound)) deallocate (t%h_bound)
    allocate (t%h_bound(n_bins, size(highest) - 3))
    do j = 1, n_bins
      call axis_basis(t%u, t%u%low + (j - 1)/t%bins_per_metre, first)
      call axis_basis(t%u, min(t%u%low + j/t%bins_per_metre, t%u%high), last)
      ! One more cell on either side covers rounding.
      first%i = max(first%i - 1, 1)
      last%i = min(last%i + 1, t%u%n - 1)
      highest = t%h(:, first%i)
      do i = first%i + 1, last%i + 3
        highest = max(highest, t%h(:, i))
      end do
      do i = 1, size(t%h_bound, 2)
        t%h_bound(j, i) = maxval(highest(i:i + 3))
      end do
    end do
  end subroutine bound_heights

  !> Prepare a roll angle [rad] for the left wheel, and its opposite for the right wheel, which is solved as the mirror image
  !> of a left one. The status is `inside` or `outside_roll`.
  pure subroutine find_roll(t, angle, tangent, roll, opposite, status)
    type(table_type), intent(in) :: t
    real(dp), intent(in) :: angle
    logical, intent(in) :: tangent         !! whether a Hessian is wanted
    type(roll_type), intent(out) :: roll, opposite
    integer, intent(out) :: status

    status = outside_roll
    if (.not. (axis_holds(t%roll, angle) .and. axis_holds(t%roll, -angle))) return
    status = inside
    roll%cosine = cos(angle)
    roll%sine = sin(angle)
    opposite%cosine = roll%cosine
    opposite%sine = -roll%sine
    call axis_basis(t%roll, angle, roll%basis, tangent)
    call axis_basis(t%roll, -angle, opposite%basis, tangent)
  end subroutine find_roll

  !> Compute the elastic energy [J] of the left wheel's tread and flange, its gradients with respect to the pose
  !> (y, z, roll) [N, N, N m], and, if wanted, the Hessian (yy, yz, y roll, zz, z roll, roll roll) of the sum, else 0.
  !> The status is `inside`, or says why the pose is not on the table.
  pure subroutine wheel_potential(t, pose, roll, tangent, energy, gradient, hessian, status)
    type(table_type), intent(in) :: t
    real(dp), intent(in) :: pose(3)        !! axle centre y, z [m], roll [rad]; track frame
    type(roll_type), intent(in) :: roll    !! roll of the pose
    logical, intent(in) :: tangent         !! whether the Hessian is wanted
    real(dp), intent(out) :: energy(2), gradient(3, 2), hessian(6)
    integer, intent(out) :: status
    real(dp) :: part, slope(3), curvature(6)
    integer :: i, branch

    energy = 0
    gradient = 0
    hessian = 0
    curvature = 0
    status = inside
    do i = 1, size(t%zones)
      call zone_potential(t%zones(i), pose, roll, tangent, part, slope, curvature, status)
      if (status /= inside) return
      if (part < 0) then
        if (norm2(slope(:2)) > largest_pull) status = outside_law
        if (status /= inside) return
      end if
      if (part <= 0) cycle
      branch = merge(2, 1, t%zones(i)%flange)
      energy(branch) = energy(branch) + part
      gradient(:, branch) = gradient(:, branch) + slope
      if (tangent) hessian = hessian + curvature
    end do
  end subroutine wheel_potential

  !> Compute energy, gradient and Hessian of one zone, as `wheel_potential`. If the zone does not touch, the energy is zero and
  !> the others are not set.
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
      ! NaN is neither above nor below the ceiling, so it is not on the table.
      if (.not. (pose(2) + arm(2) > t%ceiling .and. abs(pose(1)) <= huge(u))) status = outside_lateral
      return
    end if
    if (w >= t%h_bound(int((u - t%u%low)*t%bins_per_metre) + 1, roll%basis%i)) return
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

  !> Return the penetration of a zone in a pose [m]; negative if the zone does not touch.
  pure real(dp) function zone_penetration(t, pose, roll) result(p)
    type(zone_table), intent(in) :: t
    real(dp), intent(in) :: pose(3)
    type(roll_type), intent(in) :: roll    !! roll of the pose
    type(basis_type) :: bu
    real(dp) :: arm(2), u, w

    p = -1
    arm = pole_arm(t, roll)
    call zone_coordinates(t, pose, arm, u, w)
    if (pose(2) + arm(2) > t%ceiling .or. .not. axis_holds(t%u, u)) return
    call axis_basis(t%u, u, bu, .false.)
    p = spline_2d_value(t%h, roll%basis, bu) - w
  end function zone_penetration

  !> Return the pose (y, z, roll) in which the pole of a zone is at u and w.
  pure function zone_pose(t, u, w, roll) result(pose)
    type(zone_table), intent(in) :: t
    real(dp), intent(in) :: u, w, roll     !! [m, rad]
    real(dp) :: pose(3)

    pose = [(t%origin(1) + u)*t%along + (t%origin(2) + w)*[-t%along(2), t%along(1)] - rolled(t%pole, roll), roll]
  end function zone_pose

  !> Return the vector from the axle centre to the pole, track frame [m].
  pure function pole_arm(t, roll) result(arm)
    type(zone_table), intent(in) :: t
    type(roll_type), intent(in) :: roll
    real(dp) :: arm(2)

    arm = [t%pole(1)*roll%cosine - t%pole(2)*roll%sine, t%pole(1)*roll%sine + t%pole(2)*roll%cosine]
  end function pole_arm

  !> Compute u and w of the pole in a pose [m]; `arm` is the vector from the axle centre to the pole, track frame [m].
  pure subroutine zone_coordinates(t, pose, arm, u, w)
    type(zone_table), intent(in) :: t
    real(dp), intent(in) :: pose(3), arm(2)
    real(dp), intent(out) :: u, w
    real(dp) :: x(2)

    x = pose(1:2) + arm
    u = x(1)*t%along(1) + x(2)*t%along(2) - t%origin(1)
    w = x(2)*t%along(1) - x(1)*t%along(2) - t%origin(2)
  end subroutine zone_coordinates

  !> Compute gradient and Hessian with respect to the pose of F(u, roll, p), p = h(u, roll) - w.
  pure subroutine to_pose(t, arm, h, f, tangent, gradient, hessian)
    type(zone_table), intent(in) :: t
    real(dp), intent(in) :: arm(2)         !! from the axle centre to the pole, track frame [m]
    real(dp), intent(in) :: h(6)           !! h, h_r, h_u, h_rr, h_ru, h_uu
    real(dp), intent(in) :: f(10)          !! F, F_p, F_r, F_u, F_pp, F_pr, F_pu, F_rr, F_ru, F_uu
    logical, intent(in) :: tangent         !! whether the Hessian is wanted
    real(dp), intent(inout) :: gradient(3), hessian(6)
    real(dp) :: ca, sa, eu, ew, er, euu, euw, eur, eww, ewr, err, ur, wr

    ! e.. are derivatives with respect to u, w, roll; ur and wr are du/droll and dw/droll of the pole.
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