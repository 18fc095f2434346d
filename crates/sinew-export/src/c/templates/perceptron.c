
/* One network with one hidden layer of //%here node_count nodes, padded to blocks of eight. */
//%slot perceptron_tables

static double @_tanh(double x)
{
    const double magnitude = @_magnitude(x);
    const double t = 2.0 * (magnitude > 20.0 ? 20.0 : magnitude);
    const double round = 6755399441055744.0;
    const double shifted = t * 0x1.71547652b82fep+0 + round;
    const double k = shifted - round;
    const double u = 0.5 * ((t - k * 0x1.62e42feep-1) - k * 1.9082149292705877e-10);
    const double z = u * u;
    const double up = u * (945.0 + z * (105.0 + z));
    const double q = 945.0 + z * (420.0 + z * 15.0);
    double less, more;
    @_double power;
    power.number = shifted;
    power.bits = (power.bits << 52) + 0x3ff0000000000000u;
    less = power.number - 1.0;
    more = power.number + 1.0;
    return @_with_sign_of((less * q + more * up) / (more * q + less * up), x);
}

/* Its output; 0 where that is beyond all numbers. */
static double @_perceptron(const double *x)
{
    double sums[8] = {0.0}, linear = -0.0, total = -0.0, result;
    int block, i, k;
    for (block = 0; block < //%here block_count; block++) {
        double nodes[8];
        for (k = 0; k < 8; k++) {
            nodes[k] = @_hidden_bias[block][k];
        }
        for (i = 0; i < //%here feature_count; i++) {
            for (k = 0; k < 8; k++) {
                nodes[k] += @_hidden[block][i][k] * x[i];
            }
        }
        for (k = 0; k < 8; k++) {
            sums[k] += @_output[block][k] * @_tanh(nodes[k]);
        }
    }
//%if skip
    for (i = 0; i < //%here feature_count; i++) {
        linear += @_skip[i] * x[i];
    }
//%end
    for (k = 0; k < 8; k++) {
        total += sums[k];
    }
    result = @_output_bias + linear + total;
    return result - result == 0.0 ? result : 0.0;
}
