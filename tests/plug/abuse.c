/* Bad input to every function of ldbench.h: a status, a line that says why, and no access outside what was given.
 *
 * usage: abuse NAMELIST FOLDER
 * Prints what is not as expected, and returns how many these are.
 */
#include <ldbench.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { OK = LDBENCH_OK, REFUSED = LDBENCH_REFUSED, OUTSIDE = LDBENCH_OUTSIDE, NO_ROOM = LDBENCH_NO_ROOM };
static int faults;
static char *message;           /* 500 characters of their own, so that the sanitizer sees the end */
#define M message, 500

static void expect(int line, int status, int wanted, const char *words) {
  if (status == wanted && strstr(message, words) && strlen(message) < 500 && !strchr(message, '\n')) return;
  printf("line %d: expected status %d and \"%s\", found %d and \"%s\"\n", line, wanted, words, status, message);
  faults++;
}
#define EXPECT(call, wanted, words) \
  do { memset(message, 'x', 499); message[499] = 0; expect(__LINE__, call, wanted, words); } while (0)
/* Without a message, or for a function that has none. */
#define STATUS(call, wanted) do { int status = call; strcpy(message, ""); expect(__LINE__, status, wanted, ""); } while (0)

static void openings(const char *namelist, const char *folder) {
  int64_t handle = 7;
  EXPECT(ldbench_open(NULL, NULL, &handle, M), REFUSED, "path: expected an address");
  EXPECT(ldbench_open(namelist, NULL, NULL, M), REFUSED, "handle: expected a place for it");
  STATUS(ldbench_open(NULL, NULL, NULL, NULL, 0), REFUSED);
  STATUS(ldbench_open(namelist, NULL, NULL, NULL, 500), REFUSED);
  EXPECT(ldbench_open("", NULL, &handle, M), REFUSED, "expected a file");
  EXPECT(ldbench_open("none.nml", NULL, &handle, M), REFUSED, "none.nml: cannot be opened");
  EXPECT(ldbench_open(folder, NULL, &handle, M), REFUSED, folder);
  EXPECT(ldbench_open("profiles/awprof.yz", NULL, &handle, M), REFUSED, "awprof.yz");
  EXPECT(ldbench_open("/proc/self/exe", NULL, &handle, M), REFUSED, "exe");
  EXPECT(ldbench_open_text(NULL, "my.nml", NULL, &handle, M), REFUSED, "text: expected an address");
  EXPECT(ldbench_open_text("", NULL, NULL, &handle, M), REFUSED, "name: expected an address");
  EXPECT(ldbench_open_text("&contact", "my.nml", NULL, &handle, M), REFUSED, "my.nml");
  EXPECT(ldbench_open_text("&profiles wheel_profile = 'none.yz' /", "my.nml", NULL, &handle, M), REFUSED, "none.yz");
  EXPECT(ldbench_open_text("&contact model = 'hurtz' /", "my.nml", NULL, &handle, M), REFUSED, "&contact model");
  EXPECT(ldbench_open_text("&wheelset mass = NaN /", "my.nml", NULL, &handle, M), REFUSED, "mass");
  if (handle != 0) expect(__LINE__, (int)handle, 0, "a handle of no case");
}

static void contacts(int64_t handle) {
  const double middle[3] = {0, 0.46, 0}, far_off[3] = {1, 2, 3}, nan_[3] = {0, NAN, 0}, inf[3] = {INFINITY, 0, 0};
  double *force = malloc(3*sizeof *force), *stiffness = malloc(6*sizeof *stiffness), pose[3], velocity[3] = {0};
  ldbench_contact_t *points = malloc(4*sizeof *points);
  ldbench_facts_t facts;
  EXPECT(ldbench_facts(handle, NULL, M), REFUSED, "facts: expected an address");
  EXPECT(ldbench_facts(handle, &facts, M), OK, "");
  memcpy(pose, facts.held, sizeof pose);
  EXPECT(ldbench_contact(handle, NULL, NULL, force, points, stiffness, M), REFUSED, "pose: expected an address");
  EXPECT(ldbench_contact(handle, nan_, NULL, force, points, stiffness, M), REFUSED, "finite");
  EXPECT(ldbench_contact(handle, inf, NULL, force, points, stiffness, M), REFUSED, "finite");
  EXPECT(ldbench_contact(handle, far_off, NULL, force, points, stiffness, M), OUTSIDE, "a pose within the extent of &table");
  EXPECT(ldbench_contact(handle, middle, NULL, NULL, NULL, NULL, M), OK, "");
  EXPECT(ldbench_contact(handle, pose, NULL, force, points, stiffness, M), OK, "");
  STATUS(ldbench_contact(handle, far_off, NULL, NULL, NULL, NULL, NULL, -1), OUTSIDE);
  EXPECT(ldbench_advance(handle, 0, NULL, velocity, 1e-3, M), REFUSED, "pose: expected an address");
  EXPECT(ldbench_advance(handle, 0, pose, NULL, 1e-3, M), REFUSED, "velocity: expected an address");
  EXPECT(ldbench_advance(handle, 1, pose, velocity, 0, M), REFUSED, "a time after");
  EXPECT(ldbench_advance(handle, 0, pose, velocity, NAN, M), REFUSED, "finite");
  EXPECT(ldbench_advance(handle, 0, pose, velocity, 1e300, M), REFUSED, "steps of &integrator dt");
  velocity[1] = -1e5;
  EXPECT(ldbench_advance(handle, 0, pose, velocity, 1e-3, M), OUTSIDE, "a pose within the extent of &table");
  if (memcmp(pose, facts.held, sizeof pose) != 0) expect(__LINE__, 1, 0, "the pose of before");
  free(force);
  free(stiffness);
  free(points);
}

