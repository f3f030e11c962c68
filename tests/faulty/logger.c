/* Behaviours of the logger callback. */
#include "model.h"

#include <pthread.h>
#include <stdlib.h>

static int steps(Moment moment) { return moment == STEP || moment == HIT; }

static void log_with(const Model *model, void *environment) {
    model->callbacks->logger(environment, "faulty", OK, "status", "from %s", "an environment of its own");
}

BEHAVES(logs_to_environment_one) {
    if (steps(moment)) log_with(model, (void *)1);
    return OK;
}

BEHAVES(logs_to_environment_two) {
    if (steps(moment)) log_with(model, (void *)2);
    return OK;
}

/* Passes its own instance instead of the importer's environment, as many FMUs do. */
BEHAVES(logs_to_itself) {
    if (steps(moment)) log_with(model, model);
    return OK;
}

BEHAVES(logs_to_null) {
    if (steps(moment)) log_with(model, NULL);
    return OK;
}

BEHAVES(logs_nothing_but_null) {
    if (steps(moment)) model->callbacks->logger(model->callbacks->environment, NULL, OK, NULL, NULL);
    return OK;
}

BEHAVES(logs_wild_statuses) {
    static const int statuses[] = {-1, 6, 77, -2147483647 - 1, 2147483647};
    for (int k = 0; steps(moment) && k < 5; k++) say(model, statuses[k], "a status of its own");
    return OK;
}

/* A text in place of a format. */
BEHAVES(logs_percent_signs) {
    const Callbacks *call = model ? model->callbacks : NULL;
    if (steps(moment)) call->logger(call->environment, "faulty", OK, "status", "100 % done, 5 %d left, %%, %");
    return OK;
}

static void *talk(void *of) {
    for (int k = 0; k < 20; k++) say(of, OK, "from another thread");
    return NULL;
}

BEHAVES(logs_from_threads) {
    if (!steps(moment)) return OK;
    pthread_t threads[2];
    for (int k = 0; k < 2; k++) pthread_create(&threads[k], NULL, talk, model);
    talk(model);
    for (int k = 0; k < 2; k++) pthread_join(threads[k], NULL);
    return OK;
}

/* Goes beyond what it is valid for, without any other fault. */
BEHAVES(passes_a_limit) {
    if (moment == HIT) say_limit(model, "the rate %.4f is beyond its limit", model->rate);
    return OK;
}

static void *tell_limits(void *of) {
    const Model *model = of;
    for (int k = 0; k < 20; k++) say_limit(model, "in a thread: step %g", k + 0.5);
    return NULL;
}

/* The same in many words, and where nobody asks: without a message, from a thread, at its end, when it is freed. */
BEHAVES(passes_limits_all_the_time) {
    if (moment == TERMINATE || moment == FREE) say_limit(model, "at its end %g", 1);
    if (!steps(moment)) return OK;
    for (int k = 0; k < 20; k++) say_limit(model, "step %g is beyond step 0", k * 5e-2 - 0.2);
    model->callbacks->logger(model->callbacks->environment, NULL, OK, "validity", NULL);
    pthread_t thread;
    pthread_create(&thread, NULL, tell_limits, model);
    pthread_join(thread, NULL);
    return OK;
}

static void *talk_on(void *of) {
    for (;;) {
        say(of, WARNING, "still here");
        sleep_for(0.0005);
    }
    return NULL;
}

/* A thread that goes on logging with what fmi2Instantiate was given when the instance is gone. */
BEHAVES(logs_after_free) {
    if (moment != INSTANTIATE) return OK;
    Model *copy = malloc(sizeof *copy);
    *copy = *model;
    pthread_t thread;
    if (pthread_create(&thread, NULL, talk_on, copy) == 0) pthread_detach(thread);
    return OK;
}
