    double values[//%here input_count];
//%if signals
    double signals[//%here signal_count];
//%end
//%if previous
    double previous[//%here signal_count];
//%end
//%if stateful_features
    double states[//%here feature_count];
//%end
//%if features
    double features[//%here feature_count];
//%end
    int memory_started;
    double mean, variance, gate, beyond, farthest;
    int clipped, determined;
    double cell, low, high;
    int known;
//%if cell
    double branches[//%here branch_count];
    double slid, unknown;
//%end
//%if cable
    double tension[//%here cells];
    double slip[//%here cells + 1];
    double stretch, energy, tension_in, tension_out;
//%if weakening
    double speed[//%here cells - 1];
    double half_angle[//%here cells - 1];
    double tanh_half[//%here cells - 1];
//%end
    double motor, anchor, near, innovation, sliding_time, slid_for;
    int moved, converged;
//%if drag_changes
    double motor_displacement, anchor_displacement, interval, converged_time, warmth, adapted, drag_factor;
//%end
//%end
//%if axis_force
    double axis_value, axis_rate, axis_second_rate, axis_since_s, axis_position;
    double axis_samples;
//%if slips
    double axis_slips[//%here slip_count];
//%end
    int axis_known;
//%end
//%if axis_motion
    double axis_position, axis_velocity, axis_force, axis_elapsed_s;
//%end
//%slot member_fields
