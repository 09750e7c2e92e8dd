!> A zone that lies on both sides of the border between tread and flange has two parts. The border is a point of the wheel, so
!> each load of a patch belongs to the part on which it acts.
!>
!> The table has the force, the moment and the energy of the zone, but not how its loads are spread along the wheel. They follow
!> from the overlap g(s) of the undeformed bodies. The overlap is cut into rows of the length ds. The line load q_j of a row is
!> spread evenly over 2 w_j in rolling direction, w_j = sqrt(R g_j/cos(angle)), about half of the overlap's own length there.
!> Rows carry as half-spaces do: with q >= 0, K q >= g and q.(K q - g) = 0, where
!>
!>     K_ij = 1/(pi E*) integral over the row of asinh(w_ij/|s_i - s|)/w_ij ds
!>
!> is the displacement in the middle of row i by an even load on a rectangle (A. E. H. Love, 1929). For the shares of the loads E*
!> does not matter. The force of the table is then shared out. Model 'strip' has its own loads, k g.
!>
!> A part of the force errs by at most 2 % of the wheel's force against half-spaces of many elements (tests/physics/test_parts.py).
module zone_parts
  use contact_law, only: law_type
  use curve, only: curve_point, near_interval
  use kinds, only: dp, pi
  use root_bracket, only: bracket_type
  use station_scan, only: set_depth
  use strip_law, only: modulus_near
  use wheel_rail_pair, only: least_cosine, pair_type, rail_station, wheel_station
  use zone_tables, only: roll_type
  implicit none
  private
  public :: border_type, border_of, part_zone

  !> The border between tread and flange, a point of the wheel.
  type :: border_type
    real(dp) :: s = 0                   !! its station [m]
    real(dp) :: angle = 0               !! of the wheel's tangent there, wheelset frame [rad]
    real(dp) :: foot = 0                !! station of the rail with that angle [m]
    integer :: wheel_interval = 1
  end type border_type

  ! Rows of loads on either side of the border, which lies between two of them, so that a part grows from nothing.
  integer, parameter :: on_flange = 8, on_tread = 12, rows = on_flange + on_tread
  real(dp), parameter :: stride = 1e-3_dp   ! between the points at which the ends of the overlap are looked for [m]
  ! Between two places of one zone that carry the bodies are at most this far apart [m]: zones are cut where they would be farther.
  real(dp), parameter :: near = 0.05e-3_dp

  real(dp), parameter :: least = 1e-12_dp     ! of lengths that are not 0 [m]

  !> A point of the wheel over the rail.
  type :: look_type
    real(dp) :: s = 0                   !! station of the wheel [m]
    real(dp) :: x(2) = 0                !! position relative to the axle centre, track frame [m]
    real(dp) :: along(2) = 0            !! the wheel's tangent, track frame
    real(dp) :: radius = 0              !! of the wheel [m]
    real(dp) :: depth = 0               !! inside the rail [m]
    real(dp) :: normal(2) = 0           !! of the rail
    real(dp) :: foot = 0                !! station of the rail [m]
    integer :: wheel_interval = 1, rail_interval = 1
  end type look_type

