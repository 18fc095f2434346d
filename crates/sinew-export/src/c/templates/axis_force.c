
/* The force that moves an axis, from its motion. */
//%slot axis_tables

static void @_differentiate(@_state *s, double signal, double dt_s)
{
    double n, theta, rest, alpha, beta, gamma, predicted, error;
    s->axis_since_s += dt_s;
    dt_s = s->axis_since_s;
    if (dt_s < 1e-3 * @_tau_s) {
        return;
    }
    s->axis_since_s = 0.0;
    n = s->axis_samples < 4294967295.0 ? s->axis_samples + 1.0 : s->axis_samples;
    s->axis_samples = n;
    theta = @_tau_s / (@_tau_s + dt_s);
    rest = dt_s / (@_tau_s + dt_s);
    if (n == 1.0) {
        alpha = 1.0;
        beta = 1.0;
        gamma = 0.0;
    } else if (n * rest < 3.2) {
        const double product = (n + 1.0) * (n + 2.0) * (n + 3.0);
        alpha = 3.0 * (3.0 * n * n + 3.0 * n + 2.0) / product;
        beta = 18.0 * (2.0 * n + 1.0) / product;
        gamma = 60.0 / product;
    } else {
        alpha = 1.0 - theta * theta * theta;
        beta = 1.5 * rest * rest * (1.0 + theta);
        gamma = rest * rest * rest;
    }
    predicted = s->axis_value + dt_s * (s->axis_rate + 0.5 * dt_s * s->axis_second_rate);
    error = signal - predicted;
    s->axis_value = predicted + alpha * error;
    s->axis_rate += dt_s * s->axis_second_rate + beta * error / dt_s;
    s->axis_second_rate += gamma * error / (dt_s * dt_s);
    if (!(@_magnitude(s->axis_value) < 1e60 && @_magnitude(s->axis_rate) < 1e60
          && @_magnitude(s->axis_second_rate) < 1e60)) {
        s->axis_value = signal;
        s->axis_rate = 0.0;
        s->axis_second_rate = 0.0;
        s->axis_samples = 0.0;
    }
}

static void @_axis(@_state *s, double dt_s)
{
//%slot axis_inputs
    double dry = -0.0, passed = -0.0, half_width;
//%if slips
    int i;
//%end
    if (!s->memory_started) {
        s->axis_value = followed;
        s->axis_rate = 0.0;
        s->axis_second_rate = 0.0;
        s->axis_since_s = 0.0;
        s->axis_samples = 0.0;
        s->axis_known = 0;
//%if slips
        for (i = 0; i < //%here slip_count; i++) {
            s->axis_slips[i] = 0.0;
        }
//%end
    } else {
//%if slips
        const double travel = //%here travel;
        int all_slip = 1;
//%end
        @_differentiate(s, followed, dt_s);
//%if slips
        for (i = 0; i < //%here slip_count; i++) {
            s->axis_slips[i] =
                @_saturate(s->axis_slips[i] + travel, -@_slip_distance[i], @_slip_distance[i]);
            all_slip &= @_magnitude(s->axis_slips[i]) >= @_slip_distance[i];
        }
        s->axis_known |= all_slip;
//%else
        s->axis_known = 1;
//%end
    }
    s->axis_position = //%here axis_position;
//%if slips
    for (i = 0; i < //%here slip_count; i++) {
        dry += @_slip_force[i] * s->axis_slips[i] / @_slip_distance[i];
    }
//%end
//%slot axis_passed
    s->cell = //%here axis_sum;
    half_width = s->axis_known ? 0.0 : @_dry_sum;
    s->known = s->axis_known;
    s->low = s->cell - half_width;
    s->high = s->cell + half_width;
}
