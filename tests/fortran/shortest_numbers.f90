!> Numbers as `str` writes them, against the shortest text that is found by writing and reading alone.
!>
!> The argument is how many numbers of each kind are tried. The program prints how many texts differ, and the first of them.
program shortest_numbers
  use, intrinsic :: iso_fortran_env, only: int64
  use kinds, only: dp
  use text, only: str, with_zero
  implicit none
  integer :: n, i, kind, differ
  integer(int64) :: state
  real(dp) :: x
  character(40) :: expected, found, argument

  call get_command_argument(1, argument)
  read (argument, *) n
  state = 88172645463325252_int64
  differ = 0
  do i = 1, n
    do kind = 1, 4
      x = number(kind)
      expected = by_trial(x)
      found = str(x)
      if (found == expected) cycle
      if (differ == 0) print '(3a)', trim(found), ' instead of ', trim(expected)
      differ = differ + 1
    end do
  end do
  print '(i0)', differ

contains

  !> A number of a kind: any bits, a few digits, one beside a power of ten, one as runs have them.
  real(dp) function number(kind)
    integer, intent(in) :: kind
    integer(int64) :: bits
    integer :: digits, power

    select case (kind)
    case (1)
      bits = random()
      if (ibits(bits, 52, 11) > 1900) bits = ibclr(bits, 62)   ! below 1e270: no reader of the core takes more
      number = transfer(bits, number)
    case (2)
      digits = 1 + int(modulo(random(), 17_int64))
      power = int(modulo(random(), 60_int64)) - 30
      number = sign(real(modulo(random(), 10_int64**digits), dp), real(random(), dp))*10.0_dp**power
    case (3)
      power = int(modulo(random(), 80_int64)) - 40
      number = 10.0_dp**power
      number = transfer(transfer(number, 0_int64) + modulo(random(), 9_int64) - 4, number)
    case default
      power = int(modulo(random(), 22_int64)) - 12
      number = real(random(), dp)*2.0_dp**(-63)*10.0_dp**power
    end select
  end function number

  !> Marsaglia's xorshift.
  integer(int64) function random()
    state = ieor(state, ishft(state, 13))
    state = ieor(state, ishft(state, -7))
    state = ieor(state, ishft(state, 17))
    random = state
  end function random

  !> The fewest digits after the point, from one to twenty, that read back to the same number.
  function by_trial(x) result(word)
    real(dp), intent(in) :: x
    character(40) :: word
    character(12) :: form
    real(dp) :: back
    integer :: digits

    do digits = 1, 20
      if (abs(x) >= 1e-3_dp .and. abs(x) < 1e7_dp .or. abs(x) <= 0) then
        write (form, '(a,i0,a)') '(f0.', digits, ')'
      else
        write (form, '(a,i0,a)') '(es0.', digits, 'e0)'
      end if
      write (word, form) x
      read (word, *) back
      if (abs(back - x) <= 0) exit
    end do
    word = with_zero(word)
  end function by_trial

end program shortest_numbers
