/* The wheelset of a namelist by its own integrator in libldbench, row by row: time, lateral position and velocity, normal force of
 * the left flange, total energy.
 *
 * cc client.c $(pkg-config --cflags --libs ldbench) -o client; ./client ex1_aw.nml 0.5 0.001
 */
#include <ldbench.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int main(int count, char **words) {
  char message[1024];
  int64_t handle;
  ldbench_facts_t f;
  ldbench_contact_t contacts[4];
  double q[3], v[3], energy, t = 0, t_end = count > 2 ? atof(words[2]) : 0.5, interval = count > 3 ? atof(words[3]) : 1e-3;
  int row, status;

  if (count < 2) return 2;
  status = ldbench_open(words[1], count > 4 ? words[4] : NULL, &handle, message, sizeof message);
  if (status == LDBENCH_OK) status = ldbench_facts(handle, &f, message, sizeof message);
  memcpy(q, f.start, sizeof q);
  memcpy(v, f.velocity, sizeof v);
  for (row = 1; status == LDBENCH_OK; row++) {
    status = ldbench_contact(handle, q, &energy, NULL, contacts, NULL, message, sizeof message);
    if (status != LDBENCH_OK) break;
    energy += f.weight*q[1] + 0.5*(f.mass*(v[0]*v[0] + v[1]*v[1]) + f.roll_inertia*v[2]*v[2]);
    printf("%.9f %.12e %.12e %.9e %.15e\n", t, q[0], v[0], contacts[LDBENCH_LEFT_FLANGE].normal_force, energy);
    if (row*interval > t_end*(1 + 1e-12)) break;
    status = ldbench_advance(handle, t, q, v, row*interval, message, sizeof message);
    t = row*interval;
  }
  if (status != LDBENCH_OK) fprintf(stderr, "%s\n", message);
  ldbench_close(handle, NULL, 0);
  return status;
}
