!> Who takes the rows of a run, as they come: a file that grows with them, or memory.
module rows
  use errors, only: error_type, fatal_error
  use kinds, only: dp
  use text, only: str
  implicit none
  private
  public :: row_taker, row_list

  type, abstract :: row_taker
  contains
    procedure(take_row), deferred :: take
  end type row_taker

  abstract interface
    subroutine take_row(this, row, error)
      import :: dp, error_type, row_taker
      class(row_taker), intent(inout) :: this
      real(dp), intent(in) :: row(:)
      type(error_type), allocatable, intent(out) :: error
    end subroutine take_row
  end interface

  !> All rows, in memory.
  type, extends(row_taker) :: row_list
    integer :: n = 0
    real(dp), allocatable :: values(:, :)   !! (column, row), the first n of them
  contains
    procedure :: take
  end type row_list

contains

  subroutine take(this, row, error)
    class(row_list), intent(inout) :: this
    real(dp), intent(in) :: row(:)
    type(error_type), allocatable, intent(out) :: error
    real(dp), allocatable :: grown(:, :)
    integer :: stat

    if (.not. allocated(this%values)) allocate (this%values(size(row), 1024))
    if (this%n == size(this%values, 2)) then
      allocate (grown(size(row), 2*this%n), stat=stat)
      if (stat /= 0) then
        call fatal_error(error, 'expected memory for '//str(2*this%n)//' rows, found less')
        return
      end if
      grown(:, :this%n) = this%values
      call move_alloc(grown, this%values)
    end if
    this%n = this%n + 1
    this%values(:, this%n) = row
  end subroutine take

end module rows
