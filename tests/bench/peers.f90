!> The motion of a case by integrators of SUNDIALS, on the compiled force.
!>
!> usage: peers input.nml
!> Does the namelists &job of standard input one after the other, the answer to each a line: Y at the end (NaN if it was not
!> reached), processor time of the integration alone [s], evaluations of the force.
!>
!> The Fortran modules are those of SUNDIALS 6.4, which Debian 12 has; SPRKStep, its symplectic methods, came with 6.6.
module by_sundials
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use, intrinsic :: iso_c_binding
  use farkode_erkstep_mod
  use farkode_mod
  use fcvode_mod
  use fnvector_serial_mod
  use fsundials_context_mod
  use fsundials_nonlinearsolver_mod
  use fsundials_nvector_mod
  use fsunnonlinsol_fixedpoint_mod
  use kinds, only: dp
  use zone_tables, only: inside
  use run_setup, only: setup_type
  use elastic_contacts, only: contacts
  use motion_state, only: contact_state
  use wheelset, only: external_force
  implicit none
  private
  public :: problem_type, solve

  !> x = (y, z, roll) from equilibrium and their rates.
  type :: problem_type
    type(setup_type), pointer :: setup => null()
    logical :: explicit = .false.      !! by ARKODE; else by CVODE
    integer :: evaluations = 0
  end type problem_type

