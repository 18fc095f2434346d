
/* The motion of an axis, from the force that drives it. */
//%slot axis_tables

static void @_axis(@_state *s, double dt_s)
{
    const double force = s->signals[//%here force_signal];
    if (!s->memory_started) {
//%if spring
        const double rest = (@_gain * force - @_axis_bias) / @_stiffness;
        s->axis_position = @_smaller(@_larger(rest, -1e30), 1e30);
//%else
        s->axis_position = 0.0;
//%end
        s->axis_velocity = 0.0;
        s->axis_elapsed_s = 0.0;
    } else {
        const double half = 0.5 * dt_s;
        const double driven =
            0.5 * @_gain * (s->axis_force + force) - @_axis_bias - @_stiffness * s->axis_position;
        const double free = s->axis_velocity + half * driven;
        const double excess = @_magnitude(free) - half * @_dry_friction;
        if (excess > 0.0) {
            const double mean =
                @_with_sign_of(excess, free) / (1.0 + half * (@_damping + half * @_stiffness));
            s->axis_velocity = 2.0 * mean - s->axis_velocity;
            s->axis_position += dt_s * mean;
        } else {
            s->axis_velocity = 0.0;
        }
        s->axis_elapsed_s += dt_s;
    }
    s->axis_force = force;
    s->cell = //%here axis_far + @_axis_offset;
    s->known = s->axis_elapsed_s * @_axis_rate >= 4.0;
    s->low = s->cell - 0.0;
    s->high = s->cell + 0.0;
}
