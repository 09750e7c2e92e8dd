!> Times within a step of elastic contacts at which a contact closes or opens. Between the ends of the step the pose is the quintic
!> in time whose values, velocities and accelerations are those of both ends.
module step_times
  use kinds, only: dp
  use motion_state, only: closed, contact_state, motion_type
  use elastic_contacts, only: contacts, elastic_wheelset
  use wheelset, only: right_tread
  use zone_tables, only: inside
  implicit none
  private
  public :: pose_between, find_change

contains

  !> The pose after the share u of a step.
  pure function pose_between(old, new, u) result(q)
    type(motion_type), intent(in) :: old, new
    real(dp), intent(in) :: u
    real(dp) :: q(3), dt, rise(3), v(3, 2), a(3, 2)

    dt = new%t - old%t
    rise = new%q - old%q
    v = dt*reshape([old%v, new%v], [3, 2])
    a = 0.5_dp*dt**2*reshape([old%a, new%a], [3, 2])
    q = old%q + u*(v(:, 1) + u*(a(:, 1) + u*((10*rise - 6*v(:, 1) - 4*v(:, 2) - 3*a(:, 1) + a(:, 2)) &
      + u*((-15*rise + 8*v(:, 1) + 7*v(:, 2) + 3*a(:, 1) - 2*a(:, 2)) &
      + u*(6*rise - 3*v(:, 1) - 3*v(:, 2) - a(:, 1) + a(:, 2))))))
  end function pose_between

  !> Time t [s] at which a contact closes or opens that has changed in the step: the first one at which it is as at the end.
  !> `state` is that of its wheel when it is just closed.
  !>
  !> The energy of a contact grows with the power 5/2 of its penetration, so that its power 2/5 goes nearly in a straight line to
  !> zero. A point beyond that zero bounds it from the other side.
  subroutine find_change(w, old, new, contact, t, state)
    type(elastic_wheelset), intent(in) :: w
    type(motion_type), intent(in) :: old, new
    integer, intent(in) :: contact
    real(dp), intent(out) :: t
    type(contact_state), intent(out) :: state
    real(dp), parameter :: close = 2e-11_dp      ! [s]
    integer, parameter :: most = 60
    real(dp) :: dt, shut, open, depth, shut_before, depth_before, rate, zero
    logical :: closes(4)
    integer :: iter

    dt = new%t - old%t
    closes = closed(new%contact)
    if (closes(contact)) then
      shut = 1
      open = 0
      state = new%contact
      rate = dot_product(state%slope(:, contact), new%v)
    else
      shut = 0
      open = 1
      state = old%contact
      rate = dot_product(state%slope(:, contact), old%v)
    end if
    depth = state%energy(contact)**0.4_dp
    ! The first guess follows from the growth of the energy.
    shut_before = shut
    depth_before = depth
    zero = shut
    if (abs(rate) > 0) zero = shut - 2.5_dp*state%energy(contact)/(rate*dt)
    do iter = 1, most
      if (abs(shut - open)*dt <= close) exit
      if (.not. (zero - min(shut, open) > 0 .and. max(shut, open) - zero > 0)) zero = (shut + open)/2
      call try(zero)
      ! As far beyond the zero as the contact was before it.
      zero = crossing()
      zero = zero + sign(max(abs(zero - shut), close/dt/4), open - shut)
      if (zero - min(shut, open) > 0 .and. max(shut, open) - zero > 0) call try(zero)
      zero = crossing()
    end do
    t = old%t + dt*merge(shut, open, closes(contact))

  contains

    !> Evaluate the contact's wheel, and narrow the bracket.
    subroutine try(u)
      real(dp), intent(in) :: u
      type(contact_state) :: there
      logical :: is_closed(4)

      call contacts(w, pose_between(old, new, u), there, with_hessian=.false., wheel=merge(1, 2, contact < right_tread))
      is_closed = closed(there)
      if (is_closed(contact) .and. there%status == inside) then
        shut_before = shut
        depth_before = depth
        shut = u
        depth = there%energy(contact)**0.4_dp
        state = there
      else
        open = u
      end if
    end subroutine try

    !> Where the straight line through the last two closed points is zero.
    pure real(dp) function crossing()
      crossing = (shut + open)/2
      if (abs(depth_before - depth) > 0) crossing = shut - depth*(shut - shut_before)/(depth - depth_before)
    end function crossing

  end subroutine find_change

end module step_times
