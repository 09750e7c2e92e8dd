!> Error of the left wheel's contact table at given poses.
!>
!> usage: stated_error input.nml < poses
!> Reads how many poses there are, `most`, and lines `y z roll` (axle centre above top of rail) from standard input; writes for
!> each: 1 where a run in service can come to it, 2 going over a rail, 0 elsewhere or off the table; whether the
!> tread and the flange touch (1 or 0); the error of the table's force on the wheel against direct evaluation by
!> the case's law, of max(|F|, 5 kN).  Only the first `most` poses in service are evaluated, the others have the place -1; with 0
!> all that are on the table.
!> Half-spaces are solved on 8 x 32 elements.
program stated_error
  use table_error, only: direct_force
  use case, only: case_type
  use kinds, only: dp
  use patch_grids, only: elements_type
  use contact_table, only: find_roll, wheel_potential
  use zone_tables, only: zone_penetration, inside, roll_type
  use run_tables, only: table_request
  use service_poses, only: find_allowance, request_type
  use shared, only: read_prepared
  use run_setup, only: setup_type
  implicit none
  save
  real(dp), parameter :: least_force = 5e3_dp   ! [N]
  type(case_type) :: c
  type(setup_type), target :: setup
  type(request_type) :: request
  type(elements_type) :: elements
  real(dp), allocatable :: poses(:, :), error(:)
  logical, allocatable :: touching(:, :)
  integer, allocatable :: place(:)
  integer :: i, n, most, in_service

  call read_prepared(c, setup)
  read (*, *) n, most
  allocate (poses(3, n))
  read (*, *) poses
  allocate (error(n), source=0.0_dp)
  allocate (touching(2, n), source=.false.)
  allocate (place(n), source=0)
  request = table_request(c, setup%side(1))
  elements = elements_type(8, 32, 1e-4_dp, request%e_star, request%influence == 'flat')
  in_service = 0
  do i = 1, n
    place(i) = place_of(poses(:, i))
    if (place(i) == 1) in_service = in_service + 1
    if (most > 0 .and. (place(i) /= 1 .or. in_service > most)) place(i) = -1
  end do
  !$omp parallel do schedule(dynamic)
  do i = 1, n
    if (place(i) >= 0) call compare(poses(:, i), touching(:, i), error(i))
  end do
  do i = 1, n
    write (*, '(3i3, es24.16)') place(i), merge(1, 0, touching(:, i)), error(i)
  end do

contains

  !> In reach by any of the zones that touch.
  integer function place_of(pose) result(place)
    real(dp), intent(in) :: pose(3)
    type(roll_type) :: roll, opposite
    real(dp) :: depth, other, allowance
    integer :: status, z

    place = 0
    associate (table => setup%wheelset%table)
      call find_roll(table, pose(3), .false., roll, opposite, status)
      if (status /= inside) return
      do z = 1, size(table%zones)
        depth = zone_penetration(table%zones(z), pose, roll)
        if (depth <= 0 .or. depth > request%extent%depth) cycle
        call find_allowance(request, table, z, depth, pose, .false., allowance, other)
        if (allowance > 0) place = merge(1, 2, allowance <= 1)
      end do
    end associate
  end function place_of

  subroutine compare(pose, touching, error)
    real(dp), intent(in) :: pose(3)
    logical, intent(out) :: touching(2)
    real(dp), intent(out) :: error
    type(roll_type) :: roll, opposite
    real(dp) :: energy(2), gradient(3, 2), hessian(6), force(2)
    integer :: status
    logical :: ok, carrying(size(setup%wheelset%table%zones))

    error = 0
    touching = .false.
    associate (table => setup%wheelset%table)
      call find_roll(table, pose(3), .false., roll, opposite, status)
      if (status == inside) call wheel_potential(table, pose, roll, .false., energy, gradient, hessian, status)
      if (status /= inside) return
      call direct_force(request, elements, pose, force, carrying, ok)
      if (.not. ok) error stop 'the direct solution failed'
      touching = [any(carrying .and. .not. table%zones%past_root), any(carrying .and. table%zones%past_root)]
    end associate
    error = norm2(-sum(gradient(:2, :), 2) - force)/max(norm2(force), least_force)
  end subroutine compare

end program stated_error
