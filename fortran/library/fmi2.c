/* FMI 2.0 for model exchange and co-simulation by the functions of ldbench.h. Source of names and meanings: Functional Mock-up
 * Interface for Model Exchange and Co-Simulation 2.0.4, fmi-standard.org.
 *
 * One binary serves two models; the first letter of their GUID tells which: w, the wheelset with six states; c, its contacts alone,
 * the pose comes in and the forces go out. The folder of resources has the case (case.nml), its profiles and the tables.
 */
#include "ldbench.h"
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef void (*logger_t)(void *environment, const char *instance, fmi2Status status, const char *category, const char *words, ...);
typedef struct {
  logger_t logger;
  void *allocate, *release, *step_finished, *environment;
} callbacks_t;
typedef struct {
  int newDiscreteStatesNeeded, terminateSimulation, nominalsOfContinuousStatesChanged, valuesOfContinuousStatesChanged,
    nextEventTimeDefined;
  double nextEventTime;
} event_info_t;

/* Value references. modelDescription.xml is written by them (wrappers/ldbench/fmu.py). */
enum {
  STATES = 0,           /* y, z, roll; their rates */
  DERIVATIVES = 6,
  ELASTIC = 12,         /* energy of the contacts */
  KINETIC = 13,
  FORCE = 14,           /* F_y, F_z, moment of all contacts */
  LOAD = 17,            /* lateral force from outside */
  CONTACTS = 20,        /* eight numbers of each contact, ten apart */
  PARAMETERS = 100
};
static const char *const parameters[] = {"mass", "roll_inertia", "pitch_inertia", "vertical_load", "lateral_force", "lateral_ramp",
                                         "Y", "Z", "roll", "vY", "vZ", "roll_rate"};
enum { N_PARAMETERS = 12, N_MOTION = 6 /* parameters before the initial ones */, SIZE = 1024, INDICATORS = 4 };
static const double TOUCH = 1.0;        /* normal force at which an indicator changes its sign [N] */
static const double FAR_OFF = 1e15;     /* acceleration outside the table [m/s2, rad/s2] */

typedef struct {
  char name[SIZE];
  callbacks_t calls;
  int64_t handle;
  int wheelset;                         /* the model has states */
  int starting;                         /* the initial pose follows from parameters */
  double t, x[6];
  double parameter[N_PARAMETERS];
  int given[N_PARAMETERS];
  ldbench_facts_t facts;
  int known;                            /* the next ones are those of x */
  double energy, force[3];
  ldbench_contact_t contact[4];
} model_t;

static fmi2Status say(const model_t *m, fmi2Status status, const char *words) {
  if (m->calls.logger) m->calls.logger(m->calls.environment, m->name, status, "logStatusError", "%s", words);
  return status;
}

/* A pose outside the table lets an integrator try a shorter step, of which it need not tell. */
static fmi2Status said(const model_t *m, int status, const char *message) {
  if (status == LDBENCH_OK) return fmi2OK;
  return status == LDBENCH_OUTSIDE ? fmi2Discard : say(m, fmi2Error, message);
}

/* The path of a URI file:///..., file:/... or of a path, with %20 and so on as letters. */
static void path_of(const char *uri, char *path, size_t size) {
  size_t n = 0;
  if (strncmp(uri, "file:", 5) == 0) {
    uri += 5;
    if (strncmp(uri, "//", 2) == 0) uri += 2;
    if (strncmp(uri, "localhost/", 10) == 0) uri += 9;
#ifdef _WIN32
    if (uri[0] == '/' && isalpha((unsigned char)uri[1]) && uri[2] == ':') uri++;
#endif
  }
  for (; *uri && n + 1 < size; uri++) {
    char code[3] = {0};
    if (uri[0] == '%' && isxdigit((unsigned char)uri[1]) && isxdigit((unsigned char)uri[2])) {
      code[0] = uri[1];
      code[1] = uri[2];
      path[n++] = (char)strtol(code, NULL, 16);
      uri += 2;
    } else {
      path[n++] = *uri;
    }
  }
  while (n > 0 && path[n - 1] == '/') n--;
  path[n] = 0;
}

