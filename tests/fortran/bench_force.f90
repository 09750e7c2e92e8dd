!> Time of the wheelset's contact forces at the poses of a run: looked up, by direct evaluation of the
!> strips, by half-space solutions, and the floor under a look-up: its loads and multiply-adds alone.
!>
!> usage: bench_force input.nml poses rounds repeats stride
!> Reads n and the n poses `y`, `z`, `roll` (8-byte reals, one array after the other) from the binary
!> file.  Writes, per round, the processor time per pose [s] of table, direct, half-space, floor; table and
!> floor loop over the poses `repeats` times, the half-space takes every `stride`-th pose.  The last
!> line has the mean number of touching zones of both wheels and a sum that keeps the loops alive.
program bench_force
  use, intrinsic :: iso_fortran_env, only: int64
  use case, only: case_type, read_case
  use contact, only: branch_energy, set_moduli, zone_energy, zone_force
  use errors, only: error_type
  use geometry, only: new_scan, scan_depth, scan_type
  use hertz, only: contact_modulus
  use kinds, only: dp
  use simulation, only: prepare, setup_type
  use text, only: line_type, read_lines
  use wheelset, only: contact_state, contacts
  implicit none
  real(dp), parameter :: mirror(3) = [-1, 1, -1]
  type(case_type) :: c
  type(setup_type) :: setup
  type(error_type), allocatable :: error
  type(line_type), allocatable :: lines(:)
  type(scan_type) :: work
  type(contact_state) :: state
  real(dp), allocatable :: read_poses(:, :), pose(:, :), k(:), coefficients(:, :, :), heights(:, :)
  integer, allocatable :: touching(:)
  real(dp) :: e_star, total, from, to, seconds(4)
  integer(int64) :: n
  integer :: unit, i, round, repeat
  character(256) :: file

  call get_command_argument(1, file)
  call read_lines(trim(file), lines, error)
  if (.not. allocated(error)) call read_case(trim(file), lines, c, error)
  if (.not. allocated(error)) call prepare(c, setup, error)
  if (allocated(error)) error stop error%message
  call get_command_argument(2, file)
  open (newunit=unit, file=trim(file), access='stream', form='unformatted', status='old', action='read')
  read (unit) n
  allocate (read_poses(n, 3), touching(n))
  read (unit) read_poses
  pose = transpose(read_poses)
  e_star = c%stiffness_scale*contact_modulus(c%youngs_modulus, c%poisson)
  allocate (k(size(setup%pair%s)))
  work = new_scan(setup%pair)
  ! As large as those of a zone, so that they lie as far apart in memory.
  allocate (coefficients(c%n_depth + 3, c%n_roll + 3, c%n_lateral + 3), heights(c%n_roll + 3, c%n_lateral + 3), &
    source=1e-6_dp)
  total = 0
  do round = 1, argument(3)
    call cpu_time(from)
    do repeat = 1, argument(4)
      do i = 1, int(n)
        call contacts(setup%wheelset, pose(:, i), state)
        if (state%status /= 0) error stop 'a pose is not on the table'
        total = total + state%gradient(2) + state%hessian(4)
      end do
    end do
    call cpu_time(to)
    seconds(1) = (to - from)/(n*argument(4))

    call cpu_time(from)
    touching = 0
    do i = 1, int(n)
      call evaluate_strips(pose(:, i), touching(i))
      call evaluate_strips(mirror*pose(:, i), touching(i))
    end do
    call cpu_time(to)
    seconds(2) = (to - from)/n

    call cpu_time(from)
    do i = 1, int(n), argument(5)
      call solve_halfspace(pose(:, i))
      call solve_halfspace(mirror*pose(:, i))
    end do
    call cpu_time(to)
    seconds(3) = (to - from)/((n - 1)/argument(5) + 1)

    call cpu_time(from)
    do repeat = 1, argument(4)
      do i = 1, int(n)
        call multiply_add(pose(:, i), touching(i))
      end do
    end do
    call cpu_time(to)
    seconds(4) = (to - from)/(n*argument(4))
    write (*, '(4es12.4)') seconds
  end do
  write (*, '(f0.4, es12.4)') sum(touching)/real(n, dp), total

contains

  integer function argument(position)
    integer, intent(in) :: position
    character(16) :: word

    call get_command_argument(position, word)
    read (word, *) argument
  end function argument

  !> Force and energy of the left wheel by its strips; counts the zones that touch.
  subroutine evaluate_strips(q, touching)
    real(dp), intent(in) :: q(3)
    integer, intent(inout) :: touching
    real(dp) :: energy, force(3)
    integer :: z

    do z = 1, size(setup%zones)
      associate (zone => setup%zones(z))
        work%fresh = .true.
        call set_moduli(setup%pair, zone, e_star, q(3), k)
        call scan_depth(setup%pair, q(1:2), q(3), zone%first, zone%last, work)
        force = zone_force(setup%pair, zone, q(3), work, k)
        energy = zone_energy(setup%pair, zone, trim(c%model), e_star, q(3), work, k)
      end associate
      if (energy > 0) touching = touching + 1
      total = total + energy + force(2)
    end do
  end subroutine evaluate_strips

  !> Force and energy of the left wheel's tread and flange by the half-space.
  subroutine solve_halfspace(q)
    real(dp), intent(in) :: q(3)
    real(dp) :: energy, force(3)
    integer :: branch, first, last
    logical :: ok

    do branch = 1, 2
      first = minval(setup%zones%first, setup%zones%flange .eqv. branch == 2)
      last = maxval(setup%zones%last, setup%zones%flange .eqv. branch == 2)
      work%fresh = .true.
      call scan_depth(setup%pair, q(1:2), q(3), first, last, work)
      call branch_energy(setup%pair, first, last, e_star, q(1:2), q(3), work, energy, ok, force)
      if (.not. ok) error stop 'the half-space solution failed'
      total = total + energy + force(2)
    end do
  end subroutine solve_halfspace

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
