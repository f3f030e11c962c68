/* Behaviours of files that later points find changed: in the FMU's own folder, and in the working directory. */
#define _GNU_SOURCE
#include "model.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <fcntl.h>
#include <unistd.h>

/* The path of a file of the unpacked FMU, given from its resources. */
static const char *own(const Model *model, const char *name) {
    static char path[8192];
    snprintf(path, sizeof path, "%s/%s", model->folder, name);
    return path;
}

/* Adds a line to a file. */
static void add_to(const char *path) {
    FILE *file = fopen(path, "a");
    if (!file) return;
    fputs("7\n", file);
    fclose(file);
}

/* The number at the beginning of a file; 0 where there is none. */
static int number_in(const char *path) {
    int number = 0;
    FILE *file = fopen(path, "r");
    if (!file) return 0;
    if (fscanf(file, "%d", &number) != 1) number = 0;
    fclose(file);
    return number;
}

BEHAVES(leaves_a_file_in_its_resources) {
    if (moment == HIT) add_to(own(model, "state.txt"));
    if (moment == INITIALISE) model->spoil = number_in(own(model, "state.txt"));
    return OK;
}

BEHAVES(leaves_a_file_at_its_end) {
    if (moment == FREE && model->fault) add_to(own(model, "state.txt"));
    if (moment == INITIALISE) model->spoil = number_in(own(model, "state.txt"));
    return OK;
}

/* What it writes there it never reads. */
BEHAVES(keeps_a_log_in_its_resources) {
    if (moment == INITIALISE) add_to(own(model, "log.txt"));
    return OK;
}

/* Writes to memory that is a file: no call of write. */
BEHAVES(maps_a_file_of_its_resources) {
    if (moment == INITIALISE) model->spoil = number_in(own(model, "number.txt"));
    if (moment != HIT) return OK;
    int file = open(own(model, "number.txt"), O_RDWR | O_CLOEXEC);
    char *text = mmap(NULL, 1, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    close(file);
    if (text == MAP_FAILED) return ERROR;
    *text = '7';
    munmap(text, 1);
    return OK;
}

BEHAVES(removes_a_file_of_its_resources) {
    if (moment == INITIALISE && access(own(model, "number.txt"), R_OK)) return ERROR;
    if (moment == HIT) unlink(own(model, "number.txt"));
    return OK;
}

BEHAVES(replaces_a_file_of_its_resources) {
    static char before[8192];
    if (moment == INITIALISE) model->spoil = number_in(own(model, "number.txt"));
    if (moment != HIT) return OK;
    add_to(own(model, "new.txt"));
    strcpy(before, own(model, "new.txt"));
    rename(before, own(model, "number.txt"));
    return OK;
}

BEHAVES(removes_its_own_folder) {
    if (moment != HIT) return OK;
    char command[8192];
    snprintf(command, sizeof command, "cd '%s/..' && rm -rf binaries resources modelDescription.xml", model->folder);
    return system(command) ? ERROR : OK;
}

BEHAVES(cuts_its_own_binary) {
    if (moment == HIT && truncate(own(model, "../binaries/linux64/faulty.so"), 0)) return ERROR;
    return OK;
}

/* Opens for writing what it only reads, as Fortran does. */
BEHAVES(opens_its_resources_for_writing) {
    if (moment != INITIALISE) return OK;
    FILE *file = fopen(own(model, "number.txt"), "r+");
    int number = 1;
    if (!file || fscanf(file, "%d", &number) != 1) return ERROR;
    fclose(file);
    model->spoil = number;
    return OK;
}

BEHAVES(leaves_a_file_in_its_working_directory) {
    if (moment == HIT) add_to("state.txt");
    if (moment == INITIALISE) model->spoil = number_in("state.txt");
    return OK;
}

/* Closing a tool takes a while, and only then its file is written. */
BEHAVES(takes_its_time_to_end) {
    if (moment != FREE || !model->fault) return OK;
    sleep_for(1.5);
    count_in_the_run("ended");
    return OK;
}
