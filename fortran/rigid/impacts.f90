!> Impacts of rigid contacts, and the choice of the contacts that carry a force after an impact.
!>
!> Impact: Newton's law in the form of J. J. Moreau, "Unilateral contact and dry friction in finite freedom
!> dynamics", in: Nonsmooth Mechanics and Applications (Springer 1988) 1-82, for all contacts
!> that touch at that instant at once: impulses P >= 0 with
!>
!>     u+ + e u- >= 0,  P.(u+ + e u-) = 0,  u+ = u- + J M^-1 J' P,
!>
!> which conserves energy for e = 1 and, for e = 0, projects the velocity onto what the contacts admit.
!>
!> Accumulating impacts: an approach slower than `resting` ends in contact (e = 0). Which of the contacts at rest carry a
!> force is the same complementarity problem for forces and accelerations.
module impacts
  use complementarity, only: solve_complementarity
  use constraint_forces, only: closing_forces, convective_acceleration, couplings, most_closed, set_state
  use gap_functions, only: gap_type
  use kinds, only: dp
  use motion_state, only: motion_type
  use wheelset, only: external_force, wheelset_type
  implicit none
  private
  public :: resolve_contacts, set_forces, still

  real(dp), parameter :: resting = 1e-7_dp     ! slowest approach that bounces [m/s]
  real(dp), parameter :: still = 1e-8_dp       !! rate of a gap that neither opens nor closes, at most [m/s]

contains

  !> Resolve an impact if a contact that touches approaches, then find the contact forces that set in.  `ok` is false if no
  !> impulses or forces solve the problem, or if more than three contacts would close.
  subroutine resolve_contacts(w, restitution, c, closed, motion, released, ok)
    type(wheelset_type), intent(in) :: w
    real(dp), intent(in) :: restitution    !! 0 to 1
    type(gap_type), intent(in) :: c(:)
    logical, intent(inout) :: closed(:)    !! contacts that carry a force
    type(motion_type), intent(inout) :: motion
    integer, intent(in) :: released        !! contact whose force has just vanished, or 0
    logical, intent(out) :: ok
    integer, allocatable :: on(:)
    real(dp), allocatable :: acceleration(:), force(:)
    integer :: i

    on = pack([(i, i=1, size(c))], c%gap <= c%touching)
    call strike(w, restitution, c(on), motion, ok)
    if (.not. ok) return
    ! Contacts at rest carry a force or open.
    on = pack(on, [(abs(dot_product(c(on(i))%gradient, motion%v)) <= still .and. on(i) /= released, i=1, size(on))])
    acceleration = [(sum(c(on(i))%gradient*external_force(w, motion%t)/w%inertia()) &
      + convective_acceleration(c(on(i)), motion%v), i=1, size(on))]
    allocate (force(size(on)))
    call solve_complementarity(couplings(w%inertia(), c(on)), acceleration, force, ok)
    closed = .false.
    do i = 1, size(on)
      closed(on(i)) = force(i) > 0
    end do
    ok = ok .and. count(closed) <= most_closed
    if (ok) call set_forces(w, c, closed, motion)
  end subroutine resolve_contacts

  !> Change the velocity by the impact of contacts that touch, if one of them approaches.  `ok` is false if no impulses
  !> solve the law of impact.
  subroutine strike(w, restitution, c, motion, ok)
    type(wheelset_type), intent(in) :: w
    real(dp), intent(in) :: restitution
    type(gap_type), intent(in) :: c(:)
    type(motion_type), intent(inout) :: motion
    logical, intent(out) :: ok
    real(dp) :: rate(size(c)), impulse(size(c)), inertia(3), v(3)
    integer :: i

    ok = .true.
    rate = [(dot_product(c(i)%gradient, motion%v), i=1, size(c))]
    if (.not. any(rate < -still)) return
    inertia = w%inertia()
    call solve_complementarity(couplings(inertia, c), rate + merge(restitution, 0.0_dp, rate <= -resting)*rate, impulse, ok)
    if (.not. ok) return
    v = motion%v
    do i = 1, size(c)
      motion%v = motion%v + impulse(i)*c(i)%gradient/inertia
      associate (k => c(i)%contact)
        motion%impulse(k) = motion%impulse(k) + impulse(i)
        if (impulse(i) > 0 .and. any(rate <= -resting)) motion%contact%struck(k) = .true.
      end associate
    end do
    motion%loss = motion%loss - 0.5_dp*sum(inertia*(motion%v - v)*(motion%v + v))
  end subroutine strike

  !> Set the contact forces of a motion whose closed contacts are known.
  subroutine set_forces(w, c, closed, motion)
    type(wheelset_type), intent(in) :: w
    type(gap_type), intent(in) :: c(:)
    logical, intent(in) :: closed(:)
    type(motion_type), intent(inout) :: motion
    real(dp) :: force(count(closed))
    logical :: struck(4)

    struck = motion%contact%struck
    call closing_forces(w%inertia(), external_force(w, motion%t), motion%v, pack(c, closed), force)
    call set_state(pack(c, closed), force, motion%contact)
    motion%contact%struck = struck
  end subroutine set_forces

end module impacts
