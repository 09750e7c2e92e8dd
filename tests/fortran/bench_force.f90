!> Time of the wheelset's contact forces at the poses of a run: looked up, with and without the tangent,
!> by direct evaluation of the strips, by half-space solutions, and the floor under a look-up with
!> tangent: its loads and multiply-adds alone.
!>
!> usage: bench_force input.nml poses rounds repeats stride
!> Writes, per round, the processor time per pose [s] of force and tangent from the table, force from the table, direct,
!> half-spaces, half-spaces as a table needs them, floor; table and floor loop `repeats` times over the poses of the binary
!> file (`read_poses` has its format), the half-spaces take every `stride`-th pose.  The last line has the mean number of
!> touching zones of both wheels and a sum that keeps the loops alive.
program bench_force
  use case, only: case_type
  use shared, only: direct_type, integer_argument, new_direct, read_poses, read_prepared, wheel_contact, zone_contact
  use station_scan, only: scan_depth
  use kinds, only: dp
  use halfspace_patches, only: patches_type, press_patches
  use patch_grids, only: elements_type
  use run_setup, only: setup_type
  use wheel_rail_pair, only: mirror
  use wheelset, only: contact_state, contacts
  implicit none
  save
  type(case_type) :: c
  type(setup_type) :: setup
  type(direct_type) :: direct
  type(contact_state) :: state
  real(dp), allocatable :: pose(:, :), coefficients(:, :, :), heights(:, :)
  integer, allocatable :: touching(:)
  real(dp) :: total, from, to, seconds(6)
  integer :: n, i, round, rounds, repeat, repeats, stride

  call read_prepared(c, setup)
  call read_poses(pose)
  n = size(pose, 2)
  rounds = integer_argument(3)
  repeats = integer_argument(4)
  stride = integer_argument(5)
  allocate (touching(n))
  direct = new_direct(c, setup)
  ! As large as those of a zone, so that they lie as far apart in memory.
  associate (table => setup%wheelset%table, zone => setup%wheelset%table%zones(1))
    allocate (coefficients(zone%q%n + 2, table%roll%n + 2, zone%u%n + 2), heights(table%roll%n + 2, zone%u%n + 2), &
      source=1e-6_dp)
  end associate
  total = 0
  do round = 1, rounds
    seconds(1) = looked_up(tangent=.true.)
    seconds(2) = looked_up(tangent=.false.)

    call cpu_time(from)
    touching = 0
    do i = 1, n
      call evaluate_strips(pose(:, i), touching(i))
      call evaluate_strips(mirror*pose(:, i), touching(i))
    end do
    call cpu_time(to)
    seconds(3) = (to - from)/n

    call cpu_time(from)
    do i = 1, n, stride
      call solve_halfspace(pose(:, i))
      call solve_halfspace(mirror*pose(:, i))
    end do
    call cpu_time(to)
    seconds(4) = (to - from)/((n - 1)/stride + 1)
    seconds(5) = solution()

    call cpu_time(from)
    do repeat = 1, repeats
      do i = 1, n
        call multiply_add(pose(:, i), touching(i))
      end do
    end do
    call cpu_time(to)
    seconds(6) = (to - from)/(real(n, dp)*repeats)
    write (*, '(6es12.4)') seconds
  end do
  write (*, '(f0.4, es12.4)') sum(touching)/real(n, dp), total

