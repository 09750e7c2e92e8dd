#!/bin/sh
# Writes the module `fingerprint`: a checksum of the statements that a contact table depends on, without comments and blank lines.
cd "$(dirname "$0")" || exit 1
export LC_ALL=C     # some shells list files in the order of the locale, which would change the checksum
cat support/kinds.f90 support/linear_solver.f90 support/root_bracket.f90 profile/*.f90 contact/*.f90 table/*.f90 program/run_setup.f90 program/run_tables.f90 |
  sed -e 's/^ *!.*//' -e 's/  *! .*//' -e 's/  *!! .*//' -e 's/  *$//' -e '/^$/d' | cksum | {
  read -r sum bytes
  echo "!> What a contact table is made by."
  echo "module fingerprint"
  echo "  implicit none"
  echo "  private"
  echo "  character(*), parameter, public :: table_sources = '$sum'   !! checksum of the sources that a table depends on"
  echo "end module fingerprint"
}
