!> The wheelset as a rigid body: inertia and loads, and how its four contacts are numbered.
module wheelset
  use kinds, only: dp, gravity
  implicit none
  private
  public :: wheelset_type, external_force
  public :: contact_name, left_tread, left_flange, right_tread, right_flange, treads, flanges, outwards, other_side

  type :: wheelset_type
    real(dp) :: mass = 0               !! [kg]
    real(dp) :: roll_inertia = 0       !! [kg m^2]
    real(dp) :: pitch_inertia = 0      !! [kg m^2]
    real(dp) :: vertical_load = 0      !! downwards, without inertia, at the centre of gravity [N]
    real(dp) :: lateral_force = 0      !! at the centre of gravity, track frame, at t = 0 [N]
    real(dp) :: lateral_ramp = 0       !! growth of the lateral force [N/s]
  contains
    procedure :: inertia
    procedure :: weight
  end type wheelset_type

  integer, parameter :: left_tread = 1, left_flange = 2, right_tread = 3, right_flange = 4
  integer, parameter :: treads(2) = [left_tread, right_tread], flanges(2) = [left_flange, right_flange]   !! by side
  integer, parameter :: outwards(2) = [1, -1]   !! sign of y on the left and on the right side
  integer, parameter :: other_side(4) = [right_tread, right_flange, left_tread, left_flange]   !! by contact
  character(2), parameter :: contact_name(4) = ['LT', 'LF', 'RT', 'RF']

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

end module wheelset