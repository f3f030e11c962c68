/* Behaviours of signals. */
#define _GNU_SOURCE
#include "model.h"

#include <signal.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/time.h>
#include <unistd.h>

BEHAVES(blocks_signals) {
    if (moment != HIT) return OK;
    sigset_t all;
    sigfillset(&all);
    sigprocmask(SIG_BLOCK, &all, NULL);
    sleep_for(FOR_EVER);
    return OK;
}

BEHAVES(stops_itself) {
    if (moment == HIT) kill(getpid(), SIGSTOP);
    return OK;
}

static void come_back(int number) { (void)number; }

/* The handler returns to the instruction that crashed, for ever. */
BEHAVES(handles_its_crash) {
    if (moment != HIT) return OK;
    signal(SIGSEGV, come_back);
    crash();
    return OK;
}

BEHAVES(ignores_signals) {
    static const int numbers[] = {SIGTERM, SIGINT, SIGHUP, SIGCHLD, SIGPIPE, SIGALRM, SIGQUIT};
    for (int k = 0; moment == HIT && k < 7; k++) signal(numbers[k], SIG_IGN);
    return OK;
}

/* The signal may come after the point. */
BEHAVES(sets_an_alarm) {
    struct itimerval soon = {.it_value = {.tv_usec = 10000}};
    if (moment == HIT) setitimer(ITIMER_REAL, &soon, NULL);
    return OK;
}

BEHAVES(divides_by_zero) {
    volatile int one = 1, zero = 0;
    return moment == HIT ? one / zero : OK;
}

/* Takes back the setting by which the kernel ends a worker together with its supervisor. */
BEHAVES(refuses_to_die_with_its_parent) {
    if (moment != HIT) return OK;
    prctl(PR_SET_PDEATHSIG, 0);
    hang();
    return OK;
}