contains

  !> Solve from x on by `method`: 'adams' of CVODE with fixed-point iteration, or 'erk 4' to 'erk 8' of ARKODE.
  subroutine solve(problem, method, tolerance, t_end, x, seconds)
    type(problem_type), intent(inout), target :: problem
    character(*), intent(in) :: method
    real(dp), intent(in) :: tolerance      !! relative to 1 cm, 10 mrad, 1 m/s, 1 rad/s, and to x
    real(dp), intent(in) :: t_end          !! [s]
    real(dp), intent(inout), target :: x(6)     !! at the start, then at the end; NaN if it was not reached
    real(dp), intent(out) :: seconds       !! processor time of the integration alone
    integer(c_long), parameter :: many = 100000000
    integer(c_int64_t), parameter :: n = 6
    real(dp), target :: scale(6)           ! absolute tolerances
    real(dp) :: reached(1), from, to
    type(c_ptr) :: context, memory
    type(N_Vector), pointer :: state, scales
    type(SUNNonlinearSolver), pointer :: fixed_point
    integer(c_int) :: status(8), ended
    integer :: table

    status = 0
    fixed_point => null()
    scale = tolerance*[1e-2_dp, 1e-2_dp, 1e-2_dp, 1.0_dp, 1.0_dp, 1.0_dp]
    if (FSUNContext_Create(c_null_ptr, context) /= 0) error stop 'SUNDIALS: no context'
    state => FN_VMake_Serial(n, x, context)
    ! One call for what would be several operations: up to a twentieth less.
    status(1) = FN_VEnableFusedOps_Serial(state, 1)
    scales => FN_VMake_Serial(n, scale, context)
    problem%explicit = method(:3) == 'erk'
    if (problem%explicit) then
      select case (method)
      case ('erk 4')
        table = ARKODE_ZONNEVELD_5_3_4
      case ('erk 5')
        table = ARKODE_DORMAND_PRINCE_7_4_5
      case ('erk 6')
        table = ARKODE_VERNER_8_5_6
      case default
        table = ARKODE_FEHLBERG_13_7_8
      end select
      memory = FERKStepCreate(c_funloc(rates), 0.0_dp, state, context)
      status(2) = FERKStepSetErrFile(memory, c_null_ptr)
      status(3) = FERKStepSVtolerances(memory, tolerance, scales)
      status(4) = FERKStepSetTableNum(memory, table)
      status(5) = FERKStepSetMaxNumSteps(memory, many)
      status(6) = FERKStepSetUserData(memory, c_loc(problem))
      status(7) = FERKStepSetStopTime(memory, t_end)
      status(8) = FERKStepSetMaxErrTestFails(memory, 50)      ! in flight a first trial may go far
    else
      memory = FCVodeCreate(CV_ADAMS, context)
      status(2) = FCVodeInit(memory, c_funloc(rates), 0.0_dp, state)
      status(3) = FCVodeSVtolerances(memory, tolerance, scales)
      status(4) = FCVodeSetErrFile(memory, c_null_ptr)
      status(5) = FCVodeSetMaxNumSteps(memory, many)
      status(6) = FCVodeSetUserData(memory, c_loc(problem))
      status(7) = FCVodeSetStopTime(memory, t_end)
      fixed_point => FSUNNonlinSol_FixedPoint(state, 0_c_int, context)
      status(8) = FCVodeSetNonlinearSolver(memory, fixed_point)
    end if
    if (any(status /= 0)) error stop 'SUNDIALS: an integrator cannot be set up'
    call cpu_time(from)
    if (problem%explicit) then
      ended = FERKStepEvolve(memory, t_end, state, reached, ARK_NORMAL)
    else
      ended = FCVode(memory, t_end, state, reached, CV_NORMAL)
    end if
    call cpu_time(to)
    seconds = to - from
    if (ended /= CV_SUCCESS .and. ended /= CV_TSTOP_RETURN) x = ieee_value(x, ieee_quiet_nan)
    if (problem%explicit) then
      call FERKStepFree(memory)
    else
      call FCVodeFree(memory)
      status(1) = FSUNNonlinSolFree(fixed_point)
    end if
    call FN_VDestroy(state)
    call FN_VDestroy(scales)
    status(1) = FSUNContext_Free(context)
  end subroutine solve

  !> The numbers of a vector: FN_VGetArrayPointer gives the first one.
  function numbers(vector) result(x)
    type(N_Vector), intent(inout), target :: vector
    real(dp), pointer :: x(:), first(:)

    first => FN_VGetArrayPointer(vector)
    call c_f_pointer(c_loc(first), x, [6])
  end function numbers

  !> dx/dt. A pose outside the table makes the step shorter: CVODE's when it is told, ARKODE's, which would give up, when
  !> the rates are far off.
  integer(c_int) function rates(t, x, dx, user) result(status) bind(c)
    real(c_double), value :: t
    type(N_Vector) :: x, dx
    type(c_ptr), value :: user
    type(problem_type), pointer :: problem
    type(contact_state) :: state
    real(dp), parameter :: far_off = 1e15_dp
    real(dp), pointer :: from(:), to(:)

    call c_f_pointer(user, problem)
    from => numbers(x)
    to => numbers(dx)
    associate (w => problem%setup%wheelset)
      call contacts(w, problem%setup%equilibrium + from(1:3), state, with_hessian=.false.)
      to(1:3) = from(4:6)
      to(4:6) = (external_force(w, t) - state%gradient)/w%inertia()
    end associate
    problem%evaluations = problem%evaluations + 1
    status = 0
    if (state%status == inside) return
    to = far_off
    if (.not. problem%explicit) status = 1
  end function rates

end module by_sundials
program peers
  use, intrinsic :: iso_fortran_env, only: iostat_end
  use by_sundials, only: problem_type, solve
  use case, only: case_type
  use kinds, only: dp
  use run_setup, only: setup_type
  use shared, only: read_prepared
  implicit none
  save
  character(16) :: method
  real(dp) :: tolerance
  real(dp) :: t_end                    ! [s]
  namelist /job/ method, tolerance, t_end
  type(case_type) :: c
  type(setup_type), target :: setup
  type(problem_type) :: problem
  real(dp) :: x(6), seconds
  integer :: stat

  call read_prepared(c, setup)
  do
    read (*, nml=job, iostat=stat)
    if (stat == iostat_end) exit
    if (stat /= 0) error stop 'expected a namelist &job'
    problem = problem_type(setup)
    x = [c%y, c%z, c%roll, c%vy, c%vz, c%roll_rate]
    call solve(problem, trim(method), tolerance, t_end, x, seconds)
    write (*, '(2es24.16, 1x, i0)') x(1), seconds, problem%evaluations
    flush (6)
  end do
end program peers
