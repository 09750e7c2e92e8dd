!> Rest on rigid rails, in a program that is made without rigid contacts (`make RIGID=no`): `start_rigid` refuses the run.
module both_rails
  use contact_zones, only: side_type
  use kinds, only: dp
  use wheelset, only: wheelset_type
  implicit none
  private
  public :: rest_on_rails

contains

  !> Return the centred pose.
  subroutine rest_on_rails(side, w, centred, symmetric, farthest, equilibrium, rest, frequency, shape, ok)
    type(side_type), intent(in) :: side(:)
    type(wheelset_type), intent(in) :: w
    real(dp), intent(in) :: centred(3), farthest
    logical, intent(in) :: symmetric
    real(dp), intent(out) :: equilibrium(3), rest(3), frequency, shape(3)
    logical, intent(out) :: ok

    equilibrium = centred
    rest = centred
    frequency = 0
    shape = 0
    ok = .true.
  end subroutine rest_on_rails

end module both_rails
