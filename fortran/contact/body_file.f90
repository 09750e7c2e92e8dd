!> Reads bodies: what the influence of the wheel's and of the rail's own body differs by from that of half-spaces.
!>
!> Lines of words and numbers; blank lines and lines that begin with # are comments. A file has one or more bodies:
!>
!>     body wheel               kind: wheel or rail
!>     poisson 0.28             Poisson's ratio
!>     width 3.0                of the strips [mm]
!>     strip 12.3 -25.1         middle of a strip, y and z as in the profile's file [mm]; a line for each, as along the profile
!>     wave 0.002               wave number k of the loads along the rolling direction [1/mm]; ascending, at least two
!>     0.31                     differences of influence under it: a line for each strip i, with a number for each strip j <= i
!>     0.12 0.30
!>
!> A load cos(kx) per length on strip j, even over its width, presses along the strip's normal into the body. A difference is
!> E* times the mean displacement of strip i into the body, over the load per length; less (cosine of the angle between both
!> strips) times (mean of K_0(k d) over both strips)/pi, which a half-space has, with their distance d along the profile. It has no
!> unit. E* is that of wheel and rail together, E/(2 (1 - nu^2)).
module body_file
  use body_influence, only: body_kinds, body_type, new_body, over_halfspace
  use curve, only: curve_point, curve_type
  use errors, only: error_type, refuse
  use kinds, only: dp
  use text, only: checksum, clip, line_type, read_lines, str, to_real
  implicit none
  private
  public :: read_bodies

  integer, parameter :: most_waves = 1000, fewest_strips = 4, most_strips = 500
  real(dp), parameter :: near = 0.05e-3_dp       ! strips lie so near to their profile [m]
  real(dp), parameter :: same_poisson = 1e-6_dp
  ! Bounds of the influence of a strip on itself, some millimetres along x, over that of a half-space. The ratio is about 1 on strips
  ! far from edges, and up to 4 at the edges of shipped bodies. Another sign or E*, or half-spaces not taken off, lie outside.
  real(dp), parameter :: least_ratio(2) = [0.5_dp, 1.7_dp], largest_ratio = 10

  !> A body as a file has it.
  type :: section_type
    integer :: kind = 0, line = 0, strips = 0, waves = 0
    real(dp) :: poisson = -1, width = 0          !! [1, m]
    real(dp), allocatable :: middle(:, :)        !! (2, strips) [m]
    real(dp), allocatable :: wave(:), difference(:, :, :)   !! [1/m], (wave, strip, strip)
  end type section_type

  !> A file, and the line to go on with.
  type :: cursor_type
    character(:), allocatable :: file
    type(line_type), allocatable :: lines(:)
    integer :: next = 1
  end type cursor_type

