/* An FMU, y' = rate, that writes what its importer does against FMI 2.0, a line each, into the file that STRICT_LOG names.
 * With WARNS or ENDS it warns at each step, or ends the simulation, after ten steps; with EXCHANGE it has the functions of
 * Model Exchange, too, which no FMU for Co-Simulation needs. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef WARNS
enum { AT_LAST = 1 };
#elif defined(ENDS)
enum { AT_LAST = 2 };
#else
enum { AT_LAST = 0 };
#endif
enum { OK, WARNING, DISCARD, ERROR };
enum { INSTANTIATED, INITIALISING, STEPPING, ENDED, TERMINATED };
enum { RATE, COUNT, Y, LEVEL }; /* value references: Real, Integer, Real output, Real input */

typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;
typedef struct {
    const Callbacks *given;
    Callbacks copy;
    char name[256];
    double real[4], time, stop;
    int state, set_up, steps, stops;
} Model;

static int alive;

static void against(const char *rule) {
    const char *path = getenv("STRICT_LOG");
    FILE *file = path ? fopen(path, "a") : NULL;
    if (!file) return;
    fprintf(file, "%s\n", rule);
    fclose(file);
}

static void expect(int kept, const char *rule) {
    if (!kept) against(rule);
}

static Model *seen(void *component) {
    Model *model = component;
    expect(!memcmp(model->given, &model->copy, sizeof(Callbacks)), "callbacks");
    return model;
}

static void defaults(Model *model) {
    double start[] = {1, 0, 0, 0};
    memcpy(model->real, start, sizeof start);
    model->state = INSTANTIATED;
    model->set_up = model->steps = model->stops = 0;
    model->time = 0;
}

const char *fmi2GetVersion(void) { return "2.0"; }
const char *fmi2GetTypesPlatform(void) { return "default"; }
int fmi2SetDebugLogging(void *c, int on, size_t n, const char *const names[]) { return OK; }

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const Callbacks *given, int visible,
                      int logging) {
    expect(alive++ == 0, "one instance");
    expect(name && name[0], "instance name");
    expect(type == 1 && guid && !strcmp(guid, "strict"), "type and guid");
    expect(!resources || !strncmp(resources, "file:/", 6), "resources");
    Model *model = given->allocate(1, sizeof *model);
    if (!model) return NULL;
    snprintf(model->name, sizeof model->name, "%s", name ? name : "");
    model->given = given;
    model->copy = *given;
    defaults(model);
    return model;
}

void fmi2FreeInstance(void *c) {
    if (!c) return;
    alive--;
    ((Model *)c)->copy.release(c);
}

int fmi2SetupExperiment(void *c, int has_tolerance, double tolerance, double start, int stops, double stop) {
    Model *model = seen(c);
    expect(model->state == INSTANTIATED, "order: fmi2SetupExperiment");
    model->set_up = 1, model->time = start, model->stops = stops, model->stop = stop;
    return OK;
}

int fmi2EnterInitializationMode(void *c) {
    Model *model = seen(c);
    expect(model->state == INSTANTIATED && model->set_up, "order: fmi2EnterInitializationMode");
    model->state = INITIALISING;
    return OK;
}

int fmi2ExitInitializationMode(void *c) {
    Model *model = seen(c);
    expect(model->state == INITIALISING, "order: fmi2ExitInitializationMode");
    model->state = STEPPING;
    return OK;
}

int fmi2Terminate(void *c) {
    Model *model = seen(c);
    expect(model->state == STEPPING || model->state == ENDED, "order: fmi2Terminate");
    model->state = TERMINATED;
    return OK;
}

int fmi2Reset(void *c) {
    defaults(seen(c));
    return OK;
}

int fmi2DoStep(void *c, double time, double step, int no_return) {
    Model *model = seen(c);
    expect(model->state != ENDED, "end");
    expect(model->state == STEPPING || model->state == ENDED, "order: fmi2DoStep");
    expect(fabs(time - model->time) <= 1e-9 * (1 + fabs(time)), "communication point");
    expect(!model->stops || time + step <= model->stop * (1 + 1e-9), "stop time");
    if (AT_LAST == DISCARD && model->steps >= 10) {
        model->state = ENDED;
        return DISCARD;
    }
    model->steps++;
    model->time = time + step;
    model->real[Y] += model->real[RATE] * step;
    if (AT_LAST != WARNING || model->steps < 10) return OK;
    model->copy.logger(model->copy.environment, model->name, WARNING, "status", "%s", "the oil is warm");
    return WARNING;
}

