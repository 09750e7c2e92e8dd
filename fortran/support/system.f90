!> Services of the system that Fortran does not have: files that are written whole or not at all, standard input and output as
!> bytes, terminals. They need ISO C and three functions of POSIX that Windows has too.
module system
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_funptr, c_int, c_intptr_t, c_loc, c_long, c_null_char, &
    c_null_funptr, c_null_ptr, c_ptr, c_size_t
  use kinds, only: dp
  use links_and_modes, only: copy_mode, follow_links
  implicit none
  private
  public :: on_terminal, read_file, write_output, survive_long_files, scratch_file, make_folder, lacks_folder, &
    last_slash, set_aside, c_exit

  !> The folder for output files that the case does not name.
  character(*), parameter, public :: default_folder = 'outputs'

  !> A file that is written under another name beside its own, `file.ldbench-part` and a random number, and renamed over
  !> the earlier one when it is complete. A process that is killed leaves its scratch file behind. The file lies where a symbolic
  !> link of its name leads to, and those who may read an earlier file may read this one.
  type :: scratch_file
    private
    character(:), allocatable, public :: name     !! path of the complete file, as it was given
    character(:), allocatable, public :: place    !! the path that links lead to
    character(:), allocatable, public :: ending   !! of the scratch file, whose path is place//ending; allocated while it exists
    type(c_ptr) :: stream = c_null_ptr
    logical, public :: ok = .false.               !! whether all went well so far
  contains
    procedure :: begin
    procedure :: put
    procedure :: complete
    procedure :: finish
    procedure :: abandon
  end type scratch_file

  interface
    type(c_ptr) function c_fopen(path, mode) bind(c, name='fopen')
      import :: c_char, c_ptr
      character(kind=c_char), intent(in) :: path(*), mode(*)
    end function c_fopen
    integer(c_size_t) function c_fread(buffer, size, n, file) bind(c, name='fread')
      import :: c_char, c_ptr, c_size_t
      character(kind=c_char), intent(inout) :: buffer(*)
      integer(c_size_t), value :: size, n
      type(c_ptr), value :: file
    end function c_fread
    integer(c_size_t) function c_fwrite(buffer, size, n, file) bind(c, name='fwrite')
      import :: c_ptr, c_size_t
      type(c_ptr), value :: buffer
      integer(c_size_t), value :: size, n
      type(c_ptr), value :: file
    end function c_fwrite
    integer(c_int) function c_fseek(file, offset, from) bind(c, name='fseek')
      import :: c_int, c_long, c_ptr
      type(c_ptr), value :: file
      integer(c_long), value :: offset
      integer(c_int), value :: from
    end function c_fseek
    integer(c_int) function c_ferror(file) bind(c, name='ferror')
      import :: c_int, c_ptr
      type(c_ptr), value :: file
    end function c_ferror
    integer(c_int) function c_fclose(file) bind(c, name='fclose')
      import :: c_int, c_ptr
      type(c_ptr), value :: file
    end function c_fclose
    integer(c_int) function c_rename(from, to) bind(c, name='rename')
      import :: c_char, c_int
      character(kind=c_char), intent(in) :: from(*), to(*)
    end function c_rename
    integer(c_int) function c_remove(path) bind(c, name='remove')
      import :: c_char, c_int
      character(kind=c_char), intent(in) :: path(*)
    end function c_remove
    type(c_funptr) function c_signal(number, handler) bind(c, name='signal')
      import :: c_funptr, c_int
      integer(c_int), value :: number
      type(c_funptr), value :: handler
    end function c_signal
    !> End the program. Fortran's STOP would write its status to standard error.
    subroutine c_exit(status) bind(c, name='exit')
      import :: c_int
      integer(c_int), value :: status
    end subroutine c_exit

    ! POSIX and the C library of Windows have these three functions, ISO C does not. The mkdir of Windows ignores `mode`.
    type(c_ptr) function c_fdopen(descriptor, mode) bind(c, name='fdopen')
      import :: c_char, c_int, c_ptr
      integer(c_int), value :: descriptor
      character(kind=c_char), intent(in) :: mode(*)
    end function c_fdopen
    integer(c_int) function c_isatty(descriptor) bind(c, name='isatty')
      import :: c_int
      integer(c_int), value :: descriptor
    end function c_isatty
    integer(c_int) function c_mkdir(path, mode) bind(c, name='mkdir')
      import :: c_char, c_int
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int), value :: mode
    end function c_mkdir
  end interface

