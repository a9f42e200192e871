#include <string.h>

/* What is watched at the ends of the steps of a segment. */
static void watch(const double *p, const double *k, int count, const double *times, const double *inputs,
                  const double *input_rates, const record *steps, double *found)
{
    for (int n = 0, place = 0; n < steps->count && n < steps->most; n++) {
        const double *row = steps->rows + n * KEPT;
        double u[INPUTS + 1], du[RATES + 1];
        while (place < count - 1 && row[1] > times[place + 1]) {
            place++;
        }
        const piece one = {p, k, inputs + place * INPUTS, inputs + (place + 1) * INPUTS, input_rates + place * INPUTS,
                           input_rates + (place + 1) * INPUTS, times[place], times[place + 1]};
        inputs_at(&one, row[1], u, du);
        watched(p, k, row + 2 + SIZE, u, du, found + n * WATCHED);
    }
}

/* As advance, with the steps taken, and what is watched at the end of each. */
int advance_watched(const double *p, const double *k, int count, const double *times, const double *inputs,
                    const double *input_rates, const double *x, double relative, const double *absolute, double *width,
                    double *rows, record *steps, double *found)
{
    steps->count = 0;
    const int status = advanced(p, k, count, times, inputs, input_rates, x, relative, absolute, width, rows, steps);
    watch(p, k, count, times, inputs, input_rates, steps, found);
    return status;
}

/* A controller: numbers c and tables of its law, and how many numbers are known ahead of a sample, are inputs of the machine that
   it commands, are its memory, and are said beside; and whether it feels accelerations. The law reads what is known ahead (the
   time, what acts from outside, and more), derivatives of the states, states, and memory, and writes inputs, memory, and more. */
typedef struct {
    void (*law)(const double *c, const double *tables, const double *u, double *y);
    const double *c, *tables;
    int known, own, memory, said, feels;
} controller;

/* The loop of a run with a controller: at the begin of each segment it commands what acts until the next one.

   Returns how many segments are complete: all, or those before one that is left to the caller, as the law says no number there,
   no step is short enough, or no room is left for the steps.

   pieces of each segment; known: count x by->known; times: of a segment its begin and the ends of its pieces; inputs, rates: the
   same times INPUTS, filled with those commanded; x: states and energies, and kept: commands, memory and what is said, at the
   begin and after the last complete segment; held, ends: the same after each; taken: steps of each; found: of the steps;
   work: room for what the law reads. */
int march_watched(const double *p, const double *k, const controller *by, int count, const int *pieces, const double *known,
                  const double *times, double *inputs, const double *rates, double relative, const double *absolute,
                  double *width, double *x, double *kept, double *held, double *ends, int *taken, record *steps,
                  double *found, double *rows, double *work)
{
    const int all = by->own + by->memory + by->said;
    steps->count = 0;
    for (int segment = 0; segment < count; segment++) {
        double *const out = held + segment * all;
        double *in = work;
        const double before = *width;
        memcpy(in, known + segment * by->known, (size_t)by->known * sizeof *in);
        in += by->known;
        memset(in, 0, STATES * sizeof *in);
        if (by->feels) {
            double u[INPUTS + 1], du[RATES + 1] = {0.0};
            memcpy(u, kept, (size_t)by->own * sizeof *u);
            memcpy(u + by->own, work + 1, (size_t)(INPUTS - by->own) * sizeof *u);
            motion(p, k, x, u, du, in);
        }
        memcpy(in + STATES, x, STATES * sizeof *in);
        memcpy(in + 2 * STATES, kept + by->own, (size_t)by->memory * sizeof *in);
        by->law(by->c, by->tables, work, out);
        for (int i = 0; i < all; i++) {
            if (!isfinite(out[i])) {
                return segment;
            }
        }
        for (int row = 0; row <= pieces[segment]; row++) {
            memcpy(inputs + row * INPUTS, out, (size_t)by->own * sizeof *out);
        }
        record own = {0, steps->most - steps->count, steps->rows + steps->count * KEPT};
        if (own.most <= 0 || advanced(p, k, pieces[segment], times, inputs, rates, x, relative, absolute, width, rows, &own) ||
            own.count > own.most) {
            *width = before;
            return segment;
        }
        watch(p, k, pieces[segment], times, inputs, rates, &own, found + steps->count * WATCHED);
        steps->count += own.count;
        taken[segment] = own.count;
        memcpy(x, rows + (pieces[segment] - 1) * ALL, ALL * sizeof *x);
        memcpy(ends + segment * ALL, x, ALL * sizeof *x);
        memcpy(kept, out, (size_t)all * sizeof *kept);
        times += pieces[segment] + 1;
        inputs += (pieces[segment] + 1) * INPUTS;
        rates += (pieces[segment] + 1) * INPUTS;
    }
    return count;
}

void watched_at(const double *p, const double *k, const double *x, const double *u, const double *du, double *f)
{
    watched(p, k, x, u, du, f);
}
