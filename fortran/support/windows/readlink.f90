!> Stands in on Windows for the function of POSIX: no path is a symbolic link.
integer(c_intptr_t) function readlink(path, target, most) bind(c, name='readlink')
  use, intrinsic :: iso_c_binding, only: c_char, c_intptr_t, c_null_char, c_size_t
  implicit none
  character(kind=c_char), intent(in) :: path(*)
  character(kind=c_char), intent(inout) :: target(*)
  integer(c_size_t), value :: most

  if (most > 0 .and. path(1) /= c_null_char) target(1) = c_null_char
  readlink = -1
end function readlink
