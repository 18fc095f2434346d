
/* The compensator: the near side for a desired far end, by halving what can be reached. */
//%slot inverse_tables

/* What is sought at one sample. */
typedef struct {
    double time_s, min, max, low, high, start, at_start;
    int column, rising, crosses;
    unsigned count;
//%if cable
    int expects;
//%end
} @_query;

static int @_is_finite(double x)
{
    return x - x == 0.0;
}

static int @_is_same(double a, double b)
{
    @_double x, y;
    x.number = a;
    y.number = b;
    return x.bits == y.bits;
}

/* What the model says with a value in the column; afterwards the row holds the inputs. */
static @_prediction @_respond(@_compensator *c, @_query *q, double value)
{
    int i;
    q->count++;
    c->trial = c->model;
    for (i = 0; i < @@_INPUTS; i++) {
        c->row[i] = c->given[i];
    }
    c->row[q->column] = value;
//%if cable
    if (q->expects) {
        double expected;
        const @_prediction p = @_advance(&c->trial, q->time_s, c->row, &expected);
        c->row[//%here tension_input] = expected;
        return p;
    }
//%end
    return @_step(&c->trial, q->time_s, c->row);
}

/* The first place from the start toward what is desired at which it is attained or passed. */
static double @_search(@_compensator *c, @_query *q, double desired, double tolerance, int halvings)
{
    const int more = desired > q->at_start;
    double before = q->start, beyond = more == q->rising ? q->high : q->low, value;
    int k;
    if (@_magnitude(q->at_start - desired) <= tolerance || @_is_same(beyond, before)) {
        return before;
    }
    value = @_respond(c, q, beyond).mean;
    if (@_is_same(value, q->at_start) && !q->crosses) {
        return before;
    }
    if (@_magnitude(value - desired) <= tolerance || !(more ? value >= desired : value <= desired)) {
        return beyond;
    }
    for (k = 0; k < halvings; k++) {
        const double middle = 0.5 * (before + beyond);
        if (@_is_same(middle, before) || @_is_same(middle, beyond)) {
            break;
        }
        value = @_respond(c, q, middle).mean;
        if (@_magnitude(value - desired) <= tolerance) {
            return middle;
        }
        if (more ? value >= desired : value <= desired) {
            beyond = middle;
        } else {
            before = middle;
        }
    }
    return beyond;
}

//%if moves
/* What can be reached from a reference, where the model accepts changes up to `jump`. */
static void @_reach(@_query *q, double reference, double rate, double dt_s, double jump)
{
    const double step = @_smaller(0.999 * jump, rate * dt_s);
    double below = reference - step, above = reference + step;
    if (reference - below > jump || above - reference > jump) {
        below = reference;
        above = reference;
    }
    q->low = @_smaller(@_larger(below, q->min), above);
    q->high = @_larger(@_larger(@_smaller(above, q->max), below), q->low);
    q->start = @_smaller(@_larger(reference, q->low), q->high);
}

//%end
//%if everywhere
static void @_reach_everywhere(@_query *q, double reference)
{
    q->low = q->min;
    q->high = q->max;
    q->start = @_smaller(@_larger(reference, q->low), q->high);
}

//%end
//%if cable
/* Stretch of the cable that slides steadily with a tension at the anchor, every node in its direction or, where
   that is not given, all in one. What lies between each node and the anchor is added to its motion `sign` times. */
static double @_steady(const @_compensator *c, double tension_out, double drag_factor, const double *directions,
                       double one, double *motion, double sign)
{
    double tension = @_larger(tension_out - @_pretension, 0.0);
    double stretch = @_compliance[@@_CELLS - 1] * tension, ratio = 1.0;
    int i, k;
    for (i = @@_CELLS - 2; i >= 0; i--) {
        const double direction = directions ? directions[i] : one;
        const int with = direction * c->stretch_velocity > 0.0;
        const double velocity = with ? c->stretch_velocity : direction * 1e-9;
        const double side = velocity < 0.0 ? -1.0 : 1.0, drag_speed = drag_factor * velocity;
        double half, ahead = tension * ratio;
//%if weakening
        const double of_speed = @_larger(@_magnitude(velocity), 0.02) / @_weakening_speed;
//%if gaussian
        const double weakened = 1.0 + @_rise * @_exp(-0x1.62e42fefa39efp-1 * of_speed * of_speed);
//%else
        const double weakened = 1.0 + @_rise / (1.0 + of_speed * of_speed);
//%end
        half = side * (weakened * @_friction[i] + @_loss[i]) + @_viscous[i] * velocity;
//%else
        half = side * @_half_angle[i] + @_viscous[i] * velocity;
//%end
        if (motion) {
            motion[i] += sign * stretch;
        }
        for (k = 0; k < 2; k++) {
            const double tau = @_tanh(half + @_drag[i] * drag_speed / (tension + ahead + @_fade));
            ratio = (1.0 + tau) / (1.0 - tau);
            ahead = tension * ratio;
        }
        tension = ahead;
        stretch += @_compliance[i] * tension;
    }
    return stretch;
}

/* Turns what moves against its direction as the anchor moves and the desired tension changes; returns the motion
   next to the motor. */
static double @_turn(@_compensator *c, double moved, double before, double now, double drag_factor)
{
    double motion[@@_CELLS - 1];
    /* What moves before the turn to come says nothing of what follows it. */
    const int counts = c->stretch_arrived && c->coming * moved >= 0.0;
    int i, k;
    for (i = 0; i < @@_CELLS - 1; i++) {
        motion[i] = moved;
    }
    (void)@_steady(c, now, drag_factor, c->stretch_direction, 0.0, motion, 1.0);
    (void)@_steady(c, before, drag_factor, c->stretch_direction, 0.0, motion, -1.0);
    for (i = @@_CELLS - 2; i >= 0; i--) {
        const double direction = c->stretch_direction[i];
        const int at_anchor = i == @@_CELLS - 2;
        if (at_anchor || counts) {
            c->stretch_against[i] = @_larger(c->stretch_against[i] - direction * motion[i], 0.0);
        }
        if (at_anchor && c->coming != 0.0 ? c->coming * direction < 0.0 : c->stretch_against[i] > 5e-5) {
            for (k = 0; k <= i; k++) {
                c->stretch_direction[k] = -direction;
                c->stretch_against[k] = 0.0;
            }
            c->stretch_correction = 0.0;
        }
    }
    return motion[0];
}

/* Lowest and highest position of the motor, m, for a desired far end at a time `ahead_s` after the last sample,
   where the command before has left an error. */
static void @_move_motor(@_compensator *c, double far, double anchor, double time_s, double ahead_s,
                         double left, double *low, double *high)
{
    const double drag_factor = //%here drag_factor, asked = far / @_far_gain;
    const double tension = asked < -1e6 ? -1e6 : asked > 1e6 ? 1e6 : asked;
    const double moved = c->stretch_started ? anchor - c->stretch_anchor : 0.0;
    const double dt_s = c->stretch_started ? time_s - c->stretch_time_s : 0.0;
    const double tension_before = c->stretch_started ? c->stretch_tension : tension;
    const int elapsed = dt_s > 0.0 && @_is_finite(dt_s);
    const int observed = elapsed && @_magnitude(dt_s - ahead_s) <= 1e-6 * dt_s;
    double motion, stretch, half, about, held, ahead;
    c->stretch_started = 1;
    c->stretch_time_s = time_s;
    c->stretch_anchor = anchor;
    c->stretch_tension = tension;
    if (elapsed) {
        const double speed = moved / dt_s, velocity = speed < -100.0 ? -100.0 : speed > 100.0 ? 100.0 : speed;
        c->stretch_velocity += (velocity - c->stretch_velocity) * dt_s / (dt_s + 0.01);
    }
    motion = @_turn(c, moved, tension_before, tension, drag_factor);
    stretch = @_steady(c, tension, drag_factor, c->stretch_direction, 0.0, 0, 0.0);
    half = 0.5 * @_magnitude(@_steady(c, tension, drag_factor, 0, 1.0, 0, 0.0)
                             - @_steady(c, tension, drag_factor, 0, -1.0, 0, 0.0));
    about = 0.05 * half;
    if (observed && @_magnitude(c->last.value * @_motor_scale - c->model.motor) <= about) {
        double compliance = 0.0;
        int i;
        for (i = 0; i < @@_CELLS; i++) {
            compliance += @_compliance[i];
        }
        c->stretch_correction += dt_s / 0.1 * (compliance * (left / @_far_gain));
    }
    c->stretch_correction = @_smaller(@_larger(c->stretch_correction, -half), half);
    ahead = stretch + c->stretch_correction - c->model.stretch;
    c->stretch_arrived = @_magnitude(ahead) <= 0.1 * half;
    held = c->model.motor + (anchor - c->model.anchor);
    *low = held + ahead - about;
    *high = held + ahead + about;
    /* In a slow motion the motor does not turn back for what is still on its way. */
    if (!(observed && @_magnitude(motion) * 0.1 <= about * dt_s)) {
        return;
    }
    if (c->stretch_direction[0] > 0.0) {
        *low = @_larger(*low, @_smaller(held, *high));
    } else {
        *high = @_smaller(*high, @_larger(held, *low));
    }
}

//%end
/* What is sought at a sample of a kind, `dt_s` after the one before, from the near side there. */
static void @_ask(@_compensator *c, @_query *q, int kind, double dt_s, double reference)
{
    q->column = @_near;
    q->rising = @_rising;
    q->crosses = kind == @@_NEXT;
    q->count = 0;
    q->min = @_min;
    q->max = @_max;
//%if cable
    {
        const int missing = !@_is_finite(c->given[//%here tension_input]), first = kind == @@_FIRST;
        q->expects = missing && !first;
//%if zero_stretch
        if (first) {
            @_reach(q, reference, HUGE_VAL, 1.0, @_first_change);
        } else {
//%else
        if (first && missing) {
            /* The first profile follows from the near tension, not from the motor. */
            q->column = //%here tension_input;
            q->rising = @_tension_rising;
            q->min = @_tension_min;
            q->max = @_tension_max;
            @_reach_everywhere(q, @_typical[q->column]);
        } else if (first) {
            @_reach(q, reference, HUGE_VAL, 1.0, 0.0);
        } else {
//%end
            @_reach(q, reference, @_rate, dt_s, @_smaller(@_largest_change, @_jump[@_near]));
        }
    }
//%else
    (void)c;
//%if moves
    if (kind == @@_FIRST) {
        @_reach_everywhere(q, reference);
    } else {
        @_reach(q, reference, @_rate, dt_s, @_jump[@_near]);
    }
//%else
    (void)dt_s;
    q->low = reference;
    q->high = reference;
    q->start = reference;
//%end
//%end
}

static int @_is_attained(double mean, double desired)
{
    return @_magnitude(mean - desired) <= @_attained;
}

//%if cable
static void @_stretch_reset(@_compensator *c)
{
    int i;
    for (i = 0; i < @@_CELLS - 1; i++) {
        c->stretch_direction[i] = @_stretch_initial;
        c->stretch_against[i] = 0.0;
    }
}

//%end
void @_compensator_init(@_compensator *c)
{
    static const @_compensator zero;
    *c = zero;
    @_init(&c->model);
//%if cable
    @_stretch_reset(c);
//%end
}

void @_compensator_reset(@_compensator *c)
{
    static const @_command none;
    @_reset(&c->model);
    c->has_desired = 0;
//%if cable
    @_stretch_reset(c);
    c->stretch_velocity = 0.0;
    c->stretch_correction = 0.0;
    c->stretch_started = 0;
    c->stretch_arrived = 0;
    c->coming = 0.0;
//%end
    c->last = none;
}
//%if cable

void @_compensator_expect_sliding(@_compensator *c, double direction)
{
    c->coming = direction > 0.0 ? 1.0 : direction < 0.0 ? -1.0 : 0.0;
}
//%end

@_prediction @_compensator_observe(@_compensator *c, double time_s, const double inputs[@@_INPUTS])
{
    return @_step(&c->model, time_s, inputs);
}

@_command @_compensator_command(@_compensator *c, double time_s, const double inputs[@@_INPUTS],
                                double desired)
{
    const int missing = !@_is_finite(desired);
    @_query q;
    @_prediction p;
    double reference, value, first, second, half_width, error = 0.0;
    int kind, held = 0, commands, i;
//%if cable
    double anchor, ahead_s, left = 0.0;
//%end
    for (i = 0; i < @@_INPUTS; i++) {
        c->given[i] = i == @_near ? NAN : inputs[i];
    }
    c->trial = c->model;
    kind = @_condition(&c->trial, time_s, c->given);
    if (kind == @@_SAME) {
        c->last.flags = (c->last.flags & ~@@_COMMAND_RESET) | @@_COMMAND_REPEATED;
        return c->last;
    }
    reference = c->trial.values[@_near];
//%if cable
    anchor = @_anchor_scale * c->trial.values[//%here anchor_input];
    ahead_s = c->trial.dt_s;
    if (c->has_desired && kind == @@_NEXT) {
        left = c->desired - c->model.last.mean;
        error = -left * 0.003 / (0.003 + ahead_s);
    }
//%end
    if (!missing) {
        c->desired = desired;
        c->has_desired = 1;
    }
    q.time_s = time_s;
    @_ask(c, &q, kind, c->trial.dt_s, reference);
    if (q.column != @_near) {
        c->given[@_near] = reference;
    }
    q.at_start = @_respond(c, &q, q.start).mean;
    desired = c->has_desired ? c->desired : q.at_start;
    value = @_search(c, &q, desired + error, @_tolerance, 50);
//%if cable
    if (q.crosses && c->model.moved) {
        double low, high;
        if ((c->last.flags & @@_COMMAND_RATE_LIMITED) != 0u) {
            left = 0.0;
        }
        @_move_motor(c, desired, anchor, time_s, ahead_s, left, &low, &high);
        low /= @_motor_scale;
        high /= @_motor_scale;
        value = @_motor_scale > 0.0 ? @_smaller(@_larger(value, low), high)
                                    : @_smaller(@_larger(value, high), low);
        value = @_smaller(@_larger(value, q.low), q.high);
    }
//%end
    p = @_respond(c, &q, value);
    half_width = 1.96 * p.standard_deviation;
    first = @_search(c, &q, desired - half_width, 0.02 * half_width, 12);
    second = @_search(c, &q, desired + half_width, 0.02 * half_width, 12);
    (void)@_respond(c, &q, value);
    commands = q.column == @_near;
    if (!commands) {
        value = reference;
        first = reference;
        second = reference;
    }
//%if cable
    if (q.expects) {
        for (i = 0; i < @@_INPUTS; i++) {
            held |= i != @_near && i != //%here tension_input && !@_is_finite(c->given[i]);
        }
    } else {
        held = (p.flags & @@_INPUT_HELD) != 0u;
    }
//%else
    held = (p.flags & @@_INPUT_HELD) != 0u;
//%end
    c->last.value = value;
    c->last.low = @_smaller(@_smaller(first, second), value);
    c->last.high = @_larger(@_larger(first, second), value);
    c->last.mean = p.mean;
    c->last.standard_deviation = p.standard_deviation;
    c->last.gate = p.gate;
    c->last.evaluations = q.count;
    c->last.flags = (@_is_attained(p.mean, desired) ? 0u : @@_COMMAND_NOT_ATTAINABLE)
                    | (commands && ((value >= q.high && q.high < q.max) || (value <= q.low && q.low > q.min))
                           ? @@_COMMAND_RATE_LIMITED : 0u)
                    | ((p.flags & @@_OUT_OF_RANGE) != 0u ? @@_COMMAND_OUT_OF_RANGE : 0u)
//%if gate
                    | (p.gate < 0.5 ? @@_COMMAND_CORRECTION_WITHDRAWN : 0u)
//%end
                    | ((p.flags & @@_STATE_UNKNOWN) != 0u ? @@_COMMAND_STATE_UNKNOWN : 0u)
                    | (held || missing ? @@_COMMAND_INPUT_HELD : 0u)
                    | ((p.flags & @@_RESET) != 0u ? @@_COMMAND_RESET : 0u);
    return c->last;
}

@_command @_compensator_step(@_compensator *c, double time_s, const double inputs[@@_INPUTS], double desired)
{
    const @_command command = @_compensator_command(c, time_s, inputs, desired);
    const double measured = inputs[@_near];
    @_prediction said;
    if ((command.flags & @@_COMMAND_REPEATED) != 0u) {
        return command;
    }
    if (@_is_finite(measured)) {
        c->given[@_near] = measured;
//%if cable
        if (!@_is_finite(c->given[//%here tension_input]) && (command.flags & @@_COMMAND_RESET) == 0u) {
            double expected;
            (void)@_advance(&c->model, time_s, c->given, &expected);
            return c->last;
        }
//%end
        (void)@_step(&c->model, time_s, c->given);
        return c->last;
    }
    /* What the model says of the very row that is commanded, which may reject a tension that jumps. */
    said = @_step(&c->model, time_s, c->row);
    c->last.mean = said.mean;
    c->last.standard_deviation = said.standard_deviation;
    c->last.flags &= ~@@_COMMAND_NOT_ATTAINABLE;
    if (!@_is_attained(said.mean, c->has_desired ? c->desired : said.mean)) {
        c->last.flags |= @@_COMMAND_NOT_ATTAINABLE;
    }
    return c->last;
}
