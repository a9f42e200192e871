
/* FMI 2.0, Model Exchange and Co-Simulation. Types are those of the standard's headers, in plain C: fmi2Component is plant *,
   fmi2Status int. Source: fmi2014, chapters 2 to 4. */

typedef void (*logger)(void *, const char *, int, const char *, const char *, ...);

typedef struct {
    logger log;
    void *(*allocate)(size_t, size_t);
    void (*free)(void *);
    void (*step_finished)(void *, int);
    void *environment;
} callbacks;

static int said(const plant *one, const char *problem)
{
    if (problem && one && one->log) {
        ((logger)one->log)(one->environment, one->name, ERROR, "logStatusError", "%s", problem);
    }
    return problem || !one ? ERROR : OK;
}

API(const char *) NAMED(fmi2GetTypesPlatform)(void) { return "default"; }
API(const char *) NAMED(fmi2GetVersion)(void) { return "2.0"; }

API(plant *) NAMED(fmi2Instantiate)(const char *name, int kind, const char *guid, const char *place, const callbacks *called,
                                    int visible, int logging)
{
    plant *one = made(name, guid, token);
    (void)kind; (void)place; (void)visible; (void)logging;
    if (one && called) {
        one->log = (void (*)(void))called->log;
        one->environment = called->environment;
    }
    return one;
}

API(void) NAMED(fmi2FreeInstance)(plant *one) { free(one); }

API(int) NAMED(fmi2SetDebugLogging)(plant *one, int on, size_t count, const char *const *categories)
{
    (void)on; (void)count; (void)categories;
    return said(one, NULL);
}

API(int) NAMED(fmi2SetupExperiment)(plant *one, int defined, double tolerance, double start, int ends, double stop)
{
    (void)ends; (void)stop;
    if (one) {
        set_tolerance(one, defined, tolerance);
    }
    return said(one, one ? set_time(one, start) : NULL);
}

#define PHASE(name) \
    API(int) NAMED(name)(plant *one) { return said(one, NULL); }
PHASE(fmi2EnterInitializationMode)
PHASE(fmi2ExitInitializationMode)
PHASE(fmi2Terminate)
PHASE(fmi2EnterEventMode)
PHASE(fmi2EnterContinuousTimeMode)

API(int) NAMED(fmi2Reset)(plant *one)
{
    if (one) {
        started(one);
    }
    return said(one, NULL);
}

CALL(fmi2GetReal, (plant *one, const unsigned *references, size_t count, double *values),
     get(one, references, count, values))

CALL(fmi2SetReal, (plant *one, const unsigned *references, size_t count, const double *values),
     set(one, references, count, values))

static const char *const other_type = "the model has variables of type Real only";

#define NO_VARIABLES(type, got, put) \
    REFUSED(got, (plant *one, const unsigned *references, size_t count, type *values), count ? other_type : NULL, \
            (void)references; (void)values;) \
    REFUSED(put, (plant *one, const unsigned *references, size_t count, const type *values), count ? other_type : NULL, \
            (void)references; (void)values;)
typedef const char *text;
NO_VARIABLES(int, fmi2GetInteger, fmi2SetInteger)
NO_VARIABLES(int, fmi2GetBoolean, fmi2SetBoolean)
NO_VARIABLES(text, fmi2GetString, fmi2SetString)

CALL(fmi2GetFMUstate, (plant *one, void **state), keep(one, state))
CALL(fmi2SetFMUstate, (plant *one, void *state), take_back(one, state))

API(int) NAMED(fmi2FreeFMUstate)(plant *one, void **state)
{
    if (state) {
        free(*state);
        *state = NULL;
    }
    return said(one, NULL);
}

API(int) NAMED(fmi2SerializedFMUstateSize)(plant *one, void *state, size_t *size)
{
    (void)state;
    *size = sizeof(situation);
    return said(one, NULL);
}

CALL(fmi2SerializeFMUstate, (plant *one, void *state, char *bytes, size_t size), to_bytes(state, bytes, size))
CALL(fmi2DeSerializeFMUstate, (plant *one, const char *bytes, size_t size, void **state), from_bytes(bytes, size, state))

CALL(fmi2GetDirectionalDerivative, (plant *one, const unsigned *unknowns, size_t unknown_count, const unsigned *knowns,
                                             size_t known_count, const double *seed, double *change),
     get_direction(one, unknowns, unknown_count, knowns, known_count, seed, change))

/* Model Exchange */

typedef struct {
    int needs_new_states, terminates, nominals_changed, states_changed, next_defined;
    double next;
} event_info;

API(int) NAMED(fmi2NewDiscreteStates)(plant *one, event_info *info)
{
    memset(info, 0, sizeof *info);
    return said(one, NULL);
}

API(int) NAMED(fmi2CompletedIntegratorStep)(plant *one, int past, int *event_mode, int *terminates)
{
    (void)past;
    *event_mode = *terminates = 0;
    return said(one, NULL);
}

CALL(fmi2SetTime, (plant *one, double time), set_time(one, time))

CALL(fmi2SetContinuousStates, (plant *one, const double *states, size_t count),
     set_states(one, states, count))

CALL(fmi2GetDerivatives, (plant *one, double *rates, size_t count), get_rates(one, rates, count))

REFUSED(fmi2GetEventIndicators, (plant *one, double *indicators, size_t count), count ? "the model has no events" : NULL,
        (void)indicators;)

CALL(fmi2GetContinuousStates, (plant *one, double *states, size_t count), get_states(one, states, count))

CALL(fmi2GetNominalsOfContinuousStates, (plant *one, double *nominals, size_t count), get_nominals(nominals, count))

/* Co-Simulation */

API(int) NAMED(fmi2DoStep)(plant *one, double time, double step, int final)
{
    (void)final;
    return said(one, one ? moved_on(one, time, step) : NULL);
}

REFUSED(fmi2SetRealInputDerivatives,
        (plant *one, const unsigned *references, size_t count, const int *orders, const double *values),
        count ? "inputs are held over a step" : NULL, (void)references; (void)orders; (void)values;)
REFUSED(fmi2GetRealOutputDerivatives,
        (plant *one, const unsigned *references, size_t count, const int *orders, double *values),
        count ? "derivatives of outputs are not computed" : NULL, (void)references; (void)orders; (void)values;)

static const char *const never_late = "a step ends before its call returns";

#define NO_STATUS(name, type) REFUSED(name, (plant *one, int kind, type *value), never_late, (void)kind; (void)value;)
NO_STATUS(fmi2GetStatus, int)
NO_STATUS(fmi2GetRealStatus, double)
NO_STATUS(fmi2GetIntegerStatus, int)
NO_STATUS(fmi2GetBooleanStatus, int)
NO_STATUS(fmi2GetStringStatus, text)
REFUSED(fmi2CancelStep, (plant *one), never_late, ;)
