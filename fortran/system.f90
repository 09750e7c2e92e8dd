!> The little that is needed of the operating system.
module system
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_double, c_f_pointer, c_funptr, c_int, c_int16_t, c_int32_t, &
    c_intptr_t, c_loc, c_long, c_null_char, c_null_funptr, c_null_ptr, c_ptr, c_size_t
  use, intrinsic :: iso_fortran_env, only: int64
  !$ use omp_lib, only: omp_get_max_threads
  implicit none
  private
  public :: on_terminal, read_file, say, c_write, survive_long_files, scratch_file, same_file, lacks_folder, has_memory

  !> Of outputs that are given no name; no other folder is made.
  character(*), parameter, public :: default_folder = 'outputs'

  !> A file that is written under another name beside its own, `file.part`, the process and a time, and renamed over the old
  !> one, in one step, when it is complete. It is locked while it is written: what was left by a process that is dead,
  !> here or on another machine with the same folder, is known by that, and removed.
  type :: scratch_file
    private
    character(:), allocatable :: name     !! that it gets
    character(:), allocatable :: scratch  !! that it has until then
    type(c_ptr) :: stream = c_null_ptr
    type(c_ptr) :: lock = c_null_ptr      !! the file once more: its lock outlives the stream, until the file is renamed
    logical :: named = .false.            !! it is in its folder
    logical, public :: ok = .false.       !! all went well so far
  contains
    procedure :: begin
    procedure, private :: put_text, put_words
    generic :: put => put_text, put_words
    procedure :: append
    procedure :: finish
    procedure :: abandon
  end type scratch_file

  character(*), parameter :: part = '.part'
  integer(c_int), parameter :: lock_when_free = 2, lock_now = 2 + 4   ! LOCK_EX, LOCK_EX + LOCK_NB
  integer, parameter :: block = 2**20     ! copied at once [bytes]

  !> The beginning of C's glob_t, as glibc and musl have it, and room for the rest.
  type, bind(c) :: glob_type
    integer(c_size_t) :: n = 0
    type(c_ptr) :: paths = c_null_ptr
    type(c_ptr) :: rest(14) = c_null_ptr
  end type glob_type

  !> Linux's struct statx, the same on all processors.
  type, bind(c) :: statx_type
    integer(c_int32_t) :: before(7) = 0
    integer(c_int16_t) :: mode = 0
    integer(c_int16_t) :: rest(113) = 0
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
    integer(c_int) function c_getpid() bind(c, name='getpid')
      import :: c_int
    end function c_getpid
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
    integer(c_int) function c_fseek(file, offset, whence) bind(c, name='fseek')
      import :: c_int, c_long, c_ptr
      type(c_ptr), value :: file
      integer(c_long), value :: offset
      integer(c_int), value :: whence
    end function c_fseek
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
    integer(c_int) function c_getpgid(process) bind(c, name='getpgid')
      import :: c_int
      integer(c_int), value :: process
    end function c_getpgid
    integer(c_int) function c_glob(pattern, flags, on_error, found) bind(c, name='glob')
      import :: c_char, c_funptr, c_int, glob_type
      character(kind=c_char), intent(in) :: pattern(*)
      integer(c_int), value :: flags
      type(c_funptr), value :: on_error
      type(glob_type), intent(inout) :: found
    end function c_glob
    subroutine c_globfree(found) bind(c, name='globfree')
      import :: glob_type
      type(glob_type), intent(inout) :: found
    end subroutine c_globfree
    integer(c_size_t) function c_strlen(text) bind(c, name='strlen')
      import :: c_ptr, c_size_t
      type(c_ptr), value :: text
    end function c_strlen
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

  !> All of a file, or of standard input when `path` is '-'; at once, and, unlike Fortran's own
  !> reading, in several threads.  `opened` and `ok` tell what failed.
  subroutine read_file(path, bytes, opened, ok)
    character(*), intent(in) :: path
    character(:), allocatable, intent(out) :: bytes
    logical, intent(out) :: opened, ok
    type(c_ptr) :: file
    integer(c_size_t) :: got
    integer, parameter :: longest = 2**28  ! no file of ours is longer [bytes]
    character(:), allocatable :: grown
    integer :: n, stat, ignored

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
      got = c_fread(bytes(n + 1:), 1_c_size_t, int(len(bytes) - n, c_size_t), file)
      n = n + int(got)
      ok = c_ferror(file) == 0 .and. n < longest
      if (got == 0) exit
    end do
    bytes = bytes(:n)
    if (opened .and. path /= '-') ignored = c_fclose(file)
  end subroutine read_file

  !> Whether two paths lead to the same file, which need not be there yet.
  logical function same_file(a, b)
    character(*), intent(in) :: a, b

    same_file = resolved(a) == resolved(b)
  end function same_file

  !> The absolute path without links; of a file to come, its folder's.
  recursive function resolved(path) result(absolute)
    character(*), intent(in) :: path
    integer, parameter :: path_max = 4096
    character(path_max) :: absolute
    integer :: slash

    if (c_associated(c_realpath(path//c_null_char, absolute))) then
      absolute = absolute(:index(absolute, c_null_char) - 1)
      return
    end if
    slash = index(path, '/', back=.true.)
    absolute = path
    if (slash == 0 .and. path /= '.') absolute = trim(resolved('.'))//'/'//path
    if (slash > 1 .and. slash < len(path)) absolute = trim(resolved(path(:slash - 1)))//path(slash:)
  end function resolved

  !> Whether standard error goes to a terminal.
  logical function on_terminal()
    on_terminal = c_isatty(2_c_int) == 1
  end function on_terminal

  !> Whether a file is to lie in the default folder and that is not there.
  logical function lacks_folder(file)
    character(*), intent(in) :: file
    logical :: there

    inquire (file=default_folder, exist=there)
    lacks_folder = .not. there .and. index(file, default_folder//'/') == 1 .and. &
      index(file, '/', back=.true.) == len(default_folder) + 1
  end function lacks_folder

  !> Whether a path leads to a folder, a device, or what else is no file.
  logical function is_special(path)
    character(*), intent(in) :: path
    integer(c_int), parameter :: here = -100, want_type = 1     ! AT_FDCWD, STATX_TYPE
    integer, parameter :: kind_bits = int(o'170000'), regular = int(o'100000')
    type(statx_type) :: found

    is_special = c_statx(here, path//c_null_char, 0_c_int, want_type, found) == 0
    if (is_special) is_special = iand(int(found%mode), kind_bits) /= regular
  end function is_special

  !> Make the default folder, if that is what a file lacks; opening the file tells whether that went well.
  subroutine make_folder(file)
    character(*), intent(in) :: file
    integer(c_int), parameter :: all_may = int(o'777', c_int)   ! less what the process's umask forbids
    integer(c_int) :: ignored

    if (lacks_folder(file)) ignored = c_mkdir(default_folder//c_null_char, all_may)
  end subroutine make_folder

  !> Begin a file; the default folder is made for it. One that is `nameless` is for the process alone: it has space on
  !> the disk, but no entry in the folder, and goes with the process.
  subroutine begin(this, file, nameless)
    class(scratch_file), intent(inout) :: this
    character(*), intent(in) :: file
    logical, intent(in), optional :: nameless
    integer, parameter :: tries = 100
    character(40) :: mark
    integer(int64) :: now
    integer(c_int) :: ignored
    integer :: k

    this%named = .false.
    this%ok = .not. is_special(file)
    if (.not. this%ok) return
    call make_folder(file)
    this%name = trim(resolved(file))
    call remove_left(this%name)
    ! A file of a name that was never there: another thread may still be at what had it. Before it is locked, another one
    ! may take it for left and remove it.
    do k = 1, tries
      call system_clock(now)
      write (mark, '(i0,a,i0)') c_getpid(), '.', now
      this%scratch = this%name//part//trim(mark)
      this%stream = c_fopen(this%scratch//c_null_char, 'w+x'//c_null_char)
      if (.not. c_associated(this%stream)) cycle
      this%lock = c_fopen(this%scratch//c_null_char, 'r+'//c_null_char)
      if (c_associated(this%lock)) then
        ignored = c_flock(c_fileno(this%lock), lock_when_free)
        inquire (file=this%scratch, exist=this%named)
        if (this%named) exit
      end if
      ignored = c_remove(this%scratch//c_null_char)
      call close_streams(this)
    end do
    this%ok = this%named
    if (.not. present(nameless) .or. .not. this%ok) return
    if (nameless) this%named = c_remove(this%scratch//c_null_char) /= 0
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

  !> Add all that is in another one.
  subroutine append(this, other)
    class(scratch_file), intent(inout) :: this
    type(scratch_file), intent(inout) :: other
    character(:), allocatable :: bytes
    integer(c_size_t) :: got
    integer :: stat

    ! Rewinding writes what is in the buffer: here it comes out that the disk is full.
    this%ok = this%ok .and. other%ok
    if (this%ok) this%ok = c_fseek(other%stream, 0_c_long, 0_c_int) == 0
    if (.not. this%ok) return
    allocate (character(block) :: bytes, stat=stat)
    this%ok = stat == 0
    do while (this%ok)
      got = c_fread(bytes, 1_c_size_t, int(block, c_size_t), other%stream)
      if (got == 0) exit
      call this%put(bytes(:got))
    end do
    if (c_ferror(other%stream) /= 0) this%ok = .false.
  end subroutine append

  !> Give a file that is complete its name; where it could not be written to its end, it is removed.
  subroutine finish(this)
    class(scratch_file), intent(inout) :: this
    integer(c_int) :: ignored

    if (.not. c_associated(this%stream)) return
    if (c_fclose(this%stream) /= 0) this%ok = .false.
    this%stream = c_null_ptr
    if (this%ok) this%ok = c_rename(this%scratch//c_null_char, this%name//c_null_char) == 0
    if (.not. this%ok) ignored = c_remove(this%scratch//c_null_char)
    call close_streams(this)
  end subroutine finish

  !> Remove what has been written.
  subroutine abandon(this)
    class(scratch_file), intent(inout) :: this
    integer(c_int) :: ignored

    if (.not. c_associated(this%stream)) return
    if (this%named) ignored = c_remove(this%scratch//c_null_char)
    call close_streams(this)
  end subroutine abandon

  subroutine close_streams(this)
    class(scratch_file), intent(inout) :: this
    integer(c_int) :: ignored

    if (c_associated(this%stream)) ignored = c_fclose(this%stream)
    if (c_associated(this%lock)) ignored = c_fclose(this%lock)
    this%stream = c_null_ptr
    this%lock = c_null_ptr
  end subroutine close_streams

  !> Remove what dead processes have left of a file that they wrote.
  subroutine remove_left(file)
    character(*), intent(in) :: file
    type(glob_type) :: found
    type(c_ptr), pointer :: paths(:)
    character(kind=c_char), pointer :: letters(:)
    character(:), allocatable :: path, pattern
    integer :: i, k

    call escape(file, pattern)
    if (c_glob(pattern//part//'[0-9]*'//c_null_char, 0_c_int, c_null_funptr, found) == 0) then
      call c_f_pointer(found%paths, paths, [found%n])
      do i = 1, size(paths)
        call c_f_pointer(paths(i), letters, [c_strlen(paths(i))])
        allocate (character(size(letters)) :: path)
        do k = 1, size(letters)
          path(k:k) = letters(k)
        end do
        call remove_one_left(path)
        deallocate (path)
      end do
    end if
    call c_globfree(found)
  end subroutine remove_left

  !> Remove a file of this name if nobody writes it: its process is none of this machine's, or this one, and nobody has it
  !> locked. It goes before the lock does: a thread that has just made it waits for the lock and then sees that it is gone.
  subroutine remove_one_left(path)
    character(*), intent(in) :: path
    type(c_ptr) :: stream
    integer(c_int) :: process, own, ignored
    integer :: stat
    real(c_double) :: mark

    read (path(index(path, part, back=.true.) + len(part):), '(f40.0)', iostat=stat) mark
    if (stat /= 0 .or. mark >= huge(process)) return
    process = int(mark, c_int)
    own = c_getpid()
    if (c_getpgid(process) >= 0 .and. process /= own) return
    stream = c_fopen(path//c_null_char, 'r+'//c_null_char)
    if (.not. c_associated(stream)) return
    if (c_flock(c_fileno(stream), lock_now) == 0) ignored = c_remove(path//c_null_char)
    ignored = c_fclose(stream)
  end subroutine remove_one_left

  !> A path in which `glob` finds nothing to expand.
  pure subroutine escape(path, pattern)
    character(*), intent(in) :: path
    character(:), allocatable, intent(out) :: pattern
    character, parameter :: backslash = achar(92)
    integer :: i

    pattern = ''
    do i = 1, len(path)
      if (scan(path(i:i), '*?['//backslash) > 0) pattern = pattern//backslash
      pattern = pattern//path(i:i)
    end do
  end subroutine escape

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

  !> A file larger than the process may write is an error as others are, and no end by a signal.
  subroutine survive_long_files()
    integer(c_int), parameter :: sigxfsz = 25
    type(c_funptr) :: ignored

    ignored = c_signal(sigxfsz, transfer(1_c_intptr_t, c_null_funptr))   ! SIG_IGN
  end subroutine survive_long_files

  !> Whether there is memory for so many bytes and, beside them, for the stacks of OpenMP's threads. Where an ALLOCATE or
  !> libgomp finds none they end the process, which may be Python's, in words of their own: look for it before.
  logical function has_memory(bytes)
    integer(int64), intent(in) :: bytes
    integer(int64), parameter :: stack = 2_int64**23   ! of a thread, as systems have it [bytes]
    character(:), allocatable :: room
    integer :: threads, stat

    threads = 1
    !$ threads = omp_get_max_threads()
    allocate (character(bytes + stack*threads) :: room, stat=stat)
    has_memory = stat == 0
  end function has_memory

end module system
