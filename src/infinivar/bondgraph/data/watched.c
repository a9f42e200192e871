/* As advance, with the steps taken, and what is watched at the end of each. */
int advance_watched(const double *p, const double *k, int count, const double *times, const double *inputs,
                    const double *input_rates, const double *x, double relative, const double *absolute, double *width,
                    double *rows, record *steps, double *found)
{
    steps->count = 0;
    const int status = advanced(p, k, count, times, inputs, input_rates, x, relative, absolute, width, rows, steps);
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
    return status;
}

void watched_at(const double *p, const double *k, const double *x, const double *u, const double *du, double *f)
{
    watched(p, k, x, u, du, f);
}
