!> The static limit of a wheelset: the largest lateral force at its centre of gravity that has an equilibrium.
!>
!> Under a growing force the wheelset leans on one flange, whose contact climbs, and the other wheel is relieved. When the other
!> wheel carries nothing, weight, lateral force and the force of the flange meet in the centre of gravity, and a larger force
!> overturns the wheelset. The equilibria are followed by their lateral displacement, at which the wheelset is held. The force
!> that holds it there has its maximum at the limit.
module static_limit
  use kinds, only: dp
  use elastic_contacts, only: contacts, elastic_wheelset, hold
  use motion_state, only: closed, contact_state
  use wheelset, only: flanges, treads
  implicit none
  private
  public :: largest_force

contains

  !> The largest lateral force to the left (`way` = 1) or to the right (-1) [N]; `ok` is false where the table ends before it.
  subroutine largest_force(w, rest, clearance, way, force, ok)
    type(elastic_wheelset), intent(in) :: w
    real(dp), intent(in) :: rest(3)        !! equilibrium at the centre: y, z [m], roll [rad]
    real(dp), intent(in) :: clearance      !! on this side [m]
    integer, intent(in) :: way
    real(dp), intent(out) :: force         !! [N]
    logical, intent(out) :: ok
    real(dp), parameter :: wide = 5e-4_dp, narrow = 2e-5_dp   ! stride before and at the flange [m]
    real(dp), parameter :: near = 0.8_dp   ! share of the clearance at which the strides become narrow
    real(dp), parameter :: least = 1e-9_dp ! stride at which the equilibria end [m]
    real(dp) :: poses(3, 3), forces(3)     ! the largest force so far is the second of them; then they bracket it
    real(dp) :: q(3), last(3), held, before, stride
    logical :: bracketed, stands

    poses = spread(rest, 2, 3)
    forces = 0
    last = rest
    before = 0
    bracketed = .false.
    stride = wide
    ok = .false.
    do while (.not. ok .and. stride > least)
      q = last
      q(1) = q(1) + way*stride
      call lean(w, way, q, held, stands)
      if (.not. stands) then
        stride = stride/2
        cycle
      end if
      if (held > forces(2)) then
        poses(:, 1) = last
        forces(1) = before
        poses(:, 2) = q
        forces(2) = held
        bracketed = .false.
      else if (.not. bracketed) then
        poses(:, 3) = q
        forces(3) = held
        bracketed = .true.
      end if
      if (bracketed) call find_unloaded(w, way, q, ok)
      last = q
      before = held
      if (abs(q(1)) > near*clearance) stride = min(stride, narrow)
    end do
    ! Where the equilibria end with the largest force, it is the limit.
    if (.not. ok) call find_unloaded(w, way, last, ok)
    force = forces(2)
    if (ok .and. bracketed) call find_top(w, way, poses, force)
  end subroutine largest_force

  !> The maximum of the force between the displacements of three poses, by golden sections.
  subroutine find_top(w, way, poses, force)
    type(elastic_wheelset), intent(in) :: w
    integer, intent(in) :: way
    real(dp), intent(in) :: poses(3, 3)    !! y, z [m], roll [rad] in columns
    real(dp), intent(inout) :: force       !! at the second pose; on return the largest one [N]
    real(dp), parameter :: golden = 0.381966011250105_dp
    real(dp), parameter :: narrow = 1e-11_dp   ! [m]
    real(dp) :: low, high, top, q(3), held
    logical :: stands

    low = poses(1, 1)
    top = poses(1, 2)
    high = poses(1, 3)
    do while (abs(high - low) > narrow)
      q = poses(:, 2)
      q(1) = top + golden*merge(high - top, low - top, abs(high - top) > abs(low - top))
      if (abs(q(1) - top) <= 0) exit
      associate (y => q(1))
        call lean(w, way, q, held, stands)
        if (stands .and. held > force) then
          if (abs(high - top) > abs(low - top)) then
            low = top
          else
            high = top
          end if
          top = y
          force = held
        else if (abs(high - top) > abs(low - top)) then
          high = y
        else
          low = y
        end if
      end associate
    end do
  end subroutine find_top

  !> Equilibrium of the wheelset that is held at the lateral position of q, and the lateral force that holds it there.
  subroutine lean(w, way, q, held, stands)
    type(elastic_wheelset), intent(in) :: w
    integer, intent(in) :: way
    real(dp), intent(inout) :: q(3)        !! y, z [m], roll [rad]; on entry a pose nearby
    real(dp), intent(out) :: held          !! outwards [N]
    logical, intent(out) :: stands

    call hold(w, q, held, stands)
    held = -way*held
  end subroutine lean

  !> Whether the wheel on the other side carries nothing.
  subroutine find_unloaded(w, way, q, unloaded)
    type(elastic_wheelset), intent(in) :: w
    integer, intent(in) :: way
    real(dp), intent(in) :: q(3)
    logical, intent(out) :: unloaded
    type(contact_state) :: state
    logical :: shut(4)
    integer :: other                       ! side

    call contacts(w, q, state, with_hessian=.false.)
    shut = closed(state)
    other = merge(2, 1, way == 1)
    unloaded = .not. (shut(treads(other)) .or. shut(flanges(other)))
  end subroutine find_unloaded

end module static_limit
