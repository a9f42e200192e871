
/* Radau IIA collocation of three points, order 5: the stages of a step by Newton's method with the exact derivatives of the
   rates; the difference of one step and two halves is the error. Energies are states on which no rate depends: once the stages
   are known, they need no iteration. Source: hairer1996, section IV.8. */

enum { STAGES = 3, SIZE = STAGES * STATES, ALL = STATES + POWERS, END = ALL + SIZE, MOST_ITERATIONS = 8, MOST_STEPS = 100000 };

static const double nodes[STAGES] = {0.15505102572168219018, 0.64494897427831780982, 1.0};
static const double weights[STAGES][STAGES] = {
    {0.19681547722366042587, -0.065535425850198388, 0.023770974348220152},
    {0.39442431473908727700, 0.29207341166522846302, -0.041548752125997930},
    {0.37640306270046727506, 0.51248582618842161384, 0.11111111111111111111}};

static const double before_first[STAGES] = {1.5580782047249223824, -0.89141153805825571577, 0.33333333333333333333};
/* Weights of the points in the value of their polynomial at the begin. */

static const double layer = 1e-4;
/* What is missed there over the error it makes: that falls with the sixth power of a step, what is missed with the fourth. */

static const double calm = 0.03;
/* What is missed there in units of `layer` below which a step much shorter than allowed needs no halves to be believed. */

typedef struct {
    const double *p, *k, *first, *last, *first_rate, *last_rate;
    double begin, end;
} piece;

/* Steps taken, if anyone asks: begin, end, states before, states at the stages, and energies after each. Where there is no room
   for more, the last one takes the place of the one before. */
typedef struct {
    int count, most;
    double *rows;
} record;

enum { KEPT = 2 + ALL + SIZE };

static void kept(record *each, double begin, double end, const double *before, const double *found)
{
    if (each && each->most > 0) {
        double *row = each->rows + (each->count < each->most ? each->count : each->most - 1) * KEPT;
        each->count++;
        row[0] = begin;
        row[1] = end;
        for (int i = 0; i < STATES; i++) {
            row[2 + i] = before[i];
        }
        for (int i = 0; i < SIZE; i++) {
            row[2 + STATES + i] = found[ALL + i];
        }
        for (int i = 0; i < POWERS; i++) {
            row[2 + STATES + SIZE + i] = found[STATES + i];
        }
    }
}

/* Inputs and their rates: the cubic through both ends of a piece. */
static void inputs_at(const piece *one, double time, double *u, double *du)
{
    const double span = one->end - one->begin, share = (time - one->begin) / span;
    double speed[INPUTS + 1];
    for (int i = 0; i < INPUTS; i++) {
        const double bend = one->last[i] - one->first[i] - one->first_rate[i] * span;
        const double turn = (one->last_rate[i] - one->first_rate[i]) * span - 2.0 * bend;
        u[i] = one->first[i] + share * (one->first_rate[i] * span + share * (bend - turn + share * turn));
        speed[i] = one->first_rate[i] + share * (2.0 * (bend - turn) + 3.0 * share * turn) / span;
    }
    for (int i = 0; i < RATES; i++) {
        du[i] = speed[moving[i]];
    }
}

/* Not a number if one is none. */
static double larger(double one, double other)
{
    return one > other || one != one ? one : other;
}

/* Gauss elimination with pivots; 0 if the matrix is singular. */
static int factored(double *a, int *pivots)
{
    for (int column = 0; column < SIZE; column++) {
        int best = column;
        for (int row = column + 1; row < SIZE; row++) {
            if (fabs(a[row * SIZE + column]) > fabs(a[best * SIZE + column])) {
                best = row;
            }
        }
        pivots[column] = best;
        if (!(fabs(a[best * SIZE + column]) > 0.0)) {
            return 0;
        }
        if (best != column) {
            for (int i = 0; i < SIZE; i++) {
                const double held = a[column * SIZE + i];
                a[column * SIZE + i] = a[best * SIZE + i];
                a[best * SIZE + i] = held;
            }
        }
        for (int row = column + 1; row < SIZE; row++) {
            const double factor = a[row * SIZE + column] / a[column * SIZE + column];
            a[row * SIZE + column] = factor;
            for (int i = column + 1; factor != 0.0 && i < SIZE; i++) { /* most rates depend on few states */
                a[row * SIZE + i] -= factor * a[column * SIZE + i];
            }
        }
    }
    return 1;
}

