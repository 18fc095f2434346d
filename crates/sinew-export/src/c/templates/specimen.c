
static void @_join(@_stroke *stroke, const @_stroke *part)
{
    stroke->to = part->to;
    stroke->effort += part->effort;
    stroke->moment += part->moment;
    stroke->seconds += part->seconds;
}

static double @_length(const @_stroke *stroke)
{
    return stroke->to - stroke->from;
}

static double @_slope(const @_stroke *stroke)
{
    const double length = @_length(stroke), middle = 0.5 * (stroke->from + stroke->to);
    return 12.0 * (stroke->moment - middle * stroke->effort) / (length * length * length);
}

/* Means over the last loops: level, height, slope, speed, stroke. */
enum { @@_LEVEL, @@_HEIGHT, @@_SLOPE, @@_SPEED, @@_STROKE, @@_OF_LOOP };

/* Holds the loops against those of the training logs. */
static int @_is_other(const @_state *s)
{
    const double *const loop = s->loop;
    int above = 0, undefined = 0;
//%slot loop_checks
    return above && !undefined;
}

/* The loop of two strokes. */
static void @_conclude(@_state *s, const @_stroke *before, const @_stroke *finished)
{
    const @_stroke *const up = @_length(before) > 0.0 ? before : finished;
    const @_stroke *const down = up == before ? finished : before;
    const double length = @_length(up) - @_length(down);
    const double mean_up = up->effort / @_length(up), mean_down = down->effort / @_length(down);
    double found[@@_OF_LOOP];
    int i;
    found[@@_LEVEL] = 0.5 * (mean_up + mean_down);
    found[@@_HEIGHT] = mean_up - mean_down;
    found[@@_SLOPE] = 0.5 * (@_slope(up) + @_slope(down));
    found[@@_SPEED] = length / (up->seconds + down->seconds);
    found[@@_STROKE] = 0.5 * length;
    for (i = 0; i < @@_OF_LOOP; i++) {
        if (!(@_magnitude(found[i]) <= 1e30)) {
            return;
        }
    }
    s->loops = @_smaller(s->loops + 1.0, 16.0);
    for (i = 0; i < @@_OF_LOOP; i++) {
        s->loop[i] += (found[i] - s->loop[i]) / s->loops;
    }
    s->other = @_is_other(s);
}

/* The loops of effort over motion as they arrive. */
static void @_watch(@_state *s, int first)
{
    const double motion = s->values[//%here loop_motion], effort = s->values[//%here loop_effort];
    const double q = motion - s->loop_origin, q_before = s->loop_q, effort_before = s->loop_from;
    const double change = q - q_before, mean = 0.5 * (effort + effort_before), middle = 0.5 * (q + q_before);
    @_stroke part = {0.0, 0.0, 0.0, 0.0, 0.0}, finished;
    s->loop_from = effort;
    if (first) {
        int i;
        s->loop_origin = motion;
        s->loop_q = s->loop_low = s->loop_high = s->loop_direction = s->loops = 0.0;
        s->whole = s->has_before = s->other = 0;
        s->stroke = s->since = part;
        for (i = 0; i < @@_OF_LOOP; i++) {
            s->loop[i] = 0.0;
        }
        return;
    }
    s->loop_q = q;
    part.to = q;
    part.effort = mean * change;
    part.moment = mean * middle * change;
    part.seconds = s->dt_s;
    @_join(&s->since, &part);
    part.from = q;
    part.effort = part.moment = part.seconds = 0.0;
    if (s->loop_direction == 0.0) {
        s->loop_low = @_smaller(s->loop_low, q);
        s->loop_high = @_larger(s->loop_high, q);
        s->loop_direction = q > s->loop_low + @_reversal ? 1.0 : q < s->loop_high - @_reversal ? -1.0 : 0.0;
        s->stroke = s->since = part;
        return;
    }
    if ((q - s->stroke.to) * s->loop_direction >= 0.0) {
        @_join(&s->stroke, &s->since);
        s->since = part;
        return;
    }
    if ((s->stroke.to - q) * s->loop_direction <= @_reversal) {
        return;
    }
    finished = s->stroke;
    s->stroke = s->since;
    s->since = part;
    s->loop_direction = -s->loop_direction;
    if (!s->whole) {
        s->whole = 1;
        return;
    }
    part = s->before;
    s->before = finished;
    if (s->has_before) {
        @_conclude(s, &part, &finished);
    }
    s->has_before = 1;
}
