
/* What both versions have. */

API(void) OWN(FreeInstance)(plant *one) { free(one); }

CALL(INITIALISING, ExitInitializationMode, (plant *one), enter(one, RUNNING))
CALL(RUNNING, EnterEventMode, (plant *one), NULL)
CALL(RUNNING, EnterContinuousTimeMode, (plant *one), NULL)
CALL(RUNNING, Terminate, (plant *one), enter(one, ENDED))
CALL(ANY, Reset, (plant *one), started(one))
CALL(RUNNING, SetTime, (plant *one, double time), set_time(one, time))
CALL(RUNNING, SetContinuousStates, (plant *one, const double *states, size_t count), set_states(one, states, count))
CALL(KNOWS, GetContinuousStates, (plant *one, double *states, size_t count), get_states(one, states, count))
CALL(KNOWS, GetNominalsOfContinuousStates, (plant *one, double *nominals, size_t count), get_nominals(nominals, count))
REFUSED(GetEventIndicators, (plant *one, double *indicators, size_t count), count ? "the model has no events" : NULL,
        (void)indicators;)
