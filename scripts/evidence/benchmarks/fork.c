/* Forks so many processes, one after another, that end at once. */
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

int main(int count, char **arguments) {
    for (int left = count > 1 ? atoi(arguments[1]) : 1; left > 0; left--) {
        pid_t child = fork();
        if (child < 0) return 1;
        if (child == 0) _exit(0);
        waitpid(child, 0, 0);
    }
    return 0;
}
