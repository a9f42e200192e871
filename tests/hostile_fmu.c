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

int main(void)
{
    char bytes[sizeof(situation) + 8];
    void *state = NULL;
    int fine = 0, wrong = 0;
    plant *one = CREATED(token), *other = CREATED("another");
    if (other || !one || GET(NULL, NULL, 0, NULL) != ERROR || NAME(Reset)(NULL) != ERROR) {
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
        switch ((int)(uniform() * 12.0)) {
        case 0: status = GET(one, references, count, values); break;
        case 1: status = SET(one, references, count / 6, values); break;
        case 2: status = CHANGE(one, references, count / 3, knowns, known_count, seeds, values); break;
        case 3: status = MOVES(one, rates, uniform() < 0.9 ? STATES : STATES + 1); break;
        case 4: status = KEEP(one, &state); break;
        case 5: status = TAKE(one, state); break;
        case 6: status = uniform() < 0.1 ? DROP(one, &state) : OK; break;
        case 7: status = WRITE(one, state, bytes, uniform() < 0.9 ? sizeof(situation) : 8); break;
        case 8:
            if (WRITE(one, state, bytes, sizeof(situation)) == OK) {
                status = READ(one, bytes, uniform() < 0.9 ? sizeof(situation) : 8, &state);
            }
            break;
        case 9: status = NAME(SetContinuousStates)(one, values, uniform() < 0.9 ? STATES : STATES - 1); break;
        case 10: status = uniform() < 0.3 ? NAME(Reset)(one) : NAME(GetContinuousStates)(one, values, STATES); break;
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
