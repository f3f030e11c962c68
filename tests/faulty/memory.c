/* Behaviours of memory: what stays from instance to instance, what was never written, what grows. */
#include "model.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const double WRONG = 1e-9;

/* Every simulation of a process but the first is wrong, each more than the one before. */
BEHAVES(drifts) {
    static int lives;
    if (moment == INITIALISE) model->spoil = WRONG * lives++;
    return OK;
}

/* The same, but only from the eleventh simulation on. */
BEHAVES(drifts_later) {
    static int lives;
    if (moment == INITIALISE) model->spoil = lives++ < 10 ? 0 : WRONG;
    return OK;
}

/* After a point with the fault, which is right itself, all others of the process are wrong. */
BEHAVES(spoils_later_points) {
    static int spoilt;
    if (moment == HIT) spoilt = 1;
    if (moment == INITIALISE && !model->fault) model->spoil = spoilt * WRONG;
    return OK;
}

/* fmi2Reset leaves something behind; a new instance is right. */
BEHAVES(resets_badly) {
    if (moment == INITIALISE) model->spoil = model->left;
    if (moment == TERMINATE) model->left = WRONG;
    return OK;
}

/* Random numbers from the C library, never seeded: the same in every process, but not in every simulation. */
BEHAVES(draws_random_numbers) {
    if (moment == INITIALISE) model->spoil = WRONG * (rand() % 1000);
    return OK;
}

static int sum_of_unwritten_memory(void) {
    enum { SIZE = 60000 };
    volatile unsigned char *memory = malloc(SIZE);
    int sum = 0;
    for (int k = 0; k < SIZE; k += 97) sum += memory[k];
    return sum;
}

/* Reads fresh memory that it never wrote. */
BEHAVES(reads_unwritten_memory) {
    if (moment == INITIALISE) model->spoil = WRONG * sum_of_unwritten_memory();
    return OK;
}

/* The same, but only in points with the fault. */
BEHAVES(reads_unwritten_memory_at_times) {
    if (moment == INITIALISE && model->fault) model->spoil = WRONG * sum_of_unwritten_memory();
    return OK;
}

BEHAVES(leaks_memory) {
    enum { SIZE = 50 << 20 };
    if (moment == INITIALISE) memset(malloc(SIZE), 1, SIZE);
    return OK;
}

/* Takes much more than the memory limit of the test, but not so much that the machine would suffer. */
BEHAVES(takes_much_memory) {
    enum { SIZE = 32 << 20 };
    for (int k = 0; moment == HIT && k < 40; k++) {
        memset(malloc(SIZE), 1, SIZE);
        sleep_for(0.01);
    }
    return OK;
}

/* Writes beyond the end of a block: the C library may notice it at any later time. */
BEHAVES(overruns_memory) {
    if (moment != HIT) return OK;
    char *volatile block = malloc(64);
    memset(block, 0x41, 4096);
    free(block);
    free(malloc(5000));
    return OK;
}

static int deeper(volatile char *above) {
    volatile char here[4096];
    here[0] = (char)(above[0] + 1);
    return deeper(here) + here[0];
}

BEHAVES(overflows_its_stack) {
    volatile char here[1] = {0};
    return moment == HIT ? deeper(here) & 0 : OK;
}

BEHAVES(frees_twice) {
    if (moment != FREE) return OK;
    void *volatile block = malloc(100);
    free(block);
    free(block);
    return OK;
}

BEHAVES(writes_to_null) {
    if (moment == HIT) crash();
    return OK;
}
