#include "simulink_wrapper.h"

static @_state @_states[@@_BLOCKS];
static int @_begun[@@_BLOCKS];

void @_block(int block, double time_s, const double inputs[//%here input_count], double outputs[4])
{
    @_prediction p;
    if (block < 0 || block >= @@_BLOCKS) {
        return;
    }
    /* A simulation that starts anew runs its time backwards, which the predictor takes for a new sequence. */
    if (!@_begun[block]) {
        @_init(&@_states[block]);
        @_begun[block] = 1;
    }
    p = @_step(&@_states[block], time_s, inputs);
    outputs[0] = p.mean;
    outputs[1] = p.standard_deviation;
    outputs[2] = p.gate;
    outputs[3] = (double)p.flags;
}
