/* Relation of a sample to the one before. */
enum { @@_FIRST, @@_NEXT, @@_SAME };

/* Plausible change, range and start of every input. */
//%slot limits
//%if specimen
//%slot reversal
//%end

/* Replaces spikes and missing values by the last accepted value; finds gaps and repeated samples. */
static int @_condition(@_state *s, double time_s, const double *inputs)
{
    const int timed = time_s - time_s == 0.0;
    const double dt_s = timed ? time_s - s->time_s : s->dt_s;
    int first, i;
    if (s->started && dt_s == 0.0) {
        return @@_SAME;
    }
    first = !s->started || dt_s < 0.0 || dt_s > @_gap_s;
    s->any_held = 0;
    for (i = 0; i < @@_INPUTS; i++) {
        const double value = inputs[i];
        const int spike =
            !first && @_magnitude(value - s->values[i]) > @_jump[i] && s->held[i] < 2u;
        if (@_magnitude(value) <= 1e30 && !spike) {
            s->values[i] = value;
            s->held[i] = 0;
        } else {
            if (!s->started) {
                s->values[i] = @_typical[i];
            }
            s->held[i] += spike ? 1u : 0u;
            s->any_held = 1;
        }
    }
    s->dt_s = first ? 0.0 : dt_s;
    s->time_s = timed ? time_s : s->time_s + s->dt_s;
    s->started = 1;
    return first ? @@_FIRST : @@_NEXT;
}

//%if specimen
//%include specimen

//%end
void @_init(@_state *state)
{
    static const @_state zero;
//%if weakening
    int i;
//%end
    *state = zero;
//%if weakening
    for (i = 0; i < @@_CELLS - 1; i++) {
        state->half_angle[i] = @_friction[i] + @_loss[i];
        state->tanh_half[i] = @_tanh(state->half_angle[i]);
    }
//%end
//%if drag_changes
    state->adapted = 1.0;
    state->drag_factor = 1.0;
//%end
}

void @_reset(@_state *state)
{
    int i;
    for (i = 0; i < @@_INPUTS; i++) {
        state->held[i] = 0;
    }
    state->time_s = 0.0;
    state->dt_s = 0.0;
    state->started = 0;
    state->memory_started = 0;
}

//%if expecting
/* The next sample; where `expected` is given, the near tension is what the model expects, and is put
 * there. */
static @_prediction @_advance(@_state *s, double time_s, const double *inputs, double *expected)
{
//%else
@_prediction @_step(@_state *state, double time_s, const double inputs[@@_INPUTS])
{
    @_state *const s = state;
//%end
    const int kind = @_condition(s, time_s, inputs);
//%if dt
    const double dt_s = s->dt_s;
//%end
    int outside = 0, i;
//%if expecting
    double tension = 0.0;
//%end
    if (kind == @@_SAME) {
        s->last.flags = (s->last.flags & ~@@_RESET) | @@_REPEATED;
        return s->last;
    }
    if (kind == @@_FIRST) {
        s->memory_started = 0;
    }
//%if cable
//%if expecting
    @_observe(s, dt_s, expected ? NAN : @_tension_scale * s->values[//%here tension_input]);
    if (expected) {
        tension = s->values[//%here tension_input];
        *expected = s->tension_in / @_tension_scale;
        s->values[//%here tension_input] = *expected;
    }
//%else
    @_observe(s, dt_s, @_tension_scale * s->values[//%here tension_input]);
//%end
//%end
    @_estimate(s//%here estimate_dt);
//%if expecting
    if (expected) {
        s->values[//%here tension_input] = tension;
    }
//%end
//%if specimen
    @_watch(s, kind == @@_FIRST);
//%end
    for (i = 0; i < @@_INPUTS; i++) {
        outside |= s->values[i] < @_lowest[i] || s->values[i] > @_highest[i];
    }
    outside |= s->clipped > 0;
    s->last.mean = s->mean;
    s->last.standard_deviation = //%here band * sqrt(s->variance) / 1.96;
    s->last.gate = s->gate;
    s->last.flags = //%here unknown (outside ? @@_OUT_OF_RANGE : 0u)
//%if specimen
                    | (s->other ? @@_OTHER_SPECIMEN : 0u)
//%end
                    | (s->any_held ? @@_INPUT_HELD : 0u) | (kind == @@_FIRST ? @@_RESET : 0u);
    return s->last;
}
//%if expecting

@_prediction @_step(@_state *state, double time_s, const double inputs[@@_INPUTS])
{
    return @_advance(state, time_s, inputs, 0);
}
//%end
//%if inverse
//%include inverse
//%end
