/* An FMU for every platform: y' = (1 - y) * rate with sums and products only, so that each machine finds the same bits.
 * The parameter `fault` lets the step in the middle of a point fail in one of the ways below. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
#define EXPORT __declspec(dllexport)
static void sleep_for(double seconds) { Sleep((DWORD)(1000 * seconds)); }
#else
#include <unistd.h>
#define EXPORT __attribute__((visibility("default")))
static void sleep_for(double seconds) { usleep((unsigned)(1e6 * seconds)); }
#endif

enum { HEALTHY, WRITES_TO_NULL, EXITS, LOOPS, TAKES_MEMORY, OVERFLOWS_ITS_STACK, LEAVES_A_CHILD };
enum { OK, WARNING, DISCARD, FAILED };

typedef struct {
    double rate, y, sum;
    int fault, steps;
} Model;

static void defaults(Model *model) {
    memset(model, 0, sizeof *model);
    model->rate = 1;
}

static volatile int depth;
static int deeper(volatile char *above) {
    volatile char room[4096];
    room[0] = *above;
    depth++;
    return deeper(room) + room[0];
}

/* A child that holds the pipes of its parent and does nothing for ten minutes. */
static void leave_a_child(void) {
#ifdef _WIN32
    STARTUPINFOA start = {.cb = sizeof start};
    PROCESS_INFORMATION process;
    char command[] = "ping -n 600 127.0.0.1";
    CreateProcessA(NULL, command, NULL, NULL, TRUE, 0, NULL, NULL, &start, &process);
#else
    if (fork() == 0) {
        sleep_for(600);
        _exit(0);
    }
#endif
}

static int fail(int fault) {
    switch (fault) {
    case WRITES_TO_NULL:
        fprintf(stderr, "about to write\n");
        fflush(stderr);
        *(volatile int *)(uintptr_t)8 = 1;
        break;
    case EXITS:
        printf("no licence on Sundays\n");
        fflush(stdout);
        exit(7);
    case LOOPS:
        for (int k = 0; k < 600; k++) sleep_for(1);
        break;
    case TAKES_MEMORY:
        for (int k = 0; k < 6000; k++) {
            void *taken = malloc(1 << 20);
            if (taken) memset(taken, 1, 1 << 20);
            sleep_for(0.001);
        }
        break;
    case OVERFLOWS_ITS_STACK: {
        char room = 1;
        return deeper(&room) ? OK : FAILED;
    }
    case LEAVES_A_CHILD:
        leave_a_child();
        break;
    }
    return OK;
}

EXPORT const char *fmi2GetVersion(void) { return "2.0"; }
EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const void *callbacks,
                             int visible, int logging) {
    Model *model = malloc(sizeof *model);
    if (model) defaults(model);
    return model;
}
EXPORT void fmi2FreeInstance(void *c) { free(c); }
EXPORT int fmi2SetDebugLogging(void *c, int on, size_t n, const char *const *k) { return OK; }
EXPORT int fmi2SetupExperiment(void *c, int d, double t, double start, int s, double stop) { return OK; }
EXPORT int fmi2EnterInitializationMode(void *c) { return OK; }
EXPORT int fmi2ExitInitializationMode(void *c) {
    const char *pause = getenv("FAULTY_PAUSE");
    if (pause) sleep_for(atof(pause));
    return OK;
}
EXPORT int fmi2Terminate(void *c) { return OK; }
EXPORT int fmi2Reset(void *c) {
    defaults(c);
    return OK;
}

EXPORT int fmi2DoStep(void *c, double time, double step, int no) {
    Model *model = c;
    if (model->fault && model->steps == 10) {
        int status = fail(model->fault);
        if (status != OK) return status;
    }
    model->steps++;
    model->y += (1 - model->y) * model->rate * step;
    model->sum += model->y * model->y / 3;
    return OK;
}

static double *real(Model *model, uint32_t reference) {
    return reference == 0 ? &model->rate : reference == 2 ? &model->y : reference == 3 ? &model->sum : NULL;
}
EXPORT int fmi2GetReal(void *c, const uint32_t *r, size_t n, double *v) {
    for (size_t k = 0; k < n; k++) {
        if (!real(c, r[k])) return FAILED;
        v[k] = *real(c, r[k]);
    }
    return OK;
}
EXPORT int fmi2SetReal(void *c, const uint32_t *r, size_t n, const double *v) {
    for (size_t k = 0; k < n; k++) {
        if (!real(c, r[k])) return FAILED;
        *real(c, r[k]) = v[k];
    }
    return OK;
}
EXPORT int fmi2GetInteger(void *c, const uint32_t *r, size_t n, int *v) {
    for (size_t k = 0; k < n; k++) v[k] = ((Model *)c)->fault;
    return OK;
}
EXPORT int fmi2SetInteger(void *c, const uint32_t *r, size_t n, const int *v) {
    for (size_t k = 0; k < n; k++) ((Model *)c)->fault = v[k];
    return OK;
}
EXPORT int fmi2GetBoolean(void *c, const uint32_t *r, size_t n, int *v) { return n ? FAILED : OK; }
EXPORT int fmi2SetBoolean(void *c, const uint32_t *r, size_t n, const int *v) { return n ? FAILED : OK; }
EXPORT int fmi2GetString(void *c, const uint32_t *r, size_t n, const char **v) { return n ? FAILED : OK; }
EXPORT int fmi2SetString(void *c, const uint32_t *r, size_t n, const char *const *v) { return n ? FAILED : OK; }
EXPORT int fmi2CancelStep(void *c) { return FAILED; }
EXPORT int fmi2GetStatus(void *c, int k, int *v) { return DISCARD; }
EXPORT int fmi2GetRealStatus(void *c, int k, double *v) { return DISCARD; }
EXPORT int fmi2GetIntegerStatus(void *c, int k, int *v) { return DISCARD; }
EXPORT int fmi2GetBooleanStatus(void *c, int k, int *v) { return DISCARD; }
EXPORT int fmi2GetStringStatus(void *c, int k, const char **v) { return DISCARD; }
