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
  use body_influence, only: body_kinds, body_type, new_body
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

  !> A body as a file has it.
  type :: section_type
    integer :: kind = 0, line = 0, strips = 0, waves = 0
    real(dp) :: poisson = -1, width = 0          !! [1, m]
    real(dp), allocatable :: middle(:, :)        !! (2, strips) [m]
    real(dp), allocatable :: wave(:), difference(:, :, :)   !! [1/m], (wave, strip, strip)
  end type section_type

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
    type(line_type), allocatable :: lines(:)
    type(section_type) :: section
    real(dp) :: first, off, least(2)
    integer :: next, line(2)
    logical :: found(2)

    allocate (bodies(0))
    call read_lines(file, lines, error)
    if (allocated(error)) return
    sum = checksum(lines)
    found = .false.
    least = huge(least)
    line = 0
    next = 1
    do
      call read_section(file, lines, next, section, error)
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
      end associate
    end do
    do next = 1, 2
      if (found(next) .or. line(next) == 0) cycle
      call refuse(error, 'strips on '//trim(profile_file(next)), 'strips that are up to '//str(anint(1e5_dp*least(next))/100)// &
        ' mm beside it', file, line(next), rest='; make a file for these profiles: python -m ldbench bodies')
      return
    end do
    if (size(bodies) == 0) call refuse(error, 'bodies of a wheel or a rail', 'none', file)
  end subroutine read_bodies

  !> Read the next body of a file; its kind is 0 where there is none. `next` is the line to begin with.
  subroutine read_section(file, lines, next, section, error)
    character(*), intent(in) :: file
    type(line_type), intent(in) :: lines(:)
    integer, intent(inout) :: next
    type(section_type), intent(out) :: section
    type(error_type), allocatable, intent(out) :: error
    real(dp) :: place(2), numbers(1)
    real(dp), allocatable :: row(:)
    logical :: ok
    integer :: i, first

    call skip()
    if (next > size(lines)) return
    first = next
    section%kind = findloc('body '//body_kinds == lines(next)%text, .true., 1)
    if (section%kind == 0) then
      call complain('''body wheel'' or ''body rail''')
      return
    end if
    section%line = next
    next = next + 1
    call get('poisson', numbers, ok)
    section%poisson = numbers(1)
    if (ok) call get('width', numbers, ok)
    section%width = 1e-3_dp*numbers(1)
    if (ok .and. section%width <= 0) then
      next = next - 1
      call complain('a width above 0 mm')
    end if
    if (allocated(error)) return
    allocate (section%middle(2, size(lines)), section%wave(most_waves))
    do while (begins('strip'))
      call get('strip', place, ok)
      if (.not. ok) return
      section%strips = section%strips + 1
      section%middle(:, section%strips) = 1e-3_dp*place
    end do
    if (section%strips < fewest_strips) then
      call complain('''strip'' with y and z in mm, at least '//str(fewest_strips)//' times')
      return
    end if
    if (section%strips > most_strips) then
      call refuse(error, 'at most '//str(most_strips)//' strips', str(section%strips), file, section%line)
      return
    end if
    section%middle = section%middle(:, :section%strips)
    allocate (section%difference(most_waves, section%strips, section%strips))
    do while (begins('wave'))
      call get('wave', numbers, ok)
      if (.not. ok) return
      section%waves = section%waves + 1
      associate (w => section%waves)
        section%wave(w) = 1e3_dp*numbers(1)
        ok = section%wave(w) > 0
        if (w > 1) ok = section%wave(w) > section%wave(w - 1)
        next = next - 1
        if (.not. ok .or. w == most_waves) call complain('wave numbers above 0 that grow, fewer than '//str(most_waves)//' of them')
        if (allocated(error)) return
        next = next + 1
        do i = 1, section%strips
          row = spread(0.0_dp, 1, i)
          call get('', row, ok)
          if (.not. ok) return
          section%difference(w, :i, i) = row
          section%difference(w, i, :i) = row
        end do
      end associate
    end do
    if (section%waves < 2) then
      call complain('''wave'' with a number in 1/mm, at least twice')
      return
    end if
    section%wave = section%wave(:section%waves)
    section%difference = section%difference(:section%waves, :, :)

  contains

    !> Go on to the next line that is no comment.
    subroutine skip()
      do while (next <= size(lines))
        if (lines(next)%text /= '' .and. index(adjustl(lines(next)%text), '#') /= 1) exit
        next = next + 1
      end do
    end subroutine skip

    logical function begins(word)
      character(*), intent(in) :: word

      call skip()
      begins = .false.
      if (next <= size(lines)) begins = index(adjustl(lines(next)%text), word//' ') == 1
    end function begins

    !> The numbers behind the word of a line. `error` is set if there are others.
    subroutine get(word, x, ok)
      character(*), intent(in) :: word
      real(dp), intent(out) :: x(:)
      logical, intent(out) :: ok
      character(:), allocatable :: rest
      integer :: k, cut

      call skip()
      ok = next <= size(lines)
      x = 0
      if (ok .and. word /= '') ok = begins(word)
      if (ok) then
        rest = adjustl(lines(next)%text)//' '
        rest = adjustl(rest(len(word) + 1:))
        do k = 1, size(x)
          cut = index(rest, ' ')
          if (ok) call to_real(rest(:cut - 1), x(k), ok)
          rest = adjustl(rest(cut:))//' '
        end do
        ok = ok .and. rest == ''
      end if
      if (.not. ok) call complain(trim(adjustl(word//' '//str(size(x))//' numbers')))
      if (ok) next = next + 1
    end subroutine get

    subroutine complain(expected)
      character(*), intent(in) :: expected

      if (next <= size(lines)) then
        call refuse(error, expected, ''''//clip(lines(next)%text)//'''', file, next)
      else
        call refuse(error, expected, 'the end of the file', file)
      end if
    end subroutine complain

  end subroutine read_section

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
