!> How far a run's contact forces are from direct solutions: the error of the contact table at some poses of the run itself. They
!> are spread evenly over the logarithm of the force, on the tread, on the flange, on both at once, and where the wheelset goes over.
module judged_poses
  use direct_force, only: fine_elements, judge
  use kinds, only: dp
  use motion_state, only: motion_type
  use wheel_rail_pair, only: mirror
  use elastic_contacts, only: elastic_wheelset
  implicit none
  private
  public :: pose_choice, accuracy_type

  integer, parameter :: places = 4           !! tread, flange, both, going over
  integer, parameter :: classes = 8          !! of force, two in a factor of ten
  real(dp), parameter :: smallest = 1e3_dp   !! force of the second class [N]
  real(dp), parameter :: going_over = 0.02_dp   !! roll angle that no wheelset on both rails has [rad]

  !> The first and the last pose in each class of force at each place, of each wheel.
  type :: pose_choice
    real(dp) :: pose(3, 2, classes, places, 2) = 0   !! as of a left wheel [m, m, rad]
    logical :: known(classes, places, 2) = .false.
  contains
    procedure :: note
    procedure :: measure
  end type pose_choice

  !> Error of a wheel's force F against direct evaluation, relative to max(|F|, 5 kN), by place.
  type :: accuracy_type
    integer :: poses(places) = 0             !! compared
    real(dp) :: rms(places) = 0, largest(places) = 0
    integer :: unsolved = 0                  !! poses left out, as their direct evaluation did not converge
  end type accuracy_type

contains

  !> Take note of a motion.
  pure subroutine note(this, motion)
    class(pose_choice), intent(inout) :: this
    type(motion_type), intent(in) :: motion
    real(dp) :: force, pose(3)
    integer :: wheel, class, place

    do wheel = 1, 2
      associate (energy => motion%contact%energy(2*wheel - 1:2*wheel), slope => motion%contact%slope(:2, 2*wheel - 1:2*wheel))
        if (all(energy <= 0)) cycle
        force = norm2(sum(slope, 2))
        place = merge(3, merge(1, 2, energy(1) > 0), all(energy > 0))
        if (abs(motion%q(3)) > going_over) place = places
        class = max(1, min(2 + floor(2*log10(force/smallest)), classes))
        pose = motion%q
        if (wheel == 2) pose = mirror*pose
        if (.not. this%known(class, place, wheel)) this%pose(:, 1, class, place, wheel) = pose
        this%pose(:, 2, class, place, wheel) = pose
        this%known(class, place, wheel) = .true.
      end associate
    end do
  end subroutine note

  !> Compare the forces of the tables with direct solutions.
  subroutine measure(this, w, accuracy)
    class(pose_choice), intent(in) :: this
    type(elastic_wheelset), intent(in) :: w
    type(accuracy_type), intent(out) :: accuracy
    real(dp) :: error(2, classes, places, 2), force
    logical :: solved(2, classes, places, 2), touching(2)
    integer :: i, k, class, place, wheel

    error = 0
    solved = .false.
    !$omp parallel do schedule(dynamic) private(i, class, place, wheel, force, touching)
    do k = 0, size(error) - 1
      i = 1 + mod(k, 2)
      class = 1 + mod(k/2, classes)
      place = 1 + mod(k/(2*classes), places)
      wheel = 1 + k/(2*classes*places)
      if (.not. this%known(class, place, wheel)) cycle
      associate (pose => this%pose(:, i, class, place, wheel))
        if (wheel == 1) then
          call judge(w%table, fine_elements(w%table%law), pose, error(i, class, place, wheel), force, touching, &
            solved(i, class, place, wheel))
        else
          call judge(w%right_table, fine_elements(w%right_table%law), pose, error(i, class, place, wheel), force, touching, &
            solved(i, class, place, wheel))
        end if
      end associate
    end do
    accuracy%unsolved = 2*count(this%known) - count(solved)
    do place = 1, places
      associate (here => solved(:, :, place, :), e => error(:, :, place, :))
        accuracy%poses(place) = count(here)
        if (.not. any(here)) cycle
        accuracy%rms(place) = sqrt(sum(e**2, here)/count(here))
        accuracy%largest(place) = maxval(e, here)
      end associate
    end do
  end subroutine measure

end module judged_poses
