! The routine of LAPACK that the core calls, for wheels and for systems without LAPACK, after G. H. Golub and C. F. Van Loan, Matrix
! Computations. It does what the core asks for and no more; arguments and storage are those of LAPACK.

!> The eigenvalues of a symmetric matrix in ascending order, and its eigenvectors in the columns of `a`, by Jacobi's
!> rotations. `jobz` is 'V', `uplo` is 'U'.
subroutine dsyev(jobz, uplo, n, a, lda, w, work, lwork, info)
  use kinds, only: dp
  implicit none
  character, intent(in) :: jobz, uplo
  integer, intent(in) :: n, lda, lwork
  real(dp), intent(inout) :: a(lda, n)
  real(dp), intent(out) :: w(n), work(lwork)
  integer, intent(out) :: info
  real(dp) :: s(n, n), v(n, n), turn(2, 2), t, cotangent
  integer :: i, j, sweep
  integer, parameter :: most_sweeps = 20    ! the angles shrink quadratically

  info = merge(0, -1, jobz == 'V' .and. uplo == 'U')
  work = 0
  v = 0
  do i = 1, n
    v(i, i) = 1
    s(:i, i) = a(:i, i)
    s(i, :i) = a(:i, i)
  end do
  do sweep = 1, most_sweeps
    do j = 2, n
      do i = 1, j - 1
        if (.not. abs(s(i, j)) > 0) cycle
        cotangent = (s(j, j) - s(i, i))/(2*s(i, j))
        t = sign(1/(abs(cotangent) + sqrt(1 + cotangent**2)), cotangent)
        turn = reshape([1.0_dp, -t, t, 1.0_dp]/sqrt(1 + t**2), [2, 2])
        s(:, [i, j]) = matmul(s(:, [i, j]), turn)
        s([i, j], :) = matmul(transpose(turn), s([i, j], :))
        v(:, [i, j]) = matmul(v(:, [i, j]), turn)
      end do
    end do
  end do
  do i = 1, n
    j = minloc([(s(sweep, sweep), sweep=1, n)], 1)
    w(i) = s(j, j)
    a(:n, i) = v(:, j)
    s(j, j) = huge(1.0_dp)
  end do
end subroutine dsyev
