!> Services of the operating system that Fortran does not offer: files, locks, terminals.
module system
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_funptr, c_int, c_int16_t, c_int32_t, c_int64_t, &
    c_intptr_t, c_loc, c_null_char, c_null_funptr, c_null_ptr, c_ptr, c_size_t
  use, intrinsic :: iso_fortran_env, only: int64
  implicit none
  private
  public :: on_terminal, read_file, say, c_write, survive_long_files, scratch_file, same_file, lacks_folder

  !> The folder for output files that the case does not name. The program makes no other folder.
  character(*), parameter, public :: default_folder = 'outputs'

  !> A file that is written under another name beside its own, `file.ldbench-part` and a number, and renamed over the old
  !> one, in one step, when it is complete. Each of several writers takes a number of its own and locks its file while it
  !> writes. A file of such a name without a lock was left by a process that is dead, here or on another machine with the
  !> same folder, and is removed.
  type :: scratch_file
    private
    character(:), allocatable :: name     !! path of the complete file
    character(:), allocatable :: scratch  !! path until then
    type(c_ptr) :: stream = c_null_ptr
    integer(c_int) :: mode = 0            !! permissions of the file that it replaces, negative where there is none
    logical :: named = .false.            !! whether the scratch file is in its folder
    logical, public :: ok = .false.       !! whether all went well so far
  contains
    procedure :: begin
    procedure, private :: put_text, put_words
    generic :: put => put_text, put_words
    procedure :: complete
    procedure :: finish
    procedure :: abandon
  end type scratch_file

  character(*), parameter :: part = '.ldbench-part'
  integer, parameter :: writers = 100     ! writers of one file at the same time, at most: numbers have two digits
  integer(c_int), parameter :: lock = 2, lock_now = lock + 4   ! LOCK_EX, LOCK_EX + LOCK_NB

  !> Linux's struct statx, the same on all processors.
  type, bind(c) :: statx_type
    integer(c_int32_t) :: before(4) = 0
    integer(c_int32_t) :: links = 0         !! names of the file
    integer(c_int32_t) :: owner(2) = 0
    integer(c_int16_t) :: mode = 0
    integer(c_int16_t) :: gap = 0
    integer(c_int64_t) :: inode = 0
    integer(c_int64_t) :: between(12) = 0
    integer(c_int32_t) :: device(2) = 0
    integer(c_int64_t) :: rest(14) = 0
  end type statx_type

  interface
    integer(c_int) function c_isatty(descriptor) bind(c, name='isatty')
      import :: c_int
      integer(c_int), value :: descriptor
    end function c_isatty
    integer(c_int) function c_statx(folder, path, flags, mask, found) bind(c, name='statx')
      import :: c_char, c_int, statx_type
      integer(c_int), value :: folder, flags, mask
      character(kind=c_char), intent(in) :: path(*)
      type(statx_type), intent(inout) :: found
    end function c_statx
    integer(c_int) function c_rename(from, to) bind(c, name='rename')
      import :: c_char, c_int
      character(kind=c_char), intent(in) :: from(*), to(*)
    end function c_rename
    integer(c_int) function c_mkdir(path, mode) bind(c, name='mkdir')
      import :: c_char, c_int
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int), value :: mode
    end function c_mkdir
    type(c_ptr) function c_realpath(path, resolved) bind(c, name='realpath')
      import :: c_char, c_ptr
      character(kind=c_char), intent(in) :: path(*)
      character(kind=c_char), intent(out) :: resolved(*)
    end function c_realpath
    type(c_ptr) function c_fopen(path, mode) bind(c, name='fopen')
      import :: c_char, c_ptr
      character(kind=c_char), intent(in) :: path(*), mode(*)
    end function c_fopen
    type(c_ptr) function c_fdopen(descriptor, mode) bind(c, name='fdopen')
      import :: c_char, c_int, c_ptr
      integer(c_int), value :: descriptor
      character(kind=c_char), intent(in) :: mode(*)
    end function c_fdopen
    integer(c_size_t) function c_fread(buffer, size, n, file) bind(c, name='fread')
      import :: c_char, c_ptr, c_size_t
      character(kind=c_char), intent(inout) :: buffer(*)
      integer(c_size_t), value :: size, n
      type(c_ptr), value :: file
    end function c_fread
    integer(c_int) function c_ferror(file) bind(c, name='ferror')
      import :: c_int, c_ptr
      type(c_ptr), value :: file
    end function c_ferror
    integer(c_int) function c_fflush(file) bind(c, name='fflush')
      import :: c_int, c_ptr
      type(c_ptr), value :: file
    end function c_fflush
    integer(c_int) function c_dup(descriptor) bind(c, name='dup')
      import :: c_int
      integer(c_int), value :: descriptor
    end function c_dup
    integer(c_int) function c_close(descriptor) bind(c, name='close')
      import :: c_int
      integer(c_int), value :: descriptor
    end function c_close
    integer(c_int) function c_fchmod(descriptor, mode) bind(c, name='fchmod')
      import :: c_int
      integer(c_int), value :: descriptor, mode
    end function c_fchmod
    integer(c_int) function c_fclose(file) bind(c, name='fclose')
      import :: c_int, c_ptr
      type(c_ptr), value :: file
    end function c_fclose
    integer(c_size_t) function c_fwrite(buffer, size, n, file) bind(c, name='fwrite')
      import :: c_ptr, c_size_t
      type(c_ptr), value :: buffer
      integer(c_size_t), value :: size, n
      type(c_ptr), value :: file
    end function c_fwrite
    integer(c_int) function c_fileno(file) bind(c, name='fileno')
      import :: c_int, c_ptr
      type(c_ptr), value :: file
    end function c_fileno
    integer(c_int) function c_remove(path) bind(c, name='remove')
      import :: c_char, c_int
      character(kind=c_char), intent(in) :: path(*)
    end function c_remove
    integer(c_int) function c_flock(descriptor, operation) bind(c, name='flock')
      import :: c_int
      integer(c_int), value :: descriptor, operation
    end function c_flock
    integer(c_size_t) function c_write(descriptor, buffer, n) bind(c, name='write')
      import :: c_char, c_int, c_size_t
      integer(c_int), value :: descriptor
      character(kind=c_char), intent(in) :: buffer(*)
      integer(c_size_t), value :: n
    end function c_write
    type(c_funptr) function c_signal(number, handler) bind(c, name='signal')
      import :: c_funptr, c_int
      integer(c_int), value :: number
      type(c_funptr), value :: handler
    end function c_signal
  end interface

