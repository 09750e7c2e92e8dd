!> The motion of a case by integrators of SUNDIALS, on the compiled force.
!>
!> usage: peers input.nml
!> Does the namelists &job of standard input one after the other, the answer to each a line: Y at the end (NaN if it was not
!> reached), processor time of the integration alone [s], evaluations of the force.
!>
!> The Fortran modules are those of SUNDIALS 6.4, which Debian 12 has; SPRKStep, its symplectic methods, came with 6.6.
module by_sundials
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
  use wheelset, only: contact_state, contacts, external_force
  implicit none
  private
  public :: problem_type, peer_type, new_peer, evolve, free_peer

  !> x = (y, z, roll) from equilibrium and their rates.
  type :: problem_type
    type(setup_type), pointer :: setup => null()
    logical :: explicit = .false.      !! by ARKODE; else by CVODE
    integer :: evaluations = 0
  end type problem_type

  !> An integrator that was started.
  type :: peer_type
    real(dp) :: x(6) = 0               !! where it is
    logical :: explicit = .false.      !! of ARKODE
    real(dp) :: scale(6) = 0           !! absolute tolerances
    type(c_ptr) :: context = c_null_ptr, memory = c_null_ptr
    type(N_Vector), pointer :: state => null(), scales => null()
    type(SUNNonlinearSolver), pointer :: fixed_point => null()
  end type peer_type

contains

  !> Start `method` at x: 'adams' of CVODE with fixed-point iteration, or 'erk 4' to 'erk 8' of ARKODE.
  subroutine new_peer(problem, method, tolerance, x, t_end, peer)
    type(problem_type), intent(inout), target :: problem
    character(*), intent(in) :: method
    real(dp), intent(in) :: tolerance      !! relative to 1 cm, 10 mrad, 1 m/s, 1 rad/s, and to x
    real(dp), intent(in) :: x(6)
    real(dp), intent(in) :: t_end          !! [s]
    type(peer_type), intent(out), target :: peer
    integer(c_long), parameter :: many = 100000000
    integer(c_int64_t), parameter :: n = 6
    integer(c_int) :: status(8)
    integer :: table

    status = 0
    peer%x = x
    peer%scale = tolerance*[1e-2_dp, 1e-2_dp, 1e-2_dp, 1.0_dp, 1.0_dp, 1.0_dp]
    if (FSUNContext_Create(c_null_ptr, peer%context) /= 0) error stop 'SUNDIALS: no context'
    peer%state => FN_VMake_Serial(n, peer%x, peer%context)
    ! One call for what would be several operations: up to a twentieth less.
    status(1) = FN_VEnableFusedOps_Serial(peer%state, 1)
    peer%scales => FN_VMake_Serial(n, peer%scale, peer%context)
    peer%explicit = method(:3) == 'erk'
    problem%explicit = peer%explicit
    if (peer%explicit) then
      select case (method)
      case ('erk 4')
        table = ARKODE_ZONNEVELD_5_3_4
      case ('erk 5')
        table = ARKODE_DORMAND_PRINCE_7_4_5
      case ('erk 6')
        table = ARKODE_VERNER_8_5_6
      case ('erk 8')
        table = ARKODE_FEHLBERG_13_7_8
      case default
        error stop 'expected erk 4, erk 5, erk 6 or erk 8'
      end select
      peer%memory = FERKStepCreate(c_funloc(rates), 0.0_dp, peer%state, peer%context)
      status(2) = FERKStepSetErrFile(peer%memory, c_null_ptr)
      status(3) = FERKStepSVtolerances(peer%memory, tolerance, peer%scales)
      status(4) = FERKStepSetTableNum(peer%memory, table)
      status(5) = FERKStepSetMaxNumSteps(peer%memory, many)
      status(6) = FERKStepSetUserData(peer%memory, c_loc(problem))
      status(7) = FERKStepSetStopTime(peer%memory, t_end)
      status(8) = FERKStepSetMaxErrTestFails(peer%memory, 50)      ! in flight a first trial may go far
    else
      peer%memory = FCVodeCreate(CV_ADAMS, peer%context)
      status(2) = FCVodeInit(peer%memory, c_funloc(rates), 0.0_dp, peer%state)
      status(3) = FCVodeSVtolerances(peer%memory, tolerance, peer%scales)
      status(4) = FCVodeSetErrFile(peer%memory, c_null_ptr)
      status(5) = FCVodeSetMaxNumSteps(peer%memory, many)
      status(6) = FCVodeSetUserData(peer%memory, c_loc(problem))
      status(7) = FCVodeSetStopTime(peer%memory, t_end)
      peer%fixed_point => FSUNNonlinSol_FixedPoint(peer%state, 0_c_int, peer%context)
      status(8) = FCVodeSetNonlinearSolver(peer%memory, peer%fixed_point)
    end if
    if (any(status /= 0)) error stop 'SUNDIALS: an integrator cannot be set up'
  end subroutine new_peer

  !> On to `t`. `ok`: it was reached.
  subroutine evolve(peer, t, ok)
    type(peer_type), intent(inout) :: peer
    real(dp), intent(in) :: t              !! [s]
    logical, intent(out) :: ok
    real(dp) :: reached(1)
    integer(c_int) :: status

    if (peer%explicit) then
      status = FERKStepEvolve(peer%memory, t, peer%state, reached, ARK_NORMAL)
    else
      status = FCVode(peer%memory, t, peer%state, reached, CV_NORMAL)
    end if
    ok = status == CV_SUCCESS .or. status == CV_TSTOP_RETURN
  end subroutine evolve

  subroutine free_peer(peer)
    type(peer_type), intent(inout) :: peer
    integer(c_int) :: status

    if (peer%explicit) then
      call FERKStepFree(peer%memory)
    else
      call FCVodeFree(peer%memory)
    end if
    if (associated(peer%fixed_point)) status = FSUNNonlinSolFree(peer%fixed_point)
    call FN_VDestroy(peer%state)
    call FN_VDestroy(peer%scales)
    status = FSUNContext_Free(peer%context)
  end subroutine free_peer

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
      call contacts(w, pose(problem, from), state, with_hessian=.false.)
      to(1:3) = from(4:6)
      to(4:6) = (external_force(w, t) - state%gradient)/w%inertia()
    end associate
    problem%evaluations = problem%evaluations + 1
    status = 0
    if (state%status == inside) return
    to = far_off
    if (.not. problem%explicit) status = 1
  end function rates

  pure function pose(problem, x) result(q)
    type(problem_type), intent(in) :: problem
    real(dp), intent(in) :: x(6)
    real(dp) :: q(3)

    q = problem%setup%equilibrium + x(1:3)
  end function pose

end module by_sundials
program peers
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use, intrinsic :: iso_fortran_env, only: iostat_end
  use by_sundials, only: evolve, free_peer, new_peer, peer_type, problem_type
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
  type(peer_type) :: peer
  real(dp) :: from, to
  integer :: stat
  logical :: ok

  call read_prepared(c, setup)
  do
    read (*, nml=job, iostat=stat)
    if (stat == iostat_end) exit
    if (stat /= 0) error stop 'expected a namelist &job'
    problem = problem_type(setup)
    call new_peer(problem, trim(method), tolerance, [c%y, c%z, c%roll, c%vy, c%vz, c%roll_rate], t_end, peer)
    call cpu_time(from)
    call evolve(peer, t_end, ok)
    call cpu_time(to)
    write (*, '(2es24.16, 1x, i0)') merge(peer%x(1), ieee_value(1.0_dp, ieee_quiet_nan), ok), to - from, problem%evaluations
    flush (6)
    call free_peer(peer)
  end do
end program peers
