/* Under qemu, a program that starts itself again (/proc/self/exe) starts qemu without a program instead. With this library
 * loaded first (LD_PRELOAD) it starts qemu with itself. QEMU_AGAIN names qemu, QEMU_ROOT the folder of the C library. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <limits.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { MOST = 100 };
typedef int spawn(pid_t *, const char *, const posix_spawn_file_actions_t *, const posix_spawnattr_t *, char *const[], char *const[]);

int posix_spawnp(pid_t *pid, const char *file, const posix_spawn_file_actions_t *actions, const posix_spawnattr_t *attributes,
                 char *const arguments[], char *const environment[]) {
    spawn *next = (spawn *)dlsym(RTLD_NEXT, "posix_spawnp");
    const char *qemu = getenv("QEMU_AGAIN"), *root = getenv("QEMU_ROOT");
    if (strcmp(file, "/proc/self/exe") != 0 || qemu == NULL || root == NULL)
        return next(pid, file, actions, attributes, arguments, environment);
    char own[PATH_MAX];
    ssize_t length = readlink(file, own, sizeof own - 1);
    if (length < 0)
        return errno;
    own[length] = '\0';
    const char *all[MOST] = {qemu, "-L", root, "-0", arguments[0], own};
    for (int k = 1, n = 6; arguments[k] != NULL; k++, n++) {
        if (n == MOST - 1)
            return E2BIG;
        all[n] = arguments[k];
    }
    return next(pid, qemu, actions, attributes, (char *const *)all, environment);
}
