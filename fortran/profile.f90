!> A wheel or rail profile: a text file of two columns, y and z in millimetres,
!> read as people really write them and turned into a smooth curve in metres.
module profile
  use curve, only: curve_type, fit_curve
  use errors, only: error_type, fatal_error
  use kinds, only: degree, dp
  use text, only: checksum, clip, line_type, lower, read_lines, str, to_real
  implicit none
  private
  public :: profile_type, read_profile

  type :: profile_type
    character(:), allocatable :: file      !! as named in the namelist
    character(8) :: checksum = ''          !! CRC-32 of the file's lines
    logical :: reconstruction = .false.    !! the file says that it is one
    type(curve_type) :: curve              !! y, z [m], y increasing from first to last station
  end type profile_type

  integer, parameter :: least_points = 10
  real(dp), parameter :: least_span = 10, largest_span = 1000   !! plausible widths [mm]
  real(dp), parameter :: largest_turn = 120*degree              !! at a point: more is two points exchanged

contains

  !> Read a profile.  Accepted: comments (# ! %), header words before the first
  !> number, commas, semicolons or blanks, Fortran exponents, either direction,
  !> repeated points, further columns.  Refused, with file and line: anything
  !> else that is not a number, too few points, a curve that turns back or crosses
  !> itself, widths that cannot be millimetres.
  subroutine read_profile(file, smoothing, p, error)
    character(*), intent(in) :: file
    real(dp), intent(in) :: smoothing      !! rms distance curve to points [mm]
    type(profile_type), intent(out) :: p
    type(error_type), allocatable, intent(out) :: error
    type(line_type), allocatable :: lines(:)
    real(dp), allocatable :: points(:, :)
    integer, allocatable :: at(:)          ! line of each point

    call read_lines(file, lines, error)
    if (allocated(error)) return
    p%file = file
    p%checksum = checksum(lines)
    call parse(file, lines, points, at, p%reconstruction, error)
    if (allocated(error)) return
    call check(file, points, at, error)
    if (allocated(error)) return
    if (points(1, 1) > points(1, size(points, 2))) points = points(:, size(points, 2):1:-1)
    call fit_curve(1e-3_dp*points(1, :), 1e-3_dp*points(2, :), 1e-3_dp*smoothing, p%curve, error)
    if (allocated(error)) call fatal_error(error, file//': '//error%message)
  end subroutine read_profile

  subroutine parse(file, lines, points, at, reconstruction, error)
    character(*), intent(in) :: file
    type(line_type), intent(in) :: lines(:)
    real(dp), allocatable, intent(out) :: points(:, :)   !! (2, n) [mm]
    integer, allocatable, intent(out) :: at(:)           !! line of each point
    logical, intent(out) :: reconstruction
    type(error_type), allocatable, intent(out) :: error
    character(:), allocatable :: rest
    real(dp) :: x(2)
    integer :: n, i, k, cut
    logical :: ok

    allocate (points(2, size(lines)), at(size(lines)))
    reconstruction = .false.
    n = 0
    do i = 1, size(lines)
      if (index(lower(lines(i)%text), 'reconstruction') > 0) reconstruction = .true.
      cut = scan(lines(i)%text, '#!%')
      if (cut == 0) cut = len(lines(i)%text) + 1
      rest = lines(i)%text(:cut - 1)
      do k = 1, len(rest)
        if (scan(rest(k:k), ',;') == 1) rest(k:k) = ' '
      end do
      if (len_trim(rest) == 0) cycle
      ok = .true.
      do k = 1, 2
        if (ok) call take_number(rest, x(k), ok)
      end do
      if (.not. ok) then
        if (n == 0 .and. is_words(lines(i)%text)) cycle
        call fatal_error(error, file//', line '//str(i)// &
          ': expected two numbers, y and z in mm, found "'//clip(lines(i)%text)//'"')
        return
      end if
      if (any(abs(x) > 10*largest_span)) then
        call fatal_error(error, file//', line '//str(i)//': expected millimetres, found "'// &
          clip(lines(i)%text)//'"')
        return
      end if
      if (n > 0) then
        if (hypot(x(1) - points(1, n), x(2) - points(2, n)) < 1e-6_dp) cycle
      end if
      n = n + 1
      points(:, n) = x
      at(n) = i
    end do
    points = points(:, :n)
  end subroutine parse

  !> A heading: it begins with a letter and is not a misspelt number.
  pure logical function is_words(line)
    character(*), intent(in) :: line
    character(:), allocatable :: word

    word = lower(adjustl(line))
    is_words = len(word) > 0
    if (is_words) is_words = verify(word(1:1), 'abcdefghijklmnopqrstuvwxyz"''(') == 0 &
      .and. index(word, 'nan') /= 1 .and. index(word, 'inf') /= 1
  end function is_words

  subroutine take_number(rest, x, ok)
    character(:), allocatable, intent(inout) :: rest
    real(dp), intent(out) :: x
    logical, intent(out) :: ok
    integer :: blank

    rest = adjustl(rest)
    blank = index(rest//' ', ' ')
    call to_real(rest(:blank - 1), x, ok)
    rest = rest(blank:)
  end subroutine take_number

  subroutine check(file, points, at, error)
    character(*), intent(in) :: file
    real(dp), intent(in) :: points(:, :)
    integer, intent(in) :: at(:)
    type(error_type), allocatable, intent(out) :: error
    real(dp) :: span
    integer :: n, i, j

    n = size(points, 2)
    if (n < least_points) then
      call fatal_error(error, file//': expected at least '//str(least_points)// &
        ' points, found '//str(n))
      return
    end if
    span = maxval(points(1, :)) - minval(points(1, :))
    if (span < least_span .or. span > largest_span) then
      call fatal_error(error, file//': expected y in millimetres over '//str(least_span)// &
        ' to '//str(largest_span)//' mm, found a width of '//str(span))
      return
    end if
    do i = 1, n - 3
      do j = i + 2, n - 1
        ! Bounding boxes first: the exact test runs for near neighbours only.
        if (min(points(1, i), points(1, i + 1)) > max(points(1, j), points(1, j + 1))) cycle
        if (max(points(1, i), points(1, i + 1)) < min(points(1, j), points(1, j + 1))) cycle
        if (.not. crosses(points(:, i:i + 1), points(:, j:j + 1))) cycle
        call fatal_error(error, file//': the curve crosses itself between lines '// &
          str(at(i))//' and '//str(at(j + 1)))
        return
      end do
    end do
    do i = 2, n - 1
      if (turn(points(:, i - 1:i + 1)) <= largest_turn) cycle
      call fatal_error(error, file//', line '//str(at(i))//': expected a curve that turns by at most '// &
        str(nint(largest_turn/degree))//' degrees at a point, found '//str(nint(turn(points(:, i - 1:i + 1))/degree)))
      return
    end do
  end subroutine check

  !> Angle between the two segments of three points [rad].
  pure real(dp) function turn(points)
    real(dp), intent(in) :: points(2, 3)
    real(dp) :: a(2), b(2)

    a = points(:, 2) - points(:, 1)
    b = points(:, 3) - points(:, 2)
    turn = abs(atan2(a(1)*b(2) - a(2)*b(1), dot_product(a, b)))
  end function turn

  pure logical function crosses(a, b)
    real(dp), intent(in) :: a(2, 2), b(2, 2)   !! two segments, (coordinate, end)

    crosses = side(a, b(:, 1))*side(a, b(:, 2)) <= 0 .and. side(b, a(:, 1))*side(b, a(:, 2)) <= 0 &
      .and. max(minval(a(2, :)), minval(b(2, :))) <= min(maxval(a(2, :)), maxval(b(2, :)))
  end function crosses

  pure real(dp) function side(a, point)
    real(dp), intent(in) :: a(2, 2), point(2)

    side = (a(1, 2) - a(1, 1))*(point(2) - a(2, 1)) - (a(2, 2) - a(2, 1))*(point(1) - a(1, 1))
  end function side

end module profile
