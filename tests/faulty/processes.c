/* Behaviours of processes and threads. */
#define _GNU_SOURCE
#include "model.h"

#include <fcntl.h>
#include <pthread.h>
#include <setjmp.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <unwind.h>

/* The child returns into the importer's code, as a second worker that nobody asked for. */
BEHAVES(forks_and_returns) {
    if (moment == HIT) (void)!fork();
    return OK;
}

static void idle(void) {
    sleep_for(FOR_EVER);
    _exit(0);
}

/* A child in a session of its own keeps all descriptors open. */
BEHAVES(starts_a_daemon) {
    if (moment == HIT && fork() == 0) {
        setsid();
        if (fork() == 0) idle();
        _exit(0);
    }
    return OK;
}

BEHAVES(starts_children) {
    for (int k = 0; moment == HIT && k < 10; k++)
        if (fork() == 0) idle();
    return OK;
}

static void *stay(void *of) {
    volatile int *ticks = of;
    for (;;) {
        ++*ticks;
        usleep(1000);
    }
    return NULL;
}

BEHAVES(leaves_threads_behind) {
    static int ticks[3];
    for (int k = 0; moment == INSTANTIATE && k < 3; k++) {
        pthread_t thread;
        if (pthread_create(&thread, NULL, stay, &ticks[k]) == 0) pthread_detach(thread);
    }
    return OK;
}

BEHAVES(becomes_another_program) {
    if (moment == HIT) execl("/bin/true", "true", (char *)NULL);
    return OK;
}

BEHAVES(becomes_a_sleeping_program) {
    if (moment == HIT) execl("/bin/sleep", "sleep", "600", (char *)NULL);
    return OK;
}

BEHAVES(ends_its_thread) {
    if (moment == HIT) pthread_exit(NULL);
    return OK;
}

BEHAVES(exits) {
    if (moment == HIT) exit(0);
    return OK;
}

BEHAVES(exits_at_once) {
    if (moment == HIT) _exit(0);
    return OK;
}

BEHAVES(exits_in_terminate) {
    if (moment == TERMINATE && model->fault) exit(0);
    return OK;
}

BEHAVES(aborts) {
    if (moment == HIT) {
        fprintf(stderr, "faulty: assertion `gap > 0' failed\n");
        abort();
    }
    return OK;
}

/* As a C++ exception that nobody catches in the FMU: it unwinds into the importer's frames. */
BEHAVES(throws) {
    static struct _Unwind_Exception exception;
    if (moment != HIT) return OK;
    memcpy(&exception.exception_class, "FAULTYC+", sizeof exception.exception_class);
    _Unwind_RaiseException(&exception);
    fprintf(stderr, "terminate called after throwing an instance of 'faulty'\n");
    abort();
}

/* Jumps to a place whose function has returned. */
BEHAVES(jumps_out) {
    static jmp_buf place;
    if (moment == INSTANTIATE && setjmp(place) != 0) abort();
    if (moment == HIT) longjmp(place, 1);
    return OK;
}

/* Whether a process is of the test's run: none other may be hurt. */
static int of_this_run(pid_t process) {
    const char *mark = getenv("FAULTY_FOLDER");
    static char path[64], environment[65536];
    snprintf(path, sizeof path, "/proc/%d/environ", (int)process);
    int file = open(path, O_RDONLY | O_CLOEXEC);
    if (!mark || process <= 1 || file < 0) return 0;
    ssize_t size = read(file, environment, sizeof environment);
    close(file);
    return size > 0 && memmem(environment, (size_t)size, mark, strlen(mark)) != NULL;
}

static int signal_parent(Moment moment, int number) {
    if (moment != HIT) return OK;
    return of_this_run(getppid()) && kill(getppid(), number) == 0 ? OK : ERROR;
}

BEHAVES(kills_its_parent) {
    return signal_parent(moment, SIGKILL);
}

BEHAVES(terminates_its_parent) {
    return signal_parent(moment, SIGTERM);
}

BEHAVES(interrupts_its_parent) {
    return signal_parent(moment, SIGINT);
}

BEHAVES(stops_its_parent) {
    return signal_parent(moment, SIGSTOP);
}

BEHAVES(kills_its_group) {
    if (moment != HIT) return OK;
    return of_this_run(getpgrp()) && kill(0, SIGKILL) == 0 ? OK : ERROR;
}