contains

  !> Time of an evaluation from the table [s].
  real(dp) function looked_up(tangent) result(seconds)
    logical, intent(in) :: tangent

    call cpu_time(from)
    do repeat = 1, repeats
      do i = 1, n
        call contacts(setup%wheelset, pose(:, i), state, tangent)
        if (state%status /= 0) error stop 'a pose is not on the table'
        total = total + state%gradient(2) + state%hessian(4)
      end do
    end do
    call cpu_time(to)
    seconds = (to - from)/(real(n, dp)*repeats)
  end function looked_up

  !> Force and energy of the left wheel by its strips; counts the zones that touch.
  subroutine evaluate_strips(q, touching)
    real(dp), intent(in) :: q(3)
    integer, intent(inout) :: touching
    real(dp) :: energy, force(3)
    integer :: z

    do z = 1, size(setup%side(1)%zones)
      call zone_contact(direct, setup, z, q, energy, force)
      if (energy > 0) touching = touching + 1
      total = total + energy + force(2)
    end do
  end subroutine evaluate_strips

  !> Force and energy of the left wheel by the half-space.
  subroutine solve_halfspace(q)
    real(dp), intent(in) :: q(3)
    real(dp) :: energy, force(3, 2)

    call wheel_contact(direct, setup, q, energy, force)
    total = total + energy + sum(force(2, :))
  end subroutine solve_halfspace

  !> Time [s] of a solution on the elements, and to the tolerance, of the generator of tables: the left tread at the
  !> poses, one after the other.
  real(dp) function solution() result(seconds)
    type(elements_type) :: elements
    type(patches_type) :: patches
    integer :: first, last, solved

    elements = elements_type(5, 20, 2e-3_dp, direct%e_star, .false.)
    solved = 0
    associate (side => setup%side(1))
      first = minval(side%zones%first, .not. side%zones%flange)
      last = maxval(side%zones%last)
      seconds = 0
      do i = 1, n, stride
        direct%work%fresh = .true.
        call scan_depth(side%pair, pose(:2, i), pose(3, i), first, last, direct%work)
        call cpu_time(from)
        call press_patches(side%pair, elements, first, last, pose(:2, i), pose(3, i), direct%work, patches)
        call cpu_time(to)
        seconds = seconds + to - from
        total = total + patches%energy
        solved = solved + 1
      end do
    end associate
    seconds = seconds/max(solved, 1)
  end function solution

  !> The tensor splines of h (two axes) and S (three), with first and second derivatives, for each touching
  !> zone: 80 loads, 400 multiply-adds; the values of the basis functions are given.
  subroutine multiply_add(q, zones)
    real(dp), intent(in) :: q(3)
    integer, intent(in) :: zones
    real(dp), parameter :: b(4, 3) = reshape([1, 4, 1, 0, -1, 0, 1, 0, 1, -2, 1, 0]/6.0_dp, [4, 3])
    real(dp) :: s(10), h(6)
    integer :: z, at(3)

    at(1) = int(4096*abs(q(1)*9)) ; at(2) = int(4096*abs(q(2))) ; at(3) = int(4096*abs(q(3)*9))
    do z = 1, zones
      at = mod(at + z, shape(coefficients) - 4) + 1
      associate (x => coefficients(at(1):at(1) + 3, at(2):at(2) + 3, at(3):at(3) + 3))
        s = spline_3(x, b + z)
      end associate
      h = spline_2(heights(at(2):at(2) + 3, at(3):at(3) + 3), b + z)
      total = total + sum(s) + sum(h)
    end do
  end subroutine multiply_add

  pure function spline_2(x, b) result(v)
    real(dp), intent(in) :: x(:, :), b(4, 3)
    real(dp) :: v(6), line(3)
    integer :: j, m

    v = 0
    do j = 1, 4
      do m = 1, 3
        line(m) = sum(x(:, j)*b(:, m))
      end do
      v(1:3) = v(1:3) + line*b(j, 1)
      v(4:5) = v(4:5) + line(1:2)*b(j, 2)
      v(6) = v(6) + line(1)*b(j, 3)
    end do
  end function spline_2

  pure function spline_3(x, b) result(v)
    real(dp), intent(in) :: x(:, :, :), b(4, 3)
    real(dp) :: v(10), plane(6)
    integer :: j

    v = 0
    do j = 1, 4
      plane = spline_2(x(:, :, j), b)
      v(1:6) = v(1:6) + plane*b(j, 1)
      v(7:9) = v(7:9) + plane([1, 2, 4])*b(j, 2)
      v(10) = v(10) + plane(1)*b(j, 3)
    end do
  end function spline_3

end program bench_force
