
#include <string.h>

/* What the plant starts from: states, inputs and then their rates, parameters. */
void start(double *x, double *u, double *p)
{
    memcpy(x, start_states, sizeof start_states);
    memcpy(u, start_inputs, sizeof start_inputs);
    memcpy(p, start_given, sizeof start_given);
}

void outputs_at(const double *p, const double *k, const double *x, const double *u, const double *du, double *y)
{
    outputs(p, k, x, u, du, y);
}

/* dy: change of the states' derivatives, then of the outputs, by a change d of states, inputs and their rates. */
void directions_at(const double *p, const double *k, const double *x, const double *u, const double *du, const double *d, double *dy)
{
    directions(p, k, x, u, du, d, dy);
}
