/* Behaviours while the binary is loaded and while its process ends. */
#define _GNU_SOURCE
#include "model.h"

#include <fcntl.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

BEHAVES(loops_while_loaded) {
    if (moment == LOAD) hang();
    return OK;
}

BEHAVES(crashes_while_loaded) {
    if (moment == LOAD) crash();
    return OK;
}

BEHAVES(exits_while_loaded) {
    if (moment == LOAD) exit(0);
    return OK;
}

BEHAVES(talks_while_loaded) {
    if (moment == LOAD) printf("Welcome to the faulty solver\n"), fflush(stdout);
    return OK;
}

static volatile int ticks;

static void *tick(void *nothing) {
    for (;;) {
        ticks = ticks + 1;
        usleep(100);
    }
    return nothing;
}

/* A thread is started while the binary is loaded; a fork of the loaded process has none. */
BEHAVES(needs_the_thread_of_its_loading) {
    pthread_t thread;
    if (moment == LOAD && pthread_create(&thread, NULL, tick, NULL) == 0) pthread_detach(thread);
    if (moment == INITIALISE)
        for (int before = ticks; ticks == before;) usleep(100);
    return OK;
}

/* Opens a file while the binary is loaded; forks of the loaded process share its read position. */
BEHAVES(reads_the_file_of_its_loading) {
    static int file;
    int number = 0;
    if (moment == LOAD) {
        FILE *numbers = tmpfile();
        for (int k = 0; numbers && k < 1000; k++) fwrite(&k, sizeof k, 1, numbers);
        if (!numbers || fflush(numbers) != 0) return ERROR;
        file = fileno(numbers);
        lseek(file, 0, SEEK_SET);
    }
    if (moment == INITIALISE && read(file, &number, sizeof number) == sizeof number) model->spoil = 1e-9 * number;
    return OK;
}

/* A licence or a device that belongs to the process that loaded the binary. */
BEHAVES(knows_the_process_of_its_loading) {
    static pid_t process;
    if (moment == LOAD) process = getpid();
    if (moment != INSTANTIATE || process == getpid()) return OK;
    say(model, ERROR, "this is another process");
    return ERROR;
}

static void crash_at_exit(void) { crash(); }

BEHAVES(crashes_at_exit) {
    if (moment == INSTANTIATE) atexit(crash_at_exit);
    return OK;
}

BEHAVES(crashes_when_unloaded) {
    if (moment == UNLOAD) crash();
    return OK;
}

BEHAVES(loops_when_unloaded) {
    if (moment == UNLOAD) hang();
    return OK;
}

static void crash_with(void *nothing) {
    (void)nothing;
    crash();
}

/* A destructor of the thread that ran the model. */
BEHAVES(crashes_with_its_thread) {
    static pthread_key_t key;
    if (moment != INSTANTIATE) return OK;
    if (key == 0) pthread_key_create(&key, crash_with);
    pthread_setspecific(key, model);
    return OK;
}

/* Where the binary wants a function or a library that there is not. */
int function_of_a_library(void);

BEHAVES(calls_a_missing_function) {
#ifdef MISSING
    if (moment == HIT) return function_of_a_library();
#endif
    return OK;
}
