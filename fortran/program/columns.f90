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
  use case, only: case_type
  use curve, only: curve_point, near_interval
  use kinds, only: dp, gravity
  use motion_state, only: closed, contact_state, motion_type
  use run_setup, only: setup_type
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use wheel_rail_pair, only: pair_type, rolled, wheel_station
  use wheelset, only: contact_name, external_force, right_tread
  implicit none
  private
  public :: column_type, column_width, most_columns, energy_type, energies, list_columns, contact_columns

  integer, parameter :: column_width = 16     !! characters of a name, a unit, a number
  integer, parameter :: most_columns = 64

  type :: column_type
    character(column_width) :: name, unit
  end type column_type

  !> Energies of a motion [J].
  type :: energy_type
    real(dp) :: kinetic(5) = 0       !! longitudinal, lateral, vertical, roll, pitch
    real(dp) :: gravity = 0, load = 0   !! from static equilibrium
    real(dp) :: elastic(2) = 0       !! left, right
    real(dp) :: total = 0            !! left and right are added first, so that the mirrored run has the same sum, bit by bit
  end type energy_type

contains

  pure type(energy_type) function energies(c, setup, motion) result(e)
    type(case_type), intent(in) :: c
    type(setup_type), intent(in) :: setup
    type(motion_type), intent(in) :: motion
    real(dp) :: rise

    associate (w => setup%wheelset)
      rise = motion%q(2) - setup%equilibrium(2)
      e%kinetic = 0.5_dp*[w%mass*c%vx**2, w%inertia()*motion%v**2, w%pitch_inertia*c%pitch_rate**2]
      e%gravity = rise*(w%mass*gravity)
      e%load = rise*w%vertical_load
    end associate
    e%elastic = [sum(motion%contact%energy(:2)), sum(motion%contact%energy(3:))]
    e%total = sum([e%kinetic, e%gravity, e%load]) + (e%elastic(1) + e%elastic(2))
  end function energies

  !> The list of columns: values in order and, if the caller asks for them, names and units, and the stations of the wheels at
  !> which the contacts act. The order is defined here only.
  subroutine list_columns(c, setup, motion, first_energy, values, n, columns, stations)
    type(case_type), intent(in) :: c
    type(setup_type), intent(in) :: setup
    type(motion_type), intent(in) :: motion
    real(dp), intent(in) :: first_energy   !! total energy at the start [J]
    real(dp), intent(out) :: values(most_columns)
    integer, intent(out) :: n
    type(column_type), intent(out), optional :: columns(most_columns)
    real(dp), intent(out), optional :: stations(4)   !! by contact [m]
    type(energy_type) :: e
    real(dp) :: force(3), acceleration(3), contact(7), station
    integer :: k

    force = external_force(setup%wheelset, motion%t)
    acceleration = (force - motion%contact%gradient)/setup%wheelset%inertia()
    e = energies(c, setup, motion)
    n = 0
    call add('time', 's', motion%t)
    call add('X', 'm', c%vx*motion%t)
    call add('Y', 'm', motion%q(1))
    call add('Z', 'm', motion%q(2) - setup%equilibrium(2))
    call add('roll', 'rad', motion%q(3) - setup%equilibrium(3))
    call add('pitch', 'rad', c%pitch + c%pitch_rate*motion%t)
    call add('vX', 'm/s', c%vx)
    call add('vY', 'm/s', motion%v(1))
    call add('vZ', 'm/s', motion%v(2))
    call add('roll_rate', 'rad/s', motion%v(3))
    call add('pitch_rate', 'rad/s', c%pitch_rate)
    call add('aY', 'm/s2', acceleration(1))
    call add('aZ', 'm/s2', acceleration(2))
    call add('roll_acc', 'rad/s2', acceleration(3))
    do k = 1, 4
      call contact_columns(setup%side(merge(2, 1, k >= right_tread))%pair, motion%q, motion%contact, k, contact, station)
      if (present(stations)) stations(k) = station
      call add('angle', 'rad', contact(1), k)
      call add('N', 'N', contact(2), k)
      call add('Fy', 'N', contact(3), k)
      call add('Fz', 'N', contact(4), k)
      call add('y', 'm', contact(5), k)
      call add('z', 'm', contact(6), k)
      call add('radius', 'm', contact(7), k)
    end do
    call add('F_ext', 'N', force(1))
    ! The yaw constraint carries this moment. It is about the wheelset's own vertical axis, which leans with the roll.
    call add('M_gyro', 'N.m', setup%wheelset%pitch_inertia*c%pitch_rate*motion%v(3))
    call add('KE_long', 'J', e%kinetic(1))
    call add('KE_lat', 'J', e%kinetic(2))
    call add('KE_vert', 'J', e%kinetic(3))
    call add('KE_roll', 'J', e%kinetic(4))
    call add('KE_pitch', 'J', e%kinetic(5))
    call add('PE_grav', 'J', e%gravity)
    call add('PE_load', 'J', e%load)
    call add('PE_elastic_L', 'J', e%elastic(1))
    call add('PE_elastic_R', 'J', e%elastic(2))
    call add('W_ext', 'J', motion%work)
    call add('E_total', 'J', e%total)
    call add('E_drift', 'J', e%total - motion%work - first_energy + motion%loss)
    if (c%formulation == 'elastic') return
    do k = 1, 4
      call add('P', 'N.s', motion%impulse(k), k)
    end do
    call add('E_lost', 'J', motion%loss)

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

  !> The quantities of one contact in a row: angle, N, Fy, Fz, y, z, radius.
  pure subroutine contact_columns(pair, q, state, contact, row, s)
    type(pair_type), intent(in) :: pair
    real(dp), intent(in) :: q(3)
    type(contact_state), intent(in) :: state
    integer, intent(in) :: contact           !! left tread to right flange
    real(dp), intent(out) :: row(7)
    real(dp), intent(out) :: s               !! station of the wheel at which the resultant acts [m]; 0 if the contact is open
    real(dp) :: force(3), in_wheel(2), roll, side, r(2), d1(2), d2(2), x(2), miss, slope
    real(dp) :: push
    logical :: shut(4)
    integer :: i, iter

    row = 0
    s = 0
    shut = closed(state)
    if (.not. shut(contact)) then
      row([1, 5, 6, 7]) = ieee_value(1.0_dp, ieee_quiet_nan)
      return
    end if
    side = merge(-1.0_dp, 1.0_dp, contact >= right_tread)
    push = merge(-1, 1, state%pulls(contact))
    force = -push*state%slope(:, contact)*[side, 1.0_dp, side]       ! as on the left wheel
    roll = side*q(3)
    row(1) = atan2(-force(1), force(2))
    row(2) = hypot(force(1), force(2))
    row(3) = push*side*force(1)
    row(4) = push*force(2)

    ! The point of the wheel about which the resultant has no moment. `in_wheel` is the resultant in the frame of the wheel.
    in_wheel = rolled(force(:2), -roll)
    s = wheel_station(pair, row(1) - roll)
    i = near_interval(pair%wheel, s)
    do iter = 1, 30
      call curve_point(pair%wheel, s, i, r, d1, d2)
      miss = r(1)*in_wheel(2) - r(2)*in_wheel(1) - force(3)
      slope = d1(1)*in_wheel(2) - d1(2)*in_wheel(1)
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
