!> The columns of a run: one list of names, units and values.
!>
!> A contact (tread or flange of one wheel) may carry several patches. It is reported by the resultant: N and the contact
!> angle are the magnitude and direction of the force of the rail on the wheel; the contact point is where the line of
!> action of the resultant cuts the undeformed wheel profile, which is the force-weighted centre of the patches to within
!> their curvature; the rolling radius is the wheel's radius there.
!>
!> Rigid contacts have more columns, which tell impacts from contact that lasts: the impulses P of all impacts so far, by
!> contact, and the energy lost in them. N is negative where a rail pulls.
module columns
  use contact_zones, only: side_type
  use curve, only: curve_point, near_interval
  use kinds, only: dp, gravity
  use motion_state, only: motion_type
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use wheel_rail_pair, only: pair_type, rolled, wheel_station
  use wheelset, only: closed, contact_name, contact_state, external_force, right_tread, wheelset_type
  implicit none
  private
  public :: row_type, column_type, column_width, most_columns, make_row, list_columns, name_columns

  integer, parameter :: column_width = 16     !! characters of a name, a unit, a number
  integer, parameter :: most_columns = 64

  !> The quantities of one row.
  type :: row_type
    logical :: rigid = .false.       !! impulses and lost energy, too
    real(dp) :: t = 0                !! [s]
    real(dp) :: x(5) = 0             !! X, Y, Z from equilibrium [m], roll from equilibrium, pitch [rad]
    real(dp) :: v(5) = 0             !! rates
    real(dp) :: a(3) = 0             !! accelerations of Y, Z, roll
    real(dp) :: contact(7, 4) = 0    !! angle, N, Fy, Fz, y, z, radius, by contact
    real(dp) :: lateral_force = 0    !! external [N]
    real(dp) :: gyroscopic = 0       !! moment that the yaw constraint carries [N m]
    real(dp) :: kinetic(5) = 0       !! longitudinal, lateral, vertical, roll, pitch [J]
    real(dp) :: gravity = 0, load = 0   !! potential energies [J]
    real(dp) :: elastic(2) = 0       !! left, right [J]
    real(dp) :: work = 0             !! work of the lateral force [J]
    real(dp) :: impulse(4) = 0       !! of impacts, by contact [N s]
    real(dp) :: loss = 0             !! in impacts [J]
    real(dp) :: first_energy = 0     !! total energy at the start [J]
  contains
    procedure :: total_energy
  end type row_type

  !> A column.
  type :: column_type
    character(column_width) :: name, unit
  end type column_type

