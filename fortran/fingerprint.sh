#!/bin/sh
# Writes the module `fingerprint`: a checksum of the sources that a contact table depends on, whatever the folder they are in.
cd "$(dirname "$0")" || exit 1
for module in kinds curve formats parts mending profile hertz geometry halfspace patches contact bspline potential reach \
              samples refine ratios table accuracy table_file bracket rigid; do
  cksum < $module.f90 || exit 1
done | sort | cksum | {
  read -r sum bytes
  echo "!> What a contact table is made by."
  echo "module fingerprint"
  echo "  implicit none"
  echo "  private"
  echo "  character(*), parameter, public :: law = '$sum'   !! checksum of the sources that a table depends on"
  echo "end module fingerprint"
}
