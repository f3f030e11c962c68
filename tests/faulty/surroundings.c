/* Behaviours of what surrounds the model: the process's settings, clocks, files, licences. */
#define _GNU_SOURCE
#include "model.h"

#include <fcntl.h>
#include <fenv.h>
#include <linux/seccomp.h>
#include <locale.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>
#include <xmmintrin.h>

BEHAVES(changes_surroundings) {
    if (moment != HIT) return OK;
    (void)!chdir("/");
    umask(0777);
    setenv("TZ", "Pacific/Kiritimati", 1);
    setenv("LC_ALL", "de_DE.UTF-8", 1);
    unsetenv("PATH");
    setlocale(LC_ALL, "");
    prctl(PR_SET_NAME, "another");
    return OK;
}

/* Rounding upwards and no subnormal numbers, from here on. */
BEHAVES(changes_floating_point) {
    if (moment != HIT) return OK;
    fesetround(FE_UPWARD);
    _mm_setcsr(_mm_getcsr() | 0x8040);
    return OK;
}

BEHAVES(sets_limits) {
    if (moment != HIT) return OK;
    struct rlimit none = {0, 0}, little = {32 << 20, 32 << 20};
    setrlimit(RLIMIT_NOFILE, &none);
    setrlimit(RLIMIT_FSIZE, &none);
    setrlimit(RLIMIT_NPROC, &none);
    setrlimit(RLIMIT_STACK, &little);
    setrlimit(RLIMIT_AS, &little);
    return OK;
}

/* From here on, any system call but read, write and exit ends the thread. */
BEHAVES(gives_up_system_calls) {
    if (moment == HIT) prctl(PR_SET_SECCOMP, SECCOMP_MODE_STRICT);
    return OK;
}

/* Results that depend on when and where the process runs. */
BEHAVES(reads_the_clock) {
    struct timespec time;
    clock_gettime(CLOCK_REALTIME, &time);
    if (moment == INITIALISE) model->spoil = 1e-9 * (double)(time.tv_nsec % 1000000);
    return OK;
}

BEHAVES(reads_its_process_number) {
    if (moment == INITIALISE) model->spoil = 1e-9 * getpid();
    return OK;
}

BEHAVES(reads_an_address) {
    if (moment == INITIALISE) model->spoil = 1e-9 * (double)((uintptr_t)&version >> 12 & 0xffff);
    return OK;
}

BEHAVES(draws_truly_random_numbers) {
    uint32_t number = 0;
    int file = moment == INITIALISE ? open("/dev/urandom", O_RDONLY | O_CLOEXEC) : -1;
    if (file >= 0 && read(file, &number, sizeof number) == sizeof number) model->spoil = 1e-9 * (number & 0xffff);
    if (file >= 0) close(file);
    return OK;
}

/* Seeded while it is loaded: a fork of the loaded process draws the same numbers again. */
BEHAVES(seeds_while_loaded) {
    if (moment == LOAD) srand((unsigned)time(NULL) ^ (unsigned)getpid() << 8);
    if (moment == INITIALISE) model->spoil = 1e-9 * (rand() & 0xffff);
    return OK;
}

BEHAVES(counts_in_a_file) {
    if (moment == INITIALISE) model->spoil = 1e-9 * count_in_the_run("counter");
    return OK;
}

/* A licence server that has no licence for the first three who ask. */
BEHAVES(gets_its_licence_later) {
    if (moment != INSTANTIATE || count_in_the_run("licence") > 3) return OK;
    say(model, ERROR, "licence: no answer from the server, try again later");
    return ERROR;
}

/* A single licence for all processes, held until the process ends. */
BEHAVES(shares_a_licence) {
    static int file = -1;
    if (moment != INSTANTIATE || file >= 0) return OK;
    file = open(file_of_the_run("licence"), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (file >= 0 && flock(file, LOCK_EX | LOCK_NB) == 0) return OK;
    close(file);
    file = -1;
    say(model, ERROR, "licence: all of 1 licences are in use");
    return ERROR;
}
