!> Working precision and the constants of nature that the program uses.
module kinds
  use, intrinsic :: iso_fortran_env, only: dp => real64
  implicit none
  private
  public :: dp, pi, gravity, degree, version

  real(dp), parameter :: pi = acos(-1.0_dp)
  real(dp), parameter :: degree = pi / 180        !! [rad]
  real(dp), parameter :: gravity = 9.81_dp        !! [m/s^2], the benchmark's value
  character(*), parameter :: version = '1.0.0'
end module kinds