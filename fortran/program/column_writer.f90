!> Column files: a line of names, comment lines about the run, a line of units, fixed-width numbers, and comment lines
!> with the results.
!>
!> The names come first because that is where numpy.genfromtxt(names=True) and pandas.read_csv(comment='#') look; both
!> skip comment lines wherever they stand. Everything is written once, in this order, to a scratch file beside the file,
!> which gets its name only when it is complete.
module column_writer
  use columns, only: column_width
  use errors, only: error_type, fatal_error
  use kinds, only: dp
  use row_sink, only: row_taker
  use system, only: scratch_file
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use, intrinsic :: iso_fortran_env, only: int64
  implicit none
  private
  public :: column_file

  integer, parameter :: width = column_width

  type, extends(row_taker) :: column_file
    private
    type(scratch_file) :: file
    character(:), allocatable :: name
    character(:), allocatable :: waiting   !! rows as text, the first `filled` characters of it
    integer :: filled = 0
  contains
    procedure :: begin
    procedure :: take
    procedure :: finish
    procedure :: place
    procedure :: abandon
  end type column_file

  integer, parameter :: at_once = 2**16   ! that is written [bytes], and a row more

contains

  !> Begin a file: names, comments, units.
  subroutine begin(this, file, about, names, units, error)
    class(column_file), intent(inout) :: this
    character(*), intent(in) :: file
    character(*), intent(in) :: about          !! lines ended by newline
    character(*), intent(in) :: names(:), units(:)
    type(error_type), allocatable, intent(out) :: error
    character(:), allocatable :: line

    this%name = file
    allocate (character(at_once + width*size(names) + 1) :: this%waiting)
    call this%file%begin(file)
    call this%file%put(cells(names)//new_line('a'))
    call put_comments(this%file, about)
    line = cells(units)
    line(1:1) = '#'
    call this%file%put(line//new_line('a'))
    if (this%file%ok) return
    call this%abandon()
    call fatal_error(error, file//': cannot be written')
  end subroutine begin

  !> Write a row.
  subroutine take(this, row, error)
    class(column_file), intent(inout) :: this
    real(dp), intent(in) :: row(:)
    type(error_type), allocatable, intent(out) :: error
    integer :: length

    length = width*size(row)
    call write_numbers(size(row), row, this%waiting(this%filled + 1:this%filled + length))
    this%filled = this%filled + length + 1
    this%waiting(this%filled:this%filled) = new_line('a')
    if (this%filled < at_once) return
    call this%file%put(this%waiting(:this%filled))
    this%filled = 0
    if (this%file%ok) return
    call this%abandon()
    call incomplete(this%name, error)
  end subroutine take

  !> Write the results after the last row; `place` then gives the file its name.
  subroutine finish(this, results, error)
    class(column_file), intent(inout) :: this
    character(*), intent(in) :: results        !! lines ended by newline
    type(error_type), allocatable, intent(out) :: error

    call this%file%put(this%waiting(:this%filled))
    this%filled = 0
    call put_comments(this%file, results)
    call this%file%complete()
    if (this%file%ok) return
    call incomplete(this%name, error)
    call this%abandon()
  end subroutine finish

  !> Give a complete file its name.
  subroutine place(this, error)
    class(column_file), intent(inout) :: this
    type(error_type), allocatable, intent(out) :: error

    call this%file%finish()
    if (.not. this%file%ok) call incomplete(this%name, error)
    call this%abandon()
  end subroutine place

  subroutine incomplete(file, error)
    character(*), intent(in) :: file
    type(error_type), allocatable, intent(out) :: error

    call fatal_error(error, file//': cannot be written completely')
  end subroutine incomplete

  !> Forget a file that has no name yet.
  subroutine abandon(this)
    class(column_file), intent(inout) :: this

    call this%file%abandon()
    if (allocated(this%waiting)) deallocate (this%waiting)
    this%filled = 0
  end subroutine abandon

  !> Write lines as comments.
  subroutine put_comments(file, lines)
    type(scratch_file), intent(inout) :: file
    character(*), intent(in) :: lines          !! ended by newline
    integer :: from, to

    from = 1
    do while (from <= len(lines))
      to = from + index(lines(from:), new_line('a')) - 2
      call file%put(trim('# '//lines(from:to))//new_line('a'))
      from = to + 2
    end do
  end subroutine put_comments

  !> Words as they stand above the numbers.
  pure function cells(words) result(line)
    character(*), intent(in) :: words(:)
    character(width*size(words)) :: line
    character(width) :: cell
    integer :: i

    do i = 1, size(words)
      cell = words(i)
      line(1 + (i - 1)*width:i*width) = adjustr(cell)
    end do
  end function cells

  !> Write numbers as es16.8 would, in a tenth of the time. Numbers too small for a two-digit exponent are written as zero.
  pure subroutine write_numbers(n, x, cells)
    integer, intent(in) :: n
    real(dp), intent(in) :: x(n)
    character(width), intent(out) :: cells(n)
    integer :: i, k, decade, high, low, hundreds
    integer, parameter :: most = 99
    real(dp), parameter :: power(-most:most + 8) = [(10.0_dp**i, i=-most, most + 8)]
    character(2), parameter :: pairs(0:99) = [((achar(48 + i)//achar(48 + k), k=0, 9), i=0, 9)]
    character(4), parameter :: exponents(-most:most) = [('E-'//pairs(-i), i=-most, -1), ('E+'//pairs(i), i=0, most)]
    character(4), parameter :: first(0:9) = [('  '//achar(48 + i)//'.', i=0, 9)]
    real(dp) :: magnitude
    integer(int64) :: digits

    do k = 1, n
      ! First, for a comparison with what is no number traps in the debug build.
      if (ieee_is_nan(x(k))) then
        cells(k) = '             NaN'
        cycle
      end if
      magnitude = abs(x(k))
      if (magnitude < 1e-98_dp .or. magnitude >= 1e98_dp) then
        cells(k) = '  0.00000000E+00'
        if (magnitude > 1) write (cells(k), '(es16.8e3)') x(k)
        cycle
      end if
      ! From the power of two, which the power of ten may exceed by one; 1233/4096 is log10(2) as far as that goes.
      decade = shifta((exponent_of(magnitude) - 1)*1233, 12)
      digits = int(magnitude*power(8 - decade) + 0.5_dp, int64)
      if (digits >= 1000000000_int64) then
        decade = decade + 1
        digits = int(magnitude*power(8 - decade) + 0.5_dp, int64)
      end if
      high = int(digits/10000)
      low = int(digits - 10000*int(high, int64))
      i = high/10000
      high = high - 10000*i
      cells(k)(1:4) = first(i)
      if (x(k) < 0) cells(k)(2:2) = '-'
      hundreds = high/100
      cells(k)(5:6) = pairs(hundreds)
      cells(k)(7:8) = pairs(high - 100*hundreds)
      hundreds = low/100
      cells(k)(9:10) = pairs(hundreds)
      cells(k)(11:12) = pairs(low - 100*hundreds)
      cells(k)(13:16) = exponents(decade)
    end do
  end subroutine write_numbers

  !> `exponent` of a positive number, from its bits.
  elemental integer function exponent_of(x)
    real(dp), intent(in) :: x

    exponent_of = int(shiftr(transfer(x, 0_int64), 52)) - 1022
  end function exponent_of

end module column_writer