
/* FMI 2.0, Model Exchange and Co-Simulation. Types are those of the standard's headers in plain C, so that the
   sources need no other file: fmi2Component is plant *, fmi2Status int. Source: fmi2014, chapters 2 to 4. */

typedef void (*logger)(void *, const char *, int, const char *, const char *, ...);

typedef struct {
    logger log;
    void *(*allocate)(size_t, size_t);
    void (*free)(void *);
    void (*step_finished)(void *, int);
    void *environment;
} callbacks;

#define OWN(name) NAMED(fmi2##name)

static int said(const plant *one, const char *problem)
{
    if (problem && one && one->log) {
        ((logger)one->log)(one->environment, one->name, ERROR, "logStatusError", "%s", problem);
    }
    return problem || !one ? ERROR : OK;
}

API(const char *) OWN(GetTypesPlatform)(void) { return "default"; }
API(const char *) OWN(GetVersion)(void) { return "2.0"; }

API(plant *) OWN(Instantiate)(const char *name, int kind, const char *guid, const char *place, const callbacks *called,
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

API(int) OWN(SetDebugLogging)(plant *one, int on, size_t count, const char *const *categories)
{
    (void)on; (void)count; (void)categories;
    return said(one, NULL);
}

API(int) OWN(SetupExperiment)(plant *one, int defined, double tolerance, double start, int ends, double stop)
{
    const char *const problem = refused(one, MADE);
    return said(one, one && !problem ? set_up(one, defined, tolerance, start, ends, stop) : problem);
}

CALL(MADE, EnterInitializationMode, (plant *one), enter(one, INITIALISING))

CALL(KNOWS, GetReal, (plant *one, const unsigned *references, size_t count, double *values),
     get(one, references, count, values))
CALL(SETTABLE, SetReal, (plant *one, const unsigned *references, size_t count, const double *values),
     set(one, references, count, values))

static const char *const other_type = "the model has variables of type Real only";

#define NO_VARIABLES(type, got, put) \
    REFUSED(got, (plant *one, const unsigned *references, size_t count, type *values), count ? other_type : NULL, \
            (void)references; (void)values;) \
    REFUSED(put, (plant *one, const unsigned *references, size_t count, const type *values), count ? other_type : NULL, \
            (void)references; (void)values;)
typedef const char *text;
NO_VARIABLES(int, GetInteger, SetInteger)
NO_VARIABLES(int, GetBoolean, SetBoolean)
NO_VARIABLES(text, GetString, SetString)

CALL(ANY, GetFMUstate, (plant *one, void **state), keep(one, state))
CALL(ANY, SetFMUstate, (plant *one, void *state), take_back(one, state))

CALL(ANY, FreeFMUstate, (plant *one, void **state), drop(state))
API(int) OWN(SerializedFMUstateSize)(plant *one, void *state, size_t *size)
{
    (void)state;
    return said(one, say_size(size));
}

CALL(ANY, SerializeFMUstate, (plant *one, void *state, char *bytes, size_t size), to_bytes(state, bytes, size))
CALL(ANY, DeSerializeFMUstate, (plant *one, const char *bytes, size_t size, void **state), from_bytes(bytes, size, state))

CALL(KNOWS, GetDirectionalDerivative,
     (plant *one, const unsigned *unknowns, size_t unknown_count, const unsigned *knowns, size_t known_count, const double *seed,
      double *change),
     get_direction(one, unknowns, unknown_count, knowns, known_count, seed, change))

/* Model Exchange */

typedef struct {
    int needs_new_states, terminates, nominals_changed, states_changed, next_defined;
    double next;
} event_info;

API(int) OWN(NewDiscreteStates)(plant *one, event_info *info)
{
    const char *problem = refused(one, RUNNING);
    memset(info, 0, sizeof *info);
    if (one && !problem) {
        problem = event(one, &info->next);
        info->next_defined = COMMANDS > 0;
    }
    return said(one, problem);
}

API(int) OWN(CompletedIntegratorStep)(plant *one, int past, int *event_mode, int *terminates)
{
    (void)past;
    *event_mode = *terminates = 0;
    return said(one, refused(one, RUNNING));
}

CALL(KNOWS, GetDerivatives, (plant *one, double *rates, size_t count), get_rates(one, rates, count))

/* Co-Simulation */

API(int) OWN(DoStep)(plant *one, double time, double step, int final)
{
    const char *const problem = refused(one, RUNNING);
    (void)final;
    return said(one, one && !problem ? moved_on(one, time, step) : problem);
}

REFUSED(SetRealInputDerivatives,
        (plant *one, const unsigned *references, size_t count, const int *orders, const double *values),
        count ? "inputs are held over a step" : NULL, (void)references; (void)orders; (void)values;)
REFUSED(GetRealOutputDerivatives,
        (plant *one, const unsigned *references, size_t count, const int *orders, double *values),
        count ? "derivatives of outputs are not computed" : NULL, (void)references; (void)orders; (void)values;)

static const char *const never_late = "a step ends before its call returns";

#define NO_STATUS(name, type) REFUSED(name, (plant *one, int kind, type *value), never_late, (void)kind; (void)value;)
NO_STATUS(GetStatus, int)
NO_STATUS(GetRealStatus, double)
NO_STATUS(GetIntegerStatus, int)
NO_STATUS(GetBooleanStatus, int)
NO_STATUS(GetStringStatus, text)
REFUSED(CancelStep, (plant *one), never_late, ;)
