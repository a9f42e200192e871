
/* FMI 2.0, Model Exchange and Co-Simulation. Types are those of the standard's headers, in plain C: fmi2Component is plant *,
   fmi2Status int. Source: fmi2024, chapters 2 to 4. */

#ifdef FMI2_FUNCTION_PREFIX
#define JOINED(one, other) one##other
#define PREFIXED(one, other) JOINED(one, other)
#define NAMED(name) PREFIXED(FMI2_FUNCTION_PREFIX, name)
#else
#define NAMED(name) name
#endif
#ifdef _WIN32
#define API(type) __declspec(dllexport) type
#elif defined(__GNUC__)
#define API(type) __attribute__((visibility("default"))) type
#else
#define API(type) type
#endif

enum { OK = 0, ERROR = 3 };

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

API(int) NAMED(fmi2GetReal)(plant *one, const unsigned *references, size_t count, double *values)
{
    return said(one, one ? get(one, references, count, values) : NULL);
}

API(int) NAMED(fmi2SetReal)(plant *one, const unsigned *references, size_t count, const double *values)
{
    return said(one, one ? set(one, references, count, values) : NULL);
}

/* The model has real variables only. */
#define NO_VARIABLES(type, got, put) \
    API(int) NAMED(got)(plant *one, const unsigned *references, size_t count, type *values) \
    { \
        (void)references; (void)values; \
        return said(one, count ? "the model has variables of type Real only" : NULL); \
    } \
    API(int) NAMED(put)(plant *one, const unsigned *references, size_t count, const type *values) \
    { \
        (void)references; (void)values; \
        return said(one, count ? "the model has variables of type Real only" : NULL); \
    }
NO_VARIABLES(int, fmi2GetInteger, fmi2SetInteger)
NO_VARIABLES(int, fmi2GetBoolean, fmi2SetBoolean)
typedef const char *text;
NO_VARIABLES(text, fmi2GetString, fmi2SetString)

API(int) NAMED(fmi2GetFMUstate)(plant *one, void **state) { return said(one, one ? keep(one, state) : NULL); }
API(int) NAMED(fmi2SetFMUstate)(plant *one, void *state) { return said(one, one ? take_back(one, state) : NULL); }

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

API(int) NAMED(fmi2SerializeFMUstate)(plant *one, void *state, char *bytes, size_t size)
{
    return said(one, to_bytes(state, bytes, size));
}

API(int) NAMED(fmi2DeSerializeFMUstate)(plant *one, const char *bytes, size_t size, void **state)
{
    return said(one, from_bytes(bytes, size, state));
}

API(int) NAMED(fmi2GetDirectionalDerivative)(plant *one, const unsigned *unknowns, size_t unknown_count, const unsigned *knowns,
                                             size_t known_count, const double *seed, double *change)
{
    return said(one, one ? get_direction(one, unknowns, unknown_count, knowns, known_count, seed, change) : NULL);
}

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

API(int) NAMED(fmi2SetTime)(plant *one, double time) { return said(one, one ? set_time(one, time) : NULL); }

API(int) NAMED(fmi2SetContinuousStates)(plant *one, const double *states, size_t count)
{
    return said(one, one ? set_states(one, states, count) : NULL);
}

API(int) NAMED(fmi2GetDerivatives)(plant *one, double *rates, size_t count)
{
    return said(one, one ? get_rates(one, rates, count) : NULL);
}

API(int) NAMED(fmi2GetEventIndicators)(plant *one, double *indicators, size_t count)
{
    (void)indicators;
    return said(one, count ? "the model has no events" : NULL);
}

API(int) NAMED(fmi2GetContinuousStates)(plant *one, double *states, size_t count)
{
    return said(one, one ? get_states(one, states, count) : NULL);
}

API(int) NAMED(fmi2GetNominalsOfContinuousStates)(plant *one, double *nominals, size_t count)
{
    return said(one, get_nominals(nominals, count));
}

/* Co-Simulation */

API(int) NAMED(fmi2DoStep)(plant *one, double time, double step, int final)
{
    (void)final;
    return said(one, one ? moved_on(one, time, step) : NULL);
}

API(int) NAMED(fmi2SetRealInputDerivatives)(plant *one, const unsigned *references, size_t count, const int *orders,
                                            const double *values)
{
    (void)references; (void)orders; (void)values;
    return said(one, count ? "inputs are held over a step" : NULL);
}

API(int) NAMED(fmi2GetRealOutputDerivatives)(plant *one, const unsigned *references, size_t count, const int *orders, double *values)
{
    (void)references; (void)orders; (void)values;
    return said(one, count ? "derivatives of outputs are not computed" : NULL);
}

API(int) NAMED(fmi2CancelStep)(plant *one) { return said(one, "steps end when they return"); }

#define NO_STATUS(name, type) \
    API(int) NAMED(name)(plant *one, int kind, type *value) \
    { \
        (void)kind; (void)value; \
        return said(one, "steps end when they return"); \
    }
NO_STATUS(fmi2GetStatus, int)
NO_STATUS(fmi2GetRealStatus, double)
NO_STATUS(fmi2GetIntegerStatus, int)
NO_STATUS(fmi2GetBooleanStatus, int)
NO_STATUS(fmi2GetStringStatus, text)
