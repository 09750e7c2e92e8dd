!> Whether a rail stands upright under a coned wheel, as the drawings of design rails have it and hardly any track.
module upright_rails
  use kinds, only: dp
  use run_setup, only: setup_type
  use text, only: str
  use wheel_rail_pair, only: pair_type
  implicit none
  private
  public :: warn_of_upright

contains

  !> Give a warning about the rails of a case that stand upright although nothing was said of their inclination; '' where none does.
  pure subroutine warn_of_upright(setup, words)
    type(setup_type), intent(in) :: setup
    character(:), allocatable, intent(out) :: words
    real(dp), parameter :: least_cone = 0.01_dp
    real(dp) :: cone
    logical :: upright(2)
    integer :: k

    words = ''
    do k = 1, 2
      upright(k) = abs(setup%inclination(k)) <= 0 .and. stands_upright(setup%side(k)%pair)
      if (upright(k)) upright(k) = tread_slope(setup%side(k)%pair) > least_cone
    end do
    if (.not. any(upright)) return
    k = merge(1, 2, upright(1))
    cone = tread_slope(setup%side(k)%pair)
    words = setup%rail(k)%file
    if (all(upright) .and. setup%rail(2)%file /= words) words = words//' and '//setup%rail(2)%file
    words = 'the head of '//words//' is symmetric and stands upright under a wheel coned 1:'//str(nint(1/cone))// &
      '; design rails are published upright: where the track inclines them, give &track rail_inclination, such as 1:40'
  end subroutine warn_of_upright

  !> Whether the midpoints of a head's chords lie above each other.
  pure logical function stands_upright(pair)
    type(pair_type), intent(in) :: pair
    real(dp), parameter :: first = 4e-3_dp, last = 14e-3_dp     ! chords below the top, past the crown [m]
    ! A head that leans by 1:40 moves its midpoints by 0.7 mm. Worn heads have farther ones [m].
    real(dp), parameter :: aside = 0.15e-3_dp
    integer, parameter :: chords = 11
    real(dp) :: middle(chords), ends(2), level
    integer :: i

    stands_upright = .false.
    do i = 1, chords
      level = -first - (i - 1)*(last - first)/(chords - 1)
      ends = chord(pair, level)
      if (ends(2) <= ends(1)) return
      middle(i) = (ends(1) + ends(2))/2
    end do
    stands_upright = maxval(middle) - minval(middle) < aside
  end function stands_upright

  !> y of the gauge side and of the field side at a height [m]; both 0 where the rail does not go down to it.
  pure function chord(pair, level) result(ends)
    type(pair_type), intent(in) :: pair
    real(dp), intent(in) :: level
    real(dp) :: ends(2)
    integer :: n, first, last

    associate (y => pair%rail%a(1, 1, 1:), z => pair%rail%a(2, 1, 1:))
      n = size(z)
      first = findloc(z >= level, .true., 1)
      last = findloc(z >= level, .true., 1, back=.true.)
      ends = 0
      if (first <= 1 .or. last >= n) return
      ends = [between(first - 1), between(last)]
    end associate

  contains

    !> y at the level on the straight line from knot i to the next one [m].
    pure real(dp) function between(i)
      integer, intent(in) :: i

      associate (a => pair%rail%a(:, 1, i), b => pair%rail%a(:, 1, i + 1))
        between = a(1) + (level - a(2))/(b(2) - a(2))*(b(1) - a(1))
      end associate
    end function between

  end function chord

  !> Mean slope of the tread over 10 mm to either side of the running point.
  pure real(dp) function tread_slope(pair) result(slope)
    type(pair_type), intent(in) :: pair
    real(dp), parameter :: half = 10e-3_dp     ! [m]
    integer :: low, high

    low = max(1, count(pair%s < pair%centred_station - half))
    high = min(size(pair%s), count(pair%s <= pair%centred_station + half) + 1)
    slope = (pair%r(2, high) - pair%r(2, low))/(pair%r(1, high) - pair%r(1, low))
  end function tread_slope

end module upright_rails
