!> Which poses a run can come to, and how exact the table has to be there.
!>
!> In service the wheelset runs between its flanges, or is lifted a little; going over, it stands on one flange or
!> rolls over the rail, until the flange's tip is outside the highest point of the rail and it has derailed. Every
!> other pose has its contacts elsewhere, or the wheelset has derailed before.
module service_poses
  use wheel_rail_pair, only: pair_type, rolled
  use kinds, only: dp
  use contact_table, only: table_type, find_roll, height_over, inside, roll_type
  implicit none
  private
  public :: extent_type, first_roll, last_roll, least_force, lever, strictness, find_reach

  !> Extent of the table and of what runs reach of it.
  type :: extent_type
    real(dp) :: lateral = 80e-3_dp      !! shift of the wheel to either side [m]
    real(dp) :: lift = 40e-3_dp         !! of the wheel; higher it cannot touch [m]
    real(dp) :: drop = 10e-3_dp         !! of the wheel below its running height [m]
    real(dp) :: roll = 0.5_dp           !! to either side [rad]
    real(dp) :: depth = 2.2e-3_dp       !! largest penetration [m]
    real(dp) :: clearance = 10e-3_dp    !! of the flanges, one side [m]
  end type extent_type

  real(dp), parameter :: service_roll = 0.02_dp, service_shift = 5e-3_dp   ! beyond the clearance [rad, m]
  real(dp), parameter :: first_roll = 0.05_dp, last_roll = 0.38_dp         ! of a wheelset that goes over [rad]
  real(dp), parameter :: past = 1e-3_dp         ! of the flange's tip past the rail's highest point [m]
  real(dp), parameter :: going_over = 10     ! errors allowed there, of those in service
  ! Penetrations of the largest: of the tread; of the shallower and the deeper of two zones at once; going over.
  real(dp), parameter :: of_tread = 0.45_dp, of_two = 0.25_dp, of_deeper = 0.7_dp, of_going_over = 0.33_dp

  real(dp), parameter :: least_force = 5e3_dp   ! that errors are compared with [N]
  real(dp), parameter :: lever = 0.75_dp        ! of a wheel's force about X [m]
  ! Surroundings of what counts, for splines want some points there.
  real(dp), parameter :: more_roll = 0.01_dp, more_shift = 2e-3_dp, more_height = 6e-3_dp   ! [rad, m, m]

contains

  !> Errors allowed in a pose of the left wheel, of those in service; 0 where no run comes.
  pure real(dp) function strictness(pair, extent, pose, around)
    type(pair_type), intent(in) :: pair
    type(extent_type), intent(in) :: extent
    real(dp), intent(in) :: pose(3)
    logical, intent(in) :: around          !! with the surroundings
    real(dp) :: tip(2), tip_opposite(2), more(2)
    logical :: reached

    strictness = 0
    more = 0
    if (around) more = [more_roll, more_shift]
    if (abs(pose(3)) <= service_roll + more(1) .and. abs(pose(1)) <= extent%clearance + service_shift + more(2)) then
      strictness = 1
    else if (pose(3) > -last_roll - more(1) .and. pose(3) <= first_roll + more(1)) then
      ! Neither flange is outside its rail's crown; rolled farther, the wheelset turns about the left rail.
      tip = pose(:2) + rolled(pair%flange_tip, pose(3))
      tip_opposite = [-pose(1), pose(2)] + rolled(pair%flange_tip, -pose(3))
      reached = max(tip(1), tip_opposite(1)) - pair%crown < past + more(2)
      if (pose(3) < -first_roll - more(1)) reached = reached .and. pose(1) + pair%axle_height*sin(pose(3)) > -more(2)
      if (reached) strictness = going_over
    end if
  end function strictness

  !> Whether a run can press a zone of the left wheel by `depth` in a pose: neither another of its zones nor the right
  !> wheel lies deep inside the rail.  `other` is the deepest of the other zones.
  pure subroutine find_reach(table, extent, zone, depth, pose, around, within, other, depths)
    type(table_type), intent(in) :: table
    type(extent_type), intent(in) :: extent
    integer, intent(in) :: zone
    real(dp), intent(in) :: depth, pose(3)     !! [m, rad]
    logical, intent(in) :: around              !! with the surroundings
    logical, intent(out) :: within
    real(dp), intent(out) :: other             !! [m]; negative where none touches
    real(dp), intent(in), optional :: depths(:, :)   !! of the zones of the left and right wheel [m], not by the table
    type(roll_type) :: roll, opposite
    real(dp) :: limit, deeper, tread, found
    integer :: i, status

    limit = of_two*extent%depth*merge(1.5_dp, 1.0_dp, around)
    deeper = of_deeper*extent%depth*merge(1.5_dp, 1.0_dp, around)
    tread = of_tread*extent%depth
    other = -1
    if (abs(pose(3)) > service_roll + more_roll) then
      tread = of_going_over*extent%depth
      deeper = min(deeper, 1.5_dp*tread)
      limit = min(limit, tread/2)
      within = depth <= tread*merge(1.5_dp, 1.0_dp, around)
    else
      within = table%zones(zone)%flange .or. depth <= tread*merge(1.2_dp, 1.0_dp, around)
    end if
    if (.not. within) return
    call find_roll(table, pose(3), .false., roll, opposite, status)
    within = status == inside
    if (.not. within) return
    do i = 1, size(table%zones)
      if (i == zone) cycle
      if (present(depths)) then
        found = depths(i, 1)
      else
        found = height_over(table%zones(i), pose, roll)
      end if
      other = max(other, found)
      within = min(depth, other) <= limit .and. (other <= 0 .or. max(depth, other) <= deeper)
      if (.not. table%zones(i)%flange) within = within .and. found <= tread*merge(1.2_dp, 1.0_dp, around)
      if (.not. within) return
    end do
    do i = 1, size(table%zones)
      if (present(depths)) then
        found = depths(i, 2)
      else
        found = height_over(table%zones(i), [-pose(1), pose(2), -pose(3)], opposite)
      end if
      within = found <= merge(extent%depth, tread, table%zones(i)%flange) + merge(more_height, 0.0_dp, around)
      if (.not. within) return
    end do
  end subroutine find_reach

end module service_poses