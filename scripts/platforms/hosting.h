/* Shared by the C hosts of these scripts: the callbacks of FMI 2.0, a logger, and a way to give up. */
#ifndef HOSTING_H
#define HOSTING_H

#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

typedef void (*logger_t)(void *, const char *, int, const char *, const char *, ...);
typedef struct {
    logger_t logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} callbacks_t;

static void logger(void *environment, const char *instance, int status, const char *category,
                   const char *format, ...) {
    va_list list;
    (void)environment;
    fprintf(stderr, "[%s] %d %s: ", instance, status, category);
    va_start(list, format);
    vfprintf(stderr, format, list);
    va_end(list);
    fputc('\n', stderr);
}

static void need(int condition, const char *what) {
    if (condition) return;
    fprintf(stderr, "%s failed\n", what);
    exit(1);
}

#endif
