!> Cases that a program in another language has opened, by numbers that are not used twice: a number of a closed case stands for
!> nothing, so that it can be refused.
module open_cases
  use, intrinsic :: iso_fortran_env, only: int64
  use prepared_cases, only: prepared_type, release
  implicit none
  private
  public :: add_case, case_at, close_case

  integer, parameter :: per_block = 1024, most_blocks = 4096

  type :: slot_type
    type(prepared_type), pointer :: p => null()
  end type slot_type

  !> Blocks stay where they are, so that one thread may look up a case while another one opens the next.
  type :: block_type
    type(slot_type), pointer :: slots(:) => null()
  end type block_type

  type(block_type), save :: blocks(most_blocks)
  integer(int64), save :: opened = 0

contains

  !> Keep a case under a number; 0 where there is no room for more.
  subroutine add_case(p, number)
    type(prepared_type), pointer, intent(in) :: p
    integer(int64), intent(out) :: number
    integer :: i, j

    number = 0
    !$omp critical (cases)
    if (opened < int(per_block, int64)*most_blocks) then
      i = int(opened/per_block) + 1
      j = int(mod(opened, int(per_block, int64))) + 1
      if (.not. associated(blocks(i)%slots)) allocate (blocks(i)%slots(per_block))
      blocks(i)%slots(j)%p => p
      opened = opened + 1
      number = opened
    end if
    !$omp end critical (cases)
  end subroutine add_case

  !> The case of a number; null where none is open.
  function case_at(number) result(p)
    integer(int64), intent(in) :: number
    type(prepared_type), pointer :: p
    integer :: i

    p => null()
    if (number < 1 .or. number > int(per_block, int64)*most_blocks) return
    i = int((number - 1)/per_block) + 1
    if (associated(blocks(i)%slots)) p => blocks(i)%slots(int(mod(number - 1, int(per_block, int64))) + 1)%p
  end function case_at

  !> Free the case of a number, which stands for nothing from now on.
  subroutine close_case(number)
    integer(int64), intent(in) :: number
    type(prepared_type), pointer :: p

    !$omp critical (cases)
    p => case_at(number)
    if (associated(p)) &
      nullify (blocks(int((number - 1)/per_block) + 1)%slots(int(mod(number - 1, int(per_block, int64))) + 1)%p)
    !$omp end critical (cases)
    if (.not. associated(p)) return
    call release(p)
    deallocate (p)
  end subroutine close_case

end module open_cases