static double kinetic_energy(const model_t *m) {
  return 0.5*(m->facts.mass*(m->x[3]*m->x[3] + m->x[4]*m->x[4]) + m->facts.roll_inertia*m->x[5]*m->x[5]);
}

static double lateral_load(const model_t *m) {
  return m->facts.lateral_force + m->facts.lateral_ramp*m->t;
}

/* The contacts in the present pose. */
static fmi2Status evaluate(model_t *m) {
  char message[SIZE];
  int status;
  if (m->known) return fmi2OK;
  status = ldbench_contact(m->handle, m->x, &m->energy, m->force, m->contact, NULL, message, SIZE);
  m->known = status == LDBENCH_OK;
  return said(m, status, message);
}

/* Give the case the parameters, and the state its start. */
static fmi2Status start(model_t *m) {
  char message[SIZE];
  int k, status = LDBENCH_OK;
  for (k = 0; k < N_PARAMETERS && status == LDBENCH_OK; k++)
    if (m->given[k]) status = ldbench_set(m->handle, parameters[k], m->parameter[k], message, SIZE);
  if (status == LDBENCH_OK) status = ldbench_facts(m->handle, &m->facts, message, SIZE);
  if (status == LDBENCH_OK && m->starting && m->wheelset) {
    memcpy(m->x, m->facts.start, sizeof m->facts.start);
    memcpy(m->x + 3, m->facts.velocity, sizeof m->facts.velocity);
  }
  m->known = 0;
  return said(m, status, message);
}

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }

EXPORT void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const callbacks_t *calls,
                             int visible, int logging) {
  model_t *m = calloc(1, sizeof *m);
  char folder[SIZE], file[SIZE + 16], tables[SIZE + 16], message[SIZE];
  (void)type; (void)visible; (void)logging;
  if (!m) return NULL;
  if (calls) m->calls = *calls;
  snprintf(m->name, SIZE, "%s", name ? name : "");
  if (!guid || (guid[0] != 'w' && guid[0] != 'c') || !resources) {
    say(m, fmi2Error, "expected the GUID of modelDescription.xml and the folder of resources, found others");
    free(m);
    return NULL;
  }
  m->wheelset = guid[0] == 'w';
  m->starting = 1;
  path_of(resources, folder, SIZE);
  snprintf(file, sizeof file, "%s/case.nml", folder);
  snprintf(tables, sizeof tables, "%s/tables", folder);
  if (ldbench_open(file, tables, &m->handle, message, SIZE) != LDBENCH_OK) {
    say(m, fmi2Error, message);
    free(m);
    return NULL;
  }
  if (ldbench_facts(m->handle, &m->facts, message, SIZE) == LDBENCH_OK) {
    memcpy(m->x, m->wheelset ? m->facts.start : m->facts.held, sizeof m->facts.held);
    if (m->wheelset) memcpy(m->x + 3, m->facts.velocity, sizeof m->facts.velocity);
  }
  return m;
}

EXPORT void fmi2FreeInstance(void *c) {
  model_t *m = c;
  if (!m) return;
  ldbench_close(m->handle, NULL, 0);
  free(m);
}

EXPORT fmi2Status fmi2SetDebugLogging(void *c, int on, size_t n, const char *const categories[]) {
  (void)c; (void)on; (void)n; (void)categories;
  return fmi2OK;
}

EXPORT fmi2Status fmi2SetupExperiment(void *c, int has_tolerance, double tolerance, double from, int has_end, double to) {
  model_t *m = c;
  (void)has_tolerance; (void)tolerance; (void)has_end; (void)to;
  m->t = from;
  return fmi2OK;
}

EXPORT fmi2Status fmi2EnterInitializationMode(void *c) { return start(c); }

EXPORT fmi2Status fmi2ExitInitializationMode(void *c) {
  model_t *m = c;
  fmi2Status status = start(m);
  m->starting = 0;
  return status;
}

EXPORT fmi2Status fmi2Terminate(void *c) {
  (void)c;
  return fmi2OK;
}

