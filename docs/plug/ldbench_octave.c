/* libldbench for Octave: found = ldbench_octave(file) opens a case and gives a row of its number, mass, roll inertia, weight, and
 * pose and velocity at the start; force = ldbench_octave(number, pose) gives forces and moment of the contacts.
 *
 * mkoctfile --mex ldbench_octave.c $(pkg-config --cflags --libs ldbench)
 */
#include <ldbench.h>
#include <mex.h>
#include <string.h>

void mexFunction(int n_out, mxArray *out[], int n_in, const mxArray *in[]) {
  char message[1024] = "expected (file) or (number, pose)";
  int status = LDBENCH_REFUSED;
  (void)n_out;
  if (n_in == 1) {
    int64_t handle;
    ldbench_facts_t f;
    char *file = mxArrayToString(in[0]);
    status = ldbench_open(file, NULL, &handle, message, sizeof message);
    if (status == LDBENCH_OK) status = ldbench_facts(handle, &f, message, sizeof message);
    out[0] = mxCreateDoubleMatrix(1, 10, mxREAL);
    if (status == LDBENCH_OK) {
      double *x = mxGetPr(out[0]), first[4] = {(double)handle, f.mass, f.roll_inertia, f.weight};
      memcpy(x, first, sizeof first);
      memcpy(x + 4, f.start, sizeof f.start);
      memcpy(x + 7, f.velocity, sizeof f.velocity);
    }
    mxFree(file);
  } else if (n_in == 2) {
    out[0] = mxCreateDoubleMatrix(3, 1, mxREAL);
    status = ldbench_contact((int64_t)mxGetScalar(in[0]), mxGetPr(in[1]), NULL, mxGetPr(out[0]), NULL, NULL, message,
                             sizeof message);
  }
  if (status != LDBENCH_OK) mexErrMsgTxt(message);
}
