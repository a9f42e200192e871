
/* One plant in motion, and what both versions of the interface do with it. Functions return 0, or what is wrong. */

#include <stdlib.h>
#include <string.h>

enum {
    KNOWN = STATES + INPUTS + RATES,
    AT_STATES = 1,
    AT_DERIVATIVES = AT_STATES + STATES,
    AT_INPUTS = AT_DERIVATIVES + STATES,
    AT_OUTPUTS = AT_INPUTS + INPUTS + RATES,
    AT_PARAMETERS = AT_OUTPUTS + OUTPUTS,
    AT_GOALS = AT_PARAMETERS + PARAMETERS,
    AT_END = AT_GOALS + SHOWN,
    NAME_LETTERS = 64,
    TOKEN_LETTERS = (sizeof token + 7) / 8 * 8
};
/* Value references: time, states, their derivatives, inputs, rates of inputs, outputs, parameters, goal of the controller. */

/* Of an instance: made, initialising, running, ended; values are known from initialising on. */
enum { MADE = 1, INITIALISING = 2, RUNNING = 4, ENDED = 8, SETTABLE = MADE | INITIALISING | RUNNING, ANY = SETTABLE | ENDED,
       KNOWS = INITIALISING | RUNNING | ENDED };

typedef struct {
    double mode, time, width, p[GIVEN], x[STATES], u[INPUTS + RATES + 1];
    double begin, samples, goal[SHOWN + 1], memory[MEMORY + 1]; /* of the controller: begin and number of its samples */
} situation;

/* A situation as bytes: those of another model, or of none, are refused. */
typedef struct {
    char token[TOKEN_LETTERS];
    double size;
    situation now;
} written;

typedef struct {
    situation now;
    double k[CONSTANTS + 1], tolerance;
    char name[NAME_LETTERS];
    void *environment;
    void (*log)(void); /* of the version's own type */
} plant;

static const double usual_tolerance = 1e-8;
static const double same_time = 1e-6; /* of a sample's period: instants closer than this are one */
static const double rounding = 1e-9; /* of a time, over it: importers add up steps */

static const char *started(plant *one)
{
    memset(&one->now, 0, sizeof one->now);
    one->now.mode = MADE;
    memcpy(one->now.p, start_given, sizeof start_given);
    memcpy(one->now.x, start_states, sizeof start_states);
    memcpy(one->now.u, start_inputs, (INPUTS + RATES) * sizeof(double));
    memcpy(one->now.goal, start_goal, SHOWN * sizeof(double));
    memcpy(one->now.memory, start_memory, MEMORY * sizeof(double));
    one->now.samples = BEGUN;
    one->tolerance = usual_tolerance;
    constants(one->now.p, one->k);
    return NULL;
}

static plant *made(const char *name, const char *given_token, const char *known_token)
{
    plant *one = given_token && !strcmp(given_token, known_token) ? malloc(sizeof *one) : NULL;
    if (one) {
        memset(one, 0, sizeof *one);
        strncpy(one->name, name ? name : "", NAME_LETTERS - 1);
        started(one);
    }
    return one;
}

static int all_finite(const double *values, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (!isfinite(values[i])) {
            return 0;
        }
    }
    return 1;
}

static void rates_now(const plant *one, double *f)
{
    motion(one->now.p, one->k, one->now.x, one->now.u, one->now.u + INPUTS, f);
}

static const char *get(const plant *one, const unsigned *references, size_t count, double *values)
{
    double f[STATES], y[OUTPUTS];
    int moved = 0, written = 0;
    for (size_t i = 0; i < count; i++) {
        const unsigned at = references[i];
        if (at >= AT_END) {
            return "no variable has this value reference";
        }
        if (at >= AT_DERIVATIVES && at < AT_INPUTS && !moved++) {
            rates_now(one, f);
        }
        if (at >= AT_OUTPUTS && at < AT_PARAMETERS && !written++) {
            outputs(one->now.p, one->k, one->now.x, one->now.u, one->now.u + INPUTS, y);
        }
        values[i] = at < AT_STATES        ? one->now.time
                    : at < AT_DERIVATIVES ? one->now.x[at - AT_STATES]
                    : at < AT_INPUTS      ? f[at - AT_DERIVATIVES]
                    : at < AT_OUTPUTS     ? one->now.u[at - AT_INPUTS]
                    : at < AT_PARAMETERS  ? y[at - AT_OUTPUTS]
                    : at < AT_GOALS       ? one->now.p[at - AT_PARAMETERS]
                                          : one->now.goal[at - AT_GOALS];
        moved = moved > 0;
        written = written > 0;
    }
    return all_finite(values, count) ? NULL : "a value is not finite";
}

