!> The setup that all runs with one wheelset on one track share: placed profiles, tables, equilibrium.
module run_setup
  use case, only: case_type
  use contact_zones, only: find_zones, side_type
  use errors, only: error_type, fatal_error
  use geometry_functions, only: clearance, rigid_contact
  use kinds, only: dp
  use profile, only: is_rail, is_wheel, profile_type, read_profile
  use text, only: str
  use placement, only: place_profiles
  use wheel_rail_pair, only: same_pair
  use wheelset, only: wheelset_type
  implicit none
  private
  public :: setup_type, prepare_geometry

  type :: setup_type
    type(profile_type) :: wheel(2), rail(2)   !! left, right
    type(side_type) :: side(2)         !! left, right
    logical :: symmetric = .true.      !! left and right have the same profiles
    type(wheelset_type) :: wheelset
    real(dp) :: centred(3) = 0         !! pose of the rigid wheelset on both rails at y = 0
    real(dp) :: equilibrium(3) = 0     !! static, held at y = 0: Z and roll are measured from it [m, m, rad]
    real(dp) :: rest(3) = 0            !! static equilibrium of the free wheelset [m, m, rad]
    integer :: modes = 3               !! number of eigenmodes: 1 with rigid contacts
    real(dp) :: frequency(3) = 0       !! eigenfrequencies at `rest`, ascending [Hz]
    real(dp) :: shapes(3, 3) = 0       !! modes y, z, roll in columns
    logical :: table_found = .false.   !! all tables were read from files
    real(dp) :: table_seconds = 0      !! processor time for the tables
  end type setup_type

contains

  !> Read the profiles and place them on the track: zones of the wheels, flange clearance, centred pose.
  subroutine prepare_geometry(c, setup, error)
    type(case_type), intent(in) :: c
    type(setup_type), intent(out) :: setup
    type(error_type), allocatable, intent(out) :: error
    real(dp) :: station(2)
    integer :: k
    logical :: ok

    call read_side('', '', setup%wheel(1), setup%rail(1), setup%side(1))
    if (allocated(error)) return
    if (c%wheel_profile_right == '' .and. c%rail_profile_right == '') then
      setup%wheel(2) = setup%wheel(1)
      setup%rail(2) = setup%rail(1)
      setup%side(2) = setup%side(1)
    else
      call read_side(trim(merge('_right', '      ', c%wheel_profile_right /= '')), &
        trim(merge('_right', '      ', c%rail_profile_right /= '')), setup%wheel(2), setup%rail(2), setup%side(2))
      if (allocated(error)) return
    end if
    setup%symmetric = same_pair(setup%side(1)%pair, setup%side(2)%pair)
    do k = 1, merge(1, 2, setup%symmetric)
      ! The right side is the left one of the mirror image. (gfortran never frees the copy of an array by a list of places.)
      call clearance(setup%side(k:3 - k:3 - 2*k), setup%side(k)%clearance, ok)
      if (ok) cycle
      call fatal_error(error, '&track gauge = '//str(c%gauge)//' m with &wheelset back_to_back = '// &
        str(c%back_to_back)//' m: expected a flange clearance between 0 and 0.05 m, found none')
      return
    end do
    setup%centred = [0.0_dp, setup%side(1)%pair%axle_height, 0.0_dp]
    if (setup%symmetric) then
      setup%side(2)%clearance = setup%side(1)%clearance
    else
      call rigid_contact(setup%side, 0.0_dp, setup%centred(3), setup%centred(2), station, ok)
      if (.not. ok) call fatal_error(error, '&profiles wheel_profile_right, rail_profile_right: expected a centred '// &
        'wheelset on both rails, found none')
    end if

  contains

    !> A pair of profiles, from the variables wheel_profile and rail_profile, or those of the right side.
    subroutine read_side(of_wheel, of_rail, wheel, rail, side)
      character(*), intent(in) :: of_wheel, of_rail     !! ends of their names: '' or '_right'
      type(profile_type), intent(out) :: wheel, rail
      type(side_type), intent(out) :: side
      character(len(c%wheel_profile)) :: file

      file = c%wheel_profile
      if (of_wheel /= '') file = c%wheel_profile_right
      call read_profile(trim(file), is_wheel, wheel, error)
      if (failed('wheel_profile'//of_wheel)) return
      file = c%rail_profile
      if (of_rail /= '') file = c%rail_profile_right
      call read_profile(trim(file), is_rail, rail, error)
      if (failed('rail_profile'//of_rail)) return
      call place_profiles(wheel%curve, rail%curve, wheel%file, rail%file, c%gauge, c%gauge_depth, c%back_to_back, &
        c%rolling_radius, side%pair, error)
      if (.not. allocated(error)) call find_zones(side%pair, side%zones)
      side%threshold = [cos(c%flange_angle), sin(c%flange_angle)]
      if (of_wheel//of_rail == '') return
      if (failed('wheel_profile'//of_wheel//', rail_profile'//of_rail)) return
    end subroutine read_side

    !> Put the names of the variables into an error.
    logical function failed(names)
      character(*), intent(in) :: names

      failed = allocated(error)
      if (failed) error%message = '&profiles '//names//': '//error%message
    end function failed

  end subroutine prepare_geometry

end module run_setup