contains

  !> Read a whole file at once, or standard input when `path` is '-', or the head of a file. Unlike Fortran's own reading, several
  !> threads may call this procedure at the same time. `opened` and `ok` tell what failed.
  subroutine read_file(path, bytes, opened, ok, enough)
    character(*), intent(in) :: path
    character(:), allocatable, intent(out) :: bytes
    logical, intent(out) :: opened, ok
    integer, intent(in), optional :: enough   !! bytes after which no more need be read
    type(c_ptr) :: file
    integer, parameter :: longest = 2**28  ! no file of ours is longer [bytes]
    character(:), allocatable :: grown
    integer :: n, got, stat, ignored

    if (path == '-') then
      file = c_fdopen(0_c_int, 'r'//c_null_char)
    else
      file = c_fopen(path//c_null_char, 'rb'//c_null_char)
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
      if (present(enough)) then
        if (n >= enough) exit
      end if
    end do
    bytes = bytes(:n)
    if (opened .and. path /= '-') ignored = c_fclose(file)
  end subroutine read_file

  !> Write a text to standard output and close it; `ok` tells whether all of the text got there.
  subroutine write_output(text, ok)
    character(*), intent(in) :: text
    logical, intent(out) :: ok
    type(scratch_file) :: out

    out%stream = c_fdopen(1_c_int, 'w'//c_null_char)
    out%ok = c_associated(out%stream)
    call out%put(text)
    call out%complete()
    ok = out%ok
  end subroutine write_output

  !> Whether standard error goes to a terminal.
  logical function on_terminal()
    on_terminal = c_isatty(2_c_int) /= 0
  end function on_terminal

  !> Make a file that exceeds the size limit of the process an ordinary error. Without this, POSIX ends the process.
  subroutine survive_long_files()
    integer(c_int), parameter :: sigxfsz = 25   ! on Linux, macOS and the BSDs; refused on Windows, which has no such limit
    type(c_funptr) :: ignored

    ignored = c_signal(sigxfsz, transfer(1_c_intptr_t, c_null_funptr))   ! SIG_IGN
  end subroutine survive_long_files

  !> Whether a file is to lie in the default folder and this folder does not exist.
  logical function lacks_folder(file)
    character(*), intent(in) :: file
    logical :: there

    inquire (file=default_folder, exist=there)
    lacks_folder = .not. there .and. index(file, default_folder) == 1 .and. last_slash(file) == len(default_folder) + 1
  end function lacks_folder

  !> Position of the last separator of folders in a path, 0 if there is none. Windows has two separators.
  pure integer function last_slash(path)
    character(*), intent(in) :: path

    last_slash = scan(path, '/\', back=.true.)
  end function last_slash

  !> Whether a path is free or leads to a file that may be replaced: not to a folder, a pipe, a device or a file without
  !> permission to write.
  logical function is_replaceable(path)
    character(*), intent(in) :: path
    character(*), parameter :: devices = '/dev/'
    type(c_ptr) :: file
    integer(c_int) :: ignored
    logical :: there

    inquire (file=path, exist=there)
    is_replaceable = .not. there
    if (is_replaceable .or. path(:last_slash(path)) == devices) return
    file = c_fopen(path//c_null_char, 'rb+'//c_null_char)    ! to read and write: a folder refuses, a pipe does not wait
    if (.not. c_associated(file)) return
    is_replaceable = c_fseek(file, 0_c_long, 0_c_int) == 0   ! a pipe has no positions
    ignored = c_fclose(file)
  end function is_replaceable

  !> Give a file the first free name NAME.1.ENDING, NAME.2.ENDING, ...
  subroutine set_aside(file, aside, ok)
    character(*), intent(in) :: file
    character(:), allocatable, intent(out) :: aside   !! its name from now on
    logical, intent(out) :: ok
    character(12) :: number
    integer :: dot, k
    logical :: taken

    dot = index(file, '.', back=.true.)
    if (dot <= last_slash(file) + 1) dot = len(file) + 1
    k = 0
    taken = .true.
    do while (taken)
      k = k + 1
      write (number, '(i0)') k
      aside = file(:dot - 1)//'.'//trim(number)//file(dot:)
      inquire (file=aside, exist=taken)
    end do
    ok = c_rename(file//c_null_char, aside//c_null_char) == 0
  end subroutine set_aside

  !> Make a folder if it is missing, and the default folder if it lies there. Files that are written to it show whether it is there.
  subroutine make_folder(folder)
    character(*), intent(in) :: folder
    integer(c_int), parameter :: for_all = int(o'777', c_int)   ! the process's umask takes permissions away
    integer(c_int) :: ignored

    if (lacks_folder(folder)) ignored = c_mkdir(default_folder//c_null_char, for_all)
    ignored = c_mkdir(folder//c_null_char, for_all)
  end subroutine make_folder

  !> Begin a file; the default folder is made for it.
  subroutine begin(this, file)
    class(scratch_file), intent(inout) :: this
    character(*), intent(in) :: file
    real(dp) :: draws(2)
    character(16) :: number

    this%name = file
    this%ok = is_replaceable(file)
    if (.not. this%ok) return
    if (lacks_folder(file)) call make_folder(default_folder)
    call follow_links(file, this%place)
    call random_seed()       ! the system's seed: other processes and threads draw other numbers
    call random_number(draws)
    write (number, '(2z8.8)') int(draws*huge(1))
    this%stream = c_fopen(this%place//'.ldbench-part'//number//c_null_char, 'wb'//c_null_char)
    this%ok = c_associated(this%stream)
    if (.not. this%ok) return
    this%ending = '.ldbench-part'//number
    call copy_mode(this%place, this%place//this%ending)
  end subroutine begin

  subroutine put(this, text)
    class(scratch_file), intent(inout) :: this
    character(*), target, intent(in) :: text

    if (this%ok .and. len(text) > 0) &
      this%ok = c_fwrite(c_loc(text), 1_c_size_t, len(text, c_size_t), this%stream) == len(text, c_size_t)
  end subroutine put

  !> Write the buffer and close the file, which shows whether the disk is full.
  subroutine complete(this)
    class(scratch_file), intent(inout) :: this
    integer(c_int) :: status

    if (.not. c_associated(this%stream)) return
    status = c_fclose(this%stream)
    this%stream = c_null_ptr
    this%ok = this%ok .and. status == 0
  end subroutine complete

  !> Give a complete file its name. A file that could not be written to its end is removed.
  subroutine finish(this)
    class(scratch_file), intent(inout) :: this

    call this%complete()
    if (this%ok) this%ok = renamed(this%place//this%ending//c_null_char, this%place//c_null_char)
    if (this%ok) deallocate (this%ending)
    call this%abandon()
  end subroutine finish

  !> Remove the scratch file, unless the file is finished.
  subroutine abandon(this)
    class(scratch_file), intent(inout) :: this
    integer(c_int) :: ignored

    call this%complete()
    if (.not. allocated(this%ending)) return
    ignored = c_remove(this%place//this%ending//c_null_char)
    deallocate (this%ending)
  end subroutine abandon

  !> Give a file the name of another one, which it replaces. Windows does not replace a file in one step: the earlier one
  !> has another name until the new one has its own.
  logical function renamed(new, earlier)
    character(*), intent(in) :: new, earlier     !! paths that c_null_char ends
    character(len(new) + 1) :: aside
    integer(c_int) :: ignored

    renamed = c_rename(new, earlier) == 0
    if (renamed) return
    aside = new(:len(new) - 1)//'0'//c_null_char
    if (c_rename(earlier, aside) /= 0) return
    renamed = c_rename(new, earlier) == 0
    if (renamed) then
      ignored = c_remove(aside)
    else
      ignored = c_rename(aside, earlier)
    end if
  end function renamed

end module system
