!> The column file of a run.
!>
!> A column file has a line of names, comment lines about the run, a line of units, fixed-width numbers, and comment lines
!> with the results.
!>
!> The names come first because numpy.genfromtxt(names=True) and pandas.read_csv(comment='#') expect them there. Both skip
!> comment lines wherever they stand. Everything is written once, in this order, to a scratch file beside the column file.
!> The scratch file gets the name of the column file only when it is complete. An earlier file of this name is replaced if it is of
!> the same case; else it is kept under another name.
module column_files
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use, intrinsic :: iso_fortran_env, only: int64
  use case, only: case_type
  use columns, only: column_type, column_width, list_columns, most_columns
  use errors, only: error_type, fatal_error
  use kinds, only: dp
  use motion_state, only: motion_type
  use results, only: newline
  use row_sink, only: row_writer
  use run_monitor, only: run_type
  use run_results, only: describe_results, describe_setup
  use run_setup, only: setup_type
  use system, only: read_file, scratch_file, set_aside
  implicit none
  private
  public :: column_file, begin_columns, finish_columns

  integer, parameter :: width = column_width

  type, extends(row_writer) :: column_file
    type(scratch_file) :: file
    character(:), allocatable :: settings      !! that tell the case from others
    character(:), allocatable :: kept          !! name of an earlier file of another case from now on
  contains
    procedure :: begin
    procedure :: write_row
    procedure :: complete
    procedure :: publish
    procedure :: keep_other_case
    procedure, private :: put_comments, check
  end type column_file

