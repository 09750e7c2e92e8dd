!> A zero between two points where a function has different signs: regula falsi in Illinois' form, bisection
!> where that creeps.
module root_bracket
  use kinds, only: dp
  implicit none
  private
  public :: bracket_type

  type :: bracket_type
    real(dp) :: a, fa, b, fb           !! the two points and the values there
    integer :: steps = 0, side = 0
  contains
    procedure :: guess
    procedure :: narrow
  end type bracket_type

contains

  !> Where to look next.
  pure real(dp) function guess(this) result(x)
    class(bracket_type), intent(in) :: this

    x = this%a - this%fa*(this%b - this%a)/(this%fb - this%fa)
    if (this%steps > 30 .or. .not. (x > min(this%a, this%b) .and. x < max(this%a, this%b))) x = (this%a + this%b)/2
  end function guess

  !> The value f at x is known.
  pure subroutine narrow(this, x, f)
    class(bracket_type), intent(inout) :: this
    real(dp), intent(in) :: x, f

    this%steps = this%steps + 1
    if (f*this%fa > 0) then
      this%a = x
      this%fa = f
      if (this%side == 1) this%fb = this%fb/2
      this%side = 1
    else
      this%b = x
      this%fb = f
      if (this%side == 2) this%fa = this%fa/2
      this%side = 2
    end if
  end subroutine narrow

end module root_bracket