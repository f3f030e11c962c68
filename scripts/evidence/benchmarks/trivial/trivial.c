/* A first-order lag dy/dt = rate * (1 - y) by Euler's method as a complete FMI 2.0 Co-Simulation FMU.
 *
 * A step costs next to nothing, so that what a host spends on it is all that is seen. */
#include <stdlib.h>

typedef struct {
    double y, rate;
} lag_t;

enum { OK = 0, ERROR = 3 };
enum { OUTPUT = 0, RATE = 1 };

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }

int fmi2Reset(lag_t *lag) {
    *lag = (lag_t){0.0, 1.0};
    return OK;
}
lag_t *fmi2Instantiate(void) {
    lag_t *lag = malloc(sizeof *lag);
#ifdef TOUCHED
    static unsigned char memory[TOUCHED];
    for (size_t i = 0; i < sizeof memory; i += 1024) memory[i] = 1;
#endif
    if (lag) fmi2Reset(lag);
    return lag;
}
void fmi2FreeInstance(lag_t *lag) { free(lag); }

int fmi2DoStep(lag_t *lag, double time, double step, int keep) {
    (void)time, (void)keep;
    lag->y += step * lag->rate * (1.0 - lag->y);
    return OK;
}
int fmi2GetReal(lag_t *lag, const unsigned *reference, size_t n, double *value) {
    for (size_t i = 0; i < n; i++) {
        if (reference[i] > RATE) return ERROR;
        value[i] = reference[i] == OUTPUT ? lag->y : lag->rate;
    }
    return OK;
}
int fmi2SetReal(lag_t *lag, const unsigned *reference, size_t n, const double *value) {
    for (size_t i = 0; i < n; i++) {
        if (reference[i] != RATE) return ERROR;
        lag->rate = value[i];
    }
    return OK;
}

/* Nothing to do. */
#define DONE(name) int name(void) { return OK; }
DONE(fmi2SetDebugLogging)
DONE(fmi2SetupExperiment)
DONE(fmi2EnterInitializationMode)
DONE(fmi2ExitInitializationMode)
DONE(fmi2Terminate)

/* Not there: the model has no such variables and keeps no states. */
#define NONE(name) int name(void) { return ERROR; }
NONE(fmi2GetInteger)
NONE(fmi2GetBoolean)
NONE(fmi2GetString)
NONE(fmi2SetInteger)
NONE(fmi2SetBoolean)
NONE(fmi2SetString)
NONE(fmi2GetFMUstate)
NONE(fmi2SetFMUstate)
NONE(fmi2FreeFMUstate)
NONE(fmi2SerializedFMUstateSize)
NONE(fmi2SerializeFMUstate)
NONE(fmi2DeSerializeFMUstate)
NONE(fmi2GetDirectionalDerivative)
NONE(fmi2SetRealInputDerivatives)
NONE(fmi2GetRealOutputDerivatives)
NONE(fmi2CancelStep)
NONE(fmi2GetStatus)
NONE(fmi2GetRealStatus)
NONE(fmi2GetIntegerStatus)
NONE(fmi2GetBooleanStatus)
NONE(fmi2GetStringStatus)