static void solved(const double *a, const int *pivots, double *b)
{
    for (int row = 0; row < SIZE; row++) {
        const double held = b[pivots[row]];
        b[pivots[row]] = b[row];
        b[row] = held;
    }
    for (int i = 0; i < SIZE; i++) {
        for (int row = i + 1; row < SIZE; row++) {
            b[row] -= a[row * SIZE + i] * b[i];
        }
    }
    for (int row = SIZE - 1; row >= 0; row--) {
        for (int i = row + 1; i < SIZE; i++) {
            b[row] -= a[row * SIZE + i] * b[i];
        }
        b[row] /= a[row * SIZE + row];
    }
}

/* One step from x, which are states and energies, to the next, with the states at the stages behind them; 0 if the iteration does not converge. Changes are measured in units of the
   tolerances.

   missed, if not null: by how much the polynomial misses the rates and powers at the begin, where it has no point: it would step
   over a friction that changes within a few microseconds, and so would its halves. */
static int stepped(const piece *one, double time, double width, const double *x, const double *unit, double *next,
                   double *missed)
{
    double start[ALL], f[STAGES * ALL], u[STAGES][INPUTS + 1], du[STAGES][RATES + 1];
    double z[SIZE], change[SIZE], matrix[SIZE * SIZE], j[STATES * STATES], at[STATES];
    int pivots[SIZE];
    inputs_at(one, time, *u, *du);
    motion(one->p, one->k, x, *u, *du, start);
    if (missed) {
        powers(one->p, one->k, x, *u, *du, start + STATES);
    }
    for (int stage = 0; stage < STAGES; stage++) {
        inputs_at(one, time + nodes[stage] * width, u[stage], du[stage]);
        for (int i = 0; i < STATES; i++) {
            z[stage * STATES + i] = width * nodes[stage] * start[i];
        }
    }
    double before = 0.0;
    for (int iteration = 0; iteration < MOST_ITERATIONS; iteration++) {
        for (int stage = 0; stage < STAGES; stage++) {
            for (int i = 0; i < STATES; i++) {
                at[i] = x[i] + z[stage * STATES + i];
            }
            motion(one->p, one->k, at, u[stage], du[stage], f + stage * ALL);
            if (iteration < 1) { /* exact where the iteration begins, and close enough from then on */
                slopes(one->p, one->k, at, u[stage], du[stage], j);
                for (int row = 0; row < STAGES; row++) {
                    for (int i = 0; i < STATES; i++) {
                        for (int m = 0; m < STATES; m++) {
                            const int place = (row * STATES + i) * SIZE + stage * STATES + m;
                            matrix[place] = (row == stage && i == m ? 1.0 : 0.0) - width * weights[row][stage] * j[i * STATES + m];
                        }
                    }
                }
            }
        }
        for (int row = 0; row < STAGES; row++) {
            for (int i = 0; i < STATES; i++) {
                double sum = -z[row * STATES + i];
                for (int stage = 0; stage < STAGES; stage++) {
                    sum += width * weights[row][stage] * f[stage * ALL + i];
                }
                change[row * STATES + i] = sum;
            }
        }
        if (iteration < 1 && !factored(matrix, pivots)) {
            return 0;
        }
        solved(matrix, pivots, change);
        double largest = 0.0;
        for (int i = 0; i < SIZE; i++) {
            z[i] += change[i];
            largest = larger(fabs(change[i]) / unit[i % STATES], largest);
        }
        if (!(largest < 1e300)) {
            return 0;
        }
        if (largest < 1e-2 || (iteration > 1 && largest < 1.0 && largest >= before)) {
            for (int stage = 0; stage < STAGES; stage++) {
                for (int i = 0; i < STATES; i++) {
                    at[i] = x[i] + z[stage * STATES + i];
                }
                powers(one->p, one->k, at, u[stage], du[stage], f + stage * ALL + STATES);
            }
            for (int i = 0; i < ALL; i++) {
                double sum = 0.0;
                for (int stage = 0; stage < STAGES; stage++) {
                    sum += width * weights[STAGES - 1][stage] * f[stage * ALL + i];
                }
                next[i] = x[i] + (i < STATES ? z[(STAGES - 1) * STATES + i] : sum);
            }
            for (int i = 0; i < SIZE; i++) {
                next[ALL + i] = x[i % STATES] + z[i];
            }
            for (int i = 0; missed && i < ALL; i++) {
                double miss = start[i];
                for (int stage = 0; stage < STAGES; stage++) {
                    miss -= before_first[stage] * f[stage * ALL + i];
                }
                *missed = larger(width * fabs(miss) / unit[i], *missed);
            }
            return 1;
        }
        if (iteration > 2 && largest > 2.0 * before) {
            return 0;
        }
        before = largest;
    }
    return 0;
}

