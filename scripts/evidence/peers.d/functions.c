/* Two published functions as an FMI 2.0 Co-Simulation FMU, of standard normal scores `x1` to `x6`: margins of a series system of four
 * branches and of a non-linear oscillator (Schueremans & Van Gemert 2005; Echard et al. 2011). openturns/rare.py has the same. */
#include <math.h>
#include <stdlib.h>

enum { OK = 0, ERROR = 3 };
enum { INPUTS = 6, BRANCHES = 6, OSCILLATOR = 7 };

typedef struct {
    double x[INPUTS];
} model_t;

static double branches(const double *x) {
    double curved = 3 + 0.1 * (x[0] - x[1]) * (x[0] - x[1]), sum = (x[0] + x[1]) / sqrt(2), apart = 6 / sqrt(2);
    return fmin(fmin(curved - sum, curved + sum), fmin(x[0] - x[1] + apart, x[1] - x[0] + apart));
}
static double oscillator(const double *x) {
    double mass = 1 + 0.05 * x[2], square = (1 + 0.1 * x[0] + 0.1 + 0.01 * x[1]) / mass;
    double force = 1 + 0.2 * x[5], time = 1 + 0.2 * x[4];
    return 3 * (0.5 + 0.05 * x[3]) - fabs(2 * force / (mass * square) * sin(sqrt(square) * time / 2));
}

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }
int fmi2Reset(model_t *model) {
    *model = (model_t){0};
    return OK;
}
model_t *fmi2Instantiate(void) { return calloc(1, sizeof(model_t)); }
void fmi2FreeInstance(model_t *model) { free(model); }
int fmi2GetReal(model_t *model, const unsigned *reference, size_t n, double *value) {
    for (size_t i = 0; i < n; i++) {
        if (reference[i] > OSCILLATOR) return ERROR;
        value[i] = reference[i] == BRANCHES ? branches(model->x) : reference[i] == OSCILLATOR ? oscillator(model->x) : model->x[reference[i]];
    }
    return OK;
}
int fmi2SetReal(model_t *model, const unsigned *reference, size_t n, const double *value) {
    for (size_t i = 0; i < n; i++) {
        if (reference[i] >= INPUTS) return ERROR;
        model->x[reference[i]] = value[i];
    }
    return OK;
}

/* Nothing to do. */
#define DONE(name) int name(void) { return OK; }
DONE(fmi2SetDebugLogging) DONE(fmi2SetupExperiment) DONE(fmi2EnterInitializationMode) DONE(fmi2ExitInitializationMode)
DONE(fmi2DoStep) DONE(fmi2Terminate)

/* Not there. */
#define NONE(name) int name(void) { return ERROR; }
NONE(fmi2GetInteger) NONE(fmi2GetBoolean) NONE(fmi2GetString) NONE(fmi2SetInteger) NONE(fmi2SetBoolean) NONE(fmi2SetString)
NONE(fmi2GetFMUstate) NONE(fmi2SetFMUstate) NONE(fmi2FreeFMUstate) NONE(fmi2SerializedFMUstateSize) NONE(fmi2SerializeFMUstate)
NONE(fmi2DeSerializeFMUstate) NONE(fmi2GetDirectionalDerivative) NONE(fmi2SetRealInputDerivatives) NONE(fmi2GetRealOutputDerivatives)
NONE(fmi2CancelStep) NONE(fmi2GetStatus) NONE(fmi2GetRealStatus) NONE(fmi2GetIntegerStatus) NONE(fmi2GetBooleanStatus)
NONE(fmi2GetStringStatus)
