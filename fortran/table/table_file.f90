!> Contact tables in files. A file consists of words of 64 bits, of which the last one is a checksum of the others.
module table_file
  use, intrinsic :: iso_c_binding, only: c_f_pointer, c_loc
  use, intrinsic :: iso_fortran_env, only: int64
  use bspline, only: axis_type, new_axis
  use contact_zones, only: max_zones
  use errors, only: error_type, fatal_error
  use kinds, only: dp
  use contact_table, only: accuracy_type, table_type
  use zone_tables, only: bound_heights, zone_table
  use system, only: scratch_file
  implicit none
  private
  public :: save_table, load_table

  ! Files of other versions of the program have something else behind the kind, or another key.
  character(*), parameter :: kind = 'ldbench contact table', magic = kind//'   '

  !> A file that is being read.
  type :: reader_type
    integer :: unit = 0, stat = 0          !! stat is 0 while everything was right
    integer(int64) :: bytes = 0            !! size of the file
    integer(int64) :: mix = 0              !! checksum of the words read so far
  end type reader_type

contains

  !> Write a table to a file, complete or not at all. A file that cannot be written is an error.
  subroutine save_table(file, table, error)
    character(*), intent(in) :: file
    type(table_type), intent(in) :: table
    type(error_type), allocatable, intent(out) :: error
    type(scratch_file) :: out
    integer(int64) :: mix
    integer :: i, n_pairs

    mix = 0
    call out%begin(file)
    call put(words_of(magic))
    call put(int([len(table%key), size(table%zones), table%accuracy%poses, table%accuracy%unsolved, &
      table%accuracy%pulling, table%solutions, table%roll%n], int64))
    call put(words_of(table%key))
    call put_numbers([table%accuracy%rms, table%accuracy%largest, table%roll%x])
    do i = 1, size(table%zones)
      associate (t => table%zones(i))
        call put(int([merge(1, 0, t%flange), t%u%n, t%q%n], int64))
        call put_numbers([t%along, t%pole, t%origin, t%ceiling, t%tip, t%u%x, t%q%x])
        call put_numbers(reshape(t%h, [size(t%h)]))
        call put_numbers(reshape(t%s, [size(t%s)]))
      end associate
    end do
    n_pairs = -1
    if (allocated(table%pairs)) n_pairs = size(table%pairs)
    call put(int([n_pairs], int64))
    do i = 1, n_pairs
      associate (t => table%pairs(i))
        call put(int([t%zone, t%u%n, t%roll%n, t%p%n], int64))
        call put_numbers([t%u%x, t%roll%x, t%p%x])
        call put_numbers(reshape(t%c, [size(t%c)]))
      end associate
    end do
    call out%put(transfer(mix, repeat(' ', 8)))
    call out%finish()
    if (.not. out%ok) call fatal_error(error, '&table file = '//file//': cannot be written')

  contains

    subroutine put(words)
      integer(int64), intent(in) :: words(:)

      call out%put(transfer(words, repeat(' ', 8*size(words))))
      call stir(mix, words)
    end subroutine put

    subroutine put_numbers(numbers)
      real(dp), intent(in) :: numbers(:)

      call put(transfer(numbers, [0_int64]))
    end subroutine put_numbers

  end subroutine save_table

  !> Read the table that was made for `key`. `found` is false if the file is absent, damaged or made for something else.
  !> A file that is no table is an error, for the table would replace it.
  subroutine load_table(file, key, table, found, error)
    character(*), intent(in) :: file, key
    type(table_type), intent(out) :: table
    logical, intent(out) :: found
    type(error_type), allocatable, intent(out) :: error
    type(reader_type) :: in
    character(len(magic)) :: mark
    integer :: n

    found = .false.
    open (newunit=in%unit, file=file, access='stream', form='unformatted', action='read', &
      status='old', iostat=in%stat)
    if (in%stat /= 0) return
    inquire (unit=in%unit, size=in%bytes)
    n = int(min(in%bytes, len(kind, int64)))
    read (in%unit, iostat=in%stat) mark(:n)
    if (in%stat /= 0 .or. mark(:n) /= kind(:n)) then
      call fatal_error(error, '&table file = '//file//': expected a contact table or no file, found another one')
    else
      read (in%unit, pos=1, iostat=in%stat) mark
      if (in%stat == 0 .and. mark == magic) then
        call stir(in%mix, words_of(mark))
        call read_table(in, key, table, found)
      end if
    end if
    close (in%unit)
  end subroutine load_table

  !> Read what follows the kind of file.
  subroutine read_table(in, key, table, found)
    type(reader_type), intent(inout) :: in
    character(*), intent(in) :: key
    type(table_type), intent(inout) :: table
    logical, intent(inout) :: found
    character(:), allocatable :: stored
    real(dp) :: numbers(8)
    integer(int64) :: head(11)
    integer :: i

    stored = repeat(' ', 8*words_for(len(key)))
    call take(in, head)
    if (in%stat /= 0 .or. head(1) /= len(key) .or. head(2) < 1 .or. head(2) > max_zones .or. .not. is_extent(head(11))) return
    read (in%unit, iostat=in%stat) stored
    if (in%stat /= 0 .or. stored /= key) return
    call stir(in%mix, words_of(stored))
    table%key = key
    call take_numbers(in, 8, numbers)
    head(3:) = max(0_int64, min(head(3:), int(huge(1), int64)))
    table%accuracy = accuracy_type(int(head(7)), int(head(8)), int(head(3:6)), numbers(:4), numbers(5:))
    table%solutions = int(head(9:10))
    call take_axis(in, int(head(11)), table%roll)
    allocate (table%zones(head(2)))
    do i = 1, size(table%zones)
      if (in%stat == 0) call read_zone(in, head(11), table%zones(i))
      if (in%stat /= 0) return
    end do
    call read_pairs(in, table)
    if (in%stat /= 0) return
    read (in%unit, iostat=in%stat) head(1)
    if (in%stat /= 0 .or. head(1) /= in%mix) return
    inquire (unit=in%unit, pos=head(1))
    found = head(1) == in%bytes + 1
    if (.not. found) return
    do i = 1, size(table%zones)
      call bound_heights(table%zones(i))
    end do
  end subroutine read_table

  !> Read the axes and the coefficients of one zone. Whatever the file holds, no more memory is taken than it has bytes.
  subroutine read_zone(in, n_roll, t)
    type(reader_type), intent(inout) :: in
    integer(int64), intent(in) :: n_roll       !! points of the roll angle
    type(zone_table), intent(inout) :: t
    real(dp) :: numbers(8)
    integer(int64) :: head(3)

    call take(in, head)
    if (in%stat == 0 .and. .not. all(is_extent(head(2:)))) in%stat = 1
    if (in%stat /= 0) return
    t%flange = head(1) == 1
    call take_numbers(in, 8, numbers)
    t%along = numbers(1:2)
    t%pole = numbers(3:4)
    t%origin = numbers(5:6)
    t%ceiling = numbers(7)
    t%tip = numbers(8)
    call take_axis(in, int(head(2)), t%u)
    call take_axis(in, int(head(3)), t%q)
    if (in%stat == 0 .and. 8*product(head(2:3) + 2)*(n_roll + 2) > in%bytes) in%stat = 1
    if (in%stat /= 0) return
    allocate (t%h(n_roll + 2, head(2) + 2), t%s(head(3) + 2, n_roll + 2, head(2) + 2), stat=in%stat)
    if (in%stat /= 0) return
    call take_numbers(in, size(t%h), t%h)
    call take_numbers(in, size(t%s), t%s)
  end subroutine read_zone

  !> Read the influences of the zones on each other.
  subroutine read_pairs(in, table)
    type(reader_type), intent(inout) :: in
    type(table_type), intent(inout) :: table
    integer(int64) :: head(5)
    integer :: i

    call take(in, head(:1))
    if (in%stat /= 0 .or. head(1) < 0) return
    if (head(1) > max_zones**2) in%stat = 1
    if (in%stat /= 0) return
    allocate (table%pairs(head(1)))
    do i = 1, size(table%pairs)
      call take(in, head)
      if (in%stat == 0 .and. .not. (all(is_extent(head(3:))) .and. all(head(:2) > 0 .and. head(:2) <= size(table%zones)))) &
        in%stat = 1
      if (in%stat /= 0) return
      if (8*product(head(3:) + 2) > in%bytes) in%stat = 1
      associate (t => table%pairs(i))
        t%zone = int(head(:2))
        call take_axis(in, int(head(3)), t%u)
        call take_axis(in, int(head(4)), t%roll)
        call take_axis(in, int(head(5)), t%p)
        if (in%stat == 0) allocate (t%c(head(5) + 2, head(4) + 2, head(3) + 2), stat=in%stat)
        if (in%stat /= 0) return
        call take_numbers(in, size(t%c), t%c)
      end associate
    end do
  end subroutine read_pairs

  !> Whether an axis may have so many points.
  elemental logical function is_extent(points)
    integer(int64), intent(in) :: points

    is_extent = points >= 5 .and. points <= 10000
  end function is_extent

  !> Read words; they are 0 if the file does not have them.
  subroutine take(in, words)
    type(reader_type), intent(inout) :: in
    integer(int64), contiguous, intent(out) :: words(:)

    if (in%stat == 0) read (in%unit, iostat=in%stat) words
    if (in%stat /= 0) words = 0
    if (in%stat == 0) call stir(in%mix, words)
  end subroutine take

  !> Read n numbers, whose bits are words.
  subroutine take_numbers(in, n, numbers)
    type(reader_type), intent(inout) :: in
    integer, intent(in) :: n
    real(dp), target, intent(out) :: numbers(n)
    integer(int64), pointer, contiguous :: words(:)

    call c_f_pointer(c_loc(numbers), words, [n])
    call take(in, words)
  end subroutine take_numbers

  !> Read the n points of an axis.
  subroutine take_axis(in, n, axis)
    type(reader_type), intent(inout) :: in
    integer, intent(in) :: n
    type(axis_type), intent(inout) :: axis
    real(dp) :: x(n)

    call take_numbers(in, n, x)
    if (in%stat == 0 .and. .not. rising(x)) in%stat = 1
    if (in%stat == 0) axis = new_axis(x)
  end subroutine take_axis

  !> Whether numbers from a file, which may be damaged, can be the points of an axis.
  pure logical function rising(x)
    real(dp), intent(in) :: x(:)

    rising = all(x(2:) > x(:size(x) - 1)) .and. all(abs(x) < 1e3_dp)
  end function rising

  pure integer function words_for(letters)
    integer, intent(in) :: letters

    words_for = (letters + 7)/8
  end function words_for

  !> Return a text as words; blanks fill up the last one.
  pure function words_of(text) result(words)
    character(*), intent(in) :: text
    integer(int64) :: words(words_for(len(text)))
    character(8*words_for(len(text))) :: filled

    filled = text
    words = transfer(filled, words)
  end function words_of

  !> Mix words into a checksum that changes with every word. Between two words the generator xorshift64 makes a step
  !> (G. Marsaglia, J. Stat. Softw. 8 (2003) 14), which is invertible and has the period 2^64 - 1.
  pure subroutine stir(mix, words)
    integer(int64), intent(inout) :: mix
    integer(int64), contiguous, intent(in) :: words(:)
    integer :: i

    do i = 1, size(words)
      mix = ieor(mix, words(i))
      mix = ieor(mix, shiftl(mix, 13))
      mix = ieor(mix, shiftr(mix, 7))
      mix = ieor(mix, shiftl(mix, 17))
    end do
  end subroutine stir

end module table_file