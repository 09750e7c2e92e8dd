!> Poses that a run can reach, and how large the table's error may be there.
!>
!> In service the wheelset runs between its flanges, or is lifted a little. A wheelset that rolls over the rail first
!> stands on one flange, until the flange's tip is outside the rail's highest point and it has derailed. In every other
!> pose the contacts are elsewhere, or the wheelset has derailed before.
module service_poses
  use contact_zones, only: side_type
  use wheel_rail_pair, only: mirror, rolled
  use kinds, only: dp
  use contact_table, only: table_type, find_roll
  use zone_tables, only: inside, roll_type, zone_penetration
  implicit none
  private
  public :: extent_type, request_type, margin_roll, tread_share, force_floor, floored_force, rollover_allowance
  public :: error_allowance, find_allowance, estimated_force, fit_extent

  !> Extent of the table, which a case may change, and what says which part of it a run on this track reaches.
  type :: extent_type
    real(dp) :: lateral = 80e-3_dp      !! shift of the wheel to either side [m]
    real(dp) :: lift = 40e-3_dp         !! largest lift of a wheel; higher it cannot touch [m]
    real(dp) :: drop = 10e-3_dp         !! largest drop of a wheel below its running height [m]
    real(dp) :: roll = 0.5_dp           !! to either side [rad]
    real(dp) :: depth = 2.2e-3_dp       !! largest penetration [m]
    real(dp) :: clearance = 10e-3_dp    !! flange clearance of one side [m]
    real(dp) :: service_roll = 0.02_dp  !! roll angle in service, to either side [rad]
    ! A wheelset that rolls over the left rail has roll angles from -largest_roll to small_roll [rad].
    real(dp) :: small_roll = 0.05_dp, largest_roll = 0.38_dp
    real(dp) :: lever = 0.75_dp         !! of a wheel's force about X [m]
  end type extent_type

  !> What a contact table is to be made for.
  type :: request_type
    type(side_type), pointer :: side => null()   !! wheel and rail
    character(9) :: model = ''          !! 'strip', 'hertz' or 'halfspace'
    character(5) :: influence = ''      !! of half-spaces: 'local', 'flat' or 'apart'
    real(dp) :: e_star = 0              !! [Pa]
    type(extent_type) :: extent
    real(dp) :: accuracy = 0            !! error of the force allowed in service, relative to the force
    integer :: most(3) = 0              !! points of u, roll and q, at most
  end type request_type

  real(dp), parameter :: service_shift = 7.5e-3_dp   ! lateral displacement in service, beyond the clearance [m]
  real(dp), parameter :: tip_margin = 1e-3_dp   ! derailed: the flange's tip is so far outside the rail's highest point [m]
  real(dp), parameter :: rollover_allowance = 10   ! errors allowed in rolling over, relative to service
  ! Largest penetrations, as shares of the table's depth: of the tread; of the shallower and the deeper of two zones that
  ! touch at once; of a third zone; of any zone in rolling over.
  real(dp), parameter :: tread_share = 0.45_dp, shallower_share = 0.25_dp, deeper_share = 0.7_dp, third_share = 0.05_dp, &
    rollover_share = 0.33_dp

  ! Errors are relative to the force, but at least to this one [N].
  real(dp), parameter :: force_floor = 5e3_dp
  character(*), parameter :: floored_force = 'max(|F|, 5 kN)'
  ! Splines need some points outside the poses that runs reach [rad, m, m].
  real(dp), parameter :: margin_roll = 0.01_dp, margin_shift = 2e-3_dp, margin_height = 6e-3_dp
  real(dp), parameter :: margin_depth = 1.5_dp  ! factor on the depths of zones that touch at once, or in rolling over

