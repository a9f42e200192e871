
#include <string.h>

/* The loop of a run: at a sample the controller reads the signals and commands inputs, which are held over the segment. It has
   as many inputs as the goal, the signals and its memory together, and writes its commands and its new memory.

   Returns how many segments are complete: all, or those before one in which no step is short enough.

   c, data: numbers and tables of the controller; count: segments; pieces of each; sampled: whether it begins with a sample;
   goals: count x GOALS; seen, seen_rates: count x INPUTS and RATES, inputs at these instants; times: of a segment its begin and
   the ends of its pieces; inputs, rates: the same times INPUTS, with commands filled in; x: states and energies, memory and
   commands: at the begin, and after the last complete segment; held: count x COMMANDS, filled; width, rows: as of `advance`. */
int march(const double *p, const double *k, const double *c, const double *data, int count, const int *pieces,
          const int *sampled, const double *goals, double *seen, const double *seen_rates, const double *times,
          double *inputs, const double *rates, double *x, double *memory, double *commands, double *held,
          double relative, const double *absolute, double *width, double *rows)
{
    double in[GOALS + SIGNALS + MEMORY + 1], out[COMMANDS + MEMORY + 1], now[COMMANDS + MEMORY + 1];
    memcpy(now, commands, COMMANDS * sizeof *now);
    memcpy(now + COMMANDS, memory, MEMORY * sizeof *now);
    for (int segment = 0; segment < count; segment++) {
        if (sampled[segment] && COMMANDS) {
            double *const u = seen + segment * INPUTS;
            for (int i = 0; i < COMMANDS; i++) {
                u[commanded[i]] = now[i];
            }
            memcpy(in, goals + segment * GOALS, GOALS * sizeof *in);
            signals(p, k, x, u, seen_rates + segment * RATES, in + GOALS);
            memcpy(in + GOALS + SIGNALS, now + COMMANDS, MEMORY * sizeof *in);
            controlled(c, data, in, out);
            memcpy(now, out, sizeof now);
        }
        for (int row = 0; row <= pieces[segment]; row++) {
            for (int i = 0; i < COMMANDS; i++) {
                inputs[row * INPUTS + commanded[i]] = now[i];
            }
        }
        if (advanced(p, k, pieces[segment], times, inputs, rates, x, relative, absolute, width, rows, 0)) {
            return segment;
        }
        rows += pieces[segment] * ALL;
        times += pieces[segment] + 1;
        inputs += (pieces[segment] + 1) * INPUTS;
        rates += (pieces[segment] + 1) * INPUTS;
        memcpy(x, rows - ALL, ALL * sizeof *x);
        memcpy(commands, now, COMMANDS * sizeof *now);
        memcpy(memory, now + COMMANDS, MEMORY * sizeof *now);
        memcpy(held + segment * COMMANDS, now, COMMANDS * sizeof *now);
    }
    return count;
}
