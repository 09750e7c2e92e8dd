!> Which poses a run can come to, and how exact the table has to be there.
!>
!> In service the wheelset runs between its flanges, or is lifted a little; going
!> over, it lies on one flange and turns over the rail, until it has derailed; every
!> other pose has its contacts elsewhere, or the wheelset has derailed before.
module reach
  use geometry, only: pair_type, rolled
  use kinds, only: dp
  use potential, only: contact_table, find_roll, height_over, inside, roll_type
  implicit none
  private
  public :: extent_type, going_over, strictness, other_depth, within_reach

  !> Extent of the table and of what runs reach of it.
  type :: extent_type
    real(dp) :: lateral = 60e-3_dp      !! shift of the wheel to either side [m]
    real(dp) :: lift = 40e-3_dp         !! of the wheel; higher it cannot touch [m]
    real(dp) :: drop = 10e-3_dp         !! of the wheel below its running height [m]
    real(dp) :: roll = 0.5_dp           !! to either side [rad]
    real(dp) :: depth = 2.2e-3_dp       !! largest penetration [m]
    real(dp) :: clearance = 10e-3_dp    !! of the flanges, one side [m]
  end type extent_type

  real(dp), parameter :: service_roll = 0.02_dp, service_shift = 3e-3_dp   ! beyond the clearance [rad, m]
  real(dp), parameter :: last_roll = 0.25_dp                               ! of a wheelset that goes over [rad]
  real(dp), parameter :: derailed = 3e-3_dp                                ! flange tip past the gauge face [m]
  real(dp), parameter :: going_over = 10     ! errors allowed there, of those in service
  real(dp), parameter :: deepest = 0.3_dp    ! penetration in two zones at once, and of the tread, of the largest

contains

  !> Errors allowed in a pose of the left wheel, of those in service; 0 where no run comes.
  pure real(dp) function strictness(pair, extent, pose)
    type(pair_type), intent(in) :: pair
    type(extent_type), intent(in) :: extent
    real(dp), intent(in) :: pose(3)
    real(dp) :: tip(2)

    strictness = 0
    if (abs(pose(3)) <= service_roll .and. abs(pose(1)) <= extent%clearance + service_shift) then
      strictness = 1
    else if (pose(3) > -last_roll .and. pose(3) <= service_roll) then
      tip = pose(:2) + rolled(pair%flange_tip, pose(3))
      if (tip(1) < pair%gauge_face + derailed .or. tip(2) < 0) strictness = going_over
    end if
  end function strictness

  !> Penetration of the deepest of the other zones in a pose [m]; negative where none touches.
  pure real(dp) function other_depth(table, zone, pose) result(depth)
    type(contact_table), intent(in) :: table
    integer, intent(in) :: zone
    real(dp), intent(in) :: pose(3)
    type(roll_type) :: roll, opposite
    integer :: i, status

    depth = -1
    call find_roll(table, pose(3), .false., roll, opposite, status)
    if (status /= inside) return
    do i = 1, size(table%zones)
      if (i /= zone) depth = max(depth, height_over(table%zones(i), pose, roll))
    end do
  end function other_depth

  !> Whether a run can press a zone so deep while the deepest of the others is pressed by `other`.
  pure logical function within_reach(extent, flange, depth, other, margin)
    type(extent_type), intent(in) :: extent
    logical, intent(in) :: flange
    real(dp), intent(in) :: depth, other     !! [m]
    real(dp), intent(in) :: margin           !! times the limits

    within_reach = other <= margin*deepest*extent%depth .and. (flange .or. depth <= margin*deepest*extent%depth) &
      .and. (other <= 0 .or. depth <= 2*margin*deepest*extent%depth)
  end function within_reach

end module reach
