/* What every version of the interface holds of one instance. */
#ifndef @@_CORE_H
#define @@_CORE_H

//%if plant
#define _POSIX_C_SOURCE 200809L
#include <errno.h>
#include <fcntl.h>
#include <stdint.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>
//%else
#include "@.h"
//%end
//%if inverse
#include <math.h>
//%end
#include <stdlib.h>
#include <string.h>

/* Numbers that go in. */
#define @@_PORTS //%here inputs

/* Value references: time is 0, then the inputs, then the numbers and flags that come out. */
enum { @@_FIRST_NUMBER = @@_PORTS + 1, @@_FIRST_FLAG = @@_FIRST_NUMBER + //%here numbers };
#define @@_FLAGS //%here flags

enum { @@_INSTANTIATED = 1, @@_INITIALIZING, @@_STEPPING, @@_TERMINATED };

//%if plant
//%include process
//%else
/* Everything that a copy of the state has to hold: no pointers. */
typedef struct {
    unsigned checksum, size;
    double time_s;
    double inputs[@@_PORTS];
//%if inverse
    @_compensator state;
    @_command result;
//%else
    @_state state;
    @_prediction result;
//%end
    int phase;
} @_data;

static void @_start(@_data *d)
{
    static const double start[@@_PORTS] = {//%here starts};
    int i;
    memset(d, 0, sizeof *d);
    d->checksum = @@_CHECKSUM;
    d->size = (unsigned)sizeof *d;
    d->phase = @@_INSTANTIATED;
    for (i = 0; i < @@_PORTS; i++) {
        d->inputs[i] = start[i];
    }
//%if inverse
    @_compensator_init(&d->state);
//%else
    @_init(&d->state);
//%end
}

/* Takes the sample at a time; returns whether it could. */
static int @_sample(@_data *d, double time_s, double step_s)
{
    (void)step_s;
//%if inverse
    /* What is desired stands behind the inputs of the model, and behind it the direction that is expected. */
//%if cable
    @_compensator_expect_sliding(&d->state, d->inputs[@@_INPUTS + 1]);
//%end
    d->result = @_compensator_step(&d->state, time_s, d->inputs, d->inputs[@@_INPUTS]);
//%else
    d->result = @_step(&d->state, time_s, d->inputs);
//%end
    d->time_s = time_s;
    return 1;
}

/* Takes bytes of a state that this model has written; returns whether they are such. */
static int @_read(@_data *d, const void *bytes, size_t size)
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

static int @_restore(@_data *d, const void *state)
{
    return @_read(d, state, sizeof *d);
}

static void @_forget(const @_data *d, void *state)
{
    (void)d;
    free(state);
}

static int @_size(const @_data *d, const void *state, size_t *size)
{
    (void)state;
    *size = sizeof *d;
    return 1;
}

static int @_pack(const @_data *d, const void *state, void *to, size_t room)
{
    if (room < sizeof *d) {
        return 0;
    }
    memcpy(to, state, sizeof *d);
    return 1;
}

static int @_unpack(const @_data *d, const void *bytes, size_t size, void **to)
{
    @_data read = *d;
    return @_read(&read, bytes, size) && @_copy(&read, to);
}
//%end

/* The number behind a value reference; returns whether there is one. */
static int @_get(const @_data *d, unsigned reference, double *value)
{
//%if plant
    const double *const numbers = d->said;
//%else
    const double numbers[] = {
//%if inverse
        d->result.value, d->result.low, d->result.high,
//%end
        d->result.mean, d->result.standard_deviation, d->result.gate
    };
//%end
    if (reference >= @@_FIRST_FLAG) {
        return 0;
    }
    if (reference >= @@_FIRST_NUMBER) {
        *value = numbers[reference - @@_FIRST_NUMBER];
    } else {
        *value = reference == 0u ? d->time_s : d->inputs[reference - 1u];
    }
    return 1;
}

/* Sets an input; returns whether the reference is one. */
static int @_set(@_data *d, unsigned reference, double value)
{
    if (reference < 1u || reference > @@_PORTS) {
        return 0;
    }
    d->inputs[reference - 1u] = value;
    return 1;
}

/* A flag; returns whether the reference is one. */
static int @_flag(const @_data *d, unsigned reference, int *value)
{
    if (reference < @@_FIRST_FLAG || reference >= @@_FIRST_FLAG + @@_FLAGS) {
        return 0;
    }
//%if plant
    *value = d->said[reference - @@_FIRST_NUMBER] > 0.0;
//%else
    *value = (d->result.flags & (1u << (reference - @@_FIRST_FLAG))) != 0u;
//%end
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

#endif
