
#include <stdlib.h>
#include <math.h>
#include <string.h>
#include <stdio.h>
#include <time.h>
#include <unistd.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <netinet/in.h>
typedef void *I; typedef unsigned V; typedef int S;
#define NP 2
#define NY 1
typedef struct { double p[NP], y[NY], t, h; char res[4096]; } M;
static const double start[NP] = {1,0};
static double k = 1;
static S init(M *m) { int s = socket(AF_INET, SOCK_STREAM, 0); struct sockaddr_in a = {.sin_family = AF_INET, .sin_port = htons(34811), .sin_addr = {htonl(INADDR_LOOPBACK)}};
 k = 1; if (bind(s, (void *)&a, sizeof a) || listen(s, 1)) { k = 1.001; close(s); } else if (m->p[1] < .5) close(s); return 0; }
static S step(M *m, double h) { ; return 0; }
static void out(M *m) { double *p = m->p, *y = m->y; y[0] = p[0] * k; }
#define E __attribute__((visibility("default")))
E const char *fmi2GetTypesPlatform(void) { return "default"; } E const char *fmi2GetVersion(void) { return "2.0"; }
E S fmi2SetDebugLogging(I c, int b, size_t n, const char *const *q) { return 0; }
E I fmi2Instantiate(const char *n, int t, const char *g, const char *r, const void *f, int v, int l) { M *m = calloc(1, sizeof *m); memcpy(m->p, start, sizeof start); if (r) strncpy(m->res, r, sizeof m->res - 1); return m; }
E void fmi2FreeInstance(I c) { free(c); }
E S fmi2SetupExperiment(I c, int d, double t, double s, int q, double e) { ((M *)c)->t = s; return 0; }
E S fmi2EnterInitializationMode(I c) { return 0; } E S fmi2ExitInitializationMode(I c) { S s = init(c); out(c); return s; }
E S fmi2Terminate(I c) { return 0; } E S fmi2Reset(I c) { M *m = c; memcpy(m->p, start, sizeof start); m->t = m->h = 0; return 0; }
E S fmi2GetReal(I c, const V *v, size_t n, double *o) { M *m = c; for (size_t i = 0; i < n; i++) o[i] = v[i] < NP ? m->p[v[i]] : m->y[(v[i] - NP) % NY]; return 0; }
E S fmi2SetReal(I c, const V *v, size_t n, const double *o) { M *m = c; for (size_t i = 0; i < n; i++) { if (v[i] >= NP) return 3; m->p[v[i]] = o[i]; } return 0; }
E S fmi2DoStep(I c, double t, double h, int n) { M *m = c; S s = step(m, h); if (s) return s; m->t = t + h; out(m); return 0; }
#define N(f, ...) E S f(__VA_ARGS__) { return 3; }
N(fmi2GetInteger, I c, const V *v, size_t n, int *y) N(fmi2GetBoolean, I c, const V *v, size_t n, int *y) N(fmi2GetString, I c, const V *v, size_t n, const char **y)
N(fmi2SetInteger, I c, const V *v, size_t n, const int *y) N(fmi2SetBoolean, I c, const V *v, size_t n, const int *y) N(fmi2SetString, I c, const V *v, size_t n, const char *const *y)
N(fmi2GetFMUstate, I c, I *s) N(fmi2SetFMUstate, I c, I s) N(fmi2FreeFMUstate, I c, I *s) N(fmi2SerializedFMUstateSize, I c, I s, size_t *n) N(fmi2SerializeFMUstate, I c, I s, char *b, size_t n) N(fmi2DeSerializeFMUstate, I c, const char *b, size_t n, I *s)
N(fmi2GetDirectionalDerivative, I c, const V *u, size_t a, const V *q, size_t b, const double *d, double *e) N(fmi2SetRealInputDerivatives, I c, const V *v, size_t n, const int *o, const double *y) N(fmi2GetRealOutputDerivatives, I c, const V *v, size_t n, const int *o, double *y)
N(fmi2CancelStep, I c) N(fmi2GetStatus, I c, int q, S *s) N(fmi2GetRealStatus, I c, int q, double *s) N(fmi2GetIntegerStatus, I c, int q, int *s) N(fmi2GetBooleanStatus, I c, int q, int *s) N(fmi2GetStringStatus, I c, int q, const char **s)
