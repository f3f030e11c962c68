/* Behaviours of the life cycle: FMI functions that fail, hang or crash, and what the standard allows at its edges. */
#include "model.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

BEHAVES(healthy) {
    return OK;
}

BEHAVES(crashes_in_second_terminate) {
    static int resets;
    if (moment == RESET) resets++;
    if (moment == TERMINATE && resets > 0) crash();
    return OK;
}

BEHAVES(crashes_in_second_instantiate) {
    static int instances;
    if (moment == INSTANTIATE && instances++ > 0) crash();
    return OK;
}

/* One instance at a time, which the description does not say. */
BEHAVES(allows_one_instance) {
    static int instances;
    if (moment == INSTANTIATE && instances > 0) return ERROR;
    if (moment == INSTANTIATE) instances++;
    if (moment == FREE) instances--;
    return OK;
}

/* One instance in the whole life of a process. */
BEHAVES(allows_one_instance_ever) {
    static int instances;
    return moment == INSTANTIATE && instances++ > 0 ? ERROR : OK;
}

BEHAVES(crashes_in_reset) {
    if (moment == RESET) crash();
    return OK;
}

BEHAVES(crashes_in_free) {
    if (moment == FREE) crash();
    return OK;
}

BEHAVES(loops_in_step) {
    if (moment == HIT) loop();
    return OK;
}

BEHAVES(loops_in_reset) {
    if (moment == RESET) hang();
    return OK;
}

BEHAVES(loops_in_terminate) {
    if (moment == TERMINATE && model->fault) hang();
    return OK;
}

BEHAVES(loops_in_free) {
    if (moment == FREE && model->fault) hang();
    return OK;
}

BEHAVES(fails_and_loops_in_free) {
    if (moment == FREE && model->fault) hang();
    return moment == HIT ? ERROR : OK;
}

BEHAVES(loops_in_instantiate) {
    if (moment == INSTANTIATE) hang();
    return OK;
}

BEHAVES(loops_in_second_instantiate) {
    static int instances;
    if (moment == INSTANTIATE && instances++ > 0) hang();
    return OK;
}

BEHAVES(starts_slowly) {
    if (moment == INSTANTIATE) {
        count_in_the_run("starts");
        sleep_for(1.1);
    }
    return OK;
}

BEHAVES(fails_to_terminate) {
    return moment == TERMINATE ? ERROR : OK;
}

/* A legal end: the step is discarded because the FMU wants no further ones. */
BEHAVES(ends_early) {
    if (moment == HIT) model->ended = 1;
    return model && model->ended && (moment == HIT || moment == STEP) ? DISCARD : OK;
}

BEHAVES(warns) {
    if (moment != STEP && moment != HIT) return OK;
    say(model, WARNING, "the oil is warm");
    return WARNING;
}

BEHAVES(says_version_one) {
    if (moment == LOAD) version = "1.0";
    return OK;
}

BEHAVES(discards) {
    return moment == HIT ? DISCARD : OK;
}

BEHAVES(fails) {
    if (moment != HIT) return OK;
    say(model, ERROR, "the spring broke");
    return ERROR;
}

/* A message of 10 MB, with all that may hurt a table, a terminal or a page. */
BEHAVES(fails_with_a_huge_message) {
    if (moment != HIT) return OK;
    enum { SIZE = 10 << 20 };
    static const char part[] = "=1+2,\"\r\n;\xff\xfe\x1b[31m<script>%s%n";
    char *text = malloc(SIZE + 1);
    for (int k = 0; k < SIZE; k++) text[k] = part[k % (sizeof part - 1)];
    text[SIZE] = '\0';
    say(model, ERROR, text);
    free(text);
    return ERROR;
}

BEHAVES(dies) {
    if (moment != HIT) return OK;
    say(model, FATAL, "beyond repair");
    return FATAL;
}

BEHAVES(returns_a_wild_status) {
    return moment == HIT ? 42 : OK;
}

BEHAVES(returns_a_negative_status) {
    return moment == HIT ? -7 : OK;
}

BEHAVES(is_pending) {
    if (moment != HIT) return OK;
    model->pending = 3;
    return PENDING;
}

BEHAVES(is_pending_for_ever) {
    if (moment != HIT) return OK;
    model->pending = 1 << 30;
    return PENDING;
}

BEHAVES(gives_not_a_number) {
    if (moment == HIT) model->spoil = NAN;
    return OK;
}

BEHAVES(gives_infinity) {
    if (moment == HIT) model->spoil = -INFINITY;
    return OK;
}
