!> Pose, velocity, acceleration and contacts of the wheelset at one instant of a run.
module motion_state
  use kinds, only: dp
  use wheelset, only: external_force, left_flange, left_tread, right_flange, right_tread, wheelset_type
  implicit none
  private
  public :: motion_type, contact_state, closed, total, energy_change, energy_rounding

  !> The contacts in one pose.
  type :: contact_state
    real(dp) :: energy(4) = 0          !! elastic energy of each contact [J]
    real(dp) :: slope(3, 4) = 0        !! dU/dq of each: minus force and moment of the rail on the wheel
    real(dp) :: gradient(3) = 0        !! their sum [N, N, N m]
    real(dp) :: hessian(6) = 0         !! second derivatives of the energy: yy, yz, y roll, zz, z roll, roll roll; 0 if not wanted
    integer :: status = 0              !! of `zone_tables`; 0: the pose is on the table
    logical :: shared(2) = .false.     !! a patch of the left or of the right wheel is on tread and flange
    ! Rigid contacts have no energy. These flags say that a contact is closed, that it has just had an impulse, or that its
    ! force is negative because the rail holds the wheel down.
    logical, dimension(4) :: rigid = .false., struck = .false., pulls = .false.
  end type contact_state

  type :: motion_type
    real(dp) :: t = 0                  !! [s]
    real(dp) :: q(3) = 0               !! y, z [m], roll [rad]
    real(dp) :: v(3) = 0               !! dq/dt
    real(dp) :: a(3) = 0               !! accelerations
    real(dp) :: error = 0              !! estimate of the last step's error of the position, see `integrators` [m]
    real(dp) :: jerk(3) = 0            !! growth of the accelerations in the last implicit step, which predicts the next one
    real(dp) :: work = 0               !! work of the lateral force since the start [J]
    real(dp) :: push(4) = 0            !! integral of each normal force since the start, with the impulses of impacts [N s]
    type(contact_state) :: contact = contact_state()    !! at q
    ! The next components are for rigid contacts.
    real(dp) :: impulse(4) = 0         !! impulses of all impacts so far, by contact [N s]
    real(dp) :: loss = 0               !! energy lost in impacts so far [J]
    real(dp) :: remainder(3) = 0       !! Kahan remainder of q in free flight, without which 1e4 steps lose 1e-9 J
  end type motion_type

contains

  !> Which contacts carry a force.
  pure function closed(state)
    type(contact_state), intent(in) :: state
    logical :: closed(4)

    closed = state%energy > 0 .or. state%rigid
  end function closed

  !> Sum over the contacts. Left and right are summed apart, so that the mirrored run rounds in the same way.
  pure function total(slope)
    real(dp), intent(in) :: slope(3, 4)
    real(dp) :: total(3)

    total = (slope(:, left_tread) + slope(:, left_flange)) + (slope(:, right_tread) + slope(:, right_flange))
  end function total

  !> Change of the total energy in a step, less the work of the lateral force [J]. The exact motion has zero. Left and right
  !> are summed separately, so that the mirrored run rounds in the same way.
  pure real(dp) function energy_change(w, old, new) result(change)
    class(wheelset_type), intent(in) :: w
    type(motion_type), intent(in) :: old, new

    change = 0.5_dp*sum(w%inertia()*(new%v - old%v)*(new%v + old%v)) + w%weight()*(new%q(2) - old%q(2)) &
      + elastic_change(old%contact, new%contact) - (new%work - old%work)
  end function energy_change

  !> Change of the contacts' elastic energy [J].
  pure real(dp) function elastic_change(old, new) result(change)
    type(contact_state), intent(in) :: old, new

    change = sum(new%energy(:2) - old%energy(:2)) + sum(new%energy(3:) - old%energy(3:))
  end function elastic_change

  !> Change of the total energy that rounding of the pose can cause [J].
  pure real(dp) function energy_rounding(w, motion)
    class(wheelset_type), intent(in) :: w
    type(motion_type), intent(in) :: motion
    real(dp) :: forces(3)

    forces = total(abs(motion%contact%slope)) + abs(external_force(w, motion%t))
    energy_rounding = 4*epsilon(1.0_dp)*dot_product(forces, abs(motion%q))
  end function energy_rounding

end module motion_state
