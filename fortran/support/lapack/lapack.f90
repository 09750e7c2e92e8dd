! The four routines of LAPACK that the core calls, for wheels and for systems without LAPACK, after G. H. Golub and
! C. F. Van Loan, Matrix Computations. They do what the core asks for and no more; arguments and storage are those of LAPACK.

!> Factorise a band matrix by Gaussian elimination with row exchanges.
subroutine dgbtrf(m, n, kl, ku, ab, ldab, ipiv, info)
  use kinds, only: dp
  implicit none
  integer, intent(in) :: m, n, kl, ku, ldab
  real(dp), intent(inout) :: ab(ldab, n)       !! a(i, j) in row d + i - j of column j; the first kl rows receive what fills in
  integer, intent(out) :: ipiv(n), info
  real(dp) :: row
  integer :: c, d, j, below, pivot

  d = kl + ku + 1
  ab(:kl, :) = 0
  info = 0
  do j = 1, n
    below = min(kl, m - j)
    pivot = maxloc(abs(ab(d:d + below, j)), 1) - 1
    ipiv(j) = j + pivot
    if (.not. abs(ab(d + pivot, j)) > 0) then
      info = j
      return
    end if
    do c = j, min(n, j + kl + ku)
      row = ab(d + pivot + j - c, c)
      ab(d + pivot + j - c, c) = ab(d + j - c, c)
      ab(d + j - c, c) = row
      if (c == j) ab(d + 1:d + below, j) = ab(d + 1:d + below, j)/row
      if (c > j) ab(d + 1 + j - c:d + below + j - c, c) = ab(d + 1 + j - c:d + below + j - c, c) - row*ab(d + 1:d + below, j)
    end do
  end do
end subroutine dgbtrf

!> Solve with the factors of dgbtrf. `trans` is 'N'.
subroutine dgbtrs(trans, n, kl, ku, nrhs, ab, ldab, ipiv, b, ldb, info)
  use kinds, only: dp
  implicit none
  character, intent(in) :: trans
  integer, intent(in) :: n, kl, ku, nrhs, ldab, ldb, ipiv(n)
  real(dp), intent(in) :: ab(ldab, n)
  real(dp), intent(inout) :: b(ldb, nrhs)
  integer, intent(out) :: info
  integer :: d, j, k, above, below

  info = merge(0, -1, trans == 'N')
  d = kl + ku + 1
  do k = 1, nrhs
    do j = 1, n
      below = min(kl, n - j)
      b([j, ipiv(j)], k) = b([ipiv(j), j], k)
      b(j + 1:j + below, k) = b(j + 1:j + below, k) - b(j, k)*ab(d + 1:d + below, j)
    end do
    do j = n, 1, -1
      above = min(kl + ku, j - 1)
      b(j, k) = b(j, k)/ab(d, j)
      b(j - above:j - 1, k) = b(j - above:j - 1, k) - b(j, k)*ab(d - above:d - 1, j)
    end do
  end do
end subroutine dgbtrs

!> Solve with a symmetric positive definite band matrix by Cholesky's method. `uplo` is 'U'.
subroutine dpbsv(uplo, n, kd, nrhs, ab, ldab, b, ldb, info)
  use kinds, only: dp
  implicit none
  character, intent(in) :: uplo
  integer, intent(in) :: n, kd, nrhs, ldab, ldb
  real(dp), intent(inout) :: ab(ldab, n), b(ldb, nrhs)     ! a(i, j), i <= j, in row d + i - j of column j
  integer, intent(out) :: info
  integer :: d, i, j, first

  info = merge(0, -1, uplo == 'U')
  d = kd + 1
  do j = 1, n
    first = max(1, j - kd)
    do i = first, j - 1
      ab(d + i - j, j) = (ab(d + i - j, j) - dot_product(ab(d + first - i:kd, i), ab(d + first - j:d + i - j - 1, j)))/ab(d, i)
    end do
    ab(d, j) = ab(d, j) - sum(ab(d + first - j:kd, j)**2)
    if (.not. ab(d, j) > 0) then
      info = j
      return
    end if
    ab(d, j) = sqrt(ab(d, j))
    b(j, :) = (b(j, :) - matmul(ab(d + first - j:kd, j), b(first:j - 1, :)))/ab(d, j)
  end do
  do j = n, 1, -1
    first = max(1, j - kd)
    b(j, :) = b(j, :)/ab(d, j)
    do i = first, j - 1
      b(i, :) = b(i, :) - ab(d + i - j, j)*b(j, :)
    end do
  end do
end subroutine dpbsv

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
