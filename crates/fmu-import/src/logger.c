/* The FMI 2.0 logger callback is C-variadic, which stable Rust cannot define.
   This shim formats the message and hands it to a Rust function of fixed arity. Any argument may be NULL, and the
   environment is only passed on. */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

void fmu_import_log(void *environment, int status, const char *category, const char *message);

void fmu_import_logger(void *environment, const char *instance, int status, const char *category,
                         const char *format, ...) {
    char text[2048];
    (void)instance;
    if (!format) {
        return;
    }
    /* Without a conversion there is nothing to read from the arguments. */
    if (!strchr(format, '%')) {
        fmu_import_log(environment, status, category, format);
        return;
    }
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    fmu_import_log(environment, status, category, length > 0 ? text : "");
}
