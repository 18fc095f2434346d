
/* The cable: compliance and stiffness of its cells, friction of the nodes between them. */
#define @@_CELLS //%here cells
//%slot cable_tables

/* tanh x as an odd polynomial, x clipped to +-0.5. */
static double @_tanh(double x)
{
    double z;
    x = x > -0.5 ? x : -0.5;
    x = x < 0.5 ? x : 0.5;
    z = x * x;
    return x * (1.0 + z * (-1.0 / 3.0 + z * (2.0 / 15.0 + z * (-17.0 / 315.0))));
}

/* Tension behind a sliding node over that in front of it. */
static double @_ratio(double grip)
{
    return (1.0 - grip) / (1.0 + grip);
}

/* Stretch and twice the elastic energy, from the tensions. */
static void @_measure(@_state *s)
{
    int j;
    s->stretch = 0.0;
    s->energy = 0.0;
    for (j = 0; j < @@_CELLS; j++) {
        const double t = s->tension[j], c = @_compliance[j];
        s->stretch += c * t;
        s->energy += c * t * t;
    }
}

/* Tensions from that at the drive and the mobilised fraction of friction at every node; returns the
 * stretch. */
static double @_profile(@_state *s, double tension, double fraction)
{
    double stretch = 0.0;
    int j;
    for (j = 0; j < @@_CELLS; j++) {
        s->tension[j] = tension;
        stretch += @_compliance[j] * tension;
        if (j < @@_CELLS - 1) {
            tension *= @_ratio(fraction * //%here tanh_half[j]);
        }
    }
    return stretch;
}

/* Starts the cable with the tension at the drive. */
static void @_settle(@_state *s, double tension)
{
    int i;
//%if zero_stretch
    double fraction = 0.0;
    const double stretch = @_zero_stretch + s->motor - s->anchor;
    double low = -1.0, high = 1.0;
    for (i = 0; i < 30; i++) {
        fraction = 0.5 * (low + high);
        if (@_profile(s, tension, fraction) > stretch) {
            low = fraction;
        } else {
            high = fraction;
        }
    }
//%else
    const double fraction = @_start;
//%end
    (void)@_profile(s, tension, fraction);
//%if weakening
    for (i = 0; i < @@_CELLS - 1; i++) {
        s->speed[i] = 0.0;
    }
//%end
    for (i = 0; i <= @@_CELLS; i++) {
        s->slip[i] = 0.0;
    }
    @_measure(s);
    s->tension_in = s->tension[0];
    s->tension_out = s->tension[@@_CELLS - 1] + @_pretension;
}

/* Whether every node slid in the same direction in the last step. */
static int @_slides(const @_state *s)
{
    int i;
    for (i = 2; i < @@_CELLS; i++) {
        if (!(s->slip[i] * s->slip[1] > 0.0)) {
            return 0;
        }
    }
    return s->slip[1] != 0.0;
}
//%if weakening

/* Friction from the lagged speed of every node. */
static void @_weaken(@_state *s, double interval)
{
    int i;
    for (i = 0; i < @@_CELLS - 1; i++) {
        const double ratio = s->speed[i] * @_inverse_speed;
//%if gaussian
        const double factor = 1.0 + @_rise * @_exp(-0x1.62e42fefa39efp-1 * ratio * ratio);
//%else
        const double factor = 1.0 + @_rise / (1.0 + ratio * ratio);
//%end
        s->speed[i] +=
            interval / (@_lag + interval) * (@_magnitude(s->slip[i + 1]) / interval - s->speed[i]);
        s->half_angle[i] = @_friction[i] * factor + @_loss[i];
        s->tanh_half[i] = @_tanh(s->half_angle[i]);
    }
}
//%end

/* Tensions of a cable that was slack: sliding everywhere, with the total stretch. */
static void @_retension(@_state *s, double *next, double motor, double anchor)
{
    const double direction = motor + anchor >= 0.0 ? 1.0 : -1.0;
    double ratio = 1.0, sum = 0.0, unit;
    int j;
    for (j = 0; j < @@_CELLS; j++) {
        if (j > 0) {
            ratio *= @_ratio(direction * //%here tanh_half[j - 1]);
            s->slip[j] = motor + (anchor - motor) * ((double)j / (double)@@_CELLS);
        }
        next[j] = ratio;
        sum += @_compliance[j] * ratio;
    }
    unit = s->stretch / sum;
    s->energy = 0.0;
    for (j = 0; j < @@_CELLS; j++) {
        next[j] *= unit;
        s->energy += @_compliance[j] * next[j] * next[j];
    }
}

/* Moves one end by a distance, positive to pull, while the other is held: exact for Coulomb friction. Returns
 * the tension at that end. */
static double @_sweep(//%here sweep_state double *next, double distance, int from_anchor)
{
    const double direction = distance > 0.0 ? 1.0 : -1.0;
    double ratios[@@_CELLS], ratio = 1.0, target = 0.0;
    int i, pass, sliding = 0;
    for (i = 0; i < @@_CELLS; i++) {
        if (i > 0) {
            const int node = from_anchor ? @@_CELLS - 1 - i : i - 1;
            ratio *= @_ratio(direction * //%here tanh_half[node]);
        }
        ratios[i] = ratio;
    }
    for (pass = 0; pass <= @@_CELLS; pass++) {
        double stretch = distance, weight = 0.0;
        int count = 0;
        for (i = 0; i < @@_CELLS; i++) {
            const int j = from_anchor ? @@_CELLS - 1 - i : i;
            if (sliding == 0 || direction * (target * ratios[i] - next[j]) > 0.0) {
                stretch += @_compliance[j] * next[j];
                weight += @_compliance[j] * ratios[i];
                count++;
            }
        }
        if (count == 0 || count == sliding) {
            break;
        }
        target = @_larger(stretch / weight, 0.0);
        sliding = count;
    }
    for (i = 0; i < @@_CELLS; i++) {
        const int j = from_anchor ? @@_CELLS - 1 - i : i;
        const double slid = target * ratios[i];
        if (direction * (slid - next[j]) > 0.0) {
            next[j] = slid;
        }
    }
    return next[from_anchor ? @@_CELLS - 1 : 0];
}

/* Moves both ends one after the other, the one that tightens first. */
static void @_sweep_both(@_state *s, double *next, double *near, double *far, double motor, double anchor)
{
    int j;
    for (j = 0; j < @@_CELLS; j++) {
        next[j] = s->tension[j];
    }
    for (j = 0; j < 2; j++) {
        if ((j == 0) == (motor > 0.0)) {
            *near = motor != 0.0 ? @_sweep(//%here sweep_argument next, motor, 0) : -1.0;
        } else {
            *far = anchor != 0.0 ? @_sweep(//%here sweep_argument next, -anchor, 1) : -1.0;
        }
    }
    if (motor == 0.0) {
        *near = next[0];
    }
    if (anchor == 0.0) {
        *far = next[@@_CELLS - 1];
    }
    s->energy = 0.0;
    for (j = 0; j < @@_CELLS; j++) {
        s->energy += @_compliance[j] * next[j] * next[j];
    }
    for (j = 0; j <= @@_CELLS; j++) {
        s->slip[j] = 0.0;
    }
}

/* One implicit step of the cable: a Newton step on the balance of every node. */
static void @_move(@_state *s, double interval, double motor, double anchor)
{
    double next[@@_CELLS], superdiagonal[@@_CELLS], right[@@_CELLS];
    const double before = s->stretch, old = s->energy, rate = 1.0 / interval;
    const double driven = motor + anchor >= 0.0 ? 1.0 : -1.0;
    double above_done = 0.0, right_done = 0.0, sum = 0.0, energy = 0.0;
    double x, solved, beyond, ahead, scale, near, far, dissipated;
    int i, j;
    s->stretch += motor - anchor;
    s->slip[0] = motor;
    s->slip[@@_CELLS] = anchor;
//%if weakening
    @_weaken(s, interval);
//%end
    superdiagonal[0] = 0.0;
    right[0] = 0.0;
    for (i = 0; i < @@_CELLS - 1; i++) {
        const double kl = @_stiffness[i], kr = @_stiffness[i + 1];
        const double w = s->slip[i + 1];
        const double left_tension = s->tension[i] + (s->slip[i] - w) * kl;
        const double right_tension = s->tension[i + 1] + (w - s->slip[i + 2]) * kr;
        const double both = left_tension + right_tension;
        const double sum_here = both > 0.0 ? both : 0.0;
        const double difference = left_tension - right_tension;
        const double bound = sum_here * //%here tanh_half[i];
        const double trial = difference + (kl + kr) * w;
        const double sliding = trial > bound ? 1.0 : trial < -bound ? -1.0 : 0.0;
        const double sign = bound <= 1e-12 ? driven : sliding;
        double lower = 0.0, upper = 0.0, main_entry = 1.0, rhs = -w, inverse;
        if (sign != 0.0) {
            const double resistance = (@_viscous[i] + //%here drag / (sum_here + @_fade)) * rate;
            const double tau = @_tanh(sign * //%here half_angle[i] + resistance * w);
            lower = (1.0 - tau) * kl;
            upper = (1.0 + tau) * kr;
            main_entry = lower + upper + sum_here * (1.0 - tau * tau) * resistance;
            rhs = difference - tau * both;
        }
        inverse = 1.0 / (main_entry - lower * above_done);
        right_done = (rhs + lower * right_done) * inverse;
        above_done = upper * inverse;
        superdiagonal[i + 1] = above_done;
        right[i + 1] = right_done;
    }
    x = right[@@_CELLS - 1];
    solved = s->slip[@@_CELLS - 1] + x;
    beyond = s->slip[@@_CELLS];
    ahead = s->tension[@@_CELLS - 1] + (solved - beyond) * @_stiffness[@@_CELLS - 1];
    for (j = @@_CELLS - 2; j >= 0; j--) {
        double w, behind, accepted, t;
        x = right[j] + superdiagonal[j] * x;
        w = s->slip[j] + x;
        behind = s->tension[j] + (w - solved) * @_stiffness[j];
        /* A node whose friction would do work on the cable is held. */
        accepted = (behind - ahead) * solved < -1e-10 ? 0.0 : solved;
        t = s->tension[j + 1] + (accepted - beyond) * @_stiffness[j + 1];
        t = t > 0.0 ? t : 0.0;
        sum += @_compliance[j + 1] * t;
        energy += @_compliance[j + 1] * t * t;
        next[j + 1] = t;
        s->slip[j + 1] = accepted;
        beyond = accepted;
        solved = w;
        ahead = behind;
    }
    next[0] = s->tension[0] + (s->slip[0] - beyond) * @_stiffness[0];
    next[0] = next[0] > 0.0 ? next[0] : 0.0;
    sum += @_compliance[0] * next[0];
    energy += @_compliance[0] * next[0] * next[0];
    scale = s->stretch > 0.0 && sum > 0.0 ? s->stretch / sum : 0.0;
    energy *= scale * scale;
    near = next[0] * scale;
    far = next[@@_CELLS - 1] * scale;
    dissipated = near * motor - far * anchor - 0.5 * (energy - old);
    s->energy = energy;
    if (before <= 0.0 && (s->stretch > 0.0 || dissipated < -1e-12)) {
        @_retension(s, next, motor, anchor);
        near = next[0];
        far = next[@@_CELLS - 1];
        scale = 1.0;
    } else if (dissipated < -1e-12) {
        /* The step created energy: exact sweeps in its place. */
        @_sweep_both(s, next, &near, &far, motor, anchor);
        scale = 1.0;
    }
    for (j = 0; j < @@_CELLS; j++) {
        s->tension[j] = next[j] * scale;
    }
    if (s->stretch <= 0.0) {
        for (j = 0; j <= @@_CELLS; j++) {
            s->slip[j] = 0.0;
        }
    }
    s->tension_in = near;
    s->tension_out = far + @_pretension;
}

static double @_bounded_innovation(const @_state *s)
{
    return s->innovation < -50.0 ? -50.0 : s->innovation > 50.0 ? 50.0 : s->innovation;
}

/* Moves the cable by the displacements of both ends, the motor's corrected by the last innovation. */
static void @_follow(@_state *s, double interval, double motor, double anchor)
{
    const double larger = @_larger(@_magnitude(motor), @_magnitude(anchor));
    const double parts = larger / 5e-4;
    /* Far below the limit but for a state that was not written by this program. */
    int count = parts < 1e6 ? (int)parts : 0, k;
    double n, part;
    if ((double)count < parts) {
        count++;
    }
    count = count < 1 ? 1 : count;
    n = (double)count;
    part = interval / n;
    if (part < 1e-7) {
        return;
    }
    for (k = 0; k < count; k++) {
        @_move(s, part, motor / n, anchor / n);
        if (!s->converged) {
            const int slides = @_slides(s);
            s->slid_for += slides ? part : 0.0;
            s->sliding_time = slides ? s->sliding_time + part : 0.0;
            s->converged = s->sliding_time > 0.1;
        }
    }
}
//%if warming

/* Friction warms the grease; implicit, so that pauses of any length cool it. */
static void @_warm(@_state *s, double work, double interval)
{
    const double pause = interval > 0.0 ? interval : 0.0;
    const double warmed = (s->warmth + @_warming_rate * work) / (1.0 + pause / @_warming_time);
    s->warmth = warmed < 0.0 ? 0.0 : warmed > 4.0 ? 4.0 : warmed;
}
//%end
//%if adaptation

/* Adapts the drag while the whole cable slides, by gradient descent on the innovation. */
static void @_adapt(@_state *s)
{
    if (s->converged && s->interval > 0.0) {
        if (s->converged_time < 2.0) {
            s->converged_time += s->interval;
        } else if (@_slides(s)) {
            const double speed = s->anchor_displacement / s->interval;
            const double weight = s->anchor_displacement * (speed / 0.1) * (speed / 0.1);
            const double factor = s->adapted + @_learning * @_bounded_innovation(s) * weight;
            s->adapted = factor < 0.2 ? 0.2 : factor > 5.0 ? 5.0 : factor;
        }
    }
}
//%end

/* The observer: the cable driven by both ends, corrected by the near tension; NaN corrects nothing. */
static void @_observe_once(@_state *s, double interval, double motor, double anchor, double tension)
{
    if (s->moved && interval <= 1.0) {
        double by_motor = motor - s->motor, by_anchor = anchor - s->anchor;
        /* A larger displacement is a fault of the encoder. */
        by_motor = @_magnitude(by_motor) <= 0.05 ? by_motor : 0.0;
        by_anchor = @_magnitude(by_anchor) <= 0.05 ? by_anchor : 0.0;
        s->motor = motor;
        s->anchor = anchor;
//%if drag_changes
        s->motor_displacement = by_motor;
        s->anchor_displacement = by_anchor;
        s->interval = interval;
//%end
        @_follow(s, interval, by_motor + @_correction * @_bounded_innovation(s) * interval, by_anchor);
    } else {
        const double start = tension > 1e5 ? 1e5 : tension >= 0.0 ? tension : 0.0;
        s->motor = motor;
        s->anchor = anchor;
        s->moved = 1;
        s->converged = 0;
        s->sliding_time = 0.0;
        s->slid_for = 0.0;
//%if warming
        @_warm(s, 0.0, interval);
//%end
//%if drag_changes
        s->motor_displacement = 0.0;
        s->anchor_displacement = 0.0;
        s->interval = 0.0;
        s->converged_time = 0.0;
//%end
        @_settle(s, start);
    }
    s->near = tension;
    s->innovation = tension - s->tension_in;
    s->innovation = s->innovation - s->innovation == 0.0 ? s->innovation : 0.0;
    s->cell = @_far_gain * s->tension_out;
    s->known = s->slid_for > 0.1;
    if (s->known) {
        s->low = s->cell;
        s->high = s->cell;
    } else {
        const double low = @_far_gain * (s->tension_in / @_end_ratio + @_pretension);
        const double high = @_far_gain * (s->tension_in * @_end_ratio + @_pretension);
        s->low = @_smaller(low, high);
        s->high = @_larger(high, low);
    }
//%if warming
    @_warm(s, s->tension_in * s->motor_displacement - s->tension_out * s->anchor_displacement, s->interval);
//%end
//%if adaptation
    @_adapt(s);
//%end
//%if drag_changes
    s->drag_factor = s->adapted * (1.0 / (1.0 + s->warmth));
//%end
}

/* The same in equal parts of the way to a sample that comes late, so that the correction does not overshoot. */
static void @_observe(@_state *s, double interval, double tension)
{
    const double motor = @_motor_scale * s->values[//%here motor_input];
    const double anchor = @_anchor_scale * s->values[//%here anchor_input];
    const int n = interval > 0.015 && interval <= 1.0 ? (int)ceil(interval / 0.015) : 1;
    const double part = interval / (double)n;
    double from_motor, from_anchor, from_tension;
    int k;
    if (!s->memory_started) {
        s->moved = 0;
//%if warming
        s->warmth = 0.0;
//%end
    }
    from_motor = s->moved ? s->motor : motor;
    from_anchor = s->moved ? s->anchor : anchor;
    from_tension = s->moved ? s->near : tension;
    for (k = 1; k < n; k++) {
        const double at = (double)k / (double)n;
        @_observe_once(s, part, from_motor + at * (motor - from_motor),
                       from_anchor + at * (anchor - from_anchor), from_tension + at * (tension - from_tension));
    }
    @_observe_once(s, part, motor, anchor, tension);
}
