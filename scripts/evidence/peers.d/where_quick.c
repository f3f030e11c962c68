/* Models of tests/faulty that come to grief half-way through the points whose rate is above QUICK. */
#include "model.h"

static int hit(Moment moment, const Model *model) { return moment == STEP && model->steps == 10 && model->rate > QUICK; }

BEHAVES(crashes) {
    if (hit(moment, model)) crash();
    return OK;
}

BEHAVES(loops) {
    if (hit(moment, model)) loop();
    return OK;
}
