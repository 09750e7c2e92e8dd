!> The little that is needed of the operating system.
module system
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_int, c_null_char, c_ptr, c_size_t
  use, intrinsic :: iso_fortran_env, only: int64
  implicit none
  private
  public :: on_terminal, read_file, finish_file, scratch_name, same_file, lacks_folder, make_folder

  !> Of outputs that are given no name; no other folder is made.
  character(*), parameter, public :: default_folder = 'outputs'

  interface
    integer(c_int) function c_isatty(descriptor) bind(c, name='isatty')
      import :: c_int
      integer(c_int), value :: descriptor
    end function c_isatty
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
    integer :: n, ignored

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
      if (n == len(bytes)) bytes = bytes//repeat(' ', n)
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
    character(:), allocatable :: absolute
    integer, parameter :: path_max = 4096
    character(path_max) :: buffer
    integer :: slash

    if (c_associated(c_realpath(path//c_null_char, buffer))) then
      absolute = buffer(:index(buffer, c_null_char) - 1)
      return
    end if
    slash = index(path, '/', back=.true.)
    absolute = path
    if (slash == 0 .and. path /= '.') absolute = resolved('.')//'/'//path
    if (slash > 1 .and. slash < len(path)) absolute = resolved(path(:slash - 1))//path(slash:)
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

  !> Make the default folder, if that is what a file lacks; opening the file tells whether that went well.
  subroutine make_folder(file)
    character(*), intent(in) :: file
    integer(c_int), parameter :: all_may = int(o'777', c_int)   ! less what the process's umask forbids
    integer(c_int) :: ignored

    if (lacks_folder(file)) ignored = c_mkdir(default_folder//c_null_char, all_may)
  end subroutine make_folder

  !> A name beside `file` for writing it before it is complete.
  function scratch_name(file) result(name)
    character(*), intent(in) :: file
    character(:), allocatable :: name
    character(12) :: process

    write (process, '(i0)') c_getpid()
    name = file//'.part'//trim(process)
  end function scratch_name

  !> Close a file that was written under the name `scratch` and rename it over the old one, in one
  !> step; where it could not be written to its end, or renamed, it is removed.
  subroutine finish_file(unit, scratch, file, stat)
    integer, intent(in) :: unit
    character(*), intent(in) :: scratch, file
    integer, intent(inout) :: stat         !! of the writing so far; not 0 if it failed
    integer(int64) :: written, stored
    integer :: again, ignored

    ! Neither writing nor closing tells that the disk is full: libgfortran buffers.
    inquire (unit=unit, size=written)
    close (unit, iostat=ignored)
    inquire (file=scratch, size=stored)
    if (stored < written) stat = -1
    if (stat == 0) stat = int(c_rename(scratch//c_null_char, file//c_null_char))
    if (stat == 0) return
    open (newunit=again, file=scratch, iostat=ignored)
    if (ignored == 0) close (again, status='delete', iostat=ignored)
  end subroutine finish_file

end module system
