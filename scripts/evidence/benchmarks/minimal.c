/* The least that a host can do: what every step of the orchestrator is compared with.
 *
 * Usage: minimal BINARY GUID RESOURCE_URI STEP STEPS RUNS [REFERENCE]
 * One instance, reset between the runs; with a reference, that real output is read after every step and its
 * mean over all of them printed, otherwise its place is taken by zero. */
#include "../../platforms/hosting.h"

#include <dlfcn.h>

typedef void *instance_t;

static void *symbol(void *library, const char *name) {
    void *found = dlsym(library, name);
    need(found != NULL, name);
    return found;
}

int main(int count, char **arguments) {
    need(count == 7 || count == 8, "reading the arguments");
    double step = atof(arguments[4]);
    long steps = atol(arguments[5]), runs = atol(arguments[6]);
    void *library = dlopen(arguments[1], RTLD_NOW | RTLD_LOCAL);
    need(library != NULL, "loading the binary");
    instance_t (*instantiate)(const char *, int, const char *, const char *, const callbacks_t *, int, int) =
        symbol(library, "fmi2Instantiate");
    int (*setup)(instance_t, int, double, double, int, double) = symbol(library, "fmi2SetupExperiment");
    int (*enter)(instance_t) = symbol(library, "fmi2EnterInitializationMode");
    int (*leave)(instance_t) = symbol(library, "fmi2ExitInitializationMode");
    int (*do_step)(instance_t, double, double, int) = symbol(library, "fmi2DoStep");
    int (*get)(instance_t, const unsigned *, size_t, double *) = symbol(library, "fmi2GetReal");
    int (*terminate)(instance_t) = symbol(library, "fmi2Terminate");
    int (*reset)(instance_t) = symbol(library, "fmi2Reset");
    void (*release)(instance_t) = symbol(library, "fmi2FreeInstance");

    callbacks_t callbacks = {logger, calloc, free, NULL, NULL};
    instance_t instance = instantiate("minimal", 1, arguments[2], arguments[3], &callbacks, 0, 0);
    need(instance != NULL, "fmi2Instantiate");
    unsigned reference = count == 8 ? (unsigned)atol(arguments[7]) : 0;
    double sum = 0.0, value = 0.0;
    for (long run = 0; run < runs; run++) {
        if (run > 0) need(reset(instance) == 0, "fmi2Reset");
        need(setup(instance, 0, 0.0, 0.0, 1, step * (double)steps) == 0, "fmi2SetupExperiment");
        need(enter(instance) == 0 && leave(instance) == 0, "initialisation");
        for (long i = 0; i < steps; i++) {
            double time = (double)i * step;
            if (do_step(instance, time, (double)(i + 1) * step - time, 1) != 0) need(0, "fmi2DoStep");
            if (count == 8) {
                if (get(instance, &reference, 1, &value) != 0) need(0, "fmi2GetReal");
                sum += value;
            }
        }
        need(terminate(instance) == 0, "fmi2Terminate");
    }
    printf("%.17g\n", sum / ((double)steps * (double)runs));
    release(instance);
    return 0;
}