EXPORT fmi2Status fmi2Reset(void *c) {
  model_t *m = c;
  m->t = 0;
  m->starting = 1;
  return start(m);
}

/* A number by its value reference. */
static fmi2Status number(model_t *m, unsigned at, double *value) {
  const double zero[3] = {0, -m->facts.weight, 0};
  const double inertia[3] = {m->facts.mass, m->facts.mass, m->facts.roll_inertia};
  fmi2Status status = fmi2OK;
  if (at >= PARAMETERS && at < PARAMETERS + N_PARAMETERS) {
    char message[SIZE];
    unsigned k = at - PARAMETERS;
    *value = m->parameter[k];
    return m->given[k] ? fmi2OK : said(m, ldbench_get(m->handle, parameters[k], value, message, SIZE), message);
  }
  if (at < DERIVATIVES) {
    *value = m->x[at];
    return fmi2OK;
  }
  if (at < DERIVATIVES + 3) {
    *value = m->x[at - DERIVATIVES + 3];
    return fmi2OK;
  }
  if (at == KINETIC || at == LOAD) {
    *value = at == KINETIC ? kinetic_energy(m) : lateral_load(m);
    return fmi2OK;
  }
  status = evaluate(m);
  if (status != fmi2OK) return status;
  if (at < ELASTIC) {
    unsigned k = at - DERIVATIVES - 3;
    *value = (m->force[k] + zero[k] + (k == 0 ? lateral_load(m) : 0))/inertia[k];
  } else if (at == ELASTIC) {
    *value = m->energy;
  } else if (at >= FORCE && at < FORCE + 3) {
    *value = m->force[at - FORCE];
  } else if (at >= CONTACTS && at < CONTACTS + 40 && (at - CONTACTS)%10 < 8) {
    const ldbench_contact_t *one = &m->contact[(at - CONTACTS)/10];
    const double values[8] = {one->normal_force, one->angle, one->force[0], one->force[1], one->y, one->z, one->radius,
                              one->energy};
    *value = values[(at - CONTACTS)%10];
  } else {
    return say(m, fmi2Error, "expected a value reference of modelDescription.xml, found another");
  }
  return fmi2OK;
}

EXPORT fmi2Status fmi2GetReal(void *c, const unsigned at[], size_t n, double values[]) {
  size_t k;
  fmi2Status status = fmi2OK;
  for (k = 0; k < n && status == fmi2OK; k++) status = number(c, at[k], &values[k]);
  return status;
}

EXPORT fmi2Status fmi2SetReal(void *c, const unsigned at[], size_t n, const double values[]) {
  model_t *m = c;
  size_t k;
  int changed = 0;
  for (k = 0; k < n; k++) {
    if (at[k] >= PARAMETERS && at[k] < PARAMETERS + N_PARAMETERS) {
      if (!m->starting && at[k] >= PARAMETERS + N_MOTION)
        return say(m, fmi2Error, "expected initial values before the end of the initialization, found one after it");
      m->parameter[at[k] - PARAMETERS] = values[k];
      m->given[at[k] - PARAMETERS] = 1;
      changed = 1;
    } else if (at[k] < (m->wheelset ? 6 : 3)) {
      m->x[at[k]] = values[k];
      m->known = 0;
    } else {
      return say(m, fmi2Error, "expected an input or a parameter, found a variable that cannot be set");
    }
  }
  return changed && !m->starting ? start(m) : fmi2OK;
}

/* The model has real variables alone. */
#define NONE(c, n) ((n) == 0 ? fmi2OK : say(c, fmi2Error, "expected real variables, found others"))
EXPORT fmi2Status fmi2GetInteger(void *c, const unsigned at[], size_t n, int v[]) { (void)at; (void)v; return NONE(c, n); }
EXPORT fmi2Status fmi2GetBoolean(void *c, const unsigned at[], size_t n, int v[]) { (void)at; (void)v; return NONE(c, n); }
EXPORT fmi2Status fmi2GetString(void *c, const unsigned at[], size_t n, const char *v[]) { (void)at; (void)v; return NONE(c, n); }
EXPORT fmi2Status fmi2SetInteger(void *c, const unsigned at[], size_t n, const int v[]) { (void)at; (void)v; return NONE(c, n); }
EXPORT fmi2Status fmi2SetBoolean(void *c, const unsigned at[], size_t n, const int v[]) { (void)at; (void)v; return NONE(c, n); }
EXPORT fmi2Status fmi2SetString(void *c, const unsigned at[], size_t n, const char *const v[]) {
  (void)at; (void)v;
  return NONE(c, n);
}