contains

  !> The row of a motion.
  pure subroutine make_row(w, side, motion, speed, pitch, pitch_rate, equilibrium, first_energy, rigid, row)
    type(wheelset_type), intent(in) :: w
    type(side_type), intent(in) :: side(:) !! left, right
    type(motion_type), intent(in) :: motion
    real(dp), intent(in) :: speed          !! dX/dt [m/s]
    real(dp), intent(in) :: pitch          !! at t = 0 [rad]
    real(dp), intent(in) :: pitch_rate     !! constant [rad/s]
    real(dp), intent(in) :: equilibrium(3) !! y, z [m], roll [rad], from which Z and roll are measured
    real(dp), intent(in) :: first_energy   !! total energy at the start [J]
    logical, intent(in) :: rigid
    type(row_type), intent(out) :: row
    real(dp) :: force(3), rise
    integer :: c

    force = external_force(w, motion%t)
    rise = motion%q(2) - equilibrium(2)
    row%rigid = rigid
    row%t = motion%t
    row%x = [speed*motion%t, motion%q(1), rise, motion%q(3) - equilibrium(3), pitch + pitch_rate*motion%t]
    row%v = [speed, motion%v, pitch_rate]
    row%a = (force - motion%contact%gradient)/w%inertia()
    do c = 1, 4
      call contact_columns(side(merge(2, 1, c >= right_tread))%pair, motion%q, motion%contact, c, row%contact(:, c))
    end do
    row%lateral_force = force(1)
    row%gyroscopic = w%pitch_inertia*pitch_rate*motion%v(3)
    row%kinetic = 0.5_dp*[w%mass*speed**2, w%inertia()*motion%v**2, w%pitch_inertia*pitch_rate**2]
    row%gravity = rise*(w%mass*gravity)
    row%load = rise*w%vertical_load
    row%elastic = [sum(motion%contact%energy(:2)), sum(motion%contact%energy(3:))]
    row%work = motion%work
    row%impulse = motion%impulse
    row%loss = motion%loss
    row%first_energy = first_energy
  end subroutine make_row

  !> Sum of all energies [J]. Left and right are added first, so that the mirrored run has the same sum, bit by bit.
  pure real(dp) function total_energy(row)
    class(row_type), intent(in) :: row

    total_energy = sum([row%kinetic, row%gravity, row%load]) + (row%elastic(1) + row%elastic(2))
  end function total_energy

  !> The list of columns: values in order and, if the caller asks for them, names and units. The order is defined here only.
  subroutine list_columns(row, values, n, columns)
    type(row_type), intent(in) :: row
    real(dp), intent(out) :: values(most_columns)
    integer, intent(out) :: n
    type(column_type), intent(out), optional :: columns(most_columns)
    real(dp) :: total
    integer :: c

    n = 0
    call add('time', 's', row%t)
    call add('X', 'm', row%x(1))
    call add('Y', 'm', row%x(2))
    call add('Z', 'm', row%x(3))
    call add('roll', 'rad', row%x(4))
    call add('pitch', 'rad', row%x(5))
    call add('vX', 'm/s', row%v(1))
    call add('vY', 'm/s', row%v(2))
    call add('vZ', 'm/s', row%v(3))
    call add('roll_rate', 'rad/s', row%v(4))
    call add('pitch_rate', 'rad/s', row%v(5))
    call add('aY', 'm/s2', row%a(1))
    call add('aZ', 'm/s2', row%a(2))
    call add('roll_acc', 'rad/s2', row%a(3))
    do c = 1, 4
      call add('angle', 'rad', row%contact(1, c), c)
      call add('N', 'N', row%contact(2, c), c)
      call add('Fy', 'N', row%contact(3, c), c)
      call add('Fz', 'N', row%contact(4, c), c)
      call add('y', 'm', row%contact(5, c), c)
      call add('z', 'm', row%contact(6, c), c)
      call add('radius', 'm', row%contact(7, c), c)
    end do
    call add('F_ext', 'N', row%lateral_force)
    call add('M_gyro', 'N.m', row%gyroscopic)
    call add('KE_long', 'J', row%kinetic(1))
    call add('KE_lat', 'J', row%kinetic(2))
    call add('KE_vert', 'J', row%kinetic(3))
    call add('KE_roll', 'J', row%kinetic(4))
    call add('KE_pitch', 'J', row%kinetic(5))
    call add('PE_grav', 'J', row%gravity)
    call add('PE_load', 'J', row%load)
    call add('PE_elastic_L', 'J', row%elastic(1))
    call add('PE_elastic_R', 'J', row%elastic(2))
    call add('W_ext', 'J', row%work)
    total = row%total_energy()
    call add('E_total', 'J', total)
    call add('E_drift', 'J', total - row%work - row%first_energy + row%loss)
    if (.not. row%rigid) return
    do c = 1, 4
      call add('P', 'N.s', row%impulse(c), c)
    end do
    call add('E_lost', 'J', row%loss)

  contains

    subroutine add(name, unit, value, contact)
      character(*), intent(in) :: name, unit
      real(dp), intent(in) :: value
      integer, intent(in), optional :: contact   !! contact whose name is appended to the name of the column

      n = n + 1
      values(n) = value
      if (.not. present(columns)) return
      columns(n) = column_type(name, unit)
      if (present(contact)) columns(n)%name = name//'_'//contact_name(contact)
    end subroutine add

  end subroutine list_columns

  !> Names and units of the columns.
  subroutine name_columns(rigid, columns, n)
    logical, intent(in) :: rigid                 !! impulses and lost energy, too
    type(column_type), intent(out) :: columns(most_columns)
    integer, intent(out) :: n
    type(row_type) :: row
    real(dp) :: values(most_columns)

    row%rigid = rigid
    call list_columns(row, values, n, columns)
  end subroutine name_columns

  !> The quantities of one contact in a row: angle, N, Fy, Fz, y, z, radius.
  pure subroutine contact_columns(pair, q, state, c, row)
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

end module columns