contains

  !> The border at a station of the wheel.
  pure type(border_type) function border_of(pair, s) result(border)
    type(pair_type), intent(in) :: pair
    real(dp), intent(in) :: s           !! [m]
    real(dp) :: r(2), d1(2), d2(2)
    integer :: i

    i = near_interval(pair%wheel, s)
    call curve_point(pair%wheel, s, i, r, d1, d2)
    border = border_type(s, atan2(d1(2), d1(1)), wheel_interval=i)
    border%foot = rail_station(pair, border%angle)
  end function border_of

  !> Part the gradient of a zone between tread and flange. `share` is the flange's share of the loads, from 0 to 1.
  pure subroutine part_zone(law, border, first, last, centre, roll, depth, lowered, gradient, share, parts)
    type(law_type), intent(in) :: law
    type(border_type), intent(in) :: border
    integer, intent(in) :: first, last  !! stations of the zone
    real(dp), intent(in) :: centre(2)   !! position of the axle [m]
    type(roll_type), intent(in) :: roll
    real(dp), intent(in) :: depth       !! penetration of the zone into the lowered surface [m]
    real(dp), intent(in) :: lowered     !! by which other zones lower the surface [m]
    real(dp), intent(in) :: gradient(3) !! of the zone [N, N, N m]
    real(dp), intent(out) :: share
    real(dp), intent(out) :: parts(3, 2)   !! of tread and flange
    type(look_type) :: at, row(rows)
    real(dp) :: load(rows), ds(rows), ends(2), angle, zone_end, s
    logical :: carries(2)
    integer :: j

    associate (pair => law%side%pair)
      at%s = border%s
      at%wheel_interval = border%wheel_interval
      at%foot = border%foot
      at%rail_interval = near_interval(pair%rail, at%foot)
      call look(pair, centre, roll, lowered, border%s, at)
      ! All loads are on the side to which the force points, unless the other side may carry, too.
      angle = atan2(gradient(1), -gradient(2)) - roll%angle
      share = merge(1, 0, angle > border%angle)
      parts = reshape([(1 - share)*gradient, share*gradient], [3, 2])
      if (at%depth < -near) return
      if (law%model /= 'strip') then
        zone_end = pair%s(merge(last, first, angle > border%angle))
        if (.not. may_carry(pair, centre, roll, lowered, at, zone_end, wheel_station(pair, angle), &
          norm2(gradient(:2))/(pi*law%e_star), depth)) return
      end if
      call find_end(pair, centre, roll, lowered, at, pair%s(first), ends(1), carries(1))
      call find_end(pair, centre, roll, lowered, at, pair%s(last), ends(2), carries(2))
      if (.not. all(carries)) return
      ds(on_flange:1:-1) = (border%s - ends(1))*lengths(on_flange)
      ds(on_flange + 1:) = (ends(2) - border%s)*lengths(on_tread)
      s = ends(1)
      do j = 1, rows
        call look(pair, centre, roll, lowered, s + ds(j)/2, at)
        row(j) = at
        s = s + ds(j)
      end do
      if (law%model == 'strip') then
        do j = 1, rows
          load(j) = ds(j)*max(row(j)%depth, 0.0_dp)*modulus_near(pair, row(j)%s, law%e_star, roll%angle)
        end do
      else
        call press_rows(row, ds, load)
      end if
      if (any(load > 0)) call share_out(row, load, gradient, share, parts)
    end associate
  end subroutine part_zone

  !> Lengths of n rows from the border outwards, which add up to 1.
  pure function lengths(n)
    integer, intent(in) :: n
    real(dp) :: lengths(n)
    real(dp), parameter :: power = 1.5_dp   ! rows are shorter near the border
    integer :: i

    lengths = [((real(i, dp)/n)**power - (real(i - 1, dp)/n)**power, i=1, n)]
  end function lengths

  !> Look at the point of the wheel at a station; the point of an earlier look is a guess.
  pure subroutine look(pair, centre, roll, lowered, s, at)
    type(pair_type), intent(in) :: pair
    real(dp), intent(in) :: centre(2), lowered, s
    type(roll_type), intent(in) :: roll
    type(look_type), intent(inout) :: at
    real(dp) :: r(2), d1(2), d2(2), point(2, 1), foot(1), depth(1), normal(2, 1), rate(1), step(1)
    integer :: interval(1)

    foot = at%foot + (s - at%s)
    interval = at%rail_interval
    at%s = s
    call curve_point(pair%wheel, s, at%wheel_interval, r, d1, d2)
    at%x = turned(r)
    at%along = turned(d1)
    at%radius = -r(2)
    point(:, 1) = centre + at%x
    call set_depth(pair%rail, 1, point, foot, interval, depth, normal, rate, step)
    at%foot = foot(1)
    at%rail_interval = interval(1)
    at%depth = depth(1) - lowered
    at%normal = normal(:, 1)

  contains

    !> A vector of the wheelset frame in the track frame.
    pure function turned(v)
      real(dp), intent(in) :: v(2)
      real(dp) :: turned(2)

      turned = [v(1)*roll%cosine - v(2)*roll%sine, v(1)*roll%sine + v(2)*roll%cosine]
    end function turned

  end subroutine look

  !> Whether the bodies may touch between the border and the end of the zone, though the force acts on the other side. There the
  !> force displaces the surface by more than F/(pi E*)/sqrt(d^2 + x^2) at the distance d, with the mean square x^2 over the length
  !> of the patch in rolling direction, for 1/sqrt is convex; the patch is an ellipse with at most 0.7 of its overlap's square.
  pure logical function may_carry(pair, centre, roll, lowered, border, zone_end, station, lift, depth)
    type(pair_type), intent(in) :: pair
    real(dp), intent(in) :: centre(2), lowered
    type(roll_type), intent(in) :: roll
    type(look_type), intent(in) :: border
    real(dp), intent(in) :: zone_end, station   !! of the end and of the force [m]
    real(dp), intent(in) :: lift        !! F/(pi E*) [m^2]
    real(dp), intent(in) :: depth       !! of the patch [m]
    real(dp), parameter :: square = 0.7_dp*2/5, sure = 0.85_dp
    type(look_type) :: at
    integer :: way

    way = merge(1, -1, zone_end > border%s)
    at = border
    do
      may_carry = at%depth*sqrt((at%s - station)**2 + square*at%radius*depth) > sure*lift
      if (may_carry .or. at%depth < -near .or. way*(zone_end - at%s) <= least) return
      call look(pair, centre, roll, lowered, at%s + way*min(stride, way*(zone_end - at%s)), at)
    end do
  end function may_carry

  !> Find the outermost station at which the bodies overlap, from the border towards the end of the zone, over stretches in which
  !> they nearly touch. `found` is false where they overlap nowhere on this side.
  pure subroutine find_end(pair, centre, roll, lowered, border, zone_end, s, found)
    type(pair_type), intent(in) :: pair
    real(dp), intent(in) :: centre(2), lowered
    type(roll_type), intent(in) :: roll
    type(look_type), intent(in) :: border
    real(dp), intent(in) :: zone_end    !! station [m]
    real(dp), intent(out) :: s
    logical, intent(out) :: found
    real(dp), parameter :: close = 1e-11_dp   ! [m]
    type(look_type) :: here, next, inside, outside   ! `inside` is the last point that overlaps, `outside` the next one
    type(bracket_type) :: range
    integer :: way, iter

    way = merge(1, -1, zone_end > border%s)
    here = border
    inside = border
    outside = border
    found = border%depth > 0
    do while (here%depth > -near .and. way*(zone_end - here%s) > least)
      next = here
      call look(pair, centre, roll, lowered, here%s + way*min(stride, way*(zone_end - here%s)), next)
      if (next%depth > 0) then
        found = .true.
        inside = next
        outside = next
      else if (here%depth > 0) then
        outside = next
      end if
      here = next
    end do
    s = inside%s
    if (.not. found .or. outside%depth > 0) return
    range = bracket_type(inside%s, inside%depth, outside%s, outside%depth)
    do iter = 1, 60
      s = range%guess()
      call look(pair, centre, roll, lowered, s, inside)
      if (abs(inside%depth) <= close .or. abs(range%b - range%a) <= close) exit
      call range%narrow(s, inside%depth)
    end do
  end subroutine find_end

  !> Loads of the rows, but for a common factor.
  pure subroutine press_rows(row, ds, load)
    type(look_type), intent(in) :: row(rows)
    real(dp), intent(in) :: ds(rows)    !! lengths [m]
    real(dp), intent(out) :: load(rows)
    real(dp), parameter :: least = 0.05_dp   ! of the largest overlap: rows beyond the overlap have a width too
    real(dp) :: K(rows, rows), half(rows), w, far, deepest
    integer :: i, j

    load = 0
    deepest = maxval(row%depth)
    if (deepest <= 0) return
    do j = 1, rows
      half(j) = sqrt(row(j)%radius*max(row(j)%depth, least*deepest)/max(row(j)%along(1), least_cosine))
    end do
    do j = 1, rows
      do i = 1, j
        w = (half(i) + half(j))/2
        if (i == j) then
          K(i, i) = 2*reach(ds(i)/2, w)/(ds(i)*w)
        else
          far = row(j)%s - row(i)%s
          K(i, j) = dot_product(row(i)%along, row(j)%along)*log((w + sqrt(far**2 + w**2))/far)/w   ! asinh(w/far)
        end if
        K(j, i) = K(i, j)
      end do
    end do
    call solve_rows(K, row%depth/deepest, load)
  end subroutine press_rows

  !> Integral of asinh(w/|x|) from 0 to x, which is not 0.
  pure real(dp) function reach(x, w)
    real(dp), intent(in) :: x, w

    reach = x*asinh(w/abs(x)) + w*asinh(x/w)
  end function reach

  !> Solve q >= 0, K q >= g, q.(K q - g) = 0 by a change of all rows that have the wrong sign at once and, if that does not end, of
  !> the last such row alone (K. G. Murty, Linear complementarity, linear and nonlinear programming, 1988).
  pure subroutine solve_rows(K, g, q)
    real(dp), intent(in) :: K(rows, rows), g(rows)
    real(dp), intent(out) :: q(rows)
    integer, parameter :: at_once = 12, most = 500
    real(dp), parameter :: tolerance = 1e-12_dp   ! of g
    logical :: on(rows), wrong(rows)
    integer :: iter

    on = g > 0
    do iter = 1, most
      call solve_on(K, g, on, q)
      wrong = merge(q < 0, g - matvec(K, q) > tolerance, on)
      if (.not. any(wrong)) return
      if (iter > at_once) then
        wrong(:findloc(wrong, .true., 1, back=.true.) - 1) = .false.
      end if
      on = on .neqv. wrong
    end do
    q = max(q, 0.0_dp)
  end subroutine solve_rows

  !> Solve K q = g in the rows that are on, with q = 0 in the others, by Cholesky's factors.
  pure subroutine solve_on(K, g, on, q)
    real(dp), intent(in) :: K(rows, rows), g(rows)
    logical, intent(in) :: on(rows)
    real(dp), intent(out) :: q(rows)
    real(dp) :: L(rows, rows), x(rows)
    integer :: place(rows), n, i, j

    n = 0
    do i = 1, rows
      if (.not. on(i)) cycle
      n = n + 1
      place(n) = i
    end do
    x(:n) = g(place(:n))
    do j = 1, n
      L(j:n, j) = K(place(j:n), place(j))
      do i = 1, j - 1
        L(j:n, j) = L(j:n, j) - L(j, i)*L(j:n, i)
      end do
      L(j:n, j) = L(j:n, j)/sqrt(max(L(j, j), tiny(1.0_dp)))
      x(j) = x(j)/L(j, j)
      x(j + 1:n) = x(j + 1:n) - x(j)*L(j + 1:n, j)
    end do
    do j = n, 1, -1
      x(j) = x(j)/L(j, j)
      do i = 1, j - 1
        x(i) = x(i) - L(j, i)*x(j)
      end do
    end do
    q = 0
    q(place(:n)) = x(:n)
  end subroutine solve_on

  !> K q, summed in one order whatever the compiler does to matmul.
  pure function matvec(K, q) result(g)
    real(dp), intent(in) :: K(rows, rows), q(rows)
    real(dp) :: g(rows)
    integer :: j

    g = 0
    do j = 1, rows
      if (abs(q(j)) > 0) g = g + q(j)*K(:, j)
    end do
  end function matvec

  !> Share out the gradient of a zone by the loads of the rows. The loads act along the rail's normals. Their resultants are turned
  !> and scaled together onto the force of the table, so that both parts keep their place, and their sum is the zone's.
  pure subroutine share_out(row, load, gradient, share, parts)
    type(look_type), intent(in) :: row(rows)
    real(dp), intent(in) :: load(rows)
    real(dp), intent(in) :: gradient(3)
    real(dp), intent(inout) :: share
    real(dp), intent(inout) :: parts(3, 2)   !! of tread and flange
    real(dp) :: sums(4, 2), amount(2), total(2), turn(2), moment(2), missing
    integer :: j, part

    sums = 0
    do j = 1, rows
      part = merge(2, 1, j <= on_flange)
      associate (n => row(j)%normal, x => row(j)%x)
        sums(:, part) = sums(:, part) + load(j)*[n, x(1)*n(2) - x(2)*n(1), x(1)*n(1) + x(2)*n(2)]
      end associate
    end do
    amount = [norm2(sums(:2, 1)), norm2(sums(:2, 2))]/(norm2(sums(:2, 1)) + norm2(sums(:2, 2)))
    share = amount(2)
    total = sums(:2, 1) + sums(:2, 2)
    ! The force of the table is minus the gradient; turn = force/total as complex numbers.
    turn = -[gradient(1)*total(1) + gradient(2)*total(2), gradient(2)*total(1) - gradient(1)*total(2)]/sum(total**2)
    moment = turn(1)*sums(3, :) + turn(2)*sums(4, :)
    missing = -gradient(3) - sum(moment)
    do part = 1, 2
      parts(:, part) = -[turn(1)*sums(1, part) - turn(2)*sums(2, part), turn(1)*sums(2, part) + turn(2)*sums(1, part), &
        moment(part) + amount(part)*missing]
    end do
  end subroutine share_out

end module zone_parts