/* The state of an instance: time, pose and velocity, parameters. */
typedef struct {
  double t, x[6], parameter[N_PARAMETERS];
  int given[N_PARAMETERS], starting;
} state_t;

EXPORT fmi2Status fmi2GetFMUstate(void *c, void **state) {
  model_t *m = c;
  state_t *s = *state ? *state : calloc(1, sizeof *s);
  if (!s) return say(m, fmi2Error, "the memory is used up");
  s->t = m->t;
  s->starting = m->starting;
  memcpy(s->x, m->x, sizeof s->x);
  memcpy(s->parameter, m->parameter, sizeof s->parameter);
  memcpy(s->given, m->given, sizeof s->given);
  *state = s;
  return fmi2OK;
}

EXPORT fmi2Status fmi2SetFMUstate(void *c, void *state) {
  model_t *m = c;
  const state_t *s = state;
  fmi2Status status = fmi2OK;
  int changed = memcmp(m->parameter, s->parameter, sizeof s->parameter) || memcmp(m->given, s->given, sizeof s->given);
  memcpy(m->parameter, s->parameter, sizeof s->parameter);
  memcpy(m->given, s->given, sizeof s->given);
  m->starting = s->starting;
  if (changed) status = start(m);
  m->t = s->t;
  memcpy(m->x, s->x, sizeof s->x);
  m->known = 0;
  return status;
}

EXPORT fmi2Status fmi2FreeFMUstate(void *c, void **state) {
  (void)c;
  free(*state);
  *state = NULL;
  return fmi2OK;
}

EXPORT fmi2Status fmi2SerializedFMUstateSize(void *c, void *state, size_t *size) {
  (void)c; (void)state;
  *size = sizeof(state_t);
  return fmi2OK;
}

EXPORT fmi2Status fmi2SerializeFMUstate(void *c, void *state, char bytes[], size_t size) {
  if (size < sizeof(state_t)) return say(c, fmi2Error, "expected room for a state, found less");
  memcpy(bytes, state, sizeof(state_t));
  return fmi2OK;
}

EXPORT fmi2Status fmi2DeSerializeFMUstate(void *c, const char bytes[], size_t size, void **state) {
  if (size < sizeof(state_t)) return say(c, fmi2Error, "expected the bytes of a state, found fewer");
  if (!*state) *state = calloc(1, sizeof(state_t));
  if (!*state) return say(c, fmi2Error, "the memory is used up");
  memcpy(*state, bytes, sizeof(state_t));
  return fmi2OK;
}

EXPORT fmi2Status fmi2GetDirectionalDerivative(void *c, const unsigned of[], size_t n, const unsigned by[], size_t k,
                                               const double seed[], double values[]) {
  (void)of; (void)n; (void)by; (void)k; (void)seed; (void)values;
  return say(c, fmi2Error, "expected no call for directional derivatives, which modelDescription.xml does not offer, found one");
}

/* Model exchange. */
EXPORT fmi2Status fmi2EnterEventMode(void *c) { (void)c; return fmi2OK; }
EXPORT fmi2Status fmi2EnterContinuousTimeMode(void *c) { (void)c; return fmi2OK; }

EXPORT fmi2Status fmi2NewDiscreteStates(void *c, event_info_t *info) {
  (void)c;
  memset(info, 0, sizeof *info);
  return fmi2OK;
}

EXPORT fmi2Status fmi2CompletedIntegratorStep(void *c, int no_rewind, int *enter_event_mode, int *terminate) {
  (void)c; (void)no_rewind;
  *enter_event_mode = 0;
  *terminate = 0;
  return fmi2OK;
}