static int is_commanded(unsigned input)
{
    for (int i = 0; i < COMMANDS; i++) {
        if (input == (unsigned)commanded[i]) {
            return 1;
        }
    }
    return 0;
}

/* All values or none. */
static const char *set(plant *one, const unsigned *references, size_t count, const double *values)
{
    int tuned = 0;
    if (!all_finite(values, count)) {
        return "a value to set is not finite";
    }
    for (size_t i = 0; i < count; i++) {
        const unsigned at = references[i];
        const int is_state = at >= AT_STATES && at < AT_DERIVATIVES, is_input = at >= AT_INPUTS && at < AT_OUTPUTS;
        const int is_parameter = at >= AT_PARAMETERS && at < AT_GOALS, is_goal = at >= AT_GOALS && at < AT_END;
        if (!is_state && !(is_input && !is_commanded(at - AT_INPUTS)) && !(is_parameter && settable[at - AT_PARAMETERS]) &&
            !is_goal) {
            return "this variable cannot be set";
        }
        if (is_parameter && !(values[i] >= least[at - AT_PARAMETERS] && values[i] <= most[at - AT_PARAMETERS])) {
            return "a parameter to set is not within its min and max";
        }
        tuned |= is_parameter;
    }
    for (size_t i = 0; i < count; i++) {
        const unsigned at = references[i];
        double *const place = at < AT_DERIVATIVES ? one->now.x + (at - AT_STATES)
                              : at < AT_OUTPUTS   ? one->now.u + (at - AT_INPUTS)
                              : at < AT_GOALS     ? one->now.p + (at - AT_PARAMETERS)
                                                  : one->now.goal + (at - AT_GOALS);
        *place = values[i];
    }
    if (tuned) {
        constants(one->now.p, one->k);
    }
    return NULL;
}

static const char *set_states(plant *one, const double *states, size_t count)
{
    if (count != STATES || !all_finite(states, count)) {
        return "states to set are not finite, or not as many as there are";
    }
    memcpy(one->now.x, states, sizeof one->now.x);
    return NULL;
}

static const char *get_states(const plant *one, double *states, size_t count)
{
    if (count != STATES) {
        return "there are not that many states";
    }
    memcpy(states, one->now.x, sizeof one->now.x);
    return NULL;
}

static const char *get_nominals(double *nominals, size_t count)
{
    if (count != STATES) {
        return "there are not that many states";
    }
    for (size_t i = 0; i < count; i++) {
        nominals[i] = 1.0;
    }
    return NULL;
}

static const char *get_rates(const plant *one, double *rates, size_t count)
{
    if (count != STATES) {
        return "there are not that many states";
    }
    rates_now(one, rates);
    return all_finite(rates, count) ? NULL : "the derivative of a state is not finite";
}

/* Change of unknowns by a change of knowns: derivatives and outputs by states, inputs and their rates. */
static const char *get_direction(const plant *one, const unsigned *unknowns, size_t unknown_count, const unsigned *knowns,
                                 size_t known_count, const double *seed, double *change)
{
    double d[KNOWN] = {0.0}, dy[STATES + OUTPUTS];
    for (size_t i = 0; i < known_count; i++) {
        const unsigned at = knowns[i];
        const int is_state = at >= AT_STATES && at < AT_DERIVATIVES;
        if (at >= AT_GOALS && at < AT_END) {
            continue; /* the controller sees it at its next sample */
        }
        if (!is_state && !(at >= AT_INPUTS && at < AT_OUTPUTS)) {
            return "derivatives are known by states and inputs only";
        }
        d[is_state ? at - AT_STATES : STATES + (at - AT_INPUTS)] += seed[i];
    }
    directions(one->now.p, one->k, one->now.x, one->now.u, one->now.u + INPUTS, d, dy);
    for (size_t i = 0; i < unknown_count; i++) {
        const unsigned at = unknowns[i];
        if (at >= AT_STATES && at < AT_DERIVATIVES) {
            change[i] = d[at - AT_STATES];
        } else if (at >= AT_DERIVATIVES && at < AT_INPUTS) {
            change[i] = dy[at - AT_DERIVATIVES];
        } else if (at >= AT_OUTPUTS && at < AT_PARAMETERS) {
            change[i] = dy[STATES + (at - AT_OUTPUTS)];
        } else {
            return "derivatives are known of states' derivatives and outputs only";
        }
    }
    return all_finite(change, unknown_count) ? NULL : "a derivative is not finite";
}