contains

  !> Read a whole file at once, or standard input when `path` is '-'. Unlike Fortran's own reading, several threads may call
  !> this procedure at the same time. `opened` and `ok` tell what failed.
  subroutine read_file(path, bytes, opened, ok)
    character(*), intent(in) :: path
    character(:), allocatable, intent(out) :: bytes
    logical, intent(out) :: opened, ok
    type(c_ptr) :: file
    integer, parameter :: longest = 2**28  ! no file of ours is longer [bytes]
    character(:), allocatable :: grown
    integer :: n, got, stat, ignored

    if (path == '-') then
      file = c_fdopen(0_c_int, 'r'//c_null_char)
    else
      file = c_fopen(path//c_null_char, 'r'//c_null_char)
    end if
    opened = c_associated(file)
    ok = opened
    allocate (character(2**16) :: bytes)
    n = 0
    do while (ok)
      if (n == len(bytes)) then
        allocate (character(2*n) :: grown, stat=stat)
        ok = stat == 0
        if (.not. ok) exit
        grown(:n) = bytes
        call move_alloc(grown, bytes)
      end if
      got = int(c_fread(bytes(n + 1:), 1_c_size_t, int(len(bytes) - n, c_size_t), file))
      n = n + got
      ok = c_ferror(file) == 0 .and. n < longest
      if (got == 0) exit
    end do
    bytes = bytes(:n)
    if (opened .and. path /= '-') ignored = c_fclose(file)
  end subroutine read_file

  !> Whether two paths lead to the same file, which need not be there yet. `b` may be '-', standard input.
  logical function same_file(a, b)
    character(*), intent(in) :: a, b
    type(statx_type) :: x, y

    call look(a, x)
    if (b == '-') then
      call look('', y, descriptor=0_c_int)
    else
      call look(b, y)
    end if
    same_file = are_one(x, y)
    if (.not. same_file .and. b /= '-') same_file = resolved(a) == resolved(b)
  end function same_file

  pure logical function are_one(x, y)
    type(statx_type), intent(in) :: x, y

    are_one = min(x%links, y%links) > 0 .and. x%inode == y%inode .and. all(x%device == y%device)
  end function are_one

  !> Ask the system about a file, by path or by the descriptor of an open file. `links` is -1 if the system knows nothing.
  subroutine look(path, found, descriptor)
    character(*), intent(in) :: path
    type(statx_type), intent(out) :: found
    integer(c_int), intent(in), optional :: descriptor
    integer(c_int), parameter :: here = -100, open_one = 4096, basic = 2047   ! AT_FDCWD, AT_EMPTY_PATH, STATX_BASIC_STATS

    if (present(descriptor)) then
      if (c_statx(descriptor, c_null_char, open_one, basic, found) /= 0) found%links = -1
    else if (c_statx(here, path//c_null_char, 0_c_int, basic, found) /= 0) then
      found%links = -1
    end if
  end subroutine look

  !> The absolute path without links. For a file that does not exist yet, links of its folder alone are resolved.
  function resolved(path) result(absolute)
    character(*), intent(in) :: path
    integer, parameter :: path_max = 4096
    character(len(path) + path_max) :: absolute
    character(path_max) :: buffer
    integer :: n, length

    absolute = path//'/'
    if (index(path, '/') /= 1) absolute = './'//absolute
    length = len_trim(absolute)
    do n = length, 2, -1                ! the longest beginning that is there
      if (absolute(n:n) /= '/') cycle
      if (.not. c_associated(c_realpath(absolute(:n - 1)//c_null_char, buffer))) cycle
      absolute = buffer(:index(buffer, c_null_char) - 1)//absolute(n:length)
      exit
    end do
    absolute(len_trim(absolute):) = ''
  end function resolved

  !> Whether standard error goes to a terminal.
  logical function on_terminal()
    on_terminal = c_isatty(2_c_int) == 1
  end function on_terminal

  !> Whether a file is to lie in the default folder and this folder does not exist.
  logical function lacks_folder(file)
    character(*), intent(in) :: file
    logical :: there

    inquire (file=default_folder, exist=there)
    lacks_folder = .not. there .and. index(file, default_folder//'/') == 1 .and. &
      index(file, '/', back=.true.) == len(default_folder) + 1
  end function lacks_folder

  !> Begin a file; the default folder is made for it. A folder or a device is not written over.
  subroutine begin(this, file)
    class(scratch_file), intent(inout) :: this
    character(*), intent(in) :: file
    integer, parameter :: kind_bits = int(o'170000'), regular = int(o'100000'), permissions = int(o'777')
    integer(c_int), parameter :: of_writer = int(o'600', c_int)
    integer(c_int), parameter :: all_may = int(o'777', c_int)   ! less what the process's umask forbids
    type(statx_type) :: old, new
    type(c_ptr) :: stream
    character(:), allocatable :: path
    character(2) :: number
    integer(c_int) :: ignored
    integer :: k

    this%stream = c_null_ptr
    call look(file, old)
    this%ok = old%links < 0 .or. iand(int(old%mode), kind_bits) == regular
    if (.not. this%ok) return
    this%mode = -1
    if (old%links > 0) this%mode = iand(int(old%mode), permissions)
    if (lacks_folder(file)) ignored = c_mkdir(default_folder//c_null_char, all_may)
    this%name = trim(resolved(file))
    do k = 0, writers - 1
      write (number, '(i2.2)') k
      path = this%name//part//number
      call remove_left(path)
      if (c_associated(this%stream)) cycle
      ! The scratch file is new, so no other thread may have opened it.
      stream = c_fopen(path//c_null_char, 'w+x'//c_null_char)
      if (.not. c_associated(stream)) cycle
      ignored = c_flock(c_fileno(stream), lock)
      call look('', new, c_fileno(stream))
      if (new%links /= 0) then
        this%stream = stream
        this%scratch = path
      else
        ignored = c_fclose(stream)      ! another writer found it before it was locked, and removed it
      end if
    end do
    this%ok = c_associated(this%stream)
    this%named = this%ok
    if (this%ok .and. this%mode >= 0) ignored = c_fchmod(c_fileno(this%stream), ior(this%mode, of_writer))
  end subroutine begin

  subroutine put_text(this, text)
    class(scratch_file), intent(inout) :: this
    character(*), target, intent(in) :: text

    if (this%ok .and. len(text) > 0) &
      this%ok = c_fwrite(c_loc(text), 1_c_size_t, len(text, c_size_t), this%stream) == len(text, c_size_t)
  end subroutine put_text

  subroutine put_words(this, words)
    class(scratch_file), intent(inout) :: this
    integer(int64), contiguous, target, intent(in) :: words(:)

    if (this%ok) this%ok = c_fwrite(c_loc(words), 8_c_size_t, size(words, kind=c_size_t), this%stream) == size(words)
  end subroutine put_words

  !> Write the buffer to the disk, which shows whether the disk is full. A network file system reports that when a
  !> descriptor is closed. A duplicate is closed, because closing the file's own descriptor would end the lock.
  subroutine complete(this)
    class(scratch_file), intent(inout) :: this

    if (this%ok) this%ok = c_fflush(this%stream) == 0
    if (this%ok) this%ok = c_close(c_dup(c_fileno(this%stream))) == 0
  end subroutine complete

  !> Give a complete file its name. A file that could not be written to its end is removed.
  subroutine finish(this)
    class(scratch_file), intent(inout) :: this
    integer(c_int) :: ignored

    call this%complete()
    if (this%ok .and. this%mode >= 0) ignored = c_fchmod(c_fileno(this%stream), this%mode)
    if (this%ok) this%ok = c_rename(this%scratch//c_null_char, this%name//c_null_char) == 0
    if (this%ok) this%named = .false.
    call this%abandon()
  end subroutine finish

  !> Remove the scratch file, unless the file is finished.
  subroutine abandon(this)
    class(scratch_file), intent(inout) :: this
    integer(c_int) :: ignored

    if (.not. c_associated(this%stream)) return
    if (this%named) ignored = c_remove(this%scratch//c_null_char)
    ignored = c_fclose(this%stream)     ! not before: its lock goes with it
    this%stream = c_null_ptr
  end subroutine abandon

  !> Remove a scratch file that nobody has locked.
  subroutine remove_left(path)
    character(*), intent(in) :: path
    type(statx_type) :: opened, named
    type(c_ptr) :: stream
    integer(c_int) :: ignored

    call look(path, named)
    if (named%links < 0) return
    stream = c_fopen(path//c_null_char, 'r+'//c_null_char)
    if (.not. c_associated(stream)) return
    if (c_flock(c_fileno(stream), lock_now) == 0) then
      ! The writer may just have finished this file, and the name may lead to another writer's file.
      call look('', opened, c_fileno(stream))
      call look(path, named)
      if (are_one(opened, named)) ignored = c_remove(path//c_null_char)
    end if
    ignored = c_fclose(stream)
  end subroutine remove_left

  !> Write a text to standard output; `ok` tells whether all of it got there.
  subroutine say(text, ok)
    character(*), intent(in) :: text
    logical, intent(out) :: ok
    integer(c_size_t) :: from, got

    from = 1
    do while (from <= len(text))
      got = c_write(1_c_int, text(from:), len(text, c_size_t) - from + 1)
      if (got <= 0) exit
      from = from + got
    end do
    ok = from > len(text)
  end subroutine say

  !> Make a file that exceeds the size limit of the process an ordinary error. Without this the system ends the process.
  subroutine survive_long_files()
    integer(c_int), parameter :: sigxfsz = 25
    type(c_funptr) :: ignored

    ignored = c_signal(sigxfsz, transfer(1_c_intptr_t, c_null_funptr))   ! SIG_IGN
  end subroutine survive_long_files

end module system