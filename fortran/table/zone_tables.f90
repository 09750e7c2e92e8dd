!> The tabulated energy of one zone of a wheel on its rail: one C2 function of the pose.
!>
!> Every zone has coordinates of its pole: u along the rail's tangent at the zone's mean contact angle, w along the
!> normal, roll angle phi:
!>
!>     p = h(u, phi) - w                    penetration; the zone touches at w = h
!>     U = S(u, phi, q) q^5,  q = sqrt(p+)  elastic energy
!>
!> For a Hertzian patch U is proportional to p^(5/2), for a patch cut by the end of its zone to p^3, so S is smooth in q.
!> h and S are tensor cubic B-splines. Forces are the exact gradient of the interpolant and stiffnesses its exact
!> Hessian, so energy is conserved whatever the resolution. S belongs to the h of the spline, so that it makes up for the
!> error of h.
!>
!> The table grows: a value at a point of the axes is solved when a force first needs it (`table_growth`). Until then it is NaN,
!> and so is every coefficient that depends on it; a pose that needs one has the status `missing`, and a `gap` says where it is.
!>
!> Other zones may lower the surface of the zone by a shift: then q = sqrt((p - shift)+).
module zone_tables
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use bspline, only: axis_basis, axis_cell, axis_holds, axis_type, basis_type, spline_2d, spline_2d_value, spline_3d, &
    spline_3d_line
  use kinds, only: dp
  use wheel_rail_pair, only: rolled
  implicit none
  private
  public :: zone_table, roll_type, touching_type, line_type, gap_type, find_touching, zone_potential, press_line, height, &
    zone_pose, to_pose
  public :: inside, outside_lateral, outside_roll, outside_depth, outside_law, unsettled, missing
  public :: gap_of_height, gap_of_energy, gap_of_influence

  !> The table of a zone.
  type :: zone_table
    logical :: past_root = .false.      !! as of the zone of the wheel
    real(dp) :: along(2) = 0            !! direction of u, track frame
    real(dp) :: pole(2) = 0             !! wheelset frame [m]
    real(dp) :: origin(2) = 0           !! u, w of the pole in the reference pose [m]
    real(dp) :: ceiling = 0             !! Z of the pole above which nothing touches [m]
    real(dp) :: tip = huge(1.0_dp)      !! u beyond which the flange's tip is in contact [m]
    type(axis_type) :: u_h, u, q        !! of h; of S
    real(dp), allocatable :: h(:, :)    !! coefficients over (roll, u_h) [m]
    real(dp), allocatable :: s(:, :, :) !! coefficients over (q, roll, u) [J/m^2.5]
    real(dp), allocatable :: h_at(:, :), s_at(:, :, :)   !! values at the points
    real(dp), allocatable :: h_bound(:, :)   !! upper bound of h in a cell (roll, u_h); huge where it is not known [m]
  end type zone_table

  !> Where the table lacks coefficients: the first ones of a cell.
  type :: gap_type
    integer :: what = 0                 !! one of the enumerators `gap_of...`
    integer :: zone = 0                 !! for an influence: the pair
    integer :: cell(3) = 0              !! over (roll, u), (q, roll, u) or (p, roll, u)
  end type gap_type

  enum, bind(c)
    enumerator :: gap_of_height = 1, gap_of_energy, gap_of_influence
  end enum

  !> A roll angle, prepared for the zones of one wheel.
  type :: roll_type
    real(dp) :: angle, cosine, sine
    type(basis_type) :: basis
  end type roll_type

  !> A zone that touches in a pose.
  type :: touching_type
    integer :: zone
    real(dp) :: arm(2)                  !! from the axle centre to the pole, track frame [m]
    real(dp) :: u, p                    !! coordinate of the pole, penetration [m]
    real(dp) :: shift                   !! by which the other zones lower the surface [m]
    real(dp) :: h(6)                    !! h, h_r, h_u, h_rr, h_ru, h_uu
    type(basis_type) :: basis           !! at u
    real(dp) :: force, stiffness        !! derivatives of the energy with respect to the penetration [N, N/m]
    real(dp) :: energy, gradient(3), hessian(6), of_force(3)   !! `of_force` is the gradient of the force
  end type touching_type

  !> S over q in one cell, at one u and one roll angle.
  type :: line_type
    integer :: cell
    real(dp) :: c(4)
  end type line_type

  !> Whether a pose is on the table.
  enum, bind(c)
    enumerator :: inside = 0, outside_lateral, outside_roll, outside_depth
    enumerator :: outside_law        ! S is negative: splines may oscillate where a zone touches by its edge alone
    enumerator :: unsettled          ! the influences of zones on each other do not converge
    enumerator :: missing            ! the table has to grow first
  end enum

  !> A zone that would pull counts as open if the force is at most this one, to which errors are relative [N].
  real(dp), parameter :: largest_pull = 5e3_dp