/* States and energies at the ends of pieces: 0, or 1 where no step is short enough, 2 where too many are needed.

   count: pieces; times: count + 1; inputs and their rates: (count + 1) x INPUTS; x: the states and the energies of sources and
   losses at the first time; absolute: their tolerances; rows: count x ALL, filled; width: the step to try first, and the one to
   go on with; each: null, or where to keep the steps. */
static int advanced(const double *p, const double *k, int count, const double *times, const double *inputs,
                    const double *input_rates, const double *x, double relative, const double *absolute, double *width,
                    double *rows, record *each)
{
    double now[ALL], whole[END], half[END], two[END], unit[ALL];
    int steps = 0;
    for (int i = 0; i < ALL; i++) {
        now[i] = x[i];
    }
    for (int place = 0; place < count; place++) {
        const piece one = {p, k, inputs + place * INPUTS, inputs + (place + 1) * INPUTS, input_rates + place * INPUTS,
                           input_rates + (place + 1) * INPUTS, times[place], times[place + 1]};
        double time = one.begin;
        while (time < one.end) {
            const double left = one.end - time;
            const int last = !(*width < left * (1.0 - 1e-9));
            const double taken = last ? left : *width;
            if (++steps > MOST_STEPS) {
                return 2;
            }
            for (int i = 0; i < ALL; i++) {
                unit[i] = absolute[i] + relative * fabs(now[i]);
            }
            double error = INFINITY, missed = 0.0;
            const double *found = two;
            const int done = stepped(&one, time, taken, now, unit, whole, &missed);
            if (done && 2.0 * taken < *width && layer * missed < calm) { /* half as long as the last error allows */
                error = 0.0;
                found = whole;
            } else if (done &&
                stepped(&one, time, 0.5 * taken, now, unit, half, 0) &&
                stepped(&one, time + 0.5 * taken, 0.5 * taken, half, unit, two, 0)) {
                error = pow(layer * missed, 1.5);
                for (int i = 0; i < ALL; i++) {
                    error = larger(fabs(two[i] - whole[i]) / (31.0 * unit[i]), error);
                }
            }
            if (!(error <= 1.0)) {
                const double less = error < 1e300 ? 0.9 * pow(error, -1.0 / 6.0) : 0.1;
                *width = taken * (less > 0.1 ? less : 0.1);
                if (!(*width > 1e-12 * (times[count] - times[0]) + 1e-15)) {
                    return 1;
                }
                continue;
            }
            if (found == two) {
                const double more = error > 0.0 ? 0.9 * pow(error, -1.0 / 6.0) : 4.0;
                const double next = taken * (more < 4.0 ? more : 4.0);
                *width = last && next < *width ? *width : next; /* a step cut short by the end says nothing of longer ones */
            }
            const double reached = last ? one.end : time + taken;
            if (found == two) {
                kept(each, time, time + 0.5 * taken, now, half);
                kept(each, time + 0.5 * taken, reached, half, two);
            } else {
                kept(each, time, reached, now, whole);
            }
            time = reached;
            for (int i = 0; i < ALL; i++) {
                now[i] = found[i];
            }
        }
        for (int i = 0; i < ALL; i++) {
            rows[place * ALL + i] = now[i];
        }
    }
    return 0;
}

int advance(const double *p, const double *k, int count, const double *times, const double *inputs, const double *input_rates,
            const double *x, double relative, const double *absolute, double *width, double *rows)
{
    return advanced(p, k, count, times, inputs, input_rates, x, relative, absolute, width, rows, 0);
}

void rates_at(const double *p, const double *k, const double *x, const double *u, const double *du, double *f)
{
    motion(p, k, x, u, du, f);
}

void powers_at(const double *p, const double *k, const double *x, const double *u, const double *du, double *f)
{
    powers(p, k, x, u, du, f);
}

void slopes_at(const double *p, const double *k, const double *x, const double *u, const double *du, double *j)
{
    slopes(p, k, x, u, du, j);
}

void signals_at(const double *p, const double *k, const double *x, const double *u, const double *du, double *s)
{
    signals(p, k, x, u, du, s);
}