/* Time of the next sample of the controller. */
static double next_sample(const situation *now)
{
    return now->begin + now->samples * period;
}

/* A sample of the controller, if it is due: what it commands is held. Until then, the goal has moved on for some time. */
static const char *sample(situation *now, const double *k, double since)
{
    double in[GOALS + SIGNALS + MEMORY + 1] = {0.0}, out[COMMANDS + MEMORY + 1];
    if (!COMMANDS || now->time < next_sample(now) - same_time * period) {
        return NULL;
    }
    in[0] = now->time - now->begin;
    memcpy(in + 1, now->goal, SHOWN * sizeof *in);
    if (SHOWN > 2) {
        in[1] += since * (in[2] + 0.5 * since * in[3]);
        in[2] += since * in[3];
    }
    signals(now->p, k, now->x, now->u, now->u + INPUTS, in + GOALS);
    memcpy(in + GOALS + SIGNALS, now->memory, MEMORY * sizeof *in);
    controlled(NULL, control_data, in, out);
    if (!all_finite(out, COMMANDS + MEMORY)) {
        return "the formula of the controller has no number here";
    }
    for (int i = 0; i < COMMANDS; i++) {
        now->u[commanded[i]] = out[i];
    }
    memcpy(now->memory, out + COMMANDS, MEMORY * sizeof *out);
    now->samples = floor((now->time - now->begin) / period + same_time) + 1.0;
    return NULL;
}

/* The plant moves on with inputs that are held; those with a rate go on with it. */
static const char *integrated(situation *now, const double *k, double tolerance, double step)
{
    double first[2 * INPUTS + 1] = {0.0}, rates[2 * INPUTS + 1] = {0.0}, begin[ALL] = {0.0}, rows[ALL], absolute[ALL];
    const double times[2] = {0.0, step};
    double width = now->width > 0.0 ? now->width : 0.1 * step;
    for (int i = 0; i < INPUTS; i++) {
        first[i] = first[INPUTS + i] = now->u[i];
    }
    for (int i = 0; i < RATES; i++) {
        const double rate = now->u[INPUTS + i];
        first[INPUTS + moving[i]] += rate * step;
        rates[moving[i]] = rates[INPUTS + moving[i]] = rate;
    }
    for (int i = 0; i < ALL; i++) { /* energies are not kept, and shorten no step */
        absolute[i] = i < STATES ? tolerance : 1e300;
    }
    memcpy(begin, now->x, STATES * sizeof *begin);
    if (advance(now->p, k, 1, times, first, rates, begin, tolerance, absolute, &width, rows) || !all_finite(rows, STATES)) {
        return "no step is short enough";
    }
    memcpy(now->x, rows, STATES * sizeof *rows);
    for (int i = 0; i < INPUTS; i++) {
        now->u[i] = first[INPUTS + i];
    }
    now->width = width;
    return NULL;
}

/* A communication step, in pieces between the samples of the controller. Nothing changes where it fails. */
static const char *moved_on(plant *one, double time, double step)
{
    situation now = one->now;
    const double end = time + step;
    if (!(isfinite(time) && isfinite(step) && step > 0.0)) {
        return "a step must be > 0 s";
    }
    if (!(fabs(time - now.time) <= rounding * (fabs(time) + step))) {
        return "a step must begin at the time that the model has reached; to go back, set a state of then first";
    }
    now.time = time;
    while (now.time < end) {
        const char *problem = sample(&now, one->k, now.time - time);
        const double next = next_sample(&now), left = COMMANDS && next < end - same_time * period ? next - now.time : end - now.time;
        problem = problem ? problem : integrated(&now, one->k, one->tolerance, left);
        if (problem) {
            return problem;
        }
        now.time = left < end - now.time ? next : end;
    }
    one->now = now;
    return NULL;
}

/* Events are the samples of the controller. */
static const char *event(plant *one, double *next)
{
    const char *problem = sample(&one->now, one->k, 0.0);
    *next = next_sample(&one->now);
    return problem;
}

static const char *set_time(plant *one, double time)
{
    if (!isfinite(time)) {
        return "time is not finite";
    }
    one->now.time = time;
    return NULL;
}

