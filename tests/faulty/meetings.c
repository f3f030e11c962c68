/* Behaviours of what lies outside of a point's process and folder: what only one process of a machine can have, and what stays.
 *
 * A point with a fault keeps what it got until it ends, or leaves it behind; any other gives it back at once, and is wrong where
 * somebody else has it. */
#define _GNU_SOURCE
#include "model.h"

#include <fcntl.h>
#include <netinet/in.h>
#include <stdio.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

static int takes(Model *model, int descriptor, int failed) {
    if (failed && !model->fault) model->spoil = 1e-3;
    if (failed || !model->fault) close(descriptor);
    return OK;
}

static unsigned hash(const char *text) {
    unsigned hash = 5381;
    while (*text) hash = 33 * hash + (unsigned char)*text++;
    return hash;
}

static int at_a_port(Model *model, int type) {
    struct sockaddr_in address = {.sin_family = AF_INET, .sin_addr = {htonl(INADDR_LOOPBACK)}};
    address.sin_port = htons((uint16_t)(20000 + hash(file_of_the_run("")) % 12000));
    int descriptor = socket(AF_INET, type | SOCK_CLOEXEC, 0);
    int failed = bind(descriptor, (struct sockaddr *)&address, sizeof address);
    return takes(model, descriptor, failed || (type == SOCK_STREAM && listen(descriptor, 1)));
}

BEHAVES(waits_at_a_port) { return moment == INITIALISE ? at_a_port(model, SOCK_STREAM) : OK; }

BEHAVES(waits_for_datagrams) { return moment == INITIALISE ? at_a_port(model, SOCK_DGRAM) : OK; }

BEHAVES(names_a_socket) {
    if (moment != INITIALISE) return OK;
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    snprintf(address.sun_path + 1, sizeof address.sun_path - 1, "faulty-%u", hash(file_of_the_run("")));
    int descriptor = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    return takes(model, descriptor, bind(descriptor, (struct sockaddr *)&address, sizeof address));
}

static int locks(Model *model, const char *path) {
    int descriptor = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    return takes(model, descriptor, flock(descriptor, LOCK_EX | LOCK_NB));
}

BEHAVES(locks_a_file_elsewhere) { return moment == INITIALISE ? locks(model, file_of_the_run("lock")) : OK; }

BEHAVES(locks_its_resources) {
    char path[5000];
    if (moment != INITIALISE) return OK;
    snprintf(path, sizeof path, "%s/number.txt", model->folder);
    return locks(model, path);
}

BEHAVES(locks_a_record_elsewhere) {
    if (moment != INITIALISE) return OK;
    struct flock all = {.l_type = F_WRLCK};
    int descriptor = open(file_of_the_run("lock"), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    return takes(model, descriptor, fcntl(descriptor, F_SETLK, &all));
}

BEHAVES(leaves_a_file_elsewhere) {
    if (moment == HIT) close(open(file_of_the_run("left"), O_WRONLY | O_CREAT | O_CLOEXEC, 0600));
    if (moment == INITIALISE && !model->fault && access(file_of_the_run("left"), F_OK) == 0) model->spoil = 1e-3;
    return OK;
}

BEHAVES(reads_its_path) {
    if (moment == INITIALISE) model->spoil = 1e-9 * (hash(model->folder) % 1000000);
    return OK;
}
