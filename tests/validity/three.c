/* An FMU of FMI 3.0 that tells a limit of its model: y = x t may not exceed 1, and it says so at every step beyond. It tells
 * what the standard lets it: by its own category, after fmi3SetDebugLogging, and no more once it was reset. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef void (*Logger)(void *, int, const char *, const char *);
typedef struct {
    Logger log;
    void *environment;
    bool listens;
    double x, y;
} Model;

void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible, bool logging,
                                  bool events, bool early, const uint32_t *intermediate, size_t n, void *environment,
                                  Logger log, void *update) {
    Model *model = calloc(1, sizeof *model);
    *model = (Model){log, environment, logging, 1, 0};
    return model;
}
void fmi3FreeInstance(void *c) { free(c); }
const char *fmi3GetVersion(void) { return "3.0"; }
int fmi3SetDebugLogging(void *c, bool on, size_t n, const char *const *categories) {
    Model *model = c;
    model->listens = false;
    for (size_t k = 0; k < n; k++) model->listens |= on && strcmp(categories[k], "validity") == 0;
    return 0;
}
int fmi3EnterInitializationMode(void *c, bool t, double tolerance, double start, bool s, double stop) { return 0; }
int fmi3ExitInitializationMode(void *c) { return 0; }
int fmi3Terminate(void *c) { return 0; }
int fmi3Reset(void *c) {
    Model *model = c;
    *model = (Model){model->log, model->environment, false, 1, 0};
    return 0;
}
int fmi3DoStep(void *c, double time, double step, bool no, bool *event, bool *terminate, bool *early, double *last) {
    Model *model = c;
    *event = *terminate = *early = false;
    *last = time + step;
    model->y = model->x * *last;
    if (model->listens && model->y > 1) {
        char text[100];
        snprintf(text, sizeof text, "at %g s: y = %g is beyond 1", *last, model->y);
        model->log(model->environment, 0, "validity", text);
    }
    if (model->listens) model->log(model->environment, 0, "other", "nobody asked for this");
    return 0;
}
int fmi3SetFloat64(void *c, const uint32_t *r, size_t n, const double v[], size_t m) {
    ((Model *)c)->x = v[0];
    return 0;
}
int fmi3GetFloat64(void *c, const uint32_t *r, size_t n, double v[], size_t m) {
    for (size_t k = 0; k < n; k++) v[k] = r[k] == 1 ? ((Model *)c)->x : ((Model *)c)->y;
    return 0;
}
