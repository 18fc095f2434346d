/* Predictor of one transmission as C99: the far end from the near side, sample by sample.
//%slot about
 *
 * Every number equals that of `sinew predict` in every bit, with any compiler that keeps IEEE 754: no
 * -ffast-math, no x87. State stands in a structure of the caller: any number of instances side by side.
 * Nothing is allocated, no function of a library is called but sqrt, and the work of a step is bounded.
 */
#ifndef @@_H
#define @@_H

#ifdef __cplusplus
extern "C" {
#endif

/* Inputs of a sample, in this order and in these units:
//%slot inputs
 */
#define @@_INPUTS //%here input_count

/* Checksum of the model file, as a number. */
#define @@_CHECKSUM //%here checksum

/* Conditions under which a prediction was made: bits of its flags. */
#define @@_STATE_UNKNOWN 1u /* the state in the dead band depends on its start */
#define @@_OUT_OF_RANGE 2u  /* an input is outside the range of the training logs */
#define @@_INPUT_HELD 4u    /* an input was missing or jumped: its last value stood in */
#define @@_RESET 8u         /* all states started here: first sample, gap, time that runs backwards */
#define @@_OTHER_SPECIMEN 16u /* the loops of this sequence are not those of the training logs' specimen */
#define @@_REPEATED 32u     /* the same time stamp as before: the prediction is repeated */

typedef struct {
    double mean;               /* the far end: //%here far */
    double standard_deviation; /* mean +- 1.96 of it is the calibrated 95 % band */
    double gate;               /* weight of the learned correction, 0 to 1 */
    unsigned flags;
} @_prediction;

//%slot member_states
//%if specimen
/* A stroke of the motion, or a part of one: its ends, integrals of the effort and its first moment, duration. */
typedef struct {
    double from, to, effort, moment, seconds;
} @_stroke;

//%end
/* State of one sequence of samples. Its members are no interface. Set it with @_init. */
typedef struct {
//%include state
//%if specimen
    @_stroke stroke, since, before;
    double loop_q, loop_from, loop_origin, loop_direction, loop_low, loop_high, loops, loop[5];
    int whole, has_before, other;
//%end
    unsigned held[@@_INPUTS];
    double time_s, dt_s;
    int started, any_held;
    @_prediction last;
} @_state;

/* Before the first sample. */
void @_init(@_state *state);

/* The next sample starts a new sequence, as after a pause or another trial. */
void @_reset(@_state *state);

/* Predicts the far end at one sample: time, s, of any origin; one value per input, NaN for a missing one. */
@_prediction @_step(@_state *state, double time_s, const double inputs[@@_INPUTS]);

//%if inverse

/* Conditions under which a command was made: bits of its flags. */
#define @@_COMMAND_NOT_ATTAINABLE 1u       /* with this command the far end is not the desired one */
#define @@_COMMAND_RATE_LIMITED 2u         /* it moves as fast as it may: later it may be attained */
#define @@_COMMAND_OUT_OF_RANGE 4u         /* beyond the range of the training logs */
#define @@_COMMAND_CORRECTION_WITHDRAWN 8u /* the networks disagree: less than half of them counts */
#define @@_COMMAND_STATE_UNKNOWN 16u       /* the state in the dead band depends on its start */
#define @@_COMMAND_INPUT_HELD 32u          /* an input or the desired far end was missing: its last value */
#define @@_COMMAND_RESET 64u               /* all states started here */
#define @@_COMMAND_REPEATED 128u           /* the same time stamp as before: the command is repeated */

typedef struct {
    double value;              /* the near side: //%here near_column */
    double low, high;          /* the commands at the ends of the 95 % band of the far end */
    double mean;               /* the far end at this command */
    double standard_deviation; /* of that */
    double gate;               /* weight of the learned correction, 0 to 1 */
    unsigned evaluations;      /* of the model, at most //%here max_evaluations */
    unsigned flags;
} @_command;

/* State of a compensator. Its members are no interface. Set it with @_compensator_init. */
typedef struct {
    @_state model, trial;
    double given[@@_INPUTS], row[@@_INPUTS];
    double desired;
    int has_desired;
//%if cable
    double stretch_direction[//%here cells - 1];
    double stretch_against[//%here cells - 1];
    double stretch_velocity, stretch_correction, stretch_time_s, stretch_anchor, stretch_tension, coming;
    int stretch_started, stretch_arrived;
//%end
    @_command last;
} @_compensator;

/* Before the first sample. */
void @_compensator_init(@_compensator *compensator);

/* The next sample starts a new sequence. */
void @_compensator_reset(@_compensator *compensator);

//%if cable
/* The direction in which the cable will slide at its far end by the time its drive has crossed the dead band,
 * where the motion is known: positive toward the motor, negative away from it; 0, as at first: the motion
 * shows it. */
void @_compensator_expect_sliding(@_compensator *compensator, double direction);

//%end
/* Moves the state by a sample as it was measured; what the model says of the far end. */
@_prediction @_compensator_observe(@_compensator *compensator, double time_s,
                                   const double inputs[@@_INPUTS]);

/* The command for the time at which the drive can follow it, and a desired far end. The other inputs are
 * those that are expected then; the near one is not read. The state stays. */
@_command @_compensator_command(@_compensator *compensator, double time_s, const double inputs[@@_INPUTS],
                                double desired);

/* The command, and the state moved by the near side as it was measured, or by the command where that is
 * NaN. */
@_command @_compensator_step(@_compensator *compensator, double time_s, const double inputs[@@_INPUTS],
                             double desired);
//%end

#ifdef __cplusplus
}
#endif

#endif
