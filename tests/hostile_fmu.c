/* Random calls of an FMU, many with references, sizes and values that no importer has; read after the FMU's own text. */

#include <stdio.h>

#ifdef THIRD
#define CREATED(known) fmi3InstantiateCoSimulation("one", known, "", false, false, false, false, NULL, 0, NULL, said_so, NULL)
#define GET(one, r, n, v) fmi3GetFloat64(one, r, n, v, n)
#define SET(one, r, n, v) fmi3SetFloat64(one, r, n, v, n)
#define CHANGE(one, r, n, q, m, s, v) fmi3GetDirectionalDerivative(one, r, n, q, m, s, m, v, n)
#define NAME(name) fmi3##name
#define KEEP fmi3GetFMUState
#define TAKE fmi3SetFMUState
#define DROP fmi3FreeFMUState
#define WRITE(one, state, bytes, size) fmi3SerializeFMUState(one, state, (uint8_t *)bytes, size)
#define READ(one, bytes, size, state) fmi3DeserializeFMUState(one, (uint8_t *)bytes, size, state)
#define MOVES fmi3GetContinuousStateDerivatives
#define INITIALISES(one) fmi3EnterInitializationMode(one, false, 0.0, 0.0, false, 0.0)
static int event_of(plant *one)
{
    bool flags[5];
    double next;
    return fmi3UpdateDiscreteStates(one, flags, flags + 1, flags + 2, flags + 3, flags + 4, &next);
}
static void said_so(void *environment, int status, const char *category, const char *message)
{
    (void)environment; (void)category; (void)message; (void)status;
}
static int stepped_by(plant *one, double time, double step)
{
    bool flags[3];
    double reached;
    return fmi3DoStep(one, time, step, true, flags, flags + 1, flags + 2, &reached);
}
#else
#define CREATED(known) fmi2Instantiate("one", 1, known, "", &called, 0, 0)
#define GET fmi2GetReal
#define SET fmi2SetReal
#define CHANGE fmi2GetDirectionalDerivative
#define NAME(name) fmi2##name
#define KEEP fmi2GetFMUstate
#define TAKE fmi2SetFMUstate
#define DROP fmi2FreeFMUstate
#define WRITE(one, state, bytes, size) fmi2SerializeFMUstate(one, state, bytes, size)
#define READ fmi2DeSerializeFMUstate
#define MOVES fmi2GetDerivatives
#define INITIALISES(one) (fmi2SetupExperiment(one, 0, 0.0, 0.0, 0, 0.0) + fmi2EnterInitializationMode(one))
static int event_of(plant *one)
{
    event_info info;
    return fmi2NewDiscreteStates(one, &info);
}
static void said_so(void *environment, const char *name, int status, const char *category, const char *message, ...)
{
    (void)environment; (void)name; (void)category; (void)message; (void)status;
}
static const callbacks called = {said_so, NULL, NULL, NULL, NULL};
#define stepped_by(one, time, step) fmi2DoStep(one, time, step, 1)
#endif

enum { MOST = 12 };

static double strange(void)
{
    const double size = uniform();
    return size < 0.02 ? odd[(int)(300.0 * size)] : (uniform() - 0.5) * pow(10.0, 6.0 * uniform() - 5.0);
}

/* Calls of the modes of an instance, and those that are wrong before it is initialised. */
static int begun(plant *one)
{
    double value;
    const unsigned first = AT_STATES;
    if (GET(one, &first, 1, &value) != ERROR || stepped_by(one, 0.0, 1e-3) != ERROR || event_of(one) != ERROR ||
        NAME(ExitInitializationMode)(one) != ERROR || NAME(Terminate)(one) != ERROR || INITIALISES(one) != OK ||
        GET(one, &first, 1, &value) != OK || stepped_by(one, 0.0, 1e-3) != ERROR || INITIALISES(one) == OK) {
        return ERROR;
    }
    return NAME(ExitInitializationMode)(one);
}

int main(void)
{
    char bytes[sizeof(written) + 8] = {0};
    void *state = NULL;
    int fine = 0, wrong = 0;
    plant *one = CREATED(token), *other = CREATED("another");
    if (other || !one || GET(NULL, NULL, 0, NULL) != ERROR || NAME(Reset)(NULL) != ERROR || begun(one) != OK ||
        READ(one, bytes, sizeof(written), &state) != ERROR) {
        return 1;
    }
    for (int n = 0; n < CALLS; n++) {
        unsigned references[MOST], knowns[MOST];
        double values[MOST > STATES ? MOST : STATES], seeds[MOST], rates[STATES + 1];
        const size_t count = (size_t)(uniform() * MOST), known_count = (size_t)(uniform() * 4.0);
        int status = OK;
        for (int i = 0; i < MOST; i++) {
            references[i] = uniform() < 0.01 ? (unsigned)(seed & 0xffffffffU) : (unsigned)(uniform() * (AT_END + 1));
            knowns[i] = (unsigned)(uniform() * AT_OUTPUTS);
            seeds[i] = strange();
        }
        for (int i = 0; i < (MOST > STATES ? MOST : STATES); i++) {
            values[i] = strange();
        }
        switch ((int)(uniform() * 13.0)) {
        case 0: status = GET(one, references, count, values); break;
        case 1: status = SET(one, references, count / 6, values); break;
        case 2: status = CHANGE(one, references, count / 3, knowns, known_count, seeds, values); break;
        case 3: status = MOVES(one, rates, uniform() < 0.9 ? STATES : STATES + 1); break;
        case 4: status = KEEP(one, &state); break;
        case 5: status = TAKE(one, state); break;
        case 6: status = uniform() < 0.1 ? DROP(one, &state) : OK; break;
        case 7: status = WRITE(one, state, bytes, uniform() < 0.9 ? sizeof(written) : 8); break;
        case 8:
            if (WRITE(one, state, bytes, sizeof(written)) == OK) {
                const int changed = uniform() < 0.2;
                bytes[(size_t)(uniform() * (double)(sizeof token - 1))] ^= (char)changed;
                status = READ(one, bytes, uniform() < 0.9 ? sizeof(written) : 8, &state);
                if (changed && status == OK) {
                    return 3;
                }
            }
            break;
        case 9: status = NAME(SetContinuousStates)(one, values, uniform() < 0.9 ? STATES : STATES - 1); break;
        case 10: status = NAME(GetContinuousStates)(one, values, STATES); break;
        case 11:
            if (uniform() < 0.3) {
                status = NAME(Reset)(one);
                status = uniform() < 0.05 ? MOVES(one, rates, STATES) : begun(one);
            } else {
                status = uniform() < 0.5   ? event_of(one)
                         : uniform() < 0.9 ? NAME(SetTime)(one, uniform() < 0.5 ? one->now.time + 1e-4 * uniform() : strange())
                         : uniform() < 0.9 ? NAME(EnterEventMode)(one)
                                           : NAME(Terminate)(one);
            }
            break;
        default:
            if (uniform() < 0.02) {
                status = stepped_by(one, uniform(), uniform() < 0.9 ? 1e-4 * uniform() : strange());
            }
        }
        if (!all_finite(one->now.x, STATES) || !all_finite(one->now.u, INPUTS + RATES)) {
            return 2;
        }
        *(status == OK ? &fine : &wrong) += 1;
    }
    DROP(one, &state);
    NAME(FreeInstance)(one);
    printf("%d %d\n", fine, wrong);
    return 0;
}
