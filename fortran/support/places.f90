!> Where files are looked for, and where a file goes that only saves time.
!>
!> A file that a case names is looked for as it is given, which is from the working folder; then beside the namelist, and in the
!> folder above it, because inputs/ may stand beside profiles/; then among the files that were installed with the program.
!> Results go to the working folder. Contact tables go to the user's cache where their own folder may not be written.
module places
  use errors, only: error_type, fatal_error
  use links_and_modes, only: follow_links, read_link
  use system, only: last_slash, make_folder, scratch_file
  implicit none
  private
  public :: places_type, find_file, find_share, kept_folder, folder_of

  !> Where a relative name is looked for after the working folder.
  type :: places_type
    character(:), allocatable :: folder    !! of the namelist; '' or not allocated: the namelist is no file
    character(:), allocatable :: share     !! that was installed with the program; '' or not allocated: none
  end type places_type

contains

  !> Find the path of a file that is called `name`. An error names the places where the file is not.
  subroutine find_file(places, name, path, error)
    type(places_type), intent(in) :: places
    character(*), intent(in) :: name           !! '-' for standard input
    character(:), allocatable, intent(out) :: path
    type(error_type), allocatable, intent(out) :: error
    character(:), allocatable :: looked, above
    logical :: there

    path = name
    inquire (file=name, exist=there)
    if (there .or. name == '-') return
    looked = ''
    if (name /= '' .and. .not. is_absolute(name)) then
      looked = '; looked for in the working folder'
      if (allocated(places%folder)) then
        call look_in(places%folder)
        call folder_above(places%folder, above)
        call look_in(above)
      end if
      if (allocated(places%share)) call look_in(places%share)
    end if
    if (there) return
    path = name
    call fatal_error(error, 'cannot be opened for reading'//looked, name)
    error%missing = .true.

  contains

    !> Look in a folder, unless the file was found, or was looked for there.
    subroutine look_in(folder)
      character(*), intent(in) :: folder

      if (there .or. folder == '' .or. folder == '.' .or. index(looked//',', ', in '//folder//',') > 0) return
      looked = looked//', in '//folder
      path = folder//'/'//name
      inquire (file=path, exist=there)
    end subroutine look_in

  end subroutine find_file

  !> Find the folder of inputs and profiles that belong to this program: PREFIX/share/ldbench of PREFIX/bin, where `make install`
  !> puts both; data beside the program's folder, as in a Python package; or the program's own folder. '' if there is none.
  subroutine find_share(share)
    character(:), allocatable, intent(out) :: share
    character(:), allocatable :: own, above
    logical :: there
    integer :: k

    call own_folder(own)
    call folder_above(own, above)
    do k = 1, 3
      if (k == 1) share = above//'/share/ldbench'
      if (k == 2) share = above//'/data'
      if (k == 3) share = own
      inquire (file=share//'/inputs/ex1_aw.nml', exist=there)
      if (there) return
    end do
    share = ''
  end subroutine find_share

  !> Find the folder of the running program, links resolved: Linux tells the program, elsewhere the command that started it does.
  subroutine own_folder(folder)
    character(:), allocatable, intent(out) :: folder
    character(:), allocatable :: path, file

    call read_link('/proc/self/exe', path)
    if (path == '') call find_command(path)
    call follow_links(path, file)
    call folder_of(file, folder)
  end subroutine own_folder

  !> Find the path of the program by the command that started it: the shell looks for a plain name in the folders of PATH, cmd of
  !> Windows first in the working folder.
  subroutine find_command(path)
    character(:), allocatable, intent(out) :: path
    character(:), allocatable :: name, folders
    character :: separator
    integer :: length, from, to
    logical :: there

    call get_command_argument(0, length=length)
    allocate (character(length) :: name)
    if (length > 0) call get_command_argument(0, name)
    path = name
    if (last_slash(name) > 0) return
    call get_variable('PATH', folders)
    separator = merge(';', ':', scan(folders, ';\') > 0)
    if (separator == ';') folders = '.;'//folders
    from = 1
    do while (from <= len(folders))
      to = from - 1 + index(folders(from:)//separator, separator)
      path = folders(from:to - 1)//'/'//name
      inquire (file=path, exist=there)
      if (.not. there) inquire (file=path//'.exe', exist=there)
      if (there) return
      from = to + 1
    end do
    path = name
  end subroutine find_command

  !> The folder that keeps contact tables: the one that the case names; where that may not be written, ldbench in the user's cache;
  !> '' where that may not be written, either.
  subroutine kept_folder(named, folder)
    character(*), intent(in) :: named          !! '' keeps nothing
    character(:), allocatable, intent(out) :: folder
    character(:), allocatable :: cache, parent

    folder = named
    if (named == '') return
    if (may_write(named)) return
    folder = ''
    call cache_folder(cache)
    if (cache == '') return
    call folder_of(cache, parent)
    call make_folder(parent)
    call make_folder(cache)
    if (may_write(cache)) folder = cache
  end subroutine kept_folder

  !> The folder of this program in the cache of the user; '' if the system does not tell the cache.
  subroutine cache_folder(cache)
    character(:), allocatable, intent(out) :: cache

    call get_variable('XDG_CACHE_HOME', cache)
    if (.not. is_absolute(cache)) call get_variable('LOCALAPPDATA', cache)     ! Windows
    if (.not. is_absolute(cache)) then
      call get_variable('HOME', cache)
      if (is_absolute(cache)) cache = cache//'/.cache'
    end if
    if (is_absolute(cache)) then
      cache = cache//'/ldbench'
    else
      cache = ''
    end if
  end subroutine cache_folder

  !> Whether files can be made in a folder; while the folder is missing, whether they can where it would be made.
  logical function may_write(folder)
    character(*), intent(in) :: folder
    character(:), allocatable :: place, above
    type(scratch_file) :: probe
    logical :: there

    place = folder
    do
      inquire (file=place//'/.', exist=there)
      if (there .or. place == '.' .or. place == '/') exit
      call folder_of(place, above)
      call move_alloc(above, place)
    end do
    call probe%begin(place//'/kept')
    may_write = probe%ok
    call probe%abandon()
  end function may_write

  !> The folder of a path.
  pure subroutine folder_of(path, folder)
    character(*), intent(in) :: path
    character(:), allocatable, intent(out) :: folder
    integer :: k

    k = last_slash(path)
    folder = path(:max(k - 1, 0))
    if (k == 0) folder = '.'
    if (k == 1) folder = '/'
  end subroutine folder_of

  !> The folder in which a folder lies.
  pure subroutine folder_above(folder, above)
    character(*), intent(in) :: folder
    character(:), allocatable, intent(out) :: above

    select case (folder(last_slash(folder) + 1:))
    case ('', '.', '..')
      above = folder//'/..'
      if (folder == '.') above = '..'
      if (folder == '') above = ''
    case default
      call folder_of(folder, above)
    end select
  end subroutine folder_above

  !> Whether a path does not start at the working folder. Windows has letters of drives.
  pure logical function is_absolute(path)
    character(*), intent(in) :: path

    is_absolute = scan(path, '/\') == 1 .or. index(path, ':') == 2
  end function is_absolute

  !> The value of a variable of the environment; '' where the variable is not set.
  subroutine get_variable(name, value)
    character(*), intent(in) :: name
    character(:), allocatable, intent(out) :: value
    integer :: length

    call get_environment_variable(name, length=length)
    allocate (character(length) :: value)
    if (length > 0) call get_environment_variable(name, value)
  end subroutine get_variable

end module places