contains

  !> Begin the column file that receives the rows of a run.
  subroutine begin_columns(c, setup, file, columns, error)
    type(case_type), intent(in) :: c
    type(setup_type), intent(in) :: setup
    character(*), intent(in) :: file
    type(column_file), intent(inout) :: columns
    type(error_type), allocatable, intent(out) :: error
    type(column_type) :: list(most_columns)
    type(motion_type) :: motion            ! any
    real(dp) :: values(most_columns)
    character(:), allocatable :: about
    integer :: n

    call list_columns(c, setup, motion, 0.0_dp, values, n, list)
    call describe_setup(c, setup, about)
    call columns%begin(file, about, list(:n)%name, list(:n)%unit, error)
  end subroutine begin_columns

  !> Complete the column file of a run with its results, and give it its name.
  subroutine finish_columns(c, run, columns, error)
    type(case_type), intent(in) :: c
    type(run_type), intent(in) :: run
    type(column_file), intent(inout) :: columns
    type(error_type), allocatable, intent(out) :: error
    character(:), allocatable :: results

    call describe_results(c, run, results)
    call columns%complete(results, error)
    if (.not. allocated(error)) call columns%keep_other_case(error)
    if (.not. allocated(error)) call columns%publish(error)
    call columns%file%abandon()
  end subroutine finish_columns

  !> Begin a file: names, comments, units.
  subroutine begin(this, file, about, names, units, error)
    class(column_file), intent(inout) :: this
    character(*), intent(in) :: file
    character(*), intent(in) :: about          !! lines ended by newline
    character(*), intent(in) :: names(:), units(:)
    type(error_type), allocatable, intent(out) :: error
    character(width*size(units)) :: line

    call find_settings(about, this%settings)
    call this%file%begin(file)
    call this%check('cannot be written', error)
    if (allocated(error)) return
    call this%file%put(cells(names)//newline)
    call this%put_comments(about)
    line = cells(units)
    line(1:1) = '#'
    call this%file%put(line//newline)
    call this%check('cannot be written completely', error)
  end subroutine begin

  !> Write a row.
  subroutine write_row(this, row, error)
    class(column_file), intent(inout) :: this
    real(dp), intent(in) :: row(:)
    type(error_type), allocatable, intent(out) :: error
    character(width*size(row)) :: cells

    call write_numbers(size(row), row, cells)
    call this%file%put(cells//newline)
    call this%check('cannot be written completely', error)
  end subroutine write_row

  !> Write the results after the last row; `publish` then gives the file its name.
  subroutine complete(this, results, error)
    class(column_file), intent(inout) :: this
    character(*), intent(in) :: results        !! lines ended by newline
    type(error_type), allocatable, intent(out) :: error

    call this%put_comments(results)
    call this%file%complete()
    call this%check('cannot be written completely', error)
  end subroutine complete

  !> Give an earlier file another name, unless it is empty or of the same case.
  subroutine keep_other_case(this, error)
    class(column_file), intent(inout) :: this
    type(error_type), allocatable, intent(out) :: error
    integer, parameter :: head = 2**16         ! has the comments before the rows [bytes]
    character(:), allocatable :: earlier, settings
    logical :: opened, ok

    call read_file(this%file%name, earlier, opened, ok, enough=head)
    if (.not. opened .or. len(earlier) == 0) return
    call find_settings(earlier, settings)
    if (settings == this%settings) return
    call set_aside(this%file%place, this%kept, this%file%ok)
    call this%check('holds another case, and cannot be renamed', error)
  end subroutine keep_other_case

  !> Give the lines that tell a case from others: profiles and groups of the namelist, but not its name, its outputs and what follows
  !> from the settings. The text is the comments of a column file, or the file's head.
  pure subroutine find_settings(text, settings)
    character(*), intent(in) :: text
    character(:), allocatable, intent(out) :: settings
    character(*), parameter :: mark = '# '
    character(:), allocatable :: line
    logical :: told
    integer :: from, to

    settings = ''
    told = .false.
    from = 1
    do while (from <= len(text))
      to = from + index(text(from:), newline) - 2
      if (to < from - 1) exit
      line = text(from:to)
      from = to + 2
      if (index(line, mark) == 1) line = line(len(mark) + 1:)
      select case (line(:min(1, len(line))))
      case ('&')
        told = .not. any(line == [character(8) :: '&setup', '&case', '&output', '&results'])
      case ('/')
        told = .false.
      end select
      if (told .or. index(line, ' profile: ') > 0) settings = settings//trim(line)//newline
    end do
  end subroutine find_settings

  !> Give a complete file its name.
  subroutine publish(this, error)
    class(column_file), intent(inout) :: this
    type(error_type), allocatable, intent(out) :: error

    call this%file%finish()
    call this%check('cannot be written completely', error)
  end subroutine publish

  !> Discard a file that could not be written.
  subroutine check(this, failure, error)
    class(column_file), intent(inout) :: this
    character(*), intent(in) :: failure
    type(error_type), allocatable, intent(inout) :: error

    if (this%file%ok) return
    call fatal_error(error, failure, this%file%name)
    call this%file%abandon()
  end subroutine check

  !> Write lines as comments.
  subroutine put_comments(this, lines)
    class(column_file), intent(inout) :: this
    character(*), intent(in) :: lines          !! ended by newline
    integer :: from, to

    from = 1
    do while (from <= len(lines))
      to = from + index(lines(from:), newline) - 2
      call this%file%put(trim('# '//lines(from:to))//newline)
      from = to + 2
    end do
  end subroutine put_comments

  !> Names or units, aligned with the numbers below them.
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

  !> Write numbers as es16.8 would, in a twentieth of the time. Numbers too small for a two-digit exponent are written as
  !> zero.
  pure subroutine write_numbers(n, x, cells)
    integer, intent(in) :: n
    real(dp), intent(in) :: x(n)
    character(width), intent(out) :: cells(n)
    integer :: i, k, binary, decade, digits, first, high, low
    integer, parameter :: most = 99
    real(dp), parameter :: power(-most:most + 8) = [(10.0_dp**i, i=-most, most + 8)]
    character(2), parameter :: pairs(0:99) = [((achar(48 + i)//achar(48 + k), k=0, 9), i=0, 9)]
    character(4), parameter :: fours(0:9999) = [((pairs(i)//pairs(k), k=0, 99), i=0, 99)]
    character(4), parameter :: exponents(-most:most) = [('E-'//pairs(-i), i=-most, -1), ('E+'//pairs(i), i=0, most)]
    character(4), parameter :: firsts(0:19) = [('  '//achar(48 + i)//'.', i=0, 9), (' -'//achar(48 + i)//'.', i=0, 9)]
    real(dp) :: magnitude
    integer(int64) :: bits

    do k = 1, n
      bits = transfer(x(k), bits)
      binary = int(ibits(bits, 52, 11)) - 1022      ! the exponent: magnitude < 2**binary
      magnitude = abs(x(k))
      if (abs(binary) >= 325) then
        ! This test comes first, because a comparison with NaN traps in the debug build.
        if (ieee_is_nan(x(k))) then
          cells(k) = '             NaN'
          cycle
        end if
        if (magnitude < 1e-98_dp .or. magnitude >= 1e98_dp) then
          cells(k) = '  0.00000000E+00'
          if (magnitude > 1) write (cells(k), '(es16.8e3)') x(k)
          cycle
        end if
      end if
      ! The power of ten follows from the power of two, and may exceed the result by one. 1233/4096 approximates log10(2).
      decade = shifta((binary - 1)*1233, 12)
      if (magnitude*power(8 - decade) + 0.5_dp >= 1e9_dp) decade = decade + 1
      digits = int(magnitude*power(8 - decade) + 0.5_dp)
      high = digits/10000
      low = digits - 10000*high
      first = high/10000
      high = high - 10000*first
      if (bits < 0) first = first + 10
      cells(k)(1:4) = firsts(first)
      cells(k)(5:8) = fours(high)
      cells(k)(9:12) = fours(low)
      cells(k)(13:16) = exponents(decade)
    end do
  end subroutine write_numbers

end module column_files