contains

  !> Fit what a run reaches to the flange clearance of one side and to the track gauge [m]: the rise of a wheel is the same on
  !> every track, so roll angles go with 1/gauge; that of a wheelset going over was 0.44, 0.35 and 0.30 rad at 1, 1.4351 and
  !> 1.668 m.
  pure subroutine fit_extent(clearance, gauge, extent)
    real(dp), intent(in) :: clearance, gauge
    type(extent_type), intent(inout) :: extent
    real(dp), parameter :: standard = 1.4351_dp   ! gauge of the roll angles and the lever in `extent_type` [m]

    extent%clearance = clearance
    extent%service_roll = extent%service_roll*(standard/gauge)
    extent%small_roll = extent%small_roll*(standard/gauge)
    extent%largest_roll = min(extent%roll, extent%largest_roll*(standard/gauge))
    extent%lever = extent%lever*(gauge/standard)
  end subroutine fit_extent

  !> Estimate the force [N] of a contact, not known yet, at a penetration [m]: Hertz's force on bodies with a relative radius
  !> of curvature of about 0.3 m.
  elemental real(dp) function estimated_force(e_star, penetration) result(force)
    real(dp), intent(in) :: e_star, penetration   !! [Pa, m]
    real(dp), parameter :: factor = 0.7_dp        ! [sqrt(m)]

    force = factor*e_star*max(penetration, 0.0_dp)**1.5_dp
  end function estimated_force

  !> Error allowance at a pose of the left wheel, relative to the service poses: 1 in service, 10 in rolling over; 0 if
  !> no run reaches the pose.
  pure real(dp) function error_allowance(request, pose, with_margin)
    type(request_type), intent(in) :: request
    real(dp), intent(in) :: pose(3)        !! y, z, roll [m, rad]
    logical, intent(in) :: with_margin     !! whether the points around the reachable poses count
    real(dp) :: tip(2), tip_opposite(2), roll_more, shift_more
    logical :: reached

    error_allowance = 0
    roll_more = merge(margin_roll, 0.0_dp, with_margin)
    shift_more = merge(margin_shift, 0.0_dp, with_margin)
    if (abs(pose(3)) <= request%extent%service_roll + roll_more &
      .and. abs(pose(1)) <= request%extent%clearance + service_shift + shift_more) then
      error_allowance = 1
    else if (pose(3) > -request%extent%largest_roll - roll_more .and. pose(3) <= request%extent%small_roll + roll_more) then
      ! Neither flange is outside its rail's crown; at larger angles the wheelset turns about the left rail.
      associate (pair => request%side%pair)
        tip = pose(:2) + rolled(pair%flange_tip, pose(3))
        tip_opposite = [-pose(1), pose(2)] + rolled(pair%flange_tip, -pose(3))
        reached = max(tip(1), tip_opposite(1)) - pair%crown < tip_margin + shift_more
        if (pose(3) < -request%extent%small_roll - roll_more) reached = reached .and. &
          pose(1) + pair%axle_height*sin(pose(3)) > -shift_more
      end associate
      if (reached) error_allowance = rollover_allowance
    end if
  end function error_allowance

  !> Error allowance at a pose in which a zone of the left wheel is pressed by `depth`: that of the pose, or 0 if no run presses
  !> the zone so. Only one zone of the left wheel may lie deep inside the rail, a second one less, a third one hardly, and the
  !> right wheel may not. Poses off the table's roll axis are not reachable.
  pure subroutine find_allowance(request, table, zone, depth, pose, with_margin, allowance, deepest_other, depths)
    type(request_type), intent(in) :: request
    type(table_type), intent(in) :: table
    integer, intent(in) :: zone
    real(dp), intent(in) :: depth, pose(3)     !! [m, rad]
    logical, intent(in) :: with_margin         !! whether the points around the reachable poses count
    real(dp), intent(out) :: allowance
    real(dp), intent(out) :: deepest_other     !! largest penetration of the left wheel's other zones [m]; negative if none touches
    !> Penetrations of the zones of the left and right wheel (zone, wheel) [m]; without them the table gives them.
    real(dp), intent(in), optional :: depths(:, :)
    type(roll_type) :: roll, opposite
    real(dp) :: shallower, deeper, tread, third_most, found, third, second, deepest
    integer :: i, status
    logical :: reachable

    allowance = 0
    deepest_other = -1
    if (error_allowance(request, pose, with_margin) <= 0) return
    associate (extent => request%extent)
      shallower = shallower_share*extent%depth*merge(margin_depth, 1.0_dp, with_margin)
      deeper = deeper_share*extent%depth*merge(margin_depth, 1.0_dp, with_margin)
      third_most = third_share*extent%depth*merge(3.0_dp, 1.0_dp, with_margin)
      tread = tread_share*extent%depth
      if (abs(pose(3)) > extent%service_roll + margin_roll) then
        tread = rollover_share*extent%depth
        deeper = min(deeper, margin_depth*tread)
        shallower = min(shallower, tread/2)
        reachable = depth <= tread*merge(margin_depth, 1.0_dp, with_margin)
      else
        reachable = table%zones(zone)%past_root .or. depth <= tread*merge(1.2_dp, 1.0_dp, with_margin)
      end if
      if (.not. reachable) return
      call find_roll(table, pose(3), .false., roll, opposite, status)
      if (status /= inside) return
      deepest = depth
      second = -1
      third = -1
      do i = 1, size(table%zones)
        if (i == zone) cycle
        if (present(depths)) then
          found = depths(i, 1)
        else
          found = zone_penetration(table%zones(i), pose, roll)
        end if
        deepest_other = max(deepest_other, found)
        third = max(third, min(second, found))
        second = max(second, min(deepest, found))
        deepest = max(deepest, found)
        if (second > shallower .or. (second > 0 .and. deepest > deeper) .or. third > third_most) return
        if (.not. table%zones(i)%past_root .and. found > tread*merge(1.2_dp, 1.0_dp, with_margin)) return
      end do
      do i = 1, size(table%zones)
        if (present(depths)) then
          found = depths(i, 2)
        else
          found = zone_penetration(table%zones(i), mirror*pose, opposite)
        end if
        if (found > merge(extent%depth, tread, table%zones(i)%past_root) + merge(margin_height, 0.0_dp, with_margin)) return
      end do
    end associate
    allowance = error_allowance(request, pose, with_margin)
  end subroutine find_allowance

end module service_poses
