!> The column file of a run: one row of numbers per output time.
!>
!> A contact (tread or flange of one wheel) may carry several patches.  It is
!> reported by its resultant: N and the contact angle are the magnitude and
!> direction of the force of the rail on the wheel; the contact point is where the
!> resultant's line of action cuts the undeformed wheel profile, which is the
!> force-weighted centre of the patches to within their curvature; the rolling
!> radius is the wheel's there.
!>
!> Rigid contacts have five more columns, which tell impacts from contact that lasts: the impulses P of
!> impacts so far, by contact, and the energy lost in them.  N of a rail that pulls is negative.
module columns
  use contact, only: side_type
  use curve, only: curve_point, near_interval
  use errors, only: error_type, fatal_error
  use geometry, only: pair_type, rolled, wheel_station
  use kinds, only: dp, gravity
  use newmark, only: motion_type
  use system, only: finish_file, make_folder, scratch_name
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_quiet_nan, ieee_value
  use, intrinsic :: iso_fortran_env, only: int64
  use wheelset, only: closed, contact_name, contact_state, external_force, right_tread, &
    wheelset_type
  implicit none
  private
  public :: n_columns, n_rigid_columns, elastic_columns, column_names, column_units, fill_row, write_table_file

  integer, parameter :: n_columns = 56          !! of elastic contacts
  integer, parameter :: n_rigid_columns = 61    !! of rigid ones: the same and five more
  integer, parameter :: elastic_columns(2) = [52, 53]   !! PE_elastic_L, PE_elastic_R
  integer, parameter :: width = 16

