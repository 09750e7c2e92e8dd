!> Motion of a wheelset with rigid contacts of which the same ones stay closed, none to three:
!>
!>     M q'' = f + J' force,   J q'' + q'.g_qq q' = 0.
!>
!> Free flight is exact.  Else the step is the classical Runge-Kutta step of fourth order, after which pose and velocity
!> are projected onto the closed contacts in the kinetic metric.  A wheelset held on both rails has one degree of freedom,
!> whose speed is then projected onto the energy, too (E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration,
!> IV.4).
module smooth_motion
  use constraint_forces, only: close_gaps, closing_forces, most_closed, stop_gaps
  use contact_zones, only: side_type
  use gap_functions, only: find_gap, gap_type
  use kinds, only: dp
  use motion_state, only: energy_change, energy_rounding, motion_type
  use rival_points, only: drop_merged_rivals
  use wheelset, only: external_force, wheelset_type
  implicit none
  private
  public :: state_type, move, gap_rate, normal_forces

  !> Motion and contacts at the start or the end of a step.
  type :: state_type
    real(dp) :: h = 0                  !! time from the start of the step [s]
    type(motion_type) :: motion
    type(gap_type), allocatable :: c(:)
    logical, allocatable :: closed(:)  !! which of them
    logical :: bilateral = .false.
    integer :: zones = 0               !! number of zones of both wheels
    integer :: evaluations = 0         !! number of evaluations of the contacts so far
    real(dp) :: error = 0, excess = 0  !! as in `rigid_state` [J]
    real(dp), allocatable :: half_force(:)   !! forces half way (bilateral) [N]
    logical :: ended = .false.         !! no pose nearby is on both rails, or a contact is at the end of its zone
  end type state_type

