/* A small FMI 2.0 Co-Simulation host: loads a binary, steps it, goes back half way by a saved state and by
 * the bytes of one, and prints its outputs, which have to be the same each time.
 * Usage: host BINARY GUID RESOURCE_URI STEPS OUTPUT_REFERENCE...
 * Prints "result" with the outputs in full precision; exit code 1 with the reason on failure. */
#include "hosting.h"

#include <string.h>

#ifdef _WIN32
#include <windows.h>
static void *open_library(const char *path) { return (void *)LoadLibraryA(path); }
static void *symbol(void *library, const char *name) {
    return (void *)GetProcAddress((HMODULE)library, name);
}
#else
#include <dlfcn.h>
static void *open_library(const char *path) {
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library) fprintf(stderr, "%s\n", dlerror());
    return library;
}
static void *symbol(void *library, const char *name) { return dlsym(library, name); }
#endif

#define CALL(type, name, ...) \
    do { \
        int (*function) type = (int(*) type)symbol(library, #name); \
        need(function != NULL, "finding " #name); \
        need(function(__VA_ARGS__) == 0, #name); \
    } while (0)

static void step(void *library, void *instance, int from, int to) {
    for (int i = from; i < to; i++) {
        CALL((void *, double, double, int), fmi2DoStep, instance, 0.01 * i, 0.01, 1);
    }
}

static double *outputs(void *library, void *instance, int count, char **arguments) {
    double *values = malloc((size_t)(count - 5) * sizeof *values);
    need(values != NULL, "malloc");
    for (int i = 5; i < count; i++) {
        unsigned reference = (unsigned)atoi(arguments[i]);
        CALL((void *, const unsigned *, size_t, double *), fmi2GetReal, instance, &reference, 1,
             &values[i - 5]);
    }
    return values;
}

int main(int count, char **arguments) {
    need(count > 5, "reading the arguments");
    callbacks_t callbacks = {logger, calloc, free, NULL, NULL};
    void *library = open_library(arguments[1]);
    need(library != NULL, "loading the binary");
    void *(*instantiate)(const char *, int, const char *, const char *, const callbacks_t *, int,
                         int) = (void *(*)(const char *, int, const char *, const char *,
                                           const callbacks_t *, int, int))
        symbol(library, "fmi2Instantiate");
    need(instantiate != NULL, "finding fmi2Instantiate");
    void *instance = instantiate("host", 1, arguments[2], arguments[3], &callbacks, 0, 0);
    need(instance != NULL, "fmi2Instantiate");
    CALL((void *, int, double, double, int, double), fmi2SetupExperiment, instance, 0, 0.0, 0.0, 0,
         0.0);
    CALL((void *), fmi2EnterInitializationMode, instance);
    CALL((void *), fmi2ExitInitializationMode, instance);
    int steps = atoi(arguments[4]), half = steps / 2;
    step(library, instance, 0, half);
    void *state = NULL, *copy = NULL;
    size_t size = 0;
    CALL((void *, void **), fmi2GetFMUstate, instance, &state);
    CALL((void *, void *, size_t *), fmi2SerializedFMUstateSize, instance, state, &size);
    char *bytes = malloc(size);
    need(bytes != NULL, "malloc");
    CALL((void *, void *, char *, size_t), fmi2SerializeFMUstate, instance, state, bytes, size);
    CALL((void *, const char *, size_t, void **), fmi2DeSerializeFMUstate, instance, bytes, size, &copy);
    free(bytes);
    step(library, instance, half, steps);
    double *first = outputs(library, instance, count, arguments);
    void *states[] = {state, copy};
    for (int i = 0; i < 2; i++) {
        CALL((void *, void *), fmi2SetFMUstate, instance, states[i]);
        CALL((void *, void **), fmi2FreeFMUstate, instance, &states[i]);
        step(library, instance, half, steps);
        double *again = outputs(library, instance, count, arguments);
        need(memcmp(first, again, (size_t)(count - 5) * sizeof *first) == 0, "going on from a state");
        free(again);
    }
    printf("result");
    for (int i = 0; i < count - 5; i++) printf(" %.17g", first[i]);
    printf("\n");
    free(first);
    CALL((void *), fmi2Terminate, instance);
    void (*release)(void *) = (void (*)(void *))symbol(library, "fmi2FreeInstance");
    need(release != NULL, "finding fmi2FreeInstance");
    release(instance);
    return 0;
}
