"""The boundary to the Fortran core: calls, errors, files that are written whole, threads and processes."""
