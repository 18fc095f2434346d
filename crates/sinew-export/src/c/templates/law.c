//%if cell
//%include cell
//%end
//%if cable
//%include cable
//%end
//%if axis_force
//%include axis_force
//%end
//%if axis_motion
//%include axis_motion
//%end
//%if ensemble
//%include ensemble
//%end
//%if perceptron
//%include perceptron
//%end
//%if linear
//%include linear
//%end


//%slot sigma

/* The far end from the conditioned inputs: mean, variance and gate. */
static void @_estimate(@_state *s//%here dt_argument)
{
//%if previous
    int i;
//%end
//%if members
    const int began = s->memory_started;
//%end
//%if width
    double width;
//%end
    double mean, variance, gate, start;
//%if ensemble
    double correction, spread;
//%end
    if (!s->memory_started) {
        s->farthest = 0.0;
    }
    s->beyond = 0.0;
//%slot signals_code
//%if cell
    @_cell(s);
//%end
//%if axis
    @_axis(s, dt_s);
//%end
//%if width
    width = s->high - s->low;
//%end
//%slot features_code
//%if previous
    for (i = 0; i < //%here signal_count; i++) {
        s->previous[i] = s->signals[i];
    }
//%end
    s->memory_started = 1;

//%if cell
    start = s->unknown * s->unknown / 12.0;
//%else
//%if physics
    start = s->known ? 0.0 : width * width / 12.0;
//%else
    start = 0.0;
//%end
//%end
    variance = @_sigma * @_sigma + start;
//%if gate
//%else
    gate = 1.0;
//%end
    mean = s->cell;
    s->clipped = 0;
//%if linear
    mean += @_linear(s->features);
//%end
//%if ensemble
    s->clipped = @_ensemble(//%here feature_value &correction, &spread, &s->beyond);
//%if gate
    gate = @_gate_power / @_larger(@_gate_power + 8.0 * spread, DBL_MIN);
//%end
    mean += gate * correction;
    variance += spread;
//%end
//%if perceptron
    mean += @_perceptron(s->features);
//%end
//%if constant
    mean += 0.0;
//%end
    s->farthest = s->beyond > s->farthest ? s->beyond : s->farthest;
    s->beyond = s->farthest;
//%if physics
    s->determined = s->known;
//%else
    s->determined = 1;
//%end
    s->mean = mean;
    s->variance = variance;
    s->gate = gate;
//%slot members_code
}