EXPORT fmi2Status fmi2SetTime(void *c, double t) {
  ((model_t *)c)->t = t;
  return fmi2OK;
}

EXPORT fmi2Status fmi2SetContinuousStates(void *c, const double x[], size_t n) {
  model_t *m = c;
  if (n > 6 || (n > 0 && !m->wheelset)) return say(m, fmi2Error, "expected the states of the model, found more");
  if (n == 0) return fmi2OK;
  memcpy(m->x, x, n*sizeof *x);
  m->known = 0;
  return fmi2OK;
}

EXPORT fmi2Status fmi2GetContinuousStates(void *c, double x[], size_t n) {
  memcpy(x, ((model_t *)c)->x, (n < 6 ? n : 6)*sizeof *x);
  return fmi2OK;
}

EXPORT fmi2Status fmi2GetNominalsOfContinuousStates(void *c, double x[], size_t n) {
  const double nominal[6] = {1e-2, 1e-2, 1e-2, 1, 1, 1};
  (void)c;
  memcpy(x, nominal, (n < 6 ? n : 6)*sizeof *x);
  return fmi2OK;
}

/* Not every importer lets its integrator try a shorter step after fmi2Discard. Accelerations that no step can follow do so in all
 * of them: where a trial pose is outside the table the step fails, and where the motion itself goes there the integrator tells. */
EXPORT fmi2Status fmi2GetDerivatives(void *c, double rates[], size_t n) {
  unsigned k;
  fmi2Status status = fmi2OK;
  for (k = 0; k < n && status != fmi2Error; k++) {
    status = number(c, DERIVATIVES + k, &rates[k]);
    if (status == fmi2Discard) rates[k] = FAR_OFF;
  }
  return status == fmi2Discard ? fmi2OK : status;
}

EXPORT fmi2Status fmi2GetEventIndicators(void *c, double indicators[], size_t n) {
  model_t *m = c;
  size_t k;
  fmi2Status status = evaluate(m);
  for (k = 0; k < n && k < INDICATORS && status != fmi2Error; k++) indicators[k] = m->contact[k].normal_force - TOUCH;
  return status == fmi2Discard ? fmi2OK : status;
}

/* Co-simulation. */
EXPORT fmi2Status fmi2DoStep(void *c, double t, double step, int keep) {
  model_t *m = c;
  char message[SIZE];
  int status = LDBENCH_OK;
  (void)keep;
  if (m->wheelset) {
    status = ldbench_advance(m->handle, t, m->x, m->x + 3, t + step, message, SIZE);
    m->known = 0;
  }
  if (status == LDBENCH_OK) m->t = t + step;
  return said(m, status, message);
}

EXPORT fmi2Status fmi2CancelStep(void *c) {
  return say(c, fmi2Error, "expected no step that can be cancelled, found a call for it");
}

EXPORT fmi2Status fmi2SetRealInputDerivatives(void *c, const unsigned at[], size_t n, const int order[], const double v[]) {
  (void)at; (void)order; (void)v;
  return NONE(c, n);
}

EXPORT fmi2Status fmi2GetRealOutputDerivatives(void *c, const unsigned at[], size_t n, const int order[], double v[]) {
  (void)at; (void)order; (void)v;
  return NONE(c, n);
}

EXPORT fmi2Status fmi2GetStatus(void *c, int kind, fmi2Status *status) {
  (void)c; (void)kind;
  *status = fmi2OK;
  return fmi2Discard;
}

EXPORT fmi2Status fmi2GetRealStatus(void *c, int kind, double *value) {
  (void)kind;
  *value = ((model_t *)c)->t;
  return fmi2OK;
}

EXPORT fmi2Status fmi2GetIntegerStatus(void *c, int kind, int *value) { (void)c; (void)kind; *value = 0; return fmi2Discard; }
EXPORT fmi2Status fmi2GetBooleanStatus(void *c, int kind, int *value) { (void)c; (void)kind; *value = 0; return fmi2OK; }
EXPORT fmi2Status fmi2GetStringStatus(void *c, int kind, const char **value) {
  (void)c; (void)kind;
  *value = "";
  return fmi2Discard;
}
