!> What a contact table tabulates: the elastic law of one wheel on its rail, and how far the table reaches.
module contact_law
  use contact_zones, only: side_type
  use kinds, only: dp
  implicit none
  private
  public :: extent_type, law_type, force_floor, floored_force

  !> Extent of the table.
  type :: extent_type
    real(dp) :: lateral = 80e-3_dp      !! shift of the wheel to either side [m]
    real(dp) :: lift = 40e-3_dp         !! largest lift of a wheel; higher it cannot touch [m]
    real(dp) :: drop = 10e-3_dp         !! largest drop of a wheel below its running height [m]
    real(dp) :: roll = 0.5_dp           !! to either side [rad]
    real(dp) :: depth = 2.2e-3_dp       !! largest penetration [m]
  end type extent_type

  !> The elastic law of one wheel on its rail.
  type :: law_type
    type(side_type) :: side             !! wheel and rail
    character(9) :: model = ''          !! 'strip', 'hertz' or 'halfspace'
    character(6) :: influence = ''      !! of half-spaces: 'local', 'flat', 'apart' or 'bodies'
    real(dp) :: e_star = 0              !! [Pa]
    type(extent_type) :: extent
    real(dp) :: accuracy = 0            !! error of the force that is asked for, relative to the force
  end type law_type

  ! Errors are relative to the force, but at least to this one [N].
  real(dp), parameter :: force_floor = 5e3_dp
  character(*), parameter :: floored_force = 'max(|F|, 5 kN)'

end module contact_law