contains

  !> Find the penetration of a zone in a pose; it is not positive if the zone does not touch.
  pure subroutine find_touching(t, pose, roll, with_hessian, z, status, gap)
    type(zone_table), intent(in) :: t
    real(dp), intent(in) :: pose(3)
    type(roll_type), intent(in) :: roll
    logical, intent(in) :: with_hessian    !! whether second derivatives are wanted
    type(touching_type), intent(inout) :: z    !! its zone is known
    integer, intent(out) :: status
    type(gap_type), intent(inout) :: gap
    type(basis_type) :: basis
    real(dp) :: w
    integer :: cell

    status = inside
    z%p = 0
    z%arm = pole_arm(t, roll)
    call zone_coordinates(t, pose, z%arm, z%u, w)
    if (.not. axis_holds(t%u_h, z%u)) then
      ! NaN is neither above nor below the ceiling, so it is not on the table.
      if (.not. (pose(2) + z%arm(2) > t%ceiling .and. abs(pose(1)) <= huge(w))) status = outside_lateral
      return
    end if
    cell = axis_cell(t%u_h, z%u)
    if (w >= t%h_bound(roll%basis%i, cell)) return
    call axis_basis(t%u_h, cell, z%u, basis, with_hessian)
    call spline_2d(t%h, roll%basis, basis, with_hessian, z%h)
    if (ieee_is_nan(z%h(1))) then
      status = missing
      gap = gap_type(gap_of_height, z%zone, [roll%basis%i, cell, 0])
      return
    end if
    z%p = z%h(1) - w
    z%shift = 0
    if (z%p <= 0) return
    if (.not. axis_holds(t%q, sqrt(z%p))) status = outside_depth
    call axis_basis(t%u, axis_cell(t%u, z%u), z%u, z%basis, with_hessian)
  end subroutine find_touching

  !> Compute energy, gradient and Hessian of one zone whose surface the other zones have lowered by `shift`. The energy is 0 if
  !> the zone carries nothing.
  pure subroutine zone_potential(t, roll, with_hessian, z, status, gap)
    type(zone_table), intent(in) :: t
    type(roll_type), intent(in) :: roll    !! roll of the pose
    logical, intent(in) :: with_hessian    !! whether the Hessian is wanted
    type(touching_type), intent(inout) :: z
    integer, intent(out) :: status
    type(gap_type), intent(inout) :: gap
    type(basis_type) :: bq
    real(dp) :: p, q, v(10), f(10)

    status = inside
    z%energy = 0
    p = z%p - z%shift
    if (.not. p > 0) return
    q = sqrt(p)
    call axis_basis(t%q, axis_cell(t%q, q), q, bq, with_hessian)
    call spline_3d(t%s, bq, roll%basis, z%basis, with_hessian, v)  ! S, S_q, S_r, S_u, S_qq, S_qr, S_qu, S_rr, S_ru, S_uu
    if (ieee_is_nan(v(1))) then
      status = missing
      gap = gap_type(gap_of_energy, z%zone, [bq%i, roll%basis%i, z%basis%i])
      return
    end if

    ! F(u, roll, p) = q^5 S(u, roll, q), q = sqrt(p):
    ! F, F_p, F_r, F_u, F_pp, F_pr, F_pu, F_rr, F_ru, F_uu.
    f(1) = q**5*v(1)
    f(2) = q**3*(2.5_dp*v(1) + 0.5_dp*q*v(2))
    if (f(1) <= 0) then
      if (-2.5_dp*f(1)/p > largest_pull) status = outside_law
      return
    end if
    z%energy = f(1)
    f(3:4) = q**5*v(3:4)
    f(5:) = 0
    if (with_hessian) then
      f(5) = q*(3.75_dp*v(1) + 2.25_dp*q*v(2) + 0.25_dp*p*v(5))
      f(6:7) = q**3*(2.5_dp*v(3:4) + 0.5_dp*q*v(6:7))
      f(8:10) = q**5*v(8:10)
    end if
    z%force = f(2)
    call to_pose(t, z%arm, z%h, f, with_hessian, z%gradient, z%hessian)
    if (.not. with_hessian) return
    z%stiffness = f(5)
    z%of_force = covector(t, z%arm, f(7) + f(5)*z%h(3), -f(5), f(6) + f(5)*z%h(2))
  end subroutine zone_potential

  !> Force f [N] of a zone on its lowered surface, and stiffness k [N/m]; `line` keeps S over q from one call to the next. The
  !> status is `inside` or `missing`.
  pure subroutine press_line(t, roll, z, line, f, k, status, gap)
    type(zone_table), intent(in) :: t
    type(roll_type), intent(in) :: roll
    type(touching_type), intent(in) :: z
    type(line_type), intent(inout) :: line
    real(dp), intent(out) :: f, k
    integer, intent(inout) :: status
    type(gap_type), intent(inout) :: gap
    type(basis_type) :: bq
    real(dp) :: p, q, s(0:2)

    f = 0
    k = 0
    p = z%p - z%shift
    if (.not. p > 0) return
    q = sqrt(p)
    call axis_basis(t%q, axis_cell(t%q, q), q, bq, .true.)
    if (line%cell /= bq%i) call spline_3d_line(t%s, bq%i, roll%basis, z%basis, line%c)
    line%cell = bq%i
    if (any(ieee_is_nan(line%c))) then
      status = missing
      gap = gap_type(gap_of_energy, z%zone, [bq%i, roll%basis%i, z%basis%i])
      return
    end if
    s = [dot_product(line%c, bq%b(:, 0)), dot_product(line%c, bq%b(:, 1)), dot_product(line%c, bq%b(:, 2))]
    f = q**3*(2.5_dp*s(0) + 0.5_dp*q*s(1))
    k = max(0.0_dp, q*(3.75_dp*s(0) + 2.25_dp*q*s(1) + 0.25_dp*p*s(2)))
    if (f > 0 .and. s(0) > 0) return
    f = 0
    k = 0
  end subroutine press_line

  !> Return h of a zone at u [m]; NaN where it is missing.
  pure real(dp) function height(t, u, roll) result(h)
    type(zone_table), intent(in) :: t
    real(dp), intent(in) :: u
    type(basis_type), intent(in) :: roll
    type(basis_type) :: basis

    call axis_basis(t%u_h, axis_cell(t%u_h, u), u, basis, .false.)
    h = spline_2d_value(t%h, roll, basis)
  end function height

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
  pure subroutine to_pose(t, arm, h, f, with_hessian, gradient, hessian)
    type(zone_table), intent(in) :: t
    real(dp), intent(in) :: arm(2)         !! from the axle centre to the pole, track frame [m]
    real(dp), intent(in) :: h(6)           !! h, h_r, h_u, h_rr, h_ru, h_uu
    real(dp), intent(in) :: f(10)          !! F, F_p, F_r, F_u, F_pp, F_pr, F_pu, F_rr, F_ru, F_uu
    logical, intent(in) :: with_hessian    !! whether the Hessian is wanted
    real(dp), intent(inout) :: gradient(3), hessian(6)
    real(dp) :: ca, sa, eu, ew, er, euu, euw, eur, eww, ewr, err, ur, wr

    ! e.. are derivatives with respect to u, w, roll; ur and wr are du/droll and dw/droll of the pole.
    eu = f(4) + f(2)*h(3)
    er = f(3) + f(2)*h(2)
    ew = -f(2)
    gradient = covector(t, arm, eu, ew, er)
    if (.not. with_hessian) return
    ca = t%along(1)
    sa = t%along(2)
    ur = arm(1)*sa - arm(2)*ca
    wr = arm(1)*ca + arm(2)*sa

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

  !> Return the gradient with respect to the pose of a function with the derivatives eu, ew, er with respect to u, w and roll.
  pure function covector(t, arm, eu, ew, er) result(gradient)
    type(zone_table), intent(in) :: t
    real(dp), intent(in) :: arm(2)         !! from the axle centre to the pole, track frame [m]
    real(dp), intent(in) :: eu, ew, er
    real(dp) :: gradient(3)

    associate (ca => t%along(1), sa => t%along(2))
      gradient = [eu*ca - ew*sa, eu*sa + ew*ca, er + eu*(arm(1)*sa - arm(2)*ca) + ew*(arm(1)*ca + arm(2)*sa)]
    end associate
  end function covector

end module zone_tables