int fmi2CancelStep(void *c) { return ERROR; }

static int real(unsigned reference) { return reference == RATE || reference == Y || reference == LEVEL; }

int fmi2GetReal(void *c, const unsigned *r, size_t n, double *v) {
    Model *model = seen(c);
    expect(model->state != INSTANTIATED, "order: fmi2GetReal");
    for (size_t k = 0; k < n; k++) {
        expect(real(r[k]), "type");
        v[k] = real(r[k]) ? model->real[r[k]] : 0;
    }
    return OK;
}

int fmi2SetReal(void *c, const unsigned *r, size_t n, const double *v) {
    Model *model = seen(c);
    for (size_t k = 0; k < n; k++) {
        expect(real(r[k]), "type");
        expect(r[k] != Y, "causality");
        expect(r[k] != RATE || model->state <= INITIALISING, "fixed");
        if (r[k] == RATE || r[k] == LEVEL) model->real[r[k]] = v[k];
    }
    return OK;
}

int fmi2GetInteger(void *c, const unsigned *r, size_t n, int *v) {
    for (size_t k = 0; k < n; k++) {
        expect(r[k] == COUNT, "type");
        v[k] = 0;
    }
    return OK;
}

int fmi2SetInteger(void *c, const unsigned *r, size_t n, const int *v) {
    Model *model = seen(c);
    for (size_t k = 0; k < n; k++) {
        expect(r[k] == COUNT, "type");
        expect(model->state <= INITIALISING, "fixed");
    }
    return OK;
}

static int none(size_t n) {
    expect(n == 0, "type");
    return n ? ERROR : OK;
}
int fmi2GetBoolean(void *c, const unsigned *r, size_t n, int *v) { return none(n); }
int fmi2SetBoolean(void *c, const unsigned *r, size_t n, const int *v) { return none(n); }
int fmi2GetString(void *c, const unsigned *r, size_t n, const char **v) { return none(n); }
int fmi2SetString(void *c, const unsigned *r, size_t n, const char *const *v) { return none(n); }

int fmi2GetFMUstate(void *c, void **state) { return ERROR; }
int fmi2SetFMUstate(void *c, void *state) { return ERROR; }
int fmi2FreeFMUstate(void *c, void **state) { return ERROR; }
int fmi2SerializedFMUstateSize(void *c, void *state, size_t *size) { return ERROR; }
int fmi2SerializeFMUstate(void *c, void *state, char *bytes, size_t size) { return ERROR; }
int fmi2DeSerializeFMUstate(void *c, const char *bytes, size_t size, void **state) { return ERROR; }
int fmi2GetDirectionalDerivative(void *c, const unsigned *u, size_t nu, const unsigned *k, size_t nk, const double *dk, double *du) {
    return ERROR;
}
int fmi2SetRealInputDerivatives(void *c, const unsigned *r, size_t n, const int *order, const double *v) { return ERROR; }
int fmi2GetRealOutputDerivatives(void *c, const unsigned *r, size_t n, const int *order, double *v) { return ERROR; }

int fmi2GetStatus(void *c, int kind, int *v) { return DISCARD; }
int fmi2GetRealStatus(void *c, int kind, double *v) {
    *v = ((Model *)c)->time; /* fmi2LastSuccessfulTime */
    return OK;
}
int fmi2GetIntegerStatus(void *c, int kind, int *v) { return DISCARD; }
int fmi2GetBooleanStatus(void *c, int kind, int *v) {
    *v = ((Model *)c)->state == ENDED; /* fmi2Terminated */
    return OK;
}
int fmi2GetStringStatus(void *c, int kind, const char **v) { return DISCARD; }

#ifdef EXCHANGE
#define MISSING(name) \
    int name(void) { return ERROR; }
MISSING(fmi2EnterEventMode)
MISSING(fmi2NewDiscreteStates)
MISSING(fmi2EnterContinuousTimeMode)
MISSING(fmi2CompletedIntegratorStep)
MISSING(fmi2SetTime)
MISSING(fmi2SetContinuousStates)
MISSING(fmi2GetDerivatives)
MISSING(fmi2GetEventIndicators)
MISSING(fmi2GetContinuousStates)
MISSING(fmi2GetNominalsOfContinuousStates)
#endif
