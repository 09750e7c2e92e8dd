!> The wheelset on its two rails: inertia, loads, and the elastic potential of all four contacts as a function of the pose
!> q = (y, z, roll).
module wheelset
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use kinds, only: dp, gravity, pi
  use root_bracket, only: bracket_type
  use contact_table, only: find_roll, table_type, wheel_force
  use table_growth, only: grown_potential
  use zone_tables, only: inside, roll_type
  use wheel_rail_pair, only: mirror
  implicit none
  private
  public :: wheelset_type, contact_state, closed, contacts, total, external_force, symmetric, settle, hold, find_rest, &
    small_oscillations, contact_name
  public :: left_tread, left_flange, right_tread, right_flange, treads, flanges, outwards, other_side

  type :: wheelset_type
    real(dp) :: mass = 0               !! [kg]
    real(dp) :: roll_inertia = 0       !! [kg m^2]
    real(dp) :: pitch_inertia = 0      !! [kg m^2]
    real(dp) :: vertical_load = 0      !! downwards, without inertia, at the centre of gravity [N]
    real(dp) :: lateral_force = 0      !! at the centre of gravity, track frame, at t = 0 [N]
    real(dp) :: lateral_ramp = 0       !! growth of the lateral force [N/s]
    !> Contact tables of both sides, each made as for a left side.  Both pointers may lead to one table, and wheelsets may
    !> share tables.  The procedure that makes a table also frees it.
    type(table_type), pointer :: table => null(), right_table => null()
  contains
    procedure :: inertia
    procedure :: weight
  end type wheelset_type

  integer, parameter :: left_tread = 1, left_flange = 2, right_tread = 3, right_flange = 4
  integer, parameter :: treads(2) = [left_tread, right_tread], flanges(2) = [left_flange, right_flange]   !! by side
  integer, parameter :: outwards(2) = [1, -1]   !! sign of y on the left and on the right side
  integer, parameter :: other_side(4) = [right_tread, right_flange, left_tread, left_flange]   !! by contact
  character(2), parameter :: contact_name(4) = ['LT', 'LF', 'RT', 'RF']

  interface
    subroutine dsyev(jobz, uplo, n, a, lda, w, work, lwork, info)
      import :: dp
      character, intent(in) :: jobz, uplo
      integer, intent(in) :: n, lda, lwork
      real(dp), intent(inout) :: a(lda, *)
      real(dp), intent(out) :: w(*), work(*)
      integer, intent(out) :: info
    end subroutine dsyev
  end interface

  !> The contacts in one pose.
  type :: contact_state
    real(dp) :: energy(4) = 0          !! elastic energy of each contact [J]
    real(dp) :: slope(3, 4) = 0        !! dU/dq of each: minus force and moment of the rail on the wheel
    real(dp) :: gradient(3) = 0        !! their sum [N, N, N m]
    real(dp) :: hessian(6) = 0         !! second derivatives of the energy: yy, yz, y roll, zz, z roll, roll roll; 0 if not wanted
    integer :: status = inside         !! whether the pose is on the table
    logical :: shared(2) = .false.     !! a patch of the left or of the right wheel is on tread and flange
    ! Rigid contacts have no energy. These flags say that a contact is closed, that it has just had an impulse, or that its
    ! force is negative because the rail holds the wheel down.
    logical, dimension(4) :: rigid = .false., struck = .false., pulls = .false.
  end type contact_state

