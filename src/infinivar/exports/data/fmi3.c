
/* FMI 3.0, Model Exchange and Co-Simulation. Types are those of the standard's headers in plain C, so that the
   sources need no other file: fmi3Instance is plant *, fmi3Status int. Source: fmi2022, chapters 2 to 4. */

#include <stdbool.h>
#include <stdint.h>

typedef void (*logger)(void *, int, const char *, const char *);

#define OWN(name) NAMED(fmi3##name)

static int said(const plant *one, const char *problem)
{
    if (problem && one && one->log) {
        ((logger)one->log)(one->environment, ERROR, "logStatusError", problem);
    }
    return problem || !one ? ERROR : OK;
}

static plant *instance(const char *name, const char *known, void *environment, logger log)
{
    plant *one = made(name, known, token);
    if (one) {
        one->environment = environment;
        one->log = (void (*)(void))log;
    }
    return one;
}

API(const char *) OWN(GetVersion)(void) { return "3.0"; }

API(plant *) OWN(InstantiateModelExchange)(const char *name, const char *known, const char *place, bool visible, bool logging,
                                           void *environment, logger log)
{
    (void)place; (void)visible; (void)logging;
    return instance(name, known, environment, log);
}

API(plant *) OWN(InstantiateCoSimulation)(const char *name, const char *known, const char *place, bool visible, bool logging,
                                          bool events, bool early, const unsigned *between, size_t count,
                                          void *environment, logger log, void (*update)(void))
{
    (void)place; (void)visible; (void)logging; (void)events; (void)early; (void)between; (void)count; (void)update;
    return instance(name, known, environment, log);
}

API(plant *) OWN(InstantiateScheduledExecution)(const char *name, const char *known, const char *place, bool visible,
                                                bool logging, void *environment, logger log, void (*clock)(void),
                                                void (*lock)(void), void (*unlock)(void))
{
    (void)name; (void)known; (void)place; (void)visible; (void)logging; (void)clock; (void)lock; (void)unlock;
    if (log) {
        log(environment, ERROR, "logStatusError", "the model has no clocks");
    }
    return NULL;
}

API(int) OWN(SetDebugLogging)(plant *one, bool on, size_t count, const char *const *categories)
{
    (void)on; (void)count; (void)categories;
    return said(one, NULL);
}

API(int) OWN(EnterInitializationMode)(plant *one, bool defined, double tolerance, double start, bool ends, double stop)
{
    const char *problem = refused(one, MADE);
    if (one && !problem) {
        problem = set_up(one, defined, tolerance, start, ends, stop);
        enter(one, problem ? MADE : INITIALISING);
    }
    return said(one, problem);
}

CALL(RUNNING, EnterStepMode, (plant *one), NULL)
CALL(RUNNING, EvaluateDiscreteStates, (plant *one), NULL)

static const char *const too_few = "there are not as many values as variables";

CALL(KNOWS, GetFloat64, (plant *one, const unsigned *references, size_t count, double *values, size_t size),
     size == count ? get(one, references, count, values) : too_few)
CALL(SETTABLE, SetFloat64, (plant *one, const unsigned *references, size_t count, const double *values, size_t size),
     size == count ? set(one, references, count, values) : too_few)

/* The model has variables of type Float64 only. */
static const char *const other_type = "the model has variables of type Float64 only";

#define NO_VARIABLES(type, got, put) \
    REFUSED(got, (plant *one, const unsigned *references, size_t count, type *values, size_t size), count ? other_type : NULL, \
            (void)references; (void)values; (void)size;) \
    REFUSED(put, (plant *one, const unsigned *references, size_t count, const type *values, size_t size), \
            count ? other_type : NULL, (void)references; (void)values; (void)size;)
typedef const char *text;
NO_VARIABLES(float, GetFloat32, SetFloat32)
NO_VARIABLES(int8_t, GetInt8, SetInt8)
NO_VARIABLES(uint8_t, GetUInt8, SetUInt8)
NO_VARIABLES(int16_t, GetInt16, SetInt16)
NO_VARIABLES(uint16_t, GetUInt16, SetUInt16)
NO_VARIABLES(int32_t, GetInt32, SetInt32)
NO_VARIABLES(uint32_t, GetUInt32, SetUInt32)
NO_VARIABLES(int64_t, GetInt64, SetInt64)
NO_VARIABLES(uint64_t, GetUInt64, SetUInt64)
NO_VARIABLES(bool, GetBoolean, SetBoolean)
NO_VARIABLES(text, GetString, SetString)
REFUSED(GetBinary, (plant *one, const unsigned *references, size_t count, size_t *sizes, const uint8_t **values, size_t size),
        count ? other_type : NULL, (void)references; (void)sizes; (void)values; (void)size;)
REFUSED(SetBinary,
        (plant *one, const unsigned *references, size_t count, const size_t *sizes, const uint8_t *const *values, size_t size),
        count ? other_type : NULL, (void)references; (void)sizes; (void)values; (void)size;)
REFUSED(GetClock, (plant *one, const unsigned *references, size_t count, bool *values), count ? other_type : NULL,
        (void)references; (void)values;)
REFUSED(SetClock, (plant *one, const unsigned *references, size_t count, const bool *values), count ? other_type : NULL,
        (void)references; (void)values;)

