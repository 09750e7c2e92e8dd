!> Reads a wheel's or a rail's profile: lines of y and z in millimetres, z up, y outward to the field side.  A wheel's y begins
!> at its back, a rail's at its gauge point.  Blank lines and lines that begin with #, ! or % are comments.
!>
!> Python turns other files into this form, mends and smooths them: a file that is refused is refused with the command for it.
module profile
  use curve, only: curve_type
  use curve_fit, only: interpolate, point_noise
  use errors, only: append_advice, error_type, place_error, refuse
  use kinds, only: dp
  use profile_check, only: check_points, is_rail, is_wheel
  use system, only: last_slash
  use text, only: checksum, clip, line_type, lower, read_lines, str, to_real
  implicit none
  private
  public :: profile_type, read_profile, is_wheel, is_rail

  !> A profile and what its file says of itself.
  type :: profile_type
    character(:), allocatable :: file      !! as named in the namelist
    character(8) :: checksum = ''          !! CRC-32 of the file's lines
    logical :: reconstruction = .false.    !! the file says that it is one
    character(:), allocatable :: taken     !! how Python made the file; '' where the file does not say it
    real(dp), allocatable :: points(:, :)  !! y, z, (2, n) [mm]
    !> Depth below the top down to which the gauge side of a rail goes on behind its first point, in points left out [m]; 0 none.
    real(dp) :: hidden = 0
    type(curve_type) :: curve              !! y, z [m], y increasing from first to last station
  end type profile_type

contains

  !> Read a profile.  Fails where a line is not two numbers, where `profile_check` finds that the points cannot be the
  !> profile, or where they are noisy and not from Python.
  subroutine read_profile(file, kind, p, error)
    character(*), intent(in) :: file
    integer, intent(in) :: kind            !! is_wheel or is_rail
    type(profile_type), intent(out) :: p
    type(error_type), allocatable, intent(out) :: error
    character(*), parameter :: mark = '# taken:', hidden = '# gauge side behind the first point, down to [mm]:'
    ! Noise that changes the mean curvature over a patch by less than the curvature of a tread, with points 0.25 mm apart [m].
    real(dp), parameter :: negligible = 0.1e-6_dp
    type(line_type), allocatable :: lines(:)
    integer, allocatable :: line(:)        ! of each point in the file
    character(40) :: about
    real(dp) :: noise
    integer :: i
    logical :: made, ok

    p%taken = ''
    call read_lines(file, lines, error)
    if (allocated(error)) return
    p%file = file
    p%checksum = checksum(lines)
    made = .false.
    do i = 1, size(lines)
      if (index(lower(lines(i)%text), 'reconstruction') > 0) p%reconstruction = .true.
      if (index(lines(i)%text, hidden) == 1) then
        call to_real(adjustl(lines(i)%text(len(hidden) + 1:)), p%hidden, ok)
        p%hidden = merge(1e-3_dp*p%hidden, 0.0_dp, ok)
      end if
      if (made .or. index(lines(i)%text, mark) /= 1) cycle
      made = .true.
      p%taken = trim(adjustl(lines(i)%text(len(mark) + 1:)))
    end do
    call read_points(file, lines, p%points, line, error)
    if (.not. allocated(error)) call check_points(file, kind, .not. made, p%points, line, error)
    if (allocated(error)) then
      call advise('convert', file, error)
      return
    end if
    associate (y => 1e-3_dp*p%points(1, :), z => 1e-3_dp*p%points(2, :))
      noise = point_noise(y, z)
      if (noise > negligible .and. .not. made) then
        about = str(anint(1e8_dp*noise)/100)
        if (noise >= 1e-6_dp) about = str(nint(1e6_dp*noise))
        call refuse(error, 'a smooth curve', 'points with a noise of about '//trim(about)//' um', file)
        call advise('smooth', file, error)
        return
      end if
      call interpolate(y, z, p%curve, error)
    end associate
    if (allocated(error)) call place_error(error, file)
  end subroutine read_profile

  !> The points of the lines.
  subroutine read_points(file, lines, points, line, error)
    character(*), intent(in) :: file
    type(line_type), intent(in) :: lines(:)
    real(dp), allocatable, intent(out) :: points(:, :)
    integer, allocatable, intent(out) :: line(:)
    type(error_type), allocatable, intent(out) :: error
    real(dp), parameter :: largest = 1e4_dp    ! coordinate [mm]
    character(:), allocatable :: row
    integer :: i, n, cut, stat
    logical :: ok

    allocate (points(2, size(lines)), line(size(lines)), stat=stat)
    if (stat /= 0) then
      call refuse(error, 'memory for the points of '//str(size(lines))//' lines', 'less', file)
      return
    end if
    row = ''
    n = 0
    do i = 1, size(lines)
      row = adjustl(lines(i)%text)//' '
      if (row == '' .or. scan(row(1:1), '#!%') == 1) cycle
      n = n + 1
      line(n) = i
      cut = index(row, ' ')
      call to_real(row(:cut - 1), points(1, n), ok)
      if (ok) call to_real(adjustl(row(cut:)), points(2, n), ok)
      if (ok) ok = all(abs(points(:, n)) <= largest)
      if (ok) cycle
      call refuse(error, 'two numbers, y and z in mm', ''''//clip(row)//'''', file, i)
      return
    end do
    points = points(:, :n)
    line = line(:n)
  end subroutine read_points

  !> Add the command that makes a file that can be read.
  pure subroutine advise(verb, file, error)
    character(*), intent(in) :: verb, file
    type(error_type), allocatable, intent(inout) :: error
    character(:), allocatable :: made
    integer :: point

    point = index(file, '.', back=.true.)
    if (point <= last_slash(file) + 1) point = len(file) + 1
    made = file(:point - 1)//'.yz'
    if (made == file) made = file(:point - 1)//'_new.yz'
    call append_advice(error, verb//' it: python -m ldbench profile '//file//' -o '//made)
  end subroutine advise

end module profile
