!> Elastic contacts of the wheelset with both rails: the potential of all four contacts as a function of the pose q = (y, z, roll), by
!> contact tables, and the poses and frequencies that follow from it.
module elastic_contacts
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use contact_table, only: find_roll, table_type, wheel_force
  use kinds, only: dp, pi
  use motion_state, only: contact_state
  use root_bracket, only: bracket_type
  use table_growth, only: grown_potential
  use wheel_rail_pair, only: mirror
  use wheelset, only: wheelset_type
  use zone_tables, only: inside, roll_type
  implicit none
  private
  public :: elastic_wheelset, contacts, symmetric, settle, hold, find_rest, small_oscillations

  type, extends(wheelset_type) :: elastic_wheelset
    !> Contact tables of both sides, each made as for a left side.  Both pointers may lead to one table, and wheelsets may
    !> share tables.  The procedure that makes a table also frees it.
    type(table_type), pointer :: table => null(), right_table => null()
  end type elastic_wheelset

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

contains

  !> Potential of the contacts of both wheels or of one wheel, with its Hessian unless `with_hessian` is false. The contacts of the
  !> other wheel are zero. The tables grow where the pose needs it.
  subroutine contacts(this, q, state, with_hessian, wheel)
    type(elastic_wheelset), intent(in) :: this
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

  !> Equilibrium of the wheelset that is held at the lateral position of `q`, where its rigid wheels stand on both rails. A pose
  !> in which the rails push more than the weight is searched downwards; from there on `hold` finds the equilibrium.
  subroutine settle(this, q, ok)
    type(elastic_wheelset), intent(in) :: this
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
    type(elastic_wheelset), intent(in) :: this
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
    type(elastic_wheelset), intent(in) :: this
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
    type(elastic_wheelset), intent(in) :: w
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

end module elastic_contacts
