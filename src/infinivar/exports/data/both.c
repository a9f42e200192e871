
/* What both versions have. */

API(void) OWN(FreeInstance)(plant *one) { free(one); }

CALL(ExitInitializationMode, (plant *one), NULL)
CALL(EnterEventMode, (plant *one), NULL)
CALL(EnterContinuousTimeMode, (plant *one), NULL)
CALL(Terminate, (plant *one), NULL)
CALL(Reset, (plant *one), started(one))
CALL(SetTime, (plant *one, double time), set_time(one, time))
CALL(SetContinuousStates, (plant *one, const double *states, size_t count), set_states(one, states, count))
CALL(GetContinuousStates, (plant *one, double *states, size_t count), get_states(one, states, count))
CALL(GetNominalsOfContinuousStates, (plant *one, double *nominals, size_t count), get_nominals(nominals, count))
REFUSED(GetEventIndicators, (plant *one, double *indicators, size_t count), count ? "the model has no events" : NULL,
        (void)indicators;)
