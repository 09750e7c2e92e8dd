!> Fits a plane curve to measured points.
!>
!> Without smoothing, cubic splines interpolate the points over the cumulative chord length
!> (arc length to within 1e-6).  With smoothing they minimise
!>
!>     sum |r(s_i) - p_i|^2 + lambda integral |r'''|^2 ds
!>
!> the penalty being on the variation of the curvature: second derivatives, which
!> decide contact, come out smooth, and an arc of constant curvature is not
!> flattened as by a penalty on the curvature itself.  For cubic B-splines on
!> equally spaced knots the integral is the sum of the squared third differences of
!> the coefficients (P. H. C. Eilers, B. D. Marx, "Flexible smoothing with B-splines
!> and penalties", Statistical Science 11 (1996) 89-121).  lambda follows from the
!> distance that is asked for (C. H. Reinsch, Numer. Math. 10 (1967) 177-183); a
!> distance just below the points' noise would let the curve follow the noise, and
!> is raised to it, by at most a quarter.  The noise is that of generalised
!> cross-validation (P. Craven, G. Wahba, Numer. Math. 31 (1979) 377-403).
!> Station s_i is the arc length of the curve up to the foot of point p_i (J. Hoschek,
!> "Intrinsic parametrization for approximation", CAGD 5 (1988) 27-31).
!>
!> Where no distance is asked for, the points decide.  Points that are exact, or rounded
!> to fractions of a micrometre, are interpolated; others are smoothed by their noise.
!> The distance is raised further as long as the curve is wavy: waves shorter than a
!> contact patch and its surroundings, whose curvature exceeds that of a rail's crown,
!> would part every patch into several.
module curve_fit
  use curve, only: cubic_point, curve_frame, curve_type, extend
  use errors, only: error_type, fatal_error
  use kinds, only: dp, pi
  implicit none
  private
  public :: fit_curve

  !> Share by which a curve may exceed the distance that is asked for, where the points' noise exceeds it.
  real(dp), parameter :: leeway = 0.25_dp
  !> Noise that needs no smoothing [m]: with points 0.25 mm apart it changes the mean curvature over a patch by less than
  !> the curvature of a tread.
  real(dp), parameter :: negligible = 0.1e-6_dp
  integer, parameter :: most_rounds = 4  !! of stations and splines in turn: stations move by the square of the noise
  real(dp), parameter :: most_wavy = 0.25_dp         !! waviness up to which a curve is smooth
  real(dp), parameter :: raise = 1.5_dp              !! of the distance, as long as the curve is wavy
  real(dp), parameter :: least = 1e-6_dp, largest = 0.2e-3_dp   !! distances tried for waves [m]

  interface
    subroutine dpbsv(uplo, n, kd, nrhs, ab, ldab, b, ldb, info)
      import :: dp
      character, intent(in) :: uplo
      integer, intent(in) :: n, kd, nrhs, ldab, ldb
      real(dp), intent(inout) :: ab(ldab, *), b(ldb, *)
      integer, intent(out) :: info
    end subroutine dpbsv
  end interface

contains

  !> Fit a curve to points.  `smoothing` is the root-mean-square distance [m] that the curve may keep from them.  Where it
  !> is 0 the curve interpolates the points; where it is negative their noise and waviness decide.  Fails where the system
  !> of equations is singular.
  subroutine fit_curve(y, z, smoothing, c, error)
    real(dp), intent(in) :: y(:), z(:)     !! [m], in the order of the walk along the curve
    real(dp), intent(in) :: smoothing
    type(curve_type), intent(out) :: c
    type(error_type), allocatable, intent(out) :: error
    real(dp) :: noise, advised

    call smooth(y, z, 0.0_dp, c, error)
    noise = c%noise
    advised = merge(noise, 0.0_dp, noise > negligible)
    call fit_at(advised)
    do while (.not. allocated(error))
      if (waviness(c) <= most_wavy .or. advised > largest) exit
      advised = max(least, raise*advised)
      call fit_at(advised)
    end do
    if (smoothing >= 0 .and. abs(smoothing - advised) > 0) call fit_at(smoothing)
    c%advised = advised

  contains

    subroutine fit_at(distance)
      real(dp), intent(in) :: distance

      if (allocated(error)) deallocate (error)
      if (distance > 0) then
        call smooth(y, z, distance, c, error)
      else
        call interpolate(y, z, c, error)
      end if
      if (allocated(error)) return
      call extend(c)
      c%distance = distance
      c%noise = noise
    end subroutine fit_at

  end subroutine fit_curve

  !> Waviness of a curve: how much its curvature differs from the mean over a patch and its surroundings, relative to that
  !> mean or to the curvature of a rail's crown, on half of the curve's running surface.
  function waviness(c)
    type(curve_type), intent(in) :: c
    real(dp) :: waviness
    real(dp), parameter :: pitch = 0.25e-3_dp        ! [m]
    integer, parameter :: patch = 4, around = 16     ! half of 2 mm and 8 mm in pitches
    real(dp), parameter :: crown = 3                 ! curvature of a rail's crown [1/m]
    real(dp), parameter :: steepest = 70*pi/180      ! of the running surface [rad]
    real(dp), allocatable :: angle(:), curvature(:), wave(:)
    real(dp) :: r(2), here, mean
    integer :: n, i, k, found

    waviness = 0
    n = int(c%last()/pitch)
    if (n < 4*around) return
    allocate (angle(n), curvature(n), wave(n))
    do i = 1, n
      call curve_frame(c, (i - 0.5_dp)*pitch, r, angle(i), here)
      if (i > 1) angle(i) = angle(i) - 2*pi*anint((angle(i) - angle(i - 1))/(2*pi))
    end do
    curvature = 0
    do i = 1 + patch, n - patch
      curvature(i) = (angle(i + patch) - angle(i - patch))/(2*patch*pitch)
    end do
    found = 0
    do i = 1 + patch + around, n - patch - around
      if (abs(angle(i)) > steepest) cycle
      mean = sum(curvature(i - around:i + around))/(2*around + 1)
      found = found + 1
      wave(found) = abs(curvature(i) - mean)/max(crown, abs(mean)/2)
    end do
    ! The median: half of the values are at most as large.
    do i = 1, found
      k = count(wave(:found) <= wave(i))
      if (2*k >= found .and. 2*count(wave(:found) < wave(i)) < found) waviness = wave(i)
    end do
  end function waviness

  !> The natural cubic spline through the points.
  subroutine interpolate(y, z, c, error)
    real(dp), intent(in) :: y(:), z(:)
    type(curve_type), intent(out) :: c
    type(error_type), allocatable, intent(out) :: error
    real(dp) :: f2(size(y), 2), ab(3, size(y) - 2), rhs(size(y) - 2, 2), r(size(y) - 1), q(3)
    integer :: n, i, info

    n = size(y)
    c%n = n
    allocate (c%s(0:n + 1), c%a(2, 4, 0:n))
    c%s(1:n) = chord_stations(y, z)
    r = 1/(c%s(2:n) - c%s(1:n - 1))
    ab = 0
    do i = 1, n - 2
      q = [r(i), -r(i) - r(i + 1), r(i + 1)]
      rhs(i, 1) = dot_product(q, y(i:i + 2))
      rhs(i, 2) = dot_product(q, z(i:i + 2))
      ab(3, i) = (1/r(i) + 1/r(i + 1))/3
      if (i > 1) ab(2, i) = 1/(6*r(i))
    end do
    call dpbsv('U', n - 2, 2, 2, ab, 3, rhs, n - 2, info)
    if (info /= 0) then
      call fatal_error(error, 'spline: singular system, repeated points?')
      return
    end if
    f2 = 0
    f2(2:n - 1, :) = rhs
    do i = 1, n - 1
      c%a(1, :, i) = cubic(y(i:i + 1), f2(i:i + 1, 1), c%s(i + 1) - c%s(i))
      c%a(2, :, i) = cubic(z(i:i + 1), f2(i:i + 1, 2), c%s(i + 1) - c%s(i))
    end do
  end subroutine interpolate

  !> Cumulative chord length up to every point.
  pure function chord_stations(y, z) result(s)
    real(dp), intent(in) :: y(:), z(:)
    real(dp) :: s(size(y))
    integer :: i

    s(1) = 0
    do i = 2, size(y)
      s(i) = s(i - 1) + hypot(y(i) - y(i - 1), z(i) - z(i - 1))
    end do
  end function chord_stations

  !> The penalised spline at an rms distance from the points; with a distance of 0 only their noise.
  subroutine smooth(y, z, distance, c, error)
    real(dp), intent(in) :: y(:), z(:), distance
    type(curve_type), intent(out) :: c
    type(error_type), allocatable, intent(out) :: error
    real(dp), parameter :: finest = 0.25e-3_dp, coarsest = 0.5e-3_dp   ! between knots [m]
    real(dp) :: p(size(y), 2), s(size(y)), h
    real(dp), allocatable :: beta(:, :)
    integer :: n, m, i, round

    n = size(y)
    p(:, 1) = y
    p(:, 2) = z
    s = chord_stations(y, z)
    m = min(max(8, nint(s(n)/max(finest, min(s(n)/(n - 1), coarsest)))), n)
    do round = 1, most_rounds
      if (round > 1) then
        call find_feet(c, p, s)
        call sort_along(s, p)
        s = s - s(1)
      end if
      h = s(n)/m
      if (allocated(c%s)) deallocate (c%s, c%a, beta)
      allocate (c%s(0:m + 2), c%a(2, 4, 0:m + 1), beta(m + 3, 2))
      call penalised(s/h, p, distance, beta, c%noise, error)
      if (allocated(error) .or. distance <= 0) return
      c%n = m + 1
      c%s(1:m + 1) = [((i - 1)*h, i=1, m + 1)]
      do i = 1, m
        c%a(:, 1, i) = (beta(i, :) + 4*beta(i + 1, :) + beta(i + 2, :))/6
        c%a(:, 2, i) = (beta(i + 2, :) - beta(i, :))/(2*h)
        c%a(:, 3, i) = (beta(i, :) - 2*beta(i + 1, :) + beta(i + 2, :))/(2*h**2)
        c%a(:, 4, i) = (beta(i + 3, :) - beta(i, :) + 3*(beta(i + 1, :) - beta(i + 2, :)))/(6*h**3)
      end do
      ! A curve that is to follow the noise has no feet worth finding.
      if (c%noise > (1 + leeway)*distance) exit
    end do
  end subroutine smooth

  !> Coefficients of cubic B-splines on the knots 0, 1, ... with the least third differences at an rms distance from
  !> points p at stations x, and the noise of the points.  With a distance of 0 the coefficients are not those of a curve.
  subroutine penalised(x, p, distance, beta, noise, error)
    real(dp), intent(in) :: x(:)           !! [intervals]
    real(dp), intent(in) :: p(:, :)        !! (point, coordinate)
    real(dp), intent(in) :: distance
    real(dp), intent(out) :: beta(:, :)    !! (coefficient, coordinate)
    real(dp), intent(out) :: noise         !! rms, unit of p
    type(error_type), allocatable, intent(out) :: error
    real(dp), parameter :: differences(4) = [-1, 3, -3, 1]
    real(dp), parameter :: range = 40      ! width in ln lambda: beyond it rounding decides
    integer, parameter :: trials = 30
    ! Arrays of this size do not go on the stack, whose end no program survives.
    real(dp), allocatable :: fit(:, :), bend(:, :), ab(:, :), rhs(:, :), w(:, :)
    real(dp) :: low, high, score, best, rms, free, asked
    integer, allocatable :: first(:)
    integer :: k, i, j, l
    logical :: solved

    k = size(beta, 1)
    allocate (fit(4, k), bend(4, k), ab(4, k), rhs(k, 2), w(4, size(x)), first(size(x)))
    fit = 0
    rhs = 0
    do i = 1, size(x)
      first(i) = max(1, min(1 + int(x(i)), k - 3))
      w(:, i) = weights(x(i) - (first(i) - 1))
      do j = 1, 4
        rhs(first(i) + j - 1, :) = rhs(first(i) + j - 1, :) + w(j, i)*p(i, :)
        do l = 1, j
          fit(4 + l - j, first(i) + j - 1) = fit(4 + l - j, first(i) + j - 1) + w(j, i)*w(l, i)
        end do
      end do
    end do
    bend = 0
    do i = 1, k - 3
      do j = 1, 4
        do l = 1, j
          bend(4 + l - j, i + j - 1) = bend(4 + l - j, i + j - 1) + differences(j)*differences(l)
        end do
      end do
    end do

    ! Generalised cross-validation finds the noise.
    low = log(1e-7_dp*sum(fit(4, :))/sum(bend(4, :)))
    best = huge(best)
    noise = 0
    do i = 0, trials
      call solve(low + i*range/trials)
      if (.not. solved) cycle
      free = 1 - trace(ab, fit)/size(x)
      if (free < 1e-3_dp) cycle
      score = (rms/free)**2
      if (score >= best) cycle
      best = score
      noise = rms/sqrt(free)
    end do
    if (distance <= 0) return
    asked = max(distance, min(noise, (1 + leeway)*distance))
    ! The distance grows monotonically with lambda.
    high = low + range
    do i = 1, 60
      call solve((low + high)/2)
      ! Where rounding spoils the system, lambda is far too large.
      if (.not. solved .or. rms > asked) then
        high = (low + high)/2
      else
        low = (low + high)/2
      end if
      if (high - low < 1e-9_dp) exit
    end do
    call solve(low)
    if (.not. solved) call fatal_error(error, 'smoothing spline: singular system, too few points?')

  contains

    !> Find the coefficients for a logarithm of lambda, their rms distance, and the triangular factor of the system.
    subroutine solve(log_lambda)
      real(dp), intent(in) :: log_lambda
      integer :: q, info

      ab = fit + exp(log_lambda)*bend
      beta = rhs
      call dpbsv('U', k, 3, 2, ab, 4, beta, k, info)
      solved = info == 0
      if (.not. solved) return
      rms = 0
      do q = 1, size(x)
        rms = rms + sum((matmul(w(:, q), beta(first(q):first(q) + 3, :)) - p(q, :))**2)
      end do
      rms = sqrt(rms/size(x))
    end subroutine solve

    !> The four B-splines of an interval at t in it, 0 to 1.
    pure function weights(t) result(b)
      real(dp), intent(in) :: t
      real(dp) :: b(4)

      b = [(1 - t)**3, 4 - 6*t**2 + 3*t**3, 1 + 3*t + 3*t**2 - 3*t**3, t**3]/6
    end function weights

  end subroutine penalised

  !> Trace of (U^T U)^-1 F for band matrices, U upper triangular and F symmetric: only the band of
  !> the inverse is needed (K. Takahashi et al., 1973; M. F. Hutchinson, F. R. de Hoog, "Smoothing noisy
  !> data with spline functions", Numer. Math. 47 (1985) 99-106).
  pure real(dp) function trace(u, f)
    real(dp), intent(in) :: u(:, :), f(:, :)   !! upper bands as LAPACK stores them, diagonal last
    real(dp), allocatable :: z(:, :)
    real(dp) :: x
    integer :: i, j, k, d

    d = size(u, 1)
    allocate (z(d, size(u, 2)))
    trace = 0
    do i = size(u, 2), 1, -1
      do j = min(i + d - 1, size(u, 2)), i, -1
        x = 0
        if (j == i) x = 1/u(d, i)
        do k = i + 1, min(i + d - 1, size(u, 2))
          x = x - u(d + i - k, k)*z(d - abs(k - j), max(k, j))
        end do
        z(d + i - j, j) = x/u(d, i)
        trace = trace + merge(1, 2, i == j)*z(d + i - j, j)*f(d + i - j, j)
      end do
    end do
  end function trace

  !> Arc lengths at the feet of points on a curve, found from stations nearby.
  subroutine find_feet(c, p, s)
    type(curve_type), intent(in) :: c
    real(dp), intent(in) :: p(:, :)        !! (point, coordinate) [m]
    real(dp), intent(inout) :: s(:)        !! station on entry, arc length on return [m]
    real(dp), parameter :: gauss(3) = sqrt(0.6_dp)*[-1, 0, 1], weight(3) = [5, 8, 5]/18.0_dp
    real(dp) :: length(c%n), r(2), d1(2), d2(2), x
    integer :: i, j, k

    length(1) = 0
    do i = 1, c%n - 1
      length(i + 1) = length(i) + arc(i, c%s(i + 1) - c%s(i))
    end do
    k = 1
    do i = 1, size(s)
      x = s(i)
      do j = 1, 3
        k = max(1, min(1 + int(x/c%s(2)), c%n - 1))
        call cubic_point(c%a(:, :, k), x - c%s(k), r, d1, d2)
        ! Beyond the ends the last cubic is continued.  A foot moves by less than half an interval.
        x = x + max(-c%s(2)/2, min(dot_product(p(i, :) - r, d1)/dot_product(d1, d1), c%s(2)/2))
      end do
      s(i) = length(k) + arc(k, x - c%s(k))
    end do

  contains

    !> Arc length of knot interval i up to t [m].
    real(dp) function arc(i, t)
      integer, intent(in) :: i
      real(dp), intent(in) :: t
      integer :: l

      arc = 0
      do l = 1, 3
        call cubic_point(c%a(:, :, i), t*(1 + gauss(l))/2, r, d1, d2)
        arc = arc + weight(l)*t*norm2(d1)
      end do
    end function arc

  end subroutine find_feet

  !> Sort points, which are nearly sorted, by station.
  pure subroutine sort_along(s, p)
    real(dp), intent(inout) :: s(:), p(:, :)
    real(dp) :: key, point(2)
    integer :: i, j

    do i = 2, size(s)
      key = s(i)
      point = p(i, :)
      j = i - 1
      do while (j >= 1)
        if (s(j) <= key) exit
        s(j + 1) = s(j)
        p(j + 1, :) = p(j, :)
        j = j - 1
      end do
      s(j + 1) = key
      p(j + 1, :) = point
    end do
  end subroutine sort_along

  !> Coefficients of the cubic with end values f and end second derivatives f2.
  pure function cubic(f, f2, h) result(c)
    real(dp), intent(in) :: f(2), f2(2), h
    real(dp) :: c(4)

    c = [f(1), (f(2) - f(1))/h - h*(2*f2(1) + f2(2))/6, f2(1)/2, (f2(2) - f2(1))/(6*h)]
  end function cubic

end module curve_fit
