!> The tabulated contact potential of a wheel/rail pair: one C2 function of the pose.
!>
!> Every zone has coordinates of its pole: u along the rail's tangent at the zone's mean contact angle, w along the
!> normal, roll angle phi:
!>
!>     p = h(u, phi) - w                    penetration; the zone touches at w = h
!>     U = S(u, phi, q) q^5,  q = sqrt(p+)  elastic energy
!>
!> For a Hertzian patch U is proportional to p^(5/2), for a patch cut by the end of its zone to p^3, so S is smooth in q.
!> h and S are tensor cubic B-splines. Zones that carry together lower the surface of each other: with the influences
!> c_ij of two zones,
!>
!>     U = sum S_i q_i^5 + 1/2 sum c_ij f_i f_j,  q_i = sqrt(p_i - s_i),  s_i = sum c_ij f_j,  f_i = d(S_i q_i^5)/d(q_i^2).
!>
!> U is stationary in the forces f, so that dU/dp_i = f_i, and a zone begins to carry where its lowered surface touches.
!> Forces are the exact gradient of U and stiffnesses its exact Hessian, so energy is conserved whatever the resolution.
!>
!> Tread and flange are names for the zones that carry: a contact is the flange's if its contact angle is at least the
!> threshold of the case, or if it is on the flange's tip.
module contact_table
  use bspline, only: axis_basis, axis_holds, axis_type, basis_type, spline_2d, spline_2d_value, spline_3d, spline_3d_line
  use contact_zones, only: max_zones
  use kinds, only: dp
  use wheel_rail_pair, only: rolled
  implicit none
  private
  public :: zone_table, pair_table, table_type, accuracy_type, roll_type, bound_heights, find_roll, wheel_potential, &
    zone_penetration, zone_pose, coupled_forces, pair_influence
  public :: inside, outside_lateral, outside_roll, outside_depth, outside_law

  type :: zone_table
    logical :: flange = .false.         !! not the zone of the running point
    real(dp) :: along(2) = 0            !! direction of u, track frame
    real(dp) :: pole(2) = 0             !! wheelset frame [m]
    real(dp) :: origin(2) = 0           !! u, w of the pole in the reference pose [m]
    real(dp) :: ceiling = 0             !! Z of the pole above which nothing touches [m]
    real(dp) :: tip = huge(1.0_dp)      !! u beyond which the flange's tip is in contact [m]
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

  !> Influence c of two zones on each other: a force on one lowers the surface of the other by c times the force.
  type :: pair_table
    integer :: zone(2) = 0
    type(axis_type) :: u, roll, p       !! of the second zone
    real(dp), allocatable :: c(:, :, :) !! coefficients over (p, roll, u)
  end type pair_table

  type :: table_type
    character(:), allocatable :: key    !! everything that the table depends on
    type(axis_type) :: roll             !! roll angle of all zones [rad]
    type(zone_table), allocatable :: zones(:)
    type(pair_table), allocatable :: pairs(:)   !! not allocated if zones do not act on each other
    real(dp) :: threshold(2) = [0.9063_dp, 0.4226_dp]   !! cosine and sine of the least contact angle of a flange contact
    type(accuracy_type) :: accuracy
    integer :: solutions(2) = 0         !! half-space solutions in the table, and those that did not converge
  end type table_type

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

  !> An influence and its derivatives with respect to the pose; the zones that touch are counted.
  type :: influence_type
    integer :: first, second
    real(dp) :: gradient(3), hessian(6)
  end type influence_type

  type :: coupling_type
    integer :: n
    type(influence_type) :: list(max_zones*(max_zones - 1)/2)
    real(dp) :: c(max_zones, max_zones)
  end type coupling_type

  !> S over q in one cell, at one u and one roll angle.
  type :: line_type
    integer :: cell
    real(dp) :: c(4)
  end type line_type

  !> Whether a pose is on the table.
  enum, bind(c)
    enumerator :: inside = 0, outside_lateral, outside_roll, outside_depth
    enumerator :: outside_law        ! S is negative: splines may oscillate outside the poses that runs reach
  end enum

  !> A zone that would pull counts as open if the force is at most this one, to which errors are relative [N].
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
    roll%angle = angle
    opposite%angle = -angle
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
    type(touching_type) :: zones(max_zones)
    type(coupling_type) :: coupling
    integer :: i, n, branch
    logical :: ok

    energy = 0
    gradient = 0
    hessian = 0
    status = inside
    n = 0
    do i = 1, size(t%zones)
      call find_touching(t%zones(i), pose, roll, tangent, zones(n + 1), status)
      if (status /= inside) return
      if (zones(n + 1)%p <= 0) cycle
      n = n + 1
      zones(n)%zone = i
      if (n == max_zones) exit
    end do
    if (n == 0) return
    coupling%n = 0
    if (n > 1 .and. allocated(t%pairs)) call find_influence(t, roll, tangent, n, zones, coupling)
    if (coupling%n > 0) then
      call press_together(t, roll, n, coupling%c(:n, :n), zones, ok)
      if (.not. ok) status = outside_law
      if (.not. ok) return
    end if
    do i = 1, n
      call zone_potential(t%zones(zones(i)%zone), roll, tangent, zones(i), status)
      if (status /= inside) return
    end do
    if (coupling%n > 0) call add_coupling(n, tangent, coupling, zones, hessian)
    do i = 1, n
      associate (z => zones(i))
        if (z%energy <= 0) cycle
        branch = merge(2, 1, on_flange(t, z))
        energy(branch) = energy(branch) + z%energy
        gradient(:, branch) = gradient(:, branch) + z%gradient
        if (tangent) hessian = hessian + z%hessian
      end associate
    end do
  end subroutine wheel_potential

  !> Whether a zone's contact is the flange's: its contact angle is at least the threshold, or it is on the flange's tip.
  pure logical function on_flange(t, z)
    type(table_type), intent(in) :: t
    type(touching_type), intent(in) :: z

    on_flange = z%gradient(1)*t%threshold(1) + z%gradient(2)*t%threshold(2) >= 0 .or. z%u > t%zones(z%zone)%tip
  end function on_flange

  !> Find the penetration of a zone in a pose; it is not positive if the zone does not touch.
  pure subroutine find_touching(t, pose, roll, tangent, z, status)
    type(zone_table), intent(in) :: t
    real(dp), intent(in) :: pose(3)
    type(roll_type), intent(in) :: roll
    logical, intent(in) :: tangent         !! whether second derivatives are wanted
    type(touching_type), intent(inout) :: z
    integer, intent(out) :: status
    real(dp) :: w

    status = inside
    z%p = 0
    z%arm = pole_arm(t, roll)
    call zone_coordinates(t, pose, z%arm, z%u, w)
    if (.not. axis_holds(t%u, z%u)) then
      ! NaN is neither above nor below the ceiling, so it is not on the table.
      if (.not. (pose(2) + z%arm(2) > t%ceiling .and. abs(pose(1)) <= huge(w))) status = outside_lateral
      return
    end if
    if (w >= t%h_bound(int((z%u - t%u%low)*t%bins_per_metre) + 1, roll%basis%i)) return
    call axis_basis(t%u, z%u, z%basis, tangent)
    call spline_2d(t%h, roll%basis, z%basis, tangent, z%h)
    z%p = z%h(1) - w
    z%shift = 0
    if (z%p <= 0) return
    if (.not. axis_holds(t%q, sqrt(z%p))) status = outside_depth
  end subroutine find_touching

  !> Compute energy, gradient and Hessian of one zone whose surface the other zones have lowered by `shift`. The energy is 0 if
  !> the zone carries nothing.
  pure subroutine zone_potential(t, roll, tangent, z, status)
    type(zone_table), intent(in) :: t
    type(roll_type), intent(in) :: roll    !! roll of the pose
    logical, intent(in) :: tangent         !! whether the Hessian is wanted
    type(touching_type), intent(inout) :: z
    integer, intent(out) :: status
    type(basis_type) :: bq
    real(dp) :: p, q, v(10), f(10)

    status = inside
    z%energy = 0
    p = z%p - z%shift
    if (.not. p > 0) return
    q = sqrt(p)
    call axis_basis(t%q, q, bq, tangent)
    call spline_3d(t%s, bq, roll%basis, z%basis, tangent, v)  ! S, S_q, S_r, S_u, S_qq, S_qr, S_qu, S_rr, S_ru, S_uu

    ! F(u, roll, p) = q^5 S(u, roll, q), q = sqrt(p):
    ! F, F_p, F_r, F_u, F_pp, F_pr, F_pu, F_rr, F_ru, F_uu.
    f(1) = q**5*v(1)
    f(2) = q**3*(2.5_dp*v(1) + 0.5_dp*q*v(2))
    if (f(1) <= 0 .or. f(2) <= 0) then
      if (max(-f(2), -2.5_dp*f(1)/p) > largest_pull) status = outside_law
      return
    end if
    z%energy = f(1)
    f(3:4) = q**5*v(3:4)
    f(5:) = 0
    if (tangent) then
      f(5) = q*(3.75_dp*v(1) + 2.25_dp*q*v(2) + 0.25_dp*p*v(5))
      f(6:7) = q**3*(2.5_dp*v(3:4) + 0.5_dp*q*v(6:7))
      f(8:10) = q**5*v(8:10)
    end if
    z%force = f(2)
    call to_pose(t, z%arm, z%h, f, tangent, z%gradient, z%hessian)
    if (.not. tangent) return
    z%stiffness = f(5)
    z%of_force = covector(t, z%arm, f(7) + f(5)*z%h(3), -f(5), f(6) + f(5)*z%h(2))
  end subroutine zone_potential

  !> Find how far the zones lower the surface of each other: shift_i = sum c_ij f_j, with the force f_j of zone j on its
  !> lowered surface, by Newton's method. `ok` is false if it does not converge.
  pure subroutine press_together(t, roll, n, c, zones, ok)
    type(table_type), intent(in) :: t
    type(roll_type), intent(in) :: roll
    integer, intent(in) :: n
    real(dp), intent(in) :: c(n, n)             !! influences, 0 on the diagonal [m/N]
    type(touching_type), intent(inout) :: zones(:)
    logical, intent(out) :: ok
    real(dp), parameter :: close = 1e-10_dp     ! last step [m]: Newton's method squares the error once more
    integer, parameter :: patience = 12, most = 60
    type(line_type) :: line(n)
    real(dp) :: f(n), k(n), step(n), a(n, n)
    logical :: open(n)
    integer :: i, j, iter

    line%cell = 0
    f = 0
    open = .true.
    ! The deepest zone first, each after those before it have lowered its surface.
    do j = 1, n
      i = maxloc(zones(:n)%p, 1, open)
      open(i) = .false.
      zones(i)%shift = dot_product(c(:, i), f)
      call press_line(t%zones(zones(i)%zone), roll, zones(i), line(i), f(i), k(i))
    end do
    do iter = 1, most
      do i = 1, n
        call press_line(t%zones(zones(i)%zone), roll, zones(i), line(i), f(i), k(i))
      end do
      step = matmul(c, f) - zones(:n)%shift
      do j = 1, n
        a(:, j) = c(:, j)*k(j)
        a(j, j) = a(j, j) + 1
      end do
      call solve_small(n, a, step)
      if (iter > patience) step = step/2
      zones(:n)%shift = max(0.0_dp, zones(:n)%shift + step)
      ok = all(abs(step) < close)
      if (ok) return
    end do
  end subroutine press_together

  !> Compute the forces [N] of the zones of the left wheel along w in a pose, and how far the other zones lower the surface of
  !> each [m], for given influences on each other; 0 where no solution is found.
  pure subroutine coupled_forces(t, pose, roll, influence, force, shift)
    type(table_type), intent(in) :: t
    real(dp), intent(in) :: pose(3)
    type(roll_type), intent(in) :: roll
    real(dp), intent(in) :: influence(:, :)     !! (zone, zone) [m/N]
    real(dp), intent(out) :: force(:), shift(:) !! (zone)
    type(touching_type) :: zones(max_zones)
    integer :: place(max_zones), i, n, status
    logical :: ok

    shift = 0
    force = 0
    n = 0
    do i = 1, size(t%zones)
      call find_touching(t%zones(i), pose, roll, .false., zones(n + 1), status)
      if (status /= inside .or. zones(n + 1)%p <= 0) cycle
      n = n + 1
      zones(n)%zone = i
      if (n == max_zones) exit
    end do
    if (n == 0) return
    place(:n) = zones(:n)%zone
    call press_together(t, roll, n, influence(place(:n), place(:n)), zones, ok)
    if (.not. ok) return
    do i = 1, n
      call zone_potential(t%zones(zones(i)%zone), roll, .false., zones(i), status)
      if (zones(i)%energy <= 0) cycle
      shift(zones(i)%zone) = zones(i)%shift
      force(zones(i)%zone) = zones(i)%force
    end do
  end subroutine coupled_forces

  !> Return the influence of the zones of a pair on each other in a pose [m/N].
  pure real(dp) function pair_influence(t, pair, pose, roll) result(c)
    type(table_type), intent(in) :: t
    type(pair_table), intent(in) :: pair
    real(dp), intent(in) :: pose(3)
    type(roll_type), intent(in) :: roll
    type(touching_type) :: z
    type(basis_type) :: bp, br, bu
    real(dp) :: v(10)
    integer :: status

    c = 0
    call find_touching(t%zones(pair%zone(2)), pose, roll, .false., z, status)
    if (status /= inside .or. z%p <= 0) return
    call axis_basis(pair%p, z%p, bp, .false.)
    call axis_basis(pair%roll, roll%angle, br, .false.)
    call axis_basis(pair%u, z%u, bu, .false.)
    call spline_3d(pair%c, bp, br, bu, .false., v)
    c = max(0.0_dp, v(1))
  end function pair_influence

  !> Influences of the zones on each other [m/N], 0 on the diagonal, and their derivatives.
  pure subroutine find_influence(t, roll, tangent, n, zones, coupling)
    type(table_type), intent(in) :: t
    type(roll_type), intent(in) :: roll
    logical, intent(in) :: tangent
    integer, intent(in) :: n
    type(touching_type), intent(in) :: zones(:)
    type(coupling_type), intent(inout) :: coupling
    type(basis_type) :: bp, br, bu
    real(dp) :: v(10)
    integer :: i, j, m

    coupling%c(:n, :n) = 0
    do m = 1, size(t%pairs)
      associate (pair => t%pairs(m))
        i = findloc(zones(:n)%zone, pair%zone(1), 1)
        if (i == 0) cycle
        j = findloc(zones(:n)%zone, pair%zone(2), 1)
        if (j == 0) cycle
        call axis_basis(pair%p, zones(j)%p, bp, tangent)
        call axis_basis(pair%roll, roll%angle, br, tangent)
        call axis_basis(pair%u, zones(j)%u, bu, tangent)
        call spline_3d(pair%c, bp, br, bu, tangent, v)
        if (v(1) <= 0) cycle
        coupling%n = coupling%n + 1
        associate (one => coupling%list(coupling%n))
          one%first = i
          one%second = j
          one%hessian = 0
          call to_pose(t%zones(pair%zone(2)), zones(j)%arm, zones(j)%h, v, tangent, one%gradient, one%hessian)
        end associate
        coupling%c(i, j) = v(1)
        coupling%c(j, i) = v(1)
      end associate
    end do
  end subroutine find_influence

  !> Force f [N] of a zone on its lowered surface, and stiffness k [N/m]; `line` keeps S over q from one call to the next.
  pure subroutine press_line(t, roll, z, line, f, k)
    type(zone_table), intent(in) :: t
    type(roll_type), intent(in) :: roll
    type(touching_type), intent(in) :: z
    type(line_type), intent(inout) :: line
    real(dp), intent(out) :: f, k
    type(basis_type) :: bq
    real(dp) :: p, q, s(0:2)

    f = 0
    k = 0
    p = z%p - z%shift
    if (.not. p > 0) return
    q = sqrt(p)
    call axis_basis(t%q, q, bq)
    if (line%cell /= bq%i) call spline_3d_line(t%s, bq%i, roll%basis, z%basis, line%c)
    line%cell = bq%i
    s = matmul(line%c, bq%b)
    f = q**3*(2.5_dp*s(0) + 0.5_dp*q*s(1))
    k = max(0.0_dp, q*(3.75_dp*s(0) + 2.25_dp*q*s(1) + 0.25_dp*p*s(2)))
    if (f > 0 .and. s(0) > 0) return
    f = 0
    k = 0
  end subroutine press_line

  !> Add to every zone its half of the energy and of the gradient of the coupling; the coupling's Hessian is that of the sum.
  !>
  !> The energy is sum F_i(q, s_i) + 1/2 sum c_ij f_i f_j with f_i = -dF_i/ds_i and s = C f, its gradient
  !> sum grad F_i - 1/2 sum grad c_ij f_i f_j. The Hessian follows from (I + K C) df = (M - K V) dq and ds = C df + V dq,
  !> where K has the stiffnesses, the rows of M are the gradients of f_i, and V_i = sum f_j grad c_ij.
  pure subroutine add_coupling(n, tangent, coupling, zones, hessian)
    integer, intent(in) :: n
    logical, intent(in) :: tangent
    type(coupling_type), intent(in) :: coupling
    type(touching_type), intent(inout) :: zones(:)
    real(dp), intent(inout) :: hessian(6)
    real(dp) :: f(n), v(3, n), a(n, n), df(n, 3), ds(n, 3), full(3, 3)
    integer :: i, j, m

    f = merge(zones(:n)%force, 0.0_dp, zones(:n)%energy > 0)
    v = 0
    do m = 1, coupling%n
      associate (one => coupling%list(m))
        v(:, one%first) = v(:, one%first) + f(one%second)*one%gradient
        v(:, one%second) = v(:, one%second) + f(one%first)*one%gradient
        if (tangent) hessian = hessian - f(one%first)*f(one%second)*one%hessian
      end associate
    end do
    do i = 1, n
      if (f(i) <= 0) cycle
      zones(i)%energy = zones(i)%energy + f(i)*zones(i)%shift/2
      zones(i)%gradient = zones(i)%gradient - f(i)/2*v(:, i)
    end do
    if (.not. tangent) return
    associate (c => coupling%c)
      do i = 1, n
        a(i, :) = 0
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
        ds(:, j) = matmul(c(:n, :n), df(:, j)) + v(j, :)
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

  !> Solve a x = b, with b on entry and x on return in `x`; the diagonal of a is larger than the rest.
  pure subroutine solve_small(n, a, x)
    integer, intent(in) :: n
    real(dp), intent(in) :: a(n, n)
    real(dp), intent(inout) :: x(n)
    real(dp) :: b(n, n)
    integer :: i, j

    b = a
    do i = 1, n
      do j = i + 1, n
        x(j) = x(j) - b(j, i)/b(i, i)*x(i)
        b(j, i + 1:) = b(j, i + 1:) - b(j, i)/b(i, i)*b(i, i + 1:)
      end do
    end do
    do i = n, 1, -1
      x(i) = (x(i) - dot_product(b(i, i + 1:), x(i + 1:)))/b(i, i)
    end do
  end subroutine solve_small

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
    gradient = covector(t, arm, eu, ew, er)
    if (.not. tangent) return
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

end module contact_table