static const char *set_up(plant *one, int defined, double tolerance, double time, int ends, double stop)
{
    if (defined && !(isfinite(tolerance) && tolerance > 0.0)) {
        return "a tolerance must be > 0";
    }
    if (ends && !(isfinite(stop) && stop >= time)) {
        return "the stop must not be before the start";
    }
    one->tolerance = defined && tolerance >= 1e-12 && tolerance <= 1e-2 ? tolerance : usual_tolerance;
    one->now.begin = isfinite(time) ? time : 0.0;
    return set_time(one, time);
}

static const char *enter(plant *one, int mode)
{
    one->now.mode = mode;
    return NULL;
}

/* What is wrong with a call in the mode of an instance, if it is none of some. */
static const char *refused(const plant *one, int modes)
{
    const int mode = one ? (int)one->now.mode : modes;
    return mode & modes                      ? NULL
           : mode == ENDED                   ? "this call is not allowed once the model is terminated"
           : modes & (INITIALISING | RUNNING) ? "this call is not allowed before the model is initialised"
                                             : "this call is not allowed once the model is initialised, or initialises";
}

/* The state of an FMU: a copy of the situation. */
static const char *keep(const plant *one, void **state)
{
    if (!*state) {
        *state = malloc(sizeof one->now);
    }
    if (!*state) {
        return "no memory";
    }
    memcpy(*state, &one->now, sizeof one->now);
    return NULL;
}

static const char *take_back(plant *one, const void *state)
{
    if (!state) {
        return "there is no state";
    }
    memcpy(&one->now, state, sizeof one->now);
    constants(one->now.p, one->k);
    return NULL;
}

static const char *drop(void **state)
{
    free(*state);
    *state = NULL;
    return NULL;
}

static const char *say_size(size_t *size)
{
    *size = sizeof(written);
    return NULL;
}

static const char *to_bytes(const void *state, void *bytes, size_t size)
{
    written kept;
    if (!state || size < sizeof kept) {
        return "there is no state, or too little room";
    }
    memset(&kept, 0, sizeof kept);
    memcpy(kept.token, token, sizeof token);
    kept.size = sizeof(situation);
    memcpy(&kept.now, state, sizeof kept.now);
    memcpy(bytes, &kept, sizeof kept);
    return NULL;
}

static const char *from_bytes(const void *bytes, size_t size, void **state)
{
    written kept;
    double values[sizeof(situation) / sizeof(double)];
    if (size != sizeof kept) {
        return "these bytes are no state of this model";
    }
    memcpy(&kept, bytes, size);
    memcpy(values, &kept.now, sizeof values);
    if (memcmp(kept.token, token, sizeof token) || kept.size != sizeof(situation)) {
        return "these bytes are no state of this model";
    }
    if (!all_finite(values, sizeof values / sizeof *values)) {
        return "a value of the state is not finite";
    }
    if (kept.now.mode != MADE && kept.now.mode != INITIALISING && kept.now.mode != RUNNING && kept.now.mode != ENDED) {
        return "these bytes are no state of this model";
    }
    if (!*state) {
        *state = malloc(sizeof(situation));
    }
    if (!*state) {
        return "no memory";
    }
    memcpy(*state, &kept.now, sizeof(situation));
    return NULL;
}

#if defined FMI2_FUNCTION_PREFIX
#define PREFIX FMI2_FUNCTION_PREFIX
#elif defined FMI3_FUNCTION_PREFIX
#define PREFIX FMI3_FUNCTION_PREFIX
#else
#define PREFIX
#endif
#define JOINED(one, other) one##other
#define PREFIXED(one, other) JOINED(one, other)
#define NAMED(name) PREFIXED(PREFIX, name)
#if defined _WIN32
#define API(type) __declspec(dllexport) type
#elif defined __GNUC__
#define API(type) __attribute__((visibility("default"))) type
#else
#define API(type) type
#endif

enum { OK = 0, ERROR = 3 };

/* A function of the interface that calls one of this file, in some modes. */
#define CALL(modes, name, arguments, call) \
    API(int) OWN(name) arguments \
    { \
        const char *const problem = refused(one, modes); \
        return said(one, one && !problem ? call : problem); \
    }

/* One that the model has no use for: an error. The last argument uses the others. */
#define REFUSED(name, arguments, why, used) \
    API(int) OWN(name) arguments { used return said(one, why); }
