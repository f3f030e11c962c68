/* FMUs that misbehave, one behaviour each, to show what becomes of the other points of a study.
 *
 * Every FMU is model.c, the lag y' = (1 - y) * rate, compiled with -DBEHAVIOUR=name. The behaviour is a function
 * of that name in one of the other files, or one to which the linker gives the name, called at the moments below.
 * A behaviour that needs a cause waits for HIT, the step in the middle of a point whose parameter `fault` is 1, so
 * that the other points are healthy. */
#ifndef MODEL_H
#define MODEL_H

#include <stddef.h>

typedef enum { LOAD, INSTANTIATE, INITIALISE, STEP, HIT, TERMINATE, RESET, FREE, UNLOAD } Moment;
enum { OK, WARNING, DISCARD, ERROR, FATAL, PENDING };

typedef void (*Logger)(void *, const char *, int, const char *, const char *, ...);
typedef struct {
    Logger logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;

typedef struct {
    const Callbacks *callbacks;
    double rate, y, sum, spoil; /* Both outputs are wrong by `spoil`. */
    int fault, steps;
    int ended;   /* The answer of fmi2GetBooleanStatus(fmi2Terminated). */
    int listens; /* Whether messages in the category `validity` are wanted: no more once the model was reset. */
    int pending; /* How often fmi2GetStatus still says fmi2Pending. */
    char folder[4096]; /* The resources of the unpacked FMU. */
    double left; /* The only thing that fmi2Reset leaves as it is. */
} Model;

/* A behaviour: what it returns is the status of the step, of fmi2Terminate or of fmi2Reset; at INSTANTIATE,
 * anything but OK refuses the instance. The model is NULL at LOAD and UNLOAD. */
#define BEHAVES(name) int name(Moment moment, Model *model)

/* The answer of fmi2GetVersion; may be changed at LOAD. */
extern const char *version;

/* Sends a message to the importer's logger. */
void say(const Model *model, int status, const char *text);
/* Says that a limit of the model's validity was passed, to whom listens; the format takes a number. */
void say_limit(const Model *model, const char *format, double number);
/* The path of a file in the folder that the environment variable FAULTY_FOLDER names. */
const char *file_of_the_run(const char *name);
/* Counts the calls of this function in all processes of the run, from 1, in a file. */
int count_in_the_run(const char *name);
/* Sleeps, whatever signals arrive. */
void sleep_for(double seconds);
/* For ever, or rather for ten minutes, so that nothing stays for ever when a test fails. */
#define FOR_EVER 600.0
/* Does not return, and leaves the processor to others. */
void hang(void);
/* Keeps the processor busy for ever. */
void loop(void);
/* Reads from an address that is none. */
void crash(void);

#endif