static void numbers(int64_t handle) {
  double mass, value;
  EXPECT(ldbench_get(handle, "mass", &mass, M), OK, "");
  EXPECT(ldbench_set(handle, NULL, 1, M), REFUSED, "name: expected an address");
  EXPECT(ldbench_set(handle, "gauge", 1, M), REFUSED, "name: expected a number of &wheelset, &initial");
  EXPECT(ldbench_set(handle, "gauge", 1, M), REFUSED, "found gauge");
  EXPECT(ldbench_set(handle, "mass", -1, M), REFUSED, "mass");
  EXPECT(ldbench_set(handle, "mass", NAN, M), REFUSED, "mass");
  EXPECT(ldbench_set(handle, "vY", INFINITY, M), REFUSED, "vY");
  EXPECT(ldbench_get(handle, "mass", NULL, M), REFUSED, "value: expected an address");
  EXPECT(ldbench_get(handle, "", &value, M), REFUSED, "name");
  EXPECT(ldbench_get(handle, "none", &value, M), REFUSED, "found none");
  EXPECT(ldbench_get(handle, "mass", &value, M), OK, "");
  if (value != mass) expect(__LINE__, 1, 0, "the mass of before");
}

/* Arrays with less room than what goes there. */
static void little_room(int64_t handle) {
  char *few = malloc(5);
  STATUS(ldbench_version(few, 5), NO_ROOM);
  STATUS(ldbench_version(NULL, 5), NO_ROOM);
  STATUS(ldbench_version(few, 0), NO_ROOM);
  STATUS(ldbench_columns(handle, few, 5), NO_ROOM);
  if (strlen(few) != 4) expect(__LINE__, (int)strlen(few), 4, "four characters");
  STATUS(ldbench_columns(handle, NULL, 5), NO_ROOM);
  STATUS(ldbench_warnings(handle, NULL, 0), NO_ROOM);
  STATUS(ldbench_event_name(0, few, 5), REFUSED);
  STATUS(ldbench_event_name(1000, few, 5), REFUSED);
  STATUS(ldbench_event_name(1, few, 5), NO_ROOM);
  EXPECT(ldbench_open("none.nml", NULL, &handle, few, 5) == REFUSED && strlen(few) == 4 ? OK : REFUSED, OK, "");
  free(few);
}

static void runs(int64_t handle) {
  char *few = malloc(5);
  ldbench_facts_t facts;
  double *rows;
  ldbench_event_t *event = malloc(sizeof *event);
  int n = 0, events = 0;
  ldbench_facts(handle, &facts, M);
  rows = malloc(3*(size_t)facts.columns*sizeof *rows);
  EXPECT(ldbench_simulate(handle, 3, rows, NULL, 1, event, &events, few, 5, M), REFUSED, "n_rows: expected an address");
  EXPECT(ldbench_simulate(handle, -1, NULL, &n, -1, NULL, NULL, NULL, -1, M), OK, "");
  STATUS(ldbench_simulate(handle, 3, rows, &n, 1, event, &events, few, 5, M), NO_ROOM);
  if (n <= 3) expect(__LINE__, n, 4, "more rows than there is room for");
  free(few);
  free(rows);
  free(event);
}

/* A number that stands for no case. */
static void nothing(int64_t handle) {
  const char *words = "handle: expected an open case";
  double pose[3] = {0}, value;
  ldbench_facts_t facts;
  int n;
  EXPECT(ldbench_close(handle, M), REFUSED, words);
  EXPECT(ldbench_facts(handle, &facts, M), REFUSED, words);
  EXPECT(ldbench_warnings(handle, M), REFUSED, words);
  EXPECT(ldbench_columns(handle, M), REFUSED, words);
  EXPECT(ldbench_contact(handle, pose, NULL, pose, NULL, NULL, M), REFUSED, words);
  EXPECT(ldbench_advance(handle, 0, pose, pose, 1, M), REFUSED, words);
  EXPECT(ldbench_set(handle, "mass", 1, M), REFUSED, words);
  EXPECT(ldbench_get(handle, "mass", &value, M), REFUSED, words);
  EXPECT(ldbench_simulate(handle, 0, NULL, &n, 0, NULL, NULL, NULL, 0, M), REFUSED, words);
  STATUS(ldbench_close(handle, NULL, 0), REFUSED);
}

int main(int count, char **words) {
  int64_t handle = 0, other = 0;
  if (count != 3 || !(message = malloc(500))) return 100;
  openings(words[1], words[2]);
  EXPECT(ldbench_open(words[1], NULL, &handle, M), OK, "");
  EXPECT(ldbench_open(words[1], words[2], &other, M), OK, "");
  contacts(handle);
  numbers(handle);
  little_room(handle);
  runs(other);
  EXPECT(ldbench_close(handle, M), OK, "");
  nothing(handle);
  nothing(0);
  nothing(-1);
  EXPECT(ldbench_close(-1, M), REFUSED, "found -1");
  nothing(INT64_MAX);
  nothing(INT64_MIN);
  EXPECT(ldbench_close(other, M), OK, "");
  free(message);
  return faults;
}
