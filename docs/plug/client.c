/* The wheelset of a namelist by its own integrator in libldbench: time, lateral position and energy of the contacts, row by row.
 *
 * cc client.c $(pkg-config --cflags --libs ldbench) -o client; ./client ex1_aw.nml
 */
#include <ldbench.h>
#include <stdio.h>

int main(int count, char **words) {
  char message[1024];
  int64_t handle;
  ldbench_facts_t facts;
  double pose[3], velocity[3], energy, t = 0;
  int k, row, status;

  if (count != 2) return 2;
  status = ldbench_open(words[1], NULL, &handle, message, sizeof message);
  if (status == LDBENCH_OK) status = ldbench_facts(handle, &facts, message, sizeof message);
  for (k = 0; k < 3 && status == LDBENCH_OK; k++) {
    pose[k] = facts.start[k];
    velocity[k] = facts.velocity[k];
  }
  for (row = 0; row <= 500 && status == LDBENCH_OK; row++) {
    status = ldbench_contact(handle, pose, &energy, NULL, NULL, NULL, message, sizeof message);
    if (status != LDBENCH_OK) break;
    printf("%.3f %.12e %.12e\n", t, pose[0], energy);
    status = ldbench_advance(handle, t, pose, velocity, t + 1e-3, message, sizeof message);
    t = (row + 1)*1e-3;
  }
  if (status != LDBENCH_OK) fprintf(stderr, "%s\n", message);
  ldbench_close(handle, NULL, 0);
  return status;
}