contains

  !> The state after the time h with the same contacts closed, and all gaps there.  `to` starts as a copy of `from`.
  subroutine move(side, w, from, h, to)
    type(side_type), intent(in) :: side(:)
    type(wheelset_type), intent(in) :: w
    type(state_type), intent(in) :: from
    real(dp), intent(in) :: h              !! [s]
    type(state_type), intent(inout) :: to
    integer :: i, on(count(from%closed))
    logical :: ok

    to%h = h
    to%ended = .false.
    to%motion = from%motion
    to%c = from%c
    if (size(on) == 0) then
      call fly(w, h, to%motion)
    else if (size(on) == most_closed) then
      ! No motion is left.
      to%motion%t = to%motion%t + h
      to%motion%v = 0
      to%half_force = normal_forces(w, to)
    else
      ! Two half steps have a sixteenth of the energy error, which is less than the error of an impact.
      on = pack([(i, i=1, size(to%c))], to%closed)
      do i = 1, 2
        call slide(side, w, h/2, on, to%c, to%motion, ok)
        ok = ok .and. .not. any(to%c(on)%edge .and. .not. to%c(on)%rim)
        to%ended = to%ended .or. from%bilateral .and. .not. ok
        if (i == 1 .and. from%bilateral) to%half_force = normal_forces(w, to)
      end do
      to%evaluations = to%evaluations + 8
    end if
    to%error = energy_change(w, from%motion, to%motion)
    if (from%bilateral) call correct_speed(w, from%excess + to%error, to)
    do i = 1, size(to%c)
      if (.not. to%closed(i)) call find_gap(side, to%motion%q, to%c(i))
    end do
    call drop_merged_rivals(to%zones, to%closed, to%c)
    to%evaluations = to%evaluations + 1
  end subroutine move

  !> Take energy that the wheelset has in excess out of its speed, or leave it to a later step where the wheelset is too slow.
  pure subroutine correct_speed(w, excess, state)
    type(wheelset_type), intent(in) :: w
    real(dp), intent(in) :: excess         !! [J]
    type(state_type), intent(inout) :: state
    real(dp), parameter :: slow = 100         ! least kinetic energy, relative to the excess
    real(dp) :: kinetic

    kinetic = sum(w%inertia()*state%motion%v**2)/2
    state%excess = excess
    if (kinetic <= slow*abs(excess) .or. abs(excess) <= energy_rounding(w, state%motion)/4) return
    state%motion%v = state%motion%v*sqrt(1 - excess/kinetic)
    state%excess = 0
  end subroutine correct_speed

  !> Rate of the gap of contact i [m/s].
  pure real(dp) function gap_rate(state, i)
    type(state_type), intent(in) :: state
    integer, intent(in) :: i

    gap_rate = dot_product(state%c(i)%gradient, state%motion%v)
  end function gap_rate

  !> Normal force of every contact, 0 for open ones [N].
  pure function normal_forces(w, state) result(force)
    type(wheelset_type), intent(in) :: w
    type(state_type), intent(in) :: state
    real(dp) :: force(size(state%c)), part(count(state%closed))

    call closing_forces(w%inertia(), external_force(w, state%motion%t), state%motion%v, pack(state%c, state%closed), part)
    force = unpack(part, state%closed, 0.0_dp)
  end function normal_forces

  !> Free flight over the time h under a lateral force that grows linearly: exact.
  pure subroutine fly(w, h, motion)
    type(wheelset_type), intent(in) :: w
    real(dp), intent(in) :: h
    type(motion_type), intent(inout) :: motion
    real(dp) :: a(3), growth(3), v_y, move(3), q(3)

    a = external_force(w, motion%t)/w%inertia()
    growth = [w%lateral_ramp/w%mass, 0.0_dp, 0.0_dp]
    v_y = motion%v(1)
    move = h*(motion%v + h*(a/2 + h*growth/6)) + motion%remainder
    q = motion%q + move
    motion%remainder = (motion%q - q) + move
    motion%q = q
    motion%v = motion%v + h*(a + h*growth/2)
    motion%t = motion%t + h
    motion%work = motion%work + 0.5_dp*w%mass*(motion%v(1) - v_y)*(motion%v(1) + v_y)
  end subroutine fly

  !> A Runge-Kutta step h with the contacts `on` closed, projected onto them.
  pure subroutine slide(side, w, h, on, c, motion, ok)
    type(side_type), intent(in) :: side(:)
    type(wheelset_type), intent(in) :: w
    real(dp), intent(in) :: h
    integer, intent(in) :: on(:)
    type(gap_type), intent(inout) :: c(:)
    type(motion_type), intent(inout) :: motion
    logical, intent(out) :: ok             !! the contacts are closed, by a move that is short beside the step
    real(dp), parameter :: node(4) = [0.0_dp, 0.5_dp, 0.5_dp, 1.0_dp]
    real(dp), parameter :: weight(4) = [1.0_dp, 2.0_dp, 2.0_dp, 1.0_dp]/6
    type(gap_type) :: part(size(on))
    real(dp) :: q(3), v(3), a(3), f(3), inertia(3), dq(3), dv(3), work, force(size(on))
    integer :: stage, i

    inertia = w%inertia()
    part = c(on)
    q = motion%q
    v = motion%v
    a = 0
    dq = 0
    dv = 0
    work = 0
    do stage = 1, 4
      if (stage > 1) then
        q = motion%q + node(stage)*h*v
        v = motion%v + node(stage)*h*a
      end if
      do i = 1, size(on)
        call find_gap(side, q, part(i))
      end do
      f = external_force(w, motion%t + node(stage)*h)
      call closing_forces(inertia, f, v, part, force)
      a = f
      do i = 1, size(on)
        a = a + force(i)*part(i)%gradient
      end do
      a = a/inertia
      dq = dq + weight(stage)*v
      dv = dv + weight(stage)*a
      work = work + weight(stage)*f(1)*v(1)
    end do
    motion%q = motion%q + h*dq
    q = motion%q
    motion%remainder = 0
    motion%v = motion%v + h*dv
    motion%t = motion%t + h
    motion%work = motion%work + h*work
    call close_gaps(side, inertia, part, motion%q, ok)
    ok = ok .and. norm2(motion%q - q) < 0.3_dp*norm2(h*dq) + 1e-9_dp
    call stop_gaps(inertia, part, motion%v)
    c(on) = part
  end subroutine slide

end module smooth_motion
