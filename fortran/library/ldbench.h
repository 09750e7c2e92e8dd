/* ldbench for other programs: contact forces and motions of a wheelset without friction, to the last digit those of the program.
 *
 * Frame: X forward, Y left, Z up. A pose is y [m], z [m] of the centre of the axle above the rails' common tangent, and roll [rad];
 * a velocity is its rate. Forces are those of the rails on the wheels. All numbers are in SI units, angles in rad.
 *
 * Every function returns a status. Where it is not LDBENCH_OK, `message` (room for `size` characters with the null character)
 * says in one line why; NULL is allowed. No function stops, prints, changes the working folder, locale, signals or the state of
 * the floating-point unit. Several threads may call functions at once, on one case, too, but for ldbench_set and ldbench_close,
 * which need the case for themselves.
 */
#ifndef LDBENCH_H
#define LDBENCH_H
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif

enum ldbench_status {
  LDBENCH_OK,
  LDBENCH_REFUSED,      /* wrong input; the message says what was expected and what was found */
  LDBENCH_OUTSIDE,      /* the pose is outside what the case's &table covers: an integrator may try a shorter step */
  LDBENCH_NO_ROOM       /* a text or rows were cut to the room that was given */
};

enum ldbench_place { LDBENCH_LEFT_TREAD, LDBENCH_LEFT_FLANGE, LDBENCH_RIGHT_TREAD, LDBENCH_RIGHT_FLANGE };

typedef struct {
  double mass, roll_inertia, pitch_inertia;   /* [kg, kg m2, kg m2] */
  double weight;                              /* with the vertical load [N] */
  double held[3], rest[3];                    /* poses at rest: held at y = 0, and free */
  double start[3], velocity[3];               /* pose and velocity at t = 0 */
  double lateral_force, lateral_ramp;         /* on the centre of gravity [N], its growth [N/s] */
  double t_end;                               /* [s] */
  double clearance[2];                        /* of the rigid wheelset's flanges, left and right [m] */
  int columns;                                /* of a row of ldbench_simulate */
} ldbench_facts_t;

typedef struct {
  double energy;                              /* elastic energy [J] */
  double force[3];                            /* F_y, F_z [N], moment about the centre of the axle [N m] */
  double angle, normal_force;                 /* of the resultant [rad, N]; the angle is NaN where the contact is open */
  double y, z, radius;                        /* where it acts, and the wheel's radius there [m]; NaN where the contact is open */
} ldbench_contact_t;

typedef struct {
  double t, angle, force;                     /* [s]; angle of a flange contact [rad]; lateral force [N] */
  int kind;                                   /* ldbench_event_name says what it is */
  int cause;                                  /* of a flange contact: 1 a contact closes, 2 a patch moves from the tread */
} ldbench_event_t;

int ldbench_version(char *text, int size);

/* Open the case of a namelist file, or of its text; `name` is the path that the text is taken to have. Files that the namelist
 * names are looked for as given, then beside it. `tables` is a folder in which contact tables, which take seconds, are kept, or the
 * user's cache where the folder may not be written; NULL: they are not. `handle` is the case's number, which no
 * other case will have; 0 stands for no case. */
int ldbench_open(const char *path, const char *tables, int64_t *handle, char *message, int size);
int ldbench_open_text(const char *text, const char *name, const char *tables, int64_t *handle, char *message, int size);
int ldbench_facts(int64_t handle, ldbench_facts_t *facts, char *message, int size);

/* What is doubtful about the case, a line each. */
int ldbench_warnings(int64_t handle, char *text, int size);

/* A number of &wheelset, &initial or &loading by its name in the namelist, such as vY, on which no contact table depends. */
int ldbench_get(int64_t handle, const char *name, double *value, char *message, int size);
int ldbench_set(int64_t handle, const char *name, double value, char *message, int size);

/* Contact in a pose: elastic energy of all contacts [J]; F_y, F_z [N] and moment about the centre of the axle [N m]; each contact
 * (by ldbench_place); second derivatives of the energy by yy, yz, y roll, zz, z roll, roll roll. NULL for what is not wanted;
 * the stiffness costs as much again. */
int ldbench_contact(int64_t handle, const double pose[3], double *energy, double force[3], ldbench_contact_t contacts[4],
                    double stiffness[6], char *message, int size);

/* Advance pose and velocity from time t to t_next by the case's own integrator, with steps that it cuts as in its runs. */
int ldbench_advance(int64_t handle, double t, double pose[3], double velocity[3], double t_next, char *message, int size);

/* Names and units of the columns, a line each. */
int ldbench_columns(int64_t handle, char *text, int size);

/* Run the case: rows, one after the other, as many as there is room for (NULL: none), and their number; the recorded events and
 * their number; the text of results as column files have it. NULL for what is not wanted. */
int ldbench_simulate(int64_t handle, int capacity, double *rows, int *n_rows, int most_events, ldbench_event_t *events,
                     int *n_events, char *results, int results_size, char *message, int size);
int ldbench_event_name(int kind, char *text, int size);

/* Free a case. Its number stands for nothing from then on. */
int ldbench_close(int64_t handle, char *message, int size);

#ifdef __cplusplus
}
#endif
#endif
