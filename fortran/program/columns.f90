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
  use contact_zones, only: side_type
  use curve, only: curve_point, near_interval
  use errors, only: error_type, fatal_error
  use wheel_rail_pair, only: pair_type, rolled, wheel_station
  use kinds, only: dp, gravity
  use motion_state, only: motion_type
  use row_sink, only: row_taker
  use system, only: scratch_file
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_quiet_nan, ieee_value
  use, intrinsic :: iso_fortran_env, only: int64
  use wheelset, only: closed, contact_name, contact_state, external_force, right_tread, &
    wheelset_type
  implicit none
  private
  public :: n_columns, n_rigid_columns, elastic_columns, column_names, column_units, fill_row, column_file

  integer, parameter :: n_columns = 56          !! of elastic contacts
  integer, parameter :: n_rigid_columns = 61    !! of rigid ones: the same and five more
  integer, parameter :: elastic_columns(2) = [52, 53]   !! PE_elastic_L, PE_elastic_R
  integer, parameter :: width = 16

  !> A column file. Its rows are written as they come, to a file without a name beside it: what its header says is known
  !> when the last of them is. Then it is put together: the line of names, the header's lines and the units as comments, the
  !> fixed-width numbers. The names come first because that is where numpy.genfromtxt(names=True) and
  !> pandas.read_csv(comment='#') look. The file appears under its name only when it is complete.
  type, extends(row_taker) :: column_file
    private
    character(:), allocatable :: name
    type(scratch_file) :: rows, whole
    character(:), allocatable :: waiting   !! rows as text, the first `filled` characters of it
    integer :: filled = 0
  contains
    procedure :: begin
    procedure :: take
    procedure :: finish
    procedure :: place
    procedure :: abandon
  end type column_file

  integer, parameter :: at_once = 2**16   ! that is written [bytes], and a row more

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

  !> Begin a file with so many columns.
  subroutine begin(this, file, n, error)
    class(column_file), intent(inout) :: this
    character(*), intent(in) :: file
    integer, intent(in) :: n
    type(error_type), allocatable, intent(out) :: error

    this%name = file
    allocate (character(at_once + width*n + 1) :: this%waiting)
    call this%rows%begin(file, nameless=.true.)
    if (.not. this%rows%ok) call fatal_error(error, file//': cannot be written')
  end subroutine begin

  subroutine take(this, row, error)
    class(column_file), intent(inout) :: this
    real(dp), intent(in) :: row(:)
    type(error_type), allocatable, intent(out) :: error
    integer :: length

    length = width*size(row)
    call put(size(row), row, this%waiting(this%filled + 1:this%filled + length))
    this%filled = this%filled + length + 1
    this%waiting(this%filled:this%filled) = new_line('a')
    if (this%filled < at_once) return
    call this%rows%put(this%waiting(:this%filled))
    this%filled = 0
    if (this%rows%ok) return
    call this%abandon()
    call incomplete(this%name, error)
  end subroutine take

  !> Put the file together; `place` gives it its name.
  subroutine finish(this, header, names, units, error)
    class(column_file), intent(inout) :: this
    character(*), intent(in) :: header         !! lines ended by newline
    character(*), intent(in) :: names(:), units(:)
    type(error_type), allocatable, intent(out) :: error
    character(:), allocatable :: line
    integer :: from, to

    call this%rows%put(this%waiting(:this%filled))
    call this%whole%begin(this%name)
    call this%whole%put(cells(names)//new_line('a'))
    from = 1
    do while (from <= len(header))
      to = from + index(header(from:), new_line('a')) - 2
      call this%whole%put(trim('# '//header(from:to))//new_line('a'))
      from = to + 2
    end do
    line = cells(units)
    line(1:1) = '#'
    call this%whole%put(line//new_line('a'))
    call this%whole%append(this%rows)
    call this%whole%complete()
    if (this%whole%ok) return
    call incomplete(this%name, error)
    call this%abandon()
  end subroutine finish

  !> Give a file that is put together its name.
  subroutine place(this, error)
    class(column_file), intent(inout) :: this
    type(error_type), allocatable, intent(out) :: error

    call this%whole%finish()
    if (.not. this%whole%ok) call incomplete(this%name, error)
    call this%abandon()
  end subroutine place

  subroutine incomplete(file, error)
    character(*), intent(in) :: file
    type(error_type), allocatable, intent(out) :: error

    call fatal_error(error, file//': cannot be written completely')
  end subroutine incomplete

  !> Forget the rows, and the file that has no name yet.
  subroutine abandon(this)
    class(column_file), intent(inout) :: this

    call this%rows%abandon()
    call this%whole%abandon()
    if (allocated(this%waiting)) deallocate (this%waiting)
    this%filled = 0
  end subroutine abandon

  !> Words as they stand above the numbers.
  pure function cells(words) result(line)
    character(*), intent(in) :: words(:)
    character(width*size(words)) :: line
    character(width) :: cell
    integer :: i

    do i = 1, size(words)
      cell = words(i)
      line(1 + (i - 1)*width:i*width) = adjustr(cell)
    end do
  end function cells

  !> Numbers as es16.8 would write them, in a tenth of the time.  Numbers too small for
  !> a two-digit exponent are written as zero.
  pure subroutine put(n, x, cells)
    integer, intent(in) :: n
    real(dp), intent(in) :: x(n)
    character(width), intent(out) :: cells(n)
    integer :: i, k, decade, high, low, hundreds
    integer, parameter :: most = 99
    real(dp), parameter :: power(-most:most + 8) = [(10.0_dp**i, i=-most, most + 8)]
    character(2), parameter :: pairs(0:99) = [((achar(48 + i)//achar(48 + k), k=0, 9), i=0, 9)]
    character(4), parameter :: exponents(-most:most) = [('E-'//pairs(-i), i=-most, -1), ('E+'//pairs(i), i=0, most)]
    character(4), parameter :: first(0:9) = [('  '//achar(48 + i)//'.', i=0, 9)]
    real(dp) :: magnitude
    integer(int64) :: digits

    do k = 1, n
      ! First, for a comparison with what is no number traps in the debug build.
      if (ieee_is_nan(x(k))) then
        cells(k) = '             NaN'
        cycle
      end if
      magnitude = abs(x(k))
      if (magnitude < 1e-98_dp .or. magnitude >= 1e98_dp) then
        cells(k) = '  0.00000000E+00'
        if (magnitude > 1) write (cells(k), '(es16.8e3)') x(k)
        cycle
      end if
      ! From the power of two, which the power of ten may exceed by one; 1233/4096 is log10(2) as far as that goes.
      decade = shifta((exponent_of(magnitude) - 1)*1233, 12)
      digits = int(magnitude*power(8 - decade) + 0.5_dp, int64)
      if (digits >= 1000000000_int64) then
        decade = decade + 1
        digits = int(magnitude*power(8 - decade) + 0.5_dp, int64)
      end if
      high = int(digits/10000)
      low = int(digits - 10000*int(high, int64))
      i = high/10000
      high = high - 10000*i
      cells(k)(1:4) = first(i)
      if (x(k) < 0) cells(k)(2:2) = '-'
      hundreds = high/100
      cells(k)(5:6) = pairs(hundreds)
      cells(k)(7:8) = pairs(high - 100*hundreds)
      hundreds = low/100
      cells(k)(9:10) = pairs(hundreds)
      cells(k)(11:12) = pairs(low - 100*hundreds)
      cells(k)(13:16) = exponents(decade)
    end do
  end subroutine put

  !> `exponent` of a positive number, from its bits.
  elemental integer function exponent_of(x)
    real(dp), intent(in) :: x

    exponent_of = int(shiftr(transfer(x, 0_int64), 52)) - 1022
  end function exponent_of

end module columns