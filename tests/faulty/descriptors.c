/* Behaviours of descriptors. */
#define _GNU_SOURCE
#include "model.h"

#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { MOST = 256 };

/* Into everything but what the terminal or a log would show. */
BEHAVES(writes_stray_bytes) {
    char bytes[40];
    memset(bytes, 0x5a, sizeof bytes);
    for (int k = 3; moment == HIT && k < MOST; k++) (void)!write(k, bytes, sizeof bytes);
    return OK;
}

/* Small numbers, as the lengths of short messages. */
BEHAVES(writes_stray_lengths) {
    char bytes[40] = {8, 0, 0, 0, 0, 0, 0, 0, 1};
    for (int k = 0; moment == HIT && k < MOST; k++) (void)!write(k, bytes, sizeof bytes);
    return OK;
}

BEHAVES(closes_descriptors) {
    for (int k = 3; moment == HIT && k < MOST; k++) close(k);
    return OK;
}

BEHAVES(closes_standard_streams) {
    for (int k = 0; moment == HIT && k < 3; k++) close(k);
    return OK;
}

/* All descriptors are open, but lead elsewhere. */
BEHAVES(replaces_descriptors) {
    if (moment != HIT) return OK;
    int nothing = open("/dev/null", O_RDWR);
    for (int k = 0; k < MOST; k++)
        if (k != nothing && fcntl(k, F_GETFD) >= 0) dup2(nothing, k);
    return OK;
}

/* 100 a point; without them it cannot work. */
BEHAVES(leaks_descriptors) {
    for (int k = 0; moment == INITIALISE && k < 100; k++)
        if (open("/dev/null", O_RDONLY) < 0) {
            say(model, ERROR, "no file can be opened any more");
            return ERROR;
        }
    return OK;
}

BEHAVES(reads_standard_input) {
    char bytes[4096];
    while (moment == HIT && read(0, bytes, sizeof bytes) > 0) continue;
    return OK;
}

BEHAVES(talks_a_lot) {
    for (int k = 0; moment == HIT && k < 20000; k++) {
        printf("line %d of a flood on stdout\n", k);
        fprintf(stderr, "line %d of a flood on stderr\n", k);
        say(model, OK, "a line of a flood for the logger");
    }
    return OK;
}

/* No line ever ends. */
BEHAVES(talks_without_an_end) {
    char bytes[1 << 16];
    memset(bytes, 'a', sizeof bytes);
    for (int k = 0; moment == HIT && k < 64; k++) {
        (void)!write(1, bytes, sizeof bytes);
        (void)!write(2, bytes, sizeof bytes);
    }
    return OK;
}