contains

  !> Diagonal of the mass matrix of q = (y, z, roll).
  pure function inertia(this)
    class(wheelset_type), intent(in) :: this
    real(dp) :: inertia(3)

    inertia = [this%mass, this%mass, this%roll_inertia]
  end function inertia

  !> Weight of the wheelset and vertical load [N].
  pure real(dp) function weight(this)
    class(wheelset_type), intent(in) :: this

    weight = this%mass*gravity + this%vertical_load
  end function weight

  !> Gravity, vertical load and lateral force at time t, as a force on q.
  pure function external_force(this, t) result(f)
    class(wheelset_type), intent(in) :: this
    real(dp), intent(in) :: t            !! [s]
    real(dp) :: f(3)

    f = [this%lateral_force + this%lateral_ramp*t, -this%weight(), 0.0_dp]
  end function external_force

  !> Which contacts carry a force.
  pure function closed(state)
    type(contact_state), intent(in) :: state
    logical :: closed(4)

    closed = state%energy > 0 .or. state%rigid
  end function closed

  !> Potential of the contacts of both wheels or of one wheel, with its Hessian unless `with_hessian` is false. The contacts of the
  !> other wheel are zero. The tables grow where the pose needs it.
  subroutine contacts(this, q, state, with_hessian, wheel)
    type(wheelset_type), intent(in) :: this
    real(dp), intent(in) :: q(3)         !! axle centre y, z [m], roll [rad]; track frame
    type(contact_state), intent(out) :: state
    logical, intent(in), optional :: with_hessian
    integer, intent(in), optional :: wheel   !! 1 left, 2 right; 0 or absent: both
    type(roll_type) :: roll, opposite, unused
    type(wheel_force) :: left, right
    real(dp), parameter :: mirror_hessian(6) = [1, -1, 1, 1, -1, 1]
    integer :: only, status, i
    logical :: wanted

    wanted = .true.
    if (present(with_hessian)) wanted = with_hessian
    only = 0
    if (present(wheel)) only = wheel
    call find_roll(this%table, q(3), wanted, roll, opposite, state%status)
    if (.not. associated(this%right_table, this%table) .and. state%status == inside) &
      call find_roll(this%right_table, q(3), wanted, unused, opposite, state%status)
    if (state%status /= inside) return
    if (only /= 2) then
      call grown_potential(this%table, q, roll, wanted, left, state%status)
      state%energy(:2) = left%energy
      state%slope(:, :2) = left%gradient
    end if
    if (only /= 1) then
      ! The right wheel is solved as the mirror image of a left one.
      call grown_potential(this%right_table, mirror*q, opposite, wanted, right, status)
      state%energy(3:) = right%energy
      do i = 1, 2
        state%slope(:, i + 2) = mirror*right%gradient(:, i)
      end do
      if (status /= inside) state%status = status
    end if
    state%gradient = left%total + mirror*right%total
    state%hessian = left%hessian + mirror_hessian*right%hessian
    state%shared = [left%shared, right%shared]
  end subroutine contacts

  !> The matrix of a Hessian yy, yz, y roll, zz, z roll, roll roll.
  pure function symmetric(h) result(a)
    real(dp), intent(in) :: h(6)
    real(dp) :: a(3, 3)

    a(:, 1) = h(1:3)
    a(:, 2) = [h(2), h(4), h(5)]
    a(:, 3) = [h(3), h(5), h(6)]
  end function symmetric

  !> Sum over the contacts. Left and right are summed apart, so that the mirrored run rounds in the same way.
  pure function total(slope)
    real(dp), intent(in) :: slope(3, 4)
    real(dp) :: total(3)

    total = (slope(:, left_tread) + slope(:, left_flange)) + (slope(:, right_tread) + slope(:, right_flange))
  end function total

  !> Equilibrium of the wheelset that is held at the lateral position of `q`, where its rigid wheels stand on both rails. A pose
  !> in which the rails push more than the weight is searched downwards; from there on `hold` finds the equilibrium.
  subroutine settle(this, q, ok)
    type(wheelset_type), intent(in) :: this
    real(dp), intent(inout) :: q(3)      !! y, z [m], roll [rad]
    logical, intent(out) :: ok
    type(contact_state) :: state
    real(dp) :: high, step, force

    ok = .false.
    high = q(2) + 1e-4_dp
    step = 5e-5_dp
    do while (step > 1e-9_dp .and. .not. ok)
      q(2) = high - step
      call contacts(this, q, state)
      if (state%status /= inside) then
        step = step/2
      else if (-state%gradient(2) > this%weight()) then
        ok = .true.
      else
        high = q(2)
      end if
    end do
    if (ok) call hold(this, q, force, ok)
  end subroutine settle

  !> Height and roll at which the wheelset, held at its lateral position, is in equilibrium: Newton's method from a
  !> pose in which both wheels are pressed in.
  subroutine hold(this, q, force, ok)
    type(wheelset_type), intent(in) :: this
    real(dp), intent(inout) :: q(3)
    real(dp), intent(out) :: force       !! force of the rails on the wheelset, to the left [N]
    logical, intent(out) :: ok
    real(dp), parameter :: longest = 2e-5_dp      ! step [m, rad]
    real(dp), parameter :: balanced = 1e-12_dp    ! of the weight [1, m]
    type(contact_state) :: state
    real(dp) :: up, moment, det, move(2)
    integer :: iter

    ok = .false.
    force = 0
    do iter = 1, 200
      call contacts(this, q, state)
      if (state%status /= inside) return
      force = -state%gradient(1)
      up = -state%gradient(2) - this%weight()
      moment = -state%gradient(3)
      ok = abs(up) + abs(moment) <= balanced*this%weight()
      if (ok) return
      associate (zz => state%hessian(4), zr => state%hessian(5), rr => state%hessian(6))
        det = zz*rr - zr**2
        if (.not. det > 0) return
        move = [up*rr - moment*zr, moment*zz - up*zr]/det
      end associate
      ! Between stiff wheels the rounding of the pose alone leaves a larger force.
      ok = maxval(abs(move)) <= epsilon(move)
      if (ok) return
      q(2:) = q(2:) + move*min(1.0_dp, longest/maxval(abs(move)))
    end do
  end subroutine hold

  !> Pose of rest of the free wheelset, found downhill from the equilibrium at the track's centre.
  subroutine find_rest(this, centred, q, ok)
    type(wheelset_type), intent(in) :: this
    real(dp), intent(in) :: centred(3)   !! equilibrium of the wheelset that is held at y = 0
    real(dp), intent(out) :: q(3)
    logical, intent(out) :: ok
    real(dp), parameter :: stride = 1e-4_dp, farthest = 0.05_dp   ! [m]
    type(bracket_type) :: range
    real(dp) :: start, force, before, from(3)
    integer :: iter

    q = centred
    call hold(this, q, start, ok)
    before = start
    force = start
    from = q
    do while (ok .and. start*force > 0)
      from = q
      before = force
      q(1) = q(1) + sign(stride, start)
      ok = abs(q(1)) < farthest
      if (ok) call hold(this, q, force, ok)
    end do
    if (.not. ok .or. abs(force) <= 0) return
    range = bracket_type(from(1), before, q(1), force)
    do iter = 1, 100
      q(1) = range%guess()
      call hold(this, q, force, ok)
      if (.not. ok .or. abs(force) <= 1e-10_dp*this%weight() .or. abs(range%b - range%a) <= 1e-15_dp) return
      call range%narrow(q(1), force)
    end do
  end subroutine find_rest

  !> Small oscillations about an equilibrium, K x = omega^2 M x with the exact tangent K of the contact potential:
  !> frequencies [Hz], ascending (an unstable one as minus its growth rate/2 pi), and the modes y, z, roll in the columns
  !> of `shapes`, of unit modal mass.
  subroutine small_oscillations(w, q, frequency, shapes)
    type(wheelset_type), intent(in) :: w
    real(dp), intent(in) :: q(3)           !! y, z [m], roll [rad]
    real(dp), intent(out) :: frequency(3), shapes(3, 3)
    type(contact_state) :: state
    real(dp) :: root(3), work(15)
    integer :: info, i

    call contacts(w, q, state)
    shapes = symmetric(state%hessian)
    root = sqrt(w%inertia())
    do i = 1, 3
      shapes(:, i) = shapes(:, i)/(root*root(i))
    end do
    call dsyev('V', 'U', 3, shapes, 3, frequency, work, size(work), info)
    if (info /= 0) frequency = ieee_value(1.0_dp, ieee_quiet_nan)
    frequency = sign(sqrt(abs(frequency)), frequency)/(2*pi)
    do i = 1, 3
      shapes(:, i) = shapes(:, i)/root
    end do
  end subroutine small_oscillations

end module wheelset