!> Contact tables in files: words of 64 bits, the last of which is a checksum of the others.
module table_file
  use, intrinsic :: iso_fortran_env, only: int64
  use bspline, only: new_axis
  use contact_zones, only: max_zones
  use errors, only: error_type, fatal_error
  use kinds, only: dp
  use contact_table, only: accuracy_type, bound_heights, table_type
  use system, only: scratch_file
  implicit none
  private
  public :: save_table, load_table

  ! Files of an older program have something else behind the kind, or another key.
  character(*), parameter :: kind = 'ldbench contact table', magic = kind//'   '

contains

  !> Write a table to a file, complete or not at all.
  subroutine save_table(file, table, error)
    character(*), intent(in) :: file
    type(table_type), intent(in) :: table
    type(error_type), allocatable, intent(out) :: error
    type(scratch_file) :: out
    integer(int64) :: mix
    integer :: i

    mix = 0
    call out%begin(file)
    call put(words_of(magic))
    call put(int([len(table%key), size(table%zones), table%accuracy%poses, table%accuracy%unsolved, &
      table%solutions], int64))
    call put(words_of(table%key))
    call put_numbers([table%accuracy%rms, table%accuracy%largest])
    do i = 1, size(table%zones)
      associate (t => table%zones(i))
        call put(int([merge(1, 0, t%flange), t%u%n, t%roll%n, t%q%n], int64))
        call put_numbers([t%along, t%pole, t%origin, t%ceiling, t%u%x, t%roll%x, t%q%x])
        call put_numbers(reshape(t%h, [size(t%h)]))
        call put_numbers(reshape(t%s, [size(t%s)]))
      end associate
    end do
    call out%put([mix])
    call out%finish()
    if (.not. out%ok) call fatal_error(error, '&table file = '//file//': cannot be written')

  contains

    subroutine put(words)
      integer(int64), intent(in) :: words(:)

      call out%put(words)
      call stir(mix, size(words), words)
    end subroutine put

    subroutine put_numbers(numbers)
      real(dp), intent(in) :: numbers(:)

      call put(transfer(numbers, [0_int64]))
    end subroutine put_numbers

  end subroutine save_table

  !> Read a table that was made for `key`; `found` is false when the file is absent, damaged or
  !> made for something else.  An error when it is no table: it would be lost.
  subroutine load_table(file, key, table, found, error)
    character(*), intent(in) :: file, key
    type(table_type), intent(out) :: table
    logical, intent(out) :: found
    type(error_type), allocatable, intent(out) :: error
    character(len(magic)) :: mark
    character(:), allocatable :: stored
    real(dp), allocatable :: u(:), roll(:), q(:)
    real(dp) :: numbers(8)
    integer(int64) :: bytes, mix, head(9)
    integer :: unit, stat, n, i

    found = .false.
    stored = repeat(' ', 8*words_for(len(key)))
    open (newunit=unit, file=file, access='stream', form='unformatted', action='read', &
      status='old', iostat=stat)
    if (stat /= 0) return
    inquire (unit=unit, size=bytes)
    n = int(min(bytes, len(kind, int64)))
    read (unit, iostat=stat) mark(:n)
    if (stat /= 0 .or. mark(:n) /= kind(:n)) then
      call fatal_error(error, '&table file = '//file//': expected a contact table or no file, found another one')
    else
      mix = 0
      read (unit, pos=1, iostat=stat) mark
      if (stat == 0 .and. mark == magic) call read_table()
    end if
    close (unit)

  contains

    subroutine read_table()
      call stir(mix, size(words_of(mark)), words_of(mark))
      call take_integers(9, head)
      if (stat /= 0 .or. head(1) /= len(key) .or. head(2) < 1 .or. head(2) > max_zones) return
      read (unit, iostat=stat) stored
      if (stat /= 0 .or. stored /= key) return
      call stir(mix, size(words_of(stored)), words_of(stored))
      table%key = key
      call take_numbers(8, numbers)
      head(3:) = max(0_int64, min(head(3:), int(huge(1), int64)))
      table%accuracy = accuracy_type(int(head(7)), int(head(3:6)), numbers(:4), numbers(5:))
      table%solutions = int(head(8:9))
      allocate (table%zones(head(2)))
      do i = 1, size(table%zones)
        associate (t => table%zones(i))
          call take_integers(4, head)
          if (stat /= 0 .or. any(head(2:4) < 5 .or. head(2:4) > 10000)) return
          t%flange = head(1) == 1
          call take_numbers(7, numbers)
          t%along = numbers(1:2)
          t%pole = numbers(3:4)
          t%origin = numbers(5:6)
          t%ceiling = numbers(7)
          call take_points(u, head(2))
          call take_points(roll, head(3))
          call take_points(q, head(4))
          if (stat /= 0) return
          t%u = new_axis(u)
          t%roll = new_axis(roll)
          t%q = new_axis(q)
          ! No more than the file has: what its damage promises may be more than memory has.
          if (8*product(head(2:4) + 2) > bytes) return
          allocate (t%h(head(3) + 2, head(2) + 2), t%s(head(4) + 2, head(3) + 2, head(2) + 2), stat=stat)
          if (stat /= 0) return
          call take_numbers(size(t%h), t%h)
          call take_numbers(size(t%s), t%s)
        end associate
      end do
      if (stat == 0) read (unit, iostat=stat) head(1)
      if (stat /= 0 .or. head(1) /= mix) return
      inquire (unit=unit, pos=head(1))
      found = head(1) == bytes + 1
      if (.not. found) return
      do i = 1, size(table%zones)
        call bound_heights(table%zones(i))
      end do
    end subroutine read_table

    subroutine take_integers(n, integers)
      integer, intent(in) :: n
      integer(int64), intent(out) :: integers(n)

      integers = 0
      if (stat == 0) read (unit, iostat=stat) integers
      if (stat == 0) call stir(mix, n, integers)
    end subroutine take_integers

    subroutine take_numbers(n, numbers)
      integer, intent(in) :: n
      real(dp), intent(out) :: numbers(n)

      if (stat == 0) read (unit, iostat=stat) numbers
      if (stat /= 0) numbers = 0
      if (stat == 0) call stir_numbers(mix, n, numbers)
    end subroutine take_numbers

    !> Points of an axis.
    subroutine take_points(x, n)
      real(dp), allocatable, intent(out) :: x(:)
      integer(int64), intent(in) :: n

      allocate (x(n))
      call take_numbers(int(n), x)
      if (stat == 0 .and. .not. rising(x)) stat = 1
    end subroutine take_points

  end subroutine load_table

  !> Whether numbers from a file, which may be anything, are the points of an axis.
  pure logical function rising(x)
    real(dp), intent(in) :: x(:)

    rising = all(x(2:) > x(:size(x) - 1)) .and. all(abs(x) < 1e3_dp)
  end function rising

  pure integer function words_for(letters)
    integer, intent(in) :: letters

    words_for = (letters + 7)/8
  end function words_for

  !> A text in words, the last one filled up with blanks.
  pure function words_of(text) result(words)
    character(*), intent(in) :: text
    integer(int64) :: words(words_for(len(text)))
    character(8*words_for(len(text))) :: filled

    filled = text
    words = transfer(filled, words)
  end function words_of

  !> Mix words into one, which changes with every one of them: between them a step of the generator xorshift64
  !> (G. Marsaglia, J. Stat. Softw. 8 (2003) 14), which loses nothing and comes round after 2^64 - 1 steps.
  pure subroutine stir(mix, n, words)
    integer(int64), intent(inout) :: mix
    integer, intent(in) :: n
    integer(int64), intent(in) :: words(n)
    integer :: i

    do i = 1, n
      call stir_word(mix, words(i))
    end do
  end subroutine stir

  pure subroutine stir_numbers(mix, n, numbers)
    integer(int64), intent(inout) :: mix
    integer, intent(in) :: n
    real(dp), intent(in) :: numbers(n)
    integer :: i

    do i = 1, n
      call stir_word(mix, transfer(numbers(i), mix))
    end do
  end subroutine stir_numbers

  pure subroutine stir_word(mix, word)
    integer(int64), intent(inout) :: mix
    integer(int64), intent(in) :: word

    mix = ieor(mix, word)
    mix = ieor(mix, shiftl(mix, 13))
    mix = ieor(mix, shiftr(mix, 7))
    mix = ieor(mix, shiftl(mix, 17))
  end subroutine stir_word

end module table_file