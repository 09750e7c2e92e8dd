!> A zero between two points where a function has different signs: regula falsi in the Illinois form, bisection
!> where that converges slowly.
module root_bracket
  use kinds, only: dp
  implicit none
  private
  public :: bracket_type

  type :: bracket_type
    real(dp) :: a, fa, b, fb           !! the two points and the function's values there
    integer :: steps = 0               !! how often the bracket was narrowed
    integer :: moved = 0               !! the point that was replaced last: 1 a, 2 b, 0 none
  contains
    procedure :: guess
    procedure :: middle
    procedure :: narrow
  end type bracket_type

  integer, parameter :: patience = 30  ! steps of regula falsi before bisection

contains

  !> The point at which the function is wanted next.
  pure real(dp) function guess(this) result(x)
    class(bracket_type), intent(in) :: this

    x = this%a
    if (abs(this%fb - this%fa) > 0) x = this%a - this%fa*(this%b - this%a)/(this%fb - this%fa)
    if (this%steps > patience .or. .not. (x > min(this%a, this%b) .and. x < max(this%a, this%b))) x = this%middle()
  end function guess

  !> The middle of the bracket, for bisection.
  pure real(dp) function middle(this) result(x)
    class(bracket_type), intent(in) :: this

    x = (this%a + this%b)/2
  end function middle

  !> Narrow the bracket by the value f of the function at x.
  pure subroutine narrow(this, x, f)
    class(bracket_type), intent(inout) :: this
    real(dp), intent(in) :: x, f

    this%steps = this%steps + 1
    if (f*this%fa > 0) then
      this%a = x
      this%fa = f
      if (this%moved == 1) this%fb = this%fb/2
      this%moved = 1
    else
      this%b = x
      this%fb = f
      if (this%moved == 2) this%fa = this%fa/2
      this%moved = 2
    end if
  end subroutine narrow

end module root_bracket
