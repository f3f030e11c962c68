/* The FMI 2.0 functions of the faulty models; see model.h. */
#define _GNU_SOURCE
#include "model.h"

#include <fcntl.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

BEHAVES(BEHAVIOUR);

const char *version = "2.0";

/* While the run has a file `held`, its points from the twenty-first on wait: so a test can stop it half-way, however fast or
 * slow the machine is. */
static void wait_while_held(void) {
    if (access(file_of_the_run("held"), F_OK) != 0 || count_in_the_run("begun") <= 20) return;
    while (access(file_of_the_run("held"), F_OK) == 0) sleep_for(0.001);
}

void say(const Model *model, int status, const char *text) {
    const Callbacks *call = model->callbacks;
    call->logger(call->environment, "faulty", status, "status", "%s", text);
}

void say_limit(const Model *model, const char *format, double number) {
    const Callbacks *call = model->callbacks;
    if (model->listens) call->logger(call->environment, "faulty", OK, "validity", format, number);
}

const char *file_of_the_run(const char *name) {
    static char path[4096];
    const char *folder = getenv("FAULTY_FOLDER");
    snprintf(path, sizeof path, "%s/%s", folder ? folder : "/tmp", name);
    return path;
}

int count_in_the_run(const char *name) {
    int file = open(file_of_the_run(name), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
    if (file < 0 || flock(file, LOCK_EX) < 0 || write(file, ".", 1) != 1) return -1;
    int count = (int)lseek(file, 0, SEEK_END);
    close(file);
    return count;
}

static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

void sleep_for(double seconds) {
    for (double end = now() + seconds; now() < end;) usleep(1000);
}

void hang(void) {
    sleep_for(FOR_EVER);
}

/* Without an end, and behind all that runs beside it. */
void loop(void) {
    setpriority(PRIO_PROCESS, 0, 19);
    for (double end = now() + FOR_EVER; now() < end;) continue;
}

void crash(void) {
    *(volatile int *)(uintptr_t)8 = 1;
}

/* Takes as long as FAULTY_PAUSE says, s: the same for all points, or between two times, by the rate from 0.5 to 2; the run's file
 * `pauses` then tells how long. */
static void pause_at_a_point(double rate) {
    double least = 0, most;
    const char *text = getenv("FAULTY_PAUSE");
    if (!text || sscanf(text, "%lf %lf", &least, &most) < 2) return sleep_for(least);
    char line[32];
    double seconds = least * pow(most / least, (rate - 0.5) / 1.5);
    sleep_for(seconds);
    int file = open(file_of_the_run("pauses"), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
    int length = snprintf(line, sizeof line, "%.6f\n", seconds);
    if (file >= 0 && write(file, line, (size_t)length) == length) close(file);
}

__attribute__((constructor)) static void load(void) { BEHAVIOUR(LOAD, NULL); }
__attribute__((destructor)) static void unload(void) { BEHAVIOUR(UNLOAD, NULL); }

static void defaults(Model *model) {
    model->rate = 1;
    model->y = model->sum = model->spoil = 0;
    model->fault = model->steps = model->ended = model->pending = model->listens = 0;
}

const char *fmi2GetVersion(void) { return version; }
const char *fmi2GetTypesPlatform(void) { return "default"; }

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                      const Callbacks *callbacks, int visible, int logging) {
    Model *model = calloc(1, sizeof *model);
    model->callbacks = callbacks;
    const char *scheme = "file://";
    int skipped = strncmp(resources, scheme, strlen(scheme)) ? 0 : (int)strlen(scheme);
    snprintf(model->folder, sizeof model->folder, "%s", resources + skipped);
    defaults(model);
    if (BEHAVIOUR(INSTANTIATE, model) == OK) return model;
    free(model);
    return NULL;
}
void fmi2FreeInstance(void *c) {
    BEHAVIOUR(FREE, c);
    free(c);
}
int fmi2SetupExperiment(void *c, int d, double t, double start, int s, double stop) {
    return OK;
}
int fmi2EnterInitializationMode(void *c) { return OK; }
int fmi2ExitInitializationMode(void *c) {
    wait_while_held();
    pause_at_a_point(((Model *)c)->rate);
    return BEHAVIOUR(INITIALISE, c);
}
int fmi2Terminate(void *c) { return BEHAVIOUR(TERMINATE, c); }
int fmi2Reset(void *c) {
    int status = BEHAVIOUR(RESET, c);
    if (status == OK) defaults(c);
    return status;
}

int fmi2DoStep(void *c, double time, double step, int no) {
    Model *model = c;
    const int MIDDLE = 10;
    int hit = model->fault == 1 && model->steps == MIDDLE;
    int status = BEHAVIOUR(hit ? HIT : STEP, model);
    if (status != OK && status != WARNING && status != PENDING) return status;
    model->steps++;
    model->y += (1 - model->y) * (1 - exp(-model->rate * step));
    model->sum += model->y * model->y / 3;
    return status;
}

static double *real(Model *model, uint32_t reference) {
    return reference == 0 ? &model->rate : reference == 2 ? &model->y : reference == 3 ? &model->sum : NULL;
}
int fmi2GetReal(void *c, const uint32_t *r, size_t n, double *v) {
    for (size_t k = 0; k < n; k++) {
        if (!real(c, r[k])) return ERROR;
        v[k] = *real(c, r[k]) + (r[k] >= 2 ? ((Model *)c)->spoil : 0);
    }
    return OK;
}
int fmi2SetReal(void *c, const uint32_t *r, size_t n, const double *v) {
    for (size_t k = 0; k < n; k++) {
        if (!real(c, r[k])) return ERROR;
        *real(c, r[k]) = v[k];
    }
    return OK;
}
int fmi2GetInteger(void *c, const uint32_t *r, size_t n, int *v) {
    for (size_t k = 0; k < n; k++) {
        if (r[k] != 1) return ERROR;
        v[k] = ((Model *)c)->fault;
    }
    return OK;
}
int fmi2SetInteger(void *c, const uint32_t *r, size_t n, const int *v) {
    for (size_t k = 0; k < n; k++) {
        if (r[k] != 1) return ERROR;
        ((Model *)c)->fault = v[k];
    }
    return OK;
}

enum { DO_STEP_STATUS, PENDING_STATUS, LAST_SUCCESSFUL_TIME, TERMINATED };

int fmi2GetStatus(void *c, int kind, int *value) {
    Model *model = c;
    if (kind != DO_STEP_STATUS) return DISCARD;
    *value = model->pending > 0 ? PENDING : OK;
    model->pending -= model->pending > 0;
    return OK;
}
int fmi2GetBooleanStatus(void *c, int kind, int *value) {
    if (kind != TERMINATED) return DISCARD;
    *value = ((Model *)c)->ended;
    return OK;
}
int fmi2GetRealStatus(void *c, int kind, double *value) {
    if (kind != LAST_SUCCESSFUL_TIME) return DISCARD;
    *value = 0.05 * ((Model *)c)->steps;
    return OK;
}

/* Exported because it must be; there is nothing behind it. */
int fmi2SetDebugLogging(void *c, int on, size_t n, const char *const *k) {
    Model *model = c;
    model->listens = 0;
    for (size_t i = 0; i < n; i++) model->listens |= on && strcmp(k[i], "validity") == 0;
    return OK;
}
int fmi2GetBoolean(void *c, const uint32_t *r, size_t n, int *v) { return n ? ERROR : OK; }
int fmi2SetBoolean(void *c, const uint32_t *r, size_t n, const int *v) { return n ? ERROR : OK; }
int fmi2GetString(void *c, const uint32_t *r, size_t n, const char **v) { return n ? ERROR : OK; }
int fmi2SetString(void *c, const uint32_t *r, size_t n, const char *const *v) { return n ? ERROR : OK; }
int fmi2CancelStep(void *c) { return ERROR; }
int fmi2GetIntegerStatus(void *c, int k, int *v) { return DISCARD; }
int fmi2GetStringStatus(void *c, int k, const char **v) { return DISCARD; }
int fmi2GetFMUstate(void *c, void **s) { return ERROR; }
int fmi2SetFMUstate(void *c, void *s) { return ERROR; }
int fmi2FreeFMUstate(void *c, void **s) { return ERROR; }
int fmi2SerializedFMUstateSize(void *c, void *s, size_t *n) { return ERROR; }
int fmi2SerializeFMUstate(void *c, void *s, char *b, size_t n) { return ERROR; }
int fmi2DeSerializeFMUstate(void *c, const char *b, size_t n, void **s) { return ERROR; }
int fmi2GetDirectionalDerivative(void *c, const uint32_t *u, size_t n, const uint32_t *k, size_t m,
                                 const double *dk, double *du) {
    return ERROR;
}
int fmi2SetRealInputDerivatives(void *c, const uint32_t *r, size_t n, const int *o, const double *v) {
    return ERROR;
}
int fmi2GetRealOutputDerivatives(void *c, const uint32_t *r, size_t n, const int *o, double *v) {
    return ERROR;
}
