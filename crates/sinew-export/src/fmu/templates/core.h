/* What every version of the interface holds of one instance. */
#ifndef @@_CORE_H
#define @@_CORE_H

#include "@.h"

#include <stdlib.h>
#include <string.h>

#define @@_REALS (@@_INPUTS + 4)
#define @@_BOOLEANS 4

/* Value references: time is 0, then the inputs, then these. */
enum { @@_PREDICTION = @@_INPUTS + 1, @@_DEVIATION, @@_GATE, @@_FIRST_FLAG };

/* Everything that a copy of the state has to hold: no pointers. */
typedef struct {
    unsigned checksum, size;
    double time_s;
    double inputs[@@_INPUTS];
    @_state state;
    @_prediction prediction;
    int phase;
} @_data;

enum { @@_INSTANTIATED = 1, @@_INITIALIZING, @@_STEPPING, @@_TERMINATED };

static void @_start(@_data *d)
{
    static const double start[@@_INPUTS] = {//%here starts};
    int i;
    memset(d, 0, sizeof *d);
    d->checksum = @@_CHECKSUM;
    d->size = (unsigned)sizeof *d;
    d->phase = @@_INSTANTIATED;
    for (i = 0; i < @@_INPUTS; i++) {
        d->inputs[i] = start[i];
    }
    @_init(&d->state);
}

/* Takes the sample at a time. */
static void @_sample(@_data *d, double time_s)
{
    d->time_s = time_s;
    d->prediction = @_step(&d->state, time_s, d->inputs);
}

/* The number behind a value reference; returns whether there is one. */
static int @_get(const @_data *d, unsigned reference, double *value)
{
    switch (reference) {
    case 0:
        *value = d->time_s;
        return 1;
    case @@_PREDICTION:
        *value = d->prediction.mean;
        return 1;
    case @@_DEVIATION:
        *value = d->prediction.standard_deviation;
        return 1;
    case @@_GATE:
        *value = d->prediction.gate;
        return 1;
    default:
        if (reference > @@_INPUTS) {
            return 0;
        }
        *value = d->inputs[reference - 1u];
        return 1;
    }
}

/* Sets an input; returns whether the reference is one. */
static int @_set(@_data *d, unsigned reference, double value)
{
    if (reference < 1u || reference > @@_INPUTS) {
        return 0;
    }
    d->inputs[reference - 1u] = value;
    return 1;
}

/* A flag; returns whether the reference is one. */
static int @_flag(const @_data *d, unsigned reference, int *value)
{
    if (reference < @@_FIRST_FLAG || reference >= @@_FIRST_FLAG + @@_BOOLEANS) {
        return 0;
    }
    *value = (d->prediction.flags & (1u << (reference - @@_FIRST_FLAG))) != 0u;
    return 1;
}

static int @_is_number(double x)
{
    return x - x == 0.0;
}

/* Whether a step from a time over an interval continues the last one. */
static int @_continues(const @_data *d, double time_s, double step_s)
{
    const double off = time_s - d->time_s, size = time_s < 0.0 ? -time_s : time_s;
    const double tolerance = 1e-9 * (1.0 + size);
    return @_is_number(time_s) && @_is_number(step_s) && step_s > 0.0 && off <= tolerance
           && -off <= tolerance;
}

/* A copy of a state, in room that is made where there is none; returns whether there is memory. */
static int @_copy(const @_data *d, void **to)
{
    if (*to == NULL) {
        *to = malloc(sizeof *d);
    }
    if (*to == NULL) {
        return 0;
    }
    memcpy(*to, d, sizeof *d);
    return 1;
}

/* Bytes of a state that this model has written. */
static int @_restore(@_data *d, const void *bytes, size_t size)
{
    @_data read;
    if (bytes == NULL || size != sizeof read) {
        return 0;
    }
    memcpy(&read, bytes, sizeof read);
    if (read.checksum != @@_CHECKSUM || read.size != sizeof read || read.phase < @@_INSTANTIATED
        || read.phase > @@_TERMINATED) {
        return 0;
    }
    *d = read;
    return 1;
}

#endif