CALL(ANY, GetFMUState, (plant *one, void **state), keep(one, state))
CALL(ANY, SetFMUState, (plant *one, void *state), take_back(one, state))

CALL(ANY, FreeFMUState, (plant *one, void **state), drop(state))
API(int) OWN(SerializedFMUStateSize)(plant *one, void *state, size_t *size)
{
    (void)state;
    return said(one, say_size(size));
}

CALL(ANY, SerializeFMUState, (plant *one, void *state, uint8_t *bytes, size_t size), to_bytes(state, bytes, size))
CALL(ANY, DeserializeFMUState, (plant *one, const uint8_t *bytes, size_t size, void **state), from_bytes(bytes, size, state))

CALL(KNOWS, GetDirectionalDerivative,
     (plant *one, const unsigned *unknowns, size_t unknown_count, const unsigned *knowns, size_t known_count, const double *seed,
      size_t seed_size, double *change, size_t change_size),
     seed_size == known_count && change_size == unknown_count
         ? get_direction(one, unknowns, unknown_count, knowns, known_count, seed, change)
         : too_few)
REFUSED(GetAdjointDerivative,
        (plant *one, const unsigned *unknowns, size_t unknown_count, const unsigned *knowns, size_t known_count, const double *seed,
         size_t seed_size, double *change, size_t change_size),
        "use directional derivatives", (void)unknowns; (void)unknown_count; (void)knowns; (void)known_count; (void)seed;
        (void)seed_size; (void)change; (void)change_size;)
REFUSED(GetNumberOfVariableDependencies, (plant *one, unsigned reference, size_t *count), "dependencies do not change",
        (void)reference; (void)count;)
REFUSED(GetVariableDependencies,
        (plant *one, unsigned reference, size_t *elements, unsigned *knowns, size_t *known_elements, int *kinds, size_t count),
        "dependencies do not change", (void)reference; (void)elements; (void)knowns; (void)known_elements; (void)kinds; (void)count;)

/* The model has neither structural parameters nor clocks. */
static const char *const no_clock = "the model has no clocks";

REFUSED(EnterConfigurationMode, (plant *one), "the model has no structural parameters", ;)
REFUSED(ExitConfigurationMode, (plant *one), "the model has no structural parameters", ;)
REFUSED(GetIntervalDecimal, (plant *one, const unsigned *references, size_t count, double *intervals, int *qualifiers), no_clock,
        (void)references; (void)count; (void)intervals; (void)qualifiers;)
REFUSED(GetIntervalFraction,
        (plant *one, const unsigned *references, size_t count, uint64_t *counters, uint64_t *resolutions, int *qualifiers), no_clock,
        (void)references; (void)count; (void)counters; (void)resolutions; (void)qualifiers;)
#define NO_CLOCK(decimal, fraction, kind) \
    REFUSED(decimal, (plant *one, const unsigned *references, size_t count, kind double *values), no_clock, \
            (void)references; (void)count; (void)values;) \
    REFUSED(fraction, (plant *one, const unsigned *references, size_t count, kind uint64_t *counters, kind uint64_t *resolutions), \
            no_clock, (void)references; (void)count; (void)counters; (void)resolutions;)
NO_CLOCK(GetShiftDecimal, GetShiftFraction, )
NO_CLOCK(SetShiftDecimal, SetShiftFraction, const)
NO_CLOCK(SetIntervalDecimal, SetIntervalFraction, const)
REFUSED(ActivateModelPartition, (plant *one, unsigned clock, double time), no_clock, (void)clock; (void)time;)

API(int) OWN(UpdateDiscreteStates)(plant *one, bool *again, bool *terminates, bool *nominals, bool *states, bool *defined,
                                   double *next)
{
    *again = *terminates = *nominals = *states = *defined = false;
    *next = 0.0;
    const char *problem = refused(one, RUNNING);
    if (one && !problem) {
        problem = event(one, next);
        *defined = COMMANDS > 0;
    }
    return said(one, problem);
}

/* Model Exchange */

API(int) OWN(CompletedIntegratorStep)(plant *one, bool past, bool *event_mode, bool *terminates)
{
    (void)past;
    *event_mode = *terminates = false;
    return said(one, refused(one, RUNNING));
}

CALL(KNOWS, GetContinuousStateDerivatives, (plant *one, double *rates, size_t count), get_rates(one, rates, count))
API(int) OWN(GetNumberOfEventIndicators)(plant *one, size_t *count)
{
    *count = 0;
    return said(one, NULL);
}

API(int) OWN(GetNumberOfContinuousStates)(plant *one, size_t *count)
{
    *count = STATES;
    return said(one, NULL);
}

/* Co-Simulation */

API(int) OWN(DoStep)(plant *one, double time, double step, bool final, bool *event, bool *terminates, bool *early,
                     double *reached)
{
    const char *problem = refused(one, RUNNING);
    (void)final;
    problem = one && !problem ? moved_on(one, time, step) : problem;
    *event = *terminates = *early = false;
    *reached = problem || !one ? time : time + step;
    return said(one, problem);
}

REFUSED(GetOutputDerivatives,
        (plant *one, const unsigned *references, size_t count, const int32_t *orders, double *values, size_t size),
        count ? "derivatives of outputs are not computed" : NULL, (void)references; (void)orders; (void)values; (void)size;)
