/* For Simulink's C Caller: one function with plain arguments for each block.
 *
 * A C Caller block keeps no structure between its calls; the states stand here, one for each number `block`
 * below @@_BLOCKS. Add ../@.c and simulink_wrapper.c to "Source files" of the model's custom code, and
 * this header to "Include headers"; or use sfunction_@.c, which keeps its state itself.
 */
#ifndef @@_SIMULINK_H
#define @@_SIMULINK_H

#include "../@.h"

#define @@_BLOCKS 16

/* Outputs: prediction, standard deviation, gate, flags as a number. */
void @_block(int block, double time_s, const double inputs[//%here input_count], double outputs[4]);

#endif
