!> Passes the rows of a run in the order of time to a file, which grows with them, or to memory.
module row_sink
  use errors, only: error_type
  use kinds, only: dp
  implicit none
  private
  public :: row_writer, row_queue, on_grid, at_event, at_impact

  !> Receives the rows of a run in the order of time.
  type, abstract :: row_writer
  contains
    procedure(write_row_to), deferred :: write_row
  end type row_writer

  abstract interface
    subroutine write_row_to(this, row, error)
      import :: dp, error_type, row_writer
      class(row_writer), intent(inout) :: this
      real(dp), intent(in) :: row(:)
      type(error_type), allocatable, intent(out) :: error
    end subroutine write_row_to
  end interface

  enum, bind(c)
    enumerator :: on_grid, at_event, at_impact
  end enum

  ! Two steps can add this many rows. Each has at most eleven events, four peaks, two rows of an impact and one grid row.
  integer, parameter :: most = 64

  !> Rows in order of time that wait for rows before them: the peak of a force is known one step after it.
  !>
  !> Rows at equal intervals and rows before and after impacts are always given. A row at another event is left out
  !> where its time could not be told from that of a neighbour in nine digits.
  type :: row_queue
    integer :: passed = 0                    !! number of rows that have been given
    real(dp), allocatable :: last(:)        !! the last of them, (column)
    integer, private :: n = 0
    integer, private :: kind(most) = 0
    real(dp), private :: near = 0           ! rows within this time are one, besides nine digits [s]
    real(dp), allocatable, private :: row(:, :)   ! (column, row), the first n of them
    class(row_writer), pointer, private :: writer => null()
  contains
    procedure :: begin
    procedure :: put
    procedure :: pass_rows
    procedure, private :: move
  end type row_queue

contains

  subroutine begin(this, near, writer)
    class(row_queue), intent(out) :: this
    real(dp), intent(in) :: near            !! [s]
    class(row_writer), target, intent(inout) :: writer

    this%writer => writer
    this%near = near
  end subroutine begin

  !> Put a row, whose first number is its time, in its place.
  pure subroutine put(this, row, kind)
    class(row_queue), intent(inout) :: this
    real(dp), intent(in) :: row(:)          !! (column)
    integer, intent(in) :: kind             !! on_grid, at_event, at_impact
    real(dp) :: near
    integer :: i

    if (.not. allocated(this%row)) allocate (this%row(size(row), most), this%last(size(row)), source=0.0_dp)
    near = this%near + 2e-8_dp*row(1)
    if (kind == at_event .and. this%passed > 0 .and. row(1) - this%last(1) <= near) return
    if (kind /= at_impact) then
      do i = this%n, 1, -1
        if (abs(this%row(1, i) - row(1)) > near) cycle
        ! The earlier one of two events is kept, as it is in the mirrored run.
        if (kind == at_event .and. (this%kind(i) /= at_event .or. this%row(1, i) <= row(1))) return
        if (this%kind(i) /= at_event) cycle
        call this%move(i + 1, -1)
      end do
    end if
    i = count(this%row(1, :this%n) <= row(1)) + 1
    call this%move(i, 1)
    this%row(:, i) = row
    this%kind(i) = kind
  end subroutine put

  !> Move the rows from one on by some places.
  pure subroutine move(this, from, by)
    class(row_queue), intent(inout) :: this
    integer, intent(in) :: from, by

    this%row(:, from + by:this%n + by) = this%row(:, from:this%n)
    this%kind(from + by:this%n + by) = this%kind(from:this%n)
    this%n = this%n + by
  end subroutine move

  !> Pass the rows up to a time on to the row writer.
  subroutine pass_rows(this, up_to, error)
    class(row_queue), intent(inout) :: this
    real(dp), intent(in) :: up_to           !! [s]
    type(error_type), allocatable, intent(out) :: error
    integer :: i, n

    if (this%n == 0) return
    n = count(this%row(1, :this%n) <= up_to)
    do i = 1, n
      call this%writer%write_row(this%row(:, i), error)
      if (allocated(error)) return
      this%last = this%row(:, i)
      this%passed = this%passed + 1
    end do
    call this%move(n + 1, -n)
  end subroutine pass_rows

end module row_sink