contains

  pure function column_names() result(names)
    character(width) :: names(n_rigid_columns)
    character(6), parameter :: per_contact(7) = ['angle ', 'N     ', 'Fy    ', 'Fz    ', 'y     ', 'z     ', &
      'radius']
    integer :: c, i

    names(1:14) = [character(width) :: 'time', 'X', 'Y', 'Z', 'roll', 'pitch', 'vX', 'vY', 'vZ', &
      'roll_rate', 'pitch_rate', 'aY', 'aZ', 'roll_acc']
    do c = 1, 4
      do i = 1, 7
        names(7 + 7*c + i) = trim(per_contact(i))//'_'//contact_name(c)
      end do
    end do
    names(43:56) = [character(width) :: 'F_ext', 'M_gyro', 'KE_long', 'KE_lat', 'KE_vert', 'KE_roll', &
      'KE_pitch', 'PE_grav', 'PE_load', 'PE_elastic_L', 'PE_elastic_R', 'W_ext', 'E_total', 'E_drift']
    names(57:61) = [character(width) :: ('P_'//contact_name(c), c=1, 4), 'E_lost']
  end function column_names

  pure function column_units() result(units)
    character(width) :: units(n_rigid_columns)
    integer :: i

    units(1:14) = [character(width) :: 's', 'm', 'm', 'm', 'rad', 'rad', 'm/s', 'm/s', 'm/s', 'rad/s', &
      'rad/s', 'm/s2', 'm/s2', 'rad/s2']
    do i = 1, 4
      units(8 + 7*i:14 + 7*i) = [character(width) :: 'rad', 'N', 'N', 'N', 'm', 'm', 'm']
    end do
    units(43:56) = 'J'
    units(43:44) = [character(width) :: 'N', 'N.m']
    units(57:61) = [character(width) :: 'N.s', 'N.s', 'N.s', 'N.s', 'J']
  end function column_units

  !> One row.  `equilibrium` is the pose from which Z and roll are measured, `first_energy` the total
  !> energy at the start (0 while that is being found).
  subroutine fill_row(w, side, motion, speed, pitch, pitch_rate, equilibrium, first_energy, row)
    type(wheelset_type), intent(in) :: w
    type(side_type), intent(in) :: side(:) !! left, right
    type(motion_type), intent(in) :: motion
    real(dp), intent(in) :: speed          !! dX/dt [m/s]
    real(dp), intent(in) :: pitch          !! at t = 0 [rad]
    real(dp), intent(in) :: pitch_rate     !! constant [rad/s]
    real(dp), intent(in) :: equilibrium(3) !! y, z [m], roll [rad]
    real(dp), intent(in) :: first_energy   !! [J]
    real(dp), intent(out) :: row(:)        !! (n_columns or n_rigid_columns)
    real(dp) :: force(3), rise
    integer :: c

    force = external_force(w, motion%t)
    rise = motion%q(2) - equilibrium(2)
    row(1:11) = [motion%t, speed*motion%t, motion%q(1), rise, motion%q(3) - equilibrium(3), pitch + pitch_rate*motion%t, &
      speed, motion%v, pitch_rate]
    row(12:14) = (force - motion%contact%gradient)/w%inertia()
    do c = 1, 4
      call contact_columns(side(merge(2, 1, c >= right_tread))%pair, motion%q, motion%contact, c, row(8 + 7*c:14 + 7*c))
    end do
    row(43) = force(1)
    row(44) = w%pitch_inertia*pitch_rate*motion%v(3)
    row(45:49) = 0.5_dp*[w%mass*speed**2, w%inertia()*motion%v**2, w%pitch_inertia*pitch_rate**2]
    row(50:51) = rise*[w%mass*gravity, w%vertical_load]
    row(elastic_columns) = [sum(motion%contact%energy(:2)), sum(motion%contact%energy(3:))]
    row(54) = motion%work
    ! Left and right are added first: the mirrored run has the same sum, bit by bit.
    row(55) = sum(row(45:51)) + (row(52) + row(53))
    row(56) = row(55) - row(54) - first_energy
    if (size(row) == n_columns) return
    row(56) = row(56) + motion%loss
    row(57:61) = [motion%impulse, motion%loss]
  end subroutine fill_row

  !> angle, N, Fy, Fz, y, z, radius of one contact.
  subroutine contact_columns(pair, q, state, c, row)
    type(pair_type), intent(in) :: pair
    real(dp), intent(in) :: q(3)
    type(contact_state), intent(in) :: state
    integer, intent(in) :: c
    real(dp), intent(out) :: row(7)
    real(dp) :: force(3), own(2), roll, side, s, r(2), d1(2), d2(2), x(2), miss, slope
    real(dp) :: push
    logical :: shut(4)
    integer :: i, iter

    row = 0
    shut = closed(state)
    if (.not. shut(c)) then
      row([1, 5, 6, 7]) = ieee_value(1.0_dp, ieee_quiet_nan)
      return
    end if
    side = merge(-1.0_dp, 1.0_dp, c >= right_tread)
    push = merge(-1, 1, state%pulls(c))
    force = -push*state%slope(:, c)*[side, 1.0_dp, side]       ! as on the left wheel
    roll = side*q(3)
    row(1) = atan2(-force(1), force(2))
    row(2) = hypot(force(1), force(2))
    row(3) = push*side*force(1)
    row(4) = push*force(2)

    ! The wheel's point about which the resultant has no moment, in the wheel's frame.
    own = rolled(force(:2), -roll)
    s = wheel_station(pair, row(1) - roll)
    i = near_interval(pair%wheel, s)
    do iter = 1, 30
      call curve_point(pair%wheel, s, i, r, d1, d2)
      miss = r(1)*own(2) - r(2)*own(1) - force(3)
      slope = d1(1)*own(2) - d1(2)*own(1)
      if (slope <= 0.1_dp*row(2)) exit
      if (abs(miss) <= 1e-10_dp*row(2)) exit
      s = s - max(-5e-3_dp, min(miss/slope, 5e-3_dp))
    end do
    x = rolled(r, roll)
    row(5) = q(1) + side*x(1)
    row(6) = q(2) + x(2)
    row(7) = -r(2)
    row(2) = push*row(2)
  end subroutine contact_columns

  !> Write rows under a header: the line of names, the header's lines and the units
  !> as comments, then fixed-width numbers.  The names come first because that is
  !> where numpy.genfromtxt(names=True) and pandas.read_csv(comment='#') look.
  !> The file appears under its name only when it is complete; the default folder is made for it.
  subroutine write_table_file(file, header, names, units, rows, error)
    character(*), intent(in) :: file
    character(*), intent(in) :: header         !! lines ended by newline
    character(*), intent(in) :: names(:), units(:)
    real(dp), intent(in) :: rows(:, :)         !! (column, row)
    type(error_type), allocatable, intent(out) :: error
    character(:), allocatable :: scratch
    character(len=width*size(names)) :: line
    integer :: unit, stat, i, k, from, to
    character(200) :: iomsg

    call make_folder(file)
    scratch = scratch_name(file)
    open (newunit=unit, file=scratch, action='write', status='replace', iostat=stat, iomsg=iomsg, &
      recl=max(4096, width*size(names) + 1))
    if (stat /= 0) then
      call fatal_error(error, file//': cannot be written: '//trim(iomsg))
      return
    end if
    write (line, '(*(a16))') (adjustr(fit(names(i))), i=1, size(names))
    write (unit, '(a)', iostat=stat) line
    from = 1
    do while (from <= len(header))
      to = from + index(header(from:), new_line('a')) - 2
      if (stat == 0) write (unit, '(a)', iostat=stat) trim('# '//header(from:to))
      from = to + 2
    end do
    write (line, '(*(a16))') (adjustr(fit(units(i))), i=1, size(units))
    line(1:1) = '#'
    if (stat == 0) write (unit, '(a)', iostat=stat) line
    do i = 1, size(rows, 2)
      do k = 1, size(rows, 1)
        call put(rows(k, i), line(1 + (k - 1)*width:k*width))
      end do
      if (stat == 0) write (unit, '(a)', iostat=stat) line
    end do
    call finish_file(unit, scratch, file, stat)
    if (stat /= 0) call fatal_error(error, file//': cannot be written completely')

  contains

    pure function fit(word) result(cell)
      character(*), intent(in) :: word
      character(width) :: cell

      cell = word
    end function fit

  end subroutine write_table_file

  !> A number as es16.8 would write it, in a tenth of the time.  Numbers too small for
  !> a two-digit exponent are written as zero.
  pure subroutine put(x, cell)
    real(dp), intent(in) :: x
    character(width), intent(out) :: cell
    integer :: i, k, decade
    integer, parameter :: most = 99
    real(dp), parameter :: power(-most:most + 8) = [(10.0_dp**i, i=-most, most + 8)]
    character(2), parameter :: pairs(0:99) = [((achar(48 + i)//achar(48 + k), k=0, 9), i=0, 9)]
    integer(int64) :: digits, rest

    if (ieee_is_nan(x)) then
      cell = '             NaN'
      return
    end if
    cell = '  0.00000000E+00'
    if (abs(x) < 1e-98_dp) return
    if (abs(x) >= 1e98_dp) then
      write (cell, '(es16.8e3)') x
      return
    end if
    ! From the power of two, which the power of ten may exceed by one.
    decade = floor((exponent(x) - 1)*log10(2.0_dp))
    digits = int(abs(x)*power(8 - decade) + 0.5_dp, int64)
    if (digits >= 1000000000_int64) then
      decade = decade + 1
      digits = int(abs(x)*power(8 - decade) + 0.5_dp, int64)
    end if
    if (x < 0) cell(2:2) = '-'
    do i = 11, 5, -2
      rest = digits/100
      cell(i:i + 1) = pairs(digits - 100*rest)
      digits = rest
    end do
    cell(3:3) = achar(48 + int(digits))
    if (decade < 0) cell(14:14) = '-'
    cell(15:16) = pairs(abs(decade))
  end subroutine put

end module columns
