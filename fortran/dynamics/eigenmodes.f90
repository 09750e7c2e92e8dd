!> Small oscillations of the wheelset about an equilibrium: K x = omega^2 M x with the
!> exact tangent K of the contact potential.
module eigenmodes
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use kinds, only: dp, pi
  use newmark, only: symmetric
  use wheelset, only: contact_state, contacts, wheelset_type
  implicit none
  private
  public :: small_oscillations

  interface
    subroutine dsyev(jobz, uplo, n, a, lda, w, work, lwork, info)
      import :: dp
      character, intent(in) :: jobz, uplo
      integer, intent(in) :: n, lda, lwork
      real(dp), intent(inout) :: a(lda, *)
      real(dp), intent(out) :: w(*), work(*)
      integer, intent(out) :: info
    end subroutine dsyev
  end interface

contains

  !> Frequencies [Hz], ascending (an unstable one as minus its growth rate/2 pi), and
  !> the modes y, z, roll in the columns of `shapes`, of unit modal mass.
  subroutine small_oscillations(w, q, frequency, shapes)
    type(wheelset_type), intent(in) :: w
    real(dp), intent(in) :: q(3)           !! y, z [m], roll [rad]
    real(dp), intent(out) :: frequency(3), shapes(3, 3)
    type(contact_state) :: state
    real(dp) :: root(3), work(15)
    integer :: info, i

    call contacts(w, q, state)
    shapes = symmetric(state%hessian)
    root = sqrt(w%inertia())
    do i = 1, 3
      shapes(:, i) = shapes(:, i)/(root*root(i))
    end do
    call dsyev('V', 'U', 3, shapes, 3, frequency, work, size(work), info)
    if (info /= 0) frequency = ieee_value(1.0_dp, ieee_quiet_nan)
    frequency = sign(sqrt(abs(frequency)), frequency)/(2*pi)
    do i = 1, 3
      shapes(:, i) = shapes(:, i)/root
    end do
  end subroutine small_oscillations

end module eigenmodes