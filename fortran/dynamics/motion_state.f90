!> Pose, velocity, acceleration and contact forces of the wheelset at one instant of a run.
module motion_state
  use kinds, only: dp
  use wheelset, only: contact_state
  implicit none
  private
  public :: motion_type

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

end module motion_state