contains

  !> Read the bodies of a wheel and a rail: of each kind the first one whose strips lie on its profile. A kind that a file does not
  !> have is a half-space.
  subroutine read_bodies(file, profile, profile_file, poisson, bodies, sum, error)
    character(*), intent(in) :: file
    type(curve_type), intent(in) :: profile(2)   !! of the wheel and the rail, as in their files [m]
    character(*), intent(in) :: profile_file(2)  !! for messages
    real(dp), intent(in) :: poisson
    type(body_type), allocatable, intent(out) :: bodies(:)
    character(8), intent(out) :: sum             !! CRC-32 of the file's lines
    type(error_type), allocatable, intent(out) :: error
    type(cursor_type) :: at
    type(section_type) :: section
    real(dp) :: first, off, least(2), ratio(2)
    integer :: i, line(2)
    logical :: found(2)

    allocate (bodies(0))
    at%file = file
    call read_lines(file, at%lines, error)
    if (allocated(error)) return
    sum = checksum(at%lines)
    found = .false.
    least = huge(least)
    line = 0
    do
      call read_section(at, section, error)
      if (allocated(error)) return
      if (section%kind == 0) exit
      associate (k => section%kind)
        if (found(k)) cycle
        call locate(profile(k), section, first, off)
        if (off < least(k)) line(k) = section%line
        least(k) = min(off, least(k))
        found(k) = off < near
        if (.not. found(k)) cycle
        if (abs(section%poisson - poisson) > same_poisson) then
          call refuse(error, 'bodies with &material poisson = '//str(poisson), str(section%poisson), file, section%line, &
            rest='; make a file for this material: python -m ldbench bodies')
          return
        end if
        bodies = [bodies, new_body(k, first, section%width, section%wave, section%difference)]
        ratio = over_halfspace(bodies(size(bodies)))
        if (ratio(1) < least_ratio(1) .or. ratio(1) > least_ratio(2) .or. ratio(2) > largest_ratio) then
          call refuse(error, 'strips that act on themselves like half-spaces, less than '//str(nint(largest_ratio))// &
            ' times as much', str(anint(100*ratio(1))/100)//' to '//str(anint(100*ratio(2))/100)//' times as much', file, &
            section%line, rest='; the head of body_file.f90 tells the sign and what is taken off')
          return
        end if
      end associate
    end do
    do i = 1, 2
      if (found(i) .or. line(i) == 0) cycle
      call refuse(error, 'strips on '//trim(profile_file(i)), 'strips that are up to '//str(anint(1e5_dp*least(i))/100)// &
        ' mm beside it', file, line(i), rest='; make a file for these profiles: python -m ldbench bodies')
      return
    end do
    if (size(bodies) == 0) call refuse(error, 'bodies of a wheel or a rail', 'none', file)
  end subroutine read_bodies

  !> Read the next body; its kind is 0 where there is none.
  subroutine read_section(at, section, error)
    type(cursor_type), intent(inout) :: at
    type(section_type), intent(out) :: section
    type(error_type), allocatable, intent(out) :: error
    real(dp) :: number(1)

    call skip(at)
    if (at%next > size(at%lines)) return
    section%kind = findloc('body '//body_kinds == at%lines(at%next)%text, .true., 1)
    section%line = at%next
    if (section%kind == 0) then
      call complain(at, '''body wheel'' or ''body rail''', error)
      return
    end if
    at%next = at%next + 1
    call get(at, 'poisson', number, error)
    section%poisson = number(1)
    if (.not. allocated(error)) call get(at, 'width', number, error)
    section%width = 1e-3_dp*number(1)
    if (.not. allocated(error) .and. section%width <= 0) then
      at%next = at%next - 1
      call complain(at, 'a width above 0 mm', error)
    end if
    if (.not. allocated(error)) call read_strips(at, section, error)
    if (.not. allocated(error)) call read_waves(at, section, error)
  end subroutine read_section

  subroutine read_strips(at, section, error)
    type(cursor_type), intent(inout) :: at
    type(section_type), intent(inout) :: section
    type(error_type), allocatable, intent(out) :: error
    real(dp) :: place(2)

    allocate (section%middle(2, most_strips))
    do while (begins(at, 'strip'))
      if (section%strips == most_strips) then
        call complain(at, 'at most '//str(most_strips)//' strips', error)
        return
      end if
      call get(at, 'strip', place, error)
      if (allocated(error)) return
      section%strips = section%strips + 1
      section%middle(:, section%strips) = 1e-3_dp*place
    end do
    section%middle = section%middle(:, :section%strips)
    if (section%strips < fewest_strips) &
      call complain(at, '''strip'' with y and z in mm, at least '//str(fewest_strips)//' times', error)
  end subroutine read_strips

  subroutine read_waves(at, section, error)
    type(cursor_type), intent(inout) :: at
    type(section_type), intent(inout) :: section
    type(error_type), allocatable, intent(out) :: error
    real(dp) :: number(1), row(section%strips), previous
    integer :: most, i

    ! A wave has a line of its own and one for each strip.
    most = min(most_waves, (size(at%lines) - at%next + 1)/(section%strips + 1) + 1)
    allocate (section%wave(most), section%difference(most, section%strips, section%strips))
    previous = 0
    do while (begins(at, 'wave'))
      call get(at, 'wave', number, error)
      if (allocated(error)) return
      if (1e3_dp*number(1) <= previous .or. section%waves == most_waves) then
        at%next = at%next - 1
        call complain(at, 'wave numbers above 0 that grow, at most '//str(most_waves)//' of them', error)
        return
      end if
      section%waves = section%waves + 1
      previous = 1e3_dp*number(1)
      section%wave(section%waves) = previous
      do i = 1, section%strips
        call get(at, '', row(:i), error)
        if (allocated(error)) return
        section%difference(section%waves, :i, i) = row(:i)
        section%difference(section%waves, i, :i) = row(:i)
      end do
    end do
    section%wave = section%wave(:section%waves)
    section%difference = section%difference(:section%waves, :, :)
    if (section%waves < 2) call complain(at, '''wave'' with a number in 1/mm, at least twice', error)
  end subroutine read_waves

  !> Go on to the next line that is no comment.
  pure subroutine skip(at)
    type(cursor_type), intent(inout) :: at

    do while (at%next <= size(at%lines))
      if (at%lines(at%next)%text /= '' .and. index(adjustl(at%lines(at%next)%text), '#') /= 1) exit
      at%next = at%next + 1
    end do
  end subroutine skip

  !> Whether the next line begins with a word.
  logical function begins(at, word)
    type(cursor_type), intent(inout) :: at
    character(*), intent(in) :: word

    call skip(at)
    begins = .false.
    if (at%next <= size(at%lines)) begins = index(adjustl(at%lines(at%next)%text), word//' ') == 1
  end function begins

  !> The numbers behind the word of the next line, which has no others.
  subroutine get(at, word, x, error)
    type(cursor_type), intent(inout) :: at
    character(*), intent(in) :: word
    real(dp), intent(out) :: x(:)
    type(error_type), allocatable, intent(out) :: error
    character(:), allocatable :: rest
    integer :: k, cut
    logical :: ok

    call skip(at)
    ok = at%next <= size(at%lines)
    x = 0
    if (ok .and. word /= '') ok = begins(at, word)
    if (ok) then
      rest = adjustl(at%lines(at%next)%text)//' '
      rest = adjustl(rest(len(word) + 1:))
      do k = 1, size(x)
        cut = index(rest, ' ')
        if (ok) call to_real(rest(:cut - 1), x(k), ok)
        rest = adjustl(rest(cut:))//' '
      end do
      ok = ok .and. rest == ''
    end if
    if (ok) then
      at%next = at%next + 1
    else
      call complain(at, trim(adjustl(word//' '//str(size(x))//' numbers')), error)
    end if
  end subroutine get

  !> Say what the next line should have been.
  pure subroutine complain(at, expected, error)
    type(cursor_type), intent(in) :: at
    character(*), intent(in) :: expected
    type(error_type), allocatable, intent(out) :: error

    if (at%next <= size(at%lines)) then
      call refuse(error, expected, ''''//clip(at%lines(at%next)%text)//'''', at%file, at%next)
    else
      call refuse(error, expected, 'the end of the file', at%file)
    end if
  end subroutine complain

  !> Find the station of the first strip's middle on a profile, and how far the strips are off it at most [m].
  pure subroutine locate(profile, section, first, off)
    type(curve_type), intent(in) :: profile
    type(section_type), intent(in) :: section
    real(dp), intent(out) :: first, off
    real(dp) :: r(2), d1(2), d2(2), step
    integer :: i, iter, interval

    associate (knot => profile%a(:, 1, 1:), p => section%middle(:, 1))
      interval = minloc((knot(1, :) - p(1))**2 + (knot(2, :) - p(2))**2, 1)
      first = profile%s(interval)
      do iter = 1, 50
        call curve_point(profile, first, interval, r, d1, d2)
        step = dot_product(p - r, d1)/dot_product(d1, d1)
        first = first + step
        if (abs(step) < 1e-9_dp) exit
      end do
    end associate
    off = 0
    do i = 1, section%strips
      call curve_point(profile, first + (i - 1)*section%width, interval, r, d1, d2)
      off = max(off, norm2(r - section%middle(:, i)))
    end do
  end subroutine locate

end module body_